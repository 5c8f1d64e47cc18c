#!/usr/bin/python3
"""Rosenthal's solutions for a point or line of heat that moves for ever: cooling times and widths, into rosenthal-*.csv.

Thin plate of thickness h:  T - T0 = q / (2 pi k h) exp(-v xi / 2a) K0(v r / 2a);  thick plate:  T - T0 = q / (2 pi k r)
exp(-v (xi + r) / 2a);  xi = x - v t (Rosenthal, Weld. J. 20 (1941) 220-s). Needs numpy.
"""
import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
K, RHO_C, T0 = 50.0, 7850.0 * 500.0, 20.0  # W/(m K), J/(m^3 K), degC
A = K / RHO_C


def scaled_k0(x):
    """exp(x) K0(x) as the integral of exp(-x (cosh u - 1)), by the trapezoidal rule."""
    u = np.linspace(0, 12, 4001)
    with np.errstate(over="ignore"):
        f = np.exp(-np.multiply.outer(np.atleast_1d(x), np.cosh(u) - 1))
    return (f.sum(-1) - 0.5 * (f[..., 0] + f[..., -1])) * (u[1] - u[0])


def thin(q, v, h):
    return lambda xi, y: T0 + q / (2 * np.pi * K * h) * np.exp(-v * (xi + np.hypot(xi, y)) / (2 * A)) * scaled_k0(
        v * np.hypot(xi, y) / (2 * A))


def thick(q, v):
    return lambda xi, r: T0 + q / (2 * np.pi * K * np.hypot(xi, r)) * np.exp(-v * (xi + np.hypot(xi, r)) / (2 * A))


def peak(T, r):
    """Largest temperature at a distance from the weld line, and xi where it is: refined twice."""
    low, high = -0.2, 0.0
    for _ in range(4):
        xi = np.linspace(low, high, 2001)
        values = T(xi, r)
        n = int(values.argmax())
        low, high = xi[max(n - 1, 0)], xi[min(n + 1, 2000)]
    return values[n], xi[n]


def cooling_time(T, r, v, high=800.0, low=500.0):
    """Time from `high` down to `low` at a distance from the weld line, s."""
    top, xi_top = peak(T, max(r, 1e-6))
    times = []
    for level in (high, low):
        a, b = -1.0, xi_top
        for _ in range(80):
            middle = 0.5 * (a + b)
            a, b = (middle, b) if T(np.array([middle]), r)[0] < level else (a, middle)
        times.append(-a / v)
    return times[1] - times[0]


def half_width(T, isotherm):
    a, b = 1e-5, 0.05
    for _ in range(60):
        middle = 0.5 * (a + b)
        a, b = (middle, b) if peak(T, middle)[0] > isotherm else (a, middle)
    return a


if __name__ == "__main__":
    for name, T, v, places in [("thin", thin(1200.0, 0.01, 0.003), 0.01, np.arange(10) * 0.3),
                               ("thick", thick(2000.0, 0.01), 0.01, np.arange(10) * 0.36)]:
        print(f"{name}: half width at 1200 degC {1e3 * half_width(T, 1200.0):.5f} mm")
        with open(HERE / f"rosenthal-{name}.csv", "w") as file:
            file.write("y [mm],cooling time [s],peak [degC]\n")
            for y in places:
                top = peak(T, 1e-3 * y)[0] if y > 0 else float("inf")
                file.write(f"{y:g},{cooling_time(T, 1e-3 * y, v):.6f},{min(top, 1e6):.3f}\n")
