"""Small cases in a frame of their own, written for any scale and any pose of that frame.

A length l of a case stands for l * scale metres and a time t for t * scale seconds. Conductivities grow with the scale;
heat capacities, heat transfer coefficients, fluxes and emissivities stay. So do all temperatures.
"""
import itertools
import random
from dataclasses import dataclass, field

SPAN = "300 K"


@dataclass
class Pose:
    """Where the axes of the case point, and from where."""
    name: str
    scale: float = 1.0
    axes: tuple = (0, 1, 2)      # axis of the world along which the case's axis points
    signs: tuple = (1, 1, 1)     # ... and in which direction
    shift: float = 0.0           # m, along every axis
    length: str = "m"            # unit of the lengths in the file
    kelvin: bool = True          # unit of the temperatures in the file

    def point(self, p):
        """Place in the world, m."""
        out = [0.0] * len(p)
        for a, v in enumerate(p):
            out[self.axes[a]] = self.signs[a] * v * self.scale + self.shift
        return out


@dataclass
class Writer:
    """What a case needs to write itself in a pose."""
    pose: Pose
    dimension: int
    files: dict = field(default_factory=dict)

    def length(self, metres):
        factor = {"m": 1, "mm": 1e3}[self.pose.length]
        return f'"{metres * factor!r} {self.pose.length}"'

    def l(self, v):
        return self.length(v * self.pose.scale)

    def place(self, p):
        return "[" + ", ".join(self.length(v) for v in self.pose.point(p)) + "]"

    def temperature(self, kelvin):
        return f'"{kelvin!r} K"' if self.pose.kelvin else f'"{kelvin - 273.15!r} degC"'

    def time(self, t):
        return f'"{t * self.pose.scale!r} s"'

    def conductivity(self, k):
        return f'"{k * self.pose.scale!r} W/(m K)"'

    def face(self, name):
        a = "xyz".index(name[0])
        high = (name[1:] == "max") == (self.pose.signs[a] > 0)
        return "xyz"[self.pose.axes[a]] + ("max" if high else "min")

    def formula(self, text):
        """X, Y, Z and TIME of the case, in SI units of the world."""
        s = self.pose.scale
        for a in range(self.dimension):
            world = "xyz"[self.pose.axes[a]]
            text = text.replace("XYZ"[a], f"({self.pose.signs[a]}*({world}-({self.pose.shift!r}))/{s!r})")
        return text.replace("TIME", f"(t/{s!r})")

    def per_axis(self, values):
        out = [None] * self.dimension
        for a, v in enumerate(values):
            out[self.pose.axes[a]] = v
        return out

    def box(self, size, points, at="walls", more=""):
        low = self.pose.point([0] * self.dimension)
        high = self.pose.point(size)
        origin = "[" + ", ".join(self.length(min(l, h)) for l, h in zip(low, high)) + "]"
        sizes = "[" + ", ".join(self.l(v) for v in self.per_axis(size)) + "]"
        return (f'[cloud]\nshape = "box"\nsize = {sizes}\npoints = {self.per_axis(points)}\norigin = {origin}\n'
                f'at = "{at}"\n{self.extent()}{more}\n')

    def extent(self):
        s = self.pose.scale
        return {1: f'section = "{s * s!r} m^2"\n', 2: f"thickness = {self.l(1)}\n", 3: ""}[self.dimension]

    def jittered(self, n, seed=3):
        """The unit square of n x n points, inner ones displaced at random, as a file; volumes by quadrilaterals."""
        rng = random.Random(seed)
        d = 1 / (n - 1)
        x = {(i, j): [i * d, j * d] for i in range(n) for j in range(n)}
        for (i, j), p in x.items():
            if 0 < i < n - 1 and 0 < j < n - 1:
                p[0] += 0.2 * d * rng.uniform(-1, 1)
                p[1] += 0.2 * d * rng.uniform(-1, 1)
        volume = dict.fromkeys(x, 0.0)
        for i, j in itertools.product(range(n - 1), repeat=2):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            c = [x[k] for k in corners]
            area = 0.5 * ((c[2][0] - c[0][0]) * (c[3][1] - c[1][1]) - (c[3][0] - c[1][0]) * (c[2][1] - c[0][1]))
            for k in corners:
                volume[k] += area / 4
        s = self.pose.scale
        rows = ["x [m],y [m],volume [m^3],area_x [m^2],area_y [m^2],face,area2_x [m^2],area2_y [m^2],face2"]
        for (i, j), p in x.items():
            pieces = []
            for a, k in enumerate((i, j)):
                if k in (0, n - 1):
                    other = (i, j)[1 - a]
                    area = [0.0, 0.0]
                    width = d if 0 < other < n - 1 else d / 2
                    area[self.pose.axes[a]] = (1 if k else -1) * self.pose.signs[a] * width * s * s
                    pieces += [*map(repr, area), self.face("xy"[a] + ("max" if k else "min"))]
            pieces += [""] * (6 - len(pieces))
            world = self.pose.point(p)
            rows.append(",".join([repr(world[0]), repr(world[1]), repr(volume[i, j] * s ** 3), *pieces]))
        self.files["cloud.csv"] = "\n".join(rows) + "\n"
        return f'[cloud]\nshape = "csv"\nfile = "cloud.csv"\n{self.extent()}\n'

    def material(self, k=40.0, name="m", more="", k_of_T=None):
        conductivity = self.conductivity(k)
        if k_of_T:
            conductivity = f'{{ formula = "{self.pose.scale!r}*({k_of_T})", unit = "W/(m K)" }}'
        return (f'[material.{name}]\nconductivity = {conductivity}\ndensity = "8000 kg/m^3"\n'
                f'specific_heat = "500 J/(kg K)"\n{more}\n')

    def initial(self, kelvin=300.0):
        return f"[initial]\ntemperature = {self.temperature(kelvin)}\n"

    def hold(self, face, kelvin):
        return f'[boundary.hold_{face}]\non = "{self.face(face)}"\ntemperature = {self.temperature(kelvin)}\n'

    def hold_by(self, face, formula):
        return (f'[boundary.hold_{face}]\non = "{self.face(face)}"\n'
                f'temperature = {{ formula = "{self.formula(formula)}", unit = "K" }}\n')

    def convection(self, face, h, ambient):
        return (f'[boundary.convection_{face}]\non = "{self.face(face)}"\n'
                f'convection = {{ h = "{h!r} W/(m^2 K)", ambient = {self.temperature(ambient)} }}\n')

    def radiation(self, face, ambient):
        return (f'[boundary.radiation_{face}]\non = "{self.face(face)}"\n'
                f'radiation = {{ emissivity = 0.8, ambient = {self.temperature(ambient)} }}\n')

    def flux(self, face, value):
        return f'[boundary.flux_{face}]\non = "{self.face(face)}"\nflux = "{value!r} W/m^2"\n'

    def march(self, end, integrator="automatic", step=None, **more):
        text = f'[time]\nend = {self.time(end)}\nintegrator = "{integrator}"\n'
        return text + (f"step = {self.time(step)}\n" if step else "")

    def probes(self, *places):
        return "[probe]\n" + "".join(f"p{n} = {self.place(p)}\n" for n, p in enumerate(places))


# Every kind: dimension, methods, writer. Lengths around 1, spacings around 0.1, k / (rho c) = 1e-5.
SPH, PD, MLPG = "sph", "peridynamics", "mlpg"
ALL = (SPH, PD, MLPG)
KINDS = {}


def kind(name, dimension, methods=ALL, posable=True):
    def add(write):
        KINDS[name] = (dimension, methods, posable, write)
        return write
    return add


P2 = ([0.31, 0.42], [0.83, 0.17])
P3 = ([0.31, 0.42, 0.27], [0.83, 0.17, 0.61])


@kind("line, walls", 1)
def _(w):
    return (w.box([1], [11]) + w.material() + w.initial() + w.hold("xmin", 350.0) + w.convection("xmax", 50.0, 280.0)
            + w.march(1e4) + w.probes([0.23], [0.9]))


@kind("line, cells, radiation", 1, (SPH, PD))
def _(w):
    return (w.box([1], [12], at="cells") + w.material() + w.initial(600.0) + w.radiation("xmin", 900.0)
            + w.convection("xmax", 50.0, 280.0) + w.march(1e4) + w.probes([0.23], [0.9]))


@kind("square, steady", 2)
def _(w):
    return (w.box([1, 1], [9, 9]) + w.material() + w.hold("xmin", 300.0) + w.hold("xmax", 400.0) + "[steady]\n"
            + w.probes(*P2))


@kind("square, steady, flux and convection", 2)
def _(w):
    return (w.box([1, 0.8], [11, 9]) + w.material() + w.flux("ymax", 2e3) + w.convection("xmin", 50.0, 280.0)
            + w.hold_by("xmax", "300+50*Y") + "[steady]\n" + w.probes([0.31, 0.42], [0.83, 0.17]))


@kind("square, cells, k(T)", 2, (SPH, PD))
def _(w):
    return (w.box([1, 1], [10, 10], at="cells") + w.material(k_of_T="40-0.02*(T-300)") + w.initial()
            + w.hold("xmin", 500.0) + w.radiation("ymax", 700.0) + w.march(1e4) + w.probes(*P2))


for integrator, step in (("euler", None), ("rkl2", None), ("backward-euler", 500.0), ("crank-nicolson", 500.0),
                         ("tr-bdf2", None)):
    @kind(f"square, {integrator}", 2)
    def _(w, integrator=integrator, step=step):
        if w.method == MLPG and integrator in ("euler", "rkl2"):
            return None
        return (w.box([1, 1], [10, 9]) + w.material(k_of_T="40-0.02*(T-300)") + w.initial() + w.hold("xmin", 500.0)
                + w.convection("ymax", 80.0, 350.0) + w.march(1e4, integrator, step) + w.probes(*P2))


@kind("flat points", 2)
def _(w):
    return (w.box([1, 0.3], [9, 9]) + w.material() + w.initial() + w.hold("xmin", 400.0) + w.flux("ymax", 3e3)
            + w.march(1e4) + w.probes([0.31, 0.12], [0.83, 0.2]))


@kind("jittered, steady", 2)
def _(w):
    return (w.jittered(12) + w.material() + w.hold("xmin", 300.0) + w.hold_by("xmax", "400+50*Y") + "[steady]\n"
            + w.probes(*P2))


@kind("jittered, marching", 2)
def _(w):
    return (w.jittered(12) + w.material() + w.initial() + w.hold("xmin", 400.0) + w.convection("ymax", 80.0, 350.0)
            + w.march(1e4) + w.probes(*P2))


@kind("cube", 3)
def _(w):
    return (w.box([1, 1, 0.8], [6, 6, 5]) + w.material() + w.initial() + w.hold("xmin", 400.0)
            + w.convection("zmax", 80.0, 350.0) + w.flux("ymin", 2e3) + w.march(1e4) + w.probes(*P3))


@kind("rings", 2, posable=False)
def _(w):
    return (f'[cloud]\nshape = "disc"\nradius = {w.l(1)}\nrings = 6\n{w.extent()}' + w.material() + w.initial()
            + '[boundary.side]\nconvection = { h = "80 W/(m^2 K)", ambient = ' + w.temperature(400.0) + " }\n"
            + w.march(1e4) + w.probes([0.31, 0.42], [-0.53, 0.17]))


@kind("layers", 1)
def _(w):
    d = [0.3, 0.32, 0.38]
    names = ["a", "b", "a"]
    order = range(3) if w.pose.signs[0] > 0 else (2, 1, 0)
    layers = "".join(f'[[body.layer]]\nmaterial = "{names[n]}"\nthickness = {w.l(d[n])}\n' for n in order)
    return (w.box([1], [21]) + w.material(40.0, "a") + w.material(0.4, "b") + '[body]\nalong = "x"\n' + layers
            + w.initial() + w.hold("xmin", 350.0) + w.convection("xmax", 50.0, 280.0) + w.march(1e5)
            + w.probes([0.23], [0.5], [0.9]))


@kind("region and source", 2)
def _(w):
    return (w.box([1, 1], [11, 11]) + w.material(40.0, "a") + w.material(4.0, "b") + '[body]\nmaterial = "a"\n'
            f'[[body.region]]\nmaterial = "b"\nwhere = "{w.formula("X>0.43 && Y<0.52")}"\n'
            f'[source.q]\npower_density = {{ formula = "{w.formula("(1+X*X-Y)*2e4")}/{w.pose.scale!r}", unit = "W/m^3" }}\n'
            + w.initial() + w.hold("xmin", 350.0) + w.convection("ymax", 50.0, 280.0) + w.march(1e4) + w.probes(*P2))


def crack(w, corners, more=""):
    world = [w.pose.point(c) for c in corners]
    lists = "".join(f"{'xyz'[a]} = [" + ", ".join(w.length(c[a]) for c in world) + "]\n" for a in range(w.dimension))
    return f"[[crack]]\n{lists}{more}"


for contact in (None, "100 W/(m^2 K)"):
    @kind("crack" if contact is None else "contact", 2)
    def _(w, contact=contact):
        flux = 'flux = "edge-stabilised"\n'
        return (w.box([1, 1], [10, 10]) + (f"[mlpg]\n{flux}" if w.method == MLPG else "")
                + crack(w, [[0.501, -0.2], [0.501, 0.63 if contact is None else 1.2]],
                        f'contact = "{contact}"\n' if contact else "")
                + w.material() + w.initial() + w.hold("xmin", 400.0) + w.convection("xmax", 50.0, 280.0)
                + w.march(1e4) + w.probes(*P2))


@kind("moving source", 2)
def _(w):
    s = w.pose.scale
    return (w.box([1, 0.6], [16, 10]) + w.material() + w.initial() + w.convection("ymax", 50.0, 280.0)
            + f'[source.arc]\npower = "{2e4 * s * s!r} W"\ncolumn = {{ sigma = {w.l(0.1)} }}\n'
            f'[[source.arc.pass]]\nfrom = {w.place([0.2, 0.31])}\nto = {w.place([0.8, 0.31])}\nspeed = "0.0003 m/s"\n'
            + w.march(3e3) + w.probes([0.31, 0.42], [0.83, 0.17]))


@kind("melting", 2)
def _(w):
    return (w.box([1, 0.5], [13, 7])
            + w.material(more=f'latent_heat = "50 kJ/kg"\nsolidus = {w.temperature(340.0)}\n'
                              f"liquidus = {w.temperature(350.0)}\n")
            + w.initial() + w.hold("xmin", 400.0) + w.march(1e4) + w.probes([0.31, 0.12], [0.13, 0.17]))


def text_of(name, method, pose):
    dimension, _, _, write = KINDS[name]
    w = Writer(pose, dimension)
    w.method = method
    body = write(w)
    if body is None:
        return None, {}
    return f'title = "{name}"\nmethod = "{method}"\n[output]\nfields = false\nsamples = 1\n' + body, w.files
