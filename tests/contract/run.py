#!/usr/bin/env python3
"""What the command promises: exit codes, files, words on the terminal. run.py CALOR [TEST ...]"""
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock
import xml.etree.ElementTree as xml

CALOR = str(pathlib.Path(sys.argv.pop(1)).resolve())
CASES = pathlib.Path(__file__).resolve().parents[2] / "cases"
COMPLETION = pathlib.Path(__file__).resolve().parents[2] / "cmake/calor-completion.bash"
LONG = ["time.integrator=euler", "time.end=1000 h", "output.every=500 h"]  # runs until it is interrupted


class Contract(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.here = pathlib.Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def calor(self, *words, code=0):
        done = subprocess.run([CALOR, *words], cwd=self.here, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def read_json(self, name):
        return json.loads((self.here / name).read_text())

    def test_a_wrong_command_line_is_code_2(self):
        self.calor("new", "plate")
        for words in ([], ["solve"], ["run"], ["run", "plate.toml", "--fast"], ["run", "plate.toml", "spacing"],
                      ["run", "plate.toml", "-j", "0"], ["doc", "cloud.radiuss"]):
            done = self.calor(*words, code=2)
            self.assertEqual(done.stdout, "")
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn("did you mean 'cloud.radius'?", done.stderr)

    def test_help_lists_the_verbs_and_nothing_that_does_not_exist(self):
        for verb in ("run", "check", "cloud", "show", "units", "verify", "new", "examples", "doc", "help"):
            self.assertIn(verb, self.calor("--help").stdout)
            self.assertIn(f"Usage: calor {verb}", self.calor("help", verb).stdout)
        self.assertEqual(self.calor("help").stdout, self.calor("--help").stdout)
        self.calor("help", "solve", code=2)
        for option in ("-j", "-o", "--quiet", "--restart", "--time-limit"):
            self.assertIn(option, self.calor("run", "--help").stdout)
        self.assertRegex(self.calor("--version").stdout, r"^calor \d+\.\d+\.\d+\n$")

    def test_show_prints_the_case_that_runs(self):
        self.calor("new", "plate")
        (self.here / "plate.toml").write_text((self.here / "plate.toml").read_text() + '[[variant]]\nname = "fine"\nset = { cloud.points = [41, 21] }\n')
        shown = self.calor("show", "plate.toml", "variant=fine", "time.end=1 min").stdout
        (self.here / "shown.toml").write_text(shown)
        self.assertEqual(self.calor("show", "shown.toml").stdout, shown)
        self.assertIn("points = [41, 21]", shown)
        self.assertNotIn("variant", shown)
        self.assertIn("[[variant]]", self.calor("show", "plate.toml").stdout)
        checked, as_given = self.calor("check", "shown.toml").stdout, self.calor("check", "plate.toml", 'variant="fine"', "time.end=1 min").stdout
        self.assertEqual(checked.splitlines()[1:3], as_given.splitlines()[1:3])  # below the name
        self.assertIn("points                861", checked)
        self.calor("show", "plate.toml", "cloud.pionts=3", code=3)

    def test_units_says_how_a_unit_converts(self):
        # By definition: 1 degF is 5/9 K, and 32 degF are 273.15 K; a day has 86400 s.
        self.assertRegex(self.calor("units", "degF", "K").stdout, r"^a difference of 1 degF is 0.55555555555555\d* K, 0 degF is 255.372222222222\d* K\n$")
        self.assertEqual(self.calor("units", "day", "s").stdout, "a difference of 1 day is 86400 s, 0 day is 0 s\n")
        self.assertIn("cannot be converted", self.calor("units", "m", "K", code=2).stderr)

    def test_bash_completes_every_verb_and_its_options(self):
        def completed(*words):
            script = f'source "{COMPLETION}"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _calor; echo "${{COMPREPLY[@]}}"'
            return subprocess.run(["bash", "-c", script, "bash", "calor", *words], cwd=self.here, capture_output=True, text=True, check=True).stdout.split()
        verbs = re.findall(r"^  (\w+) ", self.calor("--help").stdout.partition("Subcommands")[2], re.MULTILINE)
        self.assertGreater(len(verbs), 10)
        self.assertEqual(set(completed("")) - {"--help", "--version"}, set(verbs))
        self.assertIn("--restart", completed("run", "--r"))
        self.assertIn("stress", completed("plot", "results/plate", "st"))
        (self.here / "my case.toml").touch()
        self.assertIn("case.toml", completed("run", "m"))

    def test_the_manual_page_and_the_completion_know_all_verbs_and_options(self):
        page, completion = (COMPLETION.parents[1] / "docs/calor.1.in").read_text().replace("\\-", "-"), COMPLETION.read_text()
        for verb in re.findall(r"^  (\w+) ", self.calor("--help").stdout.partition("Subcommands")[2], re.MULTILINE):
            self.assertIn(f".B {verb}\n", page)
            options = set(re.findall(r"(?<![\w-])--\w[\w-]*", self.calor("help", verb).stdout)) - {"--help", "--output"}  # -o
            written = "\n".join(line for line in page.splitlines() if line.startswith(f"\\fBcalor {verb}\\fR"))
            offered = re.search(rf"^ +(?:\w+ \| )*{verb}(?: \| \w+)*\) words=\"(.*)\" ;;", completion, re.MULTILINE)
            for option in options:
                self.assertIn(option, written, verb)
                self.assertIn(option, offered[1], verb)

    @unittest.skipUnless(shutil.which("zsh"), "apt-get install zsh")
    def test_zsh_takes_the_same_completion(self):
        script = (f'autoload -U bashcompinit; bashcompinit; compdef() {{ : }}; source "{COMPLETION}"; emulate sh; '
                  'COMP_WORDS=(calor rep); COMP_CWORD=1; _calor; echo "${COMPREPLY[@]}"')
        done = subprocess.run(["zsh", "-f", "-c", script], capture_output=True, text=True)
        self.assertIn("report", done.stdout.split())
        self.assertEqual(done.stderr, "")

    def test_new_writes_a_case_that_runs_and_never_overwrites(self):
        self.calor("new", "plate")
        (self.here / "plate.toml").write_text((self.here / "plate.toml").read_text() + "# mine\n")
        self.calor("new", "plate", code=4)
        self.assertIn("# mine", (self.here / "plate.toml").read_text())
        self.calor("run", "plate.toml")

    def test_a_material_of_the_library_replaces_the_numbers_of_a_case(self):
        self.calor("new", "plate")
        key = ".".join(["material", "steel", "library"])
        self.calor("run", "plate.toml", f"{key}=copper", "time.end=1 s", code=1)  # not what is expected
        self.assertEqual(list(self.read_json("results/plate/report.json")["case"]["material"]["steel"])[0], "library")

    def test_new_offers_starters_and_copies_examples_with_the_files_that_they_name(self):
        offered = [line.split()[2] for line in self.calor("new").stdout.splitlines() if line.startswith("calor new ")]
        self.assertEqual(offered, ["plate", "rod", "disc", "weld", "coating", "shock", "crack"])
        for name in offered:
            self.calor("new", name)
            self.calor("check", f"{name}.toml")
        self.calor("new", "there/mine", "--from", "axisymmetric/thermal-shock")
        self.calor("check", "there/mine.toml")
        self.assertTrue((self.here / "there/rong-kisu/reference/thermal-shock-1023.csv").exists())
        self.assertIn("take one of", self.calor("new", "x", "--from", "thermal-shock", code=2).stderr)
        self.assertIn("did you mean 'weld'?", self.calor("new", "x", "--from", "welds", code=2).stderr)
        listed = self.calor("examples").stdout
        self.assertGreater(listed.count("\nrong-kisu/"), 10)
        self.assertLessEqual(max(map(len, listed.splitlines())), 80)
        self.assertIn("start/weld ", self.calor("examples", "weld").stdout)
        self.assertNotIn("start/rod ", self.calor("examples", "weld").stdout)

    def test_cloud_writes_the_points_and_nothing_else(self):
        self.calor("new", "plate")
        before = set(self.here.iterdir())
        said = self.calor("cloud", "plate.toml", "-o", "points").stdout
        for word in ("points", "spacing", "volume", "neighbours", "evenness", "face"):
            self.assertIn(word, said)
        self.assertEqual({f.name for f in set(self.here.iterdir()) - before}, {"points.vtu", "points-surface.vtp"})

    def test_check_says_sizes_and_step_and_memory_and_writes_nothing(self):
        self.calor("new", "plate")
        said = self.calor("check", "plate.toml").stdout
        for word in ("points", "neighbours", "explicit step", "memory"):
            self.assertIn(word, said)
        self.assertEqual([path.name for path in self.here.iterdir()], ["plate.toml"])

    def test_a_run_writes_the_result_folder(self):
        self.calor("new", "plate")
        done = self.calor("run", "plate.toml", "cloud.points=[11, 6]")
        self.assertEqual(done.stderr, "")
        self.assertNotIn("\r", done.stdout)
        self.assertEqual(done.stdout.splitlines()[-2:], ["results      results/plate",
                                                         "next         calor report results/plate"])
        result = self.here / "results" / "plate"
        self.assertEqual((result / "probes.csv").read_text().splitlines()[0], "time [s],hot [K],cold [K]")
        self.assertEqual((result / "energy.csv").read_text().splitlines()[0],
                         "time [s],stored [J],through heater [J],through air [J],imbalance")
        self.assertEqual((result / "balance.csv").read_text().splitlines()[0].split(",")[:3],
                         ["time [s]", "heat flow through heater [W]", "heat flow through air [W]"])
        pieces = [entry.get("file") for entry in xml.parse(result / "fields.pvd").iter("DataSet")]
        self.assertEqual(len(pieces), 13)  # the start and every 10 minutes of 2 hours
        self.assertTrue(all((result / piece).exists() for piece in pieces))
        self.assertIn("ok    probe cold", (result / "run.log").read_text())

        report = self.read_json("results/plate/report.json")
        self.assertEqual(report["file"], str((self.here / "plate.toml").resolve()))
        self.assertEqual(report["command"][:3], ["calor", "run", "plate.toml"])
        self.assertEqual(report["case"]["cloud"]["points"], [11, 6])
        self.assertEqual(report["case"]["output"]["samples"], 200)  # a default
        self.assertLessEqual({"calor", "petsc", "mpi"}, set(report["versions"]))
        self.assertLessEqual({"points", "pairs", "ranks", "steps", "rate_evaluations", "memory_bytes", "energy_imbalance"},
                             set(report["numbers"]))
        self.assertEqual(report["numbers"]["points"], 66)
        for phase in ("cloud", "weights", "march", "output"):
            self.assertLessEqual({"wall", "cpu"}, set(report["seconds"][phase]))
        self.assertEqual([entry["passed"] for entry in report["expect"]], [True, True])
        self.assertAlmostEqual(report["expect"][0]["reference"], 393.15)

    def test_a_body_that_exchanges_no_heat_keeps_its_temperature(self):
        self.calor("new", "plate")
        text = (self.here / "plate.toml").read_text()
        parts = text.partition("[boundary.heater]")[0], text.partition("[time]")[2].partition("[[expect]]")[0]
        (self.here / "plate.toml").write_text("[time]".join(parts))
        self.calor("run", "plate.toml")
        rows = (self.here / "results/plate/energy.csv").read_text().splitlines()
        self.assertEqual((rows[0], rows[-1]), ("time [s],stored [J],imbalance", "7200,0,0"))

    def test_results_go_where_they_are_told_and_quiet_means_silent(self):
        self.calor("new", "plate")
        done = self.calor("run", "plate.toml", "-o", "there/it/is", "--quiet")
        self.assertEqual((done.stdout, done.stderr), ("", ""))
        self.assertTrue((self.here / "there/it/is/report.json").exists())

    def test_a_failed_expectation_is_code_1(self):
        self.calor("new", "plate")
        done = self.calor("run", "plate.toml", "boundary.heater.flux=21 kW/m^2", "--units", "degC", code=1)
        # 21 kW/m^2 through 200 W/(m^2 K) make 105 K.
        self.assertIn("FAIL  probe cold at 7200 s: 125.000 degC, expected 120.000 degC, off by 5 K, allowed 0.01 K\n",
                      done.stdout)
        self.assertFalse(self.read_json("results/plate/report.json")["passed"])

    def test_every_number_of_a_report_may_be_expected_and_others_are_refused_before_the_run(self):
        crack = '[[crack]]\nx = ["10.5 mm", "10.5 mm"]\ny = ["0 mm", "5 mm"]\n'
        weld = '[weld]\nisotherm = "25 degC"\n[weld.extent.width]\nfrom = ["0 mm", "5 mm"]\nto = ["20 mm", "5 mm"]\n'
        source = '[source.coil]\npower = "1 W"\nwhere = "x < 5"\nlength = "mm"\n'
        self.calor("new", "plate")
        plate = re.sub(r"\[\[expect\]\].*", "", (self.here / "plate.toml").read_text(), flags=re.DOTALL)
        steady = re.sub(r"\[(time|output)\].*\n([a-z]+ .*\n)*", "", plate) + "[steady]\n"
        for name, text in {"transient": plate + crack + source, "weld": plate + weld, "steady": steady + source}.items():
            for method in ("sph", "peridynamics", "mlpg"):
                case = self.here / f"{name}.toml"
                case.write_text(text)
                self.calor("run", case.name, f"method={method}", *([] if name == "steady" else ["time.end=1 s"]), "--quiet")
                numbers = self.read_json(f"results/{name}/report.json")["numbers"]
                case.write_text(text + "".join(f'[[expect]]\nreport = "{number}"\nat_most = 1e300\n' for number in numbers))
                self.calor("check", case.name, f"method={method}")
            case.write_text(text + '[[expect]]\nreport = "heat_flow.haeter"\nat_most = 1\n')
            self.assertIn("did you mean 'heat_flow.heater'? it has points, ", self.calor("check", case.name, code=3).stderr)

    def test_layers_as_thick_as_a_cylinder_fill_its_facets(self):
        text = ('title = "Layers"\nmethod = "sph"\n[cloud]\nshape = "surface"\nspacing = "4 mm"\n[[cloud.part]]\nshape = "cylinder"\nname = "disc"\n'
                'radius = "10 mm"\nheight = "8 mm"\nturn = ["0 deg", "0 deg", "7 deg"]\n[body]\nalong = "x"\n[boundary.disc]\non = "disc.side"\n'
                'temperature = "300 K"\n[steady]\n')
        for material in ("a", "b"):
            text += f'[material.{material}]\nconductivity = "40 W/(m K)"\n[[body.layer]]\nmaterial = "{material}"\nthickness = "10 mm"\n'
        (self.here / "layers.toml").write_text(text)
        self.calor("check", "layers.toml")
        (self.here / "layers.toml").write_text(text.replace('"10 mm"\n[material', '"11 mm"\n[material'))
        self.assertIn("or say where they start", self.calor("check", "layers.toml", code=3).stderr)

    def test_what_does_nothing_is_told_with_its_place(self):
        self.calor("new", "plate")
        plate = re.sub(r"\[\[expect\]\].*", "", (self.here / "plate.toml").read_text(), flags=re.DOTALL)
        along = '[[crack]]\nx = ["0 mm", "20 mm"]\ny = ["10 mm", "10 mm"]\n'
        late = '[[crack]]\nx = ["10.5 mm", "10.5 mm"]\ny = ["0 mm", "5 mm"]\nopens = "20 s"\n'
        passes = "".join(f'[[source.arc.pass]]\nstart = "{t} s"\nfrom = ["0 mm", "{y} mm"]\nto = ["20 mm", "{y} mm"]\nspeed = "1 m/s"\n'
                         for t, y in ((0, 5), (1, 50), (5, 5)))
        arc = '[source.arc]\ncolumn = { radius = "3 mm" }\npower = "1 W"\n' + passes
        for text, words in (
                (along, "the crack does nothing: it runs between no two neighbouring points"),
                (late, "the crack opens at 20 s, after the end of the run"),
                (arc, "the source 'arc' does not touch the body on 1 of the 3 lines of its path"),
                (arc, "the source 'arc' begins 1 of the 3 lines of its path no earlier than the run ends, at 2 s"),
                ('[source.coil]\npower_density = { formula = "x > 10 ? 1e6 : 0", unit = "W/m^3" }\n', "the source 'coil' has given no heat"),
                ('[boundary.top]\non = "ymax"\nflux = { formula = "x > 1 ? 1 : 0", unit = "W/m^2" }\n', "the flux of [boundary.top] is 0 at all places")):
            (self.here / "idle.toml").write_text(plate + text)
            line = 1 + plate.count("\n") + (2 if "flux of" in words else 0)
            for ranks in ("1", "3"):
                said = self.calor("run", "idle.toml", "time.end=2 s", "-j", ranks).stderr
                self.assertRegex(said, rf"(?m)^idle.toml:{line}:\d+: .*{re.escape(words)}")

    def test_a_run_without_expectations_still_says_what_it_came_to(self):
        self.calor("new", "plate")
        text = (self.here / "plate.toml").read_text()
        (self.here / "plate.toml").write_text(text.partition("[[expect]]")[0])
        said = self.calor("run", "plate.toml", "--units", "degC").stdout.splitlines()
        self.assertEqual([line.split()[0] for line in said if line[0] != " "],
                         ["points", "integrator", "steps", "lowest", "highest", "heat", "time", "results", "next"])
        self.assertRegex(said[3], r"20\.00 degC at \(.*\) m, 0 s")
        self.assertRegex(said[4], r"13\d\.\d\d degC at \(.*\) m, \d+ s")
        # 20 kW/m^2 on 10 mm x 1 m for 2 h
        self.assertRegex(said[5], r"out by air .* MJ, in by heater 1.44 MJ, stored .* kJ")
        self.assertIn("integrator", self.calor("check", "plate.toml").stdout)
        for unit in ("mm", "degree"):
            self.assertIn("K, degC or degF", self.calor("check", "plate.toml", "--units", unit, code=3).stderr)

    def test_a_terminal_shows_verdicts_in_colour_unless_told_not_to(self):
        self.calor("new", "plate")
        for more, coloured in (({"CALOR_COLOUR": "1"}, True), ({"CALOR_COLOUR": "0"}, False), ({}, False)):
            done = subprocess.run([CALOR, "run", "plate.toml"], cwd=self.here, capture_output=True, text=True,
                                  env={**os.environ, **more})
            self.assertEqual("\x1b[32mok  \x1b[0m  probe cold" in done.stdout, coloured)

    def test_verify_counts_and_writes_json(self):
        self.calor("new", "good")
        text = (self.here / "good.toml").read_text()
        (self.here / "bad.toml").write_text(text.replace("20 kW/m^2", "21 kW/m^2"))
        (self.here / "wrong.toml").write_text(text.replace("flux", "fluks"))
        done = self.calor("verify", "good.toml")
        self.assertEqual(done.stdout.splitlines()[-1], "2 passed, 0 failed")
        done = self.calor("verify", ".", "--json", "list.json", code=1)
        self.assertEqual(done.stdout.splitlines()[-1], "2 passed, 3 failed")
        self.assertEqual(len(done.stdout.splitlines()), 6)
        entries = self.read_json("list.json")
        self.assertEqual([entry["passed"] for entry in entries], [False, False, True, True, False])
        for entry in entries:
            self.assertEqual(set(entry), {"case", "what", "norm", "unit", "error", "tolerance", "passed"})
        self.assertEqual((entries[2]["case"], entries[2]["unit"], entries[2]["tolerance"]), ("good", "K", 0.01))
        self.assertFalse((self.here / "results").exists())
        self.calor("verify", "nowhere", code=4)

    def test_a_quiet_run_still_says_which_expectation_failed(self):
        self.calor("new", "plate")
        with open(self.here / "plate.toml", "a") as case:
            case.write('[[expect]]\nmean = "steel"\nvalue = "1000 K"\nwithin = "1 K"\n')
        said = self.calor("run", "plate.toml", "--quiet", code=1).stdout.splitlines()
        self.assertEqual([line[:4] for line in said], ["FAIL"])

    def test_files_without_end_and_tables_without_bottom_are_refused(self):
        self.calor("new", "plate")
        self.assertIn("larger than 64 MB", self.calor("run", "/dev/zero", code=4).stderr)
        self.calor("run", "plate.toml", 'cloud={shape="csv", file="/dev/zero"}', code=3)
        for text in ("x = " + "{a = " * 20000 + "1" + "}" * 20000, "x = " + "[" * 20000, ".".join("a" * 20000) + " = 1"):
            (self.here / "deep.toml").write_text(text + "\n")
            self.assertIn("nested more than 100 deep", self.calor("run", "deep.toml", code=3).stderr)
        self.calor("run", "plate.toml", "-j", "10000", code=2)

    def test_doc_shows_everything_or_one_key(self):
        self.assertIn("# The case file", self.calor("doc").stdout)
        self.assertIn("\n  rings  whole number\n", self.calor("doc", "cloud").stdout)
        self.assertNotIn("\n  radius", self.calor("doc", "cloud.rings").stdout)
        self.assertTrue(self.calor("doc", "radiation").stdout.startswith("[boundary.NAME.radiation]\n"))

    def test_a_failed_run_leaves_no_report_of_an_earlier_one(self):
        self.calor("new", "plate")
        self.calor("run", "plate.toml")
        # Nothing is wrong at 293 K; above 300 K the conductivity is negative.
        self.calor("run", "plate.toml", 'material.steel.conductivity={formula="300 - T", unit="W/(m K)"}', code=5)
        result = self.here / "results" / "plate"
        self.assertFalse((result / "report.json").exists())
        self.assertTrue(json.loads((result / "report.earlier.json").read_text())["passed"])  # kept, but not for this run
        self.assertIn("the conductivity of 'steel' is -", (result / "run.log").read_text())

    def test_nothing_of_an_earlier_run_in_the_folder_passes_for_a_result(self):
        self.calor("new", "plate")
        self.calor("new", "weld")
        own = self.here / "there/fields/notes.txt"  # no file of a run
        self.calor("run", "weld.toml", "output.format=xdmf", "-o", "there")
        own.write_text("mine")
        self.calor("run", "plate.toml", "-o", "there")
        self.calor("run", "plate.toml", "-o", "new")
        files = {str(path.relative_to(self.here / "there")) for path in (self.here / "there").rglob("*") if path.is_file()}
        fresh = {str(path.relative_to(self.here / "new")) for path in (self.here / "new").rglob("*") if path.is_file()}
        self.assertEqual(files - fresh, {"fields/notes.txt"})

    def test_temperatures_that_nothing_explains_are_told(self):
        # A source whose path crosses a hole, on points as far apart as it is wide.
        (self.here / "ring.toml").write_text("""
title = "A source across a hole"
method = "mlpg"
cloud = { shape = "surface", spacing = "2 mm", part = [{ shape = "annulus", inner = "5 mm", outer = "20 mm" }] }
material.steel = { conductivity = "40 W/(m K)", density = "7850 kg/m^3", specific_heat = "470 J/(kg K)" }
initial.temperature = "20 degC"
[source.arc]
power = "1 kW"
line = {}
pass = [{ from = ["-15 mm", "2.5 mm"], to = ["12 mm", "-7.5 mm"], speed = "24 mm/s" }]
[time]
end = "1 s"
""")
        said = self.calor("run", "ring.toml").stderr
        self.assertRegex(said, r"a temperature of 2\d\d.* K at .* is \d+(\.\d+)? K below all of start, walls and surroundings, though nothing else takes heat out")
        self.assertNotIn("above all", said)
        self.assertNotIn("below all", self.calor("run", "ring.toml", "method=sph").stderr)
        self.calor("new", "plate")
        said = self.calor("run", "plate.toml", 'boundary.air.convection.ambient={formula="300-t",unit="K"}', code=1).stderr
        self.assertRegex(said, r"a temperature of -\d+.* K at .* is below absolute zero")

    def test_a_steady_state_says_which_functions_of_time_it_takes_at_the_start(self):
        self.calor("new", "plate")
        steady = re.sub(r"(?ms)^\[(time|output|initial)\].*?(?=^\[)", "", (self.here / "plate.toml").read_text()) + "[steady]\n"
        changed = steady.replace('flux = "20 kW/m^2"', 'flux = { formula = "2e4*cos(t)", unit = "W/m^2" }')
        line = 1 + changed[:changed.index("2e4*cos")].count("\n")
        (self.here / "steady.toml").write_text(changed)
        self.assertIn(f"steady.toml:{line}:20: a function of time: the steady state is that of t = 0", self.calor("run", "steady.toml").stderr)
        (self.here / "steady.toml").write_text(steady)
        self.assertNotIn("of time", self.calor("run", "steady.toml").stderr)

    def test_a_table_that_ends_before_the_temperatures_of_its_face_or_material_is_told(self):
        self.calor("new", "plate")
        h = 'boundary.air.convection.h={ table = [[280, 20], [%s, 40]], of = "temperature", unit = "W/(m^2 K)" }'
        said = self.calor("run", "plate.toml", h % 310, code=1).stderr
        self.assertRegex(said, r"this table ends at 310 K, and boundary.air was at \d+(\.\d+)? K, with the value of its last row")
        self.assertNotIn("begins", said)
        self.assertNotIn("this table", self.calor("run", "plate.toml", h % 3000, code=1).stderr)
        level = h.replace("[%s, 40]]", "[310, 40], [320, 40]]")  # known to stay as it is
        self.assertNotIn("this table", self.calor("run", "plate.toml", level, code=1).stderr)

    def interrupt(self, *words, number, code):
        """Starts a long run with a terminal for its errors, interrupts it once the progress line shows."""
        self.calor("new", "plate")
        environment = dict(os.environ)
        try:
            terminal, end = pty.openpty()
        except OSError:  # a root without /dev/pts: a pipe that calls itself a terminal
            terminal, end = os.pipe()
            environment["CALOR_TERMINAL"] = "1"
        run = subprocess.Popen([CALOR, "run", "plate.toml", *LONG, *words], cwd=self.here, env=environment,
                               stdout=subprocess.PIPE, stderr=end)
        os.close(end)
        shown = b""
        while b" left" not in shown:
            shown += os.read(terminal, 1000)
        self.assertRegex(shown, rb"\r.* %  t = .* s  step \d+  .* left")
        run.send_signal(number)
        while True:  # until the other end is closed
            try:
                more = os.read(terminal, 1000)
            except OSError:
                break
            if not more:
                break
            shown += more
        run.communicate()
        os.close(terminal)
        self.assertEqual(run.returncode, code)
        self.assertIn(f"interrupted by signal {code - 128}".encode(), shown)
        self.assertIn(b"--restart goes on from t = ", shown)
        self.assertTrue((self.here / "results/plate/checkpoint-0").exists())
        report = self.read_json("results/plate/report.json")
        self.assertFalse(report["passed"])
        reached = report["numbers"]["end"]
        result = self.here / "results" / "plate"
        last = (result / "energy.csv").read_text().splitlines()[-1].split(",")
        self.assertEqual((float(last[0]), len(last)), (reached, 5))
        field = list(xml.parse(result / "fields.pvd").iter("DataSet"))[-1]
        self.assertEqual(float(field.get("timestep")), reached)
        self.assertTrue((result / field.get("file")).exists())

    def test_an_interrupted_run_stays_readable(self):
        self.interrupt(number=signal.SIGINT, code=130)

    def test_a_terminated_run_stays_readable(self):
        self.interrupt(number=signal.SIGTERM, code=143)

    def test_a_run_whose_terminal_is_gone_stays_readable(self):
        self.interrupt(number=signal.SIGHUP, code=129)

    def test_an_interrupted_run_on_two_processes_stays_readable(self):
        self.interrupt("-j", "2", number=signal.SIGINT, code=130)

    def test_a_run_on_two_processes_that_a_batch_system_warns_stays_readable(self):
        self.interrupt("-j", "2", number=signal.SIGUSR1, code=130)

    def test_a_terminated_run_on_two_processes_stays_readable_also_where_mpiexec_passes_no_signal_on(self):
        # As with plug-ins that take the signals of mpiexec.
        (self.here / "bin").mkdir()
        mpiexec = self.here / "bin/mpiexec"
        mpiexec.write_text(f"#!/bin/sh\ntrap '' USR1 TERM INT HUP\n{shutil.which('mpiexec')} \"$@\"\n")
        mpiexec.chmod(0o755)
        with unittest.mock.patch.dict(os.environ, PATH=f"{self.here}/bin:{os.environ['PATH']}"):
            self.interrupt("-j", "2", number=signal.SIGTERM, code=143)

    def ranks_of(self, run):
        """Process ids of mpiexec and its ranks, once all of them are there."""
        def children(parent):
            return [int(p.name) for p in pathlib.Path("/proc").iterdir() if p.name.isdigit() and self.parent(p.name) == parent]
        while True:
            self.assertIsNone(run.poll())
            launchers = children(run.pid)
            ranks = [rank for launcher in launchers for rank in children(launcher)]
            if len(ranks) >= 2 and (self.here / "results/plate/energy.csv").exists():
                return launchers + ranks
            time.sleep(0.1)

    @staticmethod
    def parent(pid):
        try:
            return int(pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            return None

    def test_nothing_outlives_the_command(self):
        for signals, stopped in ([signal.SIGKILL], False), ([signal.SIGTERM, signal.SIGTERM], True):
            with self.subTest(signals=signals):
                shutil.rmtree(self.here / "results", ignore_errors=True)
                (self.here / "plate.toml").unlink(missing_ok=True)
                self.calor("new", "plate")
                run = subprocess.Popen([CALOR, "run", "plate.toml", *LONG, "-j", "2", "--quiet"], cwd=self.here)
                all_of_them = self.ranks_of(run)
                if stopped:  # a rank that answers no more
                    os.kill(all_of_them[-1], signal.SIGSTOP)
                for number in signals:
                    run.send_signal(number)
                    time.sleep(0.5)
                run.wait()
                for _ in range(1200):
                    alive = [pid for pid in all_of_them if self.state(pid) != "Z"]
                    if not alive:
                        break
                    time.sleep(0.1)
                self.assertEqual(alive, [])

    @staticmethod
    def state(pid):
        try:
            return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return "Z"

    def files(self, name):
        folder = self.here / name
        return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*")
                if path.is_file() and path.name not in ("run.log", "report.json")}

    def test_a_run_that_its_time_limit_ended_is_code_75_and_goes_on_with_the_same_bits(self):
        self.calor("new", "plate")
        self.calor("run", "plate.toml", "-o", "whole")
        said = self.calor("run", "plate.toml", "-o", "parts", "--time-limit", "1ms", code=75)
        self.assertIn("the time limit is over: parts holds the results so far; --restart goes on from t = ", said.stderr)
        self.assertFalse(self.read_json("parts/report.json")["passed"])
        self.calor("run", "plate.toml", "-o", "parts", "--restart", "--time-limit", "0.001 s", code=75)
        self.assertIn("restarted at t = ", self.calor("run", "plate.toml", "-o", "parts", "--restart").stderr)
        self.assertEqual(self.files("whole"), self.files("parts"))
        for wrong in ("soon", "3 m", "-1s", "0s"):
            self.calor("run", "plate.toml", "--time-limit", wrong, code=2)

    def test_a_restart_without_a_checkpoint_or_of_another_case_is_refused(self):
        self.calor("new", "plate")
        self.assertIn("there is no checkpoint to go on from", self.calor("run", "plate.toml", "--restart", code=4).stderr)
        self.calor("run", "plate.toml", "--time-limit", "1ms", code=75)
        said = self.calor("run", "plate.toml", "--restart", "boundary.heater.flux=21 kW/m^2", code=3).stderr
        self.assertIn("is of another case: boundary.heater.flux is", said)
        self.calor("run", "plate.toml", "--restart")
        self.assertIn("there is no checkpoint", self.calor("run", "plate.toml", "--restart", code=4).stderr)

    def start(self, *words):
        """A long run, once it has rows."""
        if not (self.here / "plate.toml").exists():
            self.calor("new", "plate")
        run = subprocess.Popen([CALOR, "run", "plate.toml", *LONG, *words], cwd=self.here, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
        while not (self.here / "results/plate/run.lock").exists() or not (self.here / "results/plate/energy.csv").exists():
            self.assertIsNone(run.poll())
            time.sleep(0.05)
        return run

    def test_a_second_run_into_a_folder_is_refused_with_the_process_of_the_first(self):
        run = self.start()
        said = self.calor("run", "plate.toml", code=4).stderr
        self.assertRegex(said, rf"another run writes into this folder: process {run.pid} on .* since \d{{4}}-")
        run.kill()
        run.communicate()
        self.calor("run", "plate.toml")  # the lock ends with its process
        self.assertFalse((self.here / "results/plate/run.lock").exists())

    def test_a_run_whose_folder_is_removed_ends_and_claims_no_results(self):
        run = self.start("output.samples=100000")
        (self.here / "results").rename(self.here / "removed")  # at once: a run that writes fills what rmtree empties
        out, err = run.communicate()
        self.assertEqual((run.returncode, out), (4, ""))
        self.assertIn("results/plate", err)
        self.assertEqual(len(err.splitlines()), 1)

    def test_a_process_that_is_killed_alone_ends_the_run_with_a_line(self):
        run = self.start("-j", "2", "output.checkpoint_steps=100")
        while not (self.here / "results/plate/checkpoint-1").exists():
            time.sleep(0.05)
        os.kill(self.ranks_of(run)[-1], signal.SIGKILL)
        _, err = run.communicate()
        self.assertEqual(run.returncode, 137)
        self.assertIn("ended by signal 9 (Killed): results/plate holds the results so far; --restart goes on from t = ", err)

    def test_an_interrupt_before_there_is_a_result_ends_the_run_at_once(self):
        self.calor("new", "plate")
        steady = ["cloud.points=[1500, 1500]", "variant=steady"]
        text = (self.here / "plate.toml").read_text()
        (self.here / "plate.toml").write_text(text + '[[variant]]\nname = "steady"\nremove = ["time"]\nset = {steady = {}}\n')
        for words in steady, [*steady, "-j", "2"]:
            with self.subTest(words=words):
                run = subprocess.Popen([CALOR, "run", "plate.toml", *words], cwd=self.here, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True)
                time.sleep(2)
                self.assertIsNone(run.poll())
                run.send_signal(signal.SIGINT)
                out, err = run.communicate()
                self.assertEqual((run.returncode, out), (130, ""))
                self.assertEqual(len(err.splitlines()), 1, err)

    def test_output_that_cannot_be_written_is_code_4_and_the_results_are_there(self):
        self.calor("new", "plate")
        for words in ["run", "plate.toml"], ["check", "plate.toml"], ["doc"], ["--help"], ["verify", "plate.toml"]:
            with self.subTest(words=words), open("/dev/full", "w") as full:
                done = subprocess.run([CALOR, *words], cwd=self.here, stdout=full, stderr=subprocess.PIPE, text=True)
                self.assertEqual(done.returncode, 4)
                self.assertIn("standard output cannot be written: No space left on device", done.stderr)
        self.assertTrue(self.read_json("results/plate/report.json")["passed"])
        closed = subprocess.run(["sh", "-c", f"'{CALOR}' run plate.toml -o closed >&- 2>&- <&-"], cwd=self.here)
        self.assertEqual(closed.returncode, 0)
        self.assertEqual((self.here / "closed/probes.csv").read_bytes(), (self.here / "results/plate/probes.csv").read_bytes())

    def test_what_the_machine_lacks_is_code_6(self):
        self.calor("new", "plate")
        for limit in "ulimit -n 5", "ulimit -v 450000":
            with self.subTest(limit=limit):
                done = subprocess.run(["sh", "-c", f"{limit}; exec '{CALOR}' run plate.toml 'cloud.points=[2001, 1001]'"],
                                      cwd=self.here, capture_output=True, text=True)
                self.assertEqual(done.returncode, 6, done.stderr)
                self.assertIn("calor: ", done.stderr.splitlines()[-1])
        done = subprocess.run([CALOR, "run", "plate.toml"], cwd=self.here, env={}, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_cloud_that_is_kept_is_read_by_the_next_run_and_gives_the_same_bits(self):
        self.calor("new", "plate")

        def run(*words):
            self.calor("run", "plate.toml", "cloud.points=[11, 6]", "cloud.jitter=0.2", "-o", "there", *words)
            return re.findall(r"(\w+) read from", (self.here / "there/run.log").read_text()), self.files("there")

        keep = "cloud.keep=true"
        with unittest.mock.patch.dict(os.environ, CALOR_CACHE=str(self.here / "kept")):
            for words, kept in ((["method=sph"], ["volumes", "weights"]), (["method=mlpg"], ["volumes", "faces"]),
                                (["method=sph", "-j", "2"], ["volumes", "weights"])):
                plain = run(*words)
                self.assertEqual(run(*words, keep), ([], plain[1]))
                self.assertEqual(run(*words, keep), (kept, plain[1]))
            self.assertEqual(run("method=sph", keep, "cloud.seed=2")[0], [])
            body = [str(CASES / "body/hole.toml"), keep]
            self.assertNotIn("read from", self.calor("check", *body).stdout)
            self.assertEqual(re.findall(r"(\w+) read from", self.calor("check", *body).stdout), ["volumes", "weights"])

    def test_a_full_disk_and_a_folder_that_is_read_only_are_code_4(self):
        self.calor("new", "plate")
        said = self.calor("run", "plate.toml", "-o", "/proc/results", code=4).stderr
        self.assertIn("cannot be written", said)
        # A file may not grow beyond 20 kB: the disk is full.
        done = subprocess.run(["sh", "-c", f"trap '' XFSZ; ulimit -f 20; exec '{CALOR}' run plate.toml output.samples=5000"],
                              cwd=self.here, capture_output=True, text=True)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("cannot be written: File too large", done.stderr)

    def test_odd_names_and_other_languages_change_nothing(self):
        (self.here / "a b 'ü\n").mkdir()
        self.calor("new", "a b 'ü\n/plate")
        self.calor("run", "a b 'ü\n/plate.toml", "-o", "a b 'ü\n/ results")
        done = subprocess.run([CALOR, "run", "a b 'ü\n/plate.toml", "-o", "there"], cwd=self.here,
                              env={**os.environ, "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"})
        self.assertEqual(done.returncode, 0)
        self.assertEqual(self.files("a b 'ü\n/ results"), self.files("there"))

    def test_several_processes_say_what_one_says(self):
        self.calor("new", "plate")
        one = self.calor("run", "plate.toml", "boundary.heater.on=left", code=3)
        two = self.calor("run", "plate.toml", "boundary.heater.on=left", "-j", "2", code=3)
        self.assertEqual(one.stderr, two.stderr)
        self.assertEqual(self.calor("run", "plate.toml", "-j", "2").stdout.count("ok    "), 2)
        self.assertEqual(self.read_json("results/plate/report.json")["numbers"]["ranks"], 2)


if __name__ == "__main__":
    unittest.main()
