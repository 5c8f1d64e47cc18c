#!/usr/bin/env python3
"""Writes blade.stl: a piece of a turbine blade without its cooling holes, in millimetres; skin, root and tip are solids.

The section is of the four-digit family of NACA (Report 460, 1933): a mean line of two parabolas and a thickness law
across it, here with 18 % camber, 20 % thickness and a round trailing edge.
"""
import math
import pathlib

CHORD, SPAN = 40.0, 3.0
CAMBER, CAMBER_AT, THICKNESS = 0.18, 0.42, 0.20  # of the chord
TRAILING_RADIUS = 0.9
STATIONS, PIECES = 48, 8  # along the chord, around the trailing edge


def mean_line(s):
    """Height and slope at a share s of the chord."""
    side = CAMBER_AT if s < CAMBER_AT else 1 - CAMBER_AT
    height = CAMBER - CAMBER * ((s - CAMBER_AT) / side) ** 2
    return height, -2 * CAMBER * (s - CAMBER_AT) / side**2


def half_thickness(s):
    naca = 5 * THICKNESS * (0.2969 * math.sqrt(s) - 0.1260 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1036 * s**4)
    return CHORD * naca + TRAILING_RADIUS * s


def place(s, across):
    """Off the mean line by `across`, upwards where it is positive."""
    height, slope = mean_line(s)
    length = math.hypot(1, slope)
    return CHORD * s - across * slope / length, CHORD * height + across / length


def outline():
    """The suction side from nose to tail, and the pressure side in the same steps."""
    steps = [0.5 * (1 - math.cos(math.pi * n / STATIONS)) for n in range(STATIONS + 1)]
    upper = [place(s, half_thickness(s)) for s in steps]
    lower = [place(s, -half_thickness(s)) for s in steps]
    x, y = place(1, 0)
    along = math.atan(mean_line(1)[1])
    for n in range(1, PIECES + 1):
        angle = math.pi / 2 * (1 - n / PIECES)
        for side, sign in ((upper, 1), (lower, -1)):
            turned = along + sign * angle
            side.append((x + TRAILING_RADIUS * math.cos(turned), y + TRAILING_RADIUS * math.sin(turned)))
    return upper, lower


def quad(a, b, c, d):
    return [(a, b, c), (a, c, d)]


def faces():
    upper, lower = outline()
    around = [*upper, *lower[-2:0:-1]]
    pairs = list(zip(around, [*around[1:], around[0]]))
    yield "skin", [t for a, b in pairs for t in quad((*a, 0), (*a, SPAN), (*b, SPAN), (*b, 0))]
    for name, z in (("root", 0), ("tip", SPAN)):
        strip = zip(upper, upper[1:], lower[1:], lower)
        yield name, [t for corners in strip for t in quad(*((*corner, z) for corner in corners)) if len(set(t)) == 3]


def main():
    lines = []
    for name, triangles in faces():
        lines.append(f"solid {name}")
        for triangle in triangles:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex " + " ".join(f"{c:.6f}" for c in corner) for corner in triangle]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid {name}")
    pathlib.Path(__file__).with_name("blade.stl").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
