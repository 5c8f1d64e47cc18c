#!/usr/bin/python3
"""The Python package: cases, runs, results, errors, pictures.

  run.py CALOR

Without python3-numpy, python3-vtk9 or python3-matplotlib of Debian it ends with code 77: skipped."""
import copy
import base64
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
try:
    import matplotlib
    import numpy as np
    import matplotlib.pyplot  # noqa: F401
    import vtkmodules.vtkIOXML  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing}; apt-get install python3-numpy python3-vtk9 python3-matplotlib")
    sys.exit(77)

matplotlib.use("Agg")

from calor import (CalorError, Case, CaseError, CommandError, FileError, NumbersError, Result, certify, command, convergence, fit, interfaces,  # noqa: E402
                   optimise, plot, quantities, refine, sobol, stress, study, toml, twin)  # noqa: E402

if len(sys.argv) > 1:
    CALOR = str(pathlib.Path(sys.argv[1]).resolve())
    command.find_command = lambda: CALOR

PLATE = {
    "title": "Plate", "method": "sph",
    "cloud": {"shape": "box", "size": ["20 mm", "10 mm"], "points": [11, 6]},
    "material": {"steel": {"conductivity": "40 W/(m K)", "density": "7850 kg/m^3", "specific_heat": "470 J/(kg K)"}},
    "initial": {"temperature": "20 degC"},
    "boundary": {"heater": {"on": "xmin", "flux": "20 kW/m^2"},
                 "air": {"on": "xmax", "convection": {"h": "200 W/(m^2 K)", "ambient": "20 degC"}}},
    "time": {"end": "20 min"}, "output": {"every": "10 min", "temperature": "degC"},
    "probe": {"hot": ["0 mm", "5 mm"], "cold": ["20 mm", "5 mm"]},
}


def merge(case, changes):
    """Puts values at dotted keys into a case, right or wrong."""
    for path, value in changes.items():
        *sections, last = path.split(".")
        table = case
        for section in sections:
            table = table.setdefault(section, {})
        table[last] = copy.deepcopy(value)


SHARED = tempfile.TemporaryDirectory()


def shared(case):
    """The result of a case, run once for all tests that only read it."""
    folder = pathlib.Path(SHARED.name) / case["title"]
    return Result(folder) if folder.exists() else Case(case).run(folder)


class Package(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)

    def test_a_dictionary_is_run_and_leaves_nothing_but_its_result(self):
        result = Case(PLATE).run()
        self.assertEqual(os.listdir(), ["results"])
        self.assertEqual(result.folder, pathlib.Path("results/plate"))
        self.assertTrue(result.passed)
        self.assertEqual(result.numbers["points"], 66)
        # What came in is what is stored: 20 kW/m^2 on 10 mm x 1 m, less what the air took.
        stored, heater, air = (result.energy[name][-1] for name in ("stored", "through heater", "through air"))
        self.assertAlmostEqual(heater, 20e3 * 10e-3 * 1200, places=6)
        self.assertAlmostEqual(stored, heater + air, delta=1e-9 * heater)
        self.assertEqual(result.probes.units["hot"], "K")
        self.assertGreater(result.probes["hot"][-1], result.probes["cold"][-1])
        self.assertEqual(result.probes["time"][-1], 1200)

    def test_names_with_commas_and_quotes_are_columns(self):
        result = Case({**PLATE, "source": {'a, "b"': {"power": "1 W"}}}).run()
        self.assertAlmostEqual(result.balance['heat flow from a, "b"'][-1], 1)
        self.assertAlmostEqual(result.energy['from a, "b"'][-1], 1200)
        self.assertAlmostEqual(result.energy['asked of a, "b"'][-1], 1)

    def test_a_file_is_changed_by_keywords_and_dotted_keys(self):
        pathlib.Path("plate.toml").write_text(toml.write(PLATE))
        case = Case("plate.toml", {"cloud.points": [5, 3], "boundary": {"heater": {"flux": "0 W/m^2"}}}, method="mlpg")
        result = case.run("there", j=2)
        self.assertEqual((result.report["method"], result.numbers["points"], result.numbers["ranks"]), ("mlpg", 15, 2))
        np.testing.assert_allclose(result.fields()["temperature"], 293.15, rtol=1e-12)
        self.assertEqual(case.to_dict()["boundary"]["heater"], {"on": "xmin", "flux": "0 W/m^2"})
        self.assertEqual(Case("plate.toml").to_dict(), PLATE)
        self.assertRegex(case.check(), r"points +15 in 2D")

    def test_a_case_is_a_dictionary_as_a_run_sees_it(self):
        variants = [{"name": "steady", "remove": ["time"], "set": {"steady": {}, "cloud": {"spacing": "1 mm"}}}]
        pathlib.Path("plate.toml").write_text(toml.write({**PLATE, "variant": variants}))
        for case in (Case("plate.toml", variant="steady"), Case("plate.toml", ["variant=steady"]), Case({**PLATE, "variant": variants}, variant="steady")):
            seen = case.to_dict()
            # A spacing stands in the place of counts, the other keys of the section stay.
            self.assertEqual(seen["cloud"], {"shape": "box", "size": ["20 mm", "10 mm"], "spacing": "1 mm"})
            self.assertEqual((seen["steady"], "time" in seen, "variant" in seen), ({}, False, False))
        self.assertEqual(Case("plate.toml").to_dict()["variant"], variants)
        function = {"formula": "54 - 0.03*(T - 293)", "unit": "W/(m K)"}
        changed = Case("plate.toml", {"material": {"steel": {"conductivity": function}}}, time={"tolerance": "1 K"}).changed(time={"end": "5 s"})
        self.assertEqual(changed.to_dict()["material"]["steel"], {**PLATE["material"]["steel"], "conductivity": function})
        self.assertEqual(changed.to_dict()["time"], {"end": "5 s", "tolerance": "1 K"})
        self.assertEqual(Case(PLATE, title="Other plate").name, "other-plate")
        with self.assertRaisesRegex(CommandError, "parameter.p is too long for the command line .*write it into the case"):
            Case(PLATE, {"parameter.p": [0.5] * 40000}).to_dict()

    def test_numbers_of_the_report_are_known_before_the_run_with_their_units(self):
        for case in (Case(PLATE), Case({**{key: value for key, value in PLATE.items() if key not in ("time", "initial")}, "steady": {}, "output": {}}), Case(ROOT / "cases/fit/weld.toml", {"time.end": "0.1 s"})):
            result = case.changed({"expect": []}).run("once", show_progress=False)
            self.assertEqual(set(case.numbers()), set(result.numbers))
            self.assertEqual({name: unit for name, unit in case.numbers().items() if unit}, result.units)
        # Sizes of a melt and of supports both are "largest": only the one that gives the number knows its unit.
        self.assertLessEqual({("largest_width", "m"), ("largest_step", "s"), ("average_temperature", "K"), ("stored", "J"), ("pairs", "")}, set(case.numbers().items()))

    def test_units_are_those_of_the_command(self):
        # By definition: an inch is 25.4 mm, a day 86400 s, 32 degF and 491.67 degR are 273.15 K.
        for quantity, unit, value in (("2 inch", "m", 0.0508), ("0.5 day", "s", 43200), ("32 degF", "K", 273.15), ("491.67 degR", "K", 273.15),
                                      ("5 W/(mm K)", "W/(m K)", 5000), ("300 K", "degC", 26.85), (2, "", 2), ("5 %", "", 0.05)):
            self.assertAlmostEqual(quantities.in_unit(quantity, unit), value, places=10)
        self.assertAlmostEqual(quantities.in_unit("9 degF", "K", difference=True), 5)
        for quantity, unit, words in (("5 m", "K", "5 m: 'm' cannot be converted to 'K'"), ("5", "K", "the unit is missing"), ("5 K", "", "without unit")):
            with self.assertRaisesRegex(CaseError, words):
                quantities.in_unit(quantity, unit)

    def test_a_case_is_the_same_through_a_file(self):
        whole = {**PLATE, "expect": [{"probe": "hot", "value": "1 K", "within": "50 %"}, {"report": "steps", "at_least": 1}],
                 "material": {"a b": {"conductivity": {"formula": "2 + \"x\"", "unit": "W/(m K)"}, "density": 1.5e-9}}}
        self.assertEqual(tomllib.loads(toml.write(whole)), whole)

    def test_fields_have_names_units_places_and_their_time(self):
        result = shared(PLATE)
        np.testing.assert_array_equal(result.times, [0, 600, 1200])
        fields = result.fields(600)
        self.assertEqual((fields.t, fields.x.shape, fields.units["heat flux"]), (600, (66, 3), "W/m^2"))
        self.assertEqual(fields.called["part"], {0: "steel"})
        self.assertAlmostEqual(fields["volume"].sum(), 20e-3 * 10e-3)
        surface = result.surface()
        self.assertEqual(surface.called["condition"], {0: "heater", 1: "air"})
        through_heater = surface["condition"] == 0
        np.testing.assert_allclose(surface["heat flux into the body"][through_heater], 20e3, rtol=1e-12)
        np.testing.assert_allclose(surface.x[through_heater, 0], 0, atol=1e-15)
        self.assertEqual(result.vtk().GetNumberOfPoints(), 66)
        with self.assertRaisesRegex(ValueError, "at 0, 600, 1200 s"):
            result.fields(7)

    def test_pictures_have_the_unit_of_temperatures_that_is_asked_for(self):
        result = shared(PLATE)  # whose [output] says degC
        shown = result.shown(result.probes)
        np.testing.assert_allclose(shown["hot"], result.probes["hot"] - 273.15)
        self.assertEqual((shown.units["hot"], result.probes.units["hot"], result.degrees), ("°C", "K", "°C"))
        np.testing.assert_array_equal(shown["time"], result.probes["time"])
        result.temperature_unit = "degF"
        np.testing.assert_allclose(result.shown(result.probes)["hot"], 32 + 1.8 * shown["hot"])
        with self.assertRaisesRegex(ValueError, "degX"):
            result.temperature_unit = "degX"
        self.assertEqual(shared(RING).degrees, "K")

    def test_an_error_in_a_file_says_file_line_column_and_key(self):
        text = toml.write(PLATE).replace('flux = "20 kW/m^2"', 'flux = "20 kW/m"')
        pathlib.Path("plate.toml").write_text(text)
        with self.assertRaises(CaseError) as caught:
            Case("plate.toml").run()
        line = 1 + text[:text.index("flux")].count("\n")
        self.assertEqual((caught.exception.file, caught.exception.line, caught.exception.key), ("plate.toml", line, "boundary.heater.flux"))
        self.assertGreater(caught.exception.column, 1)
        self.assertIn("20 kW/m", str(caught.exception))

    def test_an_error_in_a_change_names_its_key(self):
        pathlib.Path("plate.toml").write_text(toml.write(PLATE))
        with self.assertRaises(CaseError) as caught:
            Case("plate.toml", method="spf").run()
        self.assertEqual((caught.exception.key, caught.exception.file), ("method", None))

    def test_an_error_in_a_dictionary_names_its_key(self):
        with self.assertRaises(CaseError) as caught:
            Case(PLATE, {"boundary.air.convection.h": "-"}).run()
        self.assertEqual(caught.exception.key.split(".")[:2], ["boundary", "air"])
        self.assertEqual(os.listdir(), [])

    def test_other_errors_have_their_own_kind(self):
        with self.assertRaises(FileError):
            Case("nothing.toml").run()
        with self.assertRaises(FileError):
            Result("nothing")
        with self.assertRaises(NumbersError):
            Case(PLATE, {"material.steel.conductivity": {"formula": "310 - T", "unit": "W/(m K)"}}).run()
        self.assertTrue(issubclass(NumbersError, CalorError))
        with self.assertRaisesRegex(CommandError, "^-j: .*0"):
            Case(PLATE).run(j=0)

    def test_a_failed_expectation_is_a_result(self):
        result = Case({**PLATE, "expect": [{"probe": "cold", "value": "0 degC", "within": "1 K"}]}).run()
        self.assertFalse(result.passed)
        self.assertFalse(result.verdicts[0]["passed"])
        self.assertIn("&#10007;", result._repr_html_())
        table, = result.comparisons[0]
        self.assertEqual((table["time"][-1], table["reference"][-1]), (1200, 273.15))

    def test_a_steady_case_has_one_time(self):
        steady = {key: value for key, value in PLATE.items() if key not in ("time", "initial", "output")} | {"steady": {}}
        result = Case(steady).run()
        self.assertEqual(len(result.times), 1)
        # The flux leaves through the air: 100 K above it, and 10 K through the plate.
        np.testing.assert_allclose([result.probes["cold"][-1], result.probes["hot"][-1]], [393.15, 403.15], rtol=1e-9)

    def test_progress_is_told_while_a_run_goes_on(self):
        told = []

        def tell(part, line):
            told.append((part, line))
            if len(told) == 2:  # as long as it takes on any machine, and no longer
                raise KeyboardInterrupt

        case = Case(PLATE, {"time": {"integrator": "euler", "step": "0.05 ms"}})
        with case._words() as words, self.assertRaises(KeyboardInterrupt):
            command.run(["run", *words, "-o", "result"], tell)
        self.assertEqual([part for part, _ in told], sorted(part for part, _ in told))
        self.assertIn("left", told[-1][1])

    def test_a_notebook_shows_a_bar_that_goes_away(self):
        from unittest import mock
        from calor import progress
        shown = []

        class Handle:
            def update(self, what):
                shown.append(what)

        display = mock.Mock(HTML=str, display=lambda what, display_id: Handle())
        shell = mock.Mock(**{"get_ipython.return_value.has_trait.return_value": True})
        with mock.patch.dict(sys.modules, {"IPython": shell, "IPython.display": display}), progress.bar(None) as show:
            show(0.25, "t = 5 s <b>")
        self.assertIn('value="0.25"', shown[0])
        self.assertIn("25 % t = 5 s &lt;b&gt;", shown[0])
        self.assertEqual(shown[-1], "")

    def test_an_interrupted_run_has_its_pictures_and_its_page(self):
        pathlib.Path("case.toml").write_text(toml.write({**PLATE, "time": {"end": "1e5 s", "integrator": "euler", "step": "1 ms"}}))
        run = subprocess.Popen([CALOR, "run", "case.toml", "-o", "result", "--quiet"])
        while run.poll() is None and not pathlib.Path("result/fields/fields_0000.vtu").exists():
            time.sleep(0.02)
        run.terminate()
        self.assertEqual(run.wait(), 143)
        result = Result("result")
        self.assertFalse(result.passed)
        self.assertIn("interrupted", result.write_page().read_text())
        matplotlib.pyplot.close(result.plot("section"))

    def test_without_fields_there_are_curves(self):
        result = Case(PLATE, {"output.fields": False}).run()
        self.assertFalse(result.has_fields)
        self.assertIn('class="chart"', result.write_page().read_text())
        with self.assertRaisesRegex(FileError, "fields = false"):
            result.fields()

    def test_tables_become_data_frames(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("python3-pandas is missing")
        result = shared(PLATE)
        frame = result.probes.to_pandas()
        self.assertEqual(list(frame.columns), ["hot [K]", "cold [K]"])
        self.assertEqual(frame.index[-1], 1200)
        self.assertIn("heat flux x [W/m^2]", result.fields().to_pandas().columns)


RING = {
    "title": "Ring", "method": "sph", "steady": {},
    "cloud": {"shape": "surface", "spacing": "1 mm", "part": [{"shape": "annulus", "inner": "10 mm", "outer": "20 mm"}]},
    "material": {"steel": {"conductivity": "40 W/(m K)"}},
    "boundary": {"inner": {"on": "inner", "temperature": "400 K"}, "outer": {"on": "outer", "temperature": "300 K"}},
}
BLOCK = {**{key: value for key, value in RING.items() if key not in ("cloud", "boundary")}, "title": "Block",
         "cloud": {"shape": "box", "size": ["8 mm", "6 mm", "4 mm"], "points": [9, 7, 5]},
         "boundary": {"a": {"on": "zmin", "temperature": "300 K"}, "b": {"on": "zmax", "temperature": "340 K"}}}


def area_of(mesh):
    """Of the triangles that are shown."""
    a, b, c = (np.column_stack([mesh.x, mesh.y])[mesh.get_masked_triangles()[:, n]] for n in range(3))
    return 0.5 * abs(np.cross(b - a, c - a)).sum()


class Pictures(unittest.TestCase):
    setUp = Package.setUp

    def test_triangles_cover_the_body_and_leave_its_holes(self):
        from calor import plot
        fields = shared(RING).fields()
        mesh = plot.triangles(fields, shared(RING).surface(), np.arange(len(fields.x)), [0, 1], 1)
        area = np.pi * (20e-3**2 - 10e-3**2)
        self.assertAlmostEqual(area_of(mesh), area, delta=0.01 * area)

    def test_no_triangle_crosses_a_crack(self):
        from calor import plot
        case = {**PLATE, "crack": [{"x": ["10 mm", "10 mm"], "y": ["0 mm", "20 mm"]}], "cloud": {**PLATE["cloud"], "points": [10, 6]}}
        result = Case(case).run()
        cracks = plot.cracks_of(result)
        np.testing.assert_allclose(cracks, [[[10e-3, 0], [10e-3, 20e-3]]])
        fields = result.fields()
        mesh = plot.triangles(fields, result.surface(), np.arange(len(fields.x)), [0, 1], 1, cracks)
        x = fields.x[mesh.get_masked_triangles(), 0]
        self.assertGreater(len(x), 0)
        self.assertTrue(((x < 10e-3).all(1) | (x > 10e-3).all(1)).all())

    def test_no_triangle_crosses_a_gap_however_narrow(self):
        from calor import plot
        below, above = ({"shape": "rectangle", "size": ["20 mm", "5 mm"], "at": ["0 mm", y], "name": name}
                        for name, y in (("below", "0 mm"), ("above", "5.1 mm")))
        result = Case({**RING, "title": "Gap", "cloud": {"shape": "surface", "spacing": "1 mm", "part": [below, above]},
                       "boundary": {"cold": {"on": "below.ymin", "temperature": "300 K"}, "hot": {"on": "above.ymax", "temperature": "400 K"}}}).run()
        fields = result.fields()
        mesh = plot.triangles(fields, result.surface(), np.arange(len(fields.x)), [0, 1], 1)
        y = fields.x[mesh.get_masked_triangles(), 1]
        self.assertAlmostEqual(area_of(mesh), 2 * 20e-3 * 5e-3, delta=1e-9)
        self.assertTrue(((y < 5.05e-3).all(1) | (y > 5.05e-3).all(1)).all())

    def test_a_section_has_the_temperatures_of_its_plane(self):
        from calor import plot
        fields = shared(BLOCK).fields()
        for z in (1e-3, 1.3e-3, 2e-3):  # on points and between
            np.testing.assert_allclose(plot.in_section(fields, "temperature", ("z", z)), 300 + 1e4 * z, atol=1e-6)
        with self.assertRaisesRegex(CalorError, "from 0 to 0.004 m"):
            plot.cut(fields, ("z", 1.0))

    def test_every_result_has_its_pictures(self):
        from calor import plot
        for case, expected in ((PLATE, {"section", "probes", "balance", "energy"}), (BLOCK, {"section", "surface", "balance"}),
                               (RING, {"section", "balance"})):
            drawn = plot.pictures(shared(case), dark=case is RING)
            self.assertEqual(set(drawn), expected)
            for figure in drawn.values():
                for axes in figure.axes[:1]:
                    self.assertRegex(axes.get_xlabel(), r"\[.+\]")
                matplotlib.pyplot.close(figure)

    def test_the_command_draws_and_refuses(self):
        shutil.copytree(shared(PLATE).folder, "plate")
        said = subprocess.run([CALOR, "plot", "plate", "probes", "--time", "600", "section", "--format", "svg"], capture_output=True, text=True)
        self.assertEqual((said.returncode, said.stdout.splitlines()), (0, ["plate/pictures/probes.svg", "plate/pictures/section.svg"]), said.stderr)
        self.assertIn("Plate", pathlib.Path("plate/pictures/section.svg").read_text())
        for words, code, text in ((["nothing"], 4, "report.json is missing"), (["plate", "tea"], 2, "there is no picture 'tea'"),
                                  (["plate", "section", "--field", "colour"], 2, "there is no field 'colour'"),
                                  (["plate", "section", "--time", "7"], 2, "at 0, 600, 1200 s"),
                                  (["plate", "--drak", "section"], 2, "unrecognized arguments: --drak")):
            said = subprocess.run([CALOR, "plot", *words], capture_output=True, text=True)
            self.assertEqual(said.returncode, code, said.stderr)
            self.assertIn(text, said.stderr)

    def test_the_command_names_the_package_that_is_missing(self):
        shared(PLATE)
        for module, package in (("numpy", "python3-numpy"), ("matplotlib", "python3-matplotlib"), ("vtkmodules", "python3-vtk9")):
            pathlib.Path("sitecustomize.py").write_text(f"import sys\nsys.modules[{module!r}] = None\n")
            said = subprocess.run([CALOR, "plot", shared(PLATE).folder, "section"], capture_output=True, text=True,
                                  env={**os.environ, "PYTHONPATH": ".", "PYTHONDONTWRITEBYTECODE": "1"})
            self.assertEqual(said.returncode, 2, said.stderr)
            self.assertRegex(said.stderr, rf"^calor.* needs? {package}: apt-get install {package}\n$")

    def test_a_film_has_a_picture_a_time(self):
        from PIL import Image
        from calor import film
        film.animate(shared(PLATE), pathlib.Path("film.gif"))
        with Image.open("film.gif") as frames:
            self.assertEqual(frames.n_frames, 3)
        with matplotlib.rc_context({"animation.ffmpeg_path": "none such"}), self.assertRaisesRegex(CalorError, "apt-get install ffmpeg"):
            film.animate(shared(PLATE), pathlib.Path("film.mp4"))


class Page(unittest.TestCase):
    setUp = Package.setUp

    def page(self, case):
        self.result = shared(case)
        path = self.result.write_page()
        self.assertEqual(path, self.result.folder / "report.html")
        text = path.read_text()
        return text, json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)[1])

    def test_a_page_holds_everything_it_shows(self):
        text, _ = self.page(PLATE)
        self.assertEqual(re.findall(r"<(?:link|img|iframe)|\bsrc=|url\(|@import|fetch\(|XMLHttpRequest", text), [])
        self.assertNotIn("{{", text)
        for words in ("Plate", "heat flow through heater", "calor run", "conductivity = &quot;40 W/(m K)&quot;", "petsc 3."):
            self.assertIn(words, text)

    def test_what_a_case_is_called_cannot_break_its_page(self):
        text, data = self.page({**PLATE, "title": "<b>a & \"b\"", "probe": {"</script>": ["0 mm", "5 mm"]}})
        self.assertIn("<h1>&lt;b&gt;a &amp; &quot;b&quot;</h1>", text)
        self.assertEqual(text.count("</script>"), 3)
        self.assertEqual(data["charts"][0]["series"][0]["label"], "</script>")

    def test_the_fields_of_a_page_are_those_of_the_result(self):
        _, data = self.page(BLOCK)
        cloud, fields = data["cloud"], self.result.fields()
        unpack = lambda text, kind: np.frombuffer(base64.b64decode(text), kind)  # noqa: E731
        np.testing.assert_allclose(unpack(cloud["x"], "<f4").reshape(-1, 3), fields.x, atol=1e-9)
        temperature = cloud["fields"][0]
        self.assertEqual((temperature["label"], len(temperature["values"])), ("temperature [K]", 1))
        span = temperature["high"] - temperature["low"]
        found = temperature["low"] + span * unpack(temperature["values"][0], "<u2") / 65535
        np.testing.assert_allclose(found, fields["temperature"], atol=span / 65535)
        self.assertAlmostEqual(span, 40, places=6)

    def test_of_too_many_points_the_surface_is_shown_first(self):
        from unittest import mock
        from calor import page
        fields, surface = shared(BLOCK).fields(), np.unique(shared(BLOCK).surface()["point"])
        inside = len(fields.x) - len(surface)
        with mock.patch.object(page, "MOST_POINTS", len(surface) + 20):
            rows, sizes = page.shown_points(fields, surface)
        self.assertEqual(len(rows), len(surface) + 20)
        is_outside = np.isin(fields["id"][rows], surface)
        self.assertEqual(is_outside.sum(), len(surface))
        np.testing.assert_allclose(sizes[is_outside], 1e-3)
        np.testing.assert_allclose(sizes[~is_outside], 1e-3 * (inside / 20) ** (1 / 3))

    def test_curves_of_a_page_go_through_the_rows_of_the_tables(self):
        text, data = self.page({**PLATE, "title": "Expecting", "expect": [{"probe": "hot", "value": "380 K", "at": ["10 min", "20 min"], "within": "90 %"}]})
        chart = data["charts"][0]
        self.assertEqual([series["label"] for series in chart["series"]], ["hot", "cold", "hot, expected"])
        np.testing.assert_allclose(chart["columns"][0], self.result.probes["time"], rtol=1e-6)
        np.testing.assert_allclose(chart["columns"][1], self.result.probes["hot"] - 273.15, rtol=1e-6)
        self.assertEqual([value for value in chart["columns"][3] if value is not None], [106.85, 106.85])
        self.assertEqual(chart["y"], "T [°C]")
        for one in data["charts"]:
            self.assertIn(f'<div id="{one["id"]}">', text)

    def test_a_browser_draws_the_page(self):
        browser = shutil.which("chromium")
        if not browser:
            self.skipTest("chromium is missing")
        text, data = self.page(BLOCK)
        path = self.result.folder / "report.html"
        path.write_text(text.replace("</body>", "<script>document.title = `${document.querySelectorAll('.uplot').length} charts, `"
                                     " + `${document.querySelectorAll('#ticks span').length > 2} ${document.querySelector('#probe').textContent}`</script></body>"))
        said = subprocess.run([browser, "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                               f"--user-data-dir={os.getcwd()}/browser", "--virtual-time-budget=3000", "--dump-dom", f"file://{path.resolve()}"],
                              capture_output=True, text=True, timeout=100)
        self.assertIn(f"<title>{len(data['charts'])} charts, true </title>", said.stdout, said.stderr[-2000:])


class Certificates(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)

    def test_the_limit_of_a_smooth_sequence_lies_within_its_bar(self):
        # f = 300 + c h^p + d h^(p + 1), whose last term disturbs the observed order.
        inside, total = 0, 0
        for p in (1.0, 1.5, 2.0, 3.0):
            for c in (-7.0, 0.5, 20.0):
                for d in (-0.4, -0.1, 0.2, 0.5):
                    for h in ([1, 1 / 1.5, 1 / 2], [1, 1 / 1.5, 1 / 2, 1 / 3], [1 / 2, 1 / 3, 1 / 4, 1 / 6]):
                        f = [300 + c * s**p * (1 + d * s) for s in h]
                        one = convergence.limit(h, f, 1e-9)
                        if one.is_asymptotic:
                            total += 1
                            inside += abs(one.value - 300) <= one.bar
        self.assertGreaterEqual(inside, 0.95 * total)
        self.assertGreaterEqual(total, 100)

    def test_what_does_not_converge_is_not_certified(self):
        h = [1, 1 / 2, 1 / 4]
        for f in ([1.0, 1.2, 1.1], [1.0, 1.1, 1.25], [5.0, 3.0, 2.9999]):
            one = convergence.limit(h, f, 1e-9)
            self.assertFalse(one.is_asymptotic, f)
            self.assertIn("the last two refinements changed it by", one.reason)

    def test_of_random_points_the_bar_holds_the_last_three_changes(self):
        # Two refinements that change little by chance neither shrink the bar nor count as a failure to converge.
        h = [1, 1 / 2, 1 / 3, 1 / 4, 1 / 6]
        one = convergence.limit_of_random_points(h, [1.4, 1.1, 1.14, 1.1401, 1.1402], 1e-9)
        self.assertTrue(one.is_asymptotic)
        self.assertAlmostEqual(one.bar, 0.04 * 3 / 6)
        self.assertTrue(convergence.limit_of_random_points(h, [1.4, 1.1, 1.14, 1.141, 1.144], 1e-9).is_asymptotic)
        self.assertFalse(convergence.limit_of_random_points(h, [1.4, 1.1, 1.14, 1.1, 1.2], 1e-9).is_asymptotic)

    def test_values_that_no_refinement_changes_are_exact(self):
        one = convergence.limit([1, 1 / 2, 1 / 4], [400.0, 400.0 + 1e-10, 400.0 - 1e-10], 4e-7)
        self.assertTrue(one.is_asymptotic)
        self.assertLess(one.bar, 1e-6)

    def test_methods_that_converge_to_different_limits_are_not_certified(self):
        h = [1, 1 / 2, 1 / 4, 1 / 8]
        limits = [convergence.limit(h, [value + s**2 for s in h], 1e-9) for value in (300.0, 300.5)]
        self.assertIn("the methods' limits differ by 0.5", convergence.together(limits).reason)
        self.assertTrue(convergence.together(limits[:1]).certified)

    def test_a_limit_with_a_wide_bar_does_not_widen_that_of_a_sure_one(self):
        limits = [convergence.Limit(300.0, 0.01, 2), convergence.Limit(300.5, 1.0, 2)]
        self.assertLess(convergence.together(limits).bar, 0.011)
        self.assertAlmostEqual(convergence.together(limits, are_extrapolated=False).bar, 0.5, delta=0.001)
        same = [convergence.Limit(300.0, 0.1, 2), convergence.Limit(300.25, 0.1, 2)]
        self.assertAlmostEqual(convergence.together(same).bar, 0.125)

    def test_a_method_that_repeats_another_counts_once(self):
        one, other = convergence.Limit(300.0, 0.1, 2), convergence.Limit(300.25, 0.1, 2)
        self.assertEqual(convergence.together([one, one]), convergence.together([one]))
        self.assertEqual(convergence.together([one, one, other]), convergence.together([one, other]))

    def test_a_number_has_no_more_digits_than_its_bar(self):
        self.assertEqual(convergence.text(1169.5837, 0.18, "K"), "1169.58 ± 0.18 K")
        self.assertEqual(convergence.text(1169.5837, 0.27, "K"), "1169.6 ± 0.3 K")
        self.assertEqual(convergence.text(-20312.0, 440.0, "W"), "-20300 ± 500 W")

    def test_clouds_are_refined_by_their_own_keys(self):
        def refined(**cloud):
            changes, factor = refine.refined(cloud, 1.5)
            return {**changes, "factor": round(factor, 6)}
        self.assertEqual(refined(shape="box", points=[21, 11]), {"cloud.points": [31, 16], "factor": 1.5})
        self.assertEqual(refined(shape="box", points=[20, 10], at="cells"), {"cloud.points": [30, 15], "factor": 1.5})
        self.assertEqual(refined(shape="box", spacing="3 mm"), {"cloud.spacing": "2 mm", "factor": 1.5})
        self.assertEqual(refined(shape="box", size=["3.3 mm"], spacing="0.1 mm"), {"cloud.points": [51], "factor": round(50 / 33, 6)})
        self.assertEqual(refined(shape="cylinder", rings=4, levels=3), {"cloud.rings": 6, "cloud.levels": 4, "factor": 1.5})
        self.assertEqual(refined(shape="surface", spacing="3 mm", near=[{"on": "x", "spacing": "1.5 mm"}]),
                         {"cloud.spacing": "2 mm", "cloud.near": [{"on": "x", "spacing": "1 mm"}], "factor": 1.5})
        self.assertEqual(refine.refined({"shape": "box", "x": ["0 mm", "1 mm", "3 mm"]}, 2)[0],
                         {"cloud.x": ["0 mm", "0.5 mm", "1 mm", "2 mm", "3 mm"]})
        self.assertEqual(refined(shape="box", size="3.3 mm", points=21), {"cloud.points": [31], "factor": 1.5})
        self.assertEqual(refined(shape="box", size="2 inch", spacing="0.1 inch"), {"cloud.points": [31], "factor": 1.5})
        self.assertEqual(refine.refined({"shape": "box", "x": ["0 mm", "1 cm", "3 cm"]}, 2)[0], {"cloud.x": ["0 mm", "5 mm", "10 mm", "20 mm", "30 mm"]})
        with self.assertRaisesRegex(CalorError, "cannot be refined"):
            refined(shape="mesh", file="a.msh")

    def test_variants_are_certified_as_they_run(self):
        # 10 kW/m^2 through 0.1 m of 5 W/(m K) to air of 300 K behind 50 W/(m^2 K): 500 K and 700 K, exact on any spacing.
        case = copy.deepcopy({key: value for key, value in FITTED.items() if key not in ("fit", "steady")})
        case |= {"initial": {"temperature": "300 K"}, "time": {"end": "0.001 day", "tolerance": "1 K"}}
        case["cloud"] = {"shape": "box", "size": "0.1 m", "points": 11}
        case["variant"] = [{"name": "steady", "remove": ["time"], "set": {"steady": {}, "cloud": {"points": 6}}}]
        pathlib.Path("wall.toml").write_text(toml.write(case))
        found = certify.certify(Case("wall.toml", variant="steady"), factors=[1, 2, 3])
        self.assertEqual(found.refused, {})
        self.assertEqual([run.points for run in found.runs[:9:3]], [6, 11, 16])
        self.assertAlmostEqual(found.quantities["probe front"].verdict.value, 700, places=6)
        self.assertEqual([one.method for one in twin.twin(Case("wall.toml", variant="steady")).of_methods], ["sph", "peridynamics", "mlpg"])
        self.assertEqual([one.method for one in twin.twin("wall.toml").of_methods], ["sph", "peridynamics", "mlpg"])

    def test_a_graded_plate_is_certified_with_its_true_temperature_within_the_bar(self):
        # k = 1 + 2 x between 0 K and 1 K: T = ln(1 + 2 x) / ln 3.
        case = {"title": "Graded", "method": "sph", "cloud": {"shape": "box", "size": ["1 m", "0.5 m"], "points": [9, 5]},
                "material": {"m": {"conductivity": {"formula": "1 + 2*x", "unit": "W/(m K)"}}},
                "boundary": {"xmin": {"on": "xmin", "temperature": "0 K"}, "xmax": {"on": "xmax", "temperature": "1 K"}},
                "steady": {}, "probe": {"a": ["0.3 m", "0.2 m"]}}
        path = pathlib.Path("graded.toml")
        path.write_text(toml.write(case))
        certificate = certify.certify(str(path), "runs", factors=[1, 1.5, 2, 3])
        verdict = certificate.quantities["probe a"].verdict
        self.assertTrue(verdict.certified, verdict)
        self.assertLessEqual(abs(verdict.value - np.log(1.6) / np.log(3)), verdict.bar)
        self.assertLess(verdict.bar, 1e-3)
        written = json.loads(pathlib.Path("runs/certificate.json").read_text())
        self.assertEqual(written["quantities"][0]["name"], "probe a")
        axes = certificate.plot().axes
        self.assertEqual(axes[0].get_title(loc="left").splitlines()[0], "probe a")
        sph = axes[0].lines[0]
        self.assertEqual(sph.get_label(), "sph")
        np.testing.assert_allclose(sph.get_ydata(), np.array(certificate.quantities["probe a"].values["sph"]) - verdict.value)
        page = certificate.write_page().read_text()
        self.assertIn(certificate.quantities["probe a"].statement, page)
        self.assertIn("data:image/png;base64,", page)

    def test_a_budget_is_a_time(self):
        self.assertEqual([certify.seconds(text) for text in ("90s", "1.5min", "1h", "20")], [90, 90, 3600, 20])
        with self.assertRaisesRegex(CalorError, "is no time"):
            certify.seconds("soon")
        self.assertEqual([certify.duration(t) for t in (40, 720, 11000)], ["40 s", "12 min", "3.1 h"])


# A flux of 10 kW/m^2 through 0.1 m of k, air of 300 K behind h: the back at 300 + q / h, the front q L / k above.
FITTED = {
    "title": "Wall", "method": "sph", "cloud": {"shape": "box", "size": ["0.1 m"], "points": [11]},
    "material": {"m": {"conductivity": "5 W/(m K)", "density": "1000 kg/m^3", "specific_heat": "100 J/(kg K)"}},
    "boundary": {"in": {"on": "xmin", "flux": "10 kW/m^2"}, "out": {"on": "xmax", "convection": {"h": "50 W/(m^2 K)", "ambient": "300 K"}}},
    "steady": {}, "probe": {"front": ["0 m"], "back": ["0.1 m"]},
    "fit": {"unknown": [{"key": "material.m.conductivity", "start": "5 W/(m K)"},
                        {"key": "boundary.out.convection.h", "start": "50 W/(m^2 K)", "from": "1 W/(m^2 K)", "to": "1000 W/(m^2 K)"}],
            "data": [{"probe": "front", "value": "500 K", "noise": "2 K"}, {"probe": "back", "value": "126.85 degC", "noise": "1 K"}]},
}


class Fits(unittest.TestCase):
    setUp = Certificates.setUp

    def fitted(self, changes=None, **files):
        for name, text in files.items():
            pathlib.Path(f"{name}.csv").write_text(text)
        case = json.loads(json.dumps(FITTED))
        merge(case, changes or {})
        pathlib.Path("wall.toml").write_text(toml.write(case))
        return fit.fit("wall.toml", "fit")

    def test_unknowns_and_their_intervals_are_those_of_the_closed_form(self):
        found = self.fitted()
        # h = q / (T_back - 300), k = q L / (T_front - T_back), and their derivatives.
        self.assertAlmostEqual(found.values[0], 10, delta=0.01)
        self.assertAlmostEqual(found.values[1], 100, delta=0.1)
        self.assertAlmostEqual(found.deviation[0], 10 / 100 * np.hypot(2, 1), delta=0.02 * 0.22)
        self.assertAlmostEqual(found.deviation[1], 100 / 100 * 1, delta=0.02)
        self.assertAlmostEqual(found.correlation[0, 1], -1 / np.sqrt(5), delta=0.02)
        again = Case("fit/wall-fitted.toml").run("again")
        self.assertAlmostEqual(again.probes["front"][-1], 500, delta=0.1)

    def test_unknowns_pass_zero(self):
        # The back is at ambient + 10 kW/m^2/50 W/(m^2 K) = ambient + 200 K, and at 300 K + flux/50 W/(m^2 K).
        ambient = {"boundary.out.convection.ambient": "5 degC", "fit.unknown": [{"key": "boundary.out.convection.ambient", "start": "5 degC"}]}
        for changes, back, value in ((ambient, "190 degC", -10), ({"fit.unknown": [{"key": "boundary.in.flux", "start": "10 kW/m^2"}]}, "260 K", -2),
                                     ({"fit.unknown": [{"key": "boundary.in.flux", "start": "0 W/m^2", "from": "-9 kW/m^2", "to": "9 kW/m^2"}]}, "260 K", -2)):
            found = self.fitted({**changes, "fit.data": [{"probe": "back", "value": back, "noise": "0.1 K"}]})
            self.assertAlmostEqual(found.values[0], value, delta=0.02)
            self.assertTrue(found.converged)
            self.assertLess(found.runs, 8)

    def test_an_unknown_that_cannot_pass_zero_stays_on_its_side(self):
        # Ten times the conductivity that is sought is given: the first steps lead below 0, which calor refuses.
        found = self.fitted({"fit.unknown": FITTED["fit"]["unknown"][:1], "fit.data": [{"probe": "front", "value": "2500 K", "noise": "2 K"}]})
        self.assertAlmostEqual(found.values[0], 10e3 * 0.1 / (2500 - 500), delta=0.001)
        self.assertTrue(found.converged)
        with self.assertRaisesRegex(CaseError, "a start of 0"):
            self.fitted({"fit.unknown": [{"key": "boundary.in.flux", "start": "0 W/m^2"}]})

    def test_a_search_that_was_cut_short_has_not_converged(self):
        found = self.fitted({"fit.iterations": 1})
        self.assertFalse(found.converged)
        self.assertIn("not come to its end", found.table())

    def test_a_variant_is_fitted_with_changes_and_with_its_files_beside_it(self):
        # k as a table in a file: the variant's air is 100 K warmer, the front is held by a flux of 5 kW/m^2: h = 5000/(450 - 400).
        pathlib.Path("k.csv").write_text("T [K],k [W/(m K)]\n0,5\n1000,5\n")
        case = copy.deepcopy(FITTED)
        case["material"]["m"]["conductivity"] = {"file": "k.csv"}
        case["fit"] = {"unknown": FITTED["fit"]["unknown"][1:], "data": [{"probe": "back", "value": "450 K", "noise": "1 K"}]}
        case["variant"] = [{"name": "warm", "set": {"boundary": {"out": {"convection": {"ambient": "400 K"}}}}}]
        pathlib.Path("wall.toml").write_text(toml.write(case))
        said = subprocess.run([CALOR, "fit", "wall.toml", "variant=warm", "boundary.in.flux=5 kW/m^2", "-o", "fit"], capture_output=True, text=True)
        self.assertEqual(said.returncode, 0, said.stderr)
        again = Case("fit/wall-fitted.toml")
        self.assertAlmostEqual(quantities.in_unit(again.to_dict()["boundary"]["out"]["convection"]["h"], "W/(m^2 K)"), 100, delta=0.1)
        self.assertAlmostEqual(again.run("again").probes["back"][-1], 450, delta=0.1)

    def test_what_the_data_do_not_tell_is_said(self):
        found = self.fitted({"fit.data": [FITTED["fit"]["data"][0]]})
        self.assertTrue(any("can hardly be told apart" in text or "hardly tell" in text for text in found.remarks()), found.remarks())

    def test_of_fewer_readings_than_unknowns_the_intervals_are_infinite(self):
        # The back is at 300 K + flux/h, whatever both are: more of one goes with more of the other.
        unknown = [{"key": "boundary.in.flux", "start": "10 kW/m^2"}, FITTED["fit"]["unknown"][1]]
        once = {"probe": "back", "value": "400 K", "noise": "1 K"}
        for data in ([once], [once, once]):
            found = self.fitted({"fit.unknown": unknown, "fit.data": data})
            self.assertTrue(np.isinf(found.deviation).all(), found.deviation)
            self.assertAlmostEqual(found.correlation[0, 1], 1, places=6)
            self.assertAlmostEqual(found.told, 1, places=6)
            self.assertAlmostEqual(found.values[0] * 1e3 / found.values[1], 100, delta=0.1)
            self.assertRegex(found.table(), r"boundary.in.flux +\d[\d.]* ± inf kW/m\^2")
            self.assertEqual(json.loads((found.folder / "fit.json").read_text())["unknowns"][0]["deviation"], None)

    def test_what_is_known_before_counts(self):
        unknown = [{**FITTED["fit"]["unknown"][0], "expected": "8 W/(m K)", "within": "0.0001 W/(m K)"}, FITTED["fit"]["unknown"][1]]
        self.assertAlmostEqual(self.fitted({"fit.unknown": unknown}).values[0], 8, delta=0.001)

    def test_a_heat_flow_is_fitted_by_the_derivatives_that_a_run_gives(self):
        # The front held at 500 K takes 10 kW: k and h as before, without a run for every difference.
        found = self.fitted({"boundary.in": {"on": "xmin", "temperature": "500 K"},
                             "fit.data": [{"report": "heat_flow.out", "value": "-10 kW", "noise": "100 W"}, FITTED["fit"]["data"][1]]})
        self.assertTrue((found.folder / "run-1" / "derivatives.csv").exists())
        np.testing.assert_allclose(found.values, [10, 100], rtol=2e-3)
        # h = Q / (T_b - 300), k = Q L / (500 - T_b): with Q to 1 % and T_b to 1 K.
        np.testing.assert_allclose(found.deviation, [10 * np.hypot(0.01, 0.01), 100 * np.hypot(0.01, 0.01)], rtol=0.02)

    def test_the_balance_is_measured_at_any_time_and_what_is_known_of_the_whole_run_only_without(self):
        # An insulated wall of 10 kJ/K: 20 kW make 310 K in 5 s.
        case = {key: value for key, value in json.loads(json.dumps(FITTED)).items() if key != "steady"}
        del case["boundary"]["out"]
        case |= {"initial": {"temperature": "300 K"}, "time": {"end": "10 s"}}
        case["fit"] = {"unknown": [{"key": "boundary.in.flux", "start": "10 kW/m^2"}],
                       "data": [{"report": "mean.m", "value": "310 K", "at": "5 s", "noise": "1 K"}]}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        self.assertAlmostEqual(fit.fit("wall.toml", "fit").values[0], 20, delta=0.01)
        case["fit"]["data"][0]["report"] = "largest_width"
        case["fit"]["data"][0] |= {"value": "3 mm", "noise": "1 mm"}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        with self.assertRaisesRegex(CaseError, r"wall.toml:\d+: times of largest_width.* without a time"):
            fit.fit("wall.toml", "fit")

    def test_measured_and_computed_values_are_drawn_with_their_differences(self):
        picture = self.fitted({"fit.data": [*FITTED["fit"]["data"], {"report": "heat_flow.out", "value": "-10 kW", "noise": "100 W"}]}).plot()
        self.assertEqual([ax.get_ylabel() for ax in picture.axes], ["computed [K]", "computed [W]", "(computed - measured) / noise", ""])
        np.testing.assert_allclose(picture.axes[0].lines[1].get_xdata(), [500, 400])

    def test_bad_measurements_are_refused_with_their_line(self):
        from_file = {"probe": "front", "file": "tc.csv", "noise": "1 K"}
        transient = {"time": {"end": "10 s"}, "fit.data": [from_file]}
        for rows, words in (("time [s],front [K]\n1,nan\n", "tc.csv:2: .*not finite"),
                            ("time [s],front [K]\n1,300\n20,310\n", "tc.csv:3: .*outside the run"),
                            ("time [s],front [K]\n1,abc\n", "tc.csv:2: .*no row of numbers"),
                            ("time [s],front [W]\n1,300\n", "tc.csv:1: 'W' cannot be converted to 'K'"),
                            ("front [K]\n300\n", "no column 'time'")):
            case = {key: value for key, value in json.loads(json.dumps(FITTED)).items() if key != "steady"}
            case |= {"initial": {"temperature": "300 K"}}
            merge(case, json.loads(json.dumps(transient)))
            pathlib.Path("wall.toml").write_text(toml.write(case))
            pathlib.Path("tc.csv").write_text(rows)
            with self.assertRaisesRegex(CaseError, words):
                fit.fit("wall.toml", "fit")
        once = FITTED["fit"]["data"][1]
        for changes, words in (({"fit.data": [{**once, "noise": "-1 K"}]}, r"^wall.toml:\d+: a noise of -1 K: give a standard deviation above 0$"),
                               ({"fit.data": [{**once, "at": "5 s"}]}, r"wall.toml:\d+: a time of 5 s in a steady case"),
                               ({"fit.data": [{"probe": "top", "value": "300 K", "noise": "1 K"}]}, "wall.toml:.* no probe 'top'"),
                               ({"fit.unknown": [{"key": "material.n.conductivity", "start": "1 W/(m K)"}]}, "has no 'material.n.conductivity'"),
                               ({"fit.unknown": [{"key": "material.m.conductivity", "start": "1 W/mm"}]}, "wall.toml:.*'W/mm' cannot be converted to 'W/\\(m K\\)'")):
            with self.assertRaisesRegex(CaseError, words):
                self.fitted(changes)
        with self.assertRaisesRegex(CaseError, r"wall.toml:\d+:\d+: the report has no number 'heat_flow.nothing': .*it has .*heat_flow.out"):
            self.fitted({"fit.data": [FITTED["fit"]["data"][0], {"report": "heat_flow.nothing", "value": "1 W", "noise": "1 W"}]})


# A plate of 3 x 2 nodes: a flux q through it from the left, 300 K on the right; the right answer is known where all values are alike.
FITTED_PLATE = {
    "title": "Plate", "method": "sph", "cloud": {"shape": "box", "size": ["0.1 m", "0.05 m"], "points": [11, 6]},
    "material": {"m": {"conductivity": {"grid": [[5, 5], [5, 5], [5, 5]], "along": ["x", "y"], "from": ["0 m", "0 m"], "to": ["0.1 m", "0.05 m"],
                                        "unit": "W/(m K)"}}},
    "boundary": {"in": {"on": "xmin", "flux": "10 kW/m^2"}, "out": {"on": "xmax", "temperature": "300 K"}},
    "steady": {}, "probe": {f"p{n}": [f"{2 * n} cm", f"{y} cm"] for n in range(4) for y in (n % 2 + 2,)},
    "fit": {"field": [{"key": "material.m.conductivity.grid", "expected": "8 W/(m K)", "within": "4 W/(m K)", "length": "5 cm"}],
            "data": [{"file": "plate.csv", "noise": "0.5 K"}]},
}


class SobolIndices(unittest.TestCase):
    def test_of_a_sum_and_of_ishigamis_function_are_those_of_the_closed_form(self):
        try:
            import openturns  # noqa: F401
        except ImportError:
            self.skipTest("apt-get install python3-openturns")
        random = np.random.default_rng(0)
        x = random.uniform(0, 1, (40, 2))
        first, total, foretold = sobol.expand(x, 2 * x[:, 0] + x[:, 1], [(0, 1)] * 2)
        np.testing.assert_allclose([*first, *total, foretold], [0.8, 0.2, 0.8, 0.2, 1], atol=1e-9)
        # sin x + 7 sin^2 y + 0.1 z^4 sin x on [-pi, pi]^3: Ishigami & Homma, ISUMA 1990.
        x = random.uniform(-np.pi, np.pi, (300, 3))
        first, total, foretold = sobol.expand(x, np.sin(x[:, 0]) + 7 * np.sin(x[:, 1])**2 + 0.1 * x[:, 2]**4 * np.sin(x[:, 0]), [(-np.pi, np.pi)] * 3)
        np.testing.assert_allclose(first, [0.3139, 0.4424, 0], atol=0.02)
        np.testing.assert_allclose(total, [0.5576, 0.4424, 0.2437], atol=0.02)
        self.assertGreater(foretold, 0.9)


class Fields(unittest.TestCase):
    setUp = Certificates.setUp

    def fitted(self, changes=None, rows=None):
        case = json.loads(json.dumps(FITTED_PLATE))
        merge(case, changes or {})
        pathlib.Path("plate.toml").write_text(toml.write(case))
        # k = 8 everywhere: T = 300 + q (L - x) / k.
        rows = rows or "".join(f"p{n},{300 + 1e4 * (0.1 - 0.02 * n) / 8 - 273.15:.6f}\n" for n in range(4))
        pathlib.Path("plate.csv").write_text("probe,T [degC]\n" + rows)
        return fit.fit("plate.toml", "fit")

    def test_a_field_is_found_by_the_derivatives_that_a_run_gives(self):
        found = self.fitted()
        np.testing.assert_allclose(found.values, 8, atol=0.02)
        self.assertLess(found.runs, 8)
        self.assertTrue(1 < found.told < 4, found.told)
        self.assertTrue(np.all(found.deviation < 4))
        self.assertIn("6 values, ", found.table())
        again = Case("fit/plate-fitted.toml").run("again", show_progress=False)
        self.assertAlmostEqual(again.probes["p0"][-1], 425, delta=0.2)

    def test_readings_are_read_as_spreadsheets_write_them(self):
        self.fitted()
        for written, words in ((b"\xef\xbb\xbfprobe,T [degC]\r\np0,150\r\n", None), ("probe,T [\u00b0C]\np0,150\n".encode(), None),
                               ("probe,T [\u00b0C]\np0,150\n".encode("latin-1"), "plate.csv:1: .* is not a unit"), (b"probe,T [K]\np0,\0\n", "plate.csv.*p0")):
            pathlib.Path("plate.csv").write_bytes(written)
            if words:
                with self.assertRaisesRegex(CaseError, words):
                    fit.fit("plate.toml", "fit")
            else:
                self.assertAlmostEqual(fit.fit("plate.toml", "fit").data[0].value[0], 423.15)

    def test_values_of_a_field_at_a_limit_are_told(self):
        found = self.fitted({"fit.field": [{**FITTED_PLATE["fit"]["field"][0], "to": "6 W/(m K)"}]})  # of 8 W/(m K)
        self.assertRegex(found.table(), r"\d of 6 values of material.m.conductivity.grid lie at a limit")

    def test_without_measurements_that_tell_the_field_is_as_expected(self):
        found = self.fitted({"fit.data": [{"file": "plate.csv", "noise": "10000 K"}]})
        np.testing.assert_allclose(found.values, 8, atol=0.8)  # the search ends within a fifth of the standard deviation, 4
        np.testing.assert_allclose(found.deviation, 4, rtol=0.01)
        self.assertLess(found.told, 0.1)

    def test_derivatives_of_a_run_are_read_by_name(self):
        case = copy.deepcopy({key: value for key, value in FITTED_PLATE.items() if key != "fit"})
        result = Case({**case, "output": {"derivatives": "boundary.in.flux"}}).run("once", show_progress=False)
        self.assertAlmostEqual(result.derivatives["boundary.in.flux"]["p0"][-1], 1000 * 0.1 / 5, delta=1e-6)

    def test_what_does_not_fit_is_refused_with_its_line(self):
        field = FITTED_PLATE["fit"]["field"][0]
        for changes, rows, words in (
                (None, "p9,300\n", "plate.csv:2: the case has no probe 'p9'"),
                (None, "p0,hot\n", "plate.csv:2: .* no probe with its temperature"),
                (None, "p0,nan\n", "plate.csv:2: .* not finite"),
                ({"fit.field": [{**field, "within": "0 W/(m K)"}]}, None, r"plate.toml:\d+: 'within' and 'length'"),
                ({"fit.field": [{**field, "expected": "8 W/cm"}]}, None, r"plate.toml:\d+: .*'W/cm' cannot be converted"),
                ({"fit.field": [{**field, "key": "material.m.conductivity"}]}, None, r"plate.toml:\d+: .* is no grid"),
                ({"fit.field": [{**field, "from": "6 W/(m K)"}]}, None, r"plate.toml:\d+: the grid has values outside"),
                ({"fit.data": [{"report": "volume", "value": "1 m^3", "noise": "1 m^3"}]}, None, r"plate.toml:\d+: a field takes a steady case")):
            with self.assertRaisesRegex(CaseError, words):
                self.fitted(changes, rows)


class Twins(unittest.TestCase):
    setUp = Certificates.setUp

    def test_the_error_of_a_known_solution_falls_with_the_square_of_the_spacing(self):
        case = copy.deepcopy({key: value for key, value in FITTED.items() if key != "fit"})
        case["material"]["m"]["conductivity"] = {"formula": "5 + 0.01*(T - 300) + 20*x", "unit": "W/(m K)"}
        case["boundary"]["radiation"] = {"on": "xmax", "radiation": {"emissivity": 0.8, "ambient": "400 K"}}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        steady = twin.twin("wall.toml")
        del case["steady"]
        case |= {"initial": {"temperature": "300 K"}, "time": {"end": "1 min"}}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        for found in (steady, twin.twin("wall.toml")):
            self.assertEqual([one.method for one in found.of_methods], ["sph", "peridynamics", "mlpg"])
            for one in found.of_methods:
                self.assertGreater(one.order, 1.7, one)
                self.assertLess(max(one.errors), 2e-3 * found.span)
            self.assertRegex(found.table(), r"sph .*   [12]\.\d")

    def test_layers_have_one_whose_flux_agrees_where_they_meet(self):
        case = {key: value for key, value in FITTED.items() if key != "fit"}
        case["material"] = {"m": {"conductivity": "5 W/(m K)"}, "n": {"conductivity": "0.5 W/(m K)"}}
        case["body"] = {"along": "x", "layer": [{"material": "m", "thickness": "55 mm"}, {"material": "n", "thickness": "45 mm"}]}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        touching = twin.twin("wall.toml", factors=[1, 3, 5])  # the plane stays in the middle of two points
        case["body"]["layer"][1]["contact"] = "20 W/(m^2 K)"
        pathlib.Path("wall.toml").write_text(toml.write(case))
        apart = twin.twin("wall.toml", factors=[1, 3, 5])
        self.assertNotEqual(apart.formula, touching.formula)
        for one in (*touching.of_methods, *apart.of_methods):
            self.assertGreater(one.order, 1.8, one)
        case["material"]["n"]["conductivity"] = {"formula": "0.5 + 1e-5*(T - 300)", "unit": "W/(m K)"}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        level = twin.twin("wall.toml", methods=["sph"], factors=[1, 3, 5])  # no heat crosses its contact
        self.assertGreater(level.of_methods[0].order, 1.8)
        del case["body"]["layer"][1]["contact"]
        pathlib.Path("wall.toml").write_text(toml.write(case))
        crossed = twin.twin("wall.toml", methods=["sph"], factors=[1, 3, 5])
        self.assertGreater(crossed.of_methods[0].order, 1.8)
        self.assertNotEqual(level.formula, crossed.formula)

    def test_layers_that_conduct_differently_by_direction_have_one(self):
        case = {"title": "Laminate", "method": "sph", "cloud": {"shape": "box", "size": ["100 mm", "60 mm"], "points": [21, 13]},
                "material": {"a": {"conductivity": "2 W/(m K)", "anisotropy": {"y": 5}}, "b": {"conductivity": "1 W/(m K)"}},
                "body": {"along": "x", "layer": [{"material": "a", "thickness": "42.5 mm"}, {"material": "b", "thickness": "57.5 mm"}]},
                "boundary": {"hot": {"on": "xmin", "temperature": "400 K"}, "air": {"on": ["xmax", "ymax"], "convection": {"h": "50 W/(m^2 K)", "ambient": "300 K"}}},
                "steady": {}}
        pathlib.Path("laminate.toml").write_text(toml.write(case))
        for one in twin.twin("laminate.toml", methods=["sph", "peridynamics"], factors=[1, 3]).of_methods:
            self.assertGreater(one.order, 1.8, one)

    def test_regions_have_one_that_is_level_where_they_meet(self):
        case = {"title": "Regions", "method": "sph", "cloud": {"shape": "box", "size": ["100 mm", "60 mm"], "points": [15, 9]},
                "material": {"a": {"conductivity": {"table": [[200, 2], [500, 4]], "unit": "W/(m K)"}}, "b": {"conductivity": {"formula": "20 - 0.01*T", "unit": "W/(m K)"}}},
                "body": {"material": "a", "region": [{"material": "b", "length": "mm", "where": "(x^2 + y^2 < 900 && y > x - 20) || x > X"}]}, "parameter": {"X": 70},
                "boundary": {"hot": {"on": "xmin", "temperature": "400 K"}, "air": {"on": ["xmax", "ymax"], "convection": {"h": "50 W/(m^2 K)", "ambient": "300 K"}}},
                "steady": {}}
        pathlib.Path("regions.toml").write_text(toml.write(case))
        found = twin.twin("regions.toml", methods=["sph", "peridynamics"])
        for one in found.of_methods:
            self.assertGreater(one.order, 1.6, one)
            self.assertLess(one.errors[-1], 2e-3 * found.span)
        case["material"]["a"]["conductivity"] = {"formula": "2 + x", "unit": "W/(m K)"}
        pathlib.Path("regions.toml").write_text(toml.write(case))
        with self.assertRaisesRegex(CaseError, "that of a depends on place"):
            twin.twin("regions.toml")

    def test_parts_of_a_body_by_its_surface_have_one(self):
        for name in ("tube-in-tube", "two-layer-sphere"):
            found = twin.twin(ROOT / f"cases/body/{name}.toml", name, methods=["sph"], factors=[1, 1.5])
            self.assertGreater(found.of_methods[0].order, 1.7, found.table())
        with self.assertRaisesRegex(CaseError, "written by hand"):
            twin.twin(ROOT / "cases/mesh/two-materials.toml", "mesh")


    def test_cracked_bodies_have_one_that_is_level_across_the_cracks(self):
        # Two lines that meet, between the points at all spacings.
        case = {"title": "Cracked", "method": "sph", "cloud": {"shape": "box", "size": ["1 m", "1 m"], "points": [14, 14]}, "material": {"m": {"conductivity": "5 W/(m K)"}},
                "crack": [{"x": ["0.2 m", "0.61 m", "0.61 m"], "y": ["0.42 m", "0.42 m", "0.8 m"]}],
                "boundary": {"hot": {"on": "xmin", "temperature": "400 K"}, "air": {"on": ["xmax", "ymax"], "convection": {"h": "50 W/(m^2 K)", "ambient": "300 K"}}}, "steady": {}}
        pathlib.Path("cracked.toml").write_text(toml.write(case))
        for one in twin.twin("cracked.toml", methods=["sph", "mlpg"], factors=[1, 4]).of_methods:
            self.assertGreater(one.order, 1.5, one)


class Interfaces(unittest.TestCase):
    def test_planes_of_cracks_are_those_of_their_corners(self):
        of = interfaces.of_cracks({"crack": [{"x": ["0 m", "1 m", "2 m"], "y": ["0 m", "0 m", "1 m"]}, {"x": ["3 m", "2 m"], "y": ["0 m", "0 m"]}]}, 2)
        away = [interfaces.evaluated(plane, np.array([[1.0, 2.0, 0.0]])) for plane in of]
        np.testing.assert_allclose(np.abs(away), [[2], [2 / np.sqrt(2)]], rtol=1e-11)
        of = interfaces.of_cracks({"crack": [{"x": ["0 m", "1 m", "1 m", "0 m"], "y": ["0 m", "0 m", "1 m", "1 m"], "z": ["2 m"] * 4}]}, 3)
        np.testing.assert_allclose([interfaces.evaluated(plane, np.array([[1.0, 2.0, 5.0]])) for plane in of], [[3]])

    def test_conditions_turn_where_their_comparisons_are_0(self):
        for condition, formulas in {"x < 0.1 && (y >= z + 1 || (x > 2*y))": ["x - 0.1", "y - (z + 1)", "x - (2*y)"], "abs(x - 1) < 2": ["(x - 1) - 2", "(x - 1) + 2"],
                                    "r < 3": ["r^2 - 3^2"], "(x + 1)*(y + 2) < 3": ["((x + 1)*(y + 2)) - 3"], "x < 1 ? y < 2 : 1": ["x - 1", "y - 2"]}.items():
            self.assertEqual(list(interfaces.compared(condition)), formulas, condition)

    def test_faces_of_a_shape_are_turned_and_moved_with_it(self):
        # A box of 2 m x 1 m x 3 m, turned by 90 degrees about z and moved to (1, 0, 0): x from 0 to 1 m, y from 0 to 2 m.
        part = {"shape": "box", "size": ["2 m", "1 m", "3 m"], "turn": ["0 deg", "0 deg", "90 deg"], "at": ["1 m", "0 m", "0 m"]}
        faces = list(interfaces.of_shapes({"cloud": {"part": [part]}}, 3))
        on_face = np.array([[0.3, 0, 1], [0.3, 2, 1], [1, 0.4, 1], [0, 0.4, 1], [0.3, 0.4, 0], [0.3, 0.4, 3]])
        np.testing.assert_allclose(np.diag([interfaces.evaluated(face, on_face) for face in faces]), 0, atol=1e-12)

    def test_nothing_but_arithmetic_is_carried_out(self):
        x = np.ones((2, 3))
        for formula in ("__import__('os')", "x.shape", "(lambda: 1)()", "depth - 1", "[x]"):
            self.assertIsNone(interfaces.evaluated(formula, x), formula)
        np.testing.assert_allclose(interfaces.evaluated("2*x^2 + sqrt(4) - 1e-1", x), 3.9)


class Optima(unittest.TestCase):
    setUp = Certificates.setUp

    def test_a_limit_on_a_result_is_reached_and_kept(self):
        # 1000 K and 300 K behind 100 and 200 W/(m^2 K): the cold face is at 300 K + 700 K/200/(1/100 + 0.1 m/k + 1/200),
        # 400 K where 0.1 m/k = 0.02, k = 5 W/(m K); the hot face is the cooler, the better the wall conducts.
        case = {key: value for key, value in FITTED.items() if key != "fit"}
        case["boundary"] = {"gas": {"on": "xmin", "convection": {"h": "100 W/(m^2 K)", "ambient": "1000 K"}},
                            "air": {"on": "xmax", "convection": {"h": "200 W/(m^2 K)", "ambient": "300 K"}}}
        case["material"] = {"m": {"conductivity": "2 W/(m K)"}}
        case["optimise"] = {"minimise": "maximum.gas",
                            "unknown": [{"key": "material.m.conductivity", "start": "2 W/(m K)", "from": "1 W/(m K)", "to": "20 W/(m K)"}],
                            "limit": [{"report": "maximum.air", "at_most": "400 K"}]}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        found = optimise.optimise("wall.toml")
        self.assertTrue(found.best.is_allowed)
        self.assertAlmostEqual(found.best.values[0], 5, delta=0.03)
        self.assertLess(found.best.objective, found.first.objective)
        best = Case("results/wall-optimum/wall-best.toml").to_dict()
        self.assertEqual(quantities.split(best["material"]["m"]["conductivity"])[0], found.best.values[0])
        for changes, words in (({"optimise": {"minimise": "highest.gas"}}, "the report has no number 'highest.gas'"),
                               ({"optimise": {"limit": [{"report": "maximum.air", "at_most": "1 m"}]}}, "wall.toml:.*'m' cannot be converted to 'K'"),
                               ({"optimise": {"maximise": "maximum.air"}}, "has no \\[optimise\\] with")):
            with self.assertRaisesRegex(CaseError, words):
                optimise.optimise(Case("wall.toml", changes))
        self.assertEqual(os.listdir("results"), ["wall-optimum"])  # nothing has run before it was told

    def test_a_search_that_starts_at_a_limit_leaves_it(self):
        # The critical radius of insulation, k/h = 20 mm: 15 mm of it around a pipe of 5 mm let most heat through, 40 mm and 2 mm less.
        case = {"title": "Insulation", "method": "sph", "steady": {},
                "cloud": {"shape": "box", "axisymmetric": True, "origin": ["5 mm", "0 mm"], "size": ["10 mm", "5 mm"], "points": [31, 3]},
                "material": {"wool": {"conductivity": "0.2 W/(m K)"}},
                "boundary": {"inner": {"on": "xmin", "temperature": "100 degC"}, "air": {"on": "xmax", "convection": {"h": "10 W/(m^2 K)", "ambient": "20 degC"}}}}
        for start in ("40 mm", "4 cm", "2 mm"):
            unknown = {"key": "cloud.size[0]", "start": start, "from": "0.002 m", "to": "40 mm"}
            found = optimise.optimise(Case({**case, "optimise": {"maximise": "heat_flow.inner", "unknown": [unknown]}}), start.replace(" ", "-"))
            self.assertAlmostEqual(found.best.values[0], 15, delta=0.3)

    def test_stress_is_drawn_with_its_numbers(self):
        result = Case(ROOT / "cases" / "optimise" / "graded-wall.toml").run("wall", show_progress=False)
        axes = plot.figure(result, "stress").axes
        self.assertEqual([ax.get_ylabel() for ax in axes], ["T [K]", "stress [MPa]"])
        self.assertAlmostEqual(min(axes[1].lines[0].get_ydata()), -228.7, delta=0.5)
        figure = stress.compare({"start": result, "again": result})
        self.assertEqual([ax.get_ylabel() for ax in figure.axes], ["volume fraction of ceramic", "T [K]", "stress [MPa]"])
        finer = Case(ROOT / "cases" / "optimise" / "graded-wall.toml", {"cloud.points": [81]}).run("finer", show_progress=False)
        errors = stress.bars(result, finer)  # of the cold face 0.0723 K, of the least stress 0.189 MPa against the integrals
        self.assertTrue(0.07 < errors["T"] < 0.15, errors)
        self.assertTrue(1.8e5 < errors["stress"] < 3e5, errors)
        figure = stress.compare({"start": result}, {"start": finer})
        self.assertRegex(figure.axes[2].get_legend().get_texts()[0].get_text(), r"start ± 0\.\d MPa")


class ExitCodes(unittest.TestCase):
    setUp = Certificates.setUp

    def test_many_runs_end_with_the_codes_of_one(self):
        case = {key: value for key, value in FITTED.items() if key != "fit"}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        case["optimise"] = {"minimise": "maximum.out", "iterations": 3, "limit": [{"report": "minimum.out", "at_most": "1 K"}],
                            "unknown": [{"key": "material.m.conductivity", "start": "2 W/(m K)", "from": "1 W/(m K)", "to": "20 W/(m K)"}]}
        pathlib.Path("best.toml").write_text(toml.write(case))
        for words, code, text in ((["optimise", "best.toml"], 1, "No run keeps all limits"),
                                  (["optimise", "wall.toml"], 3, "has no [optimise]"),
                                  (["certify", "wall.toml", "material.m.conductivity=2 m", "--refine", "1,2,3"], 3, "cannot be converted"),
                                  (["certify", "wall.toml", "--refine", "1,2"], 2, "at least three factors"),
                                  (["fit", "wall.toml"], 3, "no [[fit.data]]"),
                                  (["study", "wall.toml"], 3, "no [study.values]"),
                                  (["study", "wall.toml", "material.m.conductivity=[\"7 W/(m K)\", \"7 W\"]"], 1, "1 failed"),
                                  (["study", "wall.toml", "--rows", "a=[1]", "b=[1,2]"], 2, "equally long"),
                                  (["certify", "nothing.toml"], 4, "cannot be read"),
                                  (["study", "wall.toml", "method=[\"sph\"]", "-o", "wall.toml/x"], 4, "wall.toml/x")):
            said = subprocess.run([CALOR, *words], capture_output=True, text=True)
            self.assertEqual(said.returncode, code, (words, said.stderr))
            self.assertIn(text, said.stdout + said.stderr)

    def test_odd_words_are_refused_in_one_line(self):
        pathlib.Path("wall.toml").write_text(toml.write(FITTED))
        for words in (["certify", "-j", "0"], ["certify", "--refine", "1,x,3"], ["certify", "--refine", "1,2,inf"], ["certify", "--refine", "1,nan,3"],
                      ["certify", "--refine", "1,3,2"], ["certify", "--methods", "spf"], ["certify", "--methods", "sph,sph"], ["certify", "--budget", "soon"],
                      ["certify", "--twin", "--methods", ""], ["certify", "--twin", "--refine", "2"], ["certify", "variant=none"], ["certify", "no-change"],
                      ["fit", "-j", "two"], ["fit", "variant=none"], ["fit", "--nothing"], ["study", "-j", "-3", "method=[sph]"], ["study", "method=[]"],
                      ["study", "variant=none", "method=[sph]"], ["optimise", "=3"], ["optimise", "-j", "2"]):
            said = subprocess.run([CALOR, words[0], "wall.toml", *words[1:]], capture_output=True, text=True)
            self.assertEqual((said.returncode, said.stdout, said.stderr.count("\n")), (2, "", 1), (words, said.stderr))
            self.assertRegex(said.stderr, "^(calor|wall.toml)")
        self.assertEqual(os.listdir(), ["wall.toml"])

    def test_what_ended_for_a_reason_of_its_own_keeps_its_code(self):
        self.assertEqual([command.error_of(code, "").code for code in (2, 3, 4, 5, 6, 75, 130, -9)], [2, 3, 4, 5, 6, 75, 130, 137])
        refused = {"sph": CaseError("no"), "mlpg": CaseError("nor this")}
        self.assertEqual((command.together(refused).code, str(command.together(refused))), (3, "sph: no; mlpg: nor this"))
        self.assertEqual(command.together({**refused, "peridynamics": NumbersError("hot")}).code, 5)


class Studies(unittest.TestCase):
    setUp = Certificates.setUp

    def test_every_combination_is_run_once_and_kept(self):
        case = {key: value for key, value in FITTED.items() if key != "fit"}
        case["study"] = {"values": {"method": ["sph", "mlpg"], "boundary.out.convection.h": ["50 W/(m^2 K)", "100 W/(m^2 K)"]}}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        done = study.study("wall.toml")
        self.assertEqual([(row["method"], round(row["probe back [K]"])) for row in done.rows],
                         [("sph", 500), ("sph", 400), ("mlpg", 500), ("mlpg", 400)])
        with pathlib.Path("results/wall-study/study.csv").open() as file:
            self.assertEqual(len(file.readlines()), 5)
        self.assertEqual(study.study("wall.toml").reused, 4)
        cut_short = pathlib.Path("results/wall-study") / done.rows[2]["run"] / "report.json"
        cut_short.write_text(re.sub(r'"interrupted_by": 0', '"interrupted_by": 2', cut_short.read_text()))
        self.assertEqual(study.study("wall.toml").reused, 3)  # what a signal has ended is run again
        self.assertEqual([ax.get_ylabel() for ax in done.plot().axes][:2], ["probe front [K]", "probe back [K]"])
        self.assertEqual(study.study("wall.toml", values={"material.m.conductivity": ["7 W/(m K)"]}).reused, 0)

    def test_runs_are_kept_as_long_as_nothing_that_made_them_changes(self):
        case = copy.deepcopy({key: value for key, value in FITTED.items() if key != "fit"})
        case["material"]["m"]["conductivity"] = {"file": "k.csv"}
        case["variant"] = [{"name": "cold", "set": {"boundary": {"out": {"convection": {"ambient": "200 K"}}}}}]
        pathlib.Path("wall.toml").write_text(toml.write(case))
        values = {"boundary.in.flux": ["10 kW/m^2", "5 kW/m^2"]}

        def fronts(k, case):
            """Temperatures at the front, and how many runs were there before."""
            pathlib.Path("k.csv").write_text(f"T [K],k [W/(m K)]\n0,{k}\n2000,{k}\n")
            done = study.study(case, "runs", values=values)
            return [round(row["probe front [K]"]) for row in done.rows], done.reused

        # Ambient + flux (0.1 m/k + 1/(50 W/(m^2 K))).
        self.assertEqual(fronts(5, "wall.toml"), ([700, 500], 0))
        self.assertEqual(fronts(5, "wall.toml"), ([700, 500], 2))
        self.assertEqual(fronts(10, "wall.toml"), ([600, 450], 0))
        self.assertEqual(fronts(10, Case("wall.toml", variant="cold")), ([500, 350], 0))
        self.assertEqual(fronts(5, "wall.toml"), ([700, 500], 2))
        with unittest.mock.patch.object(command, "fingerprint", lambda: "another program"):
            self.assertEqual(fronts(5, "wall.toml"), ([700, 500], 0))
        done = study.study("wall.toml", "runs", values={"variant": ["cold"], **values})
        self.assertEqual(([row["variant"] for row in done.rows], done.reused), (["cold", "cold"], 0))  # with k = 5
        said = subprocess.run([CALOR, "study", "wall.toml", "variant=cold", "boundary.in.flux=[\"5 kW/m^2\"]", "-o", "runs"], capture_output=True, text=True)
        self.assertIn("1 runs, 1 of them from before", said.stdout, said.stderr)

    def test_rows_of_values_are_run_in_place_of_combinations(self):
        values = {"method": ["sph", "mlpg"], "a": [1, 2]}
        self.assertEqual(study.plan({"values": values, "rows": True}), [{"method": "sph", "a": 1}, {"method": "mlpg", "a": 2}])
        self.assertEqual(len(study.plan({"values": values})), 4)
        self.assertEqual(len(study.plan({"values": values, "rows": True, "range": {"b": [0, 1]}, "samples": 3})), 6)
        with self.assertRaisesRegex(CommandError, "equally long, these are not: method 2, a 3"):
            study.plan({"values": {**values, "a": [1, 2, 3]}, "rows": True})

    def test_after_an_error_no_further_run_is_begun(self):
        begun = []

        def act(n):
            begun.append(n)
            time.sleep(0.005)
            raise CalorError("no")

        with self.assertRaises(CalorError):
            command.side_by_side(act, range(1000), 2)
        self.assertLess(len(begun), 1000)

    def test_a_run_that_fails_is_told_and_the_others_go_on(self):
        case = {key: value for key, value in FITTED.items() if key != "fit"}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        done = study.study("wall.toml", values={"material.m.conductivity": ["7 W/(m K)", "7 W/(mm s)"]})
        self.assertNotIn("failed", done.rows[0])
        self.assertIn("conductivity", done.rows[1]["failed"])

    def test_values_that_are_given_stand_in_the_place_of_ranges(self):
        case = {key: value for key, value in FITTED.items() if key != "fit"}
        case["study"] = {"range": {"boundary.out.convection.h": ["50 W/(m^2 K)", "100 W/(m^2 K)"]}}
        pathlib.Path("wall.toml").write_text(toml.write(case))
        self.assertEqual(len(study.study("wall.toml", values={"method": ["sph", "mlpg"]}).rows), 2)

    def test_samples_are_spread_evenly_over_every_range(self):
        rows = study.samples({"a": ["10 K", "20 K"], "b": [0.0, 1.0]}, 10, 3)
        self.assertEqual(sorted(int(float(row["a"].split()[0])) for row in rows), list(range(10, 20)))
        self.assertEqual(sorted(int(10 * row["b"]) for row in rows), list(range(10)))
        self.assertEqual(rows, study.samples({"a": ["10 K", "20 K"], "b": [0.0, 1.0]}, 10, 3))

    def test_entries_of_lists_are_keys_too(self):
        case = {"material": {"m": {"conductivity": {"table": [[300, 10], [600, 20]], "unit": "K"}}}}
        self.assertEqual(quantities.changes_at(case, {"material.m.conductivity.table[1][1]": 25}),
                         {"material.m.conductivity.table": [[300, 10], [600, 25]]})
        with self.assertRaisesRegex(CalorError, "has no 'material.n'"):
            quantities.at(case, "material.n")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
