"""The manufactured twin of a case: the same body, materials and conditions, with a solution that is known.

So its error is known, too, and the order at which it falls: what the case can be trusted with before it is trusted.
"""
from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from . import quantities, refine
from .case import Case
from .command import CalorError, CommandError, NumbersError, side_by_side
from .result import Result

FACTORS = (1, 1.5, 2)
WHOLE_FACTORS = (1, 2, 3)  # where places of points are listed
WAVES = (1.7, 1.3, 2.1)    # of the solution over the extents of the body
PHASES = (0.3, 0.5, 0.4)
SWING = 0.45               # of the solution, of the temperatures that the case goes through
IN_TIME = 3e-6             # of that span: what a step may add to the error
ROUND_OFF = 1e-10          # of that span


@dataclass
class Solution:
    """Formulas in x, y, z, t, K: of the whole body, and of every layer, smooth beyond it, where there are several."""

    whole: str
    layers: list[str]
    span: float  # K

    def keys(self) -> dict[str, Any]:
        """As [twin] has them."""
        as_value = [{"temperature": {"formula": formula, "unit": "K"}} for formula in self.layers]
        return {"temperature": {"formula": self.whole, "unit": "K"}, **({"part": as_value} if as_value else {})}


def layers_of(case: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Thickness, m, and conductivity of every layer, where all of these are plain numbers of one unit; else nothing."""
    layers = case.get("body", {}).get("layer", [])
    found = []
    units = set()
    for layer in layers:
        try:
            k, unit = quantities.split(case["material"][layer["material"]]["conductivity"])
        except (CommandError, KeyError):
            return []
        units.add(unit)
        found.append((quantities.to_si(layer["thickness"], "m"), k))
    return found if len(units) == 1 and "region" not in case["body"] else []


def solution(case: Mapping[str, Any], result: Result, end: float) -> Solution:
    """Within the temperatures of a result. `end` of the run, s; 0 of a steady case. Across layers the waves run over the
    sum of thickness over conductivity in place of the thickness, so that the flux is the same on both sides where they
    meet."""
    low, high = (result.report["temperatures"][name]["T"] for name in ("lowest", "highest"))
    span = max(high - low, 1.0)
    fields = result.fields()
    layers = layers_of(case)
    across = "xyz".index(case["body"]["along"]) if layers else -1
    if len(layers) < 2:
        layers = [(1.0, 1.0)]
    resistance = sum(d / k for d, k in layers)
    of_layers: list[str] = []
    planes: list[float] = []
    passed = 0.0
    for thickness, k in layers:
        waves = []
        for axis in range(fields.dimension):
            begin, extent = fields.x[:, axis].min(), np.ptp(fields.x[:, axis])
            rate, phase = WAVES[axis] / extent, PHASES[axis]
            if axis == across and len(layers) > 1:
                rate, phase = WAVES[axis] / (resistance * k), phase + WAVES[axis] * passed / resistance
                begin = planes[-1] if planes else begin
                planes.append(begin + thickness)
            waves.append(f"cos({rate:.12g}*{'xyz'[axis]} + {phase - rate * begin:.12g})")
        passed += thickness / k
        in_time = f"*(1 + 0.4*sin({3 / end:.12g}*t))/1.4" if end else ""
        of_layers.append(f"{(low + high) / 2:.9g} + {SWING * span:.9g}*{'*'.join(waves)}{in_time}")
    whole = of_layers[-1]
    for formula, plane in zip(of_layers[-2::-1], planes[-2::-1]):
        whole = f"{'xyz'[across]} < {plane:.15g} ? {formula} : ({whole})"
    return Solution(whole, of_layers if len(of_layers) > 1 else [], span)


@dataclass
class Orders:
    """Of one method: root mean square errors at spacings of 1/factor, K, and the order at which they fall."""

    method: str
    factors: list[float]
    errors: list[float]
    order: float  # NaN where the errors are round-off


@dataclass
class Twin:
    formula: str
    span: float
    of_methods: list[Orders]
    refused: dict[str, str]
    folder: pathlib.Path

    def table(self) -> str:
        """For people."""
        factors = self.of_methods[0].factors
        lines = [f"T = {self.formula} K", f"{'rms error, K':<14}" + "".join(f"{f'{factor:.3g} times':>12}" for factor in factors) + "   order"]
        for one in self.of_methods:
            order = "exact" if math.isnan(one.order) else f"{one.order:.1f}"
            lines.append(f"{one.method:<14}" + "".join(f"{error:>12.2g}" for error in one.errors) + f"   {order}")
        return "\n".join(lines + [f"{method} is left out: {why}" for method, why in self.refused.items()])


def twin(case: Case | str, folder: str | pathlib.Path | None = None, *, methods: Sequence[str] = ("sph", "peridynamics", "mlpg"),
         factors: Sequence[float] | None = None, j: int = 1, say: Callable[[str], None] = lambda line: None) -> Twin:
    """Runs the case once, and its twin by all methods at several spacings, `j` runs side by side. Writes twin.json into
    `folder` (default: results/NAME-twin). Raises CalorError."""
    base = case if isinstance(case, Case) else Case(case)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / f"{base.name}-twin"
    written = base.to_dict()
    is_steady = "time" not in written
    end = 0.0 if is_steady else quantities.to_si(written["time"]["end"], "s")
    known = solution(written, base.changed({"output.fields": True}).run(into / "case", show_progress=False), end)
    formula, span = known.whole, known.span
    say(f"T = {formula} K")
    replaced: dict[str, Any] = {"twin": known.keys(), "output.fields": False,
                "expect": [{"name": "twin", "field": True, "norm": "rms", "value": {"formula": formula, "unit": "K"}, "within": "1e9 K"}]}
    levels: Sequence[float] = factors or (WHOLE_FACTORS if refine.can_be_divided_only(written["cloud"]) else FACTORS)
    refused: dict[str, str] = {}

    def error(method: str, factor: float) -> tuple[float, float]:
        changes, reached = refine.refined(written["cloud"], factor)
        if not is_steady and "step" in written["time"]:
            changes["time.step"] = refine.scaled(written["time"]["step"], 1 / reached**2)
        elif not is_steady:
            changes["time.tolerance"] = f"{IN_TIME * span:.6g} K"
        result = base.changed({**replaced, **changes, "method": method}).run(into / f"{method}-{factor:g}", show_progress=False)
        found = next(verdict for verdict in result.verdicts if verdict["what"].startswith("twin"))
        return reached, float(found["error"])

    def orders(method: str) -> Orders | None:
        try:
            rows = [error(method, factor) for factor in levels]
        except CalorError as problem:
            refused[method] = str(problem)
            return None
        say(f"{method}: " + ", ".join(f"{e:.2g} K" for _, e in rows))
        fine, errors = np.array(rows).T
        is_exact = errors.max() < ROUND_OFF * span
        order = math.nan if is_exact else -float(np.polyfit(np.log(fine), np.log(errors), 1)[0])
        return Orders(method, fine.tolist(), errors.tolist(), order)

    found = [one for one in side_by_side(orders, methods, j) if one]
    if not found:
        raise NumbersError("; ".join(f"{method}: {why}" for method, why in refused.items()))
    done = Twin(formula, span, found, refused, into)
    (into / "twin.json").write_text(json.dumps({"temperature": formula, "span": span, "methods": [asdict(one) for one in found], "refused": refused}, indent=1))
    return done


__all__ = ["Twin", "twin"]
