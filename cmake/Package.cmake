# cpack: a Debian package that apt installs with what it needs. Build it from the preset `portable`: a package
# for this very processor says so in its version.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME gentbeam)
set(CPACK_PACKAGE_VENDOR "The gentbeam developers")
set(CPACK_PACKAGE_CONTACT "The gentbeam developers <gentbeam@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Large, fast motions of soft hyperelastic beams")
set(CPACK_PACKAGE_DESCRIPTION "Finite elements for plane beams of Gent material: statics, natural modes
and implicit dynamics at large strains and rotations, from one text file to HDF5 results. With a
library for C, C++ and Python.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
if(NOT GENTBEAM_MARCH STREQUAL "portable")
    set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}+${GENTBEAM_MARCH}")
endif()
include(CPack)
