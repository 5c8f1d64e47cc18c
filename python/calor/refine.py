"""The same case with finer or coarser points."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from . import quantities
from .command import CaseError, CommandError
from .toml import listed


MOST = 1000  # times as many points along a line: more is a slip of the pen


def check_factors(factors: Sequence[float], least: int) -> None:
    """Raises CommandError where these are no factors of refinement, or fewer than `least`."""
    rise = all(0 < factor <= MOST for factor in factors) and all(a < b for a, b in zip(factors, factors[1:]))
    if len(factors) < least or not rise:
        raise CommandError(f"it takes at least {('two', 'three')[least - 2]} factors of refinement up to {MOST}, rising, such as 1,1.5,2")


def scaled(quantity: Any, factor: float) -> str | float:
    """ "0.25 mm" of "0.5 mm" and 0.5."""
    number, unit = quantities.split(quantity)
    return quantities.joined(number * factor, unit)


def divided(places: Sequence[str], parts: int) -> list[str]:
    """Every interval between places, such as "2 mm", in so many equal parts, in the unit of the first."""
    unit = quantities.split(places[0])[1]
    at = [quantities.in_unit(place, unit) for place in places]
    finer = [a + (b - a) * n / parts for a, b in zip(at, at[1:]) for n in range(parts)] + at[-1:]
    return [f"{value:.15g} {unit}" for value in finer]


def is_random(cloud: Mapping[str, Any]) -> bool:
    """Does every spacing have points at places of its own?"""
    return cloud.get("shape") == "surface" or bool(cloud.get("jitter"))


def can_be_divided_only(cloud: Mapping[str, Any]) -> bool:
    """Are the places of points listed one by one?"""
    return cloud.get("shape") == "box" and any(axis in cloud for axis in "xyz")


def refined(cloud: Mapping[str, Any], factor: float) -> tuple[dict[str, Any], float]:
    """Changes of [cloud], as dotted keys, that put about `factor` times as many points along a line, and by how much
    they do so. Raises CaseError for clouds that come from files."""
    changes: dict[str, Any] = {}
    shape = cloud.get("shape")
    reached = factor
    ends = 0 if cloud.get("at") == "cells" else 1
    counts = listed(cloud["points"]) if shape == "box" and "points" in cloud else []
    if shape == "box" and not counts and "size" in cloud and "spacing" in cloud:  # which have to divide each other
        spacing = quantities.in_unit(cloud["spacing"], "m")
        counts = [round(quantities.in_unit(length, "m") / spacing) + ends for length in listed(cloud["size"])]

    def more(count: int, ends: int) -> int:
        """Points along a line, of which `ends` more than intervals."""
        return max(round((count - ends) * factor), 1) + ends

    if can_be_divided_only(cloud):
        if factor != round(factor):
            raise CaseError(f"places of points that are listed can be divided in whole parts only, not in {factor:g}")
        for axis in "xyz":
            if axis in cloud:
                changes[f"cloud.{axis}"] = divided(listed(cloud[axis]), round(factor))
    elif counts:
        changes["cloud.points"] = [more(count, ends) for count in counts]
        before, after = max(zip(counts, changes["cloud.points"]))
        reached = (after - ends) / (before - ends)
    elif "rings" in cloud:
        changes["cloud.rings"] = more(cloud["rings"], 0)
        reached = changes["cloud.rings"] / cloud["rings"]
        if "levels" in cloud:
            changes["cloud.levels"] = more(cloud["levels"], 1)
    elif "spacing" in cloud:
        changes["cloud.spacing"] = scaled(cloud["spacing"], 1 / factor)
    else:
        raise CaseError(f"the points of a cloud with shape = \"{shape}\" cannot be refined here: "
                           "take a shape with 'spacing' or 'points', or compare clouds of your own by hand")
    if near := cloud.get("near"):
        changes["cloud.near"] = [{**one, "spacing": scaled(one["spacing"], 1 / factor)} for one in near]
    return changes, reached
