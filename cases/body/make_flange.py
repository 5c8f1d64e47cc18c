#!/usr/bin/env python3
"""Writes flange.stl: a ring of 10 and 30 mm radius, 8 mm high, in millimetres; every face is a solid of its own."""
import math
import pathlib

INNER, OUTER, HEIGHT, PIECES = 10.0, 30.0, 8.0, 96


def at(radius, piece, z):
    angle = 2 * math.pi * (piece % PIECES) / PIECES
    return radius * math.cos(angle), radius * math.sin(angle), z


def quad(a, b, c, d):
    return [(a, b, c), (a, c, d)]


def faces():
    around = range(PIECES)
    yield "bore", [t for n in around for t in quad(at(INNER, n, 0), at(INNER, n, HEIGHT), at(INNER, n + 1, HEIGHT), at(INNER, n + 1, 0))]
    yield "rim", [t for n in around for t in quad(at(OUTER, n, 0), at(OUTER, n + 1, 0), at(OUTER, n + 1, HEIGHT), at(OUTER, n, HEIGHT))]
    yield "bottom", [t for n in around for t in quad(at(INNER, n, 0), at(INNER, n + 1, 0), at(OUTER, n + 1, 0), at(OUTER, n, 0))]
    yield "top", [t for n in around for t in quad(at(INNER, n, HEIGHT), at(OUTER, n, HEIGHT), at(OUTER, n + 1, HEIGHT), at(INNER, n + 1, HEIGHT))]


def main():
    lines = []
    for name, triangles in faces():
        lines.append(f"solid {name}")
        for triangle in triangles:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex " + " ".join(f"{c:.6f}" for c in corner) for corner in triangle]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid {name}")
    pathlib.Path(__file__).with_name("flange.stl").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
