#!/usr/bin/python3
"""Melting of a half-space between a hot wall and a cold body: similarity solutions, into melting-*.csv.

Three zones with one conductivity and density: liquid, mushy with the capacity c + L/(T_l - T_s), solid. In each
T = A + B erf(eta / sqrt(alpha)), eta = x / (2 sqrt t), and the heat flux is continuous: two equations for the places of
liquidus and solidus. For L at one temperature, Neumann's solution (Carslaw & Jaeger, section 11.2). Needs numpy.
"""
import math
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
K, RHO, C, L = 30.0, 7850.0, 650.0, 270e3  # W/(m K), kg/m^3, J/(kg K), J/kg
T_WALL, T_START = 1800.0, 20.0  # degC
ALPHA = K / (RHO * C)


def flux(eta, alpha):
    """exp(-eta^2/alpha)/sqrt(alpha): gradient of erf(eta/sqrt(alpha)) but for a factor."""
    return math.exp(-eta * eta / alpha) / math.sqrt(alpha)


def bisect(f, low, high):
    f_low = f(low)
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (f(middle) > 0) == (f_low > 0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def three_zones(solidus, liquidus):
    """eta of liquidus and solidus, and T(eta)."""
    mushy = K / (RHO * (C + L / (liquidus - solidus)))
    root, root_m = math.sqrt(ALPHA), math.sqrt(mushy)

    def between(a, b):  # erf(b) - erf(a) without cancellation
        return math.erfc(a / root_m) - math.erfc(b / root_m)

    def solid_front(eta_l):
        """From the flux at the liquidus: where the mushy zone reaches the solidus."""
        gradient = (T_WALL - liquidus) / math.erf(eta_l / root) * flux(eta_l, ALPHA) / flux(eta_l, mushy)
        missing = (liquidus - solidus) / gradient  # erf(eta_s) - erf(eta_l) in the mushy zone
        if missing >= math.erfc(eta_l / root_m):
            return None
        return bisect(lambda eta: between(eta_l, eta) - missing, eta_l, eta_l + 10 * root)

    def excess(eta_l):
        """Heat flux into the solidus less that out of it."""
        eta_s = solid_front(eta_l)
        if eta_s is None:
            return -1.0
        into = (liquidus - solidus) / between(eta_l, eta_s) * flux(eta_s, mushy)
        return into - (solidus - T_START) / math.erfc(eta_s / root) * flux(eta_s, ALPHA)

    eta_l = bisect(excess, 1e-6 * root, 3 * root)
    eta_s = solid_front(eta_l)

    def T(eta):
        if eta < eta_l:
            return T_WALL + (liquidus - T_WALL) * math.erf(eta / root) / math.erf(eta_l / root)
        if eta < eta_s:
            return liquidus + (solidus - liquidus) * between(eta_l, eta) / between(eta_l, eta_s)
        return T_START + (solidus - T_START) * math.erfc(eta / root) / math.erfc(eta_s / root)

    return eta_l, eta_s, T


def neumann(melting):
    """eta of the front, and T(eta)."""
    root = math.sqrt(ALPHA)

    def excess(eta):
        into = (T_WALL - melting) / math.erf(eta / root) * flux(eta, ALPHA)
        out = (melting - T_START) / math.erfc(eta / root) * flux(eta, ALPHA)
        return into - out - math.sqrt(math.pi) * RHO * L / K * eta

    front = bisect(excess, 1e-6 * root, 3 * root)

    def T(eta):
        if eta < front:
            return T_WALL + (melting - T_WALL) * math.erf(eta / root) / math.erf(front / root)
        return T_START + (melting - T_START) * math.erfc(eta / root) / math.erfc(front / root)

    return front, T


def write(name, T, t=60.0):
    with open(HERE / name, "w") as file:
        file.write("x [mm],T [degC]\n")
        for x in np.arange(0, 200.25, 0.25):
            file.write(f"{x:g},{T(1e-3 * x / (2 * math.sqrt(t))):.9f}\n")


if __name__ == "__main__":
    for solidus, liquidus, name in [(1450.0, 1500.0, "50"), (1474.0, 1476.0, "2")]:
        eta_l, eta_s, T = three_zones(solidus, liquidus)
        write(f"melting-{name}.csv", T)
        depth = [2e3 * eta * math.sqrt(60.0) for eta in (eta_l, eta_s)]
        print(f"{name} K: liquidus at {depth[0]:.6f} mm, solidus at {depth[1]:.6f} mm at 60 s")
    front, T = neumann(1475.0)
    write("melting-neumann.csv", T)
    print(f"Neumann: front at {2e3 * front * math.sqrt(60.0):.6f} mm at 60 s")
