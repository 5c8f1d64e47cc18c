#!/usr/bin/python3
"""Draws the figures of Rong & Kisu from result folders: calculated points over the reference line.

  figures.py all --calor COMMAND [--only 3 7 ...]   runs the cases that the figures need, then draws them
  figures.py demo                                   table and pictures of the thermal shock in results/thermal-shock

Pictures go to figures/ in the current folder, results to results/. Needs numpy and matplotlib.
"""
import argparse
import csv
import pathlib
import subprocess
import xml.etree.ElementTree as xml

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
RESULTS = pathlib.Path("results")
FIGURES = pathlib.Path("figures")


# Reading ----------------------------------------------------------------------------------------------------------


def read_csv(path):
    """Columns by name, the unit in brackets left out."""
    with open(path) as file:
        rows = list(csv.reader(file))
    data = np.array(rows[1:], float)
    return {name.split(" [")[0]: data[:, n] for n, name in enumerate(rows[0])}


def reference(name, **filters):
    """Rows of a reference file in which the named columns have the given values."""
    table = read_csv(HERE / "reference" / name)
    keep = np.ones(len(next(iter(table.values()))), bool)
    for column, value in filters.items():
        keep &= np.isclose(table[column], value, rtol=1e-9)
    return {column: values[keep] for column, values in table.items()}


NUMPY_TYPES = {"Float64": "f8", "Float32": "f4", "Int64": "i8", "Int32": "i4", "UInt8": "u1", "UInt32": "u4", "UInt64": "u8"}


def read_vtu(path):
    """Arrays of an appended-raw VTU file, "Points" among them; of a PVTU file, those of its pieces one after another."""
    blob = pathlib.Path(path).read_bytes()
    if str(path).endswith(".pvtu"):
        pieces = [read_vtu(path.parent / piece.get("Source")) for piece in xml.fromstring(blob).iter("Piece")]
        return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    head, _, tail = blob.partition(b"<AppendedData")
    data = tail[tail.index(b"_") + 1 :]
    root = xml.fromstring(head + b"</VTKFile>")
    order = "<" if root.get("byte_order") == "LittleEndian" else ">"
    size_type = np.dtype(order + NUMPY_TYPES[root.get("header_type", "UInt32")])
    arrays = {}
    for array in root.iter("DataArray"):
        if array.get("format") != "appended":
            continue
        offset = int(array.get("offset"))
        size = int(np.frombuffer(data, size_type, 1, offset)[0])
        dtype = np.dtype(order + NUMPY_TYPES[array.get("type")])
        values = np.frombuffer(data, dtype, size // dtype.itemsize, offset + size_type.itemsize)
        components = int(array.get("NumberOfComponents", "1"))
        arrays[array.get("Name")] = values.reshape(-1, components) if components > 1 else values
    return arrays


def field(result, time=None):
    """Points (n, 3) in m and temperatures in K of a result at a time; without one, at its end."""
    folder = RESULTS / result
    entries = [(float(e.get("timestep")), e.get("file")) for e in xml.parse(folder / "fields.pvd").iter("DataSet")]
    at, file = entries[-1] if time is None else min(entries, key=lambda entry: abs(entry[0] - time))
    if time is not None and not np.isclose(at, time, rtol=1e-9):
        raise SystemExit(f"figures.py: {folder} has no field at {time} s")
    arrays = read_vtu(folder / file)
    return arrays["Points"], arrays["temperature [K]"]


def on_line(result, time=None, **fixed):
    """x and T on the line on which the named coordinates have the given values, sorted by x."""
    points, T = field(result, time)
    keep = np.ones(len(T), bool)
    for axis, value in fixed.items():
        keep &= abs(points[:, "xyz".index(axis)] - value) < 1e-9
    order = np.argsort(points[keep, 0])
    return points[keep, 0][order], T[keep][order]


# Drawing ----------------------------------------------------------------------------------------------------------


def save(figure, name):
    FIGURES.mkdir(exist_ok=True)
    figure.savefig(FIGURES / name, dpi=150, bbox_inches="tight")
    plt.close(figure)
    print(FIGURES / name)


def curves(name, title, x_label, y_label, series):
    """One picture: for every (label, x, y, reference x, reference y) points over a line of the same colour."""
    figure, axes = plt.subplots(figsize=(6, 4.2))
    for n, (label, x, y, line_x, line_y) in enumerate(series):
        colour = f"C{n}"
        axes.plot(line_x, line_y, "-", color=colour, linewidth=1)
        axes.plot(x, y, "o", color=colour, markersize=3.5, markerfacecolor="none", label=label)
    axes.plot([], [], "k-", linewidth=1, label="reference")
    axes.set(title=title, xlabel=x_label, ylabel=y_label)
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    save(figure, name)


def fig2():
    series = []
    for B, result in ((-0.2, "fig2/L4-B-0.2"), (0.5, "fig2"), (1.0, "fig2/L4-B1")):
        line = reference("fig2-L4.csv", B=B)
        series.append((f"B = {B:g}", *on_line(result, y=2.0), line["x"], line["T"]))
    curves("fig02.png", "Fig. 2: steady, k = exp(B x)", "x [m]", "T [K]", series)


def fig3():
    series = []
    for t in (0.05, 0.1, 0.25, 0.5, 1.0, 2.0):
        line = reference("fig3-L4.csv", t=t)
        series.append((f"t = {t:g} s", *on_line("fig3", t, y=2.0), line["x"], line["T"]))
    curves("fig03.png", "Fig. 3: k = exp(0.5 x), line y = 2 m, 41 x 41 points", "x [m]", "T [K]", series)


def fig4():
    line = reference("fig4.csv", y=0.5)
    series = [("21 x 21 points", *on_line("fig4", y=0.5), line["x"], line["T"])]
    curves("fig04.png", "Fig. 4: k = 1 + 2 sin(pi x) sin(pi y), line y = 0.5 m", "x [m]", "T [K]", series)


def steady_in_T(name, title, case, **fixed):
    series = []
    for a, result in ((1, case), (2, f"{case}/a2"), (4, f"{case}/a4")):
        line = reference("fig5-fig6-steady.csv", a=a)
        series.append((f"a = {a}", *on_line(result, **fixed), line["x"], line["T"]))
    curves(name, title, "x [m]", "T [K]", series)


def fig5():
    steady_in_T("fig05.png", "Fig. 5: steady, k = exp(a T), line y = 0.5 m", "fig5-steady", y=0.5)


def fig6():
    steady_in_T("fig06.png", "Fig. 6: 3D, k = exp(a T), line y = 0.5 m, z = 0.25 m", "fig6", y=0.5, z=0.25)


def fig7():
    points, T = field("fig7-fig8", 8.0)
    figure, axes = plt.subplots(figsize=(5.4, 4.4))
    filled = axes.tricontourf(100 * points[:, 0], 100 * points[:, 1], T, 20, cmap="inferno")
    figure.colorbar(filled, label="T [K]")
    axes.set(title="Fig. 7: cooling by convection, t = 8 s", xlabel="x [cm]", ylabel="y [cm]", aspect="equal")
    save(figure, "fig07.png")


def fig8():
    figure, axes = plt.subplots(figsize=(6, 4.2))
    for t in (0.5, 1.0, 4.0, 8.0):
        x, T = on_line("fig7-fig8", t, y=0.05)
        line = reference("fig7-fig8.csv", t=t, y=5.0)
        axes.plot(100 * x, T - np.interp(100 * x, line["x"], line["T"]), "o-", markersize=3, label=f"t = {t:g} s")
    axes.set(title="Fig. 8: error on the line y = 5 cm (temperatures up to 100 K)", xlabel="x [cm]", ylabel="error [K]")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    save(figure, "fig08.png")


def fig9():
    series = []
    for t in (1.0, 2.0, 3.0, 5.0):
        points, T = field("fig9/quarter", t)
        line = reference("fig9.csv", t=t)
        series.append((f"t = {t:g} s", np.hypot(points[:, 0], points[:, 1]), T, line["r"], line["T"]))
    curves("fig09.png", "Fig. 9: flux on a curved wall, all points of a quarter disc", "r [m]", "T [K]", series)


def fig11():
    points, _ = field("thermal-shock")
    figure, axes = plt.subplots(figsize=(5, 5))
    bottom = points[:, 2] < 1e-9
    axes.plot(1e3 * points[bottom, 0], 1e3 * points[bottom, 1], ".", markersize=2, color="k")
    levels = len(np.unique(points[:, 2].round(9)))
    axes.set(title=f"Fig. 11: points of one of {levels} levels", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    save(figure, "fig11.png")


SHOCKS = {1023: "thermal-shock", 1073: "thermal-shock/1073", 1123: "thermal-shock/1123"}


def section(number, T0):
    points, T = field(SHOCKS[T0], 22.0)
    half = (abs(points[:, 1]) < 1e-9) & (points[:, 0] > -1e-9)
    figure, axes = plt.subplots(figsize=(8, 2.6))
    filled = axes.tricontourf(1e3 * points[half, 0], 1e3 * points[half, 2], T[half], 20, cmap="inferno")
    figure.colorbar(filled, label="T [K]")
    title = f"Fig. {number}: axial section at t = 22 s, T0 = {T0} K (jet from above)"
    axes.set(title=title, xlabel="r [mm]", ylabel="z [mm]", aspect=2)
    save(figure, f"fig{number}.png")


def probes(number, T0):
    calculated = read_csv(RESULTS / SHOCKS[T0] / "probes.csv")
    line = reference(f"thermal-shock-{T0}.csv")
    time = calculated[next(iter(calculated))]
    shown = np.isclose(time % 1, 0, atol=1e-9) | np.isclose(time % 1, 1, atol=1e-9)
    series = [
        (label, time[shown], calculated[name][shown], line["t"], line[name])
        for label, name in (("point 1: bottom, centre", "centre"), ("point 2: bottom, r = 14.5 mm", "edge"))
    ]
    title = f"Fig. {number}: probes, T0 = {T0} K (substitute data)"
    curves(f"fig{number}.png", title, "t [s]", "T [K]", series)


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


def run(calor, result):
    name, _, variant = result.partition("/")
    command = [calor, "run", str(HERE / f"{name}.toml"), "-o", str(RESULTS / result), "--quiet"]
    if variant:
        command.append(f"variant={variant}")
    print("running", result, flush=True)
    if subprocess.run(command).returncode not in (0, 1):  # 1: ran, but an expectation failed
        raise SystemExit(f"figures.py: {' '.join(command)} failed")


def demo():
    calculated = read_csv(RESULTS / "thermal-shock" / "probes.csv")
    line = reference("thermal-shock-1023.csv")
    time = calculated[next(iter(calculated))]
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
    print(f"For ParaView: {RESULTS / 'thermal-shock' / 'fields.pvd'}")


def main():
    parser = argparse.ArgumentParser(description="Draws the figures of Rong & Kisu.")
    parser.add_argument("what", choices=["all", "demo"])
    parser.add_argument("--calor", help="the command that runs cases; without it the results must be there")
    parser.add_argument("--only", type=int, nargs="+", choices=list(DRAWN), help="numbers of figures")
    options = parser.parse_args()
    if options.what == "demo":
        return demo()
    numbers = options.only or list(DRAWN)
    if options.calor:
        for result in dict.fromkeys(result for number in numbers for result in DRAWN[number][1]):
            run(options.calor, result)
    for number in numbers:
        DRAWN[number][0]()


if __name__ == "__main__":
    main()
