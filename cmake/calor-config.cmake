# find_package(calor): the library as calor::calor, with what it stands on.
include(${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/calor-targets.cmake)
