# What calor stands on; programs that embed the installed library find the same.
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS CXX)  # pkg-config PETSc names no MPI include path
pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET PETSc>=3.18)
pkg_check_modules(MUPARSER REQUIRED IMPORTED_TARGET muparser)
pkg_search_module(HDF5 REQUIRED IMPORTED_TARGET hdf5-openmpi hdf5-mpich hdf5)  # the one that PETSc uses
pkg_check_modules(UDUNITS REQUIRED IMPORTED_TARGET udunits)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(ZLIB REQUIRED)
