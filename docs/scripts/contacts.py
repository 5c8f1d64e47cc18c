#!/usr/bin/env python3
"""contacts.py [CALOR]: the table of contacts in docs/cracks.md.

T = cos(2x) [b sinh(2 (y - c)) +- b/h cosh(2 (y - c))] above and below a contact of h at y = c through a square of 1 m,
k = 1 W/(m K), b = 0.3 h K, of 1e5 W/(m^2 K) 0.3 K; all walls held.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

CASE = """title = "Contact in a square"
method = "{method}"
cloud = {{ shape = "box", size = ["1 m", "1 m"], points = [{n}, {n}], at = "{at}" }}
steady = {{ tolerance = 1e-12 }}
output = {{ fields = false }}
material.m = {{ conductivity = "1 W/(m K)" }}
crack = [{{ x = ["-0.5 m", "1.5 m"], y = ["{c:.10f} m", "{c:.10f} m"], contact = "{h:g} W/(m^2 K)" }}]
[boundary.walls]
on = ["xmin", "xmax", "ymin", "ymax"]
temperature = {{ formula = "{T}", unit = "K" }}
[[expect]]
field = true
norm = "rms"
value = {{ formula = "{T}", unit = "K" }}
within = "1e-12 K"
"""


def error(calor: str, method: str, at: str, n: int, beside: float, h: float) -> float:
    spacing = 1 / (n - 1) if at == "walls" else 1 / n
    row = 0.5 if at == "walls" or n % 2 else 0.5 + spacing / 2
    c, b = row + beside * spacing, 0.3 * h if h < 100 else 0.3
    T = f"cos(2*x)*({b:g}*sinh(2*(y-{c:.10f})) + (y > {c - 1e-9:.10f} ? 1 : -1)*{b / h:g}*cosh(2*(y-{c:.10f})))"
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder) / "contact.toml"
        case.write_text(CASE.format(method=method, n=n, at=at, c=c, h=h, T=T))
        said = subprocess.run([calor, "run", case, "-o", folder + "/results"], capture_output=True, text=True).stdout
    return float(re.search(r"mean square of ([0-9.e+-]+) K", said).group(1))


def main() -> None:
    calor = sys.argv[1] if len(sys.argv) > 1 else "build/release/calor"
    print("| contact | SPH | peridynamics |\n|---|---|---|")
    for name, at, beside, h in (("on a row", "walls", 0, 4), ("0.25 spacings beside it", "walls", 0.25, 4), ("midway between two rows", "walls", 0.5, 4),
                                ("0.25 spacings beside a row, 1e5 W/(m^2 K)", "walls", 0.25, 1e5), ("cell centres, midway", "cells", 0.5, 4)):
        errors = [[f"{error(calor, method, at, n, beside, h):.1e}".replace("e-0", "e-") for n in (11, 21, 41)] for method in ("sph", "peridynamics")]
        print(f"| {name} | {', '.join(errors[0])} | {', '.join(errors[1])} |")


if __name__ == "__main__":
    main()
