"""Pictures of many runs: what a certificate, a fit and a study found."""
from __future__ import annotations

import base64
import math
import pathlib
from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import page, quantities
from .certify import ROUND_OFF
from .command import CaseError, CommandError
from .convergence import text
from .readings import Data
from .result import Array
from .style import CURVES, theme

if TYPE_CHECKING:
    from .certify import Certificate, Quantity
    from .fit import Fit
    from .study import Study

COLUMNS = 3  # of panels in a row
PANEL = (3.8, 2.7)  # inches


def is_number(value: object) -> bool:
    try:
        quantities.split(value)
        return True
    except CaseError:
        return False


def panels(count: int) -> tuple[Figure, list[Axes]]:
    """A figure with so many axes."""
    columns = min(count, COLUMNS)
    rows = math.ceil(count / columns)
    figure, axes = plt.subplots(rows, columns, figsize=(PANEL[0] * columns, PANEL[1] * rows), squeeze=False)
    for unused in axes.flat[count:]:
        unused.remove()
    return figure, list(axes.flat[:count])


def convergence(ax: Axes, certificate: Certificate, quantity: Quantity) -> None:
    """Values over the spacing, the limit of every method with its bar at spacing 0, and the certified band."""
    assert quantity.verdict
    middle = quantity.verdict.value if quantity.verdict.certified else 0.0
    if quantity.verdict.certified:
        ax.axhspan(-quantity.verdict.bar, quantity.verdict.bar, color="0.5", alpha=0.3, linewidth=0)
    for n, method in enumerate(certificate.methods):
        if method not in quantity.limits:
            continue
        limit = quantity.limits[method]
        spacing = [1 / run.factor for run in certificate.runs if run.method == method and quantity.name in run.values]
        values = np.array(quantity.values[method]) - middle
        ax.plot(spacing, values, "o-", color=CURVES[n], ms=4, label=method)
        if limit.is_asymptotic:
            place = 0.02 * (n - 1) * max(spacing)  # beside each other
            ax.plot([spacing[-1], place], [values[-1], limit.value - middle], ":", color=CURVES[n])
            ax.errorbar([place], [limit.value - middle], [limit.bar], fmt="s", color=CURVES[n], ms=4, capsize=3)
    ax.set_title(f"{quantity.name}\n{quantity.statement}" if quantity.verdict.certified else f"{quantity.name}\nnot certified", fontsize=8, loc="left")
    ax.set_ylabel(f"off the certified value [{quantity.unit}]" if quantity.verdict.certified else f"[{quantity.unit}]", fontsize=8)
    ax.set_xlabel("spacing, of that in the case", fontsize=8)


def certificate(found: Certificate) -> Figure:
    """All quantities of a certificate that any refinement changes, one beside the other."""
    def changes(quantity: Quantity) -> bool:
        return any(np.ptp(values) > ROUND_OFF * found.span[quantity.kind] for values in quantity.values.values())

    shown = [quantity for quantity in found.quantities.values() if quantity.limits and changes(quantity)]
    if not shown:
        raise CommandError("no refinement changes anything, or no quantity has three spacings: there is nothing to draw")
    figure, axes = panels(len(shown))
    for ax, quantity in zip(axes, shown):
        convergence(ax, found, quantity)
    axes[0].legend()
    return figure


def over_time(ax: Axes, data: Data, computed: Array) -> None:
    ax.plot(data.t, data.value, ".", color=CURVES[6], ms=4, label="measured")
    ax.plot(data.t, computed, color=CURVES[0], label="computed")
    ax.set(title=data.name, ylabel=f"[{data.unit}]")
    ax.legend()


def against_measured(ax: Axes, measured: Array, computed: Array, unit: str) -> None:
    ax.axline((measured[0], measured[0]), slope=1, color=CURVES[6], linewidth=0.8)
    ax.plot(measured, computed, "o", color=CURVES[0], ms=4)
    ax.set(title="single values", ylabel=f"computed [{unit}]")


def measurements(found: Fit) -> Figure:
    """Above computed and measured values, below their differences over the noise: series over time each by itself, single
    values of one unit together."""
    series = [n for n, data in enumerate(found.data) if data.value.size > 1]
    single: dict[str, list[int]] = {}
    for n, data in enumerate(found.data):
        if n not in series:
            single.setdefault(data.unit, []).append(n)
    count = len(series) + len(single)
    figure, axes = plt.subplots(2, count, figsize=(PANEL[0] * count, 2 * PANEL[1]), squeeze=False)
    for column, which in zip(axes.T, [[n] for n in series] + list(single.values())):
        measured = np.concatenate([found.data[n].value for n in which])
        computed = np.concatenate([found.computed(n) for n in which])
        is_series = which[0] in series
        if is_series:
            over_time(column[0], found.data[which[0]], computed)
        else:
            against_measured(column[0], measured, computed, found.data[which[0]].unit)
        column[1].axhspan(-2, 2, color="0.5", alpha=0.2, linewidth=0)
        column[1].plot(found.data[which[0]].t if is_series else measured, np.concatenate([found.residuals[n] for n in which]), ".", color=CURVES[0], ms=4)
        column[1].set_xlabel("t [s]" if is_series else f"measured [{found.data[which[0]].unit}]")
    axes[1, 0].set_ylabel("(computed - measured) / noise")
    return figure


def varied(found: Study) -> Figure:
    """Every quantity that varies, over every key of numbers."""
    keys = [key for key in found.keys if all(is_number(row[key]) for row in found.rows)]
    rows = [row for row in found.rows if "failed" not in row]
    shown = [name for name in found.quantities if np.ptp([row[name] for row in rows if name in row]) > 0]
    if not keys or not shown:
        raise CommandError("nothing varies over a key of numbers: there is nothing to draw")
    figure, axes = plt.subplots(len(shown), len(keys), figsize=(PANEL[0] * len(keys), 0.8 * PANEL[1] * len(shown)), squeeze=False, sharex="col", sharey="row")
    for line, name in zip(axes, shown):
        done = [row for row in rows if name in row]
        for ax, key in zip(line, keys):
            ax.plot([quantities.split(row[key])[0] for row in done], [row[name] for row in done], "o", ms=4)
        line[0].set_ylabel(name, fontsize=8)
    for ax, key in zip(axes[-1], keys):
        unit = quantities.split(found.rows[0][key])[1]
        ax.set_xlabel(f"{key}{f' [{unit}]' if unit else ''}", fontsize=8)
    return figure


def write(path: pathlib.Path, draw: Callable[[], Figure]) -> pathlib.Path:
    """As a picture."""
    import matplotlib
    matplotlib.use("Agg")
    with theme():
        figure = draw()
        figure.savefig(path)
        plt.close(figure)
    return path


def certificate_page(found: Certificate) -> pathlib.Path:
    """certificate.html beside certificate.json: all statements and the picture; it works by itself."""
    try:
        encoded = base64.b64encode(write(found.folder / "certificate.png", lambda: certificate(found)).read_bytes()).decode()
        picture = f"<p><img style=\"max-width:100%\" alt=\"values over the spacing\" src=\"data:image/png;base64,{encoded}\"></p>"
    except CommandError as nothing:
        picture = f"<p>No picture: {escape(str(nothing))}.</p>"
    rows = [("✓" if q.verdict and q.verdict.certified else "✗", name, q.statement) for name, q in found.quantities.items()]
    methods = [(name, method, f"{q.values[method][-1]:.7g}", "" if math.isnan(limit.order) else f"{limit.order:.2f}",
                text(limit.value, limit.bar, q.unit) if limit.is_asymptotic else limit.reason)
               for name, q in found.quantities.items() for method, limit in q.limits.items()]
    runs = [(run.method, f"{run.factor:g}", f"{run.points}", f"{run.seconds:.1f} s") for run in found.runs]
    body = "\n".join([f"<header><h1>{escape(found.title)}</h1><p>How sure are its numbers?</p></header>",
                      page.table(rows, numbers=3), picture,
                      "<h2>By method</h2>", page.table(methods, ("quantity", "method", "finest", "order", "limit"), numbers=2),
                      "<h2>Runs</h2>", page.table(runs, ("method", "times as fine", "points", "time"))])
    return page.fill(found.folder / "certificate.html", found.title, body, {"charts": [], "cloud": None})


__all__ = ["certificate", "certificate_page", "measurements", "varied", "write"]
