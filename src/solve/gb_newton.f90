!> Newton's method for one stage (gb_stage). Every trial state is tested for admissibility (J > 0, I1-2 < jm
!> at every integration point) before anything is computed from it, and the step is halved until it passes.
!> The full step is tried first throughout; where that fails, the iteration starts again with a line search.
module gb_newton
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_band, only: band_t
    use gb_system, only: system_t
    use gb_stage, only: stage_t
    implicit none
    private

    !> How an attempt ended.
    integer, parameter, public :: newton_converged = 0  !! increments below the tolerance, or residual at
                                                        !! round-off
    integer, parameter, public :: newton_inadmissible = 1   !! no admissible state along the search direction
    integer, parameter, public :: newton_singular = 2       !! a pivot of the tangent vanishes
    integer, parameter, public :: newton_slow = 3           !! iterations used up
    integer, parameter, public :: newton_diverged = 4       !! increments beyond all measure, or not finite
    integer, parameter, public :: newton_stuck = 5          !! the line search finds no decrease

    type, public :: newton_report_t
        integer :: outcome = newton_slow
        integer :: iterations = 0                   !! tangents solved with
        integer :: singular_unknown = 0             !! for newton_singular
        real(wp) :: residual = 0.0_wp               !! last residual over the forces that balance in it [-]
        real(wp), allocatable :: increments(:)      !! largest scaled increment of each iteration [-]
        real(wp), allocatable :: rejected(:)  !! the trial state that was refused, for newton_inadmissible
    end type newton_report_t

    type, public :: newton_t
        real(wp) :: tolerance = 1.0e-10_wp
        integer :: max_iterations = 25
        real(wp) :: largest(n_fields) = 0.0_wp      !! largest value of each field so far
        type(band_t) :: k                           !! tangent of the residual
        real(wp), allocatable :: r(:), force(:), u_e(:), trial(:), work(:), increment(:, :), round_off(:)
    contains
        procedure :: set_up
        procedure :: solve
    end type newton_t

    !> Fields smaller than this part of their natural size (beam length, 1, 1/h) count as that large.
    real(wp), parameter :: smallest_part = 1.0e-3_wp
    !> Increments beyond this multiple of the fields' natural size are no approximation to anything.
    real(wp), parameter :: largest_part = 1.0e6_wp
    !> A pivot of this part of its diagonal element, where the increments are beyond measure, is a
    !> mechanism's.
    real(wp), parameter :: mechanism_part = 1.0e-13_wp
    integer, parameter :: max_halvings = 40

contains

    subroutine set_up(self, system, tolerance, iterations, symmetric)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        real(wp), intent(in) :: tolerance
        integer, intent(in) :: iterations
        logical, intent(in), optional :: symmetric  !! whether the tangent is, if not as the elements'
        logical :: is_symmetric

        self%tolerance = tolerance
        self%max_iterations = iterations
        is_symmetric = system%symmetric
        if (present(symmetric)) is_symmetric = symmetric
        call self%k%set_up(system%n, system%kd, is_symmetric)
        allocate (self%r(system%n), self%force(system%n), self%u_e(system%n), self%trial(system%n), &
                  self%work(system%n), self%increment(system%n, 1), self%round_off(system%n))
    end subroutine set_up

    !> Solve R(u) = 0 from the admissible guess u. Where the outcome is not newton_converged, u is worthless.
    subroutine solve(self, system, stage, u, report)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(inout) :: u(:)  !! guess in, solution out (n); held unknowns have their values
        type(newton_report_t), intent(out) :: report
        real(wp), allocatable :: guess(:)
        integer :: spent

        guess = u
        call iterate(self, system, stage, .false., u, report)
        if (report%outcome == newton_converged .or. report%outcome == newton_singular) return
        spent = report%iterations
        u = guess
        call iterate(self, system, stage, .true., u, report)
        report%iterations = report%iterations + spent
    end subroutine solve

    !> Newton's iteration, with full steps where admissible or (searching) with a line search.
    subroutine iterate(self, system, stage, searching, u, report)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        logical, intent(in) :: searching
        real(wp), intent(inout) :: u(:)
        type(newton_report_t), intent(out) :: report
        real(wp) :: pivot_part
        logical :: admissible
        integer :: iteration, singular

        allocate (report%increments(0))
        call evaluate(self, system, stage, u, admissible)
        if (.not. admissible) then
            report%outcome = newton_inadmissible
            report%rejected = self%u_e
            return
        end if
        call estimate_round_off(self, system, u)
        do iteration = 1, self%max_iterations
            report%residual = relative_residual(self, system, stage)
            if (all(abs(self%r) <= self%round_off)) then
                report%outcome = newton_converged
                return
            end if
            call self%k%factorise(singular)
            if (singular > 0) then
                report%outcome = newton_singular
                report%singular_unknown = singular
                return
            end if
            self%increment(:, 1) = -self%r
            call self%k%solve(self%increment)
            report%iterations = iteration
            if (is_beyond_measure(self, system)) then
                report%outcome = newton_diverged
                call self%k%weakest_pivot(report%singular_unknown, pivot_part)
                if (pivot_part < mechanism_part) report%outcome = newton_singular
                return
            end if
            report%increments = [report%increments, scaled_increment(self, system, u)]
            if (report%increments(iteration) <= self%tolerance) then
                u = u + self%increment(:, 1)
                report%outcome = newton_converged
                return
            end if
            call advance(self, system, stage, searching, u, report)
            if (report%outcome /= newton_slow) return
        end do
    end subroutine iterate

    !> Take the increment, halved until the new state is admissible and, when searching, until it is better.
    subroutine advance(self, system, stage, searching, u, report)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        logical, intent(in) :: searching
        real(wp), intent(inout) :: u(:)
        type(newton_report_t), intent(inout) :: report
        real(wp) :: part, slope, merit, trial_merit
        logical :: admissible, has_met_inadmissible
        integer :: halving

        slope = 0.0_wp
        merit = 0.0_wp
        if (searching) call measure(self, system, stage, u, merit, slope)
        has_met_inadmissible = .false.
        part = 1.0_wp
        do halving = 0, max_halvings
            self%trial = u + part*self%increment(:, 1)
            call evaluate(self, system, stage, self%trial, admissible)
            if (admissible .and. searching) then
                call measure(self, system, stage, self%trial, trial_merit)
                admissible = trial_merit <= merit + 1.0e-4_wp*part*slope + 8.0_wp*epsilon(merit)*abs(merit)
            else if (.not. admissible) then
                if (.not. has_met_inadmissible) report%rejected = self%u_e
                has_met_inadmissible = .true.
            end if
            if (admissible) then
                u = self%trial
                return
            end if
            part = 0.5_wp*part
        end do
        report%outcome = merge(newton_inadmissible, newton_stuck, has_met_inadmissible)
    end subroutine advance

    !> Residual, and tangent of it, at the state u, with the supports' rows and columns removed.
    subroutine evaluate(self, system, stage, u, admissible)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: u(:)
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
            call system%add_inertia(self%u_e, stage%damping_factor*(u - stage%u_damping), &
                                    stage%mass_factor*(u - stage%u_mass), &
                                    [stage%force_factor, stage%damping_factor, stage%mass_factor], self%r, &
                                    self%k)
            if (allocated(system%damping%a)) then
                call system%damping%multiply(u - stage%u_damping, self%work)
                self%r = self%r + stage%damping_factor*self%work
                call self%k%add_symmetric(stage%damping_factor, system%damping)
            end if
        end if
        self%r(system%fixed_list) = 0.0_wp
        call self%k%constrain(system%fixed_list)
    end subroutine evaluate

    !> What a line search compares at u, where `evaluate` has just been: the stage's potential and its slope
    !> along the increment; where there is none (unsymmetric tangent), half the square of the residual.
    subroutine measure(self, system, stage, u, merit, slope)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: u(:)
        real(wp), intent(out) :: merit
        real(wp), intent(out), optional :: slope
        logical :: admissible

        if (self%k%symmetric) then
            call system%strain_energy(self%u_e, merit, admissible)
            merit = merit/stage%force_factor - dot_product(stage%f_external, u)
            if (stage%mass_factor > 0.0_wp) then
                call system%mass%multiply(u - stage%u_mass, self%work)
                merit = merit + 0.5_wp*stage%mass_factor*dot_product(u - stage%u_mass, self%work)
            end if
            if (stage%mass_factor > 0.0_wp .and. allocated(system%damping%a)) then
                call system%damping%multiply(u - stage%u_damping, self%work)
                merit = merit + 0.5_wp*stage%damping_factor*dot_product(u - stage%u_damping, self%work)
            end if
            if (present(slope)) slope = dot_product(self%r, self%increment(:, 1))
        else
            merit = 0.5_wp*sum((reshape(self%r, [n_fields, system%n/n_fields]) &
                                *spread(system%field_scale, 2, system%n/n_fields))**2)
            if (present(slope)) slope = -2.0_wp*merit
        end if
    end subroutine measure

    !> The part of each residual that rounding alone explains: unit round-off times sum |k_ij| |u_j|, where a
    !> field counts at least as its natural size (an element's length for displacements, since strains are
    !> differences of them).
    subroutine estimate_round_off(self, system, u)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        real(wp), intent(in) :: u(:)
        integer :: field

        do field = 1, n_fields
            self%work(field::n_fields) = maxval(abs(u(field::n_fields)))
        end do
        self%work(1::n_fields) = max(self%work(1::n_fields), 2.0_wp*minval(system%half_length))
        self%work(2::n_fields) = max(self%work(2::n_fields), 2.0_wp*minval(system%half_length))
        do field = 3, n_fields
            self%work(field::n_fields) = max(self%work(field::n_fields), system%field_scale(field))
        end do
        call self%k%row_bound(self%work, self%round_off)
        self%round_off = epsilon(1.0_wp)*self%round_off
    end subroutine estimate_round_off

    !> Largest increment over the fields, each relative to the largest value of its field so far.
    function scaled_increment(self, system, u) result(largest)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        real(wp), intent(in) :: u(:)
        real(wp) :: largest
        integer :: field

        largest = 0.0_wp
        do field = 1, n_fields
            self%largest(field) = max(self%largest(field), maxval(abs(u(field::n_fields))), &
                                      smallest_part*system%field_scale(field))
            largest = max(largest, maxval(abs(self%increment(field::n_fields, 1)))/self%largest(field))
        end do
    end function scaled_increment

    pure function is_beyond_measure(self, system) result(beyond)
        class(newton_t), intent(in) :: self
        type(system_t), intent(in) :: system
        logical :: beyond
        integer :: field

        beyond = .not. all(ieee_is_finite(self%increment(:, 1)))
        do field = 1, n_fields
            if (beyond) return
            beyond = maxval(abs(self%increment(field::n_fields, 1))) &
                     > largest_part*max(system%field_scale(field), self%largest(field))
        end do
    end function is_beyond_measure

    !> Norm of the residual over that of the forces that balance in it, field by field made comparable by the
    !> fields' sizes.
    pure function relative_residual(self, system, stage) result(relative)
        class(newton_t), intent(in) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp) :: relative
        real(wp) :: forces
        integer :: field

        relative = 0.0_wp
        forces = 0.0_wp
        do field = 1, n_fields
            relative = max(relative, maxval(abs(self%r(field::n_fields)))*system%field_scale(field))
            forces = max(forces, maxval(abs(self%force(field::n_fields)))*system%field_scale(field), &
                         maxval(abs(stage%f_external(field::n_fields)))*system%field_scale(field))
        end do
        ! Where nothing but inertia acts, the residual is all there is.
        if (relative > 0.0_wp) relative = relative/max(forces, relative)
    end function relative_residual

end module gb_newton
