!> How many steps it takes to see what the histories do, and how many elements to see what INITIAL gives.
!> Trials whose steps meet a vibration in its zeros only, or stride over a knock, all tell the same: that
!> nothing moves.
module gb_sight
    use gb_kinds, only: wp
    use gb_history, only: history_sine, history_formula
    use gb_load, only: stage_static
    use gb_model, only: model_t
    use gb_program, only: program_t
    implicit none
    private

    !> A course is seen where lines between its values miss no more than this part of it, in the root mean
    !> square.
    real(wp), parameter :: unseen_part = 0.3_wp
    !> Steps that see a period.
    real(wp), parameter :: steps_a_period = 4.0_wp
    !> A formula is looked at in so many instants. What it does in between, nobody knows.
    integer, parameter :: n_looks = 16384

    public :: steps_to_see, elements_to_see

contains

    !> Steps with which a transient sees all histories that act in it, at least `first`. (Steps end at the
    !> jumps and corners of the other kinds.)
    pure real(wp) function steps_to_see(model, end_time, first) result(steps)
        type(model_t), intent(in) :: model
        real(wp), intent(in) :: end_time            !! [T]
        integer, intent(in) :: first
        integer, allocatable :: acting(:)
        integer :: i

        acting = [pack(model%point_loads%history, model%point_loads%stage /= stage_static), &
            pack(model%distributed_loads%history, model%distributed_loads%stage /= stage_static), &
            pack(model%gravity%history, model%gravity%stage /= stage_static), model%prescribed%history]
        steps = real(first, wp)
        do i = 1, size(acting)
            associate (history => model%histories(acting(i)))
                select case (history%kind)
                case (history_sine)
                    steps = max(steps, steps_a_period*history%frequency*end_time)
                case (history_formula)
                    steps = max(steps, real(intervals_to_see(history%formula, 0.0_wp, end_time, first), wp))
                end select
            end associate
        end do
    end function steps_to_see

    !> Elements of equal length that see all initial values, at least `first`.
    pure real(wp) function elements_to_see(model, first) result(elements)
        type(model_t), intent(in) :: model
        real(wp), intent(in) :: first
        real(wp) :: left
        integer :: i

        left = minval(model%lines%from)
        elements = first
        ! Two intervals an element, between its three nodes.
        do i = 1, size(model%initial)
            elements = max(elements, 0.5_wp*real(intervals_to_see(model%initial(i)%formula, left, &
                left + model%mesh%length(), ceiling(2.0_wp*first)), wp))
        end do
    end function elements_to_see

    !> Intervals of equal length whose ends see a formula from a to b: `first`, or as many times two of it as
    !> it takes.
    pure integer function intervals_to_see(formula, a, b, first) result(n)
        type(program_t), intent(in) :: formula
        real(wp), intent(in) :: a, b
        integer, intent(in) :: first
        !> Looks stand aside of all ends.
        real(wp), parameter :: aside = 0.382_wp
        real(wp) :: look(n_looks), missed, place, left, right
        integer :: i, k, last

        look = [(value_of(formula, a + (b - a)*(real(i, wp) - aside)/real(n_looks, wp)), i=1, n_looks)]
        n = first
        do while (n < n_looks)
            missed = 0.0_wp
            last = -1
            left = 0.0_wp
            right = 0.0_wp
            do i = 1, n_looks
                place = real(n, wp)*(real(i, wp) - aside)/real(n_looks, wp)
                k = int(place)
                if (k /= last) then
                    left = value_of(formula, a + (b - a)*real(k, wp)/real(n, wp))
                    right = value_of(formula, a + (b - a)*real(k + 1, wp)/real(n, wp))
                    last = k
                end if
                missed = hypot(missed, look(i) - left - (right - left)*(place - real(k, wp)))
            end do
            if (missed <= unseen_part*norm2(look)) return
            n = 2*n
        end do
        n = first
    end function intervals_to_see

    !> A formula's value; 0 where it has none, which its command will tell.
    pure real(wp) function value_of(formula, at) result(value)
        type(program_t), intent(in) :: formula
        real(wp), intent(in) :: at
        logical :: defined

        call formula%evaluate(at, value, defined)
        if (.not. defined) value = 0.0_wp
    end function value_of

end module gb_sight
