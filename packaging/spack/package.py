# Copyright 2026 The calor developers
# SPDX-License-Identifier: Apache-2.0
"""Spack recipe, for a checkout: `spack dev-build -d . calor@0.1.0` in a repository of recipes that holds this folder as
packages/calor."""
from spack.package import *


class Calor(CMakePackage):
    """Meshless heat conduction: smoothed particle hydrodynamics, bond-based peridynamics and MLPG on one cloud of
    points."""

    license("Apache-2.0")

    version("0.1.0")

    variant("native", default=False, description="Compile for this machine's processor alone")

    depends_on("cxx", type="build")
    depends_on("cmake@3.24:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("petsc@3.18: +mpi ~complex +double ~int64")
    depends_on("hdf5 +mpi")
    depends_on("muparser")
    depends_on("udunits")
    depends_on("fmt")
    depends_on("spdlog +fmt_external")
    depends_on("xxhash")
    depends_on("zlib-api")
    depends_on("eigen@3.4:", type="build")
    depends_on("cli11", type="build")
    depends_on("nlohmann-json@3.11:", type="build")
    depends_on("nanoflann", type="build")
    depends_on("tomlplusplus", type="build")
    depends_on("python@3.11:", type="run")
    depends_on("py-numpy", type="run")
    depends_on("py-scipy", type="run")
    depends_on("py-matplotlib", type="run")

    def cmake_args(self):
        return [self.define("CALOR_TESTS", False), self.define_from_variant("CALOR_NATIVE", "native")]
