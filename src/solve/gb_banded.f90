!> The linearised equation as a band matrix for LAPACK: every kind of element, scheme and tangent. A symmetric
!> matrix is condensed to the elements' end nodes first (gb_condensed); where an element's interior is not
!> definite, or the rest singular, and where the matrix is unsymmetric, LAPACK gets the whole.
module gb_banded
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_band, only: band_t
    use gb_condensed, only: condensed_t
    use gb_stage, only: stage_t
    use gb_system, only: system_t
    use gb_linearised, only: linearised_t
    implicit none
    private

    type, extends(linearised_t), public :: banded_t
        type(band_t) :: k                               !! tangent of the residual
        logical :: is_condensed = .false.               !! whether condensation is tried
        type(condensed_t) :: condensed
        real(wp), allocatable :: r(:)                   !! residual (n)
        real(wp), allocatable :: force(:), u_e(:), work(:)
    contains
        procedure :: set_up
        procedure :: evaluate
        procedure :: solve
        procedure :: relative_residual
        procedure :: residual
        procedure :: mechanism
    end type banded_t

contains

    subroutine set_up(self, system, symmetric)
        class(banded_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        logical, intent(in) :: symmetric                !! whether the tangent is

        call self%k%set_up(system%n, system%kd, symmetric)
        associate (nodes => system%tables(system%table)%nodes)
            self%is_condensed = symmetric .and. maxval(nodes) > 2
            if (self%is_condensed) call self%condensed%set_up(system%first, nodes)
        end associate
        allocate (self%r(system%n), self%force(system%n), self%u_e(system%n), self%work(system%n))
    end subroutine set_up

    subroutine evaluate(self, system, stage, u, admissible)
        class(banded_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        logical, intent(out) :: admissible

        call stage%evaluation_point(u, self%u_e)
        if (stage%averages_force) then
            call system%average_tangent(stage%u_start, u, self%force, self%k, admissible)
        else
            call system%tangent(self%u_e, self%force, self%k, admissible)
        end if
        if (.not. admissible) return
        self%r = self%force - stage%f_external
        if (stage%force_factor < 1.0_wp) self%k%a = stage%force_factor*self%k%a
        if (stage%mass_factor > 0.0_wp) then
            self%work = 0.0_wp
            if (stage%needs_velocity) self%work = stage%damping_factor*(u - stage%u_damping)
            call system%add_inertia(self%u_e, self%work, stage%mass_factor*(u - stage%u_mass), &
                [stage%force_factor, stage%damping_factor, stage%mass_factor], self%r, self%k)
            if (allocated(system%damping%a)) then
                call system%damping%multiply(u - stage%u_damping, self%work)
                self%r = self%r + stage%damping_factor*self%work
                call self%k%add_symmetric(stage%damping_factor, system%damping)
            end if
        end if
        self%r(system%fixed_list) = 0.0_wp
        call self%k%constrain(system%fixed_list)
    end subroutine evaluate

    subroutine solve(self, increment, singular)
        class(banded_t), intent(inout) :: self
        real(wp), intent(out), contiguous :: increment(:)
        integer, intent(out) :: singular
        logical :: is_solved

        increment = -self%r
        singular = 0
        is_solved = .false.
        if (self%is_condensed) call self%condensed%solve(self%k, increment, is_solved)
        if (is_solved) return
        call self%k%factorise(singular)
        if (singular == 0) call self%k%solve(1, increment)
    end subroutine solve

    real(wp) function relative_residual(self, system, stage)
        class(banded_t), intent(in) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp) :: forces
        integer :: field

        relative_residual = 0.0_wp
        forces = 0.0_wp
        do field = 1, n_fields
            relative_residual = max(relative_residual, &
                maxval(abs(self%r(field::n_fields)))*system%field_scale(field))
            forces = max(forces, maxval(abs(self%force(field::n_fields)))*system%field_scale(field), &
                         maxval(abs(stage%f_external(field::n_fields)))*system%field_scale(field))
        end do
        ! Where nothing but inertia acts, the residual is all there is.
        if (relative_residual > 0.0_wp) relative_residual = relative_residual/max(forces, relative_residual)
    end function relative_residual

    subroutine residual(self, system, stage, u, r)
        class(banded_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out), contiguous :: r(:)

        r = self%r
    end subroutine residual

    integer function mechanism(self)
        class(banded_t), intent(in) :: self
        real(wp), parameter :: vanishing = 1.0e-13_wp
        type(band_t) :: whole
        real(wp) :: ratio
        integer :: singular

        ! Condensation mixes the pivots of all fields; only those of the whole tell which unknown it is.
        whole = self%k
        call whole%factorise(singular)
        call whole%weakest_pivot(mechanism, ratio)
        if (ratio >= vanishing) mechanism = 0
    end function mechanism

end module gb_banded
