"""Pictures of results with matplotlib. `figure(result, what)` draws one of PICTURES; the other functions draw into given
axes, for figures of several parts. Lengths are in mm where the body is smaller than a metre."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from .command import CalorError, CommandError
from .quantities import in_unit
from .result import Array, Fields, Result, Table, is_straight, length_unit
from .stress import stress
from .style import theme

# Parts -------------------------------------------------------------------------------------------------------------


def cracks_of(result: Result) -> Array:
    """Both ends of every straight piece of the cracks of a body of two dimensions, (n, 2, 2), m."""
    pieces = []
    for crack in result.report["case"].get("crack", []) if result.dimension == 2 else []:
        corners = np.array([[in_unit(text, "m") for text in crack[axis]] for axis in "xy"]).T
        pieces += [corners[n:n + 2] for n in range(len(corners) - 1)]
    return np.array(pieces).reshape(-1, 2, 2)


def time_text(t: float, case: dict[str, Any]) -> str:
    return "steady" if "steady" in case else f"t = {t:.4g} s"


def histories(axes: Axes, table: Table, names: Sequence[str], y_label: str) -> None:
    """Columns over time; of a steady case, which has one row, a bar each with its number."""
    if len(table["time"]) > 1:
        for name in names:
            axes.plot(table["time"], table[name], label=name)
        axes.set(xlabel="t [s]", ylabel=y_label)
        return put_legend(axes)
    values = [table[name][-1] for name in names]
    is_temperature = y_label.startswith("T ")
    bars = axes.barh(range(len(names)), values, height=0.6, color=matplotlib.rcParams["axes.prop_cycle"].by_key()["color"][0])
    axes.bar_label(bars, [f"{value:.5g}" for value in values], padding=4, fontsize=8)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.margins(x=0.12)
    if is_temperature and len(values):  # bars from 0 K would all look the same
        span = max(np.ptp(values), 1)
        axes.set_xlim(min(values) - 0.3 * span, max(values) + 0.3 * span)
    axes.set(xlabel=y_label)


def put_legend(axes: Axes, **options: Any) -> None:
    """Beside the curves, where it hides none of them."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0, **options)


def references(axes: Axes, result: Result) -> None:
    """What was expected of the temperatures of probes over time: open circles in the colours of their curves."""
    colours = {line.get_label(): line.get_color() for line in axes.get_lines()}
    expected = result.report["case"].get("expect", [])
    is_named = False
    for n, (table, *_) in result.comparisons.items():
        entry = expected[n]
        if entry.get("probe") not in colours or entry["quantity"] != "temperature":
            continue
        table = result.shown(table)
        axes.plot(table["time"], table["reference"], "o", color=colours[entry["probe"]], markersize=4.5, fillstyle="none",
                  label=None if is_named else "expected")
        is_named = True
    put_legend(axes)


def field(fields: Fields, name: str) -> tuple[Array, str]:
    """Values and label of a field; of vectors their length. Raises CalorError."""
    if name not in fields:
        raise CommandError(f"there is no field '{name}'; there are {', '.join(fields)}")
    values = fields[name]
    return (np.linalg.norm(values, axis=1) if values.ndim > 1 else values), fields.label(name)


def cut(fields: Fields, plane: tuple[str, float] | None) -> tuple[Array, list[int], Array]:
    """The points of a section, the two axes in its plane, and how far the points lie before it, m: in 2D all points; in
    3D those within 0.7 spacings of a plane such as ("y", 0.01), without one of that through the middle of the body
    across its shortest side."""
    if fields.dimension == 1:
        raise CommandError("a rod has no section: ask for its lines")
    if fields.dimension == 2:
        return np.arange(len(fields.x)), [0, 1], np.zeros(len(fields.x))
    low, high = fields.x.min(0), fields.x.max(0)
    axis = "xyz".index(plane[0]) if plane else int(np.argmin(high - low))
    distance = fields.x[:, axis] - (plane[1] if plane else 0.5 * (low + high)[axis])
    near = np.flatnonzero(abs(distance) <= 0.7 * fields["spacing"])
    if len(near) < 3:
        raise CommandError(f"no points lie near this plane: {'xyz'[axis]} of the body goes from {low[axis]:g} to {high[axis]:g} m")
    across = [n for n in range(3) if n != axis]
    # Of points one behind the other, as lattices have them, the nearest.
    order = near[np.argsort(abs(distance[near]), kind="stable")]
    place = np.round(fields.x[order][:, across] / (0.2 * fields["spacing"][order, None])).astype(int)
    points = order[np.sort(np.unique(place, axis=0, return_index=True)[1])]
    return points, across, distance[points]


def in_section(fields: Fields, name: str, plane: tuple[str, float] | None) -> Array:
    """A field at the points of a section. Temperatures are carried into its plane along their gradient, -q / k."""
    points, across, distance = cut(fields, plane)
    values: Array = field(fields, name)[0][points]
    if name == "temperature" and fields.dimension == 3:
        axis = 3 - sum(across)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = fields["heat flux"][points, axis] / fields["conductivity"][points]
        values = values + np.nan_to_num(slope, posinf=0, neginf=0) * distance
    return values


def outward(surface: Fields, fields: Fields, points: Array, axes: Sequence[int]) -> tuple[Array, Array]:
    """Outward normals of the facets of some points in the plane of a section, (points, most, 2); 0 beyond their number.
    And whether each point is on an inner corner, where the body goes on beside one facet outwards of the other."""
    normal = surface["normal"][:, axes]
    size = np.linalg.norm(normal, axis=1)
    row_of = np.full(fields["id"].max() + 1, -1)
    row_of[fields["id"][points]] = np.arange(len(points))
    row = row_of[surface["point"]]
    facets = np.flatnonzero((size > 0.5) & (row >= 0))  # others lie flat in the plane
    facets = facets[np.argsort(row[facets], kind="stable")]
    row = row[facets]
    nth = np.arange(len(row)) - np.searchsorted(row, row)
    normals, ways = np.zeros((2, len(points), int(nth.max(initial=0)) + 1, 2))
    normals[row, nth] = normal[facets] / size[facets, None]
    ways[row, nth] = surface.x[facets][:, axes] - fields.x[points[row]][:, axes]  # from the point to the facet's middle
    is_inner = np.einsum("pad,pbd->pab", normals, ways).max((1, 2)) > 0.05 * fields["spacing"][points]
    return normals, is_inner


def triangles(fields: Fields, surface: Fields, points: Array, axes: Sequence[int], factor: float,
              cracks: Array | Sequence[Any] = ()) -> Triangulation:
    """A triangulation of the points, without the triangles that leave the body: longer than two spacings, with a side
    that goes outwards from a facet of its point, or across a crack."""
    x = fields.x[points][:, axes]
    mesh = Triangulation(*(factor * x.T))
    corners = x[mesh.triangles]
    following = np.roll(corners, -1, axis=1)
    length = np.linalg.norm(following - corners, axis=2)
    hidden = length.max(1) > 2.0 * fields["spacing"][points][mesh.triangles].max(1)

    normals, is_inner = outward(surface, fields, points, axes)
    has_facet = normals.any(2)
    along = (following - corners) / length[..., None]
    for begin, way in ((mesh.triangles, along), (np.roll(mesh.triangles, -1, axis=1), -along)):
        goes_out = np.einsum("tckd,tcd->tck", normals[begin], way) > 0.35
        leaves = np.where(is_inner[begin], (goes_out | ~has_facet[begin]).all(2), goes_out.any(2))
        hidden |= leaves.any(1)

    def side(a: Array, b: Array, c: Array) -> Array:
        """Of the line from a to b, where is c?"""
        turn: Array = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
        return turn

    for begin, end in cracks:
        parts_triangle = side(begin, end, corners) * side(begin, end, following) < 0
        parts_crack = side(corners, following, begin) * side(corners, following, end) < 0
        hidden |= (parts_triangle & parts_crack).any(1)
    mesh.set_mask(hidden)
    return mesh


def draw_section(axes: Axes, result: Result, name: str = "temperature", t: float | None = None,
                 plane: tuple[str, float] | None = None, *, isotherm: float | None = None,
                 limits: tuple[float, float] | None = None) -> Any:
    """A field on a section of the body at a time (the end), with its cracks and an isotherm, in the unit of the result;
    returns what a colour bar is made of. `plane`: see cut. `limits`: of the colours."""
    fields, cracks = result.shown(result.fields(t)), cracks_of(result)
    points, across, _ = cut(fields, plane)
    factor, unit = length_unit(fields.x)
    values = in_section(fields, name, plane)
    mesh = triangles(fields, result.surface(t), points, across, factor, cracks)
    low, high = limits or (values.min(), values.max())
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        low, high = low - 0.5, high + 0.5
    levels = np.linspace(low, high, 41)
    levels[-1] += 1e-6 * (high - low)  # what has the highest value lies below the last level
    filled = axes.tricontourf(mesh, np.clip(values, low, high), levels=levels, antialiased=False)
    if isotherm is not None and values.min() < isotherm < values.max():
        axes.tricontour(mesh, values, levels=[isotherm], colors="white", linewidths=1.4)
    for ends in cracks:
        axes.plot(*(factor * ends.T), color="black", linewidth=1.6)
    axes.set(xlabel=f"{'xyz'[across[0]]} [{unit}]", ylabel=f"{'xyz'[across[1]]} [{unit}]", aspect="equal")
    axes.grid(False)
    axes.use_sticky_edges = False  # the edge of the body is not that of the picture
    axes.margins(0.01)
    return filled


def colour_bar(figure: Figure, filled: Any, axes: Axes, label: str) -> None:
    bar = figure.colorbar(filled, ax=axes, label=label, shrink=0.9)
    bar.locator = matplotlib.ticker.MaxNLocator(6)
    bar.update_ticks()
    bar.outline.set_visible(False)


# Pictures ----------------------------------------------------------------------------------------------------------


def probes(result: Result) -> Figure:
    figure, axes = plt.subplots(figsize=(8, 4))
    table = result.shown(result.probes)
    names = [name for name in table if name != "time"]
    histories(axes, table, names, f"T [{result.degrees}]")
    references(axes, result)
    axes.set_title(f"{result.title}: temperatures at the probes")
    return figure


def balance(result: Result) -> Figure:
    figure, axes = plt.subplots(figsize=(8, 4))
    flows = [name for name in result.balance if result.balance.units[name] == "W"]
    histories(axes, result.balance, flows, "heat flow into the body [W]")
    zero = axes.axhline if len(result.balance["time"]) > 1 else axes.axvline
    zero(0, color=matplotlib.rcParams["text.color"], linewidth=0.6)
    axes.set_title(f"{result.title}: heat flows")
    return figure


def energy(result: Result) -> Figure:
    figure, axes = plt.subplots(figsize=(8, 4))
    heats = [name for name in result.energy if result.energy.units[name] == "J"]
    histories(axes, result.energy, heats, "heat since the start [J]")
    axes.set_title(f"{result.title}: heat stored and heat that came in")
    return figure


def pool(result: Result) -> Figure:
    """The sizes of the melt pool over time."""
    factor, unit = length_unit(result.fields().x)
    figure, axes = plt.subplots(figsize=(8, 4))
    sizes = [name for name in result.weld if result.weld.units[name] == "m" and not name.endswith((" from", " to"))]
    for name in sizes:
        axes.plot(result.weld["time"], factor * result.weld[name], label=name)
    axes.set(xlabel="t [s]", ylabel=f"extent of the melt [{unit}]", title=f"{result.title}: melt pool")
    put_legend(axes)
    return figure


def lines(result: Result, name: str = "temperature") -> Figure:
    """Comparisons on lines: what was calculated over what was expected. Without any, of a rod the field over x at up to
    six times."""
    figure, axes = plt.subplots(figsize=(8, 4))
    tables = [result.shown(table) for entry in result.comparisons.values() for table in entry if "x" in table and is_straight(table)]
    colours = iter(matplotlib.rcParams["axes.prop_cycle"].by_key()["color"] * 100)
    if tables:
        factor, unit = length_unit(np.concatenate([np.column_stack([table[c] for c in "xyz"]) for table in tables]))
        axis = max("xyz", key=lambda c: max(float(np.ptp(table[c])) for table in tables))
        for table, colour in zip(tables, colours):
            order = np.argsort(table[axis])
            value = next(column for column in table if column not in ("x", "y", "z", "reference"))
            axes.plot(factor * table[axis][order], table["reference"][order], "-", color=colour, linewidth=1)
            axes.plot(factor * table[axis][order], table[value][order], "o", color=colour, markersize=3, fillstyle="none")
        axes.plot([], [], "-", color="grey", label="expected")
        axes.plot([], [], "o", color="grey", fillstyle="none", markersize=3, label="calculated")
        axes.set(xlabel=f"{axis} [{unit}]", ylabel=table.label(value))
    elif result.dimension == 1:
        for n in np.unique(np.linspace(0, len(result.times) - 1, 6).round().astype(int)):
            fields = result.shown(result.fields(result.times[n]))
            values, label = field(fields, name)
            factor, unit = length_unit(fields.x)
            order = np.argsort(fields.x[:, 0])
            axes.plot(factor * fields.x[order, 0], values[order], label=time_text(fields.t, result.report["case"]))
            axes.set(xlabel=f"x [{unit}]", ylabel=label)
    else:
        raise CommandError("no [[expect]] of this result is on a line")
    axes.set_title(result.title)
    put_legend(axes)
    return figure


def isotherm_of(result: Result) -> float | None:
    """That of [weld], in the unit that is shown; nothing without one."""
    isotherm = result.report["case"].get("weld", {}).get("isotherm")
    if isotherm is None:
        return None
    return float(result.shown(Table({"T": np.array([in_unit(isotherm, "K")])}, {"T": "K"}))["T"][0])


def put_title(figure: Figure, text: str) -> None:
    """Over the whole figure: the axes may be much narrower."""
    figure.suptitle(text, x=0.01, ha="left", fontsize=10)


def section_figure(fields: Fields, plane: tuple[str, float] | None) -> tuple[Figure, Axes]:
    """As high as the section is wide, within limits."""
    points, across, _ = cut(fields, plane)
    width, height = np.ptp(fields.x[points][:, across], axis=0)
    figure, axes = plt.subplots(figsize=(8, float(np.clip(6.2 * height / width + 0.9, 2, 7))))
    return figure, axes


def section(result: Result, name: str = "temperature", t: float | None = None,
            plane: tuple[str, float] | None = None) -> Figure:
    """A field on a section, at a time (the end), with the isotherm of a weld; of a body of two dimensions all of it."""
    fields = result.shown(result.fields(t))
    figure, axes = section_figure(fields, plane)
    isotherm = isotherm_of(result) if name == "temperature" else None
    filled = draw_section(axes, result, name, t, plane, isotherm=isotherm)
    colour_bar(figure, filled, axes, field(fields, name)[1])
    factor, unit = length_unit(fields.x)
    where = ""
    if fields.dimension == 3:
        where = f", section {plane[0]} = {factor * plane[1]:g} {unit}" if plane else ", section through the middle"
    put_title(figure, f"{result.title}: {time_text(fields.t, result.report['case'])}{where}")
    return figure


def surface(result: Result, name: str = "temperature", t: float | None = None) -> Figure:
    """A field on the surface of a body of three dimensions."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
    fields = result.shown(result.surface(t))
    if fields.dimension != 3:
        raise CommandError("only bodies of three dimensions have a surface to look at: ask for the section")
    factor, unit = length_unit(fields.x)
    values, label = field(fields, name)
    figure = plt.figure(figsize=(8, 6.2))
    axes = figure.add_subplot(projection="3d", proj_type="persp")
    elevation, azimuth = np.radians([axes.elev, axes.azim])
    eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    is_seen = fields["normal"] @ eye > -0.2  # what looks away would only shine through the joints
    polygons = Poly3DCollection(factor * fields.corners[is_seen], array=values[is_seen])
    axes.add_collection3d(polygons)
    polygons.set(edgecolor="face", linewidth=1.6)  # closes the joints
    polygons.set_clim(values.min(), values.max())
    corners = factor * fields.corners.reshape(-1, 3)
    low, high = corners.min(0), corners.max(0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]), xlabel=f"x [{unit}]",
             ylabel=f"y [{unit}]", zlabel=f"z [{unit}]")
    axes.set_box_aspect(np.maximum(high - low, 0.05 * (high - low).max()), zoom=1.25)
    for axis, extent in zip((axes.xaxis, axes.yaxis, axes.zaxis), high - low):
        axis.pane.set_visible(False)
        axis.set_major_locator(matplotlib.ticker.MaxNLocator(4 if extent > 0.4 * (high - low).max() else 1))
    figure.colorbar(polygons, ax=axes, label=label, location="bottom", shrink=0.6, aspect=35, pad=0.06).outline.set_visible(False)
    put_title(figure, f"{result.title}: {time_text(fields.t, result.report['case'])}")
    return figure


PICTURES: dict[str, Callable[..., Figure]] = {
    "section": section, "surface": surface, "lines": lines, "probes": probes, "pool": pool, "balance": balance, "energy": energy,
    "stress": stress}


def figure(result: Result, what: str | None = None, *, dark: bool = False, **options: Any) -> Figure:
    """The picture `what` of PICTURES; without a word the first for which the result has what it takes. `options`: those
    of its function: name (of a field), t, plane. Raises CalorError."""
    with theme(dark):
        if what is not None:
            if what not in PICTURES:
                raise CommandError(f"there is no picture '{what}'; there are {', '.join(PICTURES)}")
            return PICTURES[what](result, **options)
        for draw in PICTURES.values():
            try:
                return draw(result, **options)
            except (CalorError, TypeError):
                plt.close()
    raise CommandError(f"{result.folder} has nothing to draw")


def pictures(result: Result, **options: Any) -> dict[str, Figure]:
    """All pictures for which the result has what they take."""
    drawn = {}
    for what in PICTURES:
        try:
            drawn[what] = figure(result, what, **options)
        except CalorError:
            plt.close()
    return drawn
