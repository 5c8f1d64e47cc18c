# `cpack -G DEB` writes calor, libcalor-dev, python3-calor and calor-doc; ./dev packages builds them as they are shipped.
if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  return()  # Debian packages are built for /usr, the preset `package`
endif()

set(packages calor libcalor-dev python3-calor calor-doc)
set(component_of_calor calor)
set(component_of_libcalor-dev dev)
set(component_of_python3-calor python)
set(component_of_calor-doc doc)

# Debian wants a changelog of its own form and a copyright file in every package.
file(STRINGS CITATION.cff released REGEX "^date-released: ")
string(REPLACE "date-released: " "" released "${released}")
execute_process(COMMAND date -R -u -d "${released}" OUTPUT_VARIABLE RELEASE_DATE OUTPUT_STRIP_TRAILING_WHITESPACE
                COMMAND_ERROR_IS_FATAL ANY)
# As Debian's own tools have it, DEBFULLNAME and DEBEMAIL in the environment say who makes the packages.
set(maintainer "The calor developers")
set(address root@localhost)
if(DEFINED ENV{DEBFULLNAME})
  set(maintainer $ENV{DEBFULLNAME})
endif()
if(DEFINED ENV{DEBEMAIL})
  set(address $ENV{DEBEMAIL})
endif()
set(CALOR_MAINTAINER "${maintainer} <${address}>")
configure_file(packaging/debian/changelog.in debian/changelog @ONLY)
compress(${CMAKE_BINARY_DIR}/debian/changelog)
foreach(package ${packages})
  install(FILES ${CMAKE_BINARY_DIR}/debian/changelog.gz packaging/debian/copyright
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component_of_${package}})
endforeach()

# The manual: the site where ./dev site has built it, and the example that embeds the library.
install(DIRECTORY build/site/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/calor-doc/html COMPONENT doc OPTIONAL
        PATTERN sitemap.xml.gz EXCLUDE)
install(DIRECTORY examples docs/notebooks DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/calor-doc COMPONENT doc)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "${CALOR_MAINTAINER}")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL calor dev python doc)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # every package has a summary of its own, the first line of its description
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_CALOR_PACKAGE_NAME calor)
set(CPACK_DEBIAN_CALOR_PACKAGE_SECTION science)
set(CPACK_DEBIAN_CALOR_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_CALOR_PACKAGE_DEPENDS openmpi-bin)
set(CPACK_DEBIAN_CALOR_PACKAGE_RECOMMENDS python3-calor)
set(CPACK_DEBIAN_CALOR_PACKAGE_SUGGESTS "calor-doc, gmsh")
set(CPACK_DEBIAN_CALOR_DESCRIPTION "meshless heat conduction (command)
calor computes temperatures in solids without a mesh, by smoothed particle
hydrodynamics, bond-based peridynamics or the meshless local Petrov-Galerkin
method: steady and transient, linear and nonlinear, in one, two and three
dimensions, on one processor or many. A case is a text file with units.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libcalor-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "libpetsc-real-dev, libopenmpi-dev, libhdf5-mpi-dev, libmuparser-dev, libudunits2-dev, libfmt-dev, libspdlog-dev, libxxhash-dev, zlib1g-dev, pkg-config")
set(CPACK_DEBIAN_DEV_DESCRIPTION "meshless heat conduction (library)
The library that the command calor is made of, with its headers and the CMake
package calor, for programs that compute temperatures themselves or add
methods, materials and sources to the command.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-calor)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/packaging/debian/postinst
                                              ${CMAKE_SOURCE_DIR}/packaging/debian/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(needed_by_python "calor (>= ${PROJECT_VERSION}), python3 (>= 3.11), python3-numpy")
if(TARGET core)  # which is for one version of Python
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  string(APPEND needed_by_python ", python3 (<< ${Python_VERSION_MAJOR}.${next})")
else()
  set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${needed_by_python}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-matplotlib, python3-scipy, python3-vtk9, python3-h5py")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pandas, python3-openturns, ffmpeg")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "meshless heat conduction (Python)
Cases, runs and results of calor in Python, and what the command calor draws
pictures and writes reports, fits and studies with; and calor.core, the library
in the process of Python: weights, Jacobians and laws written in Python.")

set(CPACK_DEBIAN_DOC_PACKAGE_NAME calor-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_DESCRIPTION "meshless heat conduction (documentation)
Tutorials, how-to pages, theory, verification and the manual of case files of
calor, and a program that embeds its library.")
include(CPack)
