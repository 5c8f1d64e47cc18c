"""Fields that are searched for: a property at all nodes of a grid, and how smooth it is expected to be."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import quantities
from .command import CaseError
from .result import Array
from .toml import listed
from .unknowns import Unknown


@dataclass
class Field:
    """The values of a grid as unknowns. What is expected of them before any measurement is a Gaussian field: a mean, a
    standard deviation, and correlations after Matern (nu = 3/2) that fall over a length."""

    key: str
    unit: str
    unknowns: list[Unknown]
    mean: float
    within: float
    whitening: Array  # W with W^T W the inverse of the covariance: W (values - mean) are independent numbers of size 1


def matern(distance: Array, length: float) -> Array:
    s = np.sqrt(3) * distance / length
    correlation: Array = (1 + s) * np.exp(-s)
    return correlation


def read_field(case: Mapping[str, Any], entry: Mapping[str, Any], where: str) -> Field:
    """One [[fit.field]] at a place "case.toml:12". Raises CaseError with place and cure."""
    key = entry["key"]
    try:
        grid = quantities.at(case, key)
        if not key.endswith(".grid"):
            raise CaseError(f"'{key}' is no grid: name one as in material.plate.conductivity.grid")
        function = quantities.at(case, key.removesuffix(".grid"))
        values = np.array(grid, float)
        unit = function.get("unit", "")
        along = listed(function["along"])
        axes = [np.linspace(quantities.in_unit(first, "m"), quantities.in_unit(last, "m"), nodes)
                for first, last, nodes in zip(listed(function["from"]), listed(function["to"]), values.shape)]
        if values.ndim != len(along):
            raise CaseError(f"the grid is {values.ndim} lists deep, and 'along' names {len(along)} axes: write as many")

        def number_of(name: str, default: float) -> float:
            return quantities.in_unit(entry[name], unit, difference=name == "within") if name in entry else default

        mean, within, length = number_of("expected", np.nan), number_of("within", np.nan), quantities.in_unit(entry["length"], "m")
        low, high = number_of("from", -np.inf), number_of("to", np.inf)
        if not within > 0 or not length > 0:
            raise CaseError("'within' and 'length' of a field must be positive: give what is known about it")
        if not np.all((values >= low) & (values <= high) & (values != 0)):
            raise CaseError(f"the grid has values outside of {low:g} to {high:g}, or of 0: the search begins with them, correct them")
    except (ValueError, TypeError, KeyError, AttributeError):
        raise CaseError(f"{where}: '{key}' is no grid of numbers with along, from, to: write grid = [[1, 2], [3, 4]]",
                        where.split(":")[0], None, None, key) from None
    except CaseError as error:
        raise CaseError(f"{where}: {error}", where.split(":")[0], None, None, key) from None
    unknowns = [Unknown(key + "".join(f"[{n}]" for n in node), "", float(values[node]), low, high) for node in np.ndindex(values.shape)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(values.size, -1)
    distance = np.linalg.norm(places[:, None] - places[None], axis=-1)
    # A little of each value's own keeps the matrix regular where the length is many spacings.
    covariance = within**2 * (matern(distance, length) + 1e-8 * np.eye(values.size))
    return Field(key, unit, unknowns, mean, within, np.linalg.inv(np.linalg.cholesky(covariance)))
