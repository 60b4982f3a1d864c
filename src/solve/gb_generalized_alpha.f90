!> Newmark's scheme, eq. (44-47), and its dissipative relatives: with alpha_m = alpha_f = 0 it is Newmark's
!> own; Hilber, Hughes and Taylor's and Chung and Hulbert's schemes weight inertia and forces between the ends
!> of the step:
!>     M a_(n+1-alpha_m) + C v_(n+1-alpha_f) + f_int(u_(n+1-alpha_f)) = (1-alpha_f) f_(n+1) + alpha_f f_n.
!> All are second order; for nonlinear problems none is unconditionally stable.
module gb_generalized_alpha
    use gb_kinds, only: wp
    use gb_text, only: to_text
    use gb_state, only: state_t
    use gb_stage, only: stage_t
    use gb_scheme, only: scheme_t
    implicit none
    private

    type, extends(scheme_t), public :: generalized_alpha_t
        real(wp) :: beta = 0.25_wp, gamma = 0.5_wp
        real(wp) :: alpha_m = 0.0_wp, alpha_f = 0.0_wp
    contains
        procedure :: set_stage
        procedure :: finish_stage
        procedure :: load_mix
    end type generalized_alpha_t

    public :: newmark, hilber_hughes_taylor, chung_hulbert

contains

    !> Newmark (1959); beta = 1/4, gamma = 1/2 is the trapezoidal rule.
    pure type(generalized_alpha_t) function newmark(beta, gamma) result(scheme)
        real(wp), intent(in) :: beta, gamma

        scheme%beta = beta
        scheme%gamma = gamma
    end function newmark

    !> Hilber, Hughes and Taylor (1977), -1/3 <= alpha <= 0.
    pure type(generalized_alpha_t) function hilber_hughes_taylor(alpha) result(scheme)
        real(wp), intent(in) :: alpha

        scheme%alpha_f = -alpha
        scheme%weight_v = 1.0_wp - scheme%alpha_f
        scheme%gamma = 0.5_wp - alpha
        scheme%beta = 0.25_wp*(1.0_wp - alpha)**2
    end function hilber_hughes_taylor

    !> Chung and Hulbert (1993); rho is the spectral radius at infinite frequency, 0 to 1.
    pure type(generalized_alpha_t) function chung_hulbert(rho) result(scheme)
        real(wp), intent(in) :: rho

        scheme%alpha_m = (2.0_wp*rho - 1.0_wp)/(rho + 1.0_wp)
        scheme%alpha_f = rho/(rho + 1.0_wp)
        scheme%weight_a = 1.0_wp - scheme%alpha_m
        scheme%weight_v = 1.0_wp - scheme%alpha_f
        scheme%gamma = 0.5_wp - scheme%alpha_m + scheme%alpha_f
        scheme%beta = 0.25_wp*(1.0_wp - scheme%alpha_m + scheme%alpha_f)**2
    end function chung_hulbert

    !> a_(n+1) = (U - u_p)/(beta dt^2) with u_p = u + dt v + dt^2 (1/2 - beta) a, and v_(n+1) linear in it.
    pure subroutine set_stage(self, number, dt, committed, previous, stage)
        class(generalized_alpha_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(stage_t), intent(inout) :: stage
        real(wp) :: by_a

        by_a = self%beta*dt**2
        stage%mass_factor = (1.0_wp - self%alpha_m)/by_a
        stage%u_mass = committed%u + dt*committed%v &
            + (dt**2*(0.5_wp - self%beta) - self%alpha_m/stage%mass_factor)*committed%a
        stage%damping_factor = (1.0_wp - self%alpha_f)*self%gamma*dt/by_a
        if (stage%needs_velocity) then
            stage%u_damping = committed%u + dt*committed%v + (dt**2*(0.5_wp - self%beta))*committed%a &
                - (committed%v + (1.0_wp - self%alpha_f)*(1.0_wp - self%gamma)*dt*committed%a) &
                /stage%damping_factor
        end if
        stage%force_factor = 1.0_wp - self%alpha_f
        if (self%alpha_f > 0.0_wp) stage%u_start = committed%u
    end subroutine set_stage

    pure subroutine finish_stage(self, number, dt, committed, previous, reached)
        class(generalized_alpha_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: committed, previous
        type(state_t), intent(inout) :: reached
        real(wp) :: by_a

        by_a = 1.0_wp/(self%beta*dt**2)
        reached%a = by_a*(reached%u &
            - (committed%u + dt*committed%v + (dt**2*(0.5_wp - self%beta))*committed%a))
        reached%v = committed%v + dt*((1.0_wp - self%gamma)*committed%a + self%gamma*reached%a)
    end subroutine finish_stage

    pure subroutine load_mix(self, number, fraction, weight)
        class(generalized_alpha_t), intent(in) :: self
        integer, intent(in) :: number
        real(wp), intent(out) :: fraction, weight

        fraction = 1.0_wp
        weight = 1.0_wp - self%alpha_f
    end subroutine load_mix

end module gb_generalized_alpha
