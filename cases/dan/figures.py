#!/usr/bin/python3
"""Draws the welds of Dan from result folders: calculated points over the reference line. The paper's data that are not
known are substitutes (docs/welding.md).

  figures.py all --calor COMMAND [--only 6 8 ...]   runs the cases that the figures need, then draws them

Pictures go to figures/dan/ in the current folder, results to results/dan/. Needs numpy and matplotlib.
"""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from plotting import Paper, np, plt, read_csv

paper = Paper(HERE, results="results/dan", figures="figures/dan")
CELSIUS = 273.15


def melt_length():
    """Figs. 6 and 7: average temperature and melt length over time."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6))
    for n, case in enumerate(("W2D", "W2DS")):
        weld, line = read_csv(paper.results / case / "weld.csv"), paper.reference(f"{case}-melt-length.csv")
        left.plot(weld["time"], weld["average"] - CELSIUS, color=f"C{n}", label=case)
        left.plot(weld["time"], weld["theory"] - CELSIUS, "k--", linewidth=0.8)
        right.plot(weld["time"], 1e3 * weld["length"], color=f"C{n}", label=case)
        right.plot(line["t"], line["length"], "ko", markersize=3.5, markerfacecolor="none")
    left.set(title="average temperature (dashed: theory)", xlabel="t [s]", ylabel="T [°C]")
    right.set(title="melt length (circles: Green's functions)", xlabel="t [s]", ylabel="[mm]")
    left.legend(fontsize=8)
    paper.save(figure, "fig06-07.png")


def temperatures():
    """Fig. 8: the field at 15 s."""
    points, T = paper.field("W2D", 15.0)
    figure, axes = plt.subplots(figsize=(7, 3.8))
    filled = axes.tricontourf(1e3 * points[:, 0], 1e3 * points[:, 1], T - CELSIUS, 20, cmap="inferno")
    axes.tricontour(1e3 * points[:, 0], 1e3 * points[:, 1], T - CELSIUS, [1200], colors="w", linewidths=1)
    figure.colorbar(filled, label="T [°C]")
    axes.set(title="Fig. 8: W2D at 15 s, 1200 °C in white", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    paper.save(figure, "fig08.png")


def lines():
    """Fig. 11: along the weld and across it."""
    along, across = [], []
    for t in (12.0, 15.0, 21.0):
        line = paper.reference("W2D-weldline.csv", t=t)
        x, T = paper.on_line("W2D", t, y=0.0)
        along.append((f"t = {t:g} s", 1e3 * x, T - CELSIUS, line["x"], line["T"]))
        line = paper.reference("W2D-across.csv", t=t)
        points, T = paper.field("W2D", t)
        keep = abs(points[:, 0] - 0.1) < 1e-9
        across.append((f"t = {t:g} s", 1e3 * points[keep, 1], T[keep] - CELSIUS, line["y"], line["T"]))
    paper.curves("fig11-along.png", "Fig. 11: W2D along the weld", "x [mm]", "T [°C]", along)
    paper.curves("fig11-across.png", "Fig. 11: W2D across, x = 100 mm", "y [mm]", "T [°C]", across)


def section():
    """Fig. 12: the section x = 50 mm at 7 s."""
    points, T = paper.field("W3D", 7.0)
    keep = abs(points[:, 0] - 0.05) < 1e-9
    figure, axes = plt.subplots(figsize=(5, 3.8))
    y, z, T = 1e3 * points[keep, 1], 1e3 * points[keep, 2], T[keep] - CELSIUS
    filled = axes.tricontourf(y, z, T, 20, cmap="inferno")
    axes.tricontour(y, z, T, [1200], colors="w", linewidths=1)
    figure.colorbar(filled, label="T [°C]")
    axes.invert_yaxis()
    axes.set(title="Fig. 12: W3D at 7 s, x = 50 mm", xlabel="y [mm]", ylabel="depth [mm]", aspect="equal")
    paper.save(figure, "fig12.png")


def histories():
    """Fig. 13: nine probes on a logarithmic time axis."""
    probes, line = read_csv(paper.results / "W3D" / "probes.csv"), paper.reference("W3D-probes.csv")
    figure, axes = plt.subplots(figsize=(6, 4.2))
    for n, name in enumerate("ABCDEFGHI"):
        axes.semilogx(line["t"], line[name], "-", color=f"C{n}", linewidth=1)
        axes.semilogx(probes["time"][1:], probes[name][1:] - CELSIUS, "o", color=f"C{n}", markersize=2.5,
                      markerfacecolor="none", label=name)
    axes.set(title="Fig. 13: W3D, lines by Green's functions", xlabel="t [s]", ylabel="T [°C]", xlim=(1, 20))
    axes.legend(fontsize=8, ncol=3)
    axes.grid(alpha=0.3)
    paper.save(figure, "fig13.png")


DRAWN = {
    6: (melt_length, ["W2D", "W2DS"]),
    8: (temperatures, ["W2D"]),
    11: (lines, ["W2D"]),
    12: (section, ["W3D"]),
    13: (histories, ["W3D"]),
}

if __name__ == "__main__":
    paper.main(DRAWN)
