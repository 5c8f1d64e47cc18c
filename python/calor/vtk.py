"""Files of fields as VTK data sets."""
from __future__ import annotations

import functools
import pathlib
import xml.etree.ElementTree as xml
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .command import FileError


def read_vtk(path: pathlib.Path) -> Any:
    """Of a file of VTK in XML. Raises FileError."""
    from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader
    reader = vtkXMLGenericDataObjectReader()
    reader.SetFileName(str(path))
    reader.Update()
    dataset = reader.GetOutput()
    if dataset is None:
        raise FileError(f"{path}: VTK cannot read it")
    return dataset


def xdmf_entries(path: pathlib.Path) -> list[tuple[float, Callable[[], Any]]]:
    """The times of an XDMF file that calor has written, s, and what reads a data set of each. Raises FileError."""
    try:
        grids = [grid for grid in xml.parse(path).iter("Grid") if grid.get("GridType") == "Uniform"]
        times = [grid.find("Time") for grid in grids]
        return [(float(t.attrib["Value"]), functools.partial(read_grid, path, grid)) for t, grid in zip(times, grids) if t is not None]
    except (OSError, xml.ParseError, KeyError, ValueError) as error:
        raise FileError(f"{path}: {error}") from None


def read_grid(path: pathlib.Path, grid: xml.Element) -> Any:
    """A grid of one time: a vtkUnstructuredGrid of points, or vtkPolyData of facets. Needs python3-vtk9 and
    python3-h5py. Raises FileError."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import VTK_VERTEX, vtkCellArray, vtkPolyData, vtkUnstructuredGrid

    def array_of(element: xml.Element) -> npt.NDArray[Any]:
        return numbers(path.parent, element.findtext("DataItem", "").strip())

    topology, geometry = grid.find("Topology"), grid.find("Geometry")
    if topology is None or geometry is None:
        raise FileError(f"{path}: a grid has no topology or no geometry")
    corners = int(topology.attrib["NodesPerElement"])
    points = vtkPoints()
    points.SetData(numpy_to_vtk(array_of(geometry), deep=True))
    count = points.GetNumberOfPoints() // corners
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtkIdTypeArray(np.arange(0, corners * count + 1, corners), deep=True),
                  numpy_to_vtkIdTypeArray(np.arange(corners * count), deep=True))
    if grid.get("Name") == "fields":
        dataset = vtkUnstructuredGrid()
        dataset.SetCells(VTK_VERTEX, cells)
        data = dataset.GetPointData()
    else:
        dataset = vtkPolyData()
        {1: dataset.SetVerts, 2: dataset.SetLines, 4: dataset.SetPolys}[corners](cells)
        data = dataset.GetCellData()
    dataset.SetPoints(points)
    for attribute in grid.iter("Attribute"):
        data.AddArray(named(numpy_to_vtk(array_of(attribute), deep=True), attribute.attrib["Name"]))
    for meaning in grid.iter("Information"):
        dataset.GetFieldData().AddArray(named(numpy_to_vtk(np.array([int(meaning.attrib["Value"])]), deep=True),
                                              meaning.attrib["Name"]))
    return dataset


def named(array: Any, name: str) -> Any:
    array.SetName(name)
    return array


def numbers(folder: pathlib.Path, place: str) -> npt.NDArray[Any]:
    """The array at a place "FILE:/NAME". Raises FileError."""
    try:
        import h5py
    except ImportError:
        raise FileError("fields in HDF5 need h5py: apt-get install python3-h5py") from None
    file, _, name = place.partition(":")
    try:
        with h5py.File(folder / file) as data:
            return np.array(data[name])
    except (OSError, KeyError) as error:
        raise FileError(f"{folder / file}: {error}") from None
