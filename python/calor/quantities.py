"""Numbers with units in cases and measurements, and where they stand."""
from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from typing import Any

from .command import CaseError

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
# What measurements are written in: factor and offset to SI.
UNITS = {"s": (1, 0), "ms": (1e-3, 0), "min": (60, 0), "h": (3600, 0), "K": (1, 0), "degC": (1, 273.15),
         "degF": (5 / 9, 459.67 * 5 / 9), "W": (1, 0), "kW": (1e3, 0), "Pa": (1, 0), "kPa": (1e3, 0), "MPa": (1e6, 0), "GPa": (1e9, 0), "J": (1, 0), "kJ": (1e3, 0),
         "m": (1, 0), "cm": (1e-2, 0), "mm": (1e-3, 0), "um": (1e-6, 0), "": (1, 0)}


def split(quantity: Any) -> tuple[float, str]:
    """(12.5, "W/(m K)") of "12.5 W/(m K)"; of a plain number (0.8, ""). Raises CaseError."""
    if isinstance(quantity, (int, float)) and not isinstance(quantity, bool):
        return float(quantity), ""
    found = re.fullmatch(rf"\s*({NUMBER})\s*(.*?)\s*", quantity) if isinstance(quantity, str) else None
    if not found:
        raise CaseError(f"{quantity!r} is no number with a unit: write, for example, \"12 W/(m K)\"")
    return float(found[1]), found[2]


def joined(number: float, unit: str) -> str | float:
    """As a case holds it."""
    return f"{number:.12g} {unit}" if unit else float(f"{number:.12g}")


def to_si(quantity: Any, kind: str, difference: bool = False) -> float:
    """Of a quantity of `kind`: "K", "s", "W", "J", "Pa", "m" or "". A difference of temperatures takes no offset. Raises
    CaseError."""
    number, unit = split(quantity)
    factor, offset = unit_of(unit, kind, str(quantity))
    return number * factor + (0 if difference else offset)


def kind_of_number(name: str) -> str:
    """The SI unit of a number of report.json that people give values for: heat_flow.air, maximum.steel, ..."""
    if name.endswith("_stress"):
        return "Pa"
    of_name = {"heat_flow": "W", "mean": "K", "minimum": "K", "maximum": "K", "average_temperature": "K"}
    return of_name.get(name.split(".")[0], "m" if name.startswith(("largest_", "peak_")) else "")


def unit_of(unit: str, kind: str, what: str) -> tuple[float, float]:
    """Factor and offset to SI. Raises CaseError where the unit is not one of `kind`."""
    kinds = {"K": ("K", "degC", "degF"), "s": ("s", "ms", "min", "h"), "W": ("W", "kW"), "J": ("J", "kJ"), "Pa": ("Pa", "kPa", "MPa", "GPa"), "m": ("m", "cm", "mm", "um"), "": ("",)}
    if unit not in kinds[kind]:
        raise CaseError(f"{what}: '{unit}' is no unit of what is measured: take {', '.join(kinds[kind]) or 'none'}")
    return UNITS[unit]


def steps_of(path: str) -> list[str | int]:
    """["material", "m", "conductivity", "k", 2] of "material.m.conductivity.k[2]"."""
    steps: list[str | int] = []
    for part in path.split("."):
        name, *places = re.split(r"\[(\d+)\]", part)
        steps += [name, *(int(place) for place in places if place)]
    return steps


def at(case: Mapping[str, Any], path: str) -> Any:
    """The value at a path. Raises CaseError where there is none."""
    value: Any = case
    for step in steps_of(path):
        try:
            value = value[step]
        except (KeyError, IndexError, TypeError):
            raise CaseError(f"the case has no '{path}': write keys as they stand in it, such as material.steel.conductivity") from None
    return value


def changes_at(case: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Changes of a case, as dotted keys of whole values, that put values at paths, entries of lists among them."""
    changes: dict[str, Any] = {}
    for path, value in values.items():
        steps = steps_of(path)
        # The longest part of the path that consists of tables alone is the key; what lies below it changes as a whole.
        depth, inner = 0, case
        while depth < len(steps) - 1 and isinstance(inner, Mapping) and isinstance(inner.get(steps[depth]), Mapping):  # type: ignore[arg-type]
            inner, depth = inner[steps[depth]], depth + 1  # type: ignore[index]
        key, below = ".".join(map(str, steps[: depth + 1])), steps[depth + 1:]
        if not below:
            changes[key] = value
            continue
        if key not in changes:
            changes[key] = copy.deepcopy(at(case, key))
        whole = changes[key]
        for step in below[:-1]:
            whole = whole[step]
        whole[below[-1]] = value
    return changes
