# The lane kernels (src/element/gb_lanes.F90): how many elements or beams go side by side, and how these files
# are compiled. AUTO takes what fills one vector register of the processor that GENTBEAM_MARCH names; of
# AVX-512 half a register: eight members of a study take as long a member as four (its 32 registers are what
# helps), and single beams of 10 elements, which do not fill eight lanes, a tenth less.
set(GENTBEAM_LANES "AUTO" CACHE STRING "Elements side by side in the lane kernels: AUTO, 1, 2, 4, 8 or 16")
set_property(CACHE GENTBEAM_LANES PROPERTY STRINGS AUTO 1 2 4 8 16)

set(march)
if(NOT GENTBEAM_MARCH STREQUAL "portable")
    set(march -march=${GENTBEAM_MARCH})
endif()
execute_process(COMMAND ${CMAKE_C_COMPILER} ${march} -dM -E -x c /dev/null
    OUTPUT_VARIABLE macros ERROR_QUIET)
if(macros MATCHES "__AVX512F__")
    set(register_reals 8)
elseif(macros MATCHES "__AVX__" OR macros MATCHES "__ARM_FEATURE_SVE ")
    set(register_reals 4)
elseif(macros MATCHES "__SSE2__|__ARM_NEON|__VSX__")
    set(register_reals 2)
else()
    set(register_reals 1)
endif()
set(lanes ${GENTBEAM_LANES})
if(lanes STREQUAL "AUTO")
    set(lanes ${register_reals})
    if(lanes GREATER 4)
        set(lanes 4)
    endif()
elseif(NOT lanes MATCHES "^(1|2|4|8|16)$")
    message(FATAL_ERROR "GENTBEAM_LANES is ${lanes}; it must be AUTO, 1, 2, 4, 8 or 16")
endif()
message(STATUS "Lane kernels: ${lanes} lanes")

# gfortran 12 peels short loops to scalars before it vectorises them; with these options every loop over lanes
# becomes one vector instruction a statement. Two passes keep numbers in registers from one statement to
# others far away, more of them than there are registers, which costs stores and loads: off with them. Kernels
# begin with a line of the cache, so that what one costs depends less on the code before it (up to 4 %).
set(lane_options)
if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
    set(lane_options -ftree-vectorize -fvect-cost-model=dynamic -fno-tree-loop-distribute-patterns
        --param=max-completely-peel-times=1 -fno-gcse -fno-tree-ter -falign-functions=64)
    if(register_reals EQUAL 8 AND NOT lanes LESS 8)
        list(APPEND lane_options -mprefer-vector-width=512)
    endif()
endif()

# gentbeam_use_lanes(FILE...): sources that hold loops over lanes.
function(gentbeam_use_lanes)
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS ${lane_options})
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_DEFINITIONS GENTBEAM_LANES=${lanes})
endfunction()

# gentbeam_chain_options(FILE...): what goes along a single beam between its lane kernels. Choices between two
# numbers may be made without a branch there; the sign of a zero, and traps, decide nothing. (Debug builds
# trap.)
function(gentbeam_chain_options)
    if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
        set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS
            $<$<NOT:$<CONFIG:Debug>>:-fno-signed-zeros> $<$<NOT:$<CONFIG:Debug>>:-fno-trapping-math>)
    endif()
endfunction()
