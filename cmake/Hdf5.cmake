# HDF5, as gentbeam::hdf5. Loading Debian's shared library costs more than a small run does, since it brings
# libcurl, Kerberos, LDAP and thirty more along for reading from the web; the archive links only what is used.
set(GENTBEAM_STATIC_HDF5 "AUTO" CACHE STRING "Link HDF5's archives: ON, OFF, or AUTO (where they are usable)")
set_property(CACHE GENTBEAM_STATIC_HDF5 PROPERTY STRINGS AUTO ON OFF)

find_package(HDF5 REQUIRED COMPONENTS C Fortran)
add_library(gentbeam_hdf5 INTERFACE)
add_library(gentbeam::hdf5 ALIAS gentbeam_hdf5)
target_include_directories(gentbeam_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS})

# Archives beside the shared libraries, and those that HDF5 was built with.
function(find_hdf5_archives result)
    set(folders)
    foreach(library IN LISTS HDF5_LIBRARIES)
        get_filename_component(folder ${library} DIRECTORY)
        list(APPEND folders ${folder})
    endforeach()
    find_library(GENTBEAM_HDF5_FORTRAN_ARCHIVE libhdf5_fortran.a HINTS ${folders} NO_DEFAULT_PATH)
    find_library(GENTBEAM_HDF5_ARCHIVE libhdf5.a HINTS ${folders} NO_DEFAULT_PATH)
    mark_as_advanced(GENTBEAM_HDF5_FORTRAN_ARCHIVE GENTBEAM_HDF5_ARCHIVE)
    set(found ${GENTBEAM_HDF5_FORTRAN_ARCHIVE} ${GENTBEAM_HDF5_ARCHIVE})
    foreach(name sz aec z)
        find_library(GENTBEAM_${name}_LIBRARY NAMES lib${name}.a ${name})
        mark_as_advanced(GENTBEAM_${name}_LIBRARY)
        if(GENTBEAM_${name}_LIBRARY)
            list(APPEND found ${GENTBEAM_${name}_LIBRARY})
        endif()
    endforeach()
    find_package(Threads REQUIRED)
    set(${result} ${found} ${CMAKE_DL_LIBS} m ${CMAKE_THREAD_LIBS_INIT} PARENT_SCOPE)
endfunction()

# What the archive needs depends on how it was built: linking a small program tells.
function(check_hdf5_archives libraries result)
    set(CMAKE_TRY_COMPILE_CONFIGURATION Release)
    try_compile(${result} ${CMAKE_BINARY_DIR}/hdf5_archives ${PROJECT_SOURCE_DIR}/cmake/uses_hdf5.f90
        CMAKE_FLAGS -DINCLUDE_DIRECTORIES=${HDF5_Fortran_INCLUDE_DIRS}
        LINK_LIBRARIES ${libraries})
    set(${result} ${${result}} PARENT_SCOPE)
endfunction()

set(GENTBEAM_HDF5_IS_STATIC OFF)
if(NOT GENTBEAM_STATIC_HDF5 STREQUAL "OFF")
    find_hdf5_archives(archives)
    if(GENTBEAM_HDF5_FORTRAN_ARCHIVE AND GENTBEAM_HDF5_ARCHIVE)
        check_hdf5_archives("${archives}" GENTBEAM_HDF5_IS_STATIC)
    endif()
    if(NOT GENTBEAM_HDF5_IS_STATIC AND GENTBEAM_STATIC_HDF5 STREQUAL "AUTO")
        message(STATUS "HDF5's archives are missing or need more than is here: linking its shared library")
    elseif(NOT GENTBEAM_HDF5_IS_STATIC)
        message(FATAL_ERROR "GENTBEAM_STATIC_HDF5=ON, but HDF5's archives (libhdf5.a, libhdf5_fortran.a) are "
            "missing beside ${HDF5_LIBRARIES} or do not link; AUTO or OFF take the shared library")
    endif()
endif()
if(GENTBEAM_HDF5_IS_STATIC)
    message(STATUS "HDF5 ${HDF5_VERSION}: ${GENTBEAM_HDF5_ARCHIVE}")
    target_link_libraries(gentbeam_hdf5 INTERFACE ${archives})
    set(gentbeam_has_zlib ${GENTBEAM_z_LIBRARY})
else()
    message(STATUS "HDF5 ${HDF5_VERSION}: shared")
    target_link_libraries(gentbeam_hdf5 INTERFACE HDF5::HDF5)
endif()

# zlib has the checksums of the results file; HDF5 brings it along where it is built with it.
if(NOT gentbeam_has_zlib)
    find_package(ZLIB REQUIRED)
    target_link_libraries(gentbeam_hdf5 INTERFACE ZLIB::ZLIB)
endif()
