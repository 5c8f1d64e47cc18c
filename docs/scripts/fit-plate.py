#!/usr/bin/python3
"""fit-plate.py CALOR: makes the readings of cases/fit/plate-field.toml, and compares what `calor fit` finds with the truth.

The plate of the case conducts by a formula here, TRUE, and the 56 readings get random noise of 0.5 K."""
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
TRUE = "20 + 9*exp(-((x-62)^2 + (y-52)^2)/18^2) - 7*exp(-((x-30)^2 + (y-28)^2)/16^2)"  # W/(m K), of x and y in mm
NOISE, SEED = 0.5, 1  # K


def true_conductivity(x, y):
    return eval(TRUE.replace("^", "**"), {"exp": np.exp, "x": x, "y": y})


def seconds(work):
    """What the work returns, and the time of all processors that it takes."""
    def used():
        return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))

    begin = used()
    done = work()
    return done, used() - begin


folder = ROOT / "cases/fit"
with tempfile.TemporaryDirectory() as work:
    os.chdir(work)
    shutil.copy(folder / "plate-field.toml", ".")
    case = Case("plate-field.toml")
    true = Case({**{key: value for key, value in case.to_dict().items() if key not in ("fit", "expect")},
                 "material": {"plate": {"conductivity": {"formula": TRUE, "unit": "W/(m K)", "length": "mm"}}}})
    probes = true.run("true", show_progress=False).probes
    random = np.random.default_rng(SEED)
    with open("plate-field.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["probe", "T [degC]"])
        table.writerows((name, f"{probes[name][-1] - 273.15 + random.normal(0, NOISE):.2f}") for name in probes if name != "time")
    shutil.copy("plate-field.csv", folder)
    _, forward = seconds(lambda: [case.run("once", show_progress=False) for _ in range(10)])
    found, taken = seconds(lambda: fit.fit(case, "fit", say=print))
    print(found.table())
    grid = case.to_dict()["material"]["plate"]["conductivity"]["grid"]
    x, y = np.meshgrid(np.linspace(0, 100, len(grid)), np.linspace(0, 80, len(grid[0])), indexing="ij")
    error = found.values - true_conductivity(x, y).ravel()
    print(f"{forward / 10:.3f} s a run; {taken:.2f} s: the time of {taken / (forward / 10):.0f} runs, of which the fit counts {found.runs}")
    print(f"error of the {error.size} values: rms {np.sqrt(np.mean(error**2)):.2f} W/(m K), before {np.std(true_conductivity(x, y) - 20):.2f}; "
          f"{100 * np.mean(np.abs(error) <= 1.96 * found.deviation):.0f} % within the intervals")
