# Flags of our own sources, as a target to link with. No -ffast-math of any kind: NaN tests keep a run honest.
add_library(gentbeam_flags INTERFACE)
target_compile_options(gentbeam_flags INTERFACE
    $<$<COMPILE_LANG_AND_ID:Fortran,GNU>:-std=f2008 -Wall -Wextra -Wimplicit-interface -Wimplicit-procedure
        # gfortran 12 warns wrongly of bounds guarded by a condition and of allocatable components on their first
        # assignment, and of arguments that a deferred interface asks for.
        -Wno-do-subscript -Wno-maybe-uninitialized -Wno-uninitialized -Wno-unused-dummy-argument>)
if(GENTBEAM_WERROR)
    target_compile_options(gentbeam_flags INTERFACE $<$<COMPILE_LANG_AND_ID:Fortran,GNU>:-Werror>)
endif()
if(NOT GENTBEAM_MARCH STREQUAL "portable")
    target_compile_options(gentbeam_flags INTERFACE $<$<COMPILE_LANG_AND_ID:Fortran,GNU>:-march=${GENTBEAM_MARCH}>)
endif()
set(CMAKE_Fortran_FLAGS_RELEASE "-O2 -g1" CACHE STRING "" FORCE)
