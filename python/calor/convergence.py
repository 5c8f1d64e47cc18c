"""What a sequence of values at ever finer spacings says about their limit.

Richardson's extrapolation with the observed order; the bar follows Roache's grid convergence index (J. Fluids Eng. 116
(1994) 405) in spirit: it covers what the limit would be with other orders that the values allow.
"""
from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LEAST_ORDER, MOST_ORDER = 0.7, 4.5  # of a sequence that counts as asymptotic
SMOOTH_ORDER = 2.0                  # of all three methods, where nothing is singular
LIKE = 0.6                          # difference of orders, from three and from the three before, that is none


@dataclass(frozen=True)
class Limit:
    """Of one sequence. `value` +- `bar`; `order`: observed, nan where none is; `reason`: why it is not asymptotic,
    empty where it is."""

    value: float
    bar: float
    order: float
    reason: str = ""

    @property
    def is_asymptotic(self) -> bool:
        return not self.reason


def observed_order(h: Sequence[float], f: Sequence[float]) -> float:
    """p of f = f* + c h^p through three values at falling h; nan where there is none between 0.05 and 8."""
    (h1, h2, h3), (f1, f2, f3) = h, f
    first, second = f1 - f2, f2 - f3
    if first == 0 or second == 0 or first * second < 0:
        return math.nan

    def excess(p: float) -> float:
        return float((h1**p - h2**p) / (h2**p - h3**p) - first / second)

    low, high = 0.05, 8.0
    if excess(low) > 0 or excess(high) < 0:
        return math.nan
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return (low + high) / 2


def extrapolated(h: Sequence[float], f: Sequence[float], p: float) -> float:
    """The limit of the last two values with order p."""
    return float(f[-1] + (f[-1] - f[-2]) / ((h[-2] / h[-1]) ** p - 1))


def limit(h: Sequence[float], f: Sequence[float], round_off: float, other: float = 0) -> Limit:
    """Of at least three values at falling spacings h. Changes up to `round_off` are none; `other`: error of every value
    that does not fall with h, such as that of time steps, which bars hold and in which changes are lost."""
    h, f = [s / h[-1] for s in h], list(f)
    changes = [abs(b - a) for a, b in zip(f, f[1:])]
    if max(changes[-2:]) <= max(round_off, 3 * other):
        return Limit(f[-1], max(changes[-2:]) + max(round_off, other), math.nan)
    p = observed_order(h[-3:], f[-3:])
    said = f"the last two refinements changed it by {changes[-2]:.2g} and {changes[-1]:.2g}"
    if math.isnan(p) or not LEAST_ORDER <= p <= MOST_ORDER:
        what = "it does not converge steadily" if math.isnan(p) else f"its order would be {p:.1f}"
        return Limit(f[-1], 3 * max(changes[-2:]), p, f"{said}: {what}")
    value = extrapolated(h, f, p)
    doubt, moved = 0.5, 0.0  # of the order, and of the limit since the spacing before
    if len(f) >= 4 and changes[-3] > max(round_off, 3 * other):
        before = observed_order(h[-4:-1], f[-4:-1])
        if math.isnan(before) or abs(before - p) > LIKE * max(1.0, p / SMOOTH_ORDER):
            order = "none" if math.isnan(before) else f"{before:.1f}"
            return Limit(f[-1], 3 * max(changes[-2:]), p, f"{said}: its order went from {order} to {p:.1f}")
        doubt = min(max(2 * abs(p - before), 0.05), 0.5)
        moved = abs(extrapolated(h[:-1], f[:-1], before) - value)
    others = [extrapolated(h, f, max(p - doubt, LEAST_ORDER / 2)), extrapolated(h, f, p + doubt)]
    return Limit(value, max(*(abs(one - value) for one in others), moved) + other, p)


def limit_of_random_points(h: Sequence[float], f: Sequence[float], round_off: float, other: float = 0) -> Limit:
    """The same where every spacing has points of its own at random: their scatter hides the order, and nothing is
    extrapolated. The bar holds the last changes, three where there are so many, as one or two may be small by chance; earlier
    ones as they would have become at first order. And it holds what is left to the limit where they fall steadily."""
    changes = [abs(b - a) for a, b in zip(f, f[1:])]
    bar = max(*(change * h[-1] / s for change, s in zip(changes[-3:], h[1:][-3:])), round_off)
    p = observed_order(h[-3:], f[-3:])
    if not math.isnan(p):
        bar = max(bar, 1.25 * abs(extrapolated(h, f, min(max(p, LEAST_ORDER), SMOOTH_ORDER)) - f[-1]))
    if changes[-1] > 1.5 * max(changes[-3:-1]) and changes[-1] > max(round_off, 3 * other):
        return Limit(f[-1], 3 * bar, math.nan, f"the last two refinements changed it by {changes[-2]:.2g} and {changes[-1]:.2g}: it does not converge")
    return Limit(f[-1], bar + other, math.nan)


@dataclass(frozen=True)
class Verdict:
    """Of one quantity by all methods. `value` +- `bar`, if `certified`; else `reason` says why not."""

    value: float
    bar: float
    certified: bool
    reason: str = ""


def independent(limits: Sequence[Limit]) -> list[Limit]:
    """Those that no other repeats: where two methods are the same scheme, as on lattices of several parts, their agreement says nothing."""
    kept: list[Limit] = []
    for one in limits:
        if not any(abs(one.value - other.value) <= 1e-3 * other.bar and abs(one.bar - other.bar) <= 1e-3 * other.bar for other in kept):
            kept.append(one)
    return kept


def together(limits: Sequence[Limit], are_extrapolated: bool = True) -> Verdict:
    """The limits of several methods as one. Where independent ones agree, their scatter says how good they
    are; where they do not, nothing is certified. The scatter is that about a weighted mean (Birge, Phys. Rev. 40 (1932)
    207), in which a limit with a wide bar weighs little. Values that are not extrapolated lie off to one side: of these
    the one that is furthest off counts, and all that the surest of them allows."""
    good = independent([one for one in limits if one.is_asymptotic])
    if not good:
        return Verdict(limits[0].value, math.nan, False, "not in the asymptotic range: " + limits[0].reason)
    weight = np.array([1 / one.bar**2 if one.bar > 0 else 1e300 for one in good])
    value = float(np.sum(weight * [one.value for one in good]) / np.sum(weight))
    for a in good:
        for b in good:
            if abs(a.value - b.value) > 1.5 * (a.bar + b.bar):
                return Verdict(value, math.nan, False, f"the methods' limits differ by {abs(a.value - b.value):.2g}, more than their bars")
    surest = min(good, key=lambda one: one.bar)
    off = np.array([one.value - value for one in good])
    if len(good) > 1 and are_extrapolated:
        bar = max(surest.bar, math.sqrt(float(np.sum(weight * off**2) / np.sum(weight)) / (len(good) - 1)))
    elif len(good) > 1:
        bar = max(surest.bar + abs(surest.value - value), float(np.max(np.abs(off))))
    else:  # one of random points may look asymptotic by chance: the others' values are at hand
        others = [abs(one.value - value) for one in limits if not one.is_asymptotic]
        bar = max(1.5 * surest.bar, min(others, default=0) / 2)
    return Verdict(value, bar, True)


def text(value: float, bar: float, unit: str = "") -> str:
    """ "1169.6 +- 0.2 K": no more digits than the bar allows, which has one, or two where it begins with 1."""
    if not bar > 0 or not math.isfinite(bar):
        return f"{value:.6g}{' ' + unit if unit else ''}"
    digits = -math.floor(math.log10(bar) + 1e-9)
    if bar * 10.0**digits < 2:
        digits += 1
    rounded = math.ceil(bar * 10.0**digits - 1e-9) / 10.0**digits
    places = max(digits, 0)
    number = f"{round(value, digits):.{places}f} ± {rounded:.{places}f}"
    if places > 12 or abs(value) >= 1e12:
        number = f"{value:.12g} ± {bar:.1e}"
    return f"{number} {unit}".strip()
