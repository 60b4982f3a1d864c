# cmake --install: the program, the core library with its Fortran modules, and a CMake package.
include(CMakePackageConfigHelpers)
install(TARGETS gentbeam gentbeam_core EXPORT gentbeamTargets
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${CMAKE_BINARY_DIR}/modules/core/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gentbeam
    FILES_MATCHING PATTERN "*.mod")
install(EXPORT gentbeamTargets NAMESPACE gentbeam:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gentbeam)
configure_package_config_file(cmake/gentbeamConfig.cmake.in gentbeamConfig.cmake
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gentbeam)
write_basic_package_version_file(gentbeamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gentbeamConfig.cmake
    ${CMAKE_CURRENT_BINARY_DIR}/gentbeamConfigVersion.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gentbeam)
install(DIRECTORY input/ DESTINATION ${CMAKE_INSTALL_DATADIR}/gentbeam/input
    FILES_MATCHING PATTERN "*.inp" PATTERN "*.csv")
