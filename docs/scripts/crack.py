#!/usr/bin/python3
"""Draws docs/img/crack.png: the temperature of cases/start/crack.toml beside the exact one, and the jump across the crack.

  calor run cases/start/crack.toml variant=80 -o results/crack/80 && docs/scripts/crack.py

Needs numpy and matplotlib."""
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cases"))
from plotting import read_vtu  # noqa: E402

fields = read_vtu(next(p for p in sorted(pathlib.Path("results/crack/80/fields").iterdir()) if p.suffix in (".vtu", ".pvtu")))
x, y = fields["Points"][:, 0], fields["Points"][:, 1]
T = fields["temperature [K]"]
a = 0.5

left, right = plt.subplots(1, 2, figsize=(10, 4.2))[1]
for part in (y > 0, y < 0):  # apart, so that no contour crosses the crack
    order = np.lexsort((x[part], y[part]))
    shape = (-1, len(np.unique(np.round(x[part], 9))))
    X, Y, Z = (v[part][order].reshape(shape) for v in (x, y, T))
    left.contour(X, Y, Z, levels=np.linspace(-1, 1, 21), cmap="coolwarm")
left.plot([-a, a], [0, 0], "k", linewidth=2)
left.set(title="isotherms, 0.1 K apart", xlabel="x [m]", ylabel="y [m]", aspect="equal")

beside = np.abs(y) < 1.5 / 79
s = np.linspace(-1, 1, 1001)
right.plot(s, np.sqrt(np.clip(a**2 - s**2, 0, None)), "k", s, -np.sqrt(np.clip(a**2 - s**2, 0, None)), "k", linewidth=1)
right.plot(x[beside], T[beside], ".", color="tab:red", markersize=4)
right.set(title="faces of the crack: exact (line), points beside (dots)", xlabel="x [m]", ylabel="T [K]")
plt.tight_layout()
plt.savefig(ROOT / "docs" / "img" / "crack.png", dpi=110)
