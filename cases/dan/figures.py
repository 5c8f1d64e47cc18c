#!/usr/bin/python3
"""Draws the welds of Dan from result folders: calculated points over the reference line. The paper's data that are not
known are substitutes (docs/welding.md).

  figures.py all --calor COMMAND [--only 6 8 ...]   runs the cases that the figures need, then draws them

Pictures go to figures/dan/ in the current folder, results to results/dan/. Needs numpy, matplotlib and
python3-vtk9.
"""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from plotting import Paper, plt, put_legend

paper = Paper(HERE, results="results/dan", figures="figures/dan")
CELSIUS = 273.15


def layout(result, number, title):
    points = paper.result(result).fields(15.0).x
    figure, axes = plt.subplots(figsize=(7, 3.8))
    axes.plot(1e3 * points[:, 0], 1e3 * points[:, 1], "k.", markersize=2)
    axes.set(title=f"Fig. {number}: {title}, {len(points)} points", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    paper.save(figure, f"fig{number:02}.png")


# Points along the plate and across, and supports and radii of the circles over spacing.
GRIDS = (21, 11), (31, 16), (41, 21), (61, 31), (81, 41), (101, 51)
SUPPORTS, RADII = (1.8, 2.3, 2.8), (0.3, 0.5, 0.7)


def circles(support, radius, grid, case="circles"):
    return f"{case} mlpg.support={support} mlpg.radius={radius} cloud.points=[{grid[0]},{grid[1]}]"


def tiles(grid):
    return f"W2D/mlpg cloud.points=[{grid[0]},{grid[1]}]"


def study():
    """Figs. 6 and 7: average temperature in the end and melt length at 15 s over the number of points."""
    figure, axes = plt.subplots(2, 3, figsize=(11, 6.4), sharex=True, sharey="row")
    count = [nx * ny for nx, ny in GRIDS]

    def average_of(result):
        return paper.result(result).weld["average"][-1] - CELSIUS

    def length_of(result):
        weld = paper.result(result).weld
        return 1e3 * weld["length"][abs(weld["time"] - 15).argmin()]

    plain = [(average_of(tiles(grid)), length_of(tiles(grid))) for grid in GRIDS]
    table = [("tiles", 2.3, "", n, *values) for n, values in zip(count, plain)]
    for column, support in enumerate(SUPPORTS):
        average, length = axes[:, column]
        for radius in RADII:
            averages = [average_of(circles(support, radius, grid, "circles-average")) for grid in GRIDS]
            lengths = [length_of(circles(support, radius, grid)) for grid in GRIDS]
            table += [("circles", support, radius, *row) for row in zip(count, averages, lengths)]
            average.semilogx(count, averages, "o-", markersize=4, label=f"radius {radius:g} d")
            length.semilogx(count, lengths, "o-", markersize=4)
        average.semilogx(count, [p[0] for p in plain], "s:", color="0.5", markersize=4, label="tiles, support 2.3 d")
        length.semilogx(count, [p[1] for p in plain], "s:", color="0.5", markersize=4)
        average.axhline(189.85138, color="k", linewidth=0.8)
        length.axhline(39.44299, color="k", linewidth=0.8)
        average.set(title=f"circles, support {support:g} d")
        length.set(xlabel="points")
    axes[0, 0].set(ylabel="Fig. 6: average in the end [°C]")
    axes[1, 0].set(ylabel="Fig. 7: melt length at 15 s [mm]")
    axes[0, 0].legend(fontsize=8)
    paper.save(figure, "fig06-07.png")
    paper.table("fig06-07.csv", "subdomain,support,radius,points,average [degC],melt length [mm]", table)


def graded_averages():
    """Fig. 10: average temperature and weld line on all points and on 930 in rows."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8))
    line = paper.reference("W2D-weldline.csv", t=15.0)
    right.plot(line["x"], line["T"], "k-", linewidth=0.8, label="Green's functions")
    for n, (result, label) in enumerate((("W2D/mlpg", "1891 points"), ("W2D/mlpg-rows", "930 points in rows"))):
        weld = paper.result(result).weld
        left.plot(weld["time"], weld["average"] - CELSIUS, ("-", "--")[n], color=f"C{n}", label=label)
        x, T = paper.on_line(result, 15.0, y=0.0)
        right.plot(1e3 * x, T - CELSIUS, "ox"[n], color=f"C{n}", markersize=3.5, markerfacecolor="none", label=label)
    left.axhline(189.85138, color="k", linewidth=0.8)
    left.set(title="Fig. 10: average temperature (line: theory)", xlabel="t [s]", ylabel="T [°C]")
    right.set(title="weld line at 15 s", xlabel="x [mm]")
    left.legend(fontsize=8)
    right.legend(fontsize=8)
    paper.save(figure, "fig10.png")


def melt_length():
    """Average temperature and melt length over time."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6))
    for n, case in enumerate(("W2D", "W2DS")):
        weld, line = paper.result(case).weld, paper.reference(f"{case}-melt-length.csv")
        left.plot(weld["time"], weld["average"] - CELSIUS, color=f"C{n}", label=case)
        left.plot(weld["time"], weld["theory"] - CELSIUS, "k--", linewidth=0.8)
        right.plot(weld["time"], 1e3 * weld["length"], color=f"C{n}", label=case)
        right.plot(line["t"], line["length"], "ko", markersize=3.5, markerfacecolor="none")
    left.set(title="average temperature (dashed: theory)", xlabel="t [s]", ylabel="T [°C]")
    right.set(title="melt length (circles: Green's functions)", xlabel="t [s]", ylabel="[mm]")
    left.legend(fontsize=8)
    paper.save(figure, "melt-length.png")


def temperatures():
    """Fig. 8: the field at 15 s."""
    paper.section("fig08.png", "Fig. 8: W2D at 15 s, 1200 °C in white", "W2D", 15.0, isotherm=1200, unit="degC")


def lines():
    """Fig. 11: along the weld and across it."""
    along, across = [], []
    for t in (12.0, 15.0, 21.0):
        line = paper.reference("W2D-weldline.csv", t=t)
        x, T = paper.on_line("W2D", t, y=0.0)
        along.append((f"t = {t:g} s", 1e3 * x, T - CELSIUS, line["x"], line["T"]))
        line = paper.reference("W2D-across.csv", t=t)
        fields = paper.result("W2D").fields(t)
        keep = abs(fields.x[:, 0] - 0.1) < 1e-9
        across.append((f"t = {t:g} s", 1e3 * fields.x[keep, 1], fields["temperature"][keep] - CELSIUS, line["y"], line["T"]))
    paper.curves("fig11-along.png", "Fig. 11: W2D along the weld", "x [mm]", "T [°C]", along)
    paper.curves("fig11-across.png", "Fig. 11: W2D across, x = 100 mm", "y [mm]", "T [°C]", across)


def section():
    """Fig. 12: the section x = 50 mm at 7 s."""
    paper.section("fig12.png", "Fig. 12: W3D at 7 s, x = 50 mm, 1200 °C in white", "W3D", 7.0, plane=("x", 0.05), isotherm=1200, unit="degC",
                  size=(6, 3.4))


def histories():
    """Fig. 13: nine probes on a logarithmic time axis."""
    probes, line = paper.result("W3D").probes, paper.reference("W3D-probes.csv")
    figure, axes = plt.subplots(figsize=(6, 4.2))
    for n, name in enumerate("ABCDEFGHI"):
        colour = f"C{n % 7}"
        axes.semilogx(line["t"], line[name], "-", color=colour, linewidth=1)
        axes.semilogx(probes["time"][1:], probes[name][1:] - CELSIUS, "o", color=colour, markersize=2.5,
                      markerfacecolor="none", label=name)
    axes.set(title="Fig. 13: W3D, lines by Green's functions", xlabel="t [s]", ylabel="T [°C]", xlim=(1, 20))
    put_legend(axes)
    paper.save(figure, "fig13.png")


DRAWN = {
    4: (lambda: layout("W2D", 4, "uniform"), ["W2D"]),
    6: (study, [circles(s, r, grid, case) for grid in GRIDS for s in SUPPORTS for r in RADII
                for case in ("circles", "circles-average")] + [tiles(grid) for grid in GRIDS]),
    7: (melt_length, ["W2D", "W2DS"]),
    8: (temperatures, ["W2D"]),
    9: (lambda: layout("W2D/mlpg-rows", 9, "rows"), ["W2D/mlpg-rows"]),
    10: (graded_averages, ["W2D/mlpg", "W2D/mlpg-rows"]),
    11: (lines, ["W2D"]),
    12: (section, ["W3D"]),
    13: (histories, ["W3D"]),
}

if __name__ == "__main__":
    paper.main(DRAWN)
