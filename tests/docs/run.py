#!/usr/bin/python3
"""The commands of the documentation do what the pages say, and the notebooks run: run.py CALOR

Every block ```console of docs/tutorial-*.md has lines "$ COMMAND" and below each the lines of its output that matter, in
their order; `...` stands for anything. The commands of a page run one after the other in one empty folder. So do the
blocks ```python of the pages on Python. Commands of other pages, which may take long, are read: verbs, options, keys and
files in them exist. Notebooks need python3-nbconvert and python3-ipykernel, and run the command of build/release."""
import functools
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


def written_commands():
    """(place, command) of all lines of the documentation that start calor, ./dev or a script."""
    for page in [*sorted(DOCS.glob("*.md")), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "bench/README.md"))]:
        for number, line in enumerate(page.read_text().splitlines(), 1):
            if found := re.match(r"(?:    |\$ |    \$ )((?:build/release/)?calor .*|\./dev .*|(?:/usr/bin/)?(?:python3 )?(?:docs|tests)/\S+\.py.*)", line):
                for command in found[1].split("; "):
                    yield f"{page.name}:{number}", command


@functools.cache
def says(*words):
    done = subprocess.run([CALOR, *words], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.stdout if done.returncode == 0 else ""


def what_is_wrong(command):
    """With a command of the documentation: words that do not exist."""
    command = re.split(r"\s+#|\s{3,}", command)[0]  # a remark
    first, *rest = re.sub(r"[][]", " ", command).split()
    files = re.findall(r"(?<![\w/.-])(?:cases|bench|docs|tests)/[\w./-]+", command)
    wrong = [name for name in files if not (ROOT / name).exists()]
    if first == "./dev":
        return wrong + [word for word in rest[:1] if f"./dev {word}" not in (ROOT / "dev").read_text()]
    if not first.endswith("calor"):
        return wrong
    verb = rest[0]
    helped = says("help", verb) or "-h --help"
    options = re.findall(r"(?<![\w-])--?[a-z][\w-]*", re.sub(r"(['\"]).*?\1", " ", command))
    wrong += [option for option in options if not re.search(rf"(?<![\w-]){option}(?![\w-])", helped)]
    keys = re.findall(r"(?<![\w.])([a-z_]+(?:\.\w+)+)=", command)
    return wrong + [key for key in keys if not says("doc", key)] + ([] if says("help", verb) else [verb])


class Commands(unittest.TestCase):
    def test_the_commands_of_all_pages_exist_with_their_options_keys_and_files(self):
        count = 0
        for place, command in written_commands():
            with self.subTest(place):
                self.assertEqual(what_is_wrong(command), [], command)
            count += 1
        self.assertGreater(count, 60)
        self.assertEqual(what_is_wrong("calor rnu cases/none.toml --fast cloud.raduis=1"), ["cases/none.toml", "--fast", "cloud.raduis", "rnu"])

    def run_blocks(self, page):
        with tempfile.TemporaryDirectory() as folder:
            for case in ("plate", "coating"):
                subprocess.run([CALOR, "new", case], cwd=folder, check=True, capture_output=True)
            blocks = re.findall(r"^```python\n(.*?)^```", (DOCS / page).read_text(), re.MULTILINE | re.DOTALL)
            self.assertGreater(len(blocks), 2)
            done = subprocess.run([sys.executable, "-c", "\n".join(blocks)], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  env={**os.environ, "PYTHONPATH": str(ROOT / "python"), "MPLBACKEND": "Agg",
                                       "PATH": f"{CALOR.parent}:{os.environ['PATH']}"})
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    @unittest.skipUnless(all(map(importlib.util.find_spec, ("matplotlib", "vtkmodules", "pandas"))), "apt-get install python3-pandas")
    def test_the_page_on_python_runs(self):
        self.assertIn("method command line (method): 'method' cannot be \"spf\": did you mean \"sph\"? It is one of", self.run_blocks("python.md"))

    @unittest.skipUnless((ROOT / "build/release/python").exists(), "./dev core")
    def test_the_page_on_the_library_in_python_runs(self):
        self.run_blocks("core.md")


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
