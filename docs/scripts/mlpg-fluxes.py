#!/usr/bin/python3
"""Prints the table of docs/three-methods.md: what the fluxes of MLPG make of five problems on lattices.

  docs/scripts/mlpg-fluxes.py [CALOR]        CALOR: the program, by default build/release/calor"""
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
CALOR = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/calor"

CUBE = """
title = "Cube"
method = "mlpg"
[cloud]
shape = "box"
size = ["1 m", "1 m", "1 m"]
points = [17, 17, 17]
[material.m]
conductivity = "1 W/(m K)"
density = "1 kg/m^3"
specific_heat = "1 J/(kg K)"
[output]
fields = false
[[expect]]
field = true
norm = "rms"
of = "range"
value = {{ formula = "{T}", unit = "K" }}
within = "100 %"
"""
HELD = """
[steady]
[boundary.walls]
on = ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"]
temperature = {{ formula = "{T}", unit = "K" }}
"""
HARMONIC = "300 + exp(1.25*x)*sin(y)*sin(0.75*z)"
SMOOTH = "300 + sin(2*x + 0.5)*exp(y)*cos(z)"
WAVE = "300 + cos(pi*x)*cos(pi*y)*cos(pi*z)*exp(-3*pi^2*t)"

# Green's function of the box with mirror images, integrated over time to 12 digits: 400 W on a whole plate,
# sigma = 0.5 mm, 20 mm/s from x = 2 mm, below the centre of the source after 0.3 s.
GAUSSIAN = """
title = "Gaussian over a surface"
method = "mlpg"
[cloud]
shape = "box"
size = ["12 mm", "6 mm", "4 mm"]
spacing = "0.25 mm"
[material.m]
conductivity = "50 W/(m K)"
density = "7850 kg/m^3"
specific_heat = "500 J/(kg K)"
[initial]
temperature = "300 K"
[boundary.top]
on = "zmin"
flux = { formula = "400/(2*pi*0.5^2)*exp(-((x-2-20*t)^2+y^2)/(2*0.5^2))", unit = "W/mm^2", length = "mm" }
[time]
end = "0.3 s"
[output]
fields = false
[probe]
peak = ["8 mm", "0 mm", "0 mm"]
[[expect]]
probe = "peak"
value = "2759.28344 K"
within = "2459 K"
"""

# Neumann's solution: water at 10 degC frozen from a wall at -20 degC, equal properties of both phases, after 4 h.
FREEZING = """
title = "Freezing wall"
method = "mlpg"
[cloud]
shape = "box"
size = ["100 mm"]
points = [101]
[material.w]
conductivity = "0.6 W/(m K)"
density = "1000 kg/m^3"
specific_heat = "4200 J/(kg K)"
latent_heat = "334 kJ/kg"
solidus = "-0.02 degC"
liquidus = "0.02 degC"
[initial]
temperature = "10 degC"
[boundary.xmin]
temperature = "-20 degC"
[time]
end = "4 h"
[output]
fields = false
[probe]
ice = ["20 mm"]
[[expect]]
probe = "ice"
value = "268.08494 K"
within = "30 K"
"""

# Name, case, what an error of 100 % is (K); none: the case says it in %.
PROBLEMS = [
    ("steady cube without sources, 17^3", CUBE.format(T=HARMONIC) + HELD.format(T=HARMONIC), None),
    ("steady cube with sources, 17^3",
     CUBE.format(T=SMOOTH) + HELD.format(T=SMOOTH) + "[source.inside]\npower_density = "
     '{ formula = "4*sin(2*x + 0.5)*exp(y)*cos(z)", unit = "W/m^3" }\n', None),
    ("fading cosine, insulated cube, 17^3",
     CUBE.format(T=WAVE) + f'[initial]\ntemperature = {{ formula = "{WAVE.split("*exp")[0]}", unit = "K" }}\n'
     '[time]\nend = "0.02 s"\n', None),
    ("0.5 mm Gaussian moving over a surface, spacing 0.25 mm", GAUSSIAN, 2459.28),
    ("freezing wall, 101 points", FREEZING, 30),
]

print("| | flux | error | steps | time [s] |")
print("|---|---|---|---|---|")
for name, case, span in PROBLEMS:
    for flux in ("parameters", "edge-stabilised", "averaged"):
        if case is FREEZING and flux == "averaged":
            continue  # in one dimension it is the edge-stabilised one
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "case.toml"
            file.write_text(case)
            done = subprocess.run([CALOR, "run", file, f"mlpg.flux={flux}", "-o", f"{folder}/out", "--quiet"],
                                  capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"{name}, {flux}: {done.stderr}")
            report = json.loads((pathlib.Path(folder) / "out/report.json").read_text())
        error = report["expect"][0]["error"] if span is None else 100 * report["expect"][0]["error"] / span
        seconds = sum(phase["cpu"] for phase in report["seconds"].values())
        steps = report["numbers"].get("steps", 0)
        print(f"| {name if flux == 'parameters' else ''} | {flux} | {error:.2g} % | {steps:.0f} | {seconds:.2g} |")
