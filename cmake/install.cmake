# What `cmake --install` gives: the command and its manual page, the library with its headers, the package that
# find_package(calor) finds, the cases, and the Python package, which the command starts for pictures. The components
# are the Debian packages of packages.cmake.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/calor)
set(CALOR_PYTHON_FOLDER ${CMAKE_INSTALL_DATADIR}/calor/python CACHE STRING "Where the Python package goes")

# compress(FILE): FILE.gz, the same bytes at every time.
function(compress file)
  execute_process(COMMAND gzip -9nkf ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

configure_file(docs/calor.1.in calor.1 @ONLY)
compress(${CMAKE_BINARY_DIR}/calor.1)
write_basic_package_version_file(calor-config-version.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS calor COMPONENT calor)
install(TARGETS calor_lib EXPORT calor COMPONENT dev FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/calor
        COMPONENT dev)
install(EXPORT calor NAMESPACE calor:: FILE calor-targets.cmake DESTINATION ${package_folder} COMPONENT dev)
install(FILES cmake/calor-config.cmake cmake/dependencies.cmake ${CMAKE_BINARY_DIR}/calor-config-version.cmake
        DESTINATION ${package_folder} COMPONENT dev)
install(FILES ${CMAKE_BINARY_DIR}/calor.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT calor)
install(FILES cmake/calor-completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME calor
        COMPONENT calor)
install(DIRECTORY cases DESTINATION ${CMAKE_INSTALL_DATADIR}/calor COMPONENT calor PATTERN __pycache__ EXCLUDE)
install(DIRECTORY python/calor DESTINATION ${CALOR_PYTHON_FOLDER} COMPONENT python PATTERN __pycache__ EXCLUDE)
