#!/usr/bin/python3
"""with_calculix.py PROBLEM CELLS STEPS: finite elements of first order on hexahedra, backward Euler, by the command ccx.

Prints its CPU seconds and the error."""
from __future__ import annotations

import json
import pathlib
import resource
import subprocess
import sys
import tempfile
from math import erf, sqrt
from typing import TextIO

import numpy as np
import problems

Array = np.ndarray


class Bricks:
    """A lattice of hexahedra in a box; nodes and elements are numbered from 1, x fastest."""

    def __init__(self, size: tuple[float, ...], cells: tuple[int, ...]) -> None:
        self.size, self.cells = size, cells
        planes = [np.linspace(0, length, n + 1) for length, n in zip(size, cells)]
        z, y, x = np.meshgrid(*planes[::-1], indexing="ij")
        self.x = np.column_stack([x.ravel(), y.ravel(), z.ravel()])

    def node(self, i: Array, j: Array, k: Array) -> Array:
        nx, ny, _ = self.cells
        return 1 + i + (nx + 1) * (j + (ny + 1) * k)

    def element(self, i: int | Array, j: int | Array, k: int | Array) -> int | Array:
        nx, ny, _ = self.cells
        return 1 + i + nx * (j + ny * k)

    def write(self, deck: TextIO) -> None:
        deck.write("*NODE, NSET=ALL\n")
        np.savetxt(deck, np.column_stack([np.arange(1, len(self.x) + 1), self.x]), fmt="%d,%.12g,%.12g,%.12g")
        k, j, i = (index.ravel() for index in np.meshgrid(*(np.arange(n) for n in self.cells[::-1]), indexing="ij"))
        corners = [self.node(i + a, j + b, k + c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        deck.write("*ELEMENT, TYPE=C3D8, ELSET=BODY\n")
        np.savetxt(deck, np.column_stack([np.arange(1, i.size + 1), *corners]), fmt="%d", delimiter=",")


def material(deck: TextIO, k: str, start: float, rho: float = 1, c: float = 1) -> None:
    deck.write(f"*MATERIAL, NAME=M\n*CONDUCTIVITY\n{k}\n*DENSITY\n{rho}\n*SPECIFIC HEAT\n{c}\n*SOLID SECTION, ELSET=BODY, MATERIAL=M\n"
               f"*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL,{start}\n")


def step(deck: TextIO, end: float, steps: int) -> None:
    deck.write(f"*STEP, INC=100000\n*HEAT TRANSFER, DIRECT, SOLVER=ITERATIVE CHOLESKY\n{end / steps:.12g},{end}\n")


def finish(deck: TextIO) -> None:
    deck.write("*NODE FILE, FREQUENCY=999999\nNT\n*END STEP\n")


def cooling_square(deck: TextIO, cells: int, steps: int) -> Bricks:
    p = problems.SQUARE
    bricks = Bricks((p["side"], p["side"], p["side"] / cells), (cells, cells, 1))
    bricks.write(deck)
    edge = np.arange(cells)
    for name, elements in (("EX", bricks.element(cells - 1, edge, 0)), ("EY", bricks.element(edge, cells - 1, 0))):
        deck.write(f"*ELSET, ELSET={name}\n" + "".join(f"{e},\n" for e in elements))
    material(deck, str(p["k"]), p["start"], p["rho_c"])
    step(deck, p["end"], steps)
    deck.write(f"*FILM\nEX,F4,0.,{p['h']}\nEY,F5,0.,{p['h']}\n")
    finish(deck)
    return bricks


def weld(deck: TextIO, cells: int, steps: int) -> Bricks:
    """`cells`: through the thickness. The heat of every element is the mean of the Gaussian over it, by error functions; along the
    path an amplitude of 41 moments an element."""
    p = problems.WELD
    counts = tuple(round(size / p["size"][2] * cells) for size in p["size"])
    bricks = Bricks(p["size"], counts)
    bricks.write(deck)
    sigma = p["sigma"]
    dx, dy, dz = (size / n for size, n in zip(p["size"], counts))

    def below(d: float) -> float:
        return 0.5 * (1 + erf(d / sigma / sqrt(2)))

    material(deck, str(p["k"]), 0, p["rho"], p["c"])
    columns = [i for i in range(counts[0]) if p["from"] - 5 * sigma < (i + 0.5) * dx < p["from"] + p["speed"] * p["end"] + 5 * sigma]
    for i in columns:
        passes = ((i + 0.5) * dx - p["from"]) / p["speed"]
        moments = np.unique(np.clip(np.linspace(passes - 5 * sigma / p["speed"], passes + 5 * sigma / p["speed"], 41), 0, p["end"] + 1))
        rows = [(t, (below((i + 1) * dx - p["from"] - p["speed"] * t) - below(i * dx - p["from"] - p["speed"] * t)) / dx) for t in moments]
        before = [(0.0, 0.0), (moments[0] - 1e-6, 0.0)] if moments[0] > 0 else []
        deck.write(f"*AMPLITUDE, NAME=A{i}\n" + "".join(f"{t:.9g},{value:.9g}\n" for t, value in before + rows))
    step(deck, p["end"], steps)
    top = p["size"][2]
    across = [(below((j + 1) * dy) - below(j * dy)) / dy for j in range(counts[1]) if j * dy < 5 * sigma]
    # Above the top and below the bottom the Gaussian is folded back.
    deep = [2 * sum(below(up) - below(low) for up, low in ((top - k * dz, top - (k + 1) * dz), (top + (k + 1) * dz, top + k * dz))) / dz
            for k in range(counts[2])]
    for i in columns:
        deck.write(f"*DFLUX, AMPLITUDE=A{i}\n")
        for j, y in enumerate(across):
            for k, z in enumerate(deep):
                deck.write(f"{bricks.element(i, j, k)},BF,{p['power'] * y * z:.9g}\n")
    finish(deck)
    return bricks


def read(frd: pathlib.Path, count: int) -> Array:
    """The last temperatures of a result file."""
    T, inside = np.full(count, np.nan), False
    with frd.open() as file:
        for line in file:
            if line.startswith(" -4  NDTEMP"):
                inside = True
            elif inside and line.startswith(" -3"):
                inside = False
            elif inside and line.startswith(" -1"):
                T[int(line[3:13]) - 1] = float(line[13:25])
    return T


DECKS = {"cooling-square": cooling_square, "weld": weld}
with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "job.inp"
    with path.open("w") as file:
        body = DECKS[sys.argv[1]](file, int(sys.argv[2]), int(sys.argv[3]))
    begin = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(["ccx", "-i", "job"], cwd=folder, stdout=subprocess.DEVNULL, check=True, env={"OMP_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"})
    used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - begin
    found = read(path.with_suffix(".frd"), len(body.x))
print(json.dumps({"cpu": used, "points": len(found), "error": problems.rms_error(sys.argv[1], body.x, found)}))
