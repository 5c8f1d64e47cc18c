"""Many runs of a case with other values of its keys, in one table."""
from __future__ import annotations

import csv
import functools
import hashlib
import itertools
import json
import pathlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import certify, command, quantities
from .case import Case, files_of
from .command import CalorError, CaseError, CommandError, FileError, side_by_side
from .result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def samples(ranges: Mapping[str, Any], count: int, seed: int) -> list[dict[str, Any]]:
    """A Latin hypercube: every key has one value in each of `count` equal parts of its range."""
    random = np.random.default_rng(seed)
    columns: dict[str, list[Any]] = {}
    for key, limits in ranges.items():
        if not isinstance(limits, list) or len(limits) != 2:
            raise CommandError(f"the range of '{key}' is no [low, high]")
        low, unit = quantities.split(limits[0])
        high = quantities.in_unit(limits[1], unit)
        if not low < high:
            raise CommandError(f"the range of '{key}' has to rise, not go from {limits[0]} to {limits[1]}")
        places = (random.permutation(count) + random.random(count)) / count
        columns[key] = [quantities.joined(float(f"{low + (high - low) * place:.6g}"), unit) for place in places]
    return [dict(zip(columns, row)) for row in zip(*columns.values())]


def plan(asked: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The values of every run: all combinations of `values`, or their rows, each with all samples of `range`."""
    values, ranges = asked.get("values", {}), asked.get("range", {})
    if not values and not ranges:
        raise CommandError("the case has no [study.values] or [study.range], and no key was given: see docs/study.md")
    for key, one in values.items():
        if not isinstance(one, list) or not one:
            raise CommandError(f"the values of '{key}' are no list, or an empty one")
    lengths = {key: len(one) for key, one in values.items()}
    if asked.get("rows") and len(set(lengths.values())) > 1:
        raise CommandError(f"columns of a table are equally long, these are not: {', '.join(f'{key} {length}' for key, length in lengths.items())}")
    table = zip(*values.values()) if asked.get("rows") and values else itertools.product(*values.values())
    combinations = [dict(zip(values, row)) for row in table]
    count, seed = asked.get("samples", 20), asked.get("seed", 1)
    if count < 1 or seed < 0:
        raise CommandError(f"{count} samples, chosen by {seed}: take one or more, chosen by 0 or more")
    spread = samples(ranges, count, seed) if ranges else [{}]
    return [{**one, **other} for one in combinations for other in spread]


def mark_of(case: Case, digest: Callable[[pathlib.Path], str]) -> str:
    """Of a run: another one where anything that makes it differs, be it the case, what its files hold, or the program. Raises
    CalorError."""
    what = {name: part for name, part in case.to_dict().items() if name not in ("study", "fit", "optimise", "variant")}
    files = {name: digest(case.folder / name) for name in files_of(what, case.folder)}
    return hashlib.sha256(json.dumps([command.fingerprint(), what, files], sort_keys=True).encode()).hexdigest()[:16]


def digest_of(path: pathlib.Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass
class Study:
    """`rows`: of every run its number, the values of its keys and what came out; "failed" holds the error of one that
    did not end."""

    folder: pathlib.Path
    keys: list[str]
    rows: list[dict[str, Any]]
    reused: int

    @property
    def quantities(self) -> list[str]:
        return list(dict.fromkeys(name for row in self.rows for name in row if name not in ("run", "failed", *self.keys)))

    def write(self) -> pathlib.Path:
        path = self.folder / "study.csv"
        names = ["run", *self.keys, *self.quantities, *(["failed"] if any("failed" in row for row in self.rows) else [])]
        with path.open("w", newline="") as file:
            table = csv.DictWriter(file, names, restval="")
            table.writeheader()
            table.writerows(self.rows)
        return path

    def plot(self) -> Figure:
        """Every quantity that varies, over every key of numbers. Needs python3-matplotlib."""
        from . import figures
        return figures.varied(self)


def finished(folder: pathlib.Path) -> Result | None:
    """What a run has left that came to its end."""
    try:
        result = Result(folder)
    except FileError:
        return None
    return None if result.numbers.get("interrupted_by") else result


def study(case: Case | str, folder: str | pathlib.Path | None = None, *, values: Mapping[str, Any] | None = None, rows: bool = False, j: int = 1,
          say: Callable[[str], None] = lambda line: None) -> Study:
    """Runs what [study] asks for, `j` runs side by side; `values` stand in the place of its ranges, and besides its values. `rows`: lists
    of values are columns of a table, of which every row is run. Runs that lie in `folder` (default:
    results/NAME-study) from before with the same case, files and program are not run again. Writes study.csv. Raises CalorError."""
    base = case if isinstance(case, Case) else Case(case)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / f"{base.name}-study"
    written = base.to_dict()
    asked = dict(written.get("study", {}))
    asked["values"] = {**asked.get("values", {}), **(values or {})}
    asked["rows"] = rows or asked.get("rows", False)
    if values:
        asked.pop("range", None)
    try:
        runs = plan(asked)
    except CalorError as error:
        raise error if values else CaseError(f"{base.path or base.name}: {error}") from None
    keys = list(runs[0])
    into.mkdir(parents=True, exist_ok=True)
    reused = 0
    digest = functools.cache(digest_of)

    def run(number: int) -> dict[str, Any]:
        nonlocal reused
        case = base.changed(quantities.changes_at(written, runs[number]))
        row: dict[str, Any] = {"run": "", **runs[number]}
        try:
            place = into / f"run-{mark_of(case, digest)}"
            row["run"] = place.name
            result = finished(place)
            if result:
                reused += 1
            else:
                result = case.changed({"output.fields": False}).run(place, show_progress=False)
        except CalorError as error:
            row["failed"] = str(error)
            say(f"{number + 1} of {len(runs)} failed: {error}")
            return row
        found = certify.quantities_of(result)
        row |= {f"{name} [{quantity.unit}]": quantity.values[""][0] for name, quantity in found.items()}
        say(f"{number + 1} of {len(runs)}: " + ", ".join(f"{key.rsplit('.', 1)[-1]} = {value}" for key, value in runs[number].items()))
        return row

    table = side_by_side(run, range(len(runs)), j)
    done = Study(into, keys, table, reused)
    done.write()
    return done
