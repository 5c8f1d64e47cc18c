"""Results: the folder that a run has written, as numpy arrays, VTK data sets, pictures and pages."""
from __future__ import annotations

import copy
import csv
import functools
import json
import os
import pathlib
import re
import xml.etree.ElementTree as xml
from collections.abc import Callable, Iterator, Mapping
from html import escape
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from .command import FileError
from .vtk import read_vtk, xdmf_entries

Array = npt.NDArray[Any]

if TYPE_CHECKING:
    import matplotlib.figure
    import pandas


def split_unit(heading: str) -> tuple[str, str]:
    """("hot", "K") of "hot [K]"; a unit may be empty."""
    match = re.fullmatch(r"(.*?) \[(.*)\]", heading)
    return (match[1], match[2]) if match else (heading, "")


# Units of temperatures that people read: sign, and what makes them of K.
DEGREES = {"K": ("K", 1.0, 0.0), "degC": ("°C", 1.0, -273.15), "degF": ("°F", 1.8, -459.67)}


class Table(Mapping[str, Array]):
    """Columns of numbers by name, without their units: table["hot"] is an array, table.units["hot"] is "K"."""

    def __init__(self, columns: Mapping[str, Array], units: Mapping[str, str]) -> None:
        self._columns, self.units = dict(columns), dict(units)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Table:
        """Of a CSV file with one line of headings. Raises FileError."""
        try:
            with open(path, newline="") as file:
                heading, *rows = csv.reader(file)
            data = np.array(rows, float).reshape(-1, len(heading))
        except (OSError, ValueError) as error:
            raise FileError(f"{path}: no table of numbers: {error}") from None
        names = [split_unit(text) for text in heading]
        return cls({name: data[:, n] for n, (name, _) in enumerate(names)}, dict(names))

    def __getitem__(self, name: str) -> Array:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"there is no '{name}'; there are {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def label(self, name: str) -> str:
        """With its unit, for an axis."""
        return f"{name} [{self.units[name]}]" if self.units.get(name) else name

    def in_degrees(self: TableLike, unit: str) -> TableLike:
        """The same with all temperatures in "K", "degC" or "degF"."""
        sign, factor, zero = DEGREES[unit]
        table = copy.copy(self)
        table._columns = {name: factor * values + zero if self.units[name] == "K" else values for name, values in self.items()}
        table.units = {name: sign if was == "K" else was for name, was in self.units.items()}
        return table

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with the units in its headings; the times are the index. Arrays of vectors become columns x, y, z."""
        import pandas
        columns = {}
        for name, values in self.items():
            if values.ndim == 1:
                columns[self.label(name)] = values
            else:
                columns |= {self.label(name).replace(name, f"{name} {axis}"): values[:, n] for n, axis in enumerate("xyz")}
        frame = pandas.DataFrame(columns)
        return frame.set_index(self.label("time")) if "time" in self else frame

    def __repr__(self) -> str:
        rows = len(next(iter(self.values()), ()))
        return f"<{type(self).__name__} of {rows} rows: {', '.join(map(self.label, self))}>"

    def _repr_html_(self) -> str:
        rows = len(next(iter(self.values()), ()))
        shown = [n for n in range(rows) if rows <= 10 or n < 5 or n >= rows - 5]
        plain = [name for name in self if self[name].ndim == 1]
        head = "".join(f"<th>{escape(self.label(name))}</th>" for name in plain)
        body = "".join("<tr>" + "".join(f"<td>{self[name][n]:.6g}</td>" for name in plain) + "</tr>" for n in shown)
        return f"<table><tr>{head}</tr>{body}</table><p>{rows} rows</p>"


TableLike = TypeVar("TableLike", bound=Table)


class Fields(Table):
    """Fields at the points, or at the facets of the surface, at one time: fields["temperature"].

    `t`: the time, s. `x`: places (n, 3), m; of facets their middles. `called`: what whole numbers stand for, e.g.
    called["part"] = {0: "steel"}. `dataset`: of VTK."""

    def __init__(self, dataset: Any, t: float, dimension: int) -> None:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        self.dataset, self.t, self.dimension = dataset, t, dimension
        on_cells = dataset.IsA("vtkPolyData")
        data = dataset.GetCellData() if on_cells else dataset.GetPointData()
        points = dataset.GetPoints()
        corners = vtk_to_numpy(points.GetData()) if points else np.empty((0, 3))
        # Every facet has its own corners, as many as all others.
        self.corners = corners.reshape(dataset.GetNumberOfCells(), -1, 3) if on_cells else None
        self.x = self.corners.mean(1) if on_cells else corners
        arrays = [data.GetArray(n) for n in range(data.GetNumberOfArrays())]
        names = [split_unit(array.GetName()) for array in arrays]
        super().__init__({name: vtk_to_numpy(array) for (name, _), array in zip(names, arrays)}, dict(names))
        self.called: dict[str, dict[int, str]] = {}
        field = dataset.GetFieldData()
        for n in range(field.GetNumberOfArrays()):
            label, _, name = field.GetArrayName(n).partition(" ")
            if name:
                self.called.setdefault(label, {})[int(field.GetArray(n).GetTuple1(0))] = name


class Result:
    """The result folder of a run. Numbers are in SI units; pictures and pages show temperatures in `temperature_unit`,
    "K", "degC" or "degF": that of [output], unless it is set to another."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = pathlib.Path(folder)
        try:
            self.report: dict[str, Any] = json.loads((self.folder / "report.json").read_text())
        except OSError:
            raise FileError(f"{self.folder}: there is no result: report.json is missing") from None
        except ValueError as error:
            raise FileError(f"{self.folder}/report.json: {error}") from None
        unit = self.report["case"].get("output", {}).get("temperature", "K")
        self.temperature_unit = unit if unit in DEGREES else "K"

    @property
    def temperature_unit(self) -> str:
        """The unit in which temperatures are shown. Raises ValueError for others than "K", "degC" and "degF"."""
        return self._temperature_unit

    @temperature_unit.setter
    def temperature_unit(self, unit: str) -> None:
        if unit not in DEGREES:
            raise ValueError(f"temperature_unit = {unit!r}: take one of {', '.join(DEGREES)}")
        self._temperature_unit = unit

    # What came out ---------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        return str(self.report["name"])

    @property
    def title(self) -> str:
        return str(self.report["case"].get("title", self.name))

    @property
    def passed(self) -> bool:
        """Did the run end, and hold all its [[expect]]s?"""
        return bool(self.report["passed"])

    @property
    def verdicts(self) -> list[dict[str, Any]]:
        """What became of every [[expect]]: what, error, tolerance, unit, passed."""
        expect: list[dict[str, Any]] = self.report["expect"]
        return expect

    @property
    def numbers(self) -> dict[str, float]:
        """Sizes, counts and the balance at the end."""
        numbers: dict[str, float] = self.report["numbers"]
        return numbers

    @property
    def units(self) -> dict[str, str]:
        """SI units of the numbers that have one."""
        units: dict[str, str] = self.report["units"]
        return units

    @property
    def dimension(self) -> int:
        return int(self.numbers["dimension"])

    def _table(self, name: str, wanted: str) -> Table:
        path = self.folder / f"{name}.csv"
        if not path.exists():
            raise FileError(f"{self.folder} has no {name}.csv: {wanted}")
        return Table.read(path)

    @functools.cached_property
    def probes(self) -> Table:
        """Temperatures at the probes over time, K."""
        return self._table("probes", "the case has no [probe]")

    @functools.cached_property
    def derivatives(self) -> dict[str, Table]:
        """Of the temperatures of the probes, K, and numbers of the balance, K or W, over time, by numbers of the case:
        derivatives["boundary.air.convection.h"]["tip"], over the unit in which the number stands there."""
        path = self.folder / "derivatives.csv"
        try:
            with open(path, newline="") as file:
                heading, *rows = csv.reader(file)
            of: dict[str, list[list[float]]] = {}
            for time, number, *values in rows:
                of.setdefault(number, []).append([float(time), *map(float, values)])
        except (OSError, ValueError) as error:
            raise FileError(f"{path}: no derivatives: {error}: ask for them by [output] derivatives") from None
        units = dict(split_unit(text) for text in [heading[0], *heading[2:]])
        return {number: Table(dict(zip(units, np.array(table).T)), units) for number, table in of.items()}

    @functools.cached_property
    def balance(self) -> Table:
        """Heat flows, W, and temperatures of materials and faces, K, over time."""
        return self._table("balance", "it is not a result of calor run")

    @functools.cached_property
    def energy(self) -> Table:
        """Heat stored and heat that came in, J, over time."""
        return self._table("energy", "a steady case keeps no account of heat")

    @functools.cached_property
    def weld(self) -> Table:
        """The sizes of the melt pool over time."""
        return self._table("weld", "the case has no [weld]")

    @functools.cached_property
    def cooling(self) -> dict[str, tuple[float, float]]:
        """Of a case with [weld] by probe: the highest temperature, K, and the time of cooling, s; NaN where there is none."""
        try:
            with open(self.folder / "cooling.csv", newline="") as file:
                _, *rows = csv.reader(file)
            return {probe: (float(peak), float((*time, "nan")[0] or "nan")) for probe, peak, *time in rows}
        except (OSError, ValueError) as error:
            raise FileError(f"{self.folder / 'cooling.csv'}: {error}: the case has no [weld] with probes") from None

    @functools.cached_property
    def stress(self) -> Table:
        """Lowest and highest stress of the section, Pa, its strain and curvature, 1/m, over time."""
        return self._table("stress", "the case has no [stress]")

    @functools.cached_property
    def section(self) -> Table:
        """Temperature, K, and stress, Pa, through the thickness at the end."""
        return self._table("section", "the case has no [stress]")

    @functools.cached_property
    def comparisons(self) -> dict[int, list[Table]]:
        """Calculated and expected values by the place of the [[expect]] in the case, from 0: one table a time of a line
        or field, one of all times of a probe."""
        found: dict[int, list[tuple[float, Table]]] = {}
        for path in self.folder.glob("expect-*.csv"):
            number, _, time = path.stem.removeprefix("expect-").partition("-")
            found.setdefault(int(number) - 1, []).append((float(time or 0), Table.read(path)))
        return {n: [table for _, table in sorted(tables, key=lambda entry: entry[0])] for n, tables in sorted(found.items())}

    @property
    def degrees(self) -> str:
        """The sign of the unit in which temperatures are shown."""
        return DEGREES[self.temperature_unit][0]

    def shown(self, table: TableLike) -> TableLike:
        """A table or fields of this result with the temperatures in their unit for pictures."""
        return table.in_degrees(self.temperature_unit)

    # Fields ----------------------------------------------------------------------------------------------------------

    def _entries(self, kind: str) -> list[tuple[float, Callable[[], Any]]]:
        """The times, s, and what reads a VTK data set of each."""
        if (self.folder / f"{kind}.xdmf").exists():
            return xdmf_entries(self.folder / f"{kind}.xdmf")
        try:
            entries = xml.parse(self.folder / f"{kind}.pvd").iter("DataSet")
        except OSError:
            raise FileError(f"{self.folder} has no {kind}.pvd: the case says fields = false") from None
        return [(float(entry.get("timestep", 0)), functools.partial(read_vtk, self.folder / entry.get("file", "")))
                for entry in entries]

    @functools.cached_property
    def times(self) -> Array:
        """At which there are fields, s."""
        return np.array([t for t, _ in self._entries("fields")])

    @property
    def has_fields(self) -> bool:
        return any((self.folder / f"fields.{suffix}").exists() for suffix in ("pvd", "xdmf")) and len(self.times) > 0

    def _read(self, kind: str, t: float | None) -> Fields:
        entries = self._entries(kind)
        if not entries:
            raise FileError(f"{self.folder} has no fields")
        wanted = entries[-1][0] if t is None else t
        at, read = min(reversed(entries), key=lambda entry: abs(entry[0] - wanted))
        if t is not None and not np.isclose(at, t, rtol=1e-9, atol=1e-12):
            raise ValueError(f"there are no fields at {t:g} s, but at {', '.join(f'{t:g}' for t, _ in entries)} s")
        return Fields(read(), at, self.dimension)

    def fields(self, t: float | None = None) -> Fields:
        """Fields at the points at a time of `times`, s; without one, at the end. Needs python3-vtk9. Raises ValueError
        where there is no such time."""
        return self._read("fields", t)

    def surface(self, t: float | None = None) -> Fields:
        """The same at the facets of the surface."""
        return self._read("surface", t)

    def vtk(self, t: float | None = None) -> Any:
        """The points with their fields as a vtkUnstructuredGrid."""
        return self.fields(t).dataset

    # Pictures and pages ----------------------------------------------------------------------------------------------

    def plot(self, what: str | None = None, **options: Any) -> matplotlib.figure.Figure:
        """A picture of the result: "probes", "section", "surface", "lines", "balance", "energy", "pool"; without a word
        the first that there is. Options: see calor.plot. Needs python3-matplotlib."""
        from . import plot
        return plot.figure(self, what, **options)

    def write_page(self, path: str | os.PathLike[str] | None = None) -> pathlib.Path:
        """The report as one page of HTML, by default FOLDER/report.html."""
        from . import page
        return page.write(self, path)

    def __repr__(self) -> str:
        return f"<Result {self.folder}: {'passed' if self.passed else 'NOT passed'}, {self.numbers['points']:g} points>"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{'&#10003;' if v['passed'] else '&#10007;'}</td><td>{escape(v['what'])}</td>"
                       f"<td>{number_text(v['error'])} {escape(v['unit'])}</td>"
                       f"<td>{number_text(v['tolerance'])} {escape(v['unit'])}</td></tr>" for v in self.verdicts)
        table = f"<table><tr><th></th><th>expectation</th><th>error</th><th>within</th></tr>{rows}</table>" if rows else ""
        about = f"{self.report['method']}, {self.numbers['points']:.0f} points, {self.report['integrator']}"
        return f"<b>{escape(self.title)}</b> ({escape(about)}) in {escape(str(self.folder))}{table}"


def is_straight(table: Table) -> bool:
    """Do the places of a table lie on one straight line?"""
    x = np.column_stack([table[axis] for axis in "xyz"])
    spread = np.linalg.svd(x - x.mean(0), compute_uv=False)
    return len(x) > 1 and spread[1] <= 1e-6 * spread[0]


def length_unit(x: Array) -> tuple[float, str]:
    """How many of which unit make a metre, for places of a body."""
    size = np.ptp(x, axis=0).max() if len(x) else 1
    return (1.0, "m") if size >= 1 else (1e3, "mm") if size >= 1e-4 else (1e6, "µm")


def number_text(value: float | None) -> str:
    """Three digits; what JSON cannot hold is null in the report."""
    return "?" if value is None else f"{value:.3g}"
