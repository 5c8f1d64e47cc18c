"""Measurements that a case names: columns of CSV files and single values."""
from __future__ import annotations

import csv
import math
import pathlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import quantities
from .command import CaseError
from .result import Array, Result, split_unit


# Numbers of report.json that balance.csv has over time, and its columns.
BALANCE = {"heat_flow": ("heat flow through", "heat flow from"), "mean": ("mean of",), "minimum": ("minimum of",), "maximum": ("maximum of",)}


def source_of(report: str) -> str:
    """ "balance" where a number of report.json is known over time, and so are its derivatives; else "report"."""
    return "balance" if report.partition(".")[0] in BALANCE else "report"


@dataclass
class Data:
    """Measured values in SI units, times in s (inf: the end of the run). `source`: "probe", or see source_of."""

    name: str
    source: str
    t: Array
    value: Array
    noise: float
    unit: str
    where: str  # file and line, or the case

    def at_times(self, history: Mapping[str, Array], column: str) -> Array:
        """Of a column over time the values at the times of the measurements."""
        return np.interp(np.minimum(self.t, history["time"][-1]), history["time"], history[column])

    def computed(self, result: Result) -> Array:
        if self.source == "probe":
            return self.at_times(result.probes, self.name)
        if self.source == "report":
            return np.full(self.value.shape, result.numbers[self.name])
        kind, _, of = self.name.partition(".")
        return self.at_times(result.balance, next(column for words in BALANCE[kind] if (column := f"{words} {of}") in result.balance))

    def derivatives(self, table: Mapping[str, Array]) -> Array:
        """By one number of the case, whose rows of derivatives.csv are given."""
        return self.at_times(table, self.name)


def refusal(problem: str, cure: str, place: str) -> CaseError:
    return CaseError(f"{place}: {problem}: {cure}", place.split(":")[0], None, None, "fit.data")


def read_rows(path: pathlib.Path, where: str) -> tuple[list[str], list[tuple[str, list[str]]]]:
    """The headings of a CSV file, and its rows with their places. Raises CaseError."""
    try:
        with path.open(newline="", encoding="utf-8-sig", errors="replace") as file:  # as spreadsheets write them
            rows = list(csv.reader(file))
    except (OSError, csv.Error) as error:
        raise refusal(f"{path} cannot be read: {getattr(error, 'strerror', error)}", "give the name of a CSV file relative to the case", where) from None
    if not rows:
        raise refusal(f"{path} is empty", "give a file with a line of headings", where)
    return [text.strip() for text in rows[0]], [(f"{path}:{line}", row) for line, row in enumerate(rows[1:], 2) if any(cell.strip() for cell in row)]


def read_probes(entry: Mapping[str, Any], where: str, folder: pathlib.Path, probes: Sequence[str]) -> list[Data]:
    """A [[fit.data]] of a steady case with a file of many probes: columns probe and temperature. Raises CaseError."""
    path = folder / entry["file"]
    headings, rows = read_rows(path, where)
    if len(headings) != 2 or headings[0] != "probe":
        raise refusal(f"{path} has the columns {', '.join(headings)}", "name the probe, or give a file with the columns probe and, say, T [K]", where)
    try:
        noise = quantities.in_unit(entry["noise"], "K", difference=True)
        factor, offset = quantities.converts(split_unit(headings[1])[1], "K", f"{path}:1")
    except CaseError as error:
        raise refusal(str(error), "correct it", where) from None
    if not noise > 0:
        raise refusal(f"a noise of {entry['noise']}", "give a standard deviation above 0", where)
    data = []
    for place, row in rows:
        try:
            name, value = row[0].strip(), float(row[1])
        except (ValueError, IndexError):
            raise refusal(f"{','.join(row)!r} is no probe with its temperature", "correct it, or leave the row out", place) from None
        if name not in probes:
            raise refusal(f"the case has no probe '{name}'", f"it has {', '.join(probes) or 'none'}", place)
        if not math.isfinite(value):
            raise refusal(f"{','.join(row)!r} is not finite", "leave the row out", place)
        data.append(Data(name, "probe", np.array([math.inf]), np.array([value * factor + offset]), noise, "K", place))
    if not data:
        raise refusal(f"{path} has no rows", "give measurements", where)
    return data


def read_data(entry: Mapping[str, Any], where: str, folder: pathlib.Path, end: float, probes: Sequence[str], numbers: Callable[[], Mapping[str, str]]) -> list[Data]:
    """One [[fit.data]]; `end` of the run, s, infinite of a steady case; `numbers` of the report with their units, asked for where
    one is measured. Raises CaseError with place and cure."""
    def refuse(problem: str, cure: str, place: str = where) -> CaseError:
        return refusal(problem, cure, place)

    if math.isinf(end) and "file" in entry and "probe" not in entry and "report" not in entry:
        return read_probes(entry, where, folder, probes)
    of_probe = "probe" in entry
    if of_probe == ("report" in entry):
        raise refuse("measurements of nothing, or of two things", "give either 'probe' or 'report'")
    name = entry["probe"] if of_probe else entry["report"]
    source = "probe" if of_probe else source_of(name)
    if source == "report" and ("file" in entry or "at" in entry):
        raise refuse(f"times of {name}, which is known of the whole run alone", "give one value, without a time")
    if of_probe and name not in probes:
        raise refuse(f"the case has no probe '{name}'", f"it has {', '.join(probes) or 'none'}")
    kind = "K" if of_probe else numbers()[name]
    try:
        noise = quantities.in_unit(entry["noise"], kind, difference=True)
        value = quantities.in_unit(entry["value"], kind) if "value" in entry else math.nan
        t = quantities.in_unit(entry["at"], "s") if "at" in entry else math.inf
    except CaseError as error:
        raise refuse(str(error), "correct it") from None
    if not noise > 0:
        raise refuse(f"a noise of {entry['noise']}", "give a standard deviation above 0")
    if ("value" in entry) == ("file" in entry):
        raise refuse("no measurements, or two kinds of them", "give either 'file' or 'value'")
    if "at" in entry and (math.isinf(end) or "file" in entry):
        raise refuse(f"a time of {entry['at']} in a {'steady case' if math.isinf(end) else 'file, which has its own'}", "leave 'at' out")
    if "value" in entry:
        if t != math.inf and not 0 <= t <= end:
            raise refuse(f"a time of {entry['at']} outside the run, which ends at {end:g} s", "give another, or a longer run")
        return [Data(name, source, np.array([t]), np.array([value]), noise, kind, where)]
    path = folder / entry["file"]
    written, rows = read_rows(path, where)
    headings = [split_unit(text) for text in written]
    names = [heading for heading, _ in headings]
    if "time" not in names:
        raise refuse(f"{path} has no column 'time'", f"it has {', '.join(written)}: name one 'time [s]'")
    wanted = split_unit(entry["column"])[0] if "column" in entry else None
    others = [n for n, heading in enumerate(names) if heading != "time"]
    columns = [n for n in others if names[n] == wanted] if wanted else others
    if len(columns) != 1:
        raise refuse(f"{path} has {'no such' if not columns else 'several'} columns{f' named {wanted}' if wanted else ''}",
                     f"take one of {', '.join(written[n] for n in others)} as 'column'")
    in_time, column = names.index("time"), columns[0]
    times: list[float] = []
    values: list[float] = []
    try:
        to_s = quantities.converts(headings[in_time][1], "s", f"{path}:1")
        to_unit = quantities.converts(headings[column][1], kind, f"{path}:1")
    except CaseError as error:
        raise refuse(str(error), "write it into the heading, as in 'tc1 [degC]'") from None
    for place, row in rows:
        try:
            at, measured = float(row[in_time]), float(row[column])
        except (ValueError, IndexError):
            raise refuse(f"{','.join(row)!r} is no row of numbers", "correct it, or leave the row out", place) from None
        if not (math.isfinite(at) and math.isfinite(measured)):
            raise refuse(f"{','.join(row)!r} is not finite", "leave the row out", place)
        at = at * to_s[0]
        if not 0 <= at <= end * (1 + 1e-9):
            raise refuse(f"a time of {at:g} s outside the run, which ends at {end:g} s", "leave the row out, or let the run last longer", place)
        times.append(at)
        values.append(measured * to_unit[0] + to_unit[1])
    if not times:
        raise refuse(f"{path} has no rows", "give measurements")
    return [Data(name, source, np.array(times), np.array(values), noise, kind, where)]
