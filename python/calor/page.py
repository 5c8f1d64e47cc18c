"""One page of HTML about a result: it holds everything, works without a network, and opens from a mail."""
from __future__ import annotations

import base64
import json
import os
import pathlib
import re
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from . import toml
from .command import CalorError, FileError
from .result import Array, Fields, Result, Table, is_straight, length_unit, number_text
from .style import CURVES, VIRIDIS

ASSETS = pathlib.Path(__file__).resolve().parent / "assets"
MOST_ROWS = 2000  # of a curve; a screen has no more
MOST_POINTS = 150_000
MOST_VALUES = 6_000_000  # of all fields together, two bytes each


# Curves ------------------------------------------------------------------------------------------------------------


def rounded(values: Array) -> list[float | None]:
    """With seven digits; what is no number is null."""
    return [float(f"{value:.7g}") if np.isfinite(value) else None for value in values]


def thinned(table: Table) -> dict[str, Array]:
    rows = len(table["time"])
    keep = np.unique(np.linspace(0, rows - 1, min(rows, MOST_ROWS)).round().astype(int))
    return {name: values[keep] for name, values in table.items()}


def curve(label: str, n: int, x: Array, y: Array, **kind: bool) -> dict[str, Any]:
    """The n-th colour; `kind`: points=True for circles, thin=True for a thin line."""
    return {"label": label, "colour": CURVES[n % len(CURVES)], "x": x, "y": y, **kind}


def chart(title: str, x: str, y: str, curves: list[dict[str, Any]]) -> dict[str, Any]:
    """What page.js draws. `curves`: label, colour, x, y, and points or thin; on one x axis, whose places they need not
    share."""
    places = np.unique(np.concatenate([curve["x"] for curve in curves]))
    columns = [rounded(places)]
    for curve in curves:
        column = np.full(len(places), np.nan)
        column[np.searchsorted(places, curve["x"])] = curve["y"]
        columns.append(rounded(column))
    series = [{key: curve[key] for key in ("label", "colour", "points", "thin") if key in curve} for curve in curves]
    return {"title": title, "x": x, "y": y, "columns": columns, "series": series}


def history(title: str, table: Table, unit: str, y: str, names: list[str] | None = None) -> dict[str, Any] | None:
    """Columns of one unit over time; nothing for a single time."""
    if len(table["time"]) < 2:
        return None
    rows = thinned(table)
    names = names if names is not None else [name for name in table if table.units[name] == unit and name != "time"]
    curves = [curve(name, n, rows["time"], rows[name]) for n, name in enumerate(names)]
    return chart(title, "t [s]", y, curves) if curves else None


def probes(result: Result) -> dict[str, Any] | None:
    """Temperatures at the probes with what was expected of them."""
    if not (result.folder / "probes.csv").exists() or len(result.probes["time"]) < 2:
        return None
    table = result.shown(result.probes)
    rows, expected = thinned(table), result.report["case"].get("expect", [])
    names = [name for name in rows if name != "time"]
    curves = [curve(name, n, rows["time"], rows[name]) for n, name in enumerate(names)]
    references: dict[str, dict[float, float]] = {}
    for n, (of_probe, *_) in result.comparisons.items():
        if expected[n].get("probe") in names and expected[n]["quantity"] == "temperature":
            references.setdefault(expected[n]["probe"], {}).update(zip(of_probe["time"], result.shown(of_probe)["reference"]))
    for name, points in references.items():
        times = sorted(points)
        values = np.array([points[t] for t in times])
        curves.append(curve(f"{name}, expected", names.index(name), np.array(times), values, points=True))
    return chart("Temperatures at the probes", "t [s]", f"T [{result.degrees}]", curves)


def comparisons(result: Result) -> list[dict[str, Any]]:
    """Lines on which fields are compared: calculated points over the expected line."""
    charts = []
    for n, tables in result.comparisons.items():
        if "x" not in tables[0] or not is_straight(tables[0]):
            continue
        tables = [result.shown(table) for table in tables]
        factor, unit = length_unit(np.column_stack([tables[0][axis] for axis in "xyz"]))
        axis = max("xyz", key=lambda name: float(np.ptp(tables[0][name])))
        column = next(name for name in tables[0] if name not in ("x", "y", "z", "reference"))
        times = result.report["case"]["expect"][n].get("at", [""] * len(tables))
        curves = []
        for k, table in enumerate(tables):
            order = np.unique(table[axis], return_index=True)[1]
            x = factor * table[axis][order]
            when = f" {times[k]}" if isinstance(times, list) and k < len(times) and times[k] else ""
            curves.append(curve(f"expected{when}", k, x, table["reference"][order], thin=True))
            curves.append(curve(f"calculated{when}", k, x, table[column][order], points=True))
        what = next((v["what"] for v in result.verdicts if n < len(result.verdicts)), "")
        charts.append(chart(f"Comparison {n + 1}: {re.sub(' at .*', '', what)}", f"{axis} [{unit}]", tables[0].label(column), curves))
    return charts


def rod(result: Result) -> dict[str, Any] | None:
    """Of a body of one dimension: temperatures over its length at up to six times."""
    if result.dimension != 1 or not result.has_fields:
        return None
    curves: list[dict[str, Any]] = []
    for n in np.unique(np.linspace(0, len(result.times) - 1, 6).round().astype(int)):
        fields = result.shown(result.fields(result.times[n]))
        factor, unit = length_unit(fields.x)
        order = np.argsort(fields.x[:, 0])
        x, T = factor * fields.x[order, 0], fields["temperature"][order]
        curves.append(curve(f"{fields.t:.4g} s", len(curves), x, T))
    return chart("Temperatures along the rod", f"x [{unit}]", f"T [{result.degrees}]", curves)


def charts_of(result: Result) -> list[dict[str, Any]]:
    found = [probes(result), *comparisons(result), rod(result)]
    found.append(history("Heat flows into the body", result.balance, "W", "heat flow [W]"))
    if (result.folder / "weld.csv").exists():
        sizes = [name for name in result.weld if result.weld.units[name] == "m" and not name.endswith((" from", " to"))]
        scaled = Table({name: values * (1e3 if name in sizes else 1) for name, values in result.weld.items()}, result.weld.units)
        found.append(history("Extent of the melt", scaled, "m", "extent [mm]", sizes))
    if (result.folder / "energy.csv").exists():
        found.append(history("Heat since the start", result.energy, "J", "heat [J]"))
    charts = [one for one in found if one]
    for n, one in enumerate(charts):
        one["id"] = f"chart{n}"
    return charts


# Fields ------------------------------------------------------------------------------------------------------------


def packed(values: Array) -> str:
    return base64.b64encode(values.tobytes()).decode()


def quantised(label: str, unit: str, steps: list[Array]) -> dict[str, Any]:
    """A field as whole numbers of 16 bits between its lowest and highest value."""
    low, high = (float(f([f(step) for step in steps])) for f in (np.min, np.max))
    span = high - low or 1.0
    values = [packed(((step - low) / span * 65535).round().astype("<u2")) for step in steps]
    return {"label": f"{label} [{unit}]" if unit else label, "unit": unit, "low": low, "high": low + span, "values": values}


def shown_points(fields: Fields, on_surface: Array) -> tuple[Array, Array]:
    """Rows of the points that are shown and how large: of too many those on the surface first, by their ids; of the
    others some by chance, grown to fill the space."""
    count, is_outside = len(fields.x), np.isin(fields["id"], on_surface)
    if count <= MOST_POINTS:
        return np.arange(count), fields["spacing"]
    random = np.random.default_rng(1)
    kept = np.zeros(count, bool)
    sizes = fields["spacing"].copy()
    left = MOST_POINTS
    for group in (np.flatnonzero(is_outside), np.flatnonzero(~is_outside)):
        part = min(1.0, left / max(1, len(group)))
        chosen = random.permutation(group)[:left]
        kept[chosen] = True
        sizes[chosen] *= part ** (-1 / fields.dimension) if part > 0 else 1
        left -= len(chosen)
    rows = np.flatnonzero(kept)
    return rows, sizes[rows]


def cloud_of(result: Result) -> dict[str, Any] | None:
    """What viewer.js shows; nothing without fields, or of a rod."""
    if result.dimension == 1 or not result.has_fields:
        return None
    last = result.shown(result.fields())
    count = len(last.x)
    kept, sizes = shown_points(last, np.unique(result.surface()["point"]))
    most_times = max(2, MOST_VALUES // (2 * len(kept)))
    times = result.times[np.unique(np.linspace(0, len(result.times) - 1, min(len(result.times), most_times)).round().astype(int))]

    temperatures, fluxes = [], []
    for t in times:  # the order of the points is that of all times
        fields = result.shown(result.fields(t))
        temperatures.append(fields["temperature"][kept])
        fluxes.append(np.linalg.norm(fields["heat flux"][kept], axis=1))
    shown = [quantised("temperature", last.units["temperature"], temperatures), quantised("heat flux", "W/m^2", fluxes)]
    for name in last:
        values = last[name]
        if name in ("temperature", "heat flux", "id", "volume") or values.ndim > 1:
            continue
        if np.isfinite(values).all() and np.ptp(values) > 1e-9 * abs(values).max():
            label = name if name in ("spacing", "part", "tag") else f"{name}, at the end"
            shown.append(quantised(label, last.units[name], [values[kept]]))
    factor, unit = length_unit(last.x)
    return {"dimension": result.dimension, "x": packed(last.x[kept].astype("<f4")), "size": packed(sizes.astype("<f4")),
            "factor": factor, "unit": unit, "low": last.x.min(0).tolist(), "high": last.x.max(0).tolist(), "times": [float(t) for t in times],
            "fields": shown,
            "colours": VIRIDIS, "all": count, "shown": len(kept)}


# Text --------------------------------------------------------------------------------------------------------------


def table(rows: Sequence[Sequence[str]], headings: Sequence[str] = (), numbers: int = 1) -> str:
    """Rows of texts; those after the first `numbers` columns are numbers, on the right."""
    def line(cells: Sequence[str], kind: str) -> str:
        marks = [" class=number" if n >= numbers else "" for n in range(len(cells))]
        return "<tr>" + "".join(f"<{kind}{mark}>{escape(text)}</{kind}>" for mark, text in zip(marks, cells)) + "</tr>"

    head = line(headings, "th") if headings else ""
    return f"<div class=\"wide\"><table>{head}{''.join(line(row, 'td') for row in rows)}</table></div>"


def header(result: Result) -> str:
    word, kind = ("done" if not result.verdicts else "all expectations met", "good") if result.passed else ("expectations failed", "bad")
    if result.numbers.get("interrupted_by"):
        word, kind = "interrupted", "bad"
    ranks = int(result.numbers["ranks"])
    about = [f"method {result.report['method']}", f"{result.numbers['points']:.0f} points in {result.dimension}D",
             f"integrator {result.report['integrator']}", f"{ranks} process{'es' if ranks > 1 else ''}",
             f"calor {result.report['versions']['calor']}"]
    return (f"<header><h1>{escape(result.title)}</h1><span class=\"badge {kind}\">{word}</span>"
            f"<button id=\"theme\" title=\"light or dark\">light / dark</button><p>{escape(', '.join(about))}</p></header>")


def verdicts(result: Result) -> str:
    if not result.verdicts:
        return "<p>The case has no [[expect]] entries: nothing says how good this result is.</p>"
    rows = [("✓ met" if v["passed"] else "✗ failed", v["what"], v["norm"], f"{number_text(v['error'])} {v['unit']}",
             f"{number_text(v['tolerance'])} {v['unit']}") for v in result.verdicts]
    text = table(rows, ("", "what", "norm", "error or value", "bound"), numbers=3)
    return re.sub(r"<td>([✓✗])", lambda mark: f"<td class={'good' if mark[1] == '✓' else 'bad'}>{mark[1]}", text)


def viewer(result: Result, cloud: dict[str, Any] | None) -> str:
    if cloud is None:
        return ""
    unit, factor = cloud["unit"], cloud["factor"]
    axes = ", ".join(f"{name}: {factor * cloud['low'][n]:.4g} to {factor * cloud['high'][n]:.4g} {unit}"
                     for n, name in enumerate("xyz"[:result.dimension]))
    sides = (("+", "above"), ("-", "below"))
    cuts = "".join(f"<option value={sign}{axis}>away {side} {axis}</option>" for axis in "xyz" for sign, side in sides)
    hint = "Drag to turn, shift and drag to move, " if result.dimension == 3 else "Drag to move, "
    hint += "wheel to zoom; rest on a point for its value."
    if cloud["shown"] < cloud["all"]:
        hint += f" Shown are {cloud['shown']} of {cloud['all']} points."
    return (ASSETS / "viewer.html").read_text().format(axes=escape(axes), cuts=cuts, hint=escape(hint))


def balance(result: Result) -> str:
    flows = {name: float(result.balance[name][-1]) for name in result.balance if result.balance.units[name] == "W"}
    total, largest = sum(flows.values()), max((abs(flow) for flow in flows.values()), default=0.0)
    rows = [(name, f"{flow:.5g} W") for name, flow in flows.items()]
    rows.append(("sum", f"{total:.5g} W" if abs(total) > 1e-9 * largest else "0 W, to round-off"))
    text = "<div><h3>Heat flow into the body, at the end</h3>" + table(rows) + "</div>"
    if (result.folder / "energy.csv").exists():
        rows = [(name, f"{values[-1]:.6g} J") for name, values in result.energy.items() if result.energy.units[name] == "J"]
        rows.append(("imbalance, of the largest", f"{result.energy['imbalance'][-1]:.1e}"))
        text += "<div><h3>Heat since the start</h3>" + table(rows) + "</div>"
    shown = result.shown(result.balance)
    zones = [name.removeprefix("mean of ") for name in shown if name.startswith("mean of ")]
    temperatures = [(zone, *(f"{shown[f'{what} of {zone}'][-1]:.6g}" for what in ("mean", "minimum", "maximum"))) for zone in zones]
    text += f"<div><h3>Temperatures at the end, {result.degrees}</h3>" + table(temperatures, ("", "mean", "lowest", "highest")) + "</div>"
    return f"<h2>Balance</h2><div class=\"columns\">{text}</div>"


# Of report.json what tells how good a cloud and its weights are, and how to say it.
QUALITY = {
    "points": ("points", "{:.0f}"), "volume": ("volume, m³", "{:.6g}"), "volume_error": ("its relative error", "{:.1e}"),
    "area_sum": ("boundary areas, |sum A| / sum |A|", "{:.1e}"), "moment_sum": ("their moment", "{:.1e}"),
    "neighbours": ("neighbours of a point, mean", "{:.1f}"), "pairs": ("pairs", "{:.0f}"),
    "weight_residual": ("linear temperatures, residual of the weights", "{:.1e}"),
    "negative_share": ("share of negative weights", "{:.2g}"),
}


def quality(result: Result) -> str:
    numbers = result.numbers
    rows = [(name, style.format(numbers[key])) for key, (name, style) in QUALITY.items() if numbers.get(key) is not None]
    if result.has_fields:
        spacing = result.fields()["spacing"]
        low, high = float(spacing.min()), float(spacing.max())
        rows.insert(1, ("spacing, m", f"{low:.4g}" if high - low <= 1e-6 * high else f"{low:.4g} to {high:.4g}"))
    return "<div><h2>Cloud</h2>" + table(rows) + "</div>"


def effort(result: Result) -> str:
    seconds, numbers = result.report["seconds"], result.numbers
    rows = [(name, f"{spent['wall']:.3g} s", f"{spent['cpu']:.3g} s") for name, spent in seconds.items()]
    counts = [(name.replace("_", " "), f"{numbers[name]:.0f}") for name in
              ("steps", "rejected_steps", "rate_evaluations", "newton_iterations", "linear_iterations") if numbers.get(name)]
    counts.append(("memory of the largest process", f"{numbers['memory_bytes'] / 1e6:.0f} MB"))
    return "<div><h2>Effort</h2>" + table(rows, ("", "wall", "processors")) + table(counts) + "</div>"


def repeat(result: Result) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in result.report["versions"].items())
    ranks = int(result.numbers["ranks"])
    log = result.folder / "run.log"
    notes = "".join(re.sub(r"^\S+ \S+  ", "", line) + "\n" for line in log.read_text().splitlines()) if log.exists() else ""
    command = f"calor run {result.name}.toml" + (f" -j {ranks}" if ranks > 1 else "")
    text = f"<h2>How to repeat it</h2><pre>{escape(command)}</pre><p>with {escape(versions)}.</p>"
    if notes:
        text += f"<details><summary>What the run said</summary><pre>{escape(notes)}</pre></details>"
    case = escape(toml.write(result.report["case"]))
    return text + f"<details><summary>{escape(result.name)}.toml, with all defaults</summary><pre>{case}</pre></details>"


def write(result: Result, path: str | os.PathLike[str] | None = None) -> pathlib.Path:
    """Writes the page, by default to FOLDER/report.html, and returns its path. Raises CalorError."""
    cloud, charts = cloud_of(result), charts_of(result)
    curves = "".join(f"<div class=\"chart\"><h3>{escape(one['title'])}</h3><div id=\"{one['id']}\"></div></div>" for one in charts)
    if curves:
        hint = "Drag over a part to see it closer, double-click to see all; click a name to hide its curve."
        curves = f"<h2>Curves</h2>{curves}<p class=\"faint\">{hint}</p>"
    body = "\n".join([header(result), "<h2>Expectations</h2>", verdicts(result), viewer(result, cloud), curves, balance(result),
                      f"<div class=\"columns\">{quality(result)}{effort(result)}</div>", repeat(result)])
    return fill(pathlib.Path(path) if path is not None else result.folder / "report.html", result.title, body, {"charts": charts, "cloud": cloud})


def fill(path: pathlib.Path, title: str, body: str, data: dict[str, Any]) -> pathlib.Path:
    """Writes a page of a body of HTML and what its script draws, and returns its path. Raises CalorError."""
    parts = {"title": escape(title), "body": body, "data": json.dumps(data, allow_nan=False).replace("<", "\\u003c")}
    template = (ASSETS / "page.html").read_text()

    def filled(name: re.Match[str]) -> str:
        return parts[name[1]] if name[1] in parts else (ASSETS / name[1]).read_text()

    try:
        path.write_text(re.sub(r"\{\{([^}]+)\}\}", filled, template))
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror}") from None
    return path
