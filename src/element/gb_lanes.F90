!> How many elements or beams the lane kernels carry side by side. Every array of theirs has a leading index
!> of this length, so that one statement of a kernel is one instruction of the processor's vector unit. A
!> build option (GENTBEAM_LANES): 8 fill a register of AVX-512, 4 one of AVX2, 2 one of SSE2 or NEON; 1 is
!> plain scalar code.
module gb_lanes
    implicit none
    private

    integer, parameter, public :: lanes = GENTBEAM_LANES
    integer, parameter, public :: pair = 2          !! the two ends of a chain of nodes

end module gb_lanes
