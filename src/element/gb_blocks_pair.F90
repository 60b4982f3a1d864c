!> Blocks of five unknowns, two at a time: the ends of one chain of nodes, eliminated towards its middle.
module gb_blocks_pair
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_lanes, only: width => pair
    implicit none
    private

#include "gb_blocks.inc"

end module gb_blocks_pair
