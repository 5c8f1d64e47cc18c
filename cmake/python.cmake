# calor.core, the library in a process of Python: built where pybind11 is found (Debian: pybind11-dev, python3-dev), for
# the Python that apt installs for. What goes into build/PRESET/python is found from the source tree.
option(CALOR_CORE "Build calor.core, the library for Python, where pybind11 is found" ON)
if(NOT CALOR_CORE OR CALOR_SANITIZE)  # Python itself would have to be built with the sanitizers
  return()
endif()
if(EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "Python that calor.core is built for")
endif()
find_package(Python 3.11 QUIET COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.10 QUIET CONFIG)
if(NOT pybind11_FOUND OR NOT Python_Development.Module_FOUND)
  message(STATUS "calor.core is left out: it needs pybind11-dev and python3-dev")
  return()
endif()

file(GLOB core_sources CONFIGURE_DEPENDS python/core/*.cpp)
pybind11_add_module(core MODULE NO_EXTRAS ${core_sources})
target_link_libraries(core PRIVATE calor_lib spdlog::spdlog)
set_target_properties(core PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/python)
install(TARGETS core LIBRARY DESTINATION ${CALOR_PYTHON_FOLDER}/calor COMPONENT python OPTIONAL)
