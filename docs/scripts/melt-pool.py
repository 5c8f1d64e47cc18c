#!/usr/bin/python3
"""Draws docs/img/melt-pool.png from the result of docs/tutorial-welding.md: the melt pool at 8 s, and its length over time.

  calor run cases/start/weld.toml -o results/weld && docs/scripts/melt-pool.py

Needs numpy, matplotlib and python3-vtk9."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cases"))
from plotting import Paper, colour_bar, draw_section, plt, put_legend, theme  # noqa: E402

paper = Paper(ROOT / "cases" / "start", results="results", figures=ROOT / "docs" / "img")
result = paper.result("weld")
result.temperature_unit = "degC"
with theme():
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8, 5.4))
    filled = draw_section(top, result, t=8, isotherm=1450)
    colour_bar(figure, filled, top, "T [°C]")
    top.set(title="one half of the plate at 8 s; white: 1450 °C")
    bottom.plot(result.weld["time"], 1e3 * result.weld["length"], label="length of the pool")
    bottom.plot(result.weld["time"], 1e3 * result.weld["half_width"], label="half width\nat x = 60 mm")
    bottom.set(xlabel="t [s]", ylabel="extent [mm]", xlim=(0, 15))
    put_legend(bottom)
    paper.save(figure, "melt-pool.png")
