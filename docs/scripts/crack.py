#!/usr/bin/python3
"""Draws docs/img/crack.png: the temperature of cases/start/crack.toml, and the jump across the crack beside the exact one.

  calor run cases/start/crack.toml variant=80 -o results/crack/80 && docs/scripts/crack.py

Needs numpy, matplotlib and python3-vtk9."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cases"))
from plotting import Paper, colour_bar, draw_section, np, plt, put_legend, theme  # noqa: E402

paper = Paper(ROOT / "cases" / "start", results="results/crack", figures=ROOT / "docs" / "img")
result = paper.result("80")
fields, a = result.fields(), 0.5
with theme():
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), width_ratios=(1, 1.1))
    filled = draw_section(left, result)
    colour_bar(figure, filled, left, "T [K]")
    left.set(title="a plate with a crack")
    beside = abs(fields.x[:, 1]) < 1.5 / 79
    s = np.linspace(-1, 1, 1001)
    jump = np.sqrt(np.clip(a**2 - s**2, 0, None))
    right.plot(s, jump, s, -jump, color="black", linewidth=1)
    right.plot(fields.x[beside, 0], fields["temperature"][beside], ".", color="C1", markersize=4, label="points beside\nthe crack")
    right.plot([], [], color="black", linewidth=1, label="exact, on\nits faces")
    right.set(title="along the crack", xlabel="x [m]", ylabel="T [K]")
    put_legend(right)
    paper.save(figure, "crack.png")
