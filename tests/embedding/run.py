#!/usr/bin/env python3
"""Installs calor, builds examples/embedding with the installed package alone, and runs it: run.py CMAKE BUILD_FOLDER"""
import gzip
import pathlib
import subprocess
import sys
import tempfile
import unittest

CMAKE, BUILD = sys.argv.pop(1), sys.argv.pop(1)
EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/embedding"


class Embedding(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.prefix, cls.program = pathlib.Path(folder.name) / "installed", pathlib.Path(folder.name) / "build/embedding"
        cls.do(CMAKE, "--install", BUILD, "--prefix", cls.prefix)
        cls.do(CMAKE, "-G", "Ninja", "-S", EXAMPLE, "-B", cls.program.parent, f"-DCMAKE_PREFIX_PATH={cls.prefix}")
        cls.do(CMAKE, "--build", cls.program.parent)

    @staticmethod
    def do(*words, code=0):
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode != code:
            raise AssertionError(f"{words[0]} ends with {done.returncode}\n{done.stdout}{done.stderr}")
        return done

    def test_a_program_that_embeds_the_library_steps_to_the_exact_temperatures(self):
        case = self.prefix / "share/calor/cases/start/plate.toml"
        lines = self.do(self.program, case, "7200", "4").stdout.splitlines()
        self.assertEqual([line.split()[0] for line in lines], ["1800", "3600", "5400", "7200"])
        # Steady: 20 kW/m^2 over 200 W/(m^2 K) above air of 20 degC, and over 20 mm / (40 W/(m K)) above that.
        hot, cold = (float(word) for word in lines[-1].split()[2::2])
        self.assertAlmostEqual(hot, 403.15, delta=0.01)
        self.assertAlmostEqual(cold, 393.15, delta=0.01)

    def test_an_error_is_an_exception_and_nothing_is_printed_besides(self):
        case = self.prefix / "wrong.toml"
        case.write_text((self.prefix / "share/calor/cases/start/plate.toml").read_text().replace("flux", "fluks"))
        done = self.do(self.program, case, "1", "1", code=3)
        self.assertEqual((done.stdout, done.stderr.count("\n")), ("", 1))
        self.assertIn(f"{case}:25:1: 'fluks' is not a key of [boundary.heater]", done.stderr)

    def test_the_installed_command_runs_and_has_a_manual_page(self):
        version = self.do(self.prefix / "bin/calor", "--version").stdout.strip()
        page = gzip.decompress((self.prefix / "share/man/man1/calor.1.gz").read_bytes()).decode()
        self.assertIn(f'"{version}"', page)
        for verb in ("run", "check", "verify", "new", "examples", "doc", "help"):
            self.assertIn(f".B {verb}\n", page)


if __name__ == "__main__":
    unittest.main()
