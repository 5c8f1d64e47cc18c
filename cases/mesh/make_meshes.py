#!/usr/bin/env python3
"""The meshes of this folder, written anew: ./make_meshes.py. Plain meshes of bent grids, displaced at random inside, as
a mesher would not make them worse.

    ring.msh            a ring of triangles, radii 0.4 and 1 (Gmsh 4.1)
    two-materials.msh   a ring of two materials that meet at r = 0.7 (Gmsh 2.2)
    corner.inp          an L of quadrilaterals, named by sets of nodes (Abaqus)
    box-with-hole.msh   a box 2 x 2 x 1 with a hole of radius 0.5, tetrahedra (Gmsh 4.1)
    tube.inp            a quarter of a hollow cylinder, radii 0.4 and 1, hexahedra with surfaces (Abaqus)
    sphere.vtu          a ball of radius 1, hexahedra (VTK)
"""
import itertools
import math
import pathlib
import random

HERE = pathlib.Path(__file__).resolve().parent


SIDES = {  # outwards, by the number of corners
    3: [(0, 1), (1, 2), (2, 0)],
    4: [(0, 1), (1, 2), (2, 3), (3, 0)],
    6: [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    8: [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]}


class Grid:
    """Nodes of a grid of cells mapped into space; nodes that coincide are one."""

    def __init__(self):
        self.nodes, self.index, self.cells, self.sides = [], {}, [], {}

    def node(self, x):
        key = tuple(round(c, 9) for c in x)
        if key not in self.index:
            self.index[key] = len(self.nodes)
            self.nodes.append(list(x) + [0.0] * (3 - len(x)))
        return self.index[key]

    def fill(self, counts, place, group="body"):
        """A block of cells; place(i, j(, k)) -> coordinates."""
        dimension = len(counts)
        for cell in itertools.product(*map(range, counts)):
            around = {c: self.node(place(*(a + b for a, b in zip(cell, c))))
                      for c in itertools.product((0, 1), repeat=dimension)}
            ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
            self.cells.append((group, [around[c + z] for z in ([()] if dimension == 2 else [(0,), (1,)]) for c in ring]))

    def surface(self):
        """Sides of one cell only, outwards."""
        sides = {}
        for _, c in self.cells:
            for side in SIDES[len(c)]:
                nodes = tuple(c[k] for k in side)
                sides.setdefault(tuple(sorted(nodes)), []).append(nodes)
        return [s[0] for s in sides.values() if len(s) == 1]

    def named_surface(self, name):
        """name(coordinates of the middle) -> name of a face; returns {name: sides}."""
        out = {}
        for side in self.surface():
            middle = [sum(self.nodes[n][a] for n in side) / len(side) for a in range(3)]
            out.setdefault(name(*middle), []).append(side)
        return out

    def shake(self, by, seed=1, keep=lambda x: False):
        """Displaces inner nodes at random."""
        rng = random.Random(seed)
        still = {n for side in self.surface() for n in side}
        plane = len(self.cells[0][1]) == 4
        for n, x in enumerate(self.nodes):
            if n not in still and not keep(x):
                for a in range(2 if plane else 3):
                    x[a] += by * rng.uniform(-1, 1)


def simplices(cell):
    """Cut at the smallest number, as neighbours agree."""
    top = min(cell)
    out = []
    for side in SIDES[len(cell)]:
        nodes = [cell[k] for k in side]
        if top not in nodes:
            out += [[top, *piece] for piece in (pieces(nodes) if len(nodes) == 4 else [nodes])]
    return out


def pieces(side):
    """Two triangles of a quadrilateral."""
    k = side.index(min(side))
    a, b, c, d = side[k:] + side[:k]
    return [[a, b, c], [a, c, d]]


def number(x):
    return f"{x:.10g}"


def write_gmsh(name, grid, faces, version):
    """Cells cut into simplices. One entity a group."""
    dimension = 2 if len(grid.cells[0][1]) == 4 else 3  # prisms and cubes
    blocks = []  # (dimension, group, type, elements)
    for f, (face, sides) in enumerate(faces.items()):
        cut = [p for s in sides for p in (pieces(list(s)) if len(s) == 4 else [s])]
        blocks.append((dimension - 1, f + 1, face, 1 if dimension == 2 else 2, cut))
    groups = list(dict.fromkeys(g for g, _ in grid.cells))
    for g, group in enumerate(groups):
        cut = [s for h, c in grid.cells if h == group for s in simplices(c)]
        blocks.append((dimension, g + 1, group, 2 if dimension == 2 else 4, cut))
    out = ["$MeshFormat", f"{version} 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(blocks))]
    out += [f'{d} {tag} "{group}"' for d, tag, group, _, _ in blocks]
    out += ["$EndPhysicalNames"]
    nodes = [" ".join(map(number, x)) for x in grid.nodes]
    count = len(nodes)
    elements = sum(len(b[4]) for b in blocks)
    if version == "2.2":
        out += ["$Nodes", str(count), *(f"{n + 1} {x}" for n, x in enumerate(nodes)), "$EndNodes"]
        out += ["$Elements", str(elements)]
        label = itertools.count(1)
        for _, tag, _, kind, cut in blocks:
            out += [f"{next(label)} {kind} 2 {tag} {tag} " + " ".join(str(n + 1) for n in e) for e in cut]
    else:
        box = "-1 -1 -1 1 1 1"
        by_dimension = [[b for b in blocks if b[0] == d] for d in range(4)]
        out += ["$Entities", " ".join(str(len(b)) for b in by_dimension)]
        out += [f"{tag} {box} 1 {tag} 0" for b in by_dimension for _, tag, *_ in b]
        out += ["$EndEntities", "$Nodes", f"1 {count} 1 {count}", f"{dimension} 1 0 {count}"]
        out += [str(n + 1) for n in range(count)] + nodes
        out += ["$EndNodes", "$Elements", f"{len(blocks)} {elements} 1 {elements}"]
        label = itertools.count(1)
        for d, tag, _, kind, cut in blocks:
            out += [f"{d} {tag} {kind} {len(cut)}"]
            out += [f"{next(label)} " + " ".join(str(n + 1) for n in e) for e in cut]
    out += ["$EndElements"]
    (HERE / name).write_text("\n".join(out) + "\n")


def write_abaqus(name, grid, kind, faces, as_nodes):
    """Faces as sets of nodes or as surfaces of elements."""
    out = ["*HEADING", f" {name}", "*NODE, NSET=Nall"]
    out += [f"{n + 1}, " + ", ".join(map(number, x)) for n, x in enumerate(grid.nodes)]
    out += [f"*ELEMENT, TYPE={kind}, ELSET=Eall"]
    out += [f"{e + 1}, " + ", ".join(str(n + 1) for n in c) for e, (_, c) in enumerate(grid.cells)]
    owner = {tuple(sorted(c[k] for k in side)): (e + 1, s + 1)
             for e, (_, c) in enumerate(grid.cells) for s, side in enumerate(SIDES[len(c)])}
    for face, members in faces.items():
        if as_nodes:
            labels = sorted({n + 1 for side in members for n in side})
            out += [f"*NSET, NSET={face}"]
            out += [", ".join(map(str, labels[k:k + 12])) + "," for k in range(0, len(labels), 12)]
        else:
            out += [f"*SURFACE, NAME={face}, TYPE=ELEMENT"]
            out += ["{}, S{}".format(*owner[tuple(sorted(side))]) for side in members]
    (HERE / name).write_text("\n".join(out) + "\n")


def write_vtu(name, grid):
    cells = [c for _, c in grid.cells]
    ends = itertools.accumulate(len(c) for c in cells)
    def array(kind, label, components, rows):
        return [f'<DataArray type="{kind}" {label}NumberOfComponents="{components}" format="ascii">', *rows, "</DataArray>"]
    out = ['<?xml version="1.0"?>', '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">',
           "<UnstructuredGrid>", f'<Piece NumberOfPoints="{len(grid.nodes)}" NumberOfCells="{len(cells)}">', "<Points>",
           *array("Float64", "", 3, [" ".join(map(number, x)) for x in grid.nodes]), "</Points>", "<Cells>",
           *array("Int64", 'Name="connectivity" ', 1, [" ".join(map(str, c)) for c in cells]),
           *array("Int64", 'Name="offsets" ', 1, [" ".join(map(str, ends))]),
           *array("UInt8", 'Name="types" ', 1, [" ".join("12" for _ in cells)]),
           "</Cells>", "</Piece>", "</UnstructuredGrid>", "</VTKFile>"]
    (HERE / name).write_text("\n".join(out) + "\n")


def polar(r, angle, *z):
    return (r * math.cos(angle), r * math.sin(angle), *z)


def square_with_hole(h):
    """Points and triangles (Delaunay's, by Bowyer and Watson) of the square from -1 to 1 with a hole of radius 0.5."""
    rng, sides, around = random.Random(2), round(2 / h), round(math.pi / h)
    points = [polar(0.5, 2 * math.pi * k / around) for k in range(around)]
    for k in range(sides):
        points += [(h * k - 1, -1), (1, h * k - 1), (1 - h * k, 1), (-1, 1 - h * k)]
    for i, j in itertools.product(range(1, sides), repeat=2):
        x, y = h * i - 1 + 0.1 * h * rng.uniform(-1, 1), h * j - 1 + 0.1 * h * rng.uniform(-1, 1)
        if math.hypot(x, y) > 0.5 + 0.6 * h:
            points.append((x, y))
    count = len(points)
    points = points + [(-1e3, -1e3), (1e3, -1e3), (0, 1e3)]

    def area(a, b, c):
        return (points[b][0] - points[a][0]) * (points[c][1] - points[a][1]) - \
               (points[c][0] - points[a][0]) * (points[b][1] - points[a][1])

    def holds(triangle, p):
        rows = [(points[t][0] - points[p][0], points[t][1] - points[p][1]) for t in triangle]
        (ax, ay), (bx, by), (cx, cy) = rows
        a, b, c = (x * x + y * y for x, y in rows)
        return a * (bx * cy - by * cx) - b * (ax * cy - ay * cx) + c * (ax * by - ay * bx) > 1e-12

    triangles = {(count, count + 1, count + 2)}
    for p in range(count):
        bad = [t for t in triangles if holds(t, p)]
        edges = [e for t in bad for e in zip(t, t[1:] + t[:1])]
        triangles -= set(bad)
        triangles |= {(a, b, p) for a, b in edges if (b, a) not in edges}

    def inside(t):
        middle = [sum(points[n][a] for n in t) / 3 for a in (0, 1)]
        return max(t) < count and math.hypot(*middle) > 0.5 * math.cos(math.pi / around) and area(*t) > 1e-6

    return points[:count], sorted(filter(inside, triangles))


def ring(radial, around, split=None):
    grid = Grid()
    grid.fill((radial, around),
              lambda i, j: polar(0.4 + 0.6 * i / radial, 2 * math.pi * ((j % around) + 0.5 * (i % 2)) / around),
              )
    if split:
        grid.cells = [("core" if sum(math.hypot(*grid.nodes[n][:2]) for n in c) / 4 < split else "shell", c)
                      for _, c in grid.cells]
    return grid


def round_faces(x, y, z):
    return "inner" if math.hypot(x, y) < 0.7 else "outer"


def main():
    grid = ring(8, 56)
    grid.shake(0.012)
    write_gmsh("ring.msh", grid, grid.named_surface(round_faces), "4.1")

    grid = ring(8, 56, split=0.7)
    grid.shake(0.012, keep=lambda x: abs(math.hypot(x[0], x[1]) - 0.7) < 1e-6)
    write_gmsh("two-materials.msh", grid, grid.named_surface(round_faces), "2.2")

    grid, n = Grid(), 10
    for low in ((-1, -1), (-1, 0), (0, 0)):
        grid.fill((n, n), lambda i, j: (low[0] + i / n, low[1] + j / n))
    grid.shake(0.015)
    corner = lambda x, y, z: ("notch_x" if abs(x) < 1e-9 and y < 0 else "notch_y" if abs(y) < 1e-9 and x > 0
                              else "outside")
    write_abaqus("corner.inp", grid, "CPS4", grid.named_surface(corner), True)

    grid, layers = Grid(), 6
    plane, triangles = square_with_hole(h=1 / 6)
    for k in range(layers):
        for t in triangles:
            grid.cells.append(("body", [grid.node((*plane[p], (k + up) / layers)) for up in (0, 1) for p in t]))
    grid.shake(0.02)
    write_gmsh("box-with-hole.msh", grid, grid.named_surface(
        lambda x, y, z: "ends" if min(z, 1 - z) < 1e-6 else "hole" if math.hypot(x, y) < 0.6 else "outside"), "4.1")

    grid = Grid()
    grid.fill((6, 9, 3), lambda i, j, k: polar(0.4 + 0.1 * i, math.pi / 18 * j, 0.1 * k))
    write_abaqus("tube.inp", grid, "C3D8", grid.named_surface(
        lambda x, y, z: "ends" if min(z, 0.3 - z) < 1e-6 else "cut" if min(x, y) < 1e-6 else round_faces(x, y, z)), False)

    grid, n = Grid(), 9  # cubes blown up to shells
    def ball(*index):
        x = [math.tan(math.pi / 4 * (2 * i / n - 1)) for i in index]
        shell, length = max(abs(2 * i / n - 1) for i in index), math.hypot(*x)
        return tuple(shell * c / length for c in x)
    grid.fill((n, n, n), ball)
    write_vtu("sphere.vtu", grid)


if __name__ == "__main__":
    main()
