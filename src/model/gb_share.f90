!> Which part of a study a run has: all of it, or every N-th member.
module gb_share
    use gb_text, only: to_text
    implicit none
    private

    !> The members shard, shard + shards, ... up to `members`.
    type, public :: share_t
        integer :: members = 0                      !! of the whole study
        integer :: shard = 1, shards = 1
    contains
        procedure :: n => members_in_share
        procedure :: number => number_at
        procedure :: position => position_of
    end type share_t

    public :: study_end

contains

    pure integer function members_in_share(self) result(n)
        class(share_t), intent(in) :: self

        n = 0
        if (self%shard <= self%members) n = (self%members - self%shard)/self%shards + 1
    end function members_in_share

    !> Number of the member at a position (1-based) of the share.
    pure integer function number_at(self, position) result(number)
        class(share_t), intent(in) :: self
        integer, intent(in) :: position

        number = self%shard + (position - 1)*self%shards
    end function number_at

    pure integer function position_of(self, number) result(position)
        class(share_t), intent(in) :: self
        integer, intent(in) :: number

        position = (number - self%shard)/self%shards + 1
    end function position_of

    !> How a study ended, for the results file: complete, failed where all its members failed, interrupted
    !> where some are missing; and the counts, for the log too.
    pure subroutine study_end(members, failed, missing, status, counts)
        integer, intent(in) :: members, failed, missing
        character(:), allocatable, intent(out) :: status, counts

        counts = to_text(members - failed - missing) // ' of ' // to_text(members) // ' members complete, ' &
            // to_text(failed) // ' failed'
        status = 'complete'
        if (failed == members .and. members > 0) status = 'failed'
        if (missing > 0) then
            counts = counts // ', ' // to_text(missing) // ' missing'
            status = 'interrupted'
        end if
    end subroutine study_end

end module gb_share
