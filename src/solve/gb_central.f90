!> The explicit central difference scheme with lumped mass:
!>     u_1 = u_0 + dt v_0 + dt^2/2 a_0,
!>     M a_1 = f_1 - f_int(u_1) - C (v_0 + dt a_0),
!>     v_1 = v_0 + dt/2 (a_0 + a_1).
!> Second order, no equations to solve; stable for steps below 2/omega_max (less with damping), which the
!> stepper enforces.
module gb_central
    use gb_kinds, only: wp
    use gb_state, only: state_t
    use gb_stage, only: stage_t
    use gb_scheme, only: scheme_t
    implicit none
    private

    type, extends(scheme_t), public :: central_t
    contains
        procedure :: set_stage
        procedure :: finish_stage
        procedure :: load_mix
    end type central_t

    public :: central

contains

    pure type(central_t) function central() result(scheme)
        scheme%is_explicit = .true.
    end function central

    !> The new displacements need no equation: they are stage%u_mass. The velocities that damping sees,
    !> v_0 + dt a_0, are (U - stage%u_damping) stage%damping_factor.
    pure subroutine set_stage(self, number, dt, committed, previous, stage)
        class(central_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(stage_t), intent(inout) :: stage

        stage%u_mass = committed%u + dt*committed%v + (0.5_wp*dt**2)*committed%a
        stage%u_damping = committed%u + (0.5_wp*dt)*committed%v
        stage%damping_factor = 2.0_wp/dt
    end subroutine set_stage

    !> reached%a is that of equilibrium at reached%u.
    pure subroutine finish_stage(self, number, dt, committed, previous, reached)
        class(central_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(state_t), intent(inout) :: reached

        reached%v = committed%v + (0.5_wp*dt)*(committed%a + reached%a)
    end subroutine finish_stage

    pure subroutine load_mix(self, number, fraction, weight)
        class(central_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(out) :: fraction, weight

        fraction = 1.0_wp
        weight = 1.0_wp
    end subroutine load_mix

end module gb_central
