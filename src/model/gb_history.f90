!> Load histories: a factor as a function of time, and the instants where it jumps or has a corner.
module gb_history
    use gb_kinds, only: wp, pi
    use gb_error, only: error_t, raise, status_solution
    use gb_text, only: to_text
    use gb_program, only: program_t
    implicit none
    private

    integer, parameter, public :: history_step = 1, history_ramp = 2, history_pulse = 3, history_sine = 4, &
        history_table = 5, history_formula = 6

    type, public :: history_t
        character(:), allocatable :: name
        integer :: kind = history_step
        real(wp) :: start = 0.0_wp          !! step, ramp, pulse: when it starts [T]
        real(wp) :: rise = 0.0_wp           !! ramp: time from 0 to 1 [T]
        real(wp) :: stop = 0.0_wp           !! pulse: the last instant at which it is 1 [T]
        real(wp) :: frequency = 0.0_wp      !! sine [1/T]
        real(wp) :: phase = 0.0_wp          !! sine [rad]
        real(wp), allocatable :: t(:)       !! table: increasing times [T]
        real(wp), allocatable :: f(:)       !! table: factors at these times [-]
        character(:), allocatable :: file   !! table: path of the file it was read from
        type(program_t) :: formula          !! formula: factor of the variable t
    contains
        procedure :: evaluate
        procedure :: factor_at
        procedure :: events
    end type history_t

contains

    !> The factor at time t [-]. At a jump, `before` asks for the value just before it (what a step that ends
    !> there sees); otherwise the value from then on. `defined` is false where there is no finite value.
    pure subroutine evaluate(self, t, before, factor, defined)
        class(history_t), intent(in) :: self
        real(wp), intent(in) :: t           !! [T]
        logical, intent(in) :: before
        real(wp), intent(out) :: factor
        logical, intent(out) :: defined

        defined = .true.
        select case (self%kind)
        case (history_step)
            factor = merge(1.0_wp, 0.0_wp, has_started(self%start, t, before))
        case (history_ramp)
            factor = ramp(t - self%start, self%rise)
        case (history_pulse)
            factor = merge(1.0_wp, 0.0_wp, has_started(self%start, t, before) .and. &
                           .not. has_started(self%stop, t, before))
        case (history_sine)
            factor = sin(2.0_wp*pi*self%frequency*t + self%phase)
        case (history_table)
            factor = interpolate(self%t, self%f, t)
        case default
            call self%formula%evaluate(t, factor, defined)
        end select
    end subroutine evaluate

    !> As evaluate, with an error that names the history where the factor is not defined.
    pure subroutine factor_at(self, t, before, factor, error)
        class(history_t), intent(in) :: self
        real(wp), intent(in) :: t           !! [T]
        logical, intent(in) :: before
        real(wp), intent(out) :: factor
        type(error_t), allocatable, intent(out) :: error
        logical :: defined

        call self%evaluate(t, before, factor, defined)
        if (.not. defined) call raise(error, status_solution, 'HISTORY ' // self%name // &
            ' has no finite value at t = ' // to_text(t))
    end subroutine factor_at

    pure logical function has_started(start, t, before)
        real(wp), intent(in) :: start, t
        logical, intent(in) :: before

        if (before) then
            has_started = t > start
        else
            has_started = t >= start
        end if
    end function has_started

    !> From 0 to 1 within `rise`, which may be so short that the quotient overflows.
    pure real(wp) function ramp(t, rise)
        real(wp), intent(in) :: t, rise     !! [T]

        ramp = 0.0_wp
        if (t >= rise) then
            ramp = 1.0_wp
        else if (t > 0.0_wp) then
            ramp = t/rise
        end if
    end function ramp

    !> Linear between the points, held outside.
    pure real(wp) function interpolate(t, f, at) result(value)
        real(wp), intent(in) :: t(:), f(:), at
        integer :: low, high, middle

        if (at <= t(1)) then
            value = f(1)
        else if (at >= t(size(t))) then
            value = f(size(f))
        else
            low = 1
            high = size(t)
            do while (high - low > 1)
                middle = (low + high)/2
                if (t(middle) <= at) then
                    low = middle
                else
                    high = middle
                end if
            end do
            value = f(low) + (f(high) - f(low))*(at - t(low))/(t(high) - t(low))
        end if
    end function interpolate

    !> The instants at which the factor jumps or has a corner [T]: steps end on them.
    pure function events(self) result(times)
        class(history_t), intent(in) :: self
        real(wp), allocatable :: times(:)

        select case (self%kind)
        case (history_step)
            times = [self%start]
        case (history_ramp)
            times = [self%start, self%start + self%rise]
        case (history_pulse)
            times = [self%start, self%stop]
        case (history_table)
            times = self%t
        case default
            allocate (times(0))
        end select
    end function events

end module gb_history
