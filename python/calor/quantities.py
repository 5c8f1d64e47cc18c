"""Numbers with units in cases and measurements, and where they stand."""
from __future__ import annotations

import copy
import functools
import re
from collections.abc import Mapping
from typing import Any

from . import command, toml
from .command import CaseError, CommandError

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


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


@functools.cache
def conversion(unit: str, other: str) -> tuple[float, float]:
    """Factor and offset from one unit to another, as the command says them. Raises CommandError where there are none."""
    if unit == other:
        return 1.0, 0.0
    said = command.run(["units", "--", unit, other])[1]
    found = re.fullmatch(rf"a difference of 1 .* is ({NUMBER}) .*, 0 .* is ({NUMBER}) .*\n", said)
    assert found, said
    return float(found[1]), float(found[2])


def converts(unit: str, other: str, what: str) -> tuple[float, float]:
    """The same; raises CaseError about `what`."""
    try:
        return conversion(unit, other)
    except CommandError as error:
        raise CaseError(f"{what}: {error}") from None


def in_unit(quantity: Any, unit: str, difference: bool = False) -> float:
    """The number of a quantity in a unit. A difference of temperatures takes no offset. Raises CaseError."""
    number, its_unit = split(quantity)
    factor, offset = converts(its_unit, unit, str(quantity))
    return number * factor + (0 if difference else offset)


def steps_of(path: str) -> list[str | int]:
    """["material", "m", "conductivity", "k", 2] of "material.m.conductivity.k[2]"; keys may be in quotes."""
    found = re.finditer(r'\[(\d+)\]|"([^"]*)"|([^.\[\]"]+)', path)
    return [int(one[1]) if one[1] else one[2] or one[3] for one in found]


def at(case: Mapping[str, Any], path: str) -> Any:
    """The value at a path. Raises CaseError where there is none."""
    value: Any = case
    for step in steps_of(path):
        try:
            value = value[step if isinstance(value, (Mapping, list)) else None]  # texts have no entries
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
        key, below = ".".join(toml.key_text(str(step)) for step in steps[: depth + 1]), steps[depth + 1:]
        if not below:
            changes[key] = value
            continue
        at(case, path)  # has to be there
        if key not in changes:
            changes[key] = copy.deepcopy(at(case, key))
        whole = changes[key]
        for step in below[:-1]:
            whole = whole[step]
        whole[below[-1]] = value
    return changes
