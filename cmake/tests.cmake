# Tests: ctest finds every GoogleTest by its name; suites whose name ends in `Parallel` run on 2, 3 and 4 ranks too.
find_package(GTest REQUIRED)
find_package(rapidcheck REQUIRED)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
include(GoogleTest)

file(GLOB unit_sources CONFIGURE_DEPENDS tests/unit/*.cpp tests/verify/*.cpp)
add_executable(unit_tests ${unit_sources})
target_compile_definitions(unit_tests PRIVATE CALOR_SOURCE_DIR="${CMAKE_SOURCE_DIR}"
                                              CALOR_COMMAND="$<TARGET_FILE:calor>")
add_dependencies(unit_tests calor)
target_link_libraries(unit_tests PRIVATE calor_lib Eigen3::Eigen fmt::fmt GTest::gtest rapidcheck PkgConfig::UDUNITS
                                         ZLIB::ZLIB)
# Compiled rather than run for long: what they test is optimised elsewhere.
target_compile_options(unit_tests PRIVATE $<$<CONFIG:Release>:-O1>)
target_precompile_headers(unit_tests PRIVATE tests/unit/case_models.hpp <gtest/gtest.h> <fmt/format.h> <numbers> <numeric>)
# A process each costs 0.2 s to start MPI and PETSc, together 100 s on two cores, and names what fails. Found when ctest
# runs, because a build with sanitizers has to be told first that MPI leaks (./dev sanitize).
gtest_discover_tests(unit_tests DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60)

# Plug-ins, which docs/extending.md quotes: a program of their own, as they add to the registries.
file(GLOB plugin_sources CONFIGURE_DEPENDS tests/plugins/*.cpp)
add_executable(plugin_tests ${plugin_sources} tests/unit/main.cpp)
target_compile_definitions(plugin_tests PRIVATE CALOR_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
target_link_libraries(plugin_tests PRIVATE calor_lib GTest::gtest)
gtest_discover_tests(plugin_tests DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60)

set(tests ${CMAKE_SOURCE_DIR}/tests)
set(python ${Python3_EXECUTABLE} -B)
foreach(ranks 2 3 4)
  add_test(NAME unit_on_${ranks}_ranks
           COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} $<TARGET_FILE:unit_tests>
                   --gtest_filter=*Parallel.*)
endforeach()
add_test(NAME cases_on_ranks COMMAND ${python} ${tests}/ranks/run.py $<TARGET_FILE:calor> 2,3)
add_test(NAME bad_cases COMMAND ${python} ${tests}/bad_cases/run.py $<TARGET_FILE:calor>)
add_test(NAME contract COMMAND ${python} ${tests}/contract/run.py $<TARGET_FILE:calor>)
add_test(NAME kills COMMAND ${python} ${tests}/kills/run.py $<TARGET_FILE:calor>)
add_test(NAME files COMMAND ${tests}/files/run.py $<TARGET_FILE:calor>)
add_test(NAME python COMMAND ${tests}/python/run.py $<TARGET_FILE:calor>)
add_test(NAME core COMMAND ${tests}/python/core.py $<TARGET_FILE:calor>)
add_test(NAME schema COMMAND ${tests}/schema/run.py $<TARGET_FILE:calor>)
add_test(NAME memory COMMAND ${python} ${tests}/memory/run.py $<TARGET_FILE:unit_tests> $<TARGET_FILE:calor>)
set_tests_properties(files python core schema memory PROPERTIES SKIP_RETURN_CODE 77)
add_test(NAME tutorials COMMAND ${tests}/docs/run.py $<TARGET_FILE:calor>)
add_test(NAME poses COMMAND ${python} ${tests}/poses/run.py $<TARGET_FILE:calor>)
add_test(NAME verify COMMAND calor verify cases WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
add_test(NAME embedding COMMAND ${python} ${tests}/embedding/run.py ${CMAKE_COMMAND} ${CMAKE_BINARY_DIR})
add_test(NAME include_order COMMAND ${python} ${tests}/architecture/include_order.py)
add_test(NAME version COMMAND ${python} ${tests}/architecture/version.py)

# Seconds: the long ones begin first, so that none is left alone at the end.
set_tests_properties(poses PROPERTIES COST 220)
set_tests_properties(memory PROPERTIES COST 170)
set_tests_properties(verify python PROPERTIES COST 100)
set_tests_properties(bad_cases contract tutorials PROPERTIES COST 60)

# Open MPI: allowed as root, more ranks than cores, no spinning on a busy machine.
# Ranks that disagree on where they are say so.
set(with_ranks unit_on_2_ranks unit_on_3_ranks unit_on_4_ranks cases_on_ranks)
set_tests_properties(${with_ranks} bad_cases contract kills files python core tutorials verify embedding memory PROPERTIES ENVIRONMENT
  "CALOR_CHECK_COLLECTIVES=1;OMPI_ALLOW_RUN_AS_ROOT=1;OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1;OMPI_MCA_rmaps_base_oversubscribe=1;OMPI_MCA_mpi_yield_when_idle=1;OMPI_MCA_hwloc_base_binding_policy=none")
set_tests_properties(${with_ranks} PROPERTIES PROCESSORS 2)
