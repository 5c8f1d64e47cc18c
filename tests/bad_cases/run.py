#!/usr/bin/env python3
"""Every case in this folder is wrong. `calor run` and `calor check` must refuse it with the exit code and the words of its
first line, print nothing else, and leave an earlier result as it was.

  run.py CALOR [NAME ...]

  # expect CODE: message      first line of a case: the whole message; '...' stands for anything
  # words: key=value -o DIR   second line, if any: further words on the command line

Code 5 stands for cases that go wrong while they run; they are only run.
"""
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
EARLIER = {"report.json": '{"passed": true}\n', "probes.csv": "time [s],a [K]\n0,300\n", "fields/fields_0000.vtu": "<VTKFile/>\n"}


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def faults(calor, case):
    """What is wrong with how calor treats the case, one line each."""
    lines = case.read_text().splitlines()
    expected = re.fullmatch(r"# expect (\d): (.+)", lines[0])
    if not expected:
        return ["its first line is not '# expect CODE: message'"]
    code, message = int(expected[1]), ".*".join(map(re.escape, expected[2].split("...")))
    words = lines[1].removeprefix("# words: ").split() if lines[1].startswith("# words: ") else []
    found = []

    def try_verb(verb, words):
        done = subprocess.run([calor, verb, case.name, *words], cwd=HERE, capture_output=True, text=True)
        if done.returncode != code:
            found.append(f"{verb}: exit code {done.returncode} instead of {code}")
        if not re.fullmatch(message, done.stderr.rstrip("\n")):
            found.append(f"{verb} says      {done.stderr.rstrip()}\n    instead of {expected[2]}")
        if code != 5 and done.stdout:
            found.append(f"{verb} prints {done.stdout!r}")

    with tempfile.TemporaryDirectory() as folder:
        result = pathlib.Path(folder)
        for name, text in EARLIER.items():
            (result / name).parent.mkdir(exist_ok=True)
            (result / name).write_text(text)
        try_verb("run", words if "-o" in words else [*words, "-o", folder])
        if code != 5:
            if contents(result) != {name: text.encode() for name, text in EARLIER.items()}:
                found.append(f"run changed an earlier result: {sorted(contents(result))}")
            if "-o" not in words:
                try_verb("check", words)
    return found


def main():
    calor = str(pathlib.Path(sys.argv[1]).resolve())
    cases = sorted(HERE.glob("*.toml"))
    if len(sys.argv) > 2:
        cases = [case for case in cases if case.stem in sys.argv[2:]]
    before = contents(HERE)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(lambda case: faults(calor, case), cases))
    failed = 0
    for case, found in zip(cases, results):
        failed += bool(found)
        for fault in found:
            print(f"{case.name}: {fault}")
    if contents(HERE) != before:
        failed += 1
        print("files beside the cases have changed")
    print(f"{len(cases)} wrong cases, {failed} failures")
    return 1 if failed or not cases else 0


if __name__ == "__main__":
    sys.exit(main())
