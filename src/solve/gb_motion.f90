!> Driven supports (PRESCRIBE): fields at nodes that follow value * history.
module gb_motion
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_fields, only: n_fields, dof_index
    use gb_history, only: history_t
    use gb_model, only: model_t
    use gb_state, only: state_t
    implicit none
    private

    type, public :: motion_t
        integer, allocatable :: unknown(:)          !! driven unknowns; empty where nothing is driven
        real(wp), allocatable :: value(:)           !! theirs at factor 1
        integer, allocatable :: history(:)
        type(history_t), allocatable :: histories(:)
    contains
        procedure :: impose
        procedure :: impose_factor
        procedure :: restart
        procedure :: follow
        procedure :: is_driven
    end type motion_t

    public :: build_motion

    !> Derivatives of a history are taken over this part of a step: their truncation is small against the
    !> scheme's, and round-off does not show.
    real(wp), parameter :: difference_part = 0.1_wp

contains

    pure function build_motion(model) result(motion)
        type(model_t), intent(in) :: model
        type(motion_t) :: motion
        integer :: i, field

        allocate (motion%unknown(0), motion%value(0), motion%history(0))
        motion%histories = model%histories
        do i = 1, size(model%prescribed)
            associate (support => model%prescribed(i))
                do field = 1, n_fields
                    if (.not. support%driven(field)) cycle
                    motion%unknown = [motion%unknown, dof_index(field, model%mesh%node_at(support%x))]
                    motion%value = [motion%value, support%value(field)]
                    motion%history = [motion%history, support%history]
                end do
            end associate
        end do
    end function build_motion

    pure logical function is_driven(self)
        class(motion_t), intent(in) :: self

        is_driven = size(self%unknown) > 0
    end function is_driven

    !> Statics: driven fields at a load factor, each history taken as 1.
    pure subroutine impose_factor(self, factor, u)
        class(motion_t), intent(in) :: self
        real(wp), intent(in) :: factor
        real(wp), intent(inout) :: u(:)

        u(self%unknown) = factor*self%value
    end subroutine impose_factor

    !> Driven fields at time t; `before` asks for the values just before a jump.
    pure subroutine impose(self, t, before, u, error)
        class(motion_t), intent(in) :: self
        real(wp), intent(in) :: t                   !! [T]
        logical, intent(in) :: before
        real(wp), intent(inout) :: u(:)
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: factor
        integer :: i

        do i = 1, size(self%unknown)
            call self%histories(self%history(i))%factor_at(t, before, factor, error)
            if (allocated(error)) return
            u(self%unknown(i)) = self%value(i)*factor
        end do
    end subroutine impose

    !> Driven fields and their derivatives from time t on: at the start, and after a jump or corner.
    pure subroutine restart(self, t, step, state, error)
        class(motion_t), intent(in) :: self
        real(wp), intent(in) :: t, step             !! [T]
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error

        call differentiate(self, t, difference_part*step, state, error)
    end subroutine restart

    !> Driven fields and their derivatives at time t, the end of a step of the given size.
    pure subroutine follow(self, t, step, state, error)
        class(motion_t), intent(in) :: self
        real(wp), intent(in) :: t, step             !! [T]
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error

        call differentiate(self, t, -difference_part*step, state, error)
    end subroutine follow

    !> One-sided differences at t, t+d, t+2d, t+3d: third order for velocities, second for accelerations. The
    !> histories are smooth within a step, since steps end on their jumps and corners.
    pure subroutine differentiate(self, t, d, state, error)
        class(motion_t), intent(in) :: self
        real(wp), intent(in) :: t
        real(wp), intent(in) :: d                   !! positive: from t on; negative: up to t [T]
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: u(size(state%u), 0:3)
        integer :: k

        do k = 0, 3
            u(:, k) = state%u
            ! Away from t itself no jump is met: either side serves.
            call self%impose(t + real(k, wp)*d, d < 0.0_wp .eqv. k == 0, u(:, k), error)
            if (allocated(error)) return
        end do
        associate (i => self%unknown)
            state%u(i) = u(i, 0)
            state%v(i) = (-11.0_wp*u(i, 0) + 18.0_wp*u(i, 1) - 9.0_wp*u(i, 2) + 2.0_wp*u(i, 3))/(6.0_wp*d)
            state%a(i) = (2.0_wp*u(i, 0) - 5.0_wp*u(i, 1) + 4.0_wp*u(i, 2) - u(i, 3))/d**2
        end associate
    end subroutine differentiate

end module gb_motion
