"""One page of HTML about a result: it holds everything, works without a network, and opens from a mail."""
from __future__ import annotations

import base64
import json
import os
import pathlib
import re
from html import escape
from typing import Any

import numpy as np

from . import toml
from .command import CalorError
from .result import Result, Table, is_straight, length_unit, number_text
from .style import CURVES, VIRIDIS

ASSETS = pathlib.Path(__file__).resolve().parent / "assets"
MOST_ROWS = 2000  # of a curve; a screen has no more
MOST_POINTS = 150_000
MOST_VALUES = 6_000_000  # of all fields together, two bytes each


# Curves ------------------------------------------------------------------------------------------------------------


def rounded(values: np.ndarray) -> list[float | None]:
    """With seven digits; what is no number is null."""
    return [float(f"{value:.7g}") if np.isfinite(value) else None for value in values]


def thinned(table: Table) -> dict[str, np.ndarray]:
    rows = len(table["time"])
    keep = np.unique(np.linspace(0, rows - 1, min(rows, MOST_ROWS)).round().astype(int))
    return {name: values[keep] for name, values in table.items()}


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
    curves = [{"label": name, "colour": CURVES[n % len(CURVES)], "x": rows["time"], "y": rows[name]} for n, name in enumerate(names)]
    return chart(title, "t [s]", y, curves) if curves else None


def probes(result: Result) -> dict[str, Any] | None:
    """Temperatures at the probes with what was expected of them."""
    if not (result.folder / "probes.csv").exists() or len(result.probes["time"]) < 2:
        return None
    table = result.shown(result.probes)
    rows, expected = thinned(table), result.report["case"].get("expect", [])
    curves = [{"label": name, "colour": CURVES[n % len(CURVES)], "x": rows["time"], "y": rows[name]}
              for n, name in enumerate(name for name in rows if name != "time")]
    colours = {curve["label"]: curve["colour"] for curve in curves}
    references: dict[str, dict[float, float]] = {}
    for n, (table, *_) in result.comparisons.items():
        if expected[n].get("probe") in colours and expected[n]["quantity"] == "temperature":
            references.setdefault(expected[n]["probe"], {}).update(zip(table["time"], result.shown(table)["reference"]))
    for name, points in references.items():
        times = np.array(sorted(points))
        curves.append({"label": f"{name}, expected", "colour": colours[name], "points": True, "x": times, "y": np.array([points[t] for t in times])})
    return chart("Temperatures at the probes", "t [s]", f"T [{degrees(result)}]", curves)


def comparisons(result: Result) -> list[dict[str, Any]]:
    """Lines on which fields are compared: calculated points over the expected line."""
    charts = []
    for n, tables in result.comparisons.items():
        if "x" not in tables[0] or not is_straight(tables[0]):
            continue
        tables = [result.shown(table) for table in tables]
        factor, unit = length_unit(np.column_stack([tables[0][axis] for axis in "xyz"]))
        axis = max("xyz", key=lambda name: np.ptp(tables[0][name]))
        column = next(name for name in tables[0] if name not in ("x", "y", "z", "reference"))
        times = result.report["case"]["expect"][n].get("at", [""] * len(tables))
        curves = []
        for k, table in enumerate(tables):
            order = np.unique(table[axis], return_index=True)[1]
            x, colour = factor * table[axis][order], CURVES[k % len(CURVES)]
            when = f" {times[k]}" if isinstance(times, list) and k < len(times) and times[k] else ""
            curves.append({"label": f"expected{when}", "colour": colour, "thin": True, "x": x, "y": table["reference"][order]})
            curves.append({"label": f"calculated{when}", "colour": colour, "points": True, "x": x, "y": table[column][order]})
        what = next((v["what"] for v in result.verdicts if n < len(result.verdicts)), "")
        charts.append(chart(f"Comparison {n + 1}: {re.sub(' at .*', '', what)}", f"{axis} [{unit}]", tables[0].label(column), curves))
    return charts


def rod(result: Result) -> dict[str, Any] | None:
    """Of a body of one dimension: temperatures over its length at up to six times."""
    if result.dimension != 1:
        return None
    curves = []
    for n in np.unique(np.linspace(0, len(result.times) - 1, 6).round().astype(int)):
        fields = result.shown(result.fields(result.times[n]))
        factor, unit = length_unit(fields.x)
        order = np.argsort(fields.x[:, 0])
        curves.append({"label": f"{fields.t:.4g} s", "colour": CURVES[len(curves) % len(CURVES)], "x": factor * fields.x[order, 0], "y": fields["temperature"][order]})
    return chart("Temperatures along the rod", f"x [{unit}]", f"T [{degrees(result)}]", curves)


def degrees(result: Result) -> str:
    return "°C" if result.uses_celsius else "K"


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


def packed(values: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(values)).decode()


def quantised(label: str, unit: str, steps: list[np.ndarray]) -> dict[str, Any]:
    """A field as whole numbers of 16 bits between its lowest and highest value."""
    low, high = (float(f([f(step) for step in steps])) for f in (np.min, np.max))
    span = high - low or 1.0
    values = [packed(((step - low) / span * 65535).round().astype("<u2")) for step in steps]
    return {"label": f"{label} [{unit}]" if unit else label, "unit": unit, "low": low, "high": low + span, "values": values}


def cloud_of(result: Result) -> dict[str, Any] | None:
    """What viewer.js shows; nothing without fields, or of a rod."""
    if result.dimension == 1 or not (result.folder / "fields.pvd").exists() or not len(result.times):
        return None
    last = result.shown(result.fields())
    count = len(last.x)
    # Of many points every n-th by its id: lattices count along their lines, so that n must not divide these.
    step = max(1, int(np.ceil(count / MOST_POINTS)))
    kept = np.flatnonzero((last["id"] * 2654435761 % 4294967296) % step == 0) if step > 1 else np.arange(count)
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
            shown.append(quantised(f"{name}, at the end" if name not in ("spacing", "part", "tag") else name, last.units[name], [values[kept]]))
    factor, unit = length_unit(last.x)
    sizes = last["spacing"][kept] * step ** (1 / result.dimension)
    return {"dimension": result.dimension, "x": packed(last.x[kept].astype("<f4")), "size": packed(sizes.astype("<f4")), "factor": factor, "unit": unit,
            "low": last.x.min(0).tolist(), "high": last.x.max(0).tolist(), "times": [float(t) for t in times], "fields": shown,
            "colours": VIRIDIS, "all": count, "shown": len(kept)}


# Text --------------------------------------------------------------------------------------------------------------


def rows_of(pairs: list[tuple[str, str]]) -> str:
    return "<table>" + "".join(f"<tr><th scope=\"row\">{escape(name)}</th><td class=\"number\">{value}</td></tr>" for name, value in pairs) + "</table>"


def header(result: Result) -> str:
    numbers, report = result.numbers, result.report
    stopped = numbers.get("interrupted_by")
    word, kind = ("interrupted", "bad") if stopped else ("all expectations met", "good") if result.passed and result.verdicts else \
        ("done", "good") if result.passed else ("expectations failed", "bad")
    ranks = int(numbers["ranks"])
    about = [f"method {report['method']}", f"{numbers['points']:.0f} points in {result.dimension}D", f"integrator {report['integrator']}",
             f"{ranks} process{'es' if ranks > 1 else ''}", f"calor {report['versions']['calor']}"]
    return (f"<header><h1>{escape(result.title)}</h1><span class=\"badge {kind}\">{word}</span><button id=\"theme\" title=\"light or dark\">light / dark</button>"
            f"<p>{escape(', '.join(about))}</p></header>")


def verdicts(result: Result) -> str:
    if not result.verdicts:
        return "<p>The case has no [[expect]] entries: nothing says how good this result is.</p>"
    rows = "".join(f"<tr><td class=\"{'good' if v['passed'] else 'bad'}\">{'&#10003; met' if v['passed'] else '&#10007; failed'}</td><td>{escape(v['what'])}</td>"
                   f"<td>{escape(v['norm'])}</td><td class=\"number\">{number_text(v['error'])} {escape(v['unit'])}</td>"
                   f"<td class=\"number\">{number_text(v['tolerance'])} {escape(v['unit'])}</td></tr>" for v in result.verdicts)
    return ("<div class=\"wide\"><table><tr><th></th><th>what</th><th>norm</th><th class=\"number\">error or value</th>"
            f"<th class=\"number\">bound</th></tr>{rows}</table></div>")


VIEWER = """<div id="viewer"><div id="stage"><canvas tabindex="0" aria-label="the points of the body in the colours of a field"></canvas>
<div id="axes">{axes}</div><div id="probe" role="status"></div><div id="scale"><canvas></canvas><div id="ticks"></div></div></div>
<div class="controls"><label>field <select id="field"></select></label>
<span id="times"><button id="play">play</button><input type="range" id="time" min="0" aria-label="time"><span id="now"></span></span>
<label id="ranges">colours <select id="range"><option value="all">of all times</option><option value="now">of this time</option></select></label>
<label id="cuts">cut <select id="cut"><option value="none">none</option>{cuts}</select><input type="range" id="cutat" min="0" max="1000" value="500" aria-label="place of the cut"></label>
<button id="reset">reset view</button></div></div><p class="faint">{hint}</p>"""


def viewer(result: Result, cloud: dict[str, Any] | None) -> str:
    if cloud is None:
        return ""
    unit, factor = cloud["unit"], cloud["factor"]
    axes = ", ".join(f"{name}: {factor * cloud['low'][n]:.4g} to {factor * cloud['high'][n]:.4g} {unit}" for n, name in enumerate("xyz"[:result.dimension]))
    cuts = "".join(f"<option value=\"{sign}{axis}\">away {'above' if sign == '+' else 'below'} {axis}</option>" for axis in "xyz" for sign in "+-")
    hint = ("Drag to turn, shift and drag to move, wheel to zoom; rest on a point for its value." if result.dimension == 3
            else "Drag to move, wheel to zoom; rest on a point for its value.")
    if cloud["shown"] < cloud["all"]:
        hint += f" Shown are {cloud['shown']} of {cloud['all']} points."
    return "<h2>Fields</h2>" + VIEWER.format(axes=escape(axes), cuts=cuts, hint=escape(hint))


def balance(result: Result) -> str:
    flows = {name: result.balance[name][-1] for name in result.balance if result.balance.units[name] == "W"}
    pairs = [(name, f"{value:.5g} W") for name, value in flows.items()]
    total, largest = sum(flows.values()), max(map(abs, flows.values()), default=0)
    pairs.append(("sum", f"{total:.5g} W" if abs(total) > 1e-9 * largest else "0 W, to round-off"))
    text = "<div><h3>Heat flow into the body, at the end</h3>" + rows_of(pairs) + "</div>"
    if (result.folder / "energy.csv").exists():
        energy = result.energy
        pairs = [(name, f"{energy[name][-1]:.6g} J") for name in energy if energy.units[name] == "J"]
        pairs.append(("imbalance, of the largest", f"{energy['imbalance'][-1]:.1e}"))
        text += "<div><h3>Heat since the start</h3>" + rows_of(pairs) + "</div>"
    table = result.shown(result.balance)
    zones = [name.removeprefix("mean of ") for name in result.balance if name.startswith("mean of ")]
    rows = "".join(f"<tr><th scope=\"row\">{escape(zone)}</th>" + "".join(f"<td class=\"number\">{table[f'{what} of {zone}'][-1]:.6g}</td>"
                                                                  for what in ("mean", "minimum", "maximum")) + "</tr>" for zone in zones)
    text += (f"<div><h3>Temperatures at the end, {degrees(result)}</h3><table><tr><th></th><th class=\"number\">mean</th><th class=\"number\">lowest</th>"
             f"<th class=\"number\">highest</th></tr>{rows}</table></div>")
    return f"<h2>Balance</h2><div class=\"columns\">{text}</div>"


# Of report.json what tells how good a cloud and its weights are, and how to say it.
QUALITY = {
    "points": ("points", "{:.0f}"), "volume": ("volume, m³", "{:.6g}"), "volume_error": ("its relative error", "{:.1e}"),
    "area_sum": ("boundary areas, |sum A| / sum |A|", "{:.1e}"), "moment_sum": ("their moment", "{:.1e}"),
    "neighbours": ("neighbours of a point, mean", "{:.1f}"), "pairs": ("pairs", "{:.0f}"),
    "weight_residual": ("linear temperatures, residual of the weights", "{:.1e}"), "negative_share": ("share of negative weights", "{:.2g}"),
}


def quality(result: Result) -> str:
    pairs = [(name, style.format(result.numbers[key])) for key, (name, style) in QUALITY.items() if key in result.numbers]
    if (result.folder / "fields.pvd").exists() and len(result.times):
        spacing = result.fields()["spacing"]
        pairs.insert(1, ("spacing, m", f"{spacing.min():.4g}" + ("" if np.ptp(spacing) <= 1e-9 * spacing.max() else f" to {spacing.max():.4g}")))
    return "<div><h2>Cloud</h2>" + rows_of(pairs) + "</div>"


def effort(result: Result) -> str:
    seconds = result.report["seconds"]
    most = max((entry["wall"] for entry in seconds.values()), default=0) or 1
    rows = "".join(f"<tr><th scope=\"row\">{escape(name)}</th><td class=\"number\">{entry['wall']:.3g} s</td><td class=\"number\">{entry['cpu']:.3g} s</td>"
                   f"<td style=\"width:8rem\"><div class=\"bar\" style=\"width:{100 * entry['wall'] / most:.1f}%\"></div></td></tr>" for name, entry in seconds.items())
    counts = [(name.replace("_", " "), f"{result.numbers[name]:.0f}") for name in ("steps", "rejected_steps", "rate_evaluations", "newton_iterations", "linear_iterations")
              if result.numbers.get(name)]
    counts.append(("memory of the largest process", f"{result.numbers['memory_bytes'] / 1e6:.0f} MB"))
    return (f"<div><h2>Effort</h2><table><tr><th></th><th class=\"number\">wall</th><th class=\"number\">processors</th><th></th></tr>{rows}</table>" + rows_of(counts) + "</div>")


def repeat(result: Result) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in result.report["versions"].items())
    ranks = int(result.numbers["ranks"])
    log = result.folder / "run.log"
    notes = "".join(re.sub(r"^\S+ \S+  ", "", line) + "\n" for line in log.read_text().splitlines()) if log.exists() else ""
    text = f"<h2>How to repeat it</h2><pre>calor run {escape(result.name)}.toml{f' -j {ranks}' if ranks > 1 else ''}</pre><p>with {escape(versions)}.</p>"
    if notes:
        text += f"<details><summary>What the run said</summary><pre>{escape(notes)}</pre></details>"
    return text + f"<details><summary>{escape(result.name)}.toml, with all defaults</summary><pre>{escape(toml.write(result.report['case']))}</pre></details>"


def write(result: Result, path: str | os.PathLike[str] | None = None) -> pathlib.Path:
    """Writes the page, by default to FOLDER/report.html, and returns its path. Raises CalorError."""
    cloud, charts = cloud_of(result), charts_of(result)
    curves = "".join(f"<div class=\"chart\"><h3>{escape(one['title'])}</h3><div id=\"{one['id']}\"></div></div>" for one in charts)
    if curves:
        curves = f"<h2>Curves</h2>{curves}<p class=\"faint\">Drag over a part to see it closer, double-click to see all; click a name to hide its curve.</p>"
    body = "\n".join([header(result), "<h2>Expectations</h2>", verdicts(result), viewer(result, cloud), curves, balance(result),
                      f"<div class=\"columns\">{quality(result)}{effort(result)}</div>", repeat(result)])
    data = json.dumps({"charts": charts, "cloud": cloud}, allow_nan=False).replace("<", "\\u003c")
    parts = {"title": escape(result.title), "body": body, "data": data}
    template = (ASSETS / "page.html").read_text()
    page = re.sub(r"\{\{([^}]+)\}\}", lambda name: parts[name[1]] if name[1] in parts else (ASSETS / name[1]).read_text(), template)
    into = pathlib.Path(path) if path is not None else result.folder / "report.html"
    try:
        into.write_text(page)
    except OSError as error:
        raise CalorError(f"{into} cannot be written: {error.strerror}") from None
    return into
