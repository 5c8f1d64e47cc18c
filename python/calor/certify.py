"""An error bar on every number of a case: several spacings, by all methods that fit.

The difference of three methods at one spacing is no bound of the error; how each changes with the spacing, and whether
their limits agree, is.
"""
from __future__ import annotations

import json
import pathlib
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import convergence, refine
from .case import Case
from .command import CalorError, CaseError, CommandError, FileError, side_by_side, together
from .result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

METHODS = ("sph", "peridynamics", "mlpg")
FACTORS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)  # finer than the case, as long as time is left
COARSER = (0.5, 0.75)                                      # where there is none for at least three
ROUND_OFF = 1e-9                                           # of the largest value of a kind: no change at all


@dataclass
class Quantity:
    """What is certified, by name: the values of one method at its spacings are in `values[method]`."""

    name: str
    unit: str
    kind: str  # quantities of one kind have one scale
    values: dict[str, list[float]] = field(default_factory=dict)
    limits: dict[str, convergence.Limit] = field(default_factory=dict)
    time: dict[str, float] = field(default_factory=dict)  # error in time, by method
    verdict: convergence.Verdict | None = None

    @property
    def statement(self) -> str:
        assert self.verdict
        if not self.verdict.certified:
            return self.verdict.reason
        return "certified: " + convergence.text(self.verdict.value, self.verdict.bar, self.unit)


def quantities_of(result: Result) -> dict[str, Quantity]:
    """Temperatures of probes at the end, values of expectations, heat flows, and mean temperatures; with
    [stress] its extremes; of a weld the sizes of the melt, and of its probes the highest temperatures and times of cooling."""
    found: dict[str, Quantity] = {}

    def add(name: str, unit: str, kind: str, value: Any) -> None:
        if value is not None and np.isfinite(value):
            found[name] = Quantity(name, unit, kind, {"": [float(value)]})

    try:
        for name in result.probes:
            if name != "time":
                add(f"probe {name}", result.probes.units[name], "K", result.probes[name][-1])
    except FileError:
        pass
    for verdict in result.verdicts:
        if verdict.get("norm") == "value" and not verdict["what"].startswith("report"):
            add(verdict["what"], verdict["value_unit"], verdict["value_unit"], verdict["value"])
    for name, value in result.numbers.items():
        kind, _, of = name.partition(".")
        if of and kind in ("heat_flow", "mean"):
            add(f"{kind.replace('_', ' ')} {of}", result.units[name], result.units[name], value)
    case = result.report["case"]
    if "stress" in case:
        for name in ("lowest_stress", "highest_stress"):
            add(name, "Pa", "Pa", result.numbers[name])
    if "weld" in case:
        for extent in case["weld"].get("extent", {}):
            add(f"largest {extent}", "m", "m", result.numbers[f"largest_{extent}"])
            add(f"melted {extent}", "m", "m", result.numbers[f"peak_{extent}"])
        for probe, (peak, time) in (result.cooling if case.get("probe") else {}).items():
            add(f"peak of {probe}", "K", "K", peak)
            add(f"cooling time of {probe}", "s", "s", time)
    return found


@dataclass
class Run:
    method: str
    factor: float
    values: dict[str, float]
    seconds: float
    points: int


class Certificate:
    """The runs of a case at several spacings, and what follows. `runs`: that ended; `refused`: why a method has none."""

    def __init__(self, case: Case, folder: pathlib.Path, methods: Sequence[str], budget: float, factors: Sequence[float] | None,
                 j: int, say: Callable[[str], None]) -> None:
        self.case, self.folder, self.budget, self.factors, self.j, self.say = case, folder, budget, factors, j, say
        self.methods = list(methods)
        self.runs: list[Run] = []
        self.refused: dict[str, CalorError] = {}
        self.quantities: dict[str, Quantity] = {}
        self.span: dict[str, float] = {}
        self.beyond = ""  # what the next level would have taken
        self.started = time.monotonic()
        self.written = case.to_dict()
        if not isinstance(self.written["cloud"], Mapping):
            raise CaseError(f"{case.name} has no [cloud] that could be refined")

    @property
    def title(self) -> str:
        return str(self.written.get("title", self.case.name))

    def plot(self) -> Figure:
        """Values over the spacing, limits and bars. Needs python3-matplotlib."""
        from . import figures
        return figures.certificate(self)

    def write_page(self) -> pathlib.Path:
        """certificate.html, with all statements and the picture. Needs python3-matplotlib."""
        from . import figures
        return figures.certificate_page(self)

    def _run(self, method: str, factor: float, in_time: Mapping[str, Any]) -> Run:
        changes, reached = refine.refined(self.written["cloud"], factor)
        changes |= in_time
        into = self.folder / f"{method}-{factor:g}{'' if in_time or 'time' not in self.written else '-coarse-in-time'}"
        began = time.monotonic()
        result = self.case.changed({**changes, "method": method, "output.fields": False}).run(into, show_progress=False)
        values = {}
        for name, quantity in quantities_of(result).items():
            values[name] = quantity.values[""][0]
            self.quantities.setdefault(name, Quantity(name, quantity.unit, quantity.kind))
        return Run(method, reached, values, time.monotonic() - began, int(result.numbers["points"]))

    def _finer_in_time(self) -> dict[str, Any]:
        """A thirtieth of the tolerance, or a quarter of a fixed step."""
        steps = self.written["time"]
        if "step" in steps:
            return {"time.step": refine.scaled(steps["step"], 0.25)}
        return {"time.tolerance": refine.scaled(steps.get("tolerance", f"{1e-4 * self._span_of_temperatures():.6g} K"), 1 / 30)}

    def _span_of_temperatures(self) -> float:
        T = [value for run in self.runs for name, value in run.values.items() if self.quantities[name].kind == "K"]
        return max(max(T) - min(T), 1.0) if T else 1.0

    def _level(self, factor: float, in_time: Mapping[str, Any]) -> list[Run]:
        """All methods at one spacing, side by side."""
        def attempt(method: str) -> Run | CalorError:
            try:
                return self._run(method, factor, in_time)
            except CalorError as error:
                return error

        wanted = [method for method in self.methods if method not in self.refused]
        runs = side_by_side(attempt, wanted, self.j)
        for method, run in zip(wanted, runs):
            if isinstance(run, CalorError):
                self.refused[method] = run
                self.say(f"{method} is left out: {run}")
        done = [run for run in runs if isinstance(run, Run)]
        if done:
            self.say(f"{factor:>5g} times as fine: " + ", ".join(f"{run.method} {run.points} points {run.seconds:.1f} s" for run in done))
        return done

    def compute(self) -> None:
        """Runs as many spacings as the budget holds, at least three, or those asked for. Raises CalorError where no method
        runs."""
        whole = refine.can_be_divided_only(self.written["cloud"])
        factors = self.factors or [f for f in FACTORS if not whole or f == round(f)]
        in_time: dict[str, Any] = {}
        if "time" in self.written:
            coarse = self.runs = self._level(factors[0], {})
            in_time, self.runs = self._finer_in_time(), []
        cost: list[tuple[float, float]] = []
        for factor in factors:
            if cost and not self.factors and self._left() < (expected := self._expected(cost, factor)):
                self.beyond = f"{factor:g} times would take about {duration(expected)} more, beyond the budget"
                break
            began = time.monotonic()
            done = self._level(factor, in_time)
            if not done:
                break
            self.runs += done
            cost.append((factor, time.monotonic() - began))
            if factor == factors[0] and in_time:
                self._compare_in_time(coarse, done)
        if len(cost) < 3 and not whole and not self.factors:
            for factor in COARSER[: 3 - len(cost)]:
                self.runs += self._level(factor, in_time)
        if not self.runs:
            raise together(self.refused)
        self.runs.sort(key=lambda run: run.factor)
        self._judge()

    def _left(self) -> float:
        return self.budget - (time.monotonic() - self.started)

    @staticmethod
    def _expected(cost: list[tuple[float, float]], factor: float) -> float:
        """Seconds of a level: by how the last two grew, or like the fourth power of the refinement."""
        (f, t) = cost[-1]
        power = 4.0
        if len(cost) > 1 and t > 1:
            power = min(max(np.log(t / cost[-2][1]) / np.log(f / cost[-2][0]), 1), 5)
        return float(t * (factor / f) ** power)

    def _compare_in_time(self, coarse: Sequence[Run], fine: Sequence[Run]) -> None:
        """What error in time is left of the change: a third with steps of first order; errors of controlled steps go like
        the tolerance to 2/3, a tenth is left, here doubled."""
        left = 1 / 3 if "step" in self.written["time"] else 0.2
        before = {run.method: run.values for run in coarse}
        for run in fine:
            for name, value in run.values.items():
                self.quantities[name].time[run.method] = left * abs(before.get(run.method, {}).get(name, value) - value)

    def _judge(self) -> None:
        for kind in {quantity.kind for quantity in self.quantities.values()}:
            values = [abs(run.values[name]) for run in self.runs for name in run.values if self.quantities[name].kind == kind]
            self.span[kind] = max(values, default=0)
        is_random = refine.is_random(self.written["cloud"])
        find_limit = convergence.limit_of_random_points if is_random else convergence.limit
        for name, quantity in self.quantities.items():
            for method in self.methods:
                runs = [run for run in self.runs if run.method == method and name in run.values]
                if len(runs) < 3:
                    continue
                quantity.values[method] = [run.values[name] for run in runs]
                quantity.limits[method] = find_limit([1 / run.factor for run in runs], quantity.values[method],
                                                            ROUND_OFF * self.span[quantity.kind], quantity.time.get(method, 0))
            if not quantity.limits:
                quantity.verdict = convergence.Verdict(float("nan"), float("nan"), False,
                                                       "three spacings did not fit into the budget: give more with --budget" + (f" ({self.beyond})" if self.beyond else ""))
                continue
            quantity.verdict = convergence.together(list(quantity.limits.values()), not is_random)

    def table(self) -> str:
        """For people."""
        spacings = sorted({round(run.factor, 6) for run in self.runs})
        lines = [f"{self.title}: {len(self.runs)} runs at "
                 f"{', '.join(f'{f:g}' for f in spacings)} times the points a length, {time.monotonic() - self.started:.0f} s"]
        width = max(len(name) for name in self.quantities) if self.quantities else 0
        for name, quantity in self.quantities.items():
            lines.append(f"{name:<{width}}  {quantity.statement}")
            for method, one in quantity.limits.items():
                order = "" if np.isnan(one.order) else f", order {one.order:.1f}"
                said = f"limit {convergence.text(one.value, one.bar, quantity.unit)}" if one.is_asymptotic else one.reason
                changed = quantity.time.get(method, 0)
                in_time = f" (error in time about {changed:.1g})" if changed > 0.1 * one.bar else ""
                lines.append(f"{'':<{width}}    {method:<13}{quantity.values[method][-1]:.7g}{order}; {said}{in_time}")
        lines += [f"{method} is left out: {why}" for method, why in self.refused.items()]
        lines += [self.beyond] if self.beyond else []
        certified = sum(1 for q in self.quantities.values() if q.verdict and q.verdict.certified)
        lines.append(f"{certified} of {len(self.quantities)} certified")
        return "\n".join(lines)

    def to_json(self) -> dict[str, Any]:
        return {"case": self.case.name, "seconds": time.monotonic() - self.started, "refused": {method: str(why) for method, why in self.refused.items()},
                "runs": [asdict(run) for run in self.runs], "beyond_the_budget": self.beyond,
                "quantities": [{"name": q.name, "unit": q.unit, "statement": q.statement, "verdict": asdict(q.verdict) if q.verdict else None,
                                "limits": {method: asdict(one) for method, one in q.limits.items()}, "values": q.values,
                                "time": q.time} for q in self.quantities.values()]}

    def write(self) -> pathlib.Path:
        path = self.folder / "certificate.json"
        path.write_text(re.sub(r"\bNaN\b|\bInfinity\b", "null", json.dumps(self.to_json(), indent=1)))
        return path


def check_methods(methods: Sequence[str]) -> None:
    """Raises CommandError where one of these is none, or is named twice."""
    for n, method in enumerate(methods):
        if method not in METHODS or method in methods[:n]:
            raise CommandError(f"'{method}' is no method, or named twice: take some of {', '.join(METHODS)}")


def certify(case: Case | str, folder: str | pathlib.Path | None = None, *, methods: Sequence[str] = METHODS, budget: float = 300,
            factors: Sequence[float] | None = None, j: int = 1, say: Callable[[str], None] = lambda line: None) -> Certificate:
    """Runs a case at several spacings by several methods and says how sure its numbers are.

    `budget`: seconds that decide how many spacings there are; or `factors`: how many times as fine as in the case they
    are, at least three, rising. `j`: runs side by side. Everything lies in `folder`
    (default: results/NAME-certificate), the certificate in certificate.json. Raises CalorError."""
    case = case if isinstance(case, Case) else Case(case)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / f"{case.name}-certificate"
    check_methods(methods)
    if factors is not None:
        refine.check_factors(factors, 3)
    certificate = Certificate(case, into, methods, budget, factors, j, say)
    into.mkdir(parents=True, exist_ok=True)
    certificate.compute()
    certificate.write()
    return certificate


def duration(t: float) -> str:
    """ "40 s", "12 min" or "3.1 h"."""
    return f"{t:.0f} s" if t < 100 else f"{t / 60:.0f} min" if t < 6000 else f"{t / 3600:.1f} h"


def seconds(text: str) -> float:
    """Of "90s", "10min" or "1h"; a plain number is seconds. Raises CommandError."""
    number = re.fullmatch(r"\s*(\d+\.?\d*)\s*(s|min|h|)\s*", text)
    if not number or float(number[1]) <= 0:
        raise CommandError(f"'{text}' is no time: write 90s, 10min or 1h")
    return float(number[1]) * {"": 1, "s": 1, "min": 60, "h": 3600}[number[2]]

