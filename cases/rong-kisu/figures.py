#!/usr/bin/python3
"""Draws the figures of Rong & Kisu from result folders: calculated points over the reference line.

  figures.py all --calor COMMAND [--only 3 7 ...]   runs the cases that the figures need, then draws them
  figures.py demo                                   table and pictures of the thermal shock in results/thermal-shock

Pictures go to figures/ in the current folder, results to results/. Needs numpy, matplotlib and python3-vtk9.
"""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from plotting import Paper, colour_bar, draw_section, np, plt, put_legend

paper = Paper(HERE, results="results", figures="figures")


def fig2():
    series = []
    for B, result in ((-0.2, "fig2/L4-B-0.2"), (0.5, "fig2"), (1.0, "fig2/L4-B1")):
        line = paper.reference("fig2-L4.csv", B=B)
        series.append((f"B = {B:g}", *paper.on_line(result, y=2.0), line["x"], line["T"]))
    paper.curves("fig02.png", "Fig. 2: steady, k = exp(B x)", "x [m]", "T [K]", series)


def fig3():
    series = []
    for t in (0.05, 0.1, 0.25, 0.5, 1.0, 2.0):
        line = paper.reference("fig3-L4.csv", t=t)
        series.append((f"t = {t:g} s", *paper.on_line("fig3", t, y=2.0), line["x"], line["T"]))
    paper.curves("fig03.png", "Fig. 3: k = exp(0.5 x), line y = 2 m, 41 x 41 points", "x [m]", "T [K]", series)


def fig4():
    line = paper.reference("fig4.csv", y=0.5)
    series = [("21 x 21 points", *paper.on_line("fig4", y=0.5), line["x"], line["T"])]
    paper.curves("fig04.png", "Fig. 4: k = 1 + 2 sin(pi x) sin(pi y), line y = 0.5 m", "x [m]", "T [K]", series)


def steady_in_T(name, title, case, **fixed):
    series = []
    for a, result in ((1, case), (2, f"{case}/a2"), (4, f"{case}/a4")):
        line = paper.reference("fig5-fig6-steady.csv", a=a)
        series.append((f"a = {a}", *paper.on_line(result, **fixed), line["x"], line["T"]))
    paper.curves(name, title, "x [m]", "T [K]", series)


def fig5():
    steady_in_T("fig05.png", "Fig. 5: steady, k = exp(a T), line y = 0.5 m", "fig5-steady", y=0.5)


def fig6():
    steady_in_T("fig06.png", "Fig. 6: 3D, k = exp(a T), line y = 0.5 m, z = 0.25 m", "fig6", y=0.5, z=0.25)


def fig7():
    paper.section("fig07.png", "Fig. 7: cooling by convection, t = 8 s", "fig7-fig8", 8.0, size=(5.8, 4.6))


def fig8():
    figure, axes = plt.subplots(figsize=(7, 4.2))
    for t in (0.5, 1.0, 4.0, 8.0):
        x, T = paper.on_line("fig7-fig8", t, y=0.05)
        line = paper.reference("fig7-fig8.csv", t=t, y=5.0)
        axes.plot(100 * x, T - np.interp(100 * x, line["x"], line["T"]), "o-", markersize=3, label=f"t = {t:g} s")
    axes.set(title="Fig. 8: error on the line y = 5 cm (temperatures up to 100 K)", xlabel="x [cm]", ylabel="error [K]")
    put_legend(axes)
    paper.save(figure, "fig08.png")


def fig9():
    series = []
    for t in (1.0, 2.0, 3.0, 5.0):
        fields = paper.result("fig9/quarter").fields(t)
        line = paper.reference("fig9.csv", t=t)
        series.append((f"t = {t:g} s", np.hypot(fields.x[:, 0], fields.x[:, 1]), fields["temperature"], line["r"], line["T"]))
    paper.curves("fig09.png", "Fig. 9: flux on a curved wall, all points of a quarter disc", "r [m]", "T [K]", series)


def fig11():
    points = paper.result("thermal-shock").fields().x
    figure, axes = plt.subplots(figsize=(5, 5))
    bottom = points[:, 2] < 1e-9
    axes.plot(1e3 * points[bottom, 0], 1e3 * points[bottom, 1], ".", markersize=2, color="k")
    levels = len(np.unique(points[:, 2].round(9)))
    axes.set(title=f"Fig. 11: points of one of {levels} levels", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    paper.save(figure, "fig11.png")


SHOCKS = {1023: "thermal-shock", 1073: "thermal-shock/1073", 1123: "thermal-shock/1123"}


def section(number, T0):
    title = f"Fig. {number}: axial section at t = 22 s, T0 = {T0} K (jet from above)"
    paper.section(f"fig{number}.png", title, SHOCKS[T0], 22.0, plane=("y", 0.0), size=(8, 2.2))


def probes(number, T0):
    calculated = paper.result(SHOCKS[T0]).probes
    line = paper.reference(f"thermal-shock-{T0}.csv")
    time = calculated["time"]
    shown = np.isclose(time % 1, 0, atol=1e-9) | np.isclose(time % 1, 1, atol=1e-9)
    series = [
        (label, time[shown], calculated[name][shown], line["t"], line[name])
        for label, name in (("point 1: bottom, centre", "centre"), ("point 2: bottom, r = 14.5 mm", "edge"))
    ]
    title = f"Fig. {number}: probes, T0 = {T0} K (substitute data)"
    paper.curves(f"fig{number}.png", title, "t [s]", "T [K]", series)


def thermal_shock():
    """The picture of the README: section and probes side by side."""
    result = paper.result("thermal-shock")
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3), width_ratios=(1.5, 1))
    filled = draw_section(left, result, t=22.0, plane=("y", 0.0))
    colour_bar(figure, filled, left, "T [K]")
    left.set(title="axial section after 22 s, jet from above", aspect=3)
    line = paper.reference("thermal-shock-1023.csv")
    time = result.probes["time"]
    shown = np.isclose(time % 1, 0, atol=1e-9) | np.isclose(time % 1, 1, atol=1e-9)
    for n, (label, name) in enumerate((("centre", "centre"), ("r = 14.5 mm", "edge"))):
        right.plot(line["t"], line[name], "-", color=f"C{n}", linewidth=1)
        right.plot(time[shown], result.probes[name][shown], "o", color=f"C{n}", markersize=3, fillstyle="none", label=label)
    right.plot([], [], "k-", linewidth=1, label="reference")
    right.set(title="bottom of the disc", xlabel="t [s]", ylabel="T [K]")
    right.legend()
    paper.save(figure, "thermal-shock.png")


# Number of the figure: what draws it, and the cases (with variant) whose results it needs.
DRAWN = {
    2: (fig2, ["fig2", "fig2/L4-B-0.2", "fig2/L4-B1"]),
    3: (fig3, ["fig3"]),
    4: (fig4, ["fig4"]),
    5: (fig5, ["fig5-steady", "fig5-steady/a2", "fig5-steady/a4"]),
    6: (fig6, ["fig6", "fig6/a2", "fig6/a4"]),
    7: (fig7, ["fig7-fig8"]),
    8: (fig8, ["fig7-fig8"]),
    9: (fig9, ["fig9/quarter"]),
    11: (fig11, ["thermal-shock"]),
    12: (lambda: section(12, 1023), ["thermal-shock"]),
    13: (lambda: section(13, 1073), ["thermal-shock/1073"]),
    14: (lambda: section(14, 1123), ["thermal-shock/1123"]),
    15: (lambda: probes(15, 1023), ["thermal-shock"]),
    16: (lambda: probes(16, 1073), ["thermal-shock/1073"]),
    17: (lambda: probes(17, 1123), ["thermal-shock/1123"]),
}


def demo():
    calculated = paper.result("thermal-shock").probes
    line = paper.reference("thermal-shock-1023.csv")
    time = calculated["time"]
    print("\nTemperatures on the bottom of the disc, K; reference: axisymmetric finite volumes")
    print("   t [s]    centre  reference  difference      edge  reference  difference")
    for t in (0, 1, 2, 5, 10, 15, 20, 22):
        now, then = np.argmin(abs(time - t)), np.argmin(abs(line["t"] - t))
        row = f"{t:8g}"
        for name in ("centre", "edge"):
            T, expected = calculated[name][now], line[name][then]
            row += f"{T:10.2f}{expected:11.2f}{T - expected:+12.3f}"
        print(row)
    print("\nPictures:")
    for number in (11, 12, 15):
        DRAWN[number][0]()
    thermal_shock()
    print(f"For ParaView: {paper.results / 'thermal-shock' / 'fields.pvd'}")


if __name__ == "__main__":
    paper.main(DRAWN, demo=demo)
