#!/usr/bin/python3
"""The commands of the tutorials do what the pages say, and the notebooks run: run.py CALOR

Every block ```console of docs/tutorial-*.md has lines "$ COMMAND" and below each the lines of its output that matter, in
their order; `...` stands for anything. The commands of a page run one after the other in one empty folder. Notebooks need
python3-nbconvert and python3-ipykernel, and run the command of build/release."""
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

CALOR = pathlib.Path(sys.argv.pop(1)).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
HAS_NOTEBOOKS = all(map(importlib.util.find_spec, ("nbconvert", "ipykernel", "matplotlib", "vtkmodules")))


def commands(page):
    """(command, lines that its output has) of a page."""
    for block in re.findall(r"^```console\n(.*?)^```", page, re.MULTILINE | re.DOTALL):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, *lines = part.splitlines()
            yield command, lines


def missing(lines, output):
    """The first line that the output does not have behind those before it; None where all are there."""
    rest = iter(output.splitlines())
    for line in lines:
        pattern = re.compile(".*".join(re.escape(piece) for piece in line.split("...")))
        if not any(pattern.fullmatch(said.rstrip()) for said in rest):
            return line
    return None


class Tutorials(unittest.TestCase):
    def test_the_commands_of_the_tutorials_say_what_the_pages_say(self):
        count = 0
        for page in sorted(DOCS.glob("tutorial-*.md")):
            with tempfile.TemporaryDirectory() as folder:
                environment = {**os.environ, "PATH": f"{CALOR.parent}:{os.environ['PATH']}"}
                for command, lines in commands(page.read_text()):
                    done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, text=True,
                                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                    line = missing(lines, done.stdout)
                    self.assertIsNone(line, f"{page.name}: $ {command}\ndoes not say: {line}\nbut:\n{done.stdout}")
                    count += 1
        self.assertGreater(count, 10)

    @unittest.skipUnless(HAS_NOTEBOOKS, "apt-get install python3-nbconvert python3-ipykernel")
    def test_the_notebooks_run_to_their_ends(self):
        notebooks = sorted((DOCS / "notebooks").glob("*.ipynb"))
        if not (ROOT / "build/release/python").exists():  # calor.core
            notebooks.remove(DOCS / "notebooks/core.ipynb")
        self.assertGreaterEqual(len(notebooks), 3)
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir",
                                   folder, *notebooks], env={**os.environ, "PYTHONPATH": str(ROOT / "python")},
                                  text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
