!> Bathe's composite scheme in the form with a spectral radius rho at infinite frequency (Noh and Bathe 2019):
!> the trapezoidal rule over the first half of the step, then over the whole step
!>     v_1 = v_0 + dt (q0 a_0 + q1 a_h + q2 a_1),   u_1 = u_0 + dt (q0 v_0 + q1 v_h + q2 v_1),
!>     q1 = (rho+1)/(rho+3),  q0 = q2 = (1-q1)/2.
!> rho = 0 is the three-point backward formula of Bathe and Baig (2005), rho = 1 the trapezoidal rule twice.
module gb_bathe
    use gb_kinds, only: wp
    use gb_state, only: state_t
    use gb_stage, only: stage_t
    use gb_scheme, only: scheme_t
    implicit none
    private

    type, extends(scheme_t), public :: bathe_t
        real(wp) :: q0 = 0.0_wp, q1 = 0.0_wp, q2 = 0.0_wp
    contains
        procedure :: set_stage
        procedure :: finish_stage
        procedure :: load_mix
    end type bathe_t

    public :: bathe

contains

    pure type(bathe_t) function bathe(rho) result(scheme)
        real(wp), intent(in) :: rho

        scheme%stages = 2
        scheme%q1 = (rho + 1.0_wp)/(rho + 3.0_wp)
        scheme%q0 = 0.5_wp*(1.0_wp - scheme%q1)
        scheme%q2 = scheme%q0
    end function bathe

    pure subroutine set_stage(self, number, dt, committed, previous, stage)
        class(bathe_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(stage_t), intent(inout) :: stage
        real(wp) :: half

        stage%force_factor = 1.0_wp
        if (number == 1) then
            half = 0.5_wp*dt
            stage%mass_factor = 4.0_wp/half**2
            stage%u_mass = committed%u + half*committed%v + (0.25_wp*half**2)*committed%a
            stage%damping_factor = 2.0_wp/half
            if (stage%needs_velocity) stage%u_damping = committed%u + (0.5_wp*half)*committed%v
        else
            stage%damping_factor = 1.0_wp/(self%q2*dt)
            if (stage%needs_velocity) then
                stage%u_damping = committed%u + dt*(self%q0*committed%v + self%q1*previous%v)
            end if
            stage%mass_factor = stage%damping_factor**2
            stage%u_mass = committed%u + dt*(self%q0*committed%v + self%q1*previous%v) + (self%q2*dt) &
                           *(committed%v + dt*(self%q0*committed%a + self%q1*previous%a))
        end if
    end subroutine set_stage

    pure subroutine finish_stage(self, number, dt, committed, previous, reached)
        class(bathe_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(state_t), intent(inout) :: reached

        if (number == 1) then
            reached%v = (4.0_wp/dt)*(reached%u - committed%u) - committed%v
            reached%a = (4.0_wp/dt)*(reached%v - committed%v) - committed%a
        else
            reached%v = (reached%u - committed%u - dt*(self%q0*committed%v + self%q1*previous%v))/(self%q2*dt)
            reached%a = (reached%v - committed%v - dt*(self%q0*committed%a + self%q1*previous%a))/(self%q2*dt)
        end if
    end subroutine finish_stage

    pure subroutine load_mix(self, number, fraction, weight)
        class(bathe_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(out) :: fraction, weight

        fraction = merge(0.5_wp, 1.0_wp, number == 1)
        weight = 1.0_wp
    end subroutine load_mix

end module gb_bathe
