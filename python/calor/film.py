"""Films of results with matplotlib."""
from __future__ import annotations

import pathlib

import matplotlib
import matplotlib.pyplot as plt

from .command import CommandError
from .plot import colour_bar, draw_section, in_section, isotherm_of, put_title, section_figure
from .result import Result
from .style import theme


def animate(result: Result, path: pathlib.Path, *, name: str = "temperature", plane: tuple[str, float] | None = None,
            dark: bool = False, seconds: float = 6) -> None:
    """The section over all times of the result as a film: .mp4 (needs ffmpeg) or .gif. One scale of colours for all."""
    from matplotlib.animation import FuncAnimation, writers
    if len(result.times) < 2:
        raise CommandError("a film needs several times: give [output] every, or times")
    if path.suffix == ".mp4" and not writers.is_available("ffmpeg"):
        raise CommandError("a film .mp4 needs ffmpeg: apt-get install ffmpeg, or ask for a .gif by --film gif")
    ranges = [in_section(result.shown(result.fields(t)), name, plane) for t in result.times]
    limits = (min(values.min() for values in ranges), max(values.max() for values in ranges))
    with theme(dark):
        first = result.shown(result.fields(result.times[0]))
        figure, axes = section_figure(first, plane)
        colours = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(*limits))
        colour_bar(figure, colours, axes, first.label(name))
        isotherm = isotherm_of(result) if name == "temperature" else None

        def show(n: int) -> None:
            axes.clear()
            draw_section(axes, result, name, result.times[n], plane, isotherm=isotherm, limits=limits)
            put_title(figure, f"{result.title}: t = {result.times[n]:.4g} s")

        film = FuncAnimation(figure, show, frames=len(result.times))
        film.save(path, writer="ffmpeg" if path.suffix == ".mp4" else "pillow", fps=max(1.0, len(result.times) / seconds), dpi=120)
        plt.close(figure)
