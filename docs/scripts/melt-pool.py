#!/usr/bin/python3
"""Draws docs/img/melt-pool.png from the result of docs/tutorial-welding.md: the melt pool at 8 s, and its length over time.

  calor run cases/start/weld.toml -o results/weld && docs/scripts/melt-pool.py

Needs numpy and matplotlib."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cases"))
from plotting import np, plt, read_csv, read_vtu  # noqa: E402

fields = read_vtu(ROOT / "results/weld/fields/fields_0002.vtu")
x, y = 1e3 * fields["Points"][:, 0], 1e3 * fields["Points"][:, 1]
T = fields["temperature [K]"] - 273.15
order = np.lexsort((x, y))
X, Y, T = (v[order].reshape(-1, len(np.unique(np.round(x, 6)))) for v in (x, y, T))

top, bottom = plt.subplots(2, 1, figsize=(9, 6))[1]
for side in (1, -1):
    filled = top.contourf(X, side * Y, T, levels=[20, 200, 400, 600, 800, 1000, 1200, 1450, 3000], cmap="inferno")
    top.contour(X, side * Y, T, levels=[1450], colors="white")
plt.colorbar(filled, ax=top, label="T [degC]")
top.set(title="8 s; white: 1450 degC", xlabel="x [mm]", ylabel="y [mm]", aspect="equal", ylim=(-20, 20))
weld = read_csv(ROOT / "results/weld/weld.csv")
bottom.plot(weld["time"], 1e3 * weld["length"], label="length of the pool")
bottom.plot(weld["time"], 1e3 * weld["half_width"], label="half width at x = 60 mm")
bottom.set(xlabel="t [s]", ylabel="mm", xlim=(0, 15))
bottom.legend()
plt.tight_layout()
plt.savefig(ROOT / "docs/img/melt-pool.png", dpi=110)
