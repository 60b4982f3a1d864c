!> Newmark's scheme, eq. (44-47): beta = 1/4, gamma = 1/2 is the trapezoidal rule, second order without damping.
!> For nonlinear problems it is not unconditionally stable.
module gb_newmark
    use gb_kinds, only: wp
    use gb_text, only: to_text
    use gb_state, only: state_t
    use gb_stage, only: stage_t
    use gb_scheme, only: scheme_t
    implicit none
    private

    type, extends(scheme_t), public :: newmark_t
        real(wp) :: beta = 0.25_wp, gamma = 0.5_wp
    contains
        procedure :: set_stage
        procedure :: finish_stage
        procedure :: load_mix
        procedure :: describe
    end type newmark_t

contains

    !> Acceleration (U - u_mass)/(beta dt^2) with u_mass = u + dt v + dt^2 (1/2 - beta) a; velocity linear in U.
    pure subroutine set_stage(self, number, dt, committed, previous, stage)
        class(newmark_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(stage_t), intent(inout) :: stage

        stage%mass_factor = 1.0_wp/(self%beta*dt**2)
        stage%damping_factor = self%gamma/(self%beta*dt)
        stage%force_factor = 1.0_wp
        stage%u_mass = predicted(self, dt, committed)
        stage%u_damping = stage%u_mass - (committed%v + (dt*(1.0_wp - self%gamma))*committed%a)/stage%damping_factor
        stage%u_start = previous%u
    end subroutine set_stage

    pure subroutine finish_stage(self, number, dt, committed, previous, reached)
        class(newmark_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(state_t), intent(inout) :: reached

        reached%a = (reached%u - predicted(self, dt, committed))/(self%beta*dt**2)
        reached%v = committed%v + dt*((1.0_wp - self%gamma)*committed%a + self%gamma*reached%a)
    end subroutine finish_stage

    pure function predicted(self, dt, committed) result(u)
        class(newmark_t), intent(in) :: self
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed
        real(wp) :: u(size(committed%u))

        u = committed%u + dt*committed%v + (dt**2*(0.5_wp - self%beta))*committed%a
    end function predicted

    pure subroutine load_mix(self, number, fraction, weight)
        class(newmark_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(out) :: fraction, weight

        fraction = 1.0_wp
        weight = 1.0_wp
    end subroutine load_mix

    pure function describe(self) result(text)
        class(newmark_t), intent(in) :: self
        character(:), allocatable :: text

        text = 'newmark beta=' // to_text(self%beta) // ' gamma=' // to_text(self%gamma)
    end function describe

end module gb_newmark
