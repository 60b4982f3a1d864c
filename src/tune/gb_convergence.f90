!> What a ladder of finer and finer trials tells about the error that is left: observed order, errors of the
!> trials, and of sizes in between and a little beyond.
module gb_convergence
    use gb_kinds, only: wp
    implicit none
    private

    !> One direction of refinement: levels of growing size.
    type, public :: axis_t
        !> Orders that are believed: what lies beyond is taken for luck, or for levels too coarse to show it.
        real(wp) :: lowest_order = 1.0_wp, highest_order = 2.0_wp
        real(wp) :: first_order = 1.0_wp            !! that one difference alone is taken to shrink with
        !> From this order on, two differences are enough to go beyond the last level, and from the second one
        !> on three. With more, any order is enough: what so many have shown is not luck.
        real(wp) :: regular_order = 1.6_wp, steady_order = 1.0_wp
        real(wp) :: reach = 1.0_wp                  !! how far beyond, as a factor of the size
        real(wp), allocatable :: size(:)            !! elements or steps (levels)
        real(wp), allocatable :: error(:)           !! estimated, of every level (levels)
        real(wp) :: order = 0.0_wp                  !! that is reckoned with
    contains
        procedure :: learn
        procedure :: error_at
        procedure :: largest_size
    end type axis_t

contains

    !> Errors of all levels. Where the error is C size^-order, two levels differ by C times the difference of
    !> these powers: two differences tell the order. What is left at the last level, r times as large as the
    !> one before it, is then their difference over r^order - 1; further up it is the distance to the last
    !> level, and that. One difference alone shows no order: `first_order` is assumed.
    pure subroutine learn(self, sizes, differences, to_last)
        class(axis_t), intent(inout) :: self
        real(wp), intent(in) :: sizes(:)            !! elements or steps, growing (levels, at least 2)
        real(wp), intent(in) :: differences(:)      !! of consecutive levels (levels - 1)
        real(wp), intent(in) :: to_last(:)          !! from every level to the last one (levels)
        real(wp), allocatable :: orders(:)
        integer :: n, k

        n = size(differences)
        self%size = sizes
        self%order = self%first_order
        if (n > 1) then
            ! The mean of the last two orders: single ones may scatter.
            orders = [(observed_order(sizes(k - 1:k + 1), differences(k - 1:k), self%lowest_order, &
                self%highest_order), k=max(2, n - 1), n)]
            self%order = sum(orders)/real(size(orders), wp)
        end if
        self%error = to_last + differences(n)/((sizes(n + 1)/sizes(n))**self%order - 1.0_wp)
    end subroutine learn

    !> The order of three levels, by bisection: the higher it is, the more the differences shrink.
    pure real(wp) function observed_order(sizes, differences, lowest, highest) result(order)
        real(wp), intent(in) :: sizes(3), differences(2)
        real(wp), intent(in) :: lowest, highest     !! bounds of the answer
        real(wp) :: low, high
        integer :: i

        low = lowest
        high = highest
        do i = 1, 30
            order = 0.5_wp*(low + high)
            if (differences(1)*(sizes(2)**(-order) - sizes(3)**(-order)) &
                >= differences(2)*(sizes(1)**(-order) - sizes(2)**(-order))) then
                low = order
            else
                high = order
            end if
        end do
    end function observed_order

    !> Error at a size: a power law between levels, and beyond the last one with the order reckoned with.
    pure real(wp) function error_at(self, at) result(error)
        class(axis_t), intent(in) :: self
        real(wp), intent(in) :: at                  !! elements or steps
        real(wp) :: slope
        integer :: k, n

        n = size(self%size)
        if (at >= self%size(n)) then
            error = self%error(n)*(self%size(n)/at)**self%order
            return
        end if
        k = 1
        do while (at > self%size(k + 1))
            k = k + 1
        end do
        slope = 0.0_wp
        if (self%error(k) > 0.0_wp .and. self%error(k + 1) > 0.0_wp) &
            slope = log(self%error(k)/self%error(k + 1))/log(self%size(k + 1)/self%size(k))
        error = self%error(k)*(self%size(k)/at)**max(slope, 0.0_wp)
    end function error_at

    !> The largest size that the levels say something about.
    pure real(wp) function largest_size(self)
        class(axis_t), intent(in) :: self
        logical :: can_go_beyond

        largest_size = self%size(size(self%size))
        select case (size(self%size) - 1)
        case (1)
            can_go_beyond = .false.
        case (2)
            can_go_beyond = self%order >= self%regular_order
        case (3)
            can_go_beyond = self%order > self%steady_order
        case default
            can_go_beyond = .true.
        end select
        if (can_go_beyond) largest_size = largest_size*self%reach
    end function largest_size

end module gb_convergence
