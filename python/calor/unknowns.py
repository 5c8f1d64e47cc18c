"""Numbers of a case that are searched for."""
from __future__ import annotations

import functools
import math
import pathlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from . import quantities
from .command import CaseError, CommandError

LEAST_SIZE = 0.1  # of a value, of the scale of the unknown


@dataclass
class Unknown:
    """A number of the case, in its unit there."""

    key: str
    unit: str
    start: float
    low: float = -math.inf
    high: float = math.inf
    expected: float | None = None
    within: float = 0
    zero: float = 0  # where the quantity itself is 0: -273.15 of degC

    @property
    def scale(self) -> float:
        """How large it may well be, whatever its value now: 0 where nothing tells."""
        across = (self.high - self.low) / 2 if -math.inf < self.low < self.zero < self.high < math.inf else 0
        return max(abs(self.start - self.zero), self.within, across)

    def size(self, value: float) -> float:
        """Of a value, by which differences and errors compare; not 0 where it passes 0."""
        return max(abs(value - self.zero), LEAST_SIZE * self.scale)


@functools.cache
def zero_of(unit: str) -> float:
    """Where the quantity of a unit is 0: other units than those of temperatures begin there."""
    if not unit:
        return 0.0
    try:
        return quantities.conversion("K", unit)[1]
    except CommandError:
        return 0.0


def line_of(path: pathlib.Path | None, section: str, number: int) -> str:
    """ "case.toml:12" of the n-th [[section]] of a case."""
    if path is None:
        return f"[[{section}]] {number + 1}"
    found = 0
    for line, text in enumerate(path.read_text().splitlines(), 1):
        if re.match(rf"\s*\[\[\s*{re.escape(section)}\s*\]\]", text):
            if found == number:
                return f"{path}:{line}"
            found += 1
    return str(path)


def read_unknown(case: Mapping[str, Any], entry: Mapping[str, Any], where: str) -> Unknown:
    """One [[fit.unknown]] or [[optimise.unknown]] at a place "case.toml:12". Raises CaseError with place and cure."""
    try:
        stands = quantities.at(case, entry["key"])
        if not isinstance(stands, (str, int, float)) or isinstance(stands, bool):
            raise CaseError(f"'{entry['key']}' is no single number: name an entry of it, such as {entry['key']}.k[0]")
        unit = quantities.split(stands)[1]

        u = Unknown(entry["key"], unit, quantities.in_unit(entry["start"], unit), zero=zero_of(unit))
        u.low = quantities.in_unit(entry["from"], unit) if "from" in entry else u.low
        u.high = quantities.in_unit(entry["to"], unit) if "to" in entry else u.high
        if ("expected" in entry) != ("within" in entry):
            raise CaseError("'expected' and 'within' go together: give both or none")
        if "expected" in entry:
            u.expected, u.within = quantities.in_unit(entry["expected"], unit), quantities.in_unit(entry["within"], unit, difference=True)
            if not u.within > 0:
                raise CaseError(f"'within' is {u.within:g}: give a standard deviation above 0")
        if not u.low <= u.start <= u.high:
            raise CaseError(f"a start of {u.start:g} outside its limits: give another")
        if not u.scale:
            raise CaseError("a start of 0 does not tell how large it may be: give another, or 'from' below 0 and 'to' above")
        return u
    except CaseError as error:
        raise CaseError(f"{where}: {error}", where.split(":")[0], None, None, entry["key"]) from None
