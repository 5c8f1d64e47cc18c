"""The library in this process: points, weights, residuals, Jacobians and materials as arrays, and laws written in Python.

    from calor import core
    m = core.Model("plate.toml", method="sph")
    m.weights @ m.points + m.areas           # 0: the weights are exact for linear temperatures
    T = m.solve()                            # numpy, K, one value a point

docs/core.md goes through it. For one process and bodies of a size that fits it; large runs are those of the command (`Case.run`).
Needs python3-scipy, and the module that ./dev core builds and python3-calor brings.
"""
from __future__ import annotations

import importlib.util
import inspect
import os
import pathlib
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.machinery import PathFinder
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import command, toml
from .case import Case
from .command import CommandError
from .result import Result

try:
    from scipy.sparse import csr_matrix
except ModuleNotFoundError:
    raise ModuleNotFoundError("calor.core needs python3-scipy: apt-get install python3-scipy") from None

if TYPE_CHECKING:
    from . import _core
else:
    def _load():
        """The compiled module: beside this file where calor is installed, else beside the command that was built."""
        places = [command.PACKAGE]
        with suppress(command.FileError):
            places.append(pathlib.Path(command.find_command()).parent / "python")
        found = PathFinder.find_spec("_core", [str(place) for place in places])
        if not found or not found.loader:
            raise ModuleNotFoundError("calor.core is not built: run ./dev core, or install python3-calor")
        found.name = "calor._core"
        module = importlib.util.module_from_spec(found)
        sys.modules["calor._core"] = module
        found.loader.exec_module(module)
        return module

    _core = _load()

__all__ = ["Facets", "Material", "Model", "material", "materials", "run"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Law = Callable[..., ArrayLike]
"""A function of `x`, `t` and `T`, or of some of them: it is called with those that its parameters name. x: places, (n, 3)
in m; t: time, s; T: temperatures, (n,) in K. It returns n values, or one for all, in SI units."""


def _prepared(name: str, law: Law) -> tuple[Callable[[Floats, float, Floats], Floats], bool, bool, bool]:
    """The law as the compiled module calls it, and whether it depends on place, time and temperature."""
    try:
        wanted = list(inspect.signature(law).parameters)
    except ValueError:
        wanted = ["?"]
    if not set(wanted) <= {"x", "t", "T"}:
        raise TypeError(f"the parameters of '{name}' say what it depends on: some of x, t and T, not ({', '.join(wanted)})")

    def evaluate(x: Floats, t: float, T: Floats) -> Floats:
        given = {"x": x, "t": t, "T": T}
        values = np.asarray(law(**{word: given[word] for word in wanted}), float)
        if values.shape not in ((), (len(x),)):
            raise ValueError(f"'{name}' returns {values.size} values for {len(x)} places")
        return np.broadcast_to(values, len(x))

    return evaluate, "x" in wanted, "t" in wanted, "T" in wanted


def _take_laws(value: Any, path: str, laws: dict[str, Law]) -> Any:
    """The value with the names of the functions in it in their places; the functions go into `laws`."""
    if callable(value):
        laws[path] = value
        return {"callback": path}
    if isinstance(value, Mapping):
        return {key: _take_laws(item, f"{path}.{key}" if path else key, laws) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_take_laws(item, f"{path}[{n}]", laws) for n, item in enumerate(value, 1)]
    return value


CaseLike = str | os.PathLike[str] | Mapping[str, Any]


class _Words:
    """A case as the command takes it, beside its functions."""

    def __init__(self, case: CaseLike | Case, changes: Mapping[str, Any] | None, variant: str | None, functions: Mapping[str, Law] | None,
                 keys: Mapping[str, Any]) -> None:
        laws = dict(functions or {})
        changed = {key: _take_laws(value, key, laws) for key, value in {**(changes or {}), **keys}.items()}
        if isinstance(case, Case):
            self.case = case.changed({**changed, **({"variant": variant} if variant else {})})
        else:
            written = _take_laws(case, "", laws) if isinstance(case, Mapping) else case
            self.case = Case(written, changed, variant=variant)
        self.laws = {name: _prepared(name, law) for name, law in laws.items()}

    @contextmanager
    def read(self) -> Iterator[tuple[str, list[str], dict[str, Any]]]:
        with self.case._words() as words:
            yield words[0], words[1:], self.laws


@dataclass(frozen=True)
class Facets:
    """Pieces of the surface of the body: every one belongs to a point and a face."""

    point: Integers
    """Number of the point."""
    face: Integers
    """Index into Model.faces."""
    area: Floats
    """m^2"""
    normal: Floats
    """Outward, of length 1, (facets, 3)."""


class Model:
    """A case put together in this process: points, method, materials, conditions; nothing has been solved yet.

    `case`: a file, a dictionary or a Case; `changes`, keyword arguments and `variant` as of Case. Wherever a case takes a
    function, such as material.steel.conductivity or source.laser.power_density, the changes and dictionaries may hold
    one of Python (see Law); `functions` gives names to those that the case asks for by { callback = "NAME" }.

        core.Model("plate.toml", {"material.steel.conductivity": lambda T: 54 - 0.03 * (T - 293)})

    Points have the numbers that they have in results; vectors have three components in every dimension. `u` are the degrees
    of freedom: the temperatures of the points in SPH and peridynamics, in MLPG parameters whose temperatures are shape
    functions times parameters (`temperatures`, `dofs`). Raises CaseError, FileError, NumbersError.
    """

    def __init__(self, case: CaseLike | Case, changes: Mapping[str, Any] | None = None, *, variant: str | None = None,
                 functions: Mapping[str, Law] | None = None, **keys: Any) -> None:
        with _Words(case, changes, variant, functions, keys).read() as (path, words, laws):
            self._model = _core.Model(path, words, laws)

    def _matrix(self, entries: tuple[Integers, Integers, Floats]) -> Any:
        rows, columns, values = entries
        return csr_matrix((values, (rows, columns)), shape=(len(self), len(self)))

    def __len__(self) -> int:
        return len(self._model.volumes)

    @property
    def dimension(self) -> int:
        """1, 2 or 3"""
        return self._model.dimension

    @property
    def points(self) -> Floats:
        """Places, (n, 3), m."""
        return self._model.points

    @property
    def volumes(self) -> Floats:
        """Of the cells of the points, (n,), m^3 of the real body: thickness and section count."""
        return self._model.volumes

    @property
    def spacing(self) -> Floats:
        """Of the points along every axis, (n, 3), m."""
        return self._model.spacing

    @property
    def areas(self) -> Floats:
        """Outward area vectors of the surface that belongs to the points, (n, 3), m^2; 0 inside the body."""
        return self._model.areas

    @property
    def faces(self) -> list[str]:
        """Names of the faces."""
        return self._model.faces

    @property
    def facets(self) -> Facets:
        """The surface in pieces."""
        return Facets(**self._model.facets)

    @property
    def parts(self) -> list[str]:
        """The material of every part of the body."""
        return self._model.parts

    @property
    def part(self) -> Integers:
        """Of every point, index into parts, (n,)."""
        return self._model.part

    @property
    def prescribed(self) -> Integers:
        """Numbers of the points whose temperatures are prescribed."""
        return self._model.prescribed

    @property
    def notes(self) -> list[str]:
        """What is remarkable about the case."""
        return self._model.notes

    @property
    def start(self) -> Floats:
        """u at t = 0, with the walls at the temperatures that are prescribed, (n,)."""
        return self._model.start

    @property
    def weights(self) -> Any:
        """Conduction between the points with 1 W/(m K) everywhere, csr_matrix, m: the heat that flows into the cells, W, is
        weights @ u. docs/core.md says what an entry is in each method."""
        return self._matrix(self._model.weights())

    @property
    def shape_functions(self) -> Any:
        """Phi in T = Phi u, csr_matrix; the identity where u are temperatures."""
        return self._matrix(self._model.shape_functions())

    def temperatures(self, u: ArrayLike) -> Floats:
        """Temperatures of the points, K, of degrees of freedom."""
        return self._model.temperatures(u)

    def dofs(self, T: ArrayLike) -> Floats:
        """Degrees of freedom with these temperatures of the points, K."""
        return self._model.dofs(T)

    def conductivity(self, T: ArrayLike, t: float = 0) -> Floats:
        """Of the points at temperatures T, K, and time t, s; W/(m K)."""
        return self._model.conductivity(T, t)

    def heat_capacity(self, T: ArrayLike) -> Floats:
        """Per volume, of the points at temperatures T, K; J/(m^3 K). 1 in a steady case without density or specific heat."""
        return self._model.heat_capacity(T)

    def energy(self, u: ArrayLike) -> Floats:
        """E, enthalpies of the cells, J, above a temperature that differs from case to case."""
        return self._model.energy(u)

    def capacity(self, u: ArrayLike) -> Floats:
        """Heat capacities of the cells, J/K."""
        return self._model.capacity(u)

    def rate(self, u: ArrayLike, t: float = 0) -> Floats:
        """F in dE/dt = F: heat that flows into the cells by conduction, surface fluxes and sources, W. Points with a
        prescribed temperature have it without what holds them there."""
        return self._model.rate(u, t)

    def residual(self, u: ArrayLike, t: float = 0, *, rate_factor: float = 1, known: ArrayLike | None = None) -> Floats:
        """R = E(u) - known - rate_factor F(t, u), or without `known`, J, R = -rate_factor F; at points with a prescribed
        temperature R = T - T_prescribed(t), K. Where it is 0 for rate_factor = 1 the state is steady, and for rate_factor = dt
        and known = E of the step before it is a step of backward Euler."""
        return self._model.residual(u, t, rate_factor, known)

    def jacobian(self, u: ArrayLike, t: float = 0, *, rate_factor: float = 1, capacity_factor: float = 0) -> Any:
        """capacity_factor dE/du - rate_factor dF/du, csr_matrix: the derivative of `residual`, with capacity_factor = 1 where
        that has `known`. Degrees of freedom that are prescribed have the row of the identity, and empty columns: their step
        is known before the others'."""
        return self._matrix(self._model.jacobian(u, t, capacity_factor, rate_factor))

    def heat_flux(self, u: ArrayLike, t: float = 0) -> Floats:
        """Vectors of the heat flux at the points, (n, 3), W/m^2."""
        return self._model.heat_flux(u, t)

    def heat_flows(self, u: ArrayLike, t: float = 0) -> dict[str, float]:
        """Heat that flows into the body, W, by every section of [boundary.*] and [source.*]."""
        return dict(zip(self._model.accounts, self._model.heat_flows(u, t)))

    def solve(self) -> Floats:
        """Temperatures of the steady state of a case with [steady], K."""
        return self._model.solve()

    def march(self, times: Sequence[float] | Floats) -> Floats:
        """Temperatures at times that ascend, s, from t = 0 in a case with [time], (times, n) in K."""
        return self._model.march([float(t) for t in times])

    def __repr__(self) -> str:
        return f"<Model of {len(self)} points in {self.dimension}D, {', '.join(dict.fromkeys(self.parts))}>"


def run(case: CaseLike | Case, changes: Mapping[str, Any] | None = None, folder: str | os.PathLike[str] | None = None, *,
        variant: str | None = None, functions: Mapping[str, Law] | None = None, **keys: Any) -> Result:
    """Runs a case in this process, with functions of Python as in Model, into `folder` (default: results/NAME)."""
    words = _Words(case, changes, variant, functions, keys)
    into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / words.case.name
    with words.read() as (path, overrides, laws):
        _core.run(path, overrides, laws, str(into))
    return Result(into)


class Material:
    """A material of the library: its properties as functions of temperature. What lies outside of `range` is no more than the
    law or the last value of a table goes on to say."""

    def __init__(self, name: str) -> None:
        self._material = _core.Material(name)
        self.name = name
        self.range: tuple[float, float] = self._material.range
        """Lowest and highest temperature for which the values are good, K."""
        self.sources: dict[str, str] = self._material.sources
        """Where every property comes from."""
        self.melting: tuple[float, float, float] | None = self._material.melting
        """Heat of melting, J/kg, and the temperatures between which it is taken up, K; None: it is not known to melt."""

    def conductivity(self, T: ArrayLike) -> Floats:
        """W/(m K) at temperatures in K, in an array of the same shape."""
        return self._material.conductivity(T)

    def density(self, T: ArrayLike) -> Floats:
        """kg/m^3"""
        return self._material.density(T)

    def specific_heat(self, T: ArrayLike) -> Floats:
        """J/(kg K)"""
        return self._material.specific_heat(T)

    def __repr__(self) -> str:
        return f"<Material {self.name}, {self.range[0]:g} to {self.range[1]:g} K>"


def materials() -> list[str]:
    """Names of the materials of the library."""
    return _core.material_names()


def material(name: str) -> Material:
    """The material of that name in the library. Raises CommandError."""
    if name not in materials():
        raise CommandError(f"the library has no material '{name}': it has {', '.join(materials())}")
    return Material(name)
