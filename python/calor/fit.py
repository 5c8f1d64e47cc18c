"""Unknown numbers of a case from measurements: least squares, weighted by the noise.

Gauss-Newton with Levenberg's and Marquardt's damping. Of probes, of the balance, of a weld and of thermal stress a steady run, and one by tr-bdf2, gives the derivatives
with the values, by its tangent or its adjoint; elsewhere they come by differences once, later by Broyden's updates, and by
differences again at the end, from which the intervals follow. Runs that do not depend on each other go side by side.
"""
from __future__ import annotations

import functools
import json
import math
import pathlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import convergence, quantities
from .case import Case
from .command import CaseError, NumbersError, side_by_side
from .fields import Field, read_field
from .readings import Data, read_data
from .result import Array, Result
from .unknowns import line_of, read_unknown, Unknown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LONGEST_STEP = 0.5    # of an unknown in one step, of its value or scale
DIFFERENCE = 1e-2     # of an unknown for a derivative, of its size: well above what adaptive steps and solvers leave
CONVERGED = 0.1       # change of the unknowns in the end, of their standard deviations
ALIKE = 0.9           # correlation of unknowns that can hardly be told apart
UNTOLD = 1e12         # standard deviation over the size of a combination of unknowns that nothing tells
VAGUE = 0.5           # standard deviation over the value of an unknown that the data do not tell


@dataclass
class Fit:
    """What came out. `values` in the units of the case, `deviation`: their standard deviations, infinite where the data tell nothing;
    `correlation`: a matrix; `misfit`: sum of squares over measurements less unknowns, 1 where the noise is as stated."""

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
    fields: list[Field] = field(default_factory=list)  # their values are the last of the unknowns
    told: float = 0  # about how many combinations of the unknowns the data tell better than what was expected

    @property
    def single(self) -> int:
        """How many unknowns are numbers of their own, and not of a field."""
        return len(self.unknowns) - sum(len(f.unknowns) for f in self.fields)

    def computed(self, n: int) -> Array:
        """What the case gives in place of data[n]."""
        computed: Array = self.data[n].value + self.data[n].noise * self.residuals[n]
        return computed

    def shown(self, n: int) -> str:
        """The value of an unknown with its interval."""
        value, bar, unit = self.values[n], 1.96 * self.deviation[n], self.unknowns[n].unit
        return convergence.text(value, bar, unit) if bar < abs(value) else f"{value:.3g} ± {bar:.2g} {unit}".strip()

    def plot(self) -> Figure:
        """Computed and measured values, and their differences. Needs python3-matplotlib."""
        from . import figures
        return figures.measurements(self)

    def remarks(self) -> list[str]:
        """What the measurements do not tell, in sentences."""
        said = []
        for n, u in enumerate(self.unknowns[: self.single]):
            if not math.isfinite(self.deviation[n]) or self.deviation[n] > VAGUE * u.size(self.values[n]):
                said.append(f"The data hardly tell {u.key}: measure closer to where it acts, or give what is known about it ('expected', 'within').")
            if self.values[n] in (u.low, u.high):
                said.append(f"{u.key} lies at its limit: the data ask for more; its interval is too narrow.")
            for m in range(n):
                if abs(self.correlation[n, m]) > ALIKE:
                    said.append(f"{self.unknowns[m].key} and {u.key} can hardly be told apart (correlation {self.correlation[n, m]:+.2f}): "
                                "the data know a combination of them better than each.")
        first = self.single
        for f in self.fields:
            values = self.values[first: (first := first + len(f.unknowns))]
            if held := sum(value in (u.low, u.high) for u, value in zip(f.unknowns, values)):
                said.append(f"{held} of {values.size} values of {f.key} lie at a limit: the data ask for more; their intervals are too narrow.")
        if self.misfit > 2:
            said.append(f"Measured and computed values differ by {math.sqrt(self.misfit):.1f} times the noise: the noise is larger than stated, or the model lacks something.")
        if not self.converged:
            said.append("The search has not come to its end: give [fit] more iterations, or a better start.")
        return said

    def table(self) -> str:
        """For people."""
        width = max(len(key) for key in [*(u.key for u in self.unknowns[: self.single]), *(f.key for f in self.fields)])
        lines = [f"{sum(d.value.size for d in self.data)} measurements, {len(self.unknowns)} unknowns, {self.runs} runs; misfit {self.misfit:.2f} (1 as the noise says)"]
        for n, u in enumerate(self.unknowns[: self.single]):
            lines.append(f"{u.key:<{width}}  {self.shown(n)}  (95 %; start {u.start:g})")
        first = self.single
        for f in self.fields:
            part = slice(first, first := first + len(f.unknowns))
            value, sure = self.values[part], 1.96 * self.deviation[part]
            lines.append(f"{f.key:<{width}}  {value.size} values, {value.min():.4g} to {value.max():.4g} {f.unit}, "
                         f"± {sure.min():.2g} to {sure.max():.2g} (95 %; expected ± {1.96 * f.within:.2g})")
        if self.fields:
            lines.append(f"the measurements tell about {self.told:.0f} combinations of the {len(self.unknowns)} unknowns; the rest is as expected before")
        if self.single > 1:
            lines.append("correlation")
            lines += ["  " + " ".join(f"{value:+.2f}" for value in row[: n + 1]) + f"  {self.unknowns[n].key}"
                      for n, row in enumerate(self.correlation[: self.single])]
        return "\n".join(lines + self.remarks())

    def to_json(self) -> dict[str, Any]:
        return {"unknowns": [{"key": u.key, "unit": u.unit, "value": float(v), "deviation": float(s) if math.isfinite(s) else None} for u, v, s in zip(self.unknowns, self.values, self.deviation)],
                "correlation": self.correlation[: self.single, : self.single].tolist(), "told": self.told, "misfit": self.misfit, "runs": self.runs, "converged": self.converged,
                "remarks": self.remarks(),
                "data": [{"name": d.name, "time": [None if math.isinf(t) else t for t in d.t.tolist()], "measured": d.value.tolist(),
                          "computed": self.computed(n).tolist(), "noise": d.noise} for n, d in enumerate(self.data)]}


class Search:
    """The way to the best values."""

    def __init__(self, case: Case, folder: pathlib.Path, j: int, say: Callable[[str], None]) -> None:
        self.case, self.folder, self.j, self.say = case, folder, j, say
        self.written = case.to_dict()
        asked = self.written.get("fit", {})
        if not (asked.get("unknown") or asked.get("field")) or not asked.get("data"):
            raise CaseError(f"{case.name} has no [[fit.unknown]] or no [[fit.data]]: see docs/fit.md")
        self.iterations = int(asked.get("iterations", 20))
        self.unknowns = [read_unknown(self.written, entry, line_of(case.path, "fit.unknown", n)) for n, entry in enumerate(asked.get("unknown", []))]
        for n, u in enumerate(self.unknowns):
            if u.key in [other.key for other in self.unknowns[:n]]:
                raise CaseError(f"{line_of(case.path, 'fit.unknown', n)}: '{u.key}' is an unknown already: keep one of the two")
        self.fields = [read_field(self.written, entry, line_of(case.path, "fit.field", n)) for n, entry in enumerate(asked.get("field", []))]
        # What is expected: rows W of the unknowns from `first` on, whose W (x - mean) are independent numbers of size 1.
        self.expected = [(n, np.array([[1 / u.within]]), u.expected) for n, u in enumerate(self.unknowns) if u.expected is not None]
        for f in self.fields:
            self.expected.append((len(self.unknowns), f.whitening, f.mean))
            self.unknowns += f.unknowns
        end = quantities.in_unit(self.written["time"]["end"], "s") if "time" in self.written else math.inf
        numbers = functools.cache(case.numbers)
        self.data = [data for n, entry in enumerate(asked["data"])
                     for data in read_data(entry, line_of(case.path, "fit.data", n), case.folder, end, list(self.written.get("probe", {})), numbers)]
        # Does a run give the derivatives of all that is measured?
        self.has_derivatives = not any(u.key.startswith("cloud.") for u in self.unknowns)
        if self.fields and not (self.has_derivatives and "steady" in self.written and all(d.source != "report" for d in self.data)):
            raise CaseError(f"{line_of(case.path, 'fit.field', 0)}: a field takes a steady case and readings of probes, heat flows and mean temperatures alone: elsewhere derivatives would "
                               "cost a run for every value")
        self.runs = 0
        self.zero, self.scale = np.array([u.zero for u in self.unknowns]), np.array([u.scale for u in self.unknowns])
        self.low, self.high = np.array([u.low for u in self.unknowns]), np.array([u.high for u in self.unknowns])
        self.keeps_sign = np.zeros(len(self.unknowns), bool)  # calor has refused it beyond its zero

    def reach(self, x: Array) -> Array:
        """By which steps are measured: at least the scale of an unknown, so that it may pass its zero."""
        value = np.abs(x - self.zero)
        return np.where(self.keeps_sign, value, np.maximum(value, self.scale))

    def scales(self, x: Array, J: Array) -> Array:
        """Sizes of the columns of J, by which changes of unknowns compare; of those that nothing feels their own."""
        scale: Array = np.linalg.norm(J, axis=0)
        return np.where(scale > 0, scale, 1 / self.reach(x))

    def run(self, x: Array, also: dict[str, Any] | None = None) -> tuple[Array, Result]:
        """Residuals over noise, what is expected of the unknowns among them."""
        values = {u.key: quantities.joined(value, u.unit) for u, value in zip(self.unknowns, x)}
        self.runs += 1
        number = self.runs
        result = self.case.changed({**quantities.changes_at(self.written, values), "output.fields": False, **(also or {})}).run(
            self.folder / f"run-{number}", show_progress=False)
        r = [(d.computed(result) - d.value) / d.noise for d in self.data]
        r += [W @ (x[first: first + len(W)] - mean) for first, W, mean in self.expected]
        return np.concatenate(r), result

    def run_with_derivatives(self, x: Array) -> tuple[Array, Result, Array]:
        """Residuals, and dr/dx as the run gives it; by a difference where a number is 0, of which a run gives none."""
        single = len(self.unknowns) - sum(len(f.unknowns) for f in self.fields)
        at_zero = [n for n in range(single) if x[n] == 0]
        if len(at_zero) == x.size:
            r, result = self.run(x)
            return r, result, self.derivatives(x, r)
        asked: dict[str, Any] = {"output.derivatives": [u.key for n, u in enumerate(self.unknowns[:single]) if n not in at_zero] + [f.key for f in self.fields]}
        if of_report := list(dict.fromkeys(d.name for d in self.data if d.source != "probe")):
            asked["output.derivatives_of"] = of_report
        r, result = self.run(x, asked)
        J = np.zeros((r.size, x.size))
        given = [n for n in range(x.size) if n not in at_zero]
        derivatives = [result.derivatives[self.unknowns[n].key] for n in given]
        row = 0
        for d in self.data:
            J[row: row + d.value.size, given] = np.column_stack([d.derivatives(table) for table in derivatives]) / d.noise
            row += d.value.size
        for first, W, _ in self.expected:
            J[row: row + len(W), first: first + len(W)] = W
            row += len(W)
        for n in at_zero:
            J[:, n] = self.column(n, x, r)
        return r, result, J

    def column(self, n: int, x: Array, r: Array) -> Array:
        """dr/dx[n] by a difference."""
        h = DIFFERENCE * self.unknowns[n].size(x[n])
        if x[n] + h > self.unknowns[n].high:
            h = -h
        changed = x.copy()
        changed[n] += h
        slope: Array = (self.run(changed)[0] - r) / h
        return slope

    def derivatives(self, x: Array, r: Array) -> Array:
        """dr/dx by differences, side by side."""
        return np.column_stack(side_by_side(lambda n: self.column(n, x, r), range(x.size), self.j))

    def is_free(self, x: Array, r: Array, J: Array) -> Any:
        """Which unknowns no limit holds."""
        return ~(((x <= self.low) & (J.T @ r > 0)) | ((x >= self.high) & (J.T @ r < 0)))

    def distance(self, x: Array, r: Array, J: Array) -> float:
        """From the best values by these derivatives, in standard deviations: what of the residuals the free unknowns could take away."""
        A = (J / self.scales(x, J))[:, self.is_free(x, r, J)]
        return float(np.linalg.norm(A @ np.linalg.lstsq(A, r, rcond=None)[0])) if A.size else 0.0

    def step(self, x: Array, r: Array, J: Array, damping: float) -> Array:
        """The next values, within the limits."""
        free = self.is_free(x, r, J)
        A = np.vstack([J[:, free], np.diag(math.sqrt(damping) * self.scales(x, J)[free])])
        step = np.zeros_like(x)
        Q, R = np.linalg.qr(A)  # the damping keeps it regular
        step[free] = np.linalg.solve(R, Q[: r.size].T @ -r)
        longest = np.max(np.abs(step) / (LONGEST_STEP * self.reach(x)))
        trial: Array = np.clip(x + step / max(longest, 1), self.low, self.high)
        return trial

    def holds_back(self, x: Array, trial: Array) -> bool:
        """After calor has refused a trial: keeps the unknowns that have come to their zero or passed it from doing so. Are there such?"""
        passes = (x - self.zero) * (trial - self.zero) <= 0
        self.keeps_sign |= passes
        return bool(passes.any())

    def search(self) -> Fit:
        x = np.array([u.start for u in self.unknowns])
        if self.has_derivatives:
            try:
                r, result, J = self.run_with_derivatives(x)
            except CaseError as error:
                if error.key not in ("output.derivatives", "output.derivatives_of"):
                    raise
                self.has_derivatives = False  # the integrator's steps give none, or there are none of such a number, which the run tells
        if not self.has_derivatives:
            r, result = self.run(x)
            J = self.derivatives(x, r)
        damping = 1e-3
        is_fresh, has_failed, has_stalled = True, False, False  # the derivatives; the last step; it brought nothing that noise would let see
        near = CONVERGED * math.sqrt(min(x.size, sum(d.value.size for d in self.data)))
        for _ in range(self.iterations):
            is_near = self.distance(x, r, J) < near
            if is_near and is_fresh:
                break
            if is_near or has_stalled and not is_fresh:
                J, is_fresh, has_stalled = self.derivatives(x, r), True, False
                continue
            trial = self.step(x, r, J, damping)
            try:
                if self.has_derivatives:
                    r_new, result_new, J_new = self.run_with_derivatives(trial)
                else:
                    r_new, result_new = self.run(trial)
            except (CaseError, NumbersError):
                if not self.holds_back(x, trial):
                    raise
                continue
            if not self.has_derivatives:
                s = trial - x
                weight = s * self.scales(x, J) ** 2
                J_new = J + np.outer(r_new - r - J @ s, weight / (s @ weight))  # Broyden
            self.say(f"run {self.runs}: misfit {float(r_new @ r_new) / max(r.size - x.size, 1):.4g}{self.shown(trial)}")
            before, was_fresh = r @ r, is_fresh
            is_fresh = self.has_derivatives
            if r_new @ r_new < before:
                x, r, J, result, damping, has_failed = trial, r_new, J_new, result_new, damping / 10, False
                has_stalled = bool(before - r @ r < near**2)
                continue
            if self.has_derivatives or was_fresh or not has_failed:
                damping, has_failed = max(10 * damping, 1e-2), True
                J = J if self.has_derivatives else J_new
            else:
                J, is_fresh, has_failed = self.derivatives(x, r), True, False
        if not is_fresh:
            J = self.derivatives(x, r)
        return self._fit(x, r, J, result, self.distance(x, r, J) < near)

    def shown(self, x: Array) -> str:
        single = len(self.unknowns) - sum(len(f.unknowns) for f in self.fields)
        shown = ", ".join(str(quantities.joined(float(f"{v:.5g}"), u.unit)) for u, v in zip(self.unknowns[:single], x))
        return f" at {shown}" if shown else ""

    def _fit(self, x: Array, r: Array, J: Array, result: Result, converged: bool) -> Fit:
        size = self.reach(x)
        _, s, V = np.linalg.svd(J * size)
        told_by = s > 1e-12 * s[0]  # combinations of the unknowns that the data tell; V has those they do not, too
        of_told, of_others = V[: s.size][told_by] / s[told_by, None], np.vstack([V[: s.size][~told_by], V[s.size:]])
        covariance = of_told.T @ of_told + UNTOLD**2 * of_others.T @ of_others
        spread = np.sqrt(np.diag(covariance))
        deviation = np.where(np.sum(of_others**2, axis=0) > 1e-12, math.inf, spread * size)
        measured = J[: sum(d.value.size for d in self.data)]
        told = float(np.sum((measured * size @ of_told.T) ** 2))
        residuals, first = [], 0
        for d in self.data:
            residuals.append(r[first: first + d.value.size])
            first += d.value.size
        return Fit(self.unknowns, self.data, x, deviation, covariance / np.outer(spread, spread), float(r @ r) / max(r.size - x.size, 1),
                   self.runs, converged, self.folder, result, residuals, self.fields, told)


def fit(case: Case | str, folder: str | pathlib.Path | None = None, *, j: int = 1, say: Callable[[str], None] = lambda line: None) -> Fit:
    """Finds the unknowns of [fit] from its data, `j` runs side by side. Writes fit.json and the case with the values
    found into `folder` (default: results/NAME-fit), beside the runs. Raises CalorError."""
    case = case if isinstance(case, Case) else Case(case)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / f"{case.name}-fit"
    search = Search(case, into, j, say)
    into.mkdir(parents=True, exist_ok=True)
    found = search.search()
    (into / "fit.json").write_text(json.dumps(found.to_json(), indent=1))
    case.changed(quantities.changes_at(search.written, {u.key: quantities.joined(float(f"{v:.6g}"), u.unit) for u, v in zip(found.unknowns, found.values)})).write(into / f"{case.name}-fitted.toml")
    return found


__all__ = ["Fit", "fit"]
