!> The members of a study: which values of which parameters each of them has. Nothing is stored for a member:
!> the values follow from its number, so that a million of them cost no more than the tables they come from.
module gb_sweep
    use gb_kinds, only: wp, i8
    use gb_names, only: max_name
    implicit none
    private

    !> One SWEEP: some parameters that vary together, row by row.
    type, public :: factor_t
        character(max_name), allocatable :: names(:)      !! (np) as the deck writes them
        real(wp), allocatable :: values(:, :)       !! (np, rows)
        character(:), allocatable :: file           !! path of the table they were read from
    end type factor_t

    !> All SWEEPs of a deck. They cross: the last one varies fastest.
    type, public :: sweep_t
        type(factor_t), allocatable :: factors(:)   !! unallocated where the deck has no SWEEP
    contains
        procedure :: add => add_factor
        procedure :: members
        procedure :: n_parameters
        procedure :: names => parameter_names
        procedure :: values => member_values
    end type sweep_t

    !> More members than this are a mistake.
    integer(i8), parameter, public :: most_members = 10000000_i8

contains

    pure subroutine add_factor(self, factor)
        class(sweep_t), intent(inout) :: self
        type(factor_t), intent(in) :: factor
        type(factor_t), allocatable :: grown(:)
        integer :: i, n

        n = 0
        if (allocated(self%factors)) n = size(self%factors)
        allocate (grown(n + 1))
        do i = 1, n
            call move_alloc(self%factors(i)%names, grown(i)%names)
            call move_alloc(self%factors(i)%values, grown(i)%values)
        end do
        grown(n + 1) = factor
        call move_alloc(grown, self%factors)
    end subroutine add_factor

    !> Number of members; 0 where the deck has no SWEEP. Beyond `most_members` the number only tells that
    !> there are too many.
    pure integer(i8) function members(self)
        class(sweep_t), intent(in) :: self
        integer :: i

        members = 0
        if (.not. allocated(self%factors)) return
        members = 1
        do i = 1, size(self%factors)
            members = min(members, most_members + 1)*size(self%factors(i)%values, 2, kind=i8)
        end do
    end function members

    pure integer function n_parameters(self)
        class(sweep_t), intent(in) :: self
        integer :: i

        n_parameters = 0
        if (.not. allocated(self%factors)) return
        do i = 1, size(self%factors)
            n_parameters = n_parameters + size(self%factors(i)%names)
        end do
    end function n_parameters

    !> Names of the parameters that vary, in the deck's order.
    pure function parameter_names(self) result(names)
        class(sweep_t), intent(in) :: self
        character(max_name), allocatable :: names(:)
        integer :: i, n

        allocate (names(self%n_parameters()))
        if (size(names) == 0) return
        n = 0
        do i = 1, size(self%factors)
            names(n + 1:n + size(self%factors(i)%names)) = self%factors(i)%names
            n = n + size(self%factors(i)%names)
        end do
    end function parameter_names

    !> The parameters' values of member `number` (1-based).
    pure function member_values(self, number) result(values)
        class(sweep_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp) :: values(self%n_parameters())
        integer :: i, n, rest, rows

        rest = number - 1
        n = size(values)
        do i = size(self%factors), 1, -1
            associate (factor => self%factors(i))
                rows = size(factor%values, 2)
                values(n - size(factor%names) + 1:n) = factor%values(:, modulo(rest, rows) + 1)
                n = n - size(factor%names)
            end associate
            rest = rest/rows
        end do
    end function member_values

end module gb_sweep
