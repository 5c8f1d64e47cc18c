"""The same case with finer or coarser points."""
from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from .command import CaseError
from .quantities import to_si


def scaled(quantity: str, factor: float) -> str:
    """ "0.25 mm" of "0.5 mm" and 0.5."""
    number = re.match(r"\s*([-+]?[0-9.]+(?:[eE][-+]?\d+)?)(.*)", quantity, re.DOTALL)
    if not number:
        raise CaseError(f"'{quantity}' is no length that can be scaled: write a number and a unit")
    return f"{float(number[1]) * factor:.12g}{number[2]}"


def divided(places: Sequence[str], parts: int) -> list[str]:
    """Every interval between places, such as "2 mm", in so many equal parts. All have to have one unit."""
    units = {re.sub(r"^\s*[-+0-9.eE]+", "", place).strip() for place in places}
    if len(units) != 1:
        raise CaseError(f"places in several units ({', '.join(sorted(units))}) cannot be divided: take one unit")
    unit = units.pop()
    at = [float(re.match(r"\s*[-+0-9.eE]+", place)[0]) for place in places]  # type: ignore[index]
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
    counts = cloud.get("points")
    if shape == "box" and not counts and "size" in cloud and "spacing" in cloud:  # which have to divide each other
        spacing = to_si(cloud["spacing"], "m")
        counts = [round(to_si(length, "m") / spacing) + ends for length in ([cloud["size"]] if isinstance(cloud["size"], str) else cloud["size"])]

    def more(count: int, ends: int) -> int:
        """Points along a line, of which `ends` more than intervals."""
        return max(round((count - ends) * factor), 1) + ends

    if can_be_divided_only(cloud):
        if factor != round(factor):
            raise CaseError(f"places of points that are listed can be divided in whole parts only, not in {factor:g}")
        for axis in "xyz":
            if axis in cloud:
                changes[f"cloud.{axis}"] = divided(cloud[axis], round(factor))
    elif shape == "box" and counts:
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
