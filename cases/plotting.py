"""What the figures of the papers share: reading of results and reference files, drawing, and the command line."""
import argparse
import csv
import pathlib
import subprocess
import xml.etree.ElementTree as xml

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Reading ----------------------------------------------------------------------------------------------------------


def read_csv(path):
    """Columns by name, the unit in brackets left out."""
    with open(path) as file:
        rows = list(csv.reader(file))
    data = np.array(rows[1:], float)
    return {name.split(" [")[0]: data[:, n] for n, name in enumerate(rows[0])}


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


class Paper:
    """The cases and references of one paper, in `folder`; results and pictures go to folders of the current one."""

    def __init__(self, folder, results, figures):
        self.folder = pathlib.Path(folder)
        self.results = pathlib.Path(results)
        self.figures = pathlib.Path(figures)

    def reference(self, name, **filters):
        """Rows of a reference file in which the named columns have the given values."""
        table = read_csv(self.folder / "reference" / name)
        keep = np.ones(len(next(iter(table.values()))), bool)
        for column, value in filters.items():
            keep &= np.isclose(table[column], value, rtol=1e-9)
        return {column: values[keep] for column, values in table.items()}

    def field(self, result, time=None, name="temperature [K]"):
        """Points (n, 3) in m and a field of a result at a time; without one, at its end."""
        folder = self.results / result
        entries = [(float(e.get("timestep")), e.get("file")) for e in xml.parse(folder / "fields.pvd").iter("DataSet")]
        at, file = entries[-1] if time is None else min(entries, key=lambda entry: abs(entry[0] - time))
        if time is not None and not np.isclose(at, time, rtol=1e-9):
            raise SystemExit(f"figures: {folder} has no field at {time} s")
        arrays = read_vtu(folder / file)
        return arrays["Points"], arrays[name]

    def on_line(self, result, time=None, name="temperature [K]", **fixed):
        """x and a field on the line on which the named coordinates have the given values, sorted by x."""
        points, values = self.field(result, time, name)
        keep = np.ones(len(values), bool)
        for axis, value in fixed.items():
            keep &= abs(points[:, "xyz".index(axis)] - value) < 1e-9
        order = np.argsort(points[keep, 0])
        return points[keep, 0][order], values[keep][order]

    # Drawing ------------------------------------------------------------------------------------------------------

    def save(self, figure, name):
        self.figures.mkdir(parents=True, exist_ok=True)
        figure.savefig(self.figures / name, dpi=150, bbox_inches="tight")
        plt.close(figure)
        print(self.figures / name)

    def table(self, name, header, rows):
        """The numbers of a picture, beside it."""
        lines = [header] + [",".join(f"{value:.6g}" if isinstance(value, float) else str(value) for value in row) for row in rows]
        (self.figures / name).write_text("\n".join(lines) + "\n")
        print(self.figures / name)

    def curves(self, name, title, x_label, y_label, series, every=1):
        """One picture: for every (label, x, y, reference x, reference y) points over a line of the same colour; of the
        points each `every`-th."""
        figure, axes = plt.subplots(figsize=(6, 4.2))
        for n, (label, x, y, line_x, line_y) in enumerate(series):
            colour = f"C{n}"
            axes.plot(line_x, line_y, "-", color=colour, linewidth=1)
            axes.plot(x[::every], y[::every], "o", color=colour, markersize=3.5, markerfacecolor="none", label=label)
        axes.plot([], [], "k-", linewidth=1, label="reference")
        axes.set(title=title, xlabel=x_label, ylabel=y_label)
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
        self.save(figure, name)

    # Running ------------------------------------------------------------------------------------------------------

    def run(self, calor, result):
        """Runs a case, or with "case/variant" one of its variants; words after it change keys: "case key=value"."""
        case, *changes = result.split()
        name, _, variant = case.partition("/")
        command = [calor, "run", str(self.folder / f"{name}.toml"), *changes, "-o", str(self.results / result), "--quiet"]
        if variant:
            command.append(f"variant={variant}")
        print("running", result, flush=True)
        if subprocess.run(command).returncode not in (0, 1):  # 1: ran, but an expectation failed
            raise SystemExit(f"figures: {' '.join(command)} failed")

    def main(self, drawn, **others):
        """The command line. drawn: number of the figure -> (what draws it, the results it needs); others: further words
        and what they do."""
        parser = argparse.ArgumentParser(description=f"Draws the figures of {self.folder.name}.")
        parser.add_argument("what", choices=["all", *others])
        parser.add_argument("--calor", help="the command that runs cases; without it the results must be there")
        parser.add_argument("--only", type=int, nargs="+", choices=list(drawn), help="numbers of figures")
        options = parser.parse_args()
        if options.what in others:
            return others[options.what]()
        numbers = options.only or list(drawn)
        if options.calor:
            for result in dict.fromkeys(result for number in numbers for result in drawn[number][1]):
                self.run(options.calor, result)
        for number in numbers:
            drawn[number][0]()
