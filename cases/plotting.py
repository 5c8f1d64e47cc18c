"""What the figures of the papers share, on top of the Python package: references, results, drawing, the command line."""
import argparse
import pathlib
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from calor import Result, Table  # noqa: E402
from calor.plot import colour_bar, draw_section, put_legend  # noqa: E402
from calor.style import theme  # noqa: E402


class Paper:
    """The cases and references of one paper, in `folder`; results and pictures go to folders of the current one."""

    def __init__(self, folder, results, figures):
        self.folder = pathlib.Path(folder)
        self.results = pathlib.Path(results)
        self.figures = pathlib.Path(figures)

    # Reading ------------------------------------------------------------------------------------------------------

    def reference(self, name, **filters):
        """Rows of a reference file in which the named columns have the given values."""
        table = Table.read(self.folder / "reference" / name)
        keep = np.ones(len(next(iter(table.values()))), bool)
        for column, value in filters.items():
            keep &= np.isclose(table[column], value, rtol=1e-9)
        return {column: values[keep] for column, values in table.items()}

    def result(self, name):
        return Result(self.results / name)

    def on_line(self, result, time=None, name="temperature", **fixed):
        """x and a field on the line on which the named coordinates have the given values, sorted by x."""
        fields = self.result(result).fields(time)
        keep = np.ones(len(fields.x), bool)
        for axis, value in fixed.items():
            keep &= abs(fields.x[:, "xyz".index(axis)] - value) < 1e-9
        order = np.argsort(fields.x[keep, 0])
        return fields.x[keep, 0][order], fields[name][keep][order]

    # Drawing ------------------------------------------------------------------------------------------------------

    def save(self, figure, name):
        self.figures.mkdir(parents=True, exist_ok=True)
        figure.savefig(self.figures / name, dpi=150)
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
        figure, axes = plt.subplots(figsize=(7, 4.2))
        for n, (label, x, y, line_x, line_y) in enumerate(series):
            colour = f"C{n}"
            axes.plot(line_x, line_y, "-", color=colour, linewidth=1)
            axes.plot(x[::every], y[::every], "o", color=colour, markersize=3.5, markerfacecolor="none", label=label)
        axes.plot([], [], "k-", linewidth=1, label="reference")
        axes.set(title=title, xlabel=x_label, ylabel=y_label)
        put_legend(axes)
        self.save(figure, name)

    def section(self, name, title, result, time=None, plane=None, isotherm=None, unit="K", size=(7, 3.8)):
        """One picture of the temperatures on a section."""
        figure, axes = plt.subplots(figsize=size)
        of = self.result(result)
        of.temperature_unit = unit
        filled = draw_section(axes, of, t=time, plane=plane, isotherm=isotherm)
        colour_bar(figure, filled, axes, f"T [{of.degrees}]")
        axes.set(title=title)
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
        with theme():
            if options.what in others:
                return others[options.what]()
            numbers = options.only or list(drawn)
            if options.calor:
                for result in dict.fromkeys(result for number in numbers for result in drawn[number][1]):
                    self.run(options.calor, result)
            for number in numbers:
                drawn[number][0]()
