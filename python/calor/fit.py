"""Unknown numbers of a case from measurements: least squares, weighted by the noise.

Gauss-Newton with Levenberg's and Marquardt's damping; derivatives by differences once, later by Broyden's updates, and by
differences again at the end, from which the intervals follow. Runs that do not depend on each other go side by side.
"""
from __future__ import annotations

import csv
import json
import math
import pathlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import convergence, quantities, toml
from .case import Case
from .command import CaseError, CommandError
from .result import Array, Result, split_unit
from .unknowns import line_of, read_unknown, Unknown

LONGEST_STEP = 0.5    # of an unknown in one step, of its value
DIFFERENCE = 1e-2     # of an unknown for a derivative: well above what adaptive steps and solvers leave
CONVERGED = 0.1       # change of the unknowns in the end, of their standard deviations
ALIKE = 0.9           # correlation of unknowns that can hardly be told apart
VAGUE = 0.5           # standard deviation over the value of an unknown that the data do not tell


@dataclass
class Data:
    """Measured values in SI units, times in s (inf: the end of the run)."""

    name: str
    of_probe: bool
    t: Array
    value: Array
    noise: float
    where: str  # file and line, or the case

    def computed(self, result: Result) -> Array:
        if self.of_probe:
            history = result.probes
            return np.interp(np.minimum(self.t, history["time"][-1]), history["time"], history[self.name])
        if self.name not in result.numbers:
            raise CommandError(f"{self.where}: report.json has no '{self.name}'; it has {', '.join(sorted(result.numbers))}")
        return np.full(self.value.shape, result.numbers[self.name])


def read_data(entry: Mapping[str, Any], where: str, folder: pathlib.Path, end: float, probes: Sequence[str]) -> Data:
    """One [[fit.data]]. Raises CaseError with place and cure."""
    def refuse(problem: str, cure: str, place: str = where) -> CaseError:
        return CaseError(f"{place}: {problem}: {cure}", place.split(":")[0], None, None, "fit.data")

    of_probe = "probe" in entry
    if of_probe == ("report" in entry):
        raise refuse("measurements of nothing, or of two things", "give either 'probe' or 'report'")
    name = entry["probe"] if of_probe else entry["report"]
    kind = "K" if of_probe else quantities.kind_of_number(name)
    if of_probe and name not in probes:
        raise refuse(f"the case has no probe '{name}'", f"it has {', '.join(probes) or 'none'}")
    try:
        noise = quantities.to_si(entry["noise"], kind, difference=True)
        if not noise > 0:
            raise refuse(f"a noise of {entry['noise']}", "give a standard deviation above 0")
        if ("value" in entry) == ("file" in entry):
            raise refuse("no measurements, or two kinds of them", "give either 'file' or 'value'")
        if "value" in entry:
            t = quantities.to_si(entry["at"], "s") if "at" in entry else math.inf
            if t != math.inf and not 0 <= t <= end:
                raise refuse(f"a time of {entry['at']} outside the run, which ends at {end:g} s", "give another, or a longer run")
            return Data(name, of_probe, np.array([t]), np.array([quantities.to_si(entry["value"], kind)]), noise, where)
    except CommandError as error:
        raise refuse(str(error), "correct it") from None
    path = folder / entry["file"]
    try:
        with path.open(newline="") as file:
            rows = list(csv.reader(file))
    except OSError as error:
        raise refuse(f"{path} cannot be read: {error.strerror}", "give the name of a CSV file relative to the case") from None
    if not rows:
        raise refuse(f"{path} is empty", "give a file with a line of headings")
    headings = [split_unit(text.strip()) for text in rows[0]]
    names = [heading for heading, _ in headings]
    if "time" not in names:
        raise refuse(f"{path} has no column 'time'", f"it has {', '.join(rows[0])}: name one 'time [s]'")
    wanted = split_unit(entry["column"])[0] if "column" in entry else None
    others = [n for n, heading in enumerate(names) if heading != "time"]
    columns = [n for n in others if names[n] == wanted] if wanted else others
    if len(columns) != 1:
        raise refuse(f"{path} has {'no such' if not columns else 'several'} columns{f' named {wanted}' if wanted else ''}",
                     f"take one of {', '.join(rows[0][n] for n in others)} as 'column'")
    in_time, column = names.index("time"), columns[0]
    times: list[float] = []
    values: list[float] = []
    try:
        to_s = quantities.unit_of(headings[in_time][1], "s", f"{path}:1")
        to_unit = quantities.unit_of(headings[column][1], kind, f"{path}:1")
    except CommandError as error:
        raise refuse(str(error), "write it into the heading, as in 'tc1 [degC]'") from None
    for line, row in enumerate(rows[1:], 2):
        place = f"{path}:{line}"
        if not any(cell.strip() for cell in row):
            continue
        try:
            at, measured = float(row[in_time]), float(row[column])
        except (ValueError, IndexError):
            raise refuse(f"{','.join(row)!r} is no row of numbers", "correct it, or leave the row out", place) from None
        if not (math.isfinite(at) and math.isfinite(measured)):
            raise refuse(f"{','.join(row)!r} is not finite", "leave the row out", place)
        at = at * to_s[0]
        if not 0 <= at <= end * (1 + 1e-9):
            raise refuse(f"a time of {at:g} s outside the run, which ends at {end:g} s", "leave the row out, or let the run last longer", place)
        times.append(at)
        values.append(measured * to_unit[0] + to_unit[1])
    if not times:
        raise refuse(f"{path} has no rows", "give measurements")
    return Data(name, of_probe, np.array(times), np.array(values), noise, where)


@dataclass
class Fit:
    """What came out. `values` in the units of the case, `deviation`: their standard deviations, `correlation`: a matrix;
    `misfit`: sum of squares over measurements less unknowns, 1 where the noise is as stated."""

    unknowns: list[Unknown]
    data: list[Data]
    values: Array
    deviation: Array
    correlation: Array
    misfit: float
    runs: int
    converged: bool
    folder: pathlib.Path
    result: Result
    residuals: list[Array] = field(default_factory=list)

    def remarks(self) -> list[str]:
        """What the measurements do not tell, in sentences."""
        said = []
        for n, u in enumerate(self.unknowns):
            if not math.isfinite(self.deviation[n]) or self.deviation[n] > VAGUE * abs(self.values[n]):
                said.append(f"The data hardly tell {u.key}: measure closer to where it acts, or give what is known about it ('expected', 'within').")
            if self.values[n] in (u.low, u.high):
                said.append(f"{u.key} lies at its limit: the data ask for more; its interval is too narrow.")
            for m in range(n):
                if abs(self.correlation[n, m]) > ALIKE:
                    said.append(f"{self.unknowns[m].key} and {u.key} can hardly be told apart (correlation {self.correlation[n, m]:+.2f}): "
                                "the data know a combination of them better than each.")
        if self.misfit > 2:
            said.append(f"Measured and computed values differ by {math.sqrt(self.misfit):.1f} times the noise: the noise is larger than stated, or the model lacks something.")
        if not self.converged:
            said.append("The search has not come to its end: give [fit] more iterations, or a better start.")
        return said

    def table(self) -> str:
        """For people."""
        width = max(len(u.key) for u in self.unknowns)
        lines = [f"{sum(d.value.size for d in self.data)} measurements, {len(self.unknowns)} unknowns, {self.runs} runs; misfit {self.misfit:.2f} (1 as the noise says)"]
        for n, u in enumerate(self.unknowns):
            shown = convergence.text(self.values[n], 1.96 * self.deviation[n], u.unit)
            lines.append(f"{u.key:<{width}}  {shown}  (95 %; start {u.start:g})")
        if len(self.unknowns) > 1:
            lines.append("correlation")
            lines += ["  " + " ".join(f"{value:+.2f}" for value in row[: n + 1]) + f"  {self.unknowns[n].key}" for n, row in enumerate(self.correlation)]
        return "\n".join(lines + self.remarks())

    def to_json(self) -> dict[str, Any]:
        return {"unknowns": [{"key": u.key, "unit": u.unit, "value": float(v), "deviation": float(s)} for u, v, s in zip(self.unknowns, self.values, self.deviation)],
                "correlation": self.correlation.tolist(), "misfit": self.misfit, "runs": self.runs, "converged": self.converged,
                "remarks": self.remarks(),
                "data": [{"name": d.name, "time": [None if math.isinf(t) else t for t in d.t.tolist()], "measured": d.value.tolist(),
                          "computed": (d.value + d.noise * r).tolist(), "noise": d.noise} for d, r in zip(self.data, self.residuals)]}


class Search:
    """The way to the best values."""

    def __init__(self, case: Case, folder: pathlib.Path, j: int, say: Callable[[str], None]) -> None:
        self.case, self.folder, self.j, self.say = case, folder, j, say
        self.written = case.to_dict()
        if case.variant:
            raise CommandError("calor fit takes no variant: write the case as it is meant")
        asked = self.written.get("fit", {})
        if not asked.get("unknown") or not asked.get("data"):
            raise CommandError(f"{case.name} has no [[fit.unknown]] or no [[fit.data]]: see docs/fit.md")
        self.iterations = int(asked.get("iterations", 20))
        self.unknowns = [read_unknown(self.written, entry, line_of(case.path, "fit.unknown", n)) for n, entry in enumerate(asked["unknown"])]
        end = quantities.to_si(self.written["time"]["end"], "s") if "time" in self.written else math.inf
        home = case.path.parent if case.path else pathlib.Path(".")
        self.data = [read_data(entry, line_of(case.path, "fit.data", n), home, end, list(self.written.get("probe", {})))
                     for n, entry in enumerate(asked["data"])]
        self.runs = 0

    def run(self, x: Array) -> tuple[Array, Result]:
        """Residuals over noise, what is expected of the unknowns among them."""
        values = {u.key: quantities.joined(value, u.unit) for u, value in zip(self.unknowns, x)}
        self.runs += 1
        number = self.runs
        result = self.case.changed({**quantities.changes_at(self.written, values), "output.fields": False}).run(
            self.folder / f"run-{number}", show_progress=False)
        r = [(d.computed(result) - d.value) / d.noise for d in self.data]
        r.append(np.array([(value - u.expected) / u.within for u, value in zip(self.unknowns, x) if u.expected is not None]))
        return np.concatenate(r), result

    def derivatives(self, x: Array, r: Array) -> Array:
        """dr/dx by differences, side by side."""
        def column(n: int) -> Array:
            h = DIFFERENCE * abs(x[n])
            if x[n] + h > self.unknowns[n].high:
                h = -h
            changed = x.copy()
            changed[n] += h
            slope: Array = (self.run(changed)[0] - r) / h
            return slope

        with ThreadPoolExecutor(self.j) as pool:
            return np.column_stack(list(pool.map(column, range(x.size))))

    def search(self) -> Fit:
        low, high = np.array([u.low for u in self.unknowns]), np.array([u.high for u in self.unknowns])
        x = np.array([u.start for u in self.unknowns])
        r, result = self.run(x)
        J, damping, converged = self.derivatives(x, r), 1e-3, False
        is_fresh, has_failed = True, False  # the derivatives; the last step
        for _ in range(self.iterations):
            scale = np.linalg.norm(J, axis=0)
            scale[scale == 0] = 1 / np.abs(x[scale == 0])
            free = ~(((x <= low) & (J.T @ r > 0)) | ((x >= high) & (J.T @ r < 0)))
            if not free.any():
                converged = True
                break
            A = np.vstack([J[:, free], np.diag(math.sqrt(damping) * scale[free])])
            step = np.zeros_like(x)
            step[free] = np.linalg.lstsq(A, np.concatenate([-r, np.zeros(free.sum())]), rcond=None)[0]
            longest = np.max(np.abs(step) / (LONGEST_STEP * np.abs(x)))
            trial = np.clip(x + step / max(longest, 1), low, high)
            # In units of the standard deviations that these derivatives give.
            moved = np.linalg.norm(J @ (trial - x))
            if moved < CONVERGED * math.sqrt(x.size) and is_fresh:
                converged = True
                break
            r_new, result_new = self.run(trial)
            self.say(f"run {self.runs}: misfit {float(r_new @ r_new) / max(r.size - x.size, 1):.4g} at "
                     + ", ".join(str(quantities.joined(float(f"{v:.5g}"), u.unit)) for u, v in zip(self.unknowns, trial)))
            s, before = trial - x, r @ r
            weight = s * scale**2
            J, was_fresh, is_fresh = J + np.outer(r_new - r - J @ s, weight / (s @ weight)), is_fresh, False  # Broyden
            if r_new @ r_new < before:
                x, r, result, damping, has_failed = trial, r_new, result_new, damping / 10, False
                if before - r @ r < CONVERGED**2 * x.size:  # nothing that noise would let see
                    converged = True
                    break
            elif was_fresh or not has_failed:
                damping, has_failed = max(10 * damping, 1e-2), True
            else:
                J, is_fresh, has_failed = self.derivatives(x, r), True, False
        if not is_fresh:
            J = self.derivatives(x, r)
        return self._fit(x, r, J, result, converged)

    def _fit(self, x: Array, r: Array, J: Array, result: Result, converged: bool) -> Fit:
        size = np.abs(x)
        _, s, V = np.linalg.svd(J * size, full_matrices=False)
        with np.errstate(divide="ignore"):
            covariance = (V.T * np.where(s > 1e-12 * s[0], 1 / np.maximum(s, 1e-300) ** 2, 1e24)) @ V
        deviation = np.sqrt(np.diag(covariance)) * size
        spread = np.sqrt(np.diag(covariance))
        residuals, first = [], 0
        for d in self.data:
            residuals.append(r[first: first + d.value.size])
            first += d.value.size
        return Fit(self.unknowns, self.data, x, deviation, covariance / np.outer(spread, spread), float(r @ r) / max(r.size - x.size, 1),
                   self.runs, converged, self.folder, result, residuals)


def fit(case: Case | str, folder: str | pathlib.Path | None = None, *, j: int = 1, say: Callable[[str], None] = lambda line: None) -> Fit:
    """Finds the unknowns of [fit] from its data, `j` runs side by side. Writes fit.json and the case with the values
    found into `folder` (default: results/NAME-fit), beside the runs. Raises CalorError."""
    case = case if isinstance(case, Case) else Case(case)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / f"{case.name}-fit"
    search = Search(case, into, j, say)
    into.mkdir(parents=True, exist_ok=True)
    found = search.search()
    (into / "fit.json").write_text(json.dumps(found.to_json(), indent=1))
    fitted = case.changed(quantities.changes_at(search.written, {u.key: quantities.joined(float(f"{v:.6g}"), u.unit) for u, v in zip(found.unknowns, found.values)})).to_dict()
    (into / f"{case.name}-fitted.toml").write_text(toml.write(fitted))
    return found


__all__ = ["Fit", "fit"]
