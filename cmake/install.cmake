# What `cmake --install` gives: the command and its manual page, the library with its headers, the package that
# find_package(calor) finds, the cases, and the Python package, which the command starts for pictures.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/calor)

configure_file(docs/calor.1.in calor.1 @ONLY)
write_basic_package_version_file(calor-config-version.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS calor)
install(TARGETS calor_lib EXPORT calor FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/calor)
install(EXPORT calor NAMESPACE calor:: FILE calor-targets.cmake DESTINATION ${package_folder})
install(FILES cmake/calor-config.cmake cmake/dependencies.cmake ${CMAKE_BINARY_DIR}/calor-config-version.cmake
        DESTINATION ${package_folder})
install(FILES ${CMAKE_BINARY_DIR}/calor.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES cmake/calor-completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME calor)
install(DIRECTORY cases DESTINATION ${CMAKE_INSTALL_DATADIR}/calor PATTERN __pycache__ EXCLUDE)
install(DIRECTORY python DESTINATION ${CMAKE_INSTALL_DATADIR}/calor PATTERN __pycache__ EXCLUDE)
