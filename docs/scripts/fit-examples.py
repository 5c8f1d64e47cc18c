#!/usr/bin/python3
"""fit-examples.py CALOR: makes the readings of cases/fit/slab-of-temperature.toml, shock-of-a-jet.toml and weld.toml anew, from the
values in TRUE with random noise, and compares with these what `calor fit` finds; of the jet also from its first two probes alone."""
import csv
import json
import os
import pathlib
import re
import shutil
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
CALOR = str(pathlib.Path(sys.argv[1]).resolve())
sys.path.insert(0, str(ROOT / "python"))

from calor import Case, command, fit, quantities  # noqa: E402

command.find_command = lambda: CALOR
SEED = 3
RADII = np.arange(0, 29, 4)
TRUE = {
    "slab-of-temperature": {f"material.steel.conductivity.table[{n}][1]": k for n, k in enumerate((17, 20, 24, 27, 29, 28))},
    "shock-of-a-jet": {f"boundary.jet.convection.h.table[{n}][1]": float(h) for n, h in enumerate(np.round(0.4 + 3.6 * np.exp(-(RADII / 10) ** 2), 3))},
    "weld": {"source.arc.efficiency": 0.75, "source.arc.column.sigma": "6 mm"},
}


def make_readings(name):
    """Writes NAME.csv, and the single values into the case."""
    case = Case(f"{name}.toml")
    written = case.to_dict()
    result = case.changed(quantities.changes_at(written, TRUE[name])).run("true", show_progress=False)
    random = np.random.default_rng(SEED)
    data = written["fit"]["data"]
    columns = [entry for entry in data if "probe" in entry]
    noise = quantities.in_unit(columns[0]["noise"], "K", difference=True)
    probes = result.probes
    with open(f"{name}.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["time [s]", *(f"{entry['column']} [degC]" for entry in columns)])
        for n, t in enumerate(probes["time"]):
            if n:
                table.writerow([f"{t:g}", *(f"{probes[entry['probe']][n] - 273.15 + random.normal(0, noise):.2f}" for entry in columns)])
    shutil.copy(f"{name}.csv", ROOT / "cases/fit")
    for entry in data:
        if "report" in entry:
            value = 1e3 * result.numbers[entry["report"]] + random.normal(0, quantities.split(entry["noise"])[0])
            for path in (pathlib.Path(f"{name}.toml"), ROOT / f"cases/fit/{name}.toml"):
                path.write_text(re.sub(r'(report = "peak_width"\nvalue  = )"[^"]*"', rf'\1"{value:.2f} mm"', path.read_text()))


def find(name, case):
    found = fit.fit(case, f"{name}-fit")
    true = np.array([quantities.split(value)[0] for value in TRUE[name].values()])
    away = np.abs(found.values - true) / found.deviation
    print(f"\n{name}\n{found.table()}\ntrue: {', '.join(f'{value:g}' for value in true)}; away by {', '.join(f'{a:.1f}' for a in away)} standard deviations")
    return found


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    for file in (ROOT / "cases/fit").iterdir():
        shutil.copy(file, ".")
    for name in TRUE:
        make_readings(name)
        find(name, Case(f"{name}.toml"))
    jet = Case("shock-of-a-jet.toml")
    found = find("shock-of-a-jet", jet.changed({"fit.data": jet.to_dict()["fit"]["data"][:2]}))
    prior = np.array([u.within for u in found.unknowns])
    print(f"standard deviations over those expected: {json.dumps(np.round(found.deviation / prior, 2).tolist())}")
