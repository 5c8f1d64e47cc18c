#!/usr/bin/python3
"""Prints the tables of docs/which-method.md: a weld and a coating at several spacings and tolerances by all methods.

  docs/scripts/which-spacing.py [CALOR]        CALOR: the program, by default build/release/calor"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
CALOR = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/calor"
METHODS = ("sph", "peridynamics", "mlpg")



def run(case, *keys):
    """The report, the rows of cooling.csv and the last row of probes.csv."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        subprocess.run([CALOR, "run", case, *keys, "-o", out, "--quiet"], capture_output=True)
        report = json.loads((out / "report.json").read_text())
        report["cpu"] = sum(phase["cpu"] for phase in report["seconds"].values())
        cooling = list(csv.DictReader(open(out / "cooling.csv"))) if (out / "cooling.csv").exists() else []
        return report, cooling, list(csv.DictReader(open(out / "probes.csv")))[-1]


def weld(name, *keys):
    report, cooling, _ = run(ROOT / "cases/start/weld.toml", *keys)
    n = report["numbers"]
    time = cooling[0]["cooling time [s]"]
    print(f"| {name} | {float(cooling[0]['peak [K]']) - 273.15:.0f} | {float(time) if time else float('nan'):.2f} | "
          f"{1e3 * n['largest_length']:.1f} | {1e3 * n['largest_half_width']:.2f} | {n['steps']:.0f} | {report['cpu']:.1f} |")


print("| spacing | peak 5 mm from the weld [degC] | t8/5 [s] | length of the pool [mm] | half its width [mm] | steps | time [s] |")
print("|---|---|---|---|---|---|---|")
for spacing, methods in (("4 mm", METHODS), ("2 mm", METHODS), ("1 mm", METHODS[:2]), ("0.5 mm", METHODS[:1])):
    for method in methods:
        weld(f"{spacing}, {method}", f"method={method}", f'cloud.spacing="{spacing}"')
for tolerance in ("10 K", "0.1 K"):
    weld(f"2 mm, sph, tolerance {tolerance}", 'cloud.spacing="2 mm"', f'time.tolerance="{tolerance}"')

print()
print("| points | | surface, metal, back after 50 ms [K] | after 0.5 s [K] | steps | time [s] |")
print("|---|---|---|---|---|---|")
text = (ROOT / "cases/start/coating.toml").read_text()
text = text[:text.index("# 600 K over")].replace("\n[steady]\n", '\n[initial]\ntemperature = "600 degC"\n[time]\nend = "1 s"\n')
with tempfile.TemporaryDirectory() as folder:
    case = pathlib.Path(folder) / "coating.toml"
    case.write_text(text)
    for points in (13, 25, 49, 97, 193, 769):
        for method in METHODS if points < 769 else METHODS[:1]:
            values = []
            for end in ("50 ms", "0.5 s"):
                report, _, last = run(case, f"method={method}", f"cloud.points=[{points}]", f'time.end="{end}"')
                values.append(", ".join(f"{float(v):.1f}" for k, v in last.items() if k != "time [s]"))
            print(f"| {points} | {method} | {values[0]} | {values[1]} | {report['numbers']['steps']:.0f} | {report['cpu']:.2f} |")
