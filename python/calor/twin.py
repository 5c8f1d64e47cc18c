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
from .certify import METHODS, check_methods
from .command import CalorError, CaseError, side_by_side, together
from .interfaces import evaluated, interfaces, of_cracks
from .result import Array, Fields, Result

FACTORS = (1, 1.5, 2)
WIDE_FACTORS = (1, 2, 3)   # where places of points are listed; and in the plane where they are irregular, whose errors scatter from one spacing to the next
WAVES = (1.7, 1.3, 2.1)    # of the solution over the extents of the body
PHASES = (0.3, 0.5, 0.4)
SWING = 0.45               # of the solution, of the temperatures that the case goes through
IN_TIME = 3e-6             # of that span: what a step may add to the error
EXACT = 1e-6               # of that span: what the differences leave that the twin's sources are made of


@dataclass
class Solution:
    """Formulas in x, y, z, t, K: of the whole body, and of every part, smooth beyond it, where there are several."""

    whole: str
    parts: list[str]
    span: float  # K

    def keys(self) -> dict[str, Any]:
        """As [twin] has them."""
        as_value = [{"temperature": {"formula": formula, "unit": "K"}} for formula in self.parts]
        return {"temperature": {"formula": self.whole, "unit": "K"}, **({"part": as_value} if as_value else {})}


@dataclass
class Layer:
    thickness: float  # m
    k: float          # W/(m K)
    contact: float    # resistance to the layer before it, m^2 K/W


def layers_of(case: Mapping[str, Any]) -> list[Layer]:
    """Of a body of several isotropic layers and nothing else, whose conductivities and contacts are plain numbers; of others nothing."""
    body = case.get("body", {})
    if len(body.get("layer", [])) < 2 or "region" in body or "contact" in body or is_anisotropic(case):
        return []
    try:
        return [Layer(quantities.in_unit(layer["thickness"], "m"), quantities.in_unit(case["material"][layer["material"]]["conductivity"], "W/(m K)"),
                      1 / quantities.in_unit(layer["contact"], "W/(m^2 K)") if "contact" in layer else 0.0) for layer in body["layer"]]
    except (CaseError, KeyError, ZeroDivisionError):
        return []


def waves_across(layers: Sequence[Layer], axis: str, begin: float) -> list[tuple[str, float]]:
    """Of every layer the wave along the axis and the place, m, of its end. The wave runs over the sum of thickness over
    conductivity in place of the thickness, so that the flux is the same on both sides where layers meet; contacts add what
    the temperature jumps by."""
    resistance = sum(layer.thickness / layer.k + layer.contact for layer in layers)
    rate, phase, level = WAVES["xyz".index(axis)] / resistance, PHASES["xyz".index(axis)], 0.0
    waves = []
    for layer in layers:
        level -= rate * math.sin(phase) * layer.contact
        waves.append((f"(cos({rate / layer.k:.12g}*({axis} - {begin:.15g}) + {phase:.12g}) + {level:.12g})", begin + layer.thickness))
        begin += layer.thickness
        phase += rate * layer.thickness / layer.k
    return waves


def parts_of(case: Mapping[str, Any]) -> int:
    """How many parts the body has: its layers, or what no region takes, and its regions."""
    body = case.get("body", {})
    rest = 1 if "material" in body or not body.get("region") else 0
    return len(body.get("layer", [])) + len(body.get("region", [])) + (0 if body.get("layer") else rest)


def has_contacts(case: Mapping[str, Any]) -> bool:
    body = case.get("body", {})
    return bool(body.get("contact")) or any("contact" in part for part in [*body.get("layer", []), *body.get("region", [])])


def is_anisotropic(case: Mapping[str, Any]) -> bool:
    return any("anisotropy" in material for material in case.get("material", {}).values())


def scale(result: Result) -> tuple[float, float]:
    """The middle of the temperatures of a result and their span, K."""
    low, high = (result.report["temperatures"][name]["T"] for name in ("lowest", "highest"))
    return (low + high) / 2, max(high - low, 1.0)


def wave_along(n: int, fields: Fields) -> str:
    """One wave over the extent of the body along its n-th axis."""
    rate = WAVES[n] / np.ptp(fields.x[:, n])
    return f"cos({rate:.9g}*{'xyz'[n]} + {PHASES[n] - rate * fields.x[:, n].min():.9g})"


def level_at_cracks(case: Mapping[str, Any], fields: Fields) -> list[str]:
    """Factors that are 0 on the planes of cracks, with all of their slopes: no heat crosses."""
    largest = {plane: np.abs(evaluated(plane, fields.x)).max() for plane in of_cracks(case, fields.dimension)}  # type: ignore[arg-type]
    return [f"(({plane})/{most:.9g})^2" for plane, most in largest.items()]


def in_time(end: float) -> list[str]:
    """Linear: steps of any length are exact where heat capacities are constant, and the error is that in space."""
    return [f"(1 + {0.4 / end:.9g}*t)/1.4"] if end else []


def solution(case: Mapping[str, Any], result: Result, end: float) -> Solution:
    """Of one part, or of layers, within the temperatures of a result. `end` of the run, s; 0 of a steady case."""
    middle, span = scale(result)
    fields = result.fields()
    layers = layers_of(case)
    across = case["body"]["along"] if layers else ""
    waves = [wave_along(n, fields) for n in range(fields.dimension) if "xyz"[n] != across] + level_at_cracks(case, fields)
    of_layers = waves_across(layers, across, fields.x[:, "xyz".index(across)].min()) if layers else [("", math.inf)]
    formulas = [f"{middle:.9g} + " + "*".join([f"{SWING * span:.9g}", *([wave] if wave else []), *waves, *in_time(end)]) for wave, _ in of_layers]
    whole = formulas[-1]
    for formula, (_, plane) in zip(formulas[-2::-1], of_layers[-2::-1]):
        whole = f"{across} <= {plane:.15g} ? {formula} : ({whole})"
    return Solution(whole, formulas if layers else [], span)


def conductivities(fields: Fields, is_on_interface: Array) -> dict[int, float]:
    """Of every part with points, W/(m K); on interfaces those of several are mixed. `fields`: of one temperature everywhere. Raises CaseError where it differs by place."""
    found = {}
    for part in np.unique(fields["part"]):
        k = fields["conductivity"][~is_on_interface & (fields["part"] == part)]
        if not k.size or k.max() > (1 + 1e-5) * k.min():  # of single precision
            raise CaseError(f"the twin of a body of several parts takes one conductivity in each, at one temperature: that of {fields.called['part'][part]} depends on place, "
                            "or all of its points lie where it meets others")
        found[int(part)] = float(np.median(k))
    return found


def solution_of_parts(base: Case, case: Mapping[str, Any], result: Result, end: float) -> Solution:
    """Of several parts of any shape. T = T_0 + Psi/k with a smooth Psi that is 0 where parts meet, and k of the part at T_0:
    there T is T_0, and the flux -grad Psi, on both sides. Where there are contacts, at which T would jump by the flux, and
    anisotropic parts, whose flux is another, Psi is level there, too. Runs a moment of the case at T_0. Raises CalorError."""
    middle, span = scale(result)
    meeting = interfaces(case, result.fields())
    moment: dict[str, Any] = {"time.end": f"{1e-6 * end:.6g} s", "output.times": ["0 s"]} if end else {}
    uniform = Solution(f"{middle:.9g}", [f"{middle:.9g}"] * parts_of(case), span)
    fields = base.changed({**moment, "expect": [], "output.fields": True, "twin": uniform.keys()}).run(result.folder.parent / "uniform", show_progress=False).fields()
    k = conductivities(fields, meeting.is_on)
    factors, psi = [], np.ones(len(fields.x))
    faces = meeting.sides.formulas()
    for formula in [*faces, *(faces if has_contacts(case) or is_anisotropic(case) else []), *(wave_along(n, fields) for n in range(fields.dimension)), *level_at_cracks(case, fields)]:
        value = evaluated(formula, fields.x)
        assert value is not None
        factors.append(f"({formula})/{np.abs(value).max():.9g}")
        psi *= value / np.abs(value).max()
    of_points = np.array([k[part] for part in fields["part"]])
    amplitude = SWING * span / np.abs(psi / of_points).max()
    parts = [f"{middle:.9g} + " + "*".join([f"{amplitude / k.get(part, math.inf):.9g}", *factors, *in_time(end)]) for part in range(parts_of(case))]
    return Solution(meeting.sides.choose(parts), parts, span)


@dataclass
class Orders:
    """Of one method: root mean square errors at spacings of 1/factor, K, and the order at which they fall."""

    method: str
    factors: list[float]
    errors: list[float]
    order: float  # NaN where the errors are those of the twin's own differences


@dataclass
class Twin:
    formula: str
    span: float
    of_methods: list[Orders]
    refused: dict[str, CalorError]
    folder: pathlib.Path

    def table(self) -> str:
        """For people."""
        factors = self.of_methods[0].factors
        lines = [f"T = {self.formula} K", f"{'rms error, K':<14}" + "".join(f"{f'{factor:.3g} times':>12}" for factor in factors) + "   order"]
        for one in self.of_methods:
            order = "exact" if math.isnan(one.order) else f"{one.order:.1f}"
            lines.append(f"{one.method:<14}" + "".join(f"{error:>12.2g}" for error in one.errors) + f"   {order}")
        return "\n".join(lines + [f"{method} is left out: {why}" for method, why in self.refused.items()])


def twin(case: Case | str, folder: str | pathlib.Path | None = None, *, methods: Sequence[str] = METHODS,
         factors: Sequence[float] | None = None, j: int = 1, say: Callable[[str], None] = lambda line: None) -> Twin:
    """Runs the case once, and its twin by all methods at several spacings, `j` runs side by side. Writes twin.json into
    `folder` (default: results/NAME-twin). Raises CalorError."""
    base = case if isinstance(case, Case) else Case(case)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / f"{base.name}-twin"
    check_methods(methods)
    written = base.to_dict()
    is_steady = "time" not in written
    end = 0.0 if is_steady else quantities.in_unit(written["time"]["end"], "s")
    if factors is not None:
        refine.check_factors(factors, 2)
    ran = base.changed({"output.fields": True}).run(into / "case", show_progress=False)
    is_wide = refine.can_be_divided_only(written["cloud"]) or (refine.is_random(written["cloud"]) and ran.fields().dimension < 3)
    levels: Sequence[float] = factors if factors is not None else (WIDE_FACTORS if is_wide else FACTORS)
    has_waves = parts_of(written) == 1 or (layers_of(written) and "crack" not in written)
    known = solution(written, ran, end) if has_waves else solution_of_parts(base, written, ran, end)
    formula, span = known.whole, known.span
    say(f"T = {formula} K")
    replaced: dict[str, Any] = {"twin": known.keys(), "output.fields": False,
                "expect": [{"name": "twin", "field": True, "norm": "rms", "value": {"formula": formula, "unit": "K"}, "within": "1e9 K"}]}
    refused: dict[str, CalorError] = {}

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
            refused[method] = problem
            return None
        say(f"{method}: " + ", ".join(f"{e:.2g} K" for _, e in rows))
        fine, errors = np.array(rows).T
        is_exact = errors.max() < EXACT * span
        order = math.nan if is_exact else -float(np.polyfit(np.log(fine), np.log(errors), 1)[0])
        return Orders(method, fine.tolist(), errors.tolist(), order)

    found = [one for one in side_by_side(orders, methods, j) if one]
    if not found:
        raise together(refused)
    done = Twin(formula, span, found, refused, into)
    (into / "twin.json").write_text(json.dumps({"temperature": formula, "span": span, "methods": [asdict(one) for one in found], "refused": {method: str(why) for method, why in refused.items()}}, indent=1))
    return done


__all__ = ["Twin", "twin"]
