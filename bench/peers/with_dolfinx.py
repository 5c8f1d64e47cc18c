#!/usr/bin/python3
"""with_dolfinx.py PROBLEM CELLS [STEPS]: finite elements of first order on hexahedra or squares, dolfinx 0.5 with PETSc.

Crank-Nicolson in time, conjugate gradients with the multigrid of hypre (Jacobi in time); Newton's method for the steady
problem. Prints CPU seconds from after the imports on, which is in its favour, and the error."""
from __future__ import annotations

import json
import resource
import sys
from typing import Any

import numpy as np
import problems
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import petsc
from mpi4py import MPI
from petsc4py import PETSc

COMPILED = {"cffi_extra_compile_args": ["-O3", "-march=native"]}
EXACT_FOR_LINEAR = ufl.dx(metadata={"quadrature_degree": 2})


def cpu() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def form(expression: Any) -> Any:
    return fem.form(expression, jit_params=COMPILED)


def solver(matrix: Any, kind: str, preconditioner: str, tolerance: float) -> Any:
    ksp = PETSc.KSP().create(MPI.COMM_WORLD)
    ksp.setOperators(matrix)
    ksp.setType(kind)
    ksp.setTolerances(rtol=tolerance, atol=1e-30, max_it=2000)
    options = PETSc.Options()
    options["pc_type"] = preconditioner
    if preconditioner == "hypre":
        for name, value in (("type", "boomeramg"), ("boomeramg_coarsen_type", "HMIS"), ("boomeramg_interp_type", "ext+i"), ("boomeramg_P_max", 4),
                            ("boomeramg_strong_threshold", 0.5), ("boomeramg_agg_nl", 1), ("boomeramg_relax_type_all", "symmetric-SOR/Jacobi")):
            options[f"pc_hypre_{name}"] = value
    ksp.setFromOptions()
    ksp.setInitialGuessNonzero(True)
    return ksp


def nonlinear_cube(cells: int) -> tuple[Any, Any]:
    body = mesh.create_box(MPI.COMM_WORLD, [[0, 0, 0], [1, 1, 1]], [cells] * 3, mesh.CellType.hexahedron)
    V = fem.FunctionSpace(body, ("CG", 1))
    T, v = fem.Function(V), ufl.TestFunction(V)
    conduction = ufl.exp(2 * T) * ufl.dot(ufl.grad(T), ufl.grad(v)) * EXACT_FOR_LINEAR
    F, J = form(conduction), form(ufl.derivative(conduction, T, ufl.TrialFunction(V)))
    walls = fem.locate_dofs_geometrical(V, lambda x: np.any(np.isclose(x, 0) | np.isclose(x, 1), axis=0))
    held = fem.Function(V)
    held.x.array[:] = problems.nonlinear_cube(V.tabulate_dof_coordinates())
    bcs = [fem.dirichletbc(held, walls)]
    T.x.array[:] = 0.5
    petsc.set_bc(T.vector, bcs)
    A, b = petsc.create_matrix(J), petsc.create_vector(F)
    step, ksp, first = A.createVecLeft(), None, None
    for _ in range(30):
        with b.localForm() as local:
            local.set(0)
        petsc.assemble_vector(b, F)
        petsc.set_bc(b, bcs, T.vector, -1.0)
        first = first or b.norm()
        if b.norm() < 1e-8 * first:
            break
        A.zeroEntries()
        petsc.assemble_matrix(A, J, bcs)
        A.assemble()
        ksp = ksp or solver(A, "bcgs", "hypre", 1e-3)
        ksp.setOperators(A)
        step.set(0)
        ksp.solve(b, step)
        T.vector.axpy(-1.0, step)
    return V, T


def march(V: Any, rho_c: float, conduction: Any, end: float, steps: int, start: float, source: Any = None) -> Any:
    """Crank-Nicolson. `source(t)`: power density at the nodes, W/m^3."""
    u, v, T, dt = ufl.TrialFunction(V), ufl.TestFunction(V), fem.Function(V), end / steps
    T.x.array[:] = start
    mass = u * v * EXACT_FOR_LINEAR
    K = conduction(u, v)
    matrices = [petsc.assemble_matrix(form(one)) for one in (rho_c / dt * mass + 0.5 * K, rho_c / dt * mass - 0.5 * K, mass)]
    for matrix in matrices:
        matrix.assemble()
    A, B, M = matrices
    ksp, b = solver(A, "cg", "jacobi", 1e-7), A.createVecRight()
    q, sum_ = A.createVecRight(), A.createVecRight()
    for n in range(steps):
        B.mult(T.vector, b)
        if source:
            q.array[:] = source((n + 0.5) * dt)
            M.multAdd(q, b, sum_)
        ksp.solve(sum_ if source else b, T.vector)
    return T


def cooling_square(cells: int, steps: int) -> tuple[Any, Any]:
    p = problems.SQUARE
    body = mesh.create_rectangle(MPI.COMM_WORLD, [[0, 0], [p["side"]] * 2], [cells] * 2, mesh.CellType.quadrilateral)
    V = fem.FunctionSpace(body, ("CG", 1))
    cooled = np.sort(np.concatenate([mesh.locate_entities_boundary(body, 1, lambda x, a=a: np.isclose(x[a], p["side"])) for a in (0, 1)]))
    tags = mesh.meshtags(body, 1, cooled, np.ones(len(cooled), np.int32))
    ds = ufl.Measure("ds", domain=body, subdomain_data=tags, metadata={"quadrature_degree": 2})
    return V, march(V, p["rho_c"], lambda u, v: p["k"] * ufl.dot(ufl.grad(u), ufl.grad(v)) * EXACT_FOR_LINEAR + p["h"] * u * v * ds(1),
                    p["end"], steps, p["start"])


def weld(cells: int, steps: int) -> tuple[Any, Any]:
    """`cells`: through the thickness."""
    p = problems.WELD
    counts = [round(size / p["size"][2] * cells) for size in p["size"]]
    body = mesh.create_box(MPI.COMM_WORLD, [[0, 0, 0], list(p["size"])], counts, mesh.CellType.hexahedron)
    V = fem.FunctionSpace(body, ("CG", 1))
    x, sigma = V.tabulate_dof_coordinates(), p["sigma"]

    def bell(d: Any) -> Any:
        return np.exp(-(d**2) / (2 * sigma**2)) / np.sqrt(2 * np.pi) / sigma

    density = p["power"] * bell(x[:, 1]) * 2 * (bell(x[:, 2] - p["size"][2]) + bell(x[:, 2] + p["size"][2]))
    near = np.flatnonzero(density > 1e-7 * density.max())
    q = np.zeros(len(x))

    def source(t: float) -> Any:
        q[near] = density[near] * bell(x[near, 0] - p["from"] - p["speed"] * t)
        return q

    return V, march(V, p["rho"] * p["c"], lambda u, v: p["k"] * ufl.dot(ufl.grad(u), ufl.grad(v)) * EXACT_FOR_LINEAR, p["end"], steps, 0, source)


SOLVERS: dict[str, Any] = {"nonlinear-cube": nonlinear_cube, "cooling-square": cooling_square, "weld": weld}
begin = cpu()
space, found = SOLVERS[sys.argv[1]](*(int(word) for word in sys.argv[2:]))
used = cpu() - begin
print(json.dumps({"cpu": used, "points": len(found.x.array), "error": problems.rms_error(sys.argv[1], space.tabulate_dof_coordinates(), found.x.array)}))
