#!/usr/bin/env python3
"""Writes points.csv: points on circles of a ring of 0.4 and 1 m radius, those inside displaced, in metres."""
import math
import pathlib

INNER, OUTER, SPACING = 0.4, 1.0, 0.06


def main():
    lines = ["x [m],y [m]"]
    circles = round((OUTER - INNER) / SPACING)
    for n in range(circles + 1):
        radius = INNER + n * (OUTER - INNER) / circles
        count = round(2 * math.pi * radius / SPACING)
        inside = 0 < n < circles
        for k in range(count):
            angle = 2 * math.pi * (k + 0.5 * (n % 2)) / count
            off = 0.2 * SPACING * math.sin(12.9898 * (97 * n + k)) if inside else 0
            lines.append(f"{(radius + off) * math.cos(angle):.12f},{(radius + off) * math.sin(angle):.12f}")
    pathlib.Path(__file__).with_name("points.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
