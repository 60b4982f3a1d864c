!> The energy and momentum conserving scheme: M (v_1 - v_0)/dt + f_average = (f_0 + f_1)/2, (u_1 - u_0)/dt =
!> (v_0 + v_1)/2, with an internal force that does exactly the work the strain energy gains
!> (gb_section_average). Second order.
module gb_energy_momentum
    use gb_kinds, only: wp
    use gb_state, only: state_t
    use gb_stage, only: stage_t
    use gb_scheme, only: scheme_t
    implicit none
    private

    type, extends(scheme_t), public :: energy_momentum_t
    contains
        procedure :: set_stage
        procedure :: finish_stage
        procedure :: load_mix
    end type energy_momentum_t

    public :: energy_momentum

contains

    pure type(energy_momentum_t) function energy_momentum() result(scheme)
        scheme%has_symmetric_tangent = .false.
        scheme%weight_a = 0.5_wp
        scheme%weight_v = 0.5_wp
    end function energy_momentum

    pure subroutine set_stage(self, number, dt, committed, previous, stage)
        class(energy_momentum_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(stage_t), intent(inout) :: stage

        stage%mass_factor = 2.0_wp/dt**2
        stage%u_mass = committed%u + dt*committed%v
        stage%damping_factor = 1.0_wp/dt
        if (stage%needs_velocity) stage%u_damping = committed%u
        stage%averages_force = .true.
        stage%u_start = committed%u
    end subroutine set_stage

    !> The scheme has no acceleration of its own: that of the step's middle is kept.
    pure subroutine finish_stage(self, number, dt, committed, previous, reached)
        class(energy_momentum_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(state_t), intent(inout) :: reached

        reached%v = (2.0_wp/dt)*(reached%u - committed%u) - committed%v
        reached%a = (reached%v - committed%v)/dt
    end subroutine finish_stage

    pure subroutine load_mix(self, number, fraction, weight)
        class(energy_momentum_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(out) :: fraction, weight

        fraction = 1.0_wp
        weight = 0.5_wp
    end subroutine load_mix

end module gb_energy_momentum
