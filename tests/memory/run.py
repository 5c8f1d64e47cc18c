#!/usr/bin/env python3
"""Reads and writes beside what was allocated, and values never set, by valgrind: run.py UNIT_TESTS CALOR

Those of the unit tests that are short, and small runs by all methods on one rank and on two. ./dev sanitize looks at more,
and takes an hour. Exits with 77 (skipped) without valgrind."""
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
CASES = HERE.parents[1] / "cases"
# What MPI itself does.
SUPPRESSIONS = [path for path in (HERE / "mpi.supp", pathlib.Path("/usr/share/openmpi/openmpi-valgrind.supp")) if path.exists()]
FOUND = 9
VALGRIND = ["valgrind", "--quiet", f"--error-exitcode={FOUND}", *(f"--suppressions={path}" for path in SUPPRESSIONS)]
# Suites that take more than 0.15 s without valgrind, which is 30 times slower, or start other programs.
LONG = """*Parallel Anisotropic Archive BodyCloud CellIntegrals CellSamples Combine Command ContactCells Correction Cracks
CracksOfCases Derivatives Fibres GradedClouds HeatSystem Integrators Jitter LatticeImages Melting MeshCloud Meshes/* Methods/*
Metric MirrorImages MlpgConvergence MlpgStability Peridynamics PointTags Restart Run ShippedCases SolidShapes Source SurfaceFiles
ThermalStress Twin""".split()
RUNS = [  # ranks, case, changes
    (1, "start/crack.toml", "cloud.points=[21,21]"),
    (1, "start/crack.toml", "method=mlpg", "cloud.points=[21,21]"),
    (2, "start/crack.toml", "method=peridynamics", "cloud.points=[21,21]"),
    (1, "start/jittered.toml", "cloud.points=[12,12]"),
    (2, "start/jittered.toml", "method=mlpg", "cloud.points=[12,12]"),
    (1, "start/coating.toml",),
    (2, "field/thermostat.toml",),
    (1, "field/circuit-board.toml",),
    (2, "body/brazed-plates.toml",),
]


def command(ranks, case, changes, folder):
    calor = [*VALGRIND, str(pathlib.Path(sys.argv[2]).resolve()), "run", str(CASES / case), "-o", folder, "--quiet", *changes]
    return calor if ranks == 1 else ["mpiexec", "--quiet", "-n", str(ranks), *calor]


def main():
    if not shutil.which("valgrind"):
        print("valgrind is not here")
        return 77
    short = "-" + ":".join(f"{suite}.*" for suite in LONG)
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        jobs = [("unit tests", [*VALGRIND, sys.argv[1], "--gtest_brief=1", "--gtest_filter=" + short])]
        jobs += [(f"{case} {' '.join(changes)} on {ranks}", command(ranks, case, changes, f"{folder}/{n}"))
                 for n, (ranks, case, *changes) in enumerate(RUNS)]
        for name, words in jobs:
            done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            if done.returncode not in (0, 1):  # 1: an expectation that so coarse a cloud does not meet
                faults += 1
                print(f"FAIL  {name}: exit code {done.returncode}\n{done.stdout}", flush=True)
    print(f"{len(jobs) - faults} programs keep within their memory, {faults} do not")
    return faults > 0


if __name__ == "__main__":
    sys.exit(main())
