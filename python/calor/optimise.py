"""Numbers of a case for which a result is best, within limits on other results.

By COBYLA (Powell 1994) of scipy: linear models over a simplex that shrinks, no derivatives, limits on results as on the
numbers themselves.
"""
from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import quantities, refine
from .case import Case
from .command import CaseError
from .result import Array, Result
from .unknowns import Unknown, line_of, read_unknown

FIRST_STEP = 0.2  # of the way between the limits of an unknown
ALLOWED = 1e-4    # by how much a limit may be missed, of its value


@dataclass
class Limit:
    """A bound on a number of report.json, in SI."""

    number: str
    unit: str
    is_upper: bool
    bound: float

    def room(self, result: Result) -> float:
        """What is left until the limit, relative to it; negative beyond."""
        room = self.bound - result.numbers[self.number]
        return (room if self.is_upper else -room) / (abs(self.bound) or 1)


def read_limit(entry: Mapping[str, Any], where: str, units: Mapping[str, str]) -> Limit:
    """One [[optimise.limit]]; `units` of the numbers of the report. Raises CaseError."""
    try:
        if ("at_most" in entry) == ("at_least" in entry):
            raise CaseError("a limit is 'at_most' or 'at_least': give one of them")
        key = "at_most" if "at_most" in entry else "at_least"
        unit = units[entry["report"]]
        return Limit(entry["report"], unit, key == "at_most", quantities.in_unit(entry[key], unit))
    except CaseError as error:
        raise CaseError(f"{where}: {error}", where.split(":")[0], None, None, "optimise.limit") from None


@dataclass
class Trial:
    values: list[float]  # of the unknowns, in their units
    objective: float
    room: list[float]    # of every limit, relative
    result: Result

    @property
    def is_allowed(self) -> bool:
        return all(room >= -ALLOWED for room in self.room)


@dataclass
class Optimum:
    """What came out: `first` at the start of the search, `best` at its end."""

    unknowns: list[Unknown]
    limits: list[Limit]
    number: str
    unit: str
    trials: list[Trial]
    best: Trial
    folder: pathlib.Path
    finer: Callable[[Trial, str], Result]  # the same on half the spacing

    @property
    def first(self) -> Trial:
        return self.trials[0]

    def table(self) -> str:
        """For people."""
        width = max(len(name) for name in [self.number, *(u.key for u in self.unknowns), *(limit.number for limit in self.limits)])
        lines = [f"{len(self.trials)} runs", f"{'':<{width}}  {'start':>12}  {'best':>12}"]
        lines += [f"{u.key:<{width}}  {first:>12.5g}  {best:>12.5g}  {u.unit}" for u, first, best in zip(self.unknowns, self.first.values, self.best.values)]
        lines.append(f"{self.number:<{width}}  {self.first.objective:>12.5g}  {self.best.objective:>12.5g}  {self.unit}")
        for limit in self.limits:
            first, best = (trial.result.numbers[limit.number] for trial in (self.first, self.best))
            lines.append(f"{limit.number:<{width}}  {first:>12.5g}  {best:>12.5g}  {limit.unit}"
                         f"  ({'at most' if limit.is_upper else 'at least'} {limit.bound:g})")
        if not self.best.is_allowed:
            lines.append("No run keeps all limits; the one that misses them least stands here: widen those of the unknowns, or of the results.")
        return "\n".join(lines)

    def plot(self) -> Any:
        """Composition, temperature and stress before and after, of a case with [stress], with their errors by a run each on half
        the spacing where the cloud can be refined. Needs python3-matplotlib."""
        from . import stress
        shown = {"start": self.first, "best": self.best}
        try:
            finer = {name: self.finer(trial, name) for name, trial in shown.items()}
        except CaseError:
            finer = None
        return stress.compare({name: trial.result for name, trial in shown.items()}, finer)

    def to_json(self) -> dict[str, Any]:
        return {"unknowns": [{"key": u.key, "unit": u.unit, "start": self.first.values[n], "best": self.best.values[n]} for n, u in enumerate(self.unknowns)],
                "number": self.number, "start": self.first.objective, "best": self.best.objective, "keeps_limits": self.best.is_allowed,
                "limits": [{"number": limit.number, "at_most" if limit.is_upper else "at_least": limit.bound,
                            "best": self.best.result.numbers[limit.number]} for limit in self.limits],
                "runs": [{"values": trial.values, "number": trial.objective, "allowed": trial.is_allowed, "folder": trial.result.folder.name} for trial in self.trials]}


class Search:
    """Runs of a case, each once."""

    def __init__(self, case: Case, folder: pathlib.Path, say: Callable[[str], None]) -> None:
        self.case, self.folder, self.say = case, folder, say
        self.written = case.to_dict()
        asked = self.written.get("optimise", {})
        if not asked.get("unknown") or ("minimise" in asked) == ("maximise" in asked):
            raise CaseError(f"{case.name} has no [optimise] with 'minimise' or 'maximise' and [[optimise.unknown]]: see docs/optimise.md")
        self.sign = 1 if "minimise" in asked else -1
        self.number = asked.get("minimise", asked.get("maximise"))
        self.iterations = int(asked.get("iterations", 40))
        self.unknowns = [read_unknown(self.written, entry, line_of(case.path, "optimise.unknown", n)) for n, entry in enumerate(asked["unknown"])]
        for n, u in enumerate(self.unknowns):
            if not (math.isfinite(u.low) and math.isfinite(u.high) and u.low < u.high):
                where = line_of(case.path, "optimise.unknown", n)
                raise CaseError(f"{where}: {u.key} has no limits: give 'from' and 'to'", where.split(":")[0], None, None, u.key)
        units = case.numbers()
        self.unit = units[self.number]
        self.limits = [read_limit(entry, line_of(case.path, "optimise.limit", n), units) for n, entry in enumerate(asked.get("limit", []))]
        self.trials: list[Trial] = []

    def trial(self, x: Array) -> Trial:
        """At x, each between 0 and 1."""
        values = [float(f"{u.low + (u.high - u.low) * min(max(place, 0), 1):.8g}") for u, place in zip(self.unknowns, x)]
        for known in self.trials:
            if known.values == values:
                return known
        result = self.case.changed(self.changes(values)).run(self.folder / f"run-{len(self.trials) + 1}", show_progress=False)
        trial = Trial(values, result.numbers[self.number], [limit.room(result) for limit in self.limits], result)
        self.trials.append(trial)
        self.say(f"run {len(self.trials)}: {self.number} {trial.objective:.5g} at "
                 + ", ".join(f"{u.key} = {quantities.joined(float(f'{value:.5g}'), u.unit)}" for u, value in zip(self.unknowns, values))
                 + ("" if trial.is_allowed else ", beyond a limit"))
        return trial

    def changes(self, values: Sequence[float]) -> dict[str, Any]:
        return quantities.changes_at(self.written, {u.key: quantities.joined(value, u.unit) for u, value in zip(self.unknowns, values)})

    def finer(self, trial: Trial, name: str) -> Result:
        """A trial on half the spacing. Raises CaseError for clouds that come from files."""
        finer, _ = refine.refined(self.written["cloud"], 2)
        return self.case.changed({**self.changes(trial.values), **finer}).run(self.folder / f"{name}-on-half-the-spacing", show_progress=False)

    def best(self) -> Trial:
        """The best of those that keep the limits; of none the one that misses them least."""
        allowed = [trial for trial in self.trials if trial.is_allowed]
        if allowed:
            return min(allowed, key=lambda trial: self.sign * trial.objective)
        return max(self.trials, key=lambda trial: min(trial.room))

    def search(self) -> Optimum:
        from scipy.optimize import minimize
        start = np.array([(u.start - u.low) / (u.high - u.low) for u in self.unknowns])
        is_turned = start + FIRST_STEP > 1  # counted from the upper limit: first steps lead up, and beyond a limit nothing changes

        def trial(x: Array) -> Trial:
            return self.trial(np.where(is_turned, 1 - x, x))

        x = np.where(is_turned, 1 - start, start)
        scale = abs(trial(x).objective) or 1
        within = [{"type": "ineq", "fun": lambda x, n=n: min(x[n], 1 - x[n])} for n in range(x.size)]
        limits = [{"type": "ineq", "fun": lambda x, n=n: trial(x).room[n]} for n in range(len(self.limits))]
        minimize(lambda x: self.sign * trial(x).objective / scale, x, method="COBYLA", constraints=within + limits, tol=1e-3,
                 options={"rhobeg": FIRST_STEP, "maxiter": self.iterations, "catol": ALLOWED})
        return Optimum(self.unknowns, self.limits, self.number, self.unit, self.trials, self.best(), self.folder, self.finer)


def optimise(case: Case | str, folder: str | pathlib.Path | None = None, *, say: Callable[[str], None] = lambda line: None) -> Optimum:
    """Searches what [optimise] asks for. Writes optimum.json and the case with the best values into `folder` (default:
    results/NAME-optimum), beside the runs. Needs python3-scipy. Raises CalorError."""
    case = case if isinstance(case, Case) else Case(case)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / f"{case.name}-optimum"
    search = Search(case, into, say)
    into.mkdir(parents=True, exist_ok=True)
    found = search.search()
    (into / "optimum.json").write_text(json.dumps(found.to_json(), indent=1))
    best = {u.key: quantities.joined(value, u.unit) for u, value in zip(found.unknowns, found.best.values)}
    case.changed(quantities.changes_at(search.written, best)).write(into / f"{case.name}-best.toml")
    return found


__all__ = ["Optimum", "optimise"]
