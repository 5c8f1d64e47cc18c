#!/usr/bin/env python3
"""Temperatures of cases/body/radiating-sphere.toml after 600 s by finite volumes along the radius.

Prints them at the centre, at half the radius and on the surface for 100, 200 and 400 shells.
"""

import numpy as np
from scipy.integrate import solve_ivp

RADIUS, DENSITY, EMISSIVITY, SIGMA = 0.05, 7800.0, 0.8, 5.670374419e-8
START, AROUND, END = 1200.0, 300.0, 600.0


def conductivity(T):
    return 15 + 0.01 * T


def specific_heat(T):
    return 400 + 0.2 * T


def surface(T, half):
    """Temperature of the surface: what comes from the middle of the last shell, `half` away, is radiated."""
    Ts = T
    for _ in range(30):
        k = conductivity(T) / half
        excess = k * (Ts - T) + EMISSIVITY * SIGMA * (Ts**4 - AROUND**4)
        Ts -= excess / (k + 4 * EMISSIVITY * SIGMA * Ts**3)
    return Ts


def solve(shells):
    r = np.linspace(0, RADIUS, shells + 1)
    volume, area, dr = np.diff(r**3) / 3, r**2, RADIUS / shells

    def rate(_, T):
        q = np.zeros(shells + 1)
        q[1:-1] = -0.5 * (conductivity(T[1:]) + conductivity(T[:-1])) * np.diff(T) / dr
        q[-1] = EMISSIVITY * SIGMA * (surface(T[-1], dr / 2) ** 4 - AROUND**4)
        return -np.diff(area * q) / (volume * DENSITY * specific_heat(T))

    T = solve_ivp(rate, (0, END), np.full(shells, START), method="BDF", rtol=1e-9, atol=1e-7).y[:, -1]
    return T[0], np.interp(RADIUS / 2, 0.5 * (r[1:] + r[:-1]), T), surface(T[-1], dr / 2)


for shells in (100, 200, 400):
    print(shells, *(f"{T:.3f} K" for T in solve(shells)))
