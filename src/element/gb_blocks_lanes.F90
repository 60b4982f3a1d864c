!> Blocks of five unknowns, one a lane: members of a sweep, or the middle nodes of several elements.
module gb_blocks_lanes
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_lanes, only: width => lanes
    implicit none
    private

#include "gb_blocks.inc"

end module gb_blocks_lanes
