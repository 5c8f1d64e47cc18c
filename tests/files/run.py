#!/usr/bin/python3
"""Opens result files with VTK and meshio: what others read of them, on one rank and on three.

  run.py CALOR

Without python3-vtk9 and python3-meshio of Debian it ends with code 77: skipped."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import meshio
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader
except ImportError as missing:
    print(f"skipped: {missing}; apt-get install python3-vtk9 python3-meshio")
    sys.exit(77)

CALOR = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
WALLS = """
[material.steel]
conductivity  = "40 W/(m K)"
density       = "7800 kg/m^3"
specific_heat = "500 J/(kg K)"
[initial]
temperature = "20 degC"
[boundary.hot]
on          = "xmin"
temperature = "200 degC"
[boundary.air]
on         = "xmax"
convection = { h = "200 W/(m^2 K)", ambient = "20 degC" }
[time]
end = "10 s"
"""
BLOCK = """title = "two parts of a block <&>"
method = "sph"
[cloud]
shape  = "box"
size   = ["30 mm", "20 mm", "10 mm"]
points = [7, 6, 5]
[material.aluminium]
conductivity  = "200 W/(m K)"
density       = "2700 kg/m^3"
specific_heat = "900 J/(kg K)"
[body]
along = "x"
[[body.layer]]
material  = "steel"
thickness = "12 mm"
[[body.layer]]
material  = "aluminium"
thickness = "18 mm"
""" + WALLS
PLATE = 'title = "plate"\nmethod = "sph"\n[cloud]\nshape = "box"\nsize = ["30 mm", "20 mm"]\npoints = [7, 6]\n' + WALLS
ROD = 'title = "rod"\nmethod = "sph"\n[cloud]\nshape = "box"\nsize = ["30 mm"]\npoints = [7]\n' + WALLS
BALL = """title = "ball"
method = "sph"
[cloud]
shape   = "surface"
spacing = "3 mm"
[[cloud.part]]
shape  = "sphere"
radius = "15 mm"
""" + WALLS.replace('"xmin"', '"surface"').partition("[boundary.air]")[0] + '[time]\nend = "1 s"\n'


def arrays(data):
    return {data.GetArrayName(n): vtk_to_numpy(data.GetArray(n)) for n in range(data.GetNumberOfArrays())}


def read(path):
    """A data set of VTK, and the arrays of its points, cells and field."""
    reader = vtkXMLGenericDataObjectReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    return grid, arrays(grid.GetPointData()), arrays(grid.GetCellData()), arrays(grid.GetFieldData())


class Files(unittest.TestCase):
    def run_case(self, text, ranks=1):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        case = pathlib.Path(folder.name) / "case.toml"
        case.write_text(text)
        subprocess.run([CALOR, "run", case, "-o", case.with_name("result"), "-j", str(ranks), "--quiet"], check=True)
        return case.with_name("result")

    def test_vtk_and_meshio_read_the_same_points(self):
        path = self.run_case(BLOCK) / "fields" / "fields_0001.vtu"
        grid, points, _, names = read(path)
        mesh = meshio.read(path)
        self.assertEqual(grid.GetNumberOfPoints(), 210)
        self.assertEqual([(block.type, len(block.data)) for block in mesh.cells], [("vertex", 210)])
        self.assertEqual(set(points), set(mesh.point_data))
        for name, values in points.items():
            np.testing.assert_array_equal(values, mesh.point_data[name])
        self.assertEqual(grid.GetPointData().GetScalars().GetName(), "temperature [K]")
        self.assertEqual({name: int(value[0]) for name, value in names.items() if name != "TimeValue"},
                         {"part steel": 0, "part aluminium": 1})
        np.testing.assert_array_equal(points["part"], np.where(mesh.points[:, 0] < 12e-3, 0, 1))
        self.assertAlmostEqual(points["volume [m^3]"].sum(), 6e-6, delta=1e-18)

    def test_several_ranks_write_what_one_writes(self):
        one, three = self.run_case(BLOCK), self.run_case(BLOCK, ranks=3)
        _, alone, _, _ = read(one / "fields" / "fields_0001.vtu")
        _, together, _, names = read(three / "fields" / "fields_0001.pvtu")
        self.assertEqual(set(alone), set(together))
        self.assertIn("part steel", names)
        for name in ("temperature [K]", "part", "volume [m^3]"):
            np.testing.assert_allclose(alone[name][np.argsort(alone["id"])], together[name][np.argsort(together["id"])], rtol=1e-12)
        sums = [arrays["heat flux into the body [W/m^2]"] @ arrays["area [m^2]"]
                for arrays in (read(one / "fields" / "surface_0001.vtp")[2], read(three / "fields" / "surface_0001.pvtp")[2])]
        self.assertAlmostEqual(*sums, delta=1e-9 * abs(sums[0]))

    def test_the_polygons_of_the_surface_have_the_areas_of_their_facets(self):
        for text, measure in ((BLOCK, "Area"), (PLATE, "Length"), (BALL, "Area")):
            with self.subTest(text[:20]):
                surface, _, facets, _ = read(self.run_case(text) / "fields" / "surface_0001.vtp")
                sizes = vtkCellSizeFilter()
                sizes.SetInputData(surface)
                sizes.Update()
                found = arrays(sizes.GetOutput().GetCellData())[measure]
                np.testing.assert_allclose(found, facets["area [m^2]"], rtol=1e-12)
                self.assertEqual(surface.GetCellData().GetScalars().GetName(), "temperature [K]")
        # Of a sphere the polygons lie on the surface, as far as they are flat.
        centres = np.array([np.mean([surface.GetPoint(4 * n + k) for k in range(4)], 0) for n in range(surface.GetNumberOfCells())])
        np.testing.assert_allclose(np.linalg.norm(centres, axis=1), 15e-3, rtol=0.03)
        np.testing.assert_allclose(np.linalg.norm(facets["normal"], axis=1), 1, rtol=1e-12)

    def test_the_surface_of_a_rod_is_its_ends(self):
        surface, _, facets, _ = read(self.run_case(ROD) / "fields" / "surface_0001.vtp")
        self.assertEqual(surface.GetNumberOfCells(), 2)
        np.testing.assert_allclose(sorted(surface.GetPoint(n)[0] for n in range(2)), [0, 30e-3])
        np.testing.assert_array_equal(facets["condition"], facets["face"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
