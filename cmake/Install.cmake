# cmake --install: the program with its manual page and completion, the C library with its header, the core
# library with its Fortran modules, the Python package, and a CMake package for find_package(gentbeam).
include(CMakePackageConfigHelpers)
set(GENTBEAM_PYTHON_DIR "lib/python3/dist-packages" CACHE STRING
    "Where the Python package goes, below the prefix")
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/gentbeam)

install(TARGETS gentbeam gentbeam_library EXPORT gentbeamTargets
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT gentbeamTargets NAMESPACE gentbeam:: DESTINATION ${package_dir})
install(FILES include/gentbeam.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

install(TARGETS gentbeam_core EXPORT gentbeamFortranTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT gentbeamFortranTargets NAMESPACE gentbeam:: DESTINATION ${package_dir})
install(DIRECTORY ${CMAKE_BINARY_DIR}/modules/core/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gentbeam
    FILES_MATCHING PATTERN "*.mod")

configure_package_config_file(cmake/gentbeamConfig.cmake.in gentbeamConfig.cmake
    INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(gentbeamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gentbeamConfig.cmake
    ${CMAKE_CURRENT_BINARY_DIR}/gentbeamConfigVersion.cmake DESTINATION ${package_dir})

# The program writes its own manual page and completion.
add_custom_command(OUTPUT ${CMAKE_BINARY_DIR}/gentbeam.1 ${CMAKE_BINARY_DIR}/gentbeam.bash
    COMMAND gentbeam --man > ${CMAKE_BINARY_DIR}/gentbeam.1
    COMMAND gentbeam --completion > ${CMAKE_BINARY_DIR}/gentbeam.bash
    DEPENDS gentbeam VERBATIM)
add_custom_target(gentbeam_manual ALL
    DEPENDS ${CMAKE_BINARY_DIR}/gentbeam.1 ${CMAKE_BINARY_DIR}/gentbeam.bash)
install(FILES ${CMAKE_BINARY_DIR}/gentbeam.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${CMAKE_BINARY_DIR}/gentbeam.bash RENAME gentbeam
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)

install(DIRECTORY python/gentbeam DESTINATION ${GENTBEAM_PYTHON_DIR} FILES_MATCHING PATTERN "*.py")
install(DIRECTORY input/ DESTINATION ${CMAKE_INSTALL_DATADIR}/gentbeam/input
    FILES_MATCHING PATTERN "*.inp" PATTERN "*.csv")
install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN "*.md"
    PATTERN "pictures/*.png" PATTERN "pictures/*.gif")
