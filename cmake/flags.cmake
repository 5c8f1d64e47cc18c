# Flags of everything that is built here.
add_library(flags INTERFACE)
# g++ 12 warns of its own AVX-512 headers (GCC bug 105593).
target_compile_options(flags INTERFACE -Wall -Wextra $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized\;-Wno-uninitialized>)
# Nobody replaces calor's functions when a program starts: calls among them need no detour.
target_compile_options(flags INTERFACE -fno-semantic-interposition)
target_compile_definitions(flags INTERFACE OMPI_SKIP_MPICXX)
if(CALOR_NATIVE)
  include(CheckCXXCompilerFlag)
  check_cxx_compiler_flag(-march=native CALOR_HAS_NATIVE)
  if(CALOR_HAS_NATIVE)
    target_compile_options(flags INTERFACE -march=native)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    # Vector gathers are slower than scalar loads on many x86 processors: the k(T) loop runs 2.5 times faster without.
    set(no_gather -mtune-ctrl=^use_gather,^use_gather_4parts,^use_gather_2parts)
    check_cxx_compiler_flag(${no_gather} CALOR_HAS_NO_GATHER)
    if(CALOR_HAS_NO_GATHER)
      target_compile_options(flags INTERFACE ${no_gather})
    endif()
  endif()
endif()
if(CALOR_COVERAGE)
  target_compile_options(flags INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(flags INTERFACE --coverage)
endif()
if(CALOR_SANITIZE)
  # At -O0 the tests would take an hour.
  target_compile_options(flags INTERFACE -O1 -fsanitize=address,undefined -fno-sanitize-recover=undefined
                                         -fno-omit-frame-pointer)
  target_link_options(flags INTERFACE -fsanitize=address,undefined)
endif()
if(CALOR_LTO)
  # Two types or functions of one name that differ between files are errors.
  target_compile_options(flags INTERFACE -flto)
  target_link_options(flags INTERFACE -flto=auto -Wodr -Werror=odr -Wlto-type-mismatch -Werror=lto-type-mismatch)
endif()
