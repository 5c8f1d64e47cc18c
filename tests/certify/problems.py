"""Problems with known answers: a case, and the exact values of some of its probes, K, or heat flows, W."""
import math
import pathlib

CASES = pathlib.Path(__file__).resolve().parents[2] / "cases"
STEADY = "[steady]\n"


def box(size, points, method="sph", more=""):
    return f'title = "t"\nmethod = "{method}"\n[cloud]\nshape = "box"\nsize = {size}\npoints = {points}\n{more}'


def material(k, rho="1 kg/m^3", c="1 J/(kg K)"):
    k = f'"{k}"' if "W/" in k else formula(k, "W/(m K)")
    return f'[material.m]\nconductivity = {k}\ndensity = "{rho}"\nspecific_heat = "{c}"\n'


def held(face, T):
    return f'[boundary.{face}]\non = "{face}"\ntemperature = {T}\n'


def probes(**places):
    return "[probe]\n" + "".join(f"{name} = {[f'{c} m' for c in place]}\n".replace("'", '"') for name, place in places.items())


def text(value):
    return f'"{value}"'


def formula(text, unit="K"):
    return f'{{ formula = "{text}", unit = "{unit}" }}'


def series(F, terms=400):
    return sum(F(n) for n in range(terms))


def graded_plate():
    """k = 1 + 2 x, 0 K and 1 K: T = ln(1 + 2 x) / ln 3."""
    case = box(["1 m", "0.5 m"], [11, 6]) + material("1 + 2*x") + held("xmin", '"0 K"') + held("xmax", '"1 K"') + STEADY
    return case + probes(a=(0.3, 0.2), b=(0.75, 0.25)), {"probe a": math.log(1.6) / math.log(3), "probe b": math.log(2.5) / math.log(3),
                                                        "heat flow xmax": 1 / math.log(3)}


def conductivity_of_temperature():
    """k = exp(2 T): linear in theta."""
    case = box(["1 m"], [11]) + material("exp(2*T)") + held("xmin", '"0 K"') + held("xmax", '"1 K"') + STEADY + probes(a=(0.35,))
    return case, {"probe a": math.log(0.35 * (math.exp(2) - 1) + 1) / 2}


def exponential():
    """e^x sin y on an irregular square."""
    f = formula("300 + 10*exp(x)*sin(y)")
    walls = "".join(held(face, f) for face in ("xmin", "xmax", "ymin", "ymax"))
    case = box(["1 m", "1 m"], [11, 11], more="jitter = 0.2\n") + material("1 W/(m K)") + walls + STEADY + probes(a=(0.37, 0.62), b=(0.8, 0.2))
    exact = lambda x, y: 300 + 10 * math.exp(x) * math.sin(y)
    return case, {"probe a": exact(0.37, 0.62), "probe b": exact(0.8, 0.2)}


def hollow_cylinder():
    a, b, k, h, Ta, Tb = 0.01, 0.02, 10., 500., 400., 300.
    q = (Ta - Tb) / (math.log(b / a) / k + 1 / (h * b))  # q r
    case = f"""title = "t"
method = "sph"
[cloud]
shape = "surface"
spacing = "1.5 mm"
[[cloud.part]]
shape = "sector"
inner = "{a} m"
outer = "{b} m"
from = "0 deg"
to = "90 deg"
[boundary.in]
on = "inner"
temperature = "{Ta} K"
[boundary.out]
on = "outer"
convection = {{ h = "{h} W/(m^2 K)", ambient = "{Tb} K" }}
""" + material("10 W/(m K)") + STEADY
    r, angle = 0.0147, 0.6
    return case + probes(a=(r * math.cos(angle), r * math.sin(angle))), {"probe a": Ta - q / k * math.log(r / a), "heat flow in": q * math.pi / 2}


def nafems_t4():
    """NAFEMS T4: 18.25 degC at (0.6 m, 0.2 m); digits beyond by series would be needed, so the bar must hold 18.25 +- 0.01."""
    case = box(["0.6 m", "1 m"], [13, 21]) + material("52 W/(m K)") + held("ymin", '"373.15 K"')
    for face in ("xmax", "ymax"):
        case += f'[boundary.{face}]\non = "{face}"\nconvection = {{ h = "750 W/(m^2 K)", ambient = "273.15 K" }}\n'
    return case + STEADY + probes(E=(0.6, 0.2)), {"probe E": plate_t4(0.6, 0.2)}


def plate_t4(x, y):
    """Separation of variables: cos(a x), a tan(a L) = h / k, of sinh and cosh in y."""
    k, h, L, H = 52., 750., 0.6, 1.
    total = 0.
    for n in range(400):
        low, high = n * math.pi / L + 1e-12, (n + 0.5) * math.pi / L - 1e-12
        for _ in range(200):
            a = (low + high) / 2
            low, high = (a, high) if a * math.tan(a * L) < h / k else (low, a)
        c = 2 * math.sin(a * L) / (a * L + math.sin(a * L) * math.cos(a * L))
        beta = h / k / a
        # Y(0) = 1, Y' = -h/k Y at H, written without overflow
        up, down = math.exp(-a * y), math.exp(-a * (2 * H - y))
        r = (1 - beta) / (1 + beta)
        total += c * math.cos(a * x) * (up + r * down) / (1 + r * math.exp(-2 * a * H))
    return 273.15 + 100 * total


def nafems_t3():
    """NAFEMS T3: 1D, T = 100 sin(pi t / 40) degC at x = 0.1 m, 0 degC at 0: at 0.08 m after 32 s, by modes."""
    k, rho, c, L = 35., 7200., 440.5, 0.1
    case = box(["0.1 m"], [21]) + material("35 W/(m K)", "7200 kg/m^3", "440.5 J/(kg K)") + held("xmin", '"273.15 K"') \
        + held("xmax", formula("273.15 + 100*sin(pi*t/40)")) + '[initial]\ntemperature = "273.15 K"\n[time]\nend = "32 s"\n'
    t, x, w, D = 32., 0.08, math.pi / 40, k / rho / c
    g = 100 * math.sin(w * t) * x / L
    for n in range(1, 4000):  # T = g + sum b_n sin(n pi x / L), b' = -lam b - g_n'
        lam = D * (n * math.pi / L) ** 2
        q = -2 * (-1) ** (n + 1) / (n * math.pi) * 100 * w
        b = q * (lam * math.cos(w * t) + w * math.sin(w * t) - lam * math.exp(-lam * t)) / (lam**2 + w**2)
        g += b * math.sin(n * math.pi * x / L)
    return case + probes(a=(0.08,)), {"probe a": 273.15 + g}


def cooling_square():
    """A square with insulated and cooled sides: a product of two series."""
    h, k, L, t = 0.5, 1., 1., 0.3
    case = box(["1 m", "1 m"], [11, 11]) + material("1 W/(m K)") + '[initial]\ntemperature = "100 K"\n[time]\nend = "0.3 s"\n'
    for face in ("xmax", "ymax"):
        case += f'[boundary.{face}]\non = "{face}"\nconvection = {{ h = "{h} W/(m^2 K)", ambient = "0 K" }}\n'

    def one(x):
        total = 0.
        for n in range(60):
            low, high = n * math.pi + 1e-12, (n + 0.5) * math.pi - 1e-12
            for _ in range(200):
                a = (low + high) / 2
                low, high = (a, high) if a * math.tan(a) < h * L / k else (low, a)
            total += 4 * math.sin(a) / (2 * a + math.sin(2 * a)) * math.cos(a * x) * math.exp(-a * a * t)
        return total

    return case + probes(a=(0.25, 0.6), b=(1, 1)), {"probe a": 100 * one(0.25) * one(0.6), "probe b": 100 * one(1) ** 2}


def inner_corner():
    """r^(2/3) sin(2/3 angle) on an L: singular."""
    f = "(x^2 + y^2)^(1/3)*sin(2/3*(0.75*pi + atan2(-x - y, y - x)))"
    case = f"""title = "t"
method = "sph"
[cloud]
shape = "surface"
spacing = "0.1 m"
[[cloud.part]]
shape = "polygon"
x = ["0 m", "1 m", "1 m", "-1 m", "-1 m", "0 m"]
y = ["0 m", "0 m", "1 m", "1 m", "-1 m", "-1 m"]
names = ["outline"]
[boundary.outline]
on = "outline"
temperature = {formula(f)}
""" + material("1 W/(m K)") + STEADY
    exact = lambda x, y: (x * x + y * y) ** (1 / 3) * math.sin(2 / 3 * (0.75 * math.pi + math.atan2(-x - y, y - x)))
    return case + probes(a=(0.4, 0.5), b=(-0.05, 0.1)), {"probe a": exact(0.4, 0.5), "probe b": exact(-0.05, 0.1)}


def two_layers():
    """Steady through 0.37 m of k = 1 and 0.63 m of k = 20, air outside."""
    case = box(["1 m"], [11]) + """[material.a]
conductivity = "1 W/(m K)"
[material.b]
conductivity = "20 W/(m K)"
[body]
along = "x"
[[body.layer]]
material = "a"
thickness = "0.37 m"
[[body.layer]]
material = "b"
thickness = "0.63 m"
[boundary.air]
on = "xmax"
convection = { h = "5 W/(m^2 K)", ambient = "10 K" }
""" + held("xmin", '"0 K"') + STEADY
    q = 10 / (0.37 + 0.63 / 20 + 1 / 5)
    return case + probes(a=(0.2,), b=(0.8,)), {"probe a": 0.2 * q, "probe b": q * (0.37 + 0.43 / 20), "heat flow air": q}


def radiating_slab():
    """NAFEMS T2: 1000 K at one end, radiating to 300 K, emissivity 0.98, k = 55.6, 0.1 m: 927 K."""
    case = box(["0.1 m"], [11]) + material("55.6 W/(m K)") + held("xmin", '"1000 K"') + """[boundary.out]
on = "xmax"
radiation = { emissivity = 0.98, ambient = "300 K" }
""" + STEADY
    low, high = 300., 1000.
    for _ in range(200):
        T = (low + high) / 2
        low, high = (T, high) if 55.6 * (1000 - T) / 0.1 > 0.98 * 5.670374419e-8 * (T**4 - 300**4) else (low, T)
    return case + probes(a=(0.05,), b=(0.1,)), {"probe a": (1000 + T) / 2, "probe b": T}


def cosine():
    """cos(pi x) cos(pi y) decays in an insulated square."""
    case = box(["1 m", "1 m"], [11, 11]) + material("1 W/(m K)") + f'[initial]\ntemperature = {formula("300 + 10*cos(pi*x)*cos(pi*y)")}\n' \
        + '[time]\nend = "0.05 s"\n'
    exact = lambda x, y: 300 + 10 * math.exp(-2 * math.pi**2 * 0.05) * math.cos(math.pi * x) * math.cos(math.pi * y)
    return case + probes(a=(0, 0), b=(0.3, 0.2)), {"probe a": exact(0, 0), "probe b": exact(0.3, 0.2)}


def heated_half_space():
    """A flux into a thick slab: 2 q sqrt(t / (pi k rho c)) at the surface."""
    case = box(["2 m"], [41]) + material("1 W/(m K)") + '[boundary.in]\non = "xmin"\nflux = "100 W/m^2"\n' \
        + '[initial]\ntemperature = "300 K"\n[time]\nend = "0.05 s"\n'
    t, x = 0.05, 0.1
    inside = 2 * math.sqrt(t / math.pi) * math.exp(-x * x / 4 / t) - x * math.erfc(x / 2 / math.sqrt(t))
    return case + probes(a=(0,), b=(x,)), {"probe a": 300 + 200 * math.sqrt(t / math.pi), "probe b": 300 + 100 * inside}


def source_in_a_disc():
    """Even source in a disc at 0 K on its side: Q (R^2 - r^2) / 4 k."""
    case = """title = "t"
method = "sph"
[cloud]
shape = "surface"
spacing = "0.15 m"
[[cloud.part]]
shape = "disc"
radius = "1 m"
[source.s]
power_density = "4 W/m^3"
[boundary.side]
on = "side"
temperature = "0 K"
""" + material("1 + T") + STEADY
    exact = lambda r: math.sqrt(1 + 2 * (1 - r * r)) - 1
    return case + probes(a=(0.05, 0.02), b=(0.4, 0.3)), {"probe a": exact(math.hypot(0.05, 0.02)), "probe b": exact(0.5)}


def even_source_in_a_cube():
    """In three dimensions: a cube at 0 K outside, as a square bar less what its ends take, by sums of 1/cosh; 0.0562 Q L^2 / k in the
    middle."""
    case = box(["1 m", "1 m", "1 m"], [9, 9, 9]) + '[source.s]\npower_density = "100 W/m^3"\n' + material("1 W/(m K)") \
        + "".join(held(face, '"0 K"') for face in ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")) + STEADY
    odd = range(1, 60, 2)
    sign = {n: (-1) ** (n // 2) for n in odd}
    bar = 1 / 8 - sum(4 * sign[n] / (math.pi * n) ** 3 / math.cosh(n * math.pi / 2) for n in odd)
    ends = sum(16 * sign[n] * sign[m] / math.pi**4 / n / m / (n * n + m * m) / math.cosh(math.pi * math.hypot(n, m) / 2) for n in odd for m in odd)
    return case + probes(a=(0.5, 0.5, 0.5)), {"probe a": 100 * (bar - ends)}


def thermal_shock():
    """A thick slab of 300 K meets air of 1300 K: erfc and exp, as if it had no end."""
    h, k, t = 20., 1., 0.02
    case = box(["1 m"], [41]) + material("1 W/(m K)") + '[boundary.air]\non = "xmin"\n' \
        + 'convection = { h = "20 W/(m^2 K)", ambient = "1300 K" }\n[initial]\ntemperature = "300 K"\n[time]\nend = "0.02 s"\n'

    def exact(x):
        s = 2 * math.sqrt(t)
        return 300 + 1000 * (math.erfc(x / s) - math.exp(h * x / k + h * h * t / k / k) * math.erfc(x / s + h * math.sqrt(t) / k))

    return case + probes(a=(0,), b=(0.1,)), {"probe a": exact(0), "probe b": exact(0.1)}


def weld():
    """A Gaussian source crosses an insulated plate of constant properties: an integral over time of Gaussians and their images."""
    k, rho, c, d, sigma, power, speed, Lx, Ly, end = 40., 7850., 600., 0.002, 0.003, 1000., 0.01, 0.08, 0.04, 5.
    case = box(["80 mm", "40 mm"], [41, 21], more='thickness = "2 mm"\n') + material("40 W/(m K)", "7850 kg/m^3", "600 J/(kg K)") \
        + '[source.arc]\npower = "1000 W"\nhalf = true\ncolumn = { sigma = "3 mm" }\n[[source.arc.pass]]\nfrom = ["20 mm", "0 mm"]\n' \
        + 'to = ["60 mm", "0 mm"]\nspeed = "10 mm/s"\n[initial]\ntemperature = "300 K"\n[time]\nend = "5 s"\n'

    def spread(x, at, length, variance):
        images = [2 * n * length + side * at for n in (-2, -1, 0, 1, 2) for side in (1, -1)]
        return sum(math.exp(-(x - one) ** 2 / 2 / variance) for one in images) / math.sqrt(2 * math.pi * variance)

    def exact(x, y):
        steps, total = 4000, 0.  # Simpson's rule over the pass of 4 s
        for n in range(steps + 1):
            tau = 4 * n / steps
            variance = sigma**2 + 2 * k / rho / c * (end - tau)
            weight = 1 if n in (0, steps) else 4 if n % 2 else 2
            total += weight * spread(x, 0.02 + speed * tau, Lx, variance) * spread(y, 0., Ly, variance) / 2  # 0 is its own image
        return 300 + power / rho / c / d * total * 4 / steps / 3

    return case + probes(a=(0.04, 0.006), b=(0.055, 0.)), {"probe a": exact(0.04, 0.006), "probe b": exact(0.055, 0.)}


def crack_tips():
    """Around a crack that insulates: Im sqrt(z^2 - a^2), singular at both tips."""
    f = formula("sqrt(sqrt(((x-0.5)^2+y^2)*((x+0.5)^2+y^2)))*sin((atan2(y,x-0.5)+atan2(y,x+0.5))/2)")
    case = box(["2 m", "2 m"], [20, 20], more='origin = ["-1 m", "-1 m"]\n[[crack]]\nx = ["-0.5 m", "0.5 m"]\ny = ["0 m", "0 m"]\n') \
        + material("1 W/(m K)") + "".join(held(face, f) for face in ("xmin", "xmax", "ymin", "ymax")) + STEADY

    def exact(x, y):
        return math.sqrt(math.hypot(x - 0.5, y) * math.hypot(x + 0.5, y)) * math.sin((math.atan2(y, x - 0.5) + math.atan2(y, x + 0.5)) / 2)

    return case + probes(a=(0.2, 0.3), b=(0.75, 0.2)), {"probe a": exact(0.2, 0.3), "probe b": exact(0.75, 0.2)}


def shipped(name):
    """A case of calor up to its expectations."""
    return (CASES / f"{name}.toml").read_text().split("[[expect]]")[0]


def circuit_board():
    """Copper far thinner than the spacing, and a chip whose edge lies between points: double cosine series, 400 x 400 terms."""
    exact = {"chip": 95.48587, "under": 90.38441, "edge": 62.56381, "corner": 59.27530}
    return shipped("field/circuit-board"), {f"probe {name}": 273.15 + T for name, T in exact.items()}


def melting_half_space():
    """Latent heat over 50 K: how far the melt and the mushy zone reach, by the similarity solution of three zones."""
    return shipped("dan/melting"), {"melted liquid": 5.358148e-3, "melted molten": 6.295483e-3}


def radiating_ball():
    """Everything depends on temperature: finite volumes along the radius, docs/scripts/radiating-sphere.py."""
    return shipped("body/radiating-sphere"), {"probe middle": 880.140, "probe half": 873.493}


ALL = [graded_plate, conductivity_of_temperature, exponential, hollow_cylinder, nafems_t4, nafems_t3, cooling_square, inner_corner,
       two_layers, radiating_slab, cosine, heated_half_space, source_in_a_disc, even_source_in_a_cube,
       thermal_shock, weld, crack_tips, circuit_board, melting_half_space, radiating_ball]
