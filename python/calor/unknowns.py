"""Numbers of a case that are searched for."""
from __future__ import annotations

import math
import pathlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from . import quantities
from .command import CaseError


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

        def number_of(name: str) -> float:
            value, its_unit = quantities.split(entry[name])
            if its_unit != unit:
                raise CaseError(f"'{name}' is in '{its_unit}', the key in '{unit}': write both in one unit")
            return value

        u = Unknown(entry["key"], unit, number_of("start"))
        u.low = number_of("from") if "from" in entry else u.low
        u.high = number_of("to") if "to" in entry else u.high
        if ("expected" in entry) != ("within" in entry):
            raise CaseError("'expected' and 'within' go together: give both or none")
        if "expected" in entry:
            u.expected, u.within = number_of("expected"), number_of("within")
        if not u.low <= u.start <= u.high or u.start == 0:
            raise CaseError(f"a start of {u.start:g} outside its limits, or of 0: give another")
        return u
    except CaseError as error:
        raise CaseError(f"{where}: {error}", where.split(":")[0], None, None, entry["key"]) from None
