!> Cutting a step in halves where Newton's method fails, and growing back: an interval is walked through in
!> 2^level equal parts, so that its end is always met exactly.
module gb_substeps
    use gb_kinds, only: wp
    use gb_memory, only: memory_t
    implicit none
    private

    type, public :: substeps_t
        integer :: max_level = 10       !! halvings allowed
        integer :: level = 0            !! kept from one interval to the next
        integer :: least_level = 0      !! halvings that a stability limit asks for
        integer :: done = 0             !! parts of 2^level that are behind
    contains
        procedure :: begin_interval
        procedure :: refine
        procedure :: next_end
        procedure :: accept
        procedure :: reject
        procedure :: is_finished
        procedure :: pass_memory
    end type substeps_t

contains

    pure subroutine begin_interval(self)
        class(substeps_t), intent(inout) :: self

        self%done = 0
        self%least_level = 0
    end subroutine begin_interval

    !> Let the interval be cut in at least so many equal parts, whatever is behind (up to one halving more
    !> than is allowed, which tells that it is not enough).
    pure subroutine refine(self, least_parts)
        class(substeps_t), intent(inout) :: self
        real(wp), intent(in) :: least_parts

        self%least_level = 0
        do while (2.0_wp**self%least_level < least_parts .and. self%least_level <= self%max_level)
            self%least_level = self%least_level + 1
        end do
        do while (self%level < self%least_level)
            self%level = self%level + 1
            self%done = 2*self%done
        end do
    end subroutine refine

    !> Where the next part ends, as a part of the interval, 0 < next_end <= 1 (exact in binary arithmetic).
    pure real(wp) function next_end(self)
        class(substeps_t), intent(in) :: self

        next_end = real(self%done + 1, wp)/2.0_wp**self%level
    end function next_end

    !> The part is solved; two halves in a row join again.
    pure subroutine accept(self)
        class(substeps_t), intent(inout) :: self

        self%done = self%done + 1
        if (self%level > self%least_level .and. modulo(self%done, 2) == 0) then
            self%level = self%level - 1
            self%done = self%done/2
        end if
    end subroutine accept

    !> The part failed: halve it. `exhausted` when no halving is left.
    pure subroutine reject(self, exhausted)
        class(substeps_t), intent(inout) :: self
        logical, intent(out) :: exhausted

        exhausted = self%level >= self%max_level
        if (exhausted) return
        self%level = self%level + 1
        self%done = 2*self%done
    end subroutine reject

    pure logical function is_finished(self)
        class(substeps_t), intent(in) :: self

        is_finished = self%done >= 2**self%level
    end function is_finished

    !> What one interval leaves to the next.
    subroutine pass_memory(self, memory)
        class(substeps_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory

        call memory%pass('parts.level', self%level)
    end subroutine pass_memory

end module gb_substeps
