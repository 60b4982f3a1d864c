# Flags of our own sources, as a target to link with. No -ffast-math: NaN tests keep a run honest (the two
# options of cmake/Lanes.cmake leave them alone).
# gfortran 12 warns wrongly of bounds that a condition guards and of allocatable components on their first
# assignment, and rightly of arguments that a deferred interface asks for and an implementation does not need.
add_library(gentbeam_flags INTERFACE)
set(gnu_fortran "$<COMPILE_LANG_AND_ID:Fortran,GNU>")
target_compile_options(gentbeam_flags INTERFACE
    $<${gnu_fortran}:-std=f2008 -Wall -Wextra -Wimplicit-interface -Wimplicit-procedure>
    $<${gnu_fortran}:-Wno-do-subscript -Wno-maybe-uninitialized -Wno-uninitialized>
    $<${gnu_fortran}:-Wno-unused-dummy-argument>)
# Members of a study run on several threads: no local array may be kept from call to call.
target_compile_options(gentbeam_flags INTERFACE $<${gnu_fortran}:-frecursive>)
if(GENTBEAM_WERROR)
    target_compile_options(gentbeam_flags INTERFACE $<${gnu_fortran}:-Werror>)
endif()
if(NOT GENTBEAM_MARCH STREQUAL "portable")
    target_compile_options(gentbeam_flags INTERFACE $<${gnu_fortran}:-march=${GENTBEAM_MARCH}>)
endif()
set(CMAKE_Fortran_FLAGS_RELEASE "-O2 -ftree-vectorize -fvect-cost-model=dynamic -g1" CACHE STRING "" FORCE)
