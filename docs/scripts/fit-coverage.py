#!/usr/bin/python3
"""fit-coverage.py CALOR [SEEDS]: how often the intervals of `calor fit` hold the truth.

The readings of cases/fit/thermal-barrier.toml are made anew with other noise of 1 K for every seed; printed are the shares of
seeds whose 95 % intervals hold the values that the readings were made with, how often all three lie within two standard
deviations, the runs that a fit took, and its processor time in that of runs without derivatives."""
import csv
import os
import pathlib
import resource
import shutil
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
CALOR = str(pathlib.Path(sys.argv[1]).resolve())
sys.path.insert(0, str(ROOT / "python"))

from calor import Case, command, fit  # noqa: E402

command.find_command = lambda: CALOR
TRUE = {"material.ysz.conductivity": (1.05, "W/(m K)"), "boundary.radiation.radiation.emissivity": (0.8, ""),
        "boundary.air.convection.h": (800, "W/(m^2 K)")}



def processor_time():
    """Of this process and all runs so far, s."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    for file in (ROOT / "cases/fit").iterdir():
        shutil.copy(file, ".")
    case = Case("thermal-barrier.toml")
    probes = case.changed({key: f"{value} {unit}" if unit else value for key, (value, unit) in TRUE.items()}).run("true", show_progress=False).probes
    with open("thermal-barrier.csv", newline="") as file:
        heading, *rows = csv.reader(file)
    t = np.array([float(row[0]) for row in rows])
    begin = processor_time()
    for _ in range(20):
        case.changed({"output.fields": False}).run("once", show_progress=False)
    a_run = (processor_time() - begin) / 20
    inside, near, runs, taken = np.zeros(len(TRUE)), 0, [], 0.0
    for seed in range(int(sys.argv[2]) if len(sys.argv) > 2 else 200):
        random = np.random.default_rng(seed)
        readings = [np.interp(t, probes["time"], probes[name.split()[0]]) - 273.15 + random.normal(0, 1, t.size) for name in heading[1:]]
        with open("thermal-barrier.csv", "w", newline="") as file:
            table = csv.writer(file)
            table.writerow(heading)
            table.writerows(zip(t, *readings))
        begin = processor_time()
        found = fit.fit(case, "fit")
        taken += processor_time() - begin
        runs.append(found.runs)
        away = [abs(value - TRUE[u.key][0]) / s for u, value, s in zip(found.unknowns, found.values, found.deviation)]
        inside += np.less_equal(away, 1.96)
        near += max(away) <= 2
    for key, share in zip(TRUE, inside / len(runs)):
        print(f"{key:<40} {100 * share:.1f} %")
    print(f"all three within two standard deviations: {100 * near / len(runs):.1f} %")
    print(f"{len(runs)} seeds, {np.mean(runs):.1f} runs a fit, at most {max(runs)}; the time of {taken / len(runs) / a_run:.1f} runs of {a_run:.3f} s")
