#!/usr/bin/python3
"""Draws the figures of Wang, Ma, Guo & Huang from result folders: calculated points over the reference line.

  figures.py all --calor COMMAND [--only 5 10 ...]   runs the cases that the figures need, then draws them

Pictures go to figures/wang/ in the current folder, results to results/wang/. Needs numpy, matplotlib and python3-vtk9.
"""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from plotting import Paper

paper = Paper(HERE, results="results/wang", figures="figures/wang")


# Properties of the plate, Figs. 5, 10 and 11 -----------------------------------------------------------------------

EXPONENTS = {0.01: "fig5/M0.01", 0.2: "fig5/M0.2", 1: "fig5", 5: "fig5/M5", 70: "fig5/M70"}
POROSITIES = (0, 1, 2, 3, 3.99)


def porous(figure):
    """Result for every A."""
    return {A: f"{figure}/A{A}" if A else figure for A in POROSITIES}


def property_of_plate(name, title, label, results, field, file, column, scale=1):
    line = paper.reference(file)
    series = []
    for value, result in results.items():
        x, f = paper.on_line(result, name=field)
        series.append((f"{column[-1]} = {value:g}", 1e3 * x, f / scale, line["x"], line[f"{column}{value}"] / scale))
    paper.curves(name, title, "y [mm]", label, series, every=5)


def fig5():
    title, field = "Fig. 5: metal of the plate without pores", "volume fraction of Ti-6Al-4V"
    property_of_plate("fig05.png", title, "volume fraction", EXPONENTS, field, "fig05-V1.csv", "V1_M")


def fig10():
    title, field = "Fig. 10: conductivity of the porous plate, M = 1", "conductivity"
    property_of_plate("fig10.png", title, "k [W/(m K)]", porous("fig10"), field, "fig10-conductivity.csv", "k_A")


def fig11():
    title, field = "Fig. 11: heat capacity of the porous plate, M = 1", "volumetric heat capacity"
    label, file = "rho c [MJ/(m^3 K)]", "fig11-heat-capacity.csv"
    property_of_plate("fig11.png", title, label, porous("fig11"), field, file, "rho_c_A", scale=1e6)


# Temperatures, Figs. 2 and 3 (bar), 6 to 9, 12 and 13 (plate) -------------------------------------------------------

LAYERS = {"odd reflection": "fig2-fig3", "constant layers": "fig2-fig3/euler-constant-layers"}
GRADINGS = {M: f"fig6-fig7/M{M}" if M != 1 else "fig6-fig7" for M in EXPONENTS}
PORES = {A: f"fig8-fig9/A{A}" if A else "fig8-fig9" for A in POROSITIES}
HEATED = {T1: f"fig12-fig13/T{T1}" if T1 != 200 else "fig12-fig13" for T1 in (200, 350, 480, 720)}


def bar(number, t):
    line = paper.reference("fig2-fig3.csv", t=t)
    series = []
    for label, result in LAYERS.items():
        x, T = paper.on_line(result, t)
        series.append((label, 1e3 * x, T - 273.15, line["x"], line["T"]))
    paper.curves(f"fig{number:02}.png", f"Fig. {number}: graded bar, t = {t} s", "x [mm]", "T [degC]", series, every=25)


def plate(number, t, what, file, parameter, unit, results):
    series = []
    for value, result in results.items():
        x, T = paper.on_line(result, t)
        line = paper.reference(file, t=t, **{parameter: value})
        series.append((f"{parameter} = {value}{unit}", 1e3 * x, T - 273.15, line["x"], line["T"]))
    title = f"Fig. {number}: graded plate, {what}, t = {t} s"
    paper.curves(f"fig{number:02}.png", title, "y [mm]", "T [degC]", series, every=25)


def gradings(number, t):
    plate(number, t, "exponents", "fig6-fig7.csv", "M", "", GRADINGS)


def pores(number, t):
    plate(number, t, "M = 1 with pores", "fig8-fig9.csv", "A", "", PORES)


def heated(number, t):
    plate(number, t, "M = 1, heated face", "fig12-fig13.csv", "T1", " degC", HEATED)


# Number of the figure: what draws it, and the cases (with variant) whose results it needs.
DRAWN = {
    2: (lambda: bar(2, 1), list(LAYERS.values())),
    3: (lambda: bar(3, 3), list(LAYERS.values())),
    5: (fig5, list(EXPONENTS.values())),
    6: (lambda: gradings(6, 1), list(GRADINGS.values())),
    7: (lambda: gradings(7, 3), list(GRADINGS.values())),
    8: (lambda: pores(8, 1), list(PORES.values())),
    9: (lambda: pores(9, 3), list(PORES.values())),
    10: (fig10, list(porous("fig10").values())),
    11: (fig11, list(porous("fig11").values())),
    12: (lambda: heated(12, 1), list(HEATED.values())),
    13: (lambda: heated(13, 3), list(HEATED.values())),
}

if __name__ == "__main__":
    paper.main(DRAWN)
