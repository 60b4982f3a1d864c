# BLAS and LAPACK, as LAPACK::LAPACK. The bands of a beam are narrow: the reference library is faster on
# them than OpenBLAS, whose threads also cost CPU time from the moment it is loaded (docs/performance.md).
# BLA_VENDOR chooses another one, as in any CMake project. On Debian the plain libblas.a is whichever the
# administrator prefers; the reference archives have folders of their own.
set(multiarch /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE})
find_library(GENTBEAM_REFERENCE_LAPACK liblapack.a PATHS ${multiarch}/lapack NO_DEFAULT_PATH)
find_library(GENTBEAM_REFERENCE_BLAS libblas.a PATHS ${multiarch}/blas NO_DEFAULT_PATH)
mark_as_advanced(GENTBEAM_REFERENCE_LAPACK GENTBEAM_REFERENCE_BLAS)
if(NOT BLA_VENDOR AND GENTBEAM_REFERENCE_LAPACK AND GENTBEAM_REFERENCE_BLAS)
    add_library(LAPACK::LAPACK INTERFACE IMPORTED)
    target_link_libraries(LAPACK::LAPACK INTERFACE ${GENTBEAM_REFERENCE_LAPACK} ${GENTBEAM_REFERENCE_BLAS})
    message(STATUS "LAPACK: the reference archives in ${multiarch}")
else()
    find_package(LAPACK REQUIRED)
    message(STATUS "LAPACK: ${LAPACK_LIBRARIES}")
endif()

# Where it is OpenBLAS all the same, the program keeps it to one thread. Asked anew each time, since
# BLA_VENDOR may have changed.
unset(GENTBEAM_HAS_OPENBLAS CACHE)
set(CMAKE_REQUIRED_LIBRARIES LAPACK::LAPACK gfortran)
check_function_exists(openblas_set_num_threads GENTBEAM_HAS_OPENBLAS)
unset(CMAKE_REQUIRED_LIBRARIES)
