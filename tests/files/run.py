#!/usr/bin/python3
"""Opens result files with VTK and meshio: what others read of them, on one rank and on three.

  run.py CALOR

Without python3-vtk9, python3-meshio and python3-h5py of Debian it ends with code 77: skipped."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "python"))
try:
    import h5py
    import meshio
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader
    import calor
except ImportError as missing:
    print(f"skipped: {missing}; apt-get install python3-vtk9 python3-meshio python3-h5py")
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
    def run_case(self, text, ranks=1, more=(), codes=(0,)):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        case = pathlib.Path(folder.name) / "case.toml"
        case.write_text(text)
        return self.go_on(case.with_name("result"), ranks, more, codes)

    def go_on(self, result, ranks, more, codes=(0,)):
        done = subprocess.run([CALOR, "run", result.with_name("case.toml"), "-o", result, "-j", str(ranks), "--quiet", *more])
        self.assertIn(done.returncode, codes)
        return result

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

    def assert_same_fields(self, one, other):
        self.assertEqual(list(one.times), list(other.times))
        for t in one.times:
            # Several ranks have their own order of points and facets.
            for left, right in ((one.fields(t), other.fields(t)), (one.surface(t), other.surface(t))):
                self.assertEqual((set(left), left.units, left.called), (set(right), right.units, right.called))
                orders = [np.lexsort(fields.x.round(9).T) for fields in (left, right)]
                for name in left:
                    np.testing.assert_allclose(left[name][orders[0]], right[name][orders[1]], rtol=1e-9, atol=1e-9, err_msg=name)

    def test_xdmf_holds_what_vtk_holds(self):
        for text, ranks in ((BLOCK, 1), (BLOCK, 3), (PLATE, 2), (ROD, 3)):
            with self.subTest(text[:20], ranks=ranks):
                vtk, xdmf = self.run_case(text), self.run_case(text, ranks, ["output.format=xdmf"])
                self.assertFalse((xdmf / "fields.pvd").exists())
                self.assert_same_fields(calor.Result(vtk), calor.Result(xdmf))
                with h5py.File(xdmf / "fields" / "fields_0001.h5") as data:
                    self.assertEqual(data["fields/temperature"].attrs["unit"], b"K")
                    self.assertEqual(data["fields/temperature"].compression, "gzip")

    def test_xdmf_goes_on_on_other_ranks(self):
        steps = ["output.format=xdmf", "output.times=[\"2 s\", \"6 s\"]", "time.step=\"10 ms\""]
        whole = self.run_case(BLOCK, 1, steps)
        parts = self.run_case(BLOCK, 2, [*steps, "--time-limit", "1ms"], codes=(75,))
        self.go_on(parts, 3, [*steps, "--restart"])
        self.assert_same_fields(calor.Result(whole), calor.Result(parts))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
