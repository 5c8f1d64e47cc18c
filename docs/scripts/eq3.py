#!/usr/bin/python3
"""Solves Fig. 2 of Rong & Kisu (steady, k = exp(B x), 4 m x 4 m, 41 x 41 points) with their eq. (3) as it is printed and
with its pair sum alone, and compares both with the exact solution. Needs numpy; takes half a minute. See docs/eq3-double-count.md."""
import numpy as np

n, L = 41, 4.0
dx = L / (n - 1)
h = dx  # smoothing length; the kernel ends at 2 h
x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(0, L, n), np.linspace(0, L, n), indexing="ij"))

# Cubic spline in 2D: V_j dW/dr / r for all pairs, with the corrected constants of eq. (4). F = -dW/dr / r > 0.
dx_ij, dy_ij = x[:, None] - x[None, :], y[:, None] - y[None, :]
r = np.hypot(dx_ij, dy_ij)
z = r / h
slope = 10 / (7 * np.pi) / h**3 * np.where(z < 1, -3 * z + 2.25 * z**2, np.where(z < 2 - 1e-9, -0.75 * (2 - z) ** 2, 0))
F = dx**2 * np.divide(-slope, r, out=np.zeros_like(r), where=r > 0)


def difference(weights):
    """The matrix of T -> sum_j weights_ij (T_j - T_i)."""
    return weights - np.diag(weights.sum(1))


gradient_x, gradient_y = difference(-F * dx_ij), difference(-F * dy_ij)
hot, cold = x > L - 1e-9, x < 1e-9
insulated = ((y < 1e-9) | (y > y.max() - 1e-9)) & ~hot & ~cold

print("largest error of T, which goes from 0 to 1")
print("    B   eq. (3) as printed   pair sum alone   k T'' + 2 k' T' = 0, exactly")
for B in (-0.2, 0.5, 1.0):
    k = np.exp(B * x)
    pairs = difference(F * (k[:, None] + k[None, :]))
    product = np.diag((-F * dx_ij) @ k) @ gradient_x + np.diag((-F * dy_ij) @ k) @ gradient_y  # grad k . grad T
    exact = np.expm1(-B * x) / np.expm1(-B * L)
    errors = []
    for operator in (pairs + product, pairs):
        A, b = operator.copy(), np.zeros(len(x))
        A[insulated] = gradient_y[insulated]  # eq. (5) with zero flux
        A[hot | cold] = np.eye(len(x))[hot | cold]
        b[hot] = 1
        errors.append(abs(np.linalg.solve(A, b) - exact).max())
    doubled = np.expm1(-2 * B * x) / np.expm1(-2 * B * L)
    print(f"{B:5.1f}{100 * errors[0]:17.1f} %{100 * errors[1]:16.2f} %{100 * abs(doubled - exact).max():16.1f} %")
