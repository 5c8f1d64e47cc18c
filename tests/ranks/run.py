#!/usr/bin/env python3
"""Runs cases on several ranks and compares their results with those of one rank.

  run.py CALOR RANKS[,RANKS] [PART OF A NAME ...]

The cases are those of this folder, in which some ranks have no wall, no source, no region or hardly a point, and those of
cases/ that do not take long; the variants of the latter on three ranks only. Of several numbers of ranks each is
compared with the same run of one rank.
"""
import csv
import fnmatch
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
CASES = HERE.parent.parent / "cases"
TOLERANCE = 1e-7  # of the span of temperatures in the results of a case, or of the largest value of a column
# Where a thermostat holds a temperature by switching, rounding moves the steps within its ramp of 0.01 K.
SWITCHING, TOLERANCE_OF_SWITCHING = "field/thermostat*", 1e-4
LIMIT = 900  # s; nothing here takes more than a few on an idle machine, unless ranks wait for each other for ever
# Those of many points, and of many steps: of these the ranks do nothing but wait for each other's messages.
LONG = ["anisotropic/block/mlpg-jittered", "anisotropic/turned-square/*81", "body/blade/*", "body/flange/*", "body/radiating-sphere*", "body/sphere/*", "body/t-joint/*", "body/tube-in-tube/*", "body/two-layer-sphere/*",
        "dan/W?D*/mlpg*", "dan/W3D/peridynamics", "dan/circles*", "dan/convection/virtual-faces", "dan/cube-*",
        "dan/rosenthal-*", "dan/steel*", "field/latent-heat-as-a-box/euler", "rong-kisu/convection-3d/paper*", "rong-kisu/fig3/paper*", "rong-kisu/fig3/to-the-end",
        "rong-kisu/fig5-transient*", "rong-kisu/fig6*", "rong-kisu/fig7-fig8/paper", "rong-kisu/fig9/cylinder*",
        "rong-kisu/fig9/paper-40*", "rong-kisu/thermal-shock*",
        "start/jittered/mlpg-81", "start/weld*", "wang/fig*/*"]
# What is nothing but round-off, or says how it was computed (a face between two ranks counts on both: "neighbours" of mlpg).
NOISE = {"ranks", "neighbours", "memory_bytes", "residual", "imbalance", "weight_residual", "energy_imbalance", "area_sum", "moment_sum",
         "volume_error", "newton_iterations", "linear_iterations",
         "face_iterations", "lambda_iterations", "source_error", "average_temperature_error"}


def variants(case):
    return ["", *(variant["name"] for variant in tomllib.loads(case.read_text()).get("variant", []))]


def name_of(case, variant):
    return f"{case.parent.name}/{case.stem}" + (f"/{variant}" if variant else "")


def is_wanted(case, variant, ranks, parts):
    name = name_of(case, variant)
    if parts:
        return any(part in name for part in parts)
    return case.parent == HERE or not (variant and ranks == 2 or any(fnmatch.fnmatch(name, long) for long in LONG))


def run(command, case, variant, folder):
    words = [*command, "run", case.name, "-o", str(folder), "--quiet"] + ([f"variant={variant}"] if variant else [])
    process = subprocess.Popen(words, cwd=case.parent, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        said, _ = process.communicate(timeout=LIMIT)
    except subprocess.TimeoutExpired:
        process.kill()  # its ranks end with it
        process.communicate()
        return f"not at its end after {LIMIT} s"
    return None if process.returncode in (0, 1) else f"exit code {process.returncode}: {said.strip()}"


def columns(path):
    """{name: numbers} of a CSV file, its rows in the order of the column id where there is one."""
    with path.open() as file:
        header, *rows = csv.reader(file)
    if "id" in header:
        rows.sort(key=lambda row: int(row[header.index("id")]))
    return {name: [float(row[n]) for row in rows] for n, name in enumerate(header)}


def span_of(tables):
    """Between the lowest and the highest temperature; in a body of one temperature a little of that."""
    T = [value for table in tables.values() for name, values in table.items() if name.endswith("[K]") for value in values]
    return max(max(T) - min(T), 1e-4 * max(map(abs, T))) if T else 0


def scale_of(name, numbers, span):
    """What a difference of a number of the report is compared with: extremes and means of parts of a body at rest, or what
    flows through its walls, are nothing but round-off of the span and of the largest flow."""
    kind = name.partition(".")[0]
    if kind in ("minimum", "maximum", "mean"):
        return max(span, 1e-12)
    if kind in ("heat", "stored"):
        return max(*(abs(value) for other, value in numbers.items() if other.startswith(("heat.", "stored"))), 1e-3)
    if kind == "heat_flow":
        return max(*(abs(value) for other, value in numbers.items() if other.startswith("heat_flow.")), 1e-3)
    return max(abs(numbers[name]), 1e-12)


def differences(one, several, tolerance):
    """What differs between two result folders, one line each."""
    reports = [json.loads((folder / "report.json").read_text()) for folder in (one, several)]
    numbers, other_numbers = (report["numbers"] for report in reports)
    tables = {name: columns(one / name) for name in ("final.csv", "probes.csv", "weld.csv") if (one / name).exists()}
    span = span_of(tables)
    for file, left in tables.items():
        if file == "weld.csv":
            continue
        right = columns(several / file)
        for name, values in left.items():
            others = right.get(name, [])
            if len(values) != len(others):
                yield f"{file}, {name}: {len(values)} and {len(others)} rows"
                continue
            scale = (span if name.endswith("[K]") else max(map(abs, values), default=0)) or 1
            off = max((abs(a - b) for a, b in zip(values, others)), default=0) / scale
            if not off <= tolerance:
                yield f"{file}, {name}: off by {off:.2g} of the span"
    for name, value in numbers.items():
        other = other_numbers.get(name, math.nan)
        if name not in NOISE and not abs(value - other) <= tolerance * scale_of(name, numbers, span):
            yield f"report, {name}: {value} and {other}"
    passed, other_passed = (report["passed"] for report in reports)
    if passed != other_passed:
        yield f"report: passed {passed} and {other_passed}"


def compare(calor, case, variant, several_ranks):
    """{ranks: what differs from one rank}"""
    with tempfile.TemporaryDirectory() as folder:
        one = pathlib.Path(folder) / "one"
        fault = run([str(calor)], case, variant, one)
        if fault:
            return {1: [fault]}
        faults = {}
        is_switching = fnmatch.fnmatch(name_of(case, variant), SWITCHING)
        tolerance = TOLERANCE_OF_SWITCHING if is_switching else TOLERANCE
        for ranks in several_ranks:
            several = pathlib.Path(folder) / str(ranks)
            fault = run(["mpiexec", "--quiet", "-n", str(ranks), str(calor)], case, variant, several)
            faults[ranks] = [fault] if fault else list(differences(one, several, tolerance))
        return faults


def main():
    calor, wanted = pathlib.Path(sys.argv[1]).resolve(), sys.argv[3:]
    all_ranks = [int(ranks) for ranks in sys.argv[2].split(",")]
    os.environ["CALOR_CHECK_COLLECTIVES"] = "1"
    failed = count = 0
    for case in sorted([*CASES.rglob("*.toml"), *HERE.glob("*.toml")]):
        for variant in variants(case):
            several_ranks = [ranks for ranks in all_ranks if is_wanted(case, variant, ranks, wanted)]
            if not several_ranks:
                continue
            faults = compare(calor, case, variant, several_ranks)
            count += 1
            failed += any(faults.values())
            for ranks, lines in faults.items():
                for line in lines:
                    print(f"FAIL  {name_of(case, variant)} on {ranks} ranks: {line}", flush=True)
    print(f"{count - failed} cases are the same on any number of ranks, {failed} are not")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
