"""Where the parts of a body meet, as formulas in x, y, z that are smooth, and 0 there.

Candidates are the comparisons in the formulas of regions, the planes between layers and the faces of plain shapes. Which of
them matter, and which part lies on which side, the points tell.
"""
from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import quantities
from .command import CaseError
from .result import Array, Fields
from .toml import listed

# Of the spacing: how near to an interface points are on it. Those on curved faces lie beside the chords of their facets, and
# cells that an interface cuts are of the part that has most of them.
ON = (1e-6, 0.15, 0.6)
LOGICAL, COMPARISON = r"&&|\|\||\?|:", r"<=|>=|==|!=|<|>"
FUNCTIONS = {"sin": np.sin, "cos": np.cos, "exp": np.exp, "log": np.log, "ln": np.log, "sqrt": np.sqrt}


def evaluated(formula: str, x: Array) -> Array | None:
    """At places x (n, 3), m; nothing where the formula has words that are not known here, or is not finite."""
    known = {**FUNCTIONS, "x": x[:, 0], "y": x[:, 1], "z": x[:, 2], "r": np.hypot(x[:, 0], x[:, 1]), "pi": math.pi}
    words = re.findall(r"[A-Za-z_]\w*", re.sub(quantities.NUMBER, "0", formula))
    if not set(words) <= set(known) or not re.fullmatch(r"[\w\s.+*/^()-]*", formula):  # a case is to carry out nothing but arithmetic
        return None
    try:
        with np.errstate(all="ignore"):
            value: Array = eval(formula.replace("^", "**"), {"__builtins__": {}}, known) * np.ones(len(x))
    except (SyntaxError, TypeError, ValueError):
        return None
    return value if np.isfinite(value).all() else None


def distances(formula: str, fields: Fields) -> Array | None:
    """Of the points from where a formula is 0, m, negative where it is; nothing where it cannot be evaluated."""
    value = evaluated(formula, fields.x)
    if value is None:
        return None
    step = 1e-6 * np.ptp(fields.x, axis=0).max()
    slopes = []
    for n in range(fields.dimension):
        around = [evaluated(formula, fields.x + side * step * np.eye(3)[n]) for side in (1, -1)]
        if around[0] is None or around[1] is None:
            return None
        slopes.append((around[0] - around[1]) / (2 * step))
    distance: Array = value / np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
    return distance


def split_outside_brackets(text: str, at: str) -> list[str]:
    """The pieces between matches of a pattern that lie in no bracket."""
    depth = list(itertools.accumulate({"(": 1, ")": -1}.get(c, 0) for c in text))
    pieces, begin = [], 0
    for found in re.finditer(at, text):
        if depth[found.start()] == 0:
            pieces.append(text[begin: found.start()])
            begin = found.end()
    return [*pieces, text[begin:]]


def compared(condition: str) -> Iterator[str]:
    """For every comparison in a condition what is 0 where it turns, smooth where that is possible."""
    condition = condition.strip()
    pieces = split_outside_brackets(condition, LOGICAL)
    sides = split_outside_brackets(condition, COMPARISON)
    if len(pieces) > 1:
        for piece in pieces:
            yield from compared(piece)
    elif condition.startswith("(") and condition.endswith(")") and len(sides) == 1:
        yield from compared(condition[1:-1])
    elif len(sides) == 2:
        one, other = (side.strip() if re.fullmatch(r"[\w.]+", side.strip()) else f"({side.strip()})" for side in sides)
        if size := re.fullmatch(r"\(abs\((.*)\)\)", one):
            yield from (f"({size[1]}) - {other}", f"({size[1]}) + {other}")
        elif re.search(r"\br\b|sqrt", f"{one} {other}"):
            yield f"{one}^2 - {other}^2"
        else:
            yield f"{one} - {other}"


def of_regions(case: Mapping[str, Any]) -> Iterator[str]:
    numbers = {name: value for name, value in case.get("parameter", {}).items() if isinstance(value, (int, float))}
    for region in case["body"].get("region", []):
        unit = quantities.in_unit(f"1 {region.get('length', 'm')}", "m")
        in_m = {axis: axis if unit == 1 else f"({axis}/{unit:.15g})" for axis in "xyzr"}
        replaced = {**in_m, **{name: f"({value!r})" for name, value in numbers.items()}}
        for formula in compared(region.get("where", "")):
            yield re.sub(r"\b[A-Za-z_]\w*\b", lambda word: replaced.get(word[0], word[0]), formula)


def of_layers(case: Mapping[str, Any], low: Array) -> Iterator[str]:
    body = case["body"]
    if "layer" not in body:
        return
    axis = body["along"]
    place = quantities.in_unit(body["start"], "m") if "start" in body else low["xyz".index(axis)]
    for layer in body["layer"][:-1]:
        place += quantities.in_unit(layer["thickness"], "m")
        yield f"{axis} - ({place:.15g})"


def of_shapes(case: Mapping[str, Any], dimension: int) -> Iterator[str]:
    """Faces of plain shapes, where they have been turned and moved to."""
    for part in case["cloud"].get("part", []):
        at = [quantities.in_unit(c, "m") for c in listed(part.get("at", ["0 m"] * 3))] + [0.0]
        turn = [quantities.in_unit(angle, "rad") for angle in listed(part.get("turn", []))]
        if dimension == 2:
            turn = [0, 0, *turn]
        turned = np.eye(3)
        for (a, b), angle in zip(((1, 2), (2, 0), (0, 1)), turn):
            about = np.eye(3)
            about[[a, a, b, b], [a, b, a, b]] = math.cos(angle), -math.sin(angle), math.sin(angle), math.cos(angle)
            turned = about @ turned
        # Coordinates in the shape: those of the body less its place, turned back.
        along = [f"({c} - ({place:.15g}))" if place else c for c, place in zip("xyz", at)]
        X, Y, Z = ("(" + (" + ".join(f"{turned[n, axis]:.15g}*{along[n]}" for n in range(dimension) if abs(turned[n, axis]) > 1e-12) or "0") + ")" for axis in range(3))
        for key in ("radius", "inner", "outer"):
            if key in part:
                height = f" + {Z}^2" if part["shape"] in ("sphere", "shell") else ""
                yield f"{X}^2 + {Y}^2{height} - {quantities.in_unit(part[key], 'm') ** 2:.15g}"
        if "semi_axes" in part:
            yield " + ".join(f"({C}/{quantities.in_unit(a, 'm'):.15g})^2" for C, a in zip((X, Y, Z), listed(part["semi_axes"]))) + " - 1"
        for C, length in [*zip((X, Y, Z), listed(part.get("size", []))), *([(Z, part["height"])] if "height" in part else [])]:
            yield from (C, f"{C} - {quantities.in_unit(length, 'm'):.15g}")


def of_cracks(case: Mapping[str, Any], dimension: int) -> list[str]:
    """The planes of all cracks, each once: distances from them, m."""
    planes: dict[str, None] = {}
    for crack in case.get("crack", []):
        corners = np.array([[quantities.in_unit(c, "m") for c in listed(crack[axis])] for axis in "xyz"[:dimension]]).T
        edges = np.diff(corners, axis=0)
        if dimension == 2:
            pieces = [(corner, np.array([-along[1], along[0]])) for corner, along in zip(corners, edges)]
        else:
            pieces = [(corners[0], sum(np.cross(a - corners[0], b - corners[0]) for a, b in zip(corners[1:], corners[2:])))]
        for corner, normal in pieces:
            normal = normal / np.linalg.norm(normal) * np.sign(normal[np.abs(normal).argmax()])
            terms = [f"{n:.12g}*{c}" for n, c in zip(normal, "xyz") if abs(n) > 1e-12]
            planes[f"{' + '.join(terms)} - ({round(float(normal @ corner), 14):.12g})"] = None
    return list(planes)


@dataclass
class Sides:
    """A part, or which lie where a formula is negative and where not."""

    part: int | None
    formula: str = ""
    negative: Sides | None = None
    positive: Sides | None = None

    def formulas(self) -> list[str]:
        if not (self.negative and self.positive):
            return []
        return list(dict.fromkeys([self.formula, *self.negative.formulas(), *self.positive.formulas()]))

    def choose(self, of_part: Sequence[str]) -> str:
        """One formula of all, from that of every part."""
        if not (self.negative and self.positive):
            assert self.part is not None
            return of_part[self.part]
        return f"({self.formula} < 0 ? {self.negative.choose(of_part)} : {self.positive.choose(of_part)})"


def impurity(part: Array) -> float:
    """How many points of other parts than their neighbours in a list there are: Gini's index times their number."""
    counts = np.unique(part, return_counts=True)[1]
    return float(part.size - (counts**2).sum() / max(part.size, 1))


def divided(values: Mapping[str, Array], part: Array) -> Sides | None:
    """Which parts lie on which sides, by the `values` of candidates and the part at all points; nothing where they do
    not tell. Points on an interface say nothing."""
    if np.unique(part).size == 1:
        return Sides(int(part[0]))
    best, least = "", impurity(part) * (1 - 1e-9)
    for formula, value in values.items():
        left = sum(impurity(part[side]) for side in (value < 0, value > 0))
        if (value < 0).any() and (value > 0).any() and left < least:
            best, least = formula, left
    if not best:
        return None
    sides = [divided({f: v[side] for f, v in values.items()}, part[side]) for side in (values[best] < 0, values[best] > 0)]
    return Sides(None, best, *sides) if all(sides) else None


@dataclass
class Interfaces:
    sides: Sides
    is_on: Array  # which points lie on one


def interfaces(case: Mapping[str, Any], fields: Fields) -> Interfaces:
    """Of the body of a case, by fields of one of its results. Raises CaseError where no formulas tell its parts from each other."""
    formulas = dict.fromkeys([*of_layers(case, fields.x.min(0)), *of_regions(case), *of_shapes(case, fields.dimension)])
    known = {formula: away for formula in formulas if (away := distances(formula, fields)) is not None}
    for on in ON:
        values = {formula: np.where(np.abs(away) < on * fields["spacing"], 0, away) for formula, away in known.items()}
        if sides := divided(values, fields["part"]):
            return Interfaces(sides, np.any([values[formula] == 0 for formula in sides.formulas()], axis=0))
    raise CaseError("the parts of the body meet where no formula, plane, circle or sphere of the case is known to be: its twin has to be written by hand, as [[twin.part]] "
                    "with temperatures and fluxes that agree there")
