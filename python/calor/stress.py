"""Pictures of thermal stress: through the thickness, over time, and of two results beside each other."""
from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .result import Array, Result, Table

MM, MPA = 1e3, 1e-6


def lines_of(section: Table) -> list[tuple[str, Array]]:
    """Names and rows of the lines through the thickness that are drawn: the one that there is; of a disc those at its
    axis, half way and at its rim."""
    if "r" not in section:
        return [("", np.arange(len(section["s"])))]
    radii = np.unique(section["r"])
    chosen = radii[[0, len(radii) // 2, len(radii) - 1]]
    return [(f"r = {MM * r:.3g} mm", np.flatnonzero(section["r"] == r)) for r in chosen]


def components_of(section: Table) -> list[str]:
    return [name for name in section if section.units[name] == "Pa"]


def bars(result: Result, finer: Result) -> dict[str, float]:
    """Errors of temperature and stresses along the lines: four thirds of the largest change with half the spacing, as at second
    order."""
    def change(name: str) -> float:
        pairs = zip(lines_of(result.section), lines_of(finer.section))
        return max(float(np.max(np.abs(np.interp(result.section["s"][rows], finer.section["s"][others], finer.section[name][others])
                                       - result.section[name][rows]))) for (_, rows), (_, others) in pairs)

    return {name: 4 / 3 * change(name) for name in ("T", *components_of(result.section))}


def through_thickness(axes: Sequence[Axes], result: Result, label: str = "", errors: Mapping[str, float] | None = None) -> None:
    """Temperature, and every component of the stress, into axes of their own; the legend has their errors."""
    section = result.section
    components = components_of(section)

    def words(line: str, name: str) -> str:
        unit, factor = ("K", 1.0) if name == "T" else ("MPa", MPA)
        error = f" ± {factor * errors[name]:.1g} {unit}" if errors else ""
        return ", ".join(word for word in (label, line) if word) + error

    shown = result.shown(section)
    for line, rows in lines_of(section):
        axes[0].plot(MM * section["s"][rows], shown["T"][rows], label=words(line, "T"))
        for ax, component in zip(axes[1:], components):
            ax.plot(MM * section["s"][rows], MPA * section[component][rows], label=words(line, component))
    axes[0].set_ylabel(f"T [{result.degrees}]")
    for ax, component in zip(axes[1:], components):
        ax.set_ylabel(f"{component} [MPa]")
        ax.axhline(0, color=plt.rcParams["text.color"], linewidth=0.6)
    for ax in axes:
        ax.set_xlabel("s [mm]")
        if ax.get_legend_handles_labels()[1] not in ([], [""]):
            ax.legend()


def stress(result: Result) -> Figure:
    """Temperature and stress through the thickness at the end; lowest and highest stress over time."""
    section, history = result.section, result.stress
    components = len(components_of(section))
    is_steady = len(history["time"]) < 2
    figure, axes = plt.subplots(1, 1 + components + (not is_steady), figsize=(4 * (1 + components + (not is_steady)), 3.6))
    through_thickness(axes[: 1 + components], result)
    if not is_steady:
        for name in ("lowest", "highest"):
            axes[-1].plot(history["time"], MPA * history[name], label=name)
        axes[-1].set(xlabel="t [s]", ylabel="stress of the section [MPa]")
        axes[-1].legend()
    figure.suptitle(f"{result.title}: thermal stress at the end", fontsize=10, x=0.01, ha="left")
    return figure


def compare(results: Mapping[str, Result], finer: Mapping[str, Result] | None = None) -> Figure:
    """Composition (of a body of one dimension), temperature and stress through the thickness of several results, by name. With
    the same on half the spacing, `finer`, their errors are told."""
    first = next(iter(results.values()))
    of_points = first.fields()
    mixed = [name for name in of_points if name.startswith("volume fraction of ")][1:2] if of_points.dimension == 1 else []
    components = len(components_of(first.section))
    count = len(mixed) + 1 + components
    figure, axes = plt.subplots(1, count, figsize=(4 * count, 3.6))
    for label, result in results.items():
        through_thickness(axes[len(mixed):], result, label, bars(result, finer[label]) if finer else None)
        if mixed:
            fields = result.fields()
            order = np.argsort(fields.x[:, 0])
            axes[0].plot(MM * (fields.x[order, 0] - fields.x[:, 0].min()), fields[mixed[0]][order], label=label)
            axes[0].set(xlabel="s [mm]", ylabel=mixed[0])
    return figure


__all__ = ["compare", "stress"]
