#!/usr/bin/env python3
"""Errors of a transient wall of two layers, conductivities 1 : 20, with the interface on a point and between points.

    docs/scripts/two-layers.py [CALOR]

Largest error of three probes (in each layer and on the interface) after 0.3 s against 2561 points, and its order.
"""
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

CALOR = sys.argv[1] if len(sys.argv) > 1 else "build/release/calor"
CASE = """
title = "Two layers"
method = "{method}"
[cloud]
shape = "box"
size = ["1 m"]
points = [{points}]
at = "{at}"
[material.a]
conductivity = "1 W/(m K)"
density = "1 kg/m^3"
specific_heat = "1 J/(kg K)"
[material.b]
conductivity = "20 W/(m K)"
density = "2 kg/m^3"
specific_heat = "1 J/(kg K)"
[body]
along = "x"
[[body.layer]]
material = "a"
thickness = "{interface} m"
[[body.layer]]
material = "b"
thickness = "{rest} m"
[initial]
temperature = "300 K"
[boundary.xmin]
convection = {{ h = "5 W/(m^2 K)", ambient = "400 K" }}
[time]
end = "0.3 s"
integrator = "tr-bdf2"
tolerance = "1e-5 K"
[output]
fields = false
samples = 1
[probe]
a = ["0.1 m"]
interface = ["{interface} m"]
b = ["0.95 m"]
"""


def probes(folder, **values):
    case = pathlib.Path(folder) / "wall.toml"
    case.write_text(CASE.format(rest=1 - values["interface"], **values))
    subprocess.run([CALOR, "run", case, "-o", case.with_suffix("")], check=True, capture_output=True)
    with open(case.with_suffix("") / "probes.csv") as file:
        return [float(value) for value in list(csv.reader(file))[-1][1:]]


with tempfile.TemporaryDirectory() as folder:
    for at, one_more, methods in (("walls", 1, ("sph", "peridynamics", "mlpg")), ("cells", 0, ("sph", "peridynamics"))):
        for interface in (0.5, 0.3714, 0.6237):
            exact = probes(folder, method="sph", points=2560 + one_more, at=at, interface=interface)
            for method in methods:
                errors = []
                for cells in (16, 32, 64, 128):
                    found = probes(folder, method=method, points=cells + one_more, at=at, interface=interface)
                    errors.append(max(abs(a - b) for a, b in zip(found, exact)))
                orders = [math.log2(a / b) for a, b in zip(errors, errors[1:])]
                print(f"{at} {interface:6} {method:12}", *(f"{e:8.1e}" for e in errors), "K, order",
                      *(f"{o:.1f}" for o in orders), flush=True)
