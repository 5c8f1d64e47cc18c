#!/usr/bin/python3
"""The JSON Schema of `calor doc --schema`: all shipped cases fit, wrong ones of tests/bad_cases whose form is wrong do
not, and taplo, by which editors check TOML, says the same where it is installed (./dev test does). run.py CALOR

A schema sees keys that are unknown, missing or of another choice, values of a wrong kind, without a unit or among no
choices, and cases that are neither steady nor transient. It does not see what depends on several values or on the
body: units that do not convert, formulas that fail, walls with two conditions, places outside, files."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest

try:
    import jsonschema
except ImportError:
    sys.exit(77)  # python3-jsonschema is missing: ctest skips this

CALOR = str(pathlib.Path(sys.argv.pop(1)).resolve())
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# What the reader says where the form of a case is wrong, rather than its numbers.
FORM = (r"\.toml.*(is not a key of|(\]|the case) needs '|has no unit|cannot be (the number|the text|a list|a table|true|false)|goes with|"
        r"It is one of|neither \[steady\] nor \[time\]|both \[steady\] and \[time\]|a table needs at least two)")
TAPLO = shutil.which("taplo", path=str(ROOT / "build/npm/node_modules/.bin")) or shutil.which("taplo")
SHIPPED = sorted([*(ROOT / "cases").rglob("*.toml"), *(ROOT / "tests" / "ranks").glob("*.toml")])
BAD = sorted((ROOT / "tests" / "bad_cases").glob("*.toml"))


class SchemaTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        schema = json.loads(subprocess.run([CALOR, "doc", "--schema"], capture_output=True, text=True, check=True).stdout)
        jsonschema.Draft7Validator.check_schema(schema)
        cls.schema = schema
        cls.validator = jsonschema.Draft7Validator(schema)

    def faults(self, case):
        return [f"{'/'.join(map(str, error.absolute_path))}: {error.message[:200]}" for error in self.validator.iter_errors(case)]

    def test_all_shipped_cases_fit(self):
        self.assertGreater(len(SHIPPED), 50)
        for path in SHIPPED:
            with self.subTest(case=path.stem):
                self.assertEqual(self.faults(tomllib.loads(path.read_text())), [])

    def test_cases_of_a_wrong_form_do_not_fit(self):
        seen = 0
        for path in BAD:
            text = path.read_text()
            head, second = text.splitlines()[:2]
            if not re.search(FORM, head) or second.startswith("# words:"):
                continue
            try:
                case = tomllib.loads(text)
            except tomllib.TOMLDecodeError:
                continue
            seen += 1
            with self.subTest(case=path.stem, head=head):
                self.assertNotEqual(self.faults(case), [])
        self.assertGreater(seen, 10)

    @unittest.skipUnless(TAPLO, "npm install --prefix build/npm @taplo/cli")
    def test_taplo_refuses_the_same_cases(self):
        wrong = set()
        for path in SHIPPED + BAD:
            try:
                if self.faults(tomllib.loads(path.read_text())):
                    wrong.add(str(path))
            except tomllib.TOMLDecodeError:
                wrong.add(str(path))
        with tempfile.TemporaryDirectory() as folder:
            schema = pathlib.Path(folder) / "calor.schema.json"
            schema.write_text(json.dumps(self.schema))
            lint = subprocess.run([TAPLO, "lint", "--no-auto-config", "--schema", schema.as_uri(), *SHIPPED, *BAD],
                                  capture_output=True, text=True)
        self.assertEqual(set(re.findall(r'invalid file.*path="(.*)"', lint.stdout + lint.stderr)), wrong)

    def test_an_editor_learns_sentence_unit_choices_and_default_of_a_key(self):
        cloud = self.schema["properties"]["cloud"]["properties"]
        self.assertIn("disc", cloud["shape"]["enum"])
        self.assertEqual(cloud["thickness"]["default"], "1 m")
        self.assertEqual(cloud["thickness"]["description"], "Thickness of a body of two dimensions. [m]")
        self.assertEqual(self.schema["required"], ["title", "cloud", "material", "method"])


if __name__ == "__main__":
    unittest.main()
