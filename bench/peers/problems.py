"""The problems that all codes solve, and their exact solutions. Lengths in m, temperatures in K over that of the start."""
from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

Array = np.ndarray

# Steady, k = exp(2 T) W/(m K), in the unit cube, all faces held. exp(2 T) is linear in a harmonic function.


def nonlinear_cube(x: Array) -> Array:
    phi = (2 + x[:, 0] ** 2 + x[:, 1] ** 2 - 2 * x[:, 2] ** 2) / 4
    return 0.5 * np.log((np.exp(2) - 1) * phi + 1)


# A square of 10 cm at 100 K, insulated at x = 0 and y = 0, loses heat to surroundings of 0 K at the other two sides.
SQUARE = {"side": 0.1, "k": 100.0, "rho_c": 1e6, "h": 1000.0, "start": 100.0, "end": 8.0}


def cooling_wall(x: Array, t: float, terms: int = 200) -> Array:
    """Of a wall, insulated at 0 and cooled at its other face: a series of cosines (Carslaw & Jaeger 1959, section 3.11)."""
    biot = SQUARE["h"] * SQUARE["side"] / SQUARE["k"]
    zeta = np.array([brentq(lambda q: q * np.sin(q) - biot * np.cos(q), n * np.pi + 1e-12, (n + 0.5) * np.pi - 1e-12) for n in range(terms)])
    amplitude = 4 * np.sin(zeta) / (2 * zeta + np.sin(2 * zeta))
    fourier = SQUARE["k"] / SQUARE["rho_c"] * t / SQUARE["side"] ** 2
    places, back = np.unique(np.round(x, 12), return_inverse=True)
    return (amplitude * np.exp(-(zeta**2) * fourier) * np.cos(np.outer(places, zeta) / SQUARE["side"])).sum(1)[back]


def cooling_square(x: Array) -> Array:
    return SQUARE["start"] * cooling_wall(x[:, 0], SQUARE["end"]) * cooling_wall(x[:, 1], SQUARE["end"])


# Half of a plate, insulated; a Gaussian source moves along its edge, which is the plane of symmetry.
WELD = {"size": (0.2, 0.05, 0.006), "k": 40.0, "rho": 7800.0, "c": 650.0, "power": 2000.0, "sigma": 2e-3, "from": 0.02,
        "speed": 0.01, "end": 16.0}


def weld(x: Array, places: int = 4000) -> Array:
    """The heat of every moment spreads as a product of Gaussians, mirrored at all walls; Gauss-Legendre in the root of the
    time that has gone by."""
    rho_c = WELD["rho"] * WELD["c"]
    q, weight = np.polynomial.legendre.leggauss(places)
    q, weight = (q + 1) / 2, weight / 2
    ago = WELD["end"] * q**2
    variance = WELD["sigma"] ** 2 + 2 * WELD["k"] / rho_c * ago

    def factor(values: Array, centre: Array | float, length: float) -> tuple[Array, Array]:
        places, back = np.unique(np.round(values, 12), return_inverse=True)
        sum_ = np.zeros((places.size, q.size))
        images = 12 if length < 0.01 else 2
        for m in range(-images, images + 1):
            for sign in (1, -1):
                d = places[:, None] - (sign * centre + 2 * m * length)
                sum_ += np.exp(-(d**2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)
        return sum_, back

    along, i = factor(x[:, 0], WELD["from"] + WELD["speed"] * (WELD["end"] - ago), WELD["size"][0])
    across, j = factor(x[:, 1], 0.0, WELD["size"][1])
    deep, k = factor(x[:, 2], WELD["size"][2], WELD["size"][2])
    # The power is that of the whole plate: half of it stays on this side, where its image doubles it again.
    heat = 2 * WELD["end"] * q * weight * WELD["power"] / rho_c / 2
    return np.einsum("in,jn,kn->ijk", along * heat, across, deep, optimize="greedy")[i, j, k]


EXACT = {"nonlinear-cube": nonlinear_cube, "cooling-square": cooling_square, "weld": weld}


def rms_error(problem: str, x: Array, T: Array) -> float:
    """Over the nodes; of the weld over its peak, else in K."""
    exact = EXACT[problem](x)
    error = float(np.sqrt(np.mean((T - exact) ** 2)))
    return error / float(exact.max()) if problem == "weld" else error
