"""Which of several numbers a result varies by: Sobol's indices, by a polynomial chaos expansion through the samples of a study.

Sudret, Reliab. Eng. Syst. Saf. 93 (2008) 964. OpenTURNS (python3-openturns) does the work."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import quantities
from .command import CaseError

if TYPE_CHECKING:
    from .study import Study

TRUSTED = 0.95  # of the variance of left-out runs that the expansion must foretell


@dataclass
class Indices:
    """Of one quantity. `first`: part of its variance by one number alone, `total`: with what it does together with others, by key.
    `foretold`: part of the variance of runs that the expansion through the others foretells."""

    quantity: str
    first: dict[str, float]
    total: dict[str, float]
    foretold: float


def expand(x: Any, y: Any, limits: Sequence[tuple[float, float]]) -> tuple[list[float], list[float], float]:
    """First and total indices of y over x, uniform between limits, and what of the variance the expansion foretells, by
    cross-validation in ten parts."""
    import openturns as ot
    ot.Log.Show(ot.Log.NONE)
    distribution = ot.ComposedDistribution([ot.Uniform(low, high) for low, high in limits])

    def fitted(x: Any, y: Any) -> Any:
        basis = ot.OrthogonalProductPolynomialFactory([ot.LegendreFactory()] * len(limits))
        # As many terms as a third of the runs, the most important of them by least angles.
        terms = ot.FixedStrategy(basis, max(len(limits) + 1, len(x) // 3))
        algorithm = ot.FunctionalChaosAlgorithm(ot.Sample(x), ot.Sample(y[:, None]), distribution, terms)
        algorithm.run()
        return algorithm.getResult()

    wrong = np.zeros(len(y))
    for part in np.array_split(np.random.default_rng(0).permutation(len(y)), 10):
        rest = np.setdiff1d(np.arange(len(y)), part)
        wrong[part] = y[part] - np.array(fitted(x[rest], y[rest]).getMetaModel()(ot.Sample(x[part])))[:, 0]
    result = ot.FunctionalChaosSobolIndices(fitted(x, y))
    d = range(len(limits))
    return ([result.getSobolIndex(n) for n in d], [result.getSobolTotalIndex(n) for n in d], float(1 - np.sum(wrong**2) / np.sum((y - y.mean()) ** 2)))


def sobol(study: Study, ranges: Mapping[str, Any]) -> list[Indices]:
    """Of all quantities of a study of `ranges` alone that vary. Raises CaseError where it has too few runs."""
    rows = [row for row in study.rows if "failed" not in row]
    keys = list(ranges)
    if not keys or set(study.keys) != set(keys):
        raise CaseError("Sobol's indices take samples of [study.range] alone, without [study.values]")
    if len(rows) < 10 * len(keys):
        raise CaseError(f"Sobol's indices by {len(rows)} runs of {len(keys)} numbers: take [study] samples = {10 * len(keys)} or more")
    units = {key: quantities.split(ranges[key][0])[1] for key in keys}
    limits = [(quantities.in_unit(ranges[key][0], units[key]), quantities.in_unit(ranges[key][1], units[key])) for key in keys]
    x = np.array([[quantities.in_unit(row[key], units[key]) for key in keys] for row in rows])
    found = []
    for name in study.quantities:
        y = np.array([row.get(name, np.nan) for row in rows], float)
        if not np.all(np.isfinite(y)) or np.ptp(y) <= 1e-9 * max(1e-300, np.max(np.abs(y))):
            continue
        first, total, foretold = expand(x, y, limits)
        found.append(Indices(name, dict(zip(keys, first)), dict(zip(keys, total)), foretold))
    return found


def table(found: Sequence[Indices]) -> str:
    """For people."""
    lines = ["quantity: key first order / total, of its variance"]
    for one in found:
        lines.append(one.quantity + ("" if one.foretold >= TRUSTED else f"  (not to be trusted: the expansion foretells {100 * max(0, one.foretold):.0f} % of other runs: take more samples)"))
        lines += [f"  {key:<40} {one.first[key]:6.3f} / {one.total[key]:6.3f}" for key in sorted(one.total, key=lambda key: -one.total[key])]
    return "\n".join(lines)


__all__ = ["Indices", "sobol", "table"]
