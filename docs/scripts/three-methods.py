#!/usr/bin/python3
"""Prints the table of docs/three-methods.md: cases/start/three-methods.toml by every method on four clouds.

  docs/scripts/three-methods.py [CALOR]        CALOR: the program, by default build/release/calor"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
CALOR = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/calor"

print("| points | | rms error [mK] | steps | time [s] | memory [MB] |")
print("|---|---|---|---|---|---|")
for jitter in (0, 0.2):
    for n in (21, 41, 81):
        for method in ("sph", "peridynamics", "mlpg"):
            folder = ROOT / "results/three-methods" / f"{method}-{n}-{jitter}"
            subprocess.run(
                [CALOR, "run", ROOT / "cases/start/three-methods.toml", f"method={method}", f"cloud.points=[{n}, {n}]",
                 f"cloud.jitter={jitter}", "-o", folder, "--quiet"], stdout=subprocess.DEVNULL)
            report = json.load(open(folder / "report.json"))
            seconds = sum(phase["cpu"] for phase in report["seconds"].values())
            cloud = f"{n} x {n}{', jittered' if jitter else ''}" if method == "sph" else ""
            print(f"| {cloud} | {method} | {1e3 * report['expect'][0]['error']:.2g} | {report['numbers']['steps']:.0f} | "
                  f"{seconds:.2g} | {report['numbers']['memory_bytes'] / 1e6:.0f} |")
