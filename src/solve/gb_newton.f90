!> Newton's method for one stage (gb_stage). Every trial state is tested for admissibility (J > 0, I1-2 < jm
!> at every integration point) before anything is computed from it, and the step is halved until it passes.
!> The full step is tried first throughout; where that fails, the iteration starts again with a line search.
!>
!> The iteration ends when the increment d_k is below the tolerance or, in motion, when the next one would be
!> far below: convergence is quadratic, d_(k+1) = C d_k^2, and for C stands the largest d_k/d_(k-1)^2 of this
!> solution and, halved from one to the next, of those before. Where the tangent leaves something out, a
!> linear part is added, rate d_k, with the smallest d_k/d_(k-1) of this solution or, doubled from one to the
!> next, of those before. Where increments stop shrinking, the residual is compared with what rounding alone
!> explains.
module gb_newton
    use gb_kinds, only: wp
    use gb_memory, only: memory_t
    use gb_fields, only: n_fields
    use gb_system, only: system_t
    use gb_stage, only: stage_t
    use gb_linearised, only: linearised_t
    use gb_banded, only: banded_t
    use gb_norms, only: largest_values
    use gb_block, only: block_t
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
        real(wp) :: curvature = 0.0_wp              !! C of quadratic convergence; 0 before anything is known
        real(wp) :: rate = 1.0_wp                   !! of linear convergence, where the tangent is not exact
        logical :: is_symmetric = .true.            !! whether the tangent is
        logical :: has_block = .false.              !! whether the block solver is tried first
        type(block_t) :: block
        type(banded_t) :: banded
        real(wp), allocatable :: increment(:)       !! (n)
    contains
        procedure :: set_up
        procedure :: solve
        procedure :: solve_block
        procedure :: prepare_banded
        procedure :: strain_energy
        procedure :: kinetic_energy
        procedure :: pass_memory
    end type newton_t

    !> Fields smaller than this part of their natural size (beam length, 1, 1/h) count as that large.
    real(wp), parameter, public :: smallest_part = 1.0e-3_wp
    !> Increments beyond this multiple of the fields' natural size are no approximation to anything.
    real(wp), parameter, public :: largest_part = 1.0e6_wp
    !> Increments above this part of the fields may change what their largest value is.
    real(wp), parameter, public :: coarse_part = 1.0e-2_wp
    !> An increment that is not smaller than this part of the last one does not converge quadratically.
    real(wp), parameter :: slow_part = 0.1_wp
    !> An estimated increment must be below this part of the tolerance.
    real(wp), parameter :: margin = 0.01_wp
    !> Where rounding is looked for: increments below this part of the fields, or after so many iterations.
    real(wp), parameter :: small_part = 1.0e-4_wp
    integer, parameter :: late = 6
    integer, parameter, public :: max_halvings = 40

    public :: may_be_rounding, is_last

contains

    subroutine set_up(self, system, tolerance, iterations, symmetric, block)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        real(wp), intent(in) :: tolerance
        integer, intent(in) :: iterations
        logical, intent(in), optional :: symmetric  !! whether the tangent is, if not as the elements'
        logical, intent(in), optional :: block      !! whether the block solver is to be used (it must apply)

        self%tolerance = tolerance
        self%max_iterations = iterations
        self%is_symmetric = system%symmetric
        if (present(symmetric)) self%is_symmetric = symmetric
        self%has_block = .false.
        if (present(block)) self%has_block = block
        if (self%has_block) call self%block%set_up(system)
        allocate (self%increment(system%n))
    end subroutine set_up

    !> Make LAPACK's solver ready; where the block solver does all the work its memory is never needed.
    subroutine prepare_banded(self, system)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system

        if (.not. allocated(self%banded%r)) call self%banded%set_up(system, self%is_symmetric)
    end subroutine prepare_banded

    !> Strain energy [F L] of the state u, by the solver in use. Not admissible: energy is meaningless.
    pure subroutine strain_energy(self, system, u, energy, admissible)
        class(newton_t), intent(in) :: self
        type(system_t), intent(in) :: system
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out) :: energy
        logical, intent(out) :: admissible

        if (self%has_block) then
            call self%block%strain_energy(u, energy, admissible)
        else
            call system%strain_energy(u, energy, admissible)
        end if
    end subroutine strain_energy

    !> Kinetic energy [F L] of velocities v at the state u.
    pure real(wp) function kinetic_energy(self, system, u, v)
        class(newton_t), intent(in) :: self
        type(system_t), intent(in) :: system
        real(wp), intent(in), contiguous :: u(:), v(:)

        if (self%has_block) then
            kinetic_energy = self%block%kinetic_energy(u, v)
        else
            kinetic_energy = system%kinetic_energy(u, v)
        end if
    end function kinetic_energy

    !> Solve R(u) = 0 by the block solver from the guess u or, where that is not admissible, from the state
    !> `origin` with the held unknowns of the guess. Where the outcome is not newton_converged, u is
    !> worthless, and `solve` may do better from the same guess.
    subroutine solve_block(self, system, stage, origin, u, report)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: origin(:)       !! (n)
        real(wp), intent(inout), contiguous :: u(:)         !! guess in, solution out (n)
        type(newton_report_t), intent(out) :: report

        call iterate(self, self%block, system, stage, origin, .false., u, report)
    end subroutine solve_block

    !> The same by LAPACK's solver, and once more with a line search where that fails.
    subroutine solve(self, system, stage, origin, u, report)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: origin(:)       !! (n)
        real(wp), intent(inout), contiguous :: u(:)         !! guess in, solution out (n)
        type(newton_report_t), intent(out) :: report
        real(wp), allocatable :: guess(:)
        integer :: spent

        call self%prepare_banded(system)
        guess = u
        call iterate(self, self%banded, system, stage, origin, .false., u, report)
        if (report%outcome == newton_converged .or. report%outcome == newton_singular) return
        spent = report%iterations
        u = guess
        call iterate(self, self%banded, system, stage, origin, .true., u, report)
        report%iterations = report%iterations + spent
    end subroutine solve

    !> What one solution leaves to the next.
    subroutine pass_memory(self, memory)
        class(newton_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory

        call memory%pass('newton.largest', self%largest)
        call memory%pass('newton.curvature', self%curvature)
        call memory%pass('newton.rate', self%rate)
    end subroutine pass_memory

    !> Newton's iteration, with full steps where admissible or (searching) with a line search.
    subroutine iterate(self, tangent, system, stage, origin, searching, u, report)
        class(newton_t), intent(inout) :: self
        class(linearised_t), intent(inout) :: tangent
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: origin(:)
        logical, intent(in) :: searching
        real(wp), intent(inout), contiguous :: u(:)
        type(newton_report_t), intent(out) :: report
        real(wp) :: increments(self%max_iterations), last, curvature, remembered, next
        logical :: can_estimate
        integer :: iteration

        call start(tangent, system, stage, origin, u, report)
        if (report%outcome == newton_inadmissible) return
        call widen(self, system, u)
        last = 0.0_wp
        curvature = 0.0_wp
        remembered = self%curvature
        if (tangent%is_exact) then
            self%rate = 0.0_wp
        else
            self%rate = min(2.0_wp*self%rate, 1.0_wp)
        end if
        ! A scheme that conserves does so only as far as its equation is solved, and statics of a slender beam
        ! bends and stretches in turn, so that a small increment may be followed by a large one.
        can_estimate = stage%mass_factor > 0.0_wp .and. .not. stage%averages_force
        do iteration = 1, self%max_iterations
            call find_increment(self, tangent, system, increments(iteration), report)
            if (report%outcome /= newton_slow) exit
            report%iterations = iteration
            if (may_be_rounding(self%tolerance, iteration, increments(iteration), last)) then
                if (is_round_off(self, tangent, system, stage, u)) then
                    report%outcome = newton_converged
                    report%iterations = iteration - 1
                    exit
                end if
            end if
            if (last > 0.0_wp .and. increments(iteration) > self%tolerance) then
                curvature = max(curvature, increments(iteration)/last**2)
                self%curvature = max(curvature, 0.5_wp*remembered)
            end if
            if (.not. tangent%is_exact .and. last > 0.0_wp) &
                self%rate = min(self%rate, increments(iteration)/last)
            next = (self%curvature*increments(iteration) + self%rate)*increments(iteration)
            if (is_last(self%tolerance, next, increments(iteration), can_estimate .and. last > 0.0_wp)) then
                u = u + self%increment
                report%outcome = merge(newton_converged, newton_singular, tangent%is_trusted)
                exit
            end if
            last = increments(iteration)
            call advance(self, tangent, system, stage, searching, u, last, report)
            if (report%outcome /= newton_slow) exit
            if (increments(iteration) > coarse_part) call widen(self, system, u)
        end do
        report%increments = increments(:report%iterations)
        report%residual = tangent%relative_residual(system, stage)
    end subroutine iterate

    !> Linearise at the guess or, where it is not admissible, at `origin`.
    subroutine start(tangent, system, stage, origin, u, report)
        class(linearised_t), intent(inout) :: tangent
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: origin(:)
        real(wp), intent(inout), contiguous :: u(:)
        type(newton_report_t), intent(out) :: report
        logical :: admissible

        call tangent%take_stage(stage)
        call tangent%evaluate(system, stage, u, admissible)
        if (.not. admissible) then
            where (.not. system%fixed) u = origin
            call tangent%evaluate(system, stage, u, admissible)
        end if
        if (admissible) return
        report%outcome = newton_inadmissible
        allocate (report%increments(0), report%rejected(size(u)))
        call stage%evaluation_point(u, report%rejected)
    end subroutine start

    !> Whether an increment may be made of rounding alone, and is to be left out then: it starts below the
    !> tolerance, or it is small, or late, and no longer shrinks.
    pure logical function may_be_rounding(tolerance, iteration, increment, last)
        real(wp), intent(in) :: tolerance
        integer, intent(in) :: iteration
        real(wp), intent(in) :: increment, last

        if (iteration == 1) then
            may_be_rounding = increment <= tolerance
        else
            may_be_rounding = increment > slow_part*last .and. (increment < small_part .or. iteration > late)
        end if
    end function may_be_rounding

    !> Whether an increment is below the tolerance or (estimating) the one that is to come next far below.
    pure logical function is_last(tolerance, next, increment, estimating)
        real(wp), intent(in) :: tolerance
        real(wp), intent(in) :: next                !! expected; 0: nothing is known
        real(wp), intent(in) :: increment
        logical, intent(in) :: estimating

        is_last = increment <= tolerance
        if (estimating .and. next > 0.0_wp) is_last = is_last .or. next <= margin*tolerance
    end function is_last

    !> The increment at the point of linearisation, and its largest value over the fields, each relative to
    !> the largest value of its field so far.
    subroutine find_increment(self, tangent, system, largest, report)
        class(newton_t), intent(inout) :: self
        class(linearised_t), intent(inout) :: tangent
        type(system_t), intent(in) :: system
        real(wp), intent(out) :: largest
        type(newton_report_t), intent(inout) :: report
        real(wp) :: norm(n_fields)
        integer :: singular

        largest = 0.0_wp
        call tangent%solve(self%increment, singular)
        if (singular /= 0) then
            report%outcome = newton_singular
            report%singular_unknown = max(0, singular)
            return
        end if
        norm = largest_values(self%increment)
        if (.not. all(norm <= largest_part*max(system%field_scale, self%largest))) then
            report%singular_unknown = tangent%mechanism()
            report%outcome = merge(newton_singular, newton_diverged, report%singular_unknown > 0)
            return
        end if
        largest = maxval(norm/self%largest)
    end subroutine find_increment

    !> Keep the largest value of every field so far.
    pure subroutine widen(self, system, u)
        class(newton_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        real(wp), intent(in), contiguous :: u(:)

        self%largest = max(self%largest, largest_values(u), smallest_part*system%field_scale)
    end subroutine widen

    !> Take the increment, halved until the new state is admissible and, when searching, until it is better.
    subroutine advance(self, tangent, system, stage, searching, u, last, report)
        class(newton_t), intent(inout) :: self
        class(linearised_t), intent(inout) :: tangent
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        logical, intent(in) :: searching
        real(wp), intent(inout), contiguous :: u(:)
        real(wp), intent(inout) :: last             !! made 0 where the increment is not taken whole
        type(newton_report_t), intent(inout) :: report
        real(wp) :: part, slope, merit, trial_merit
        logical :: admissible, has_met_inadmissible
        integer :: halving

        slope = 0.0_wp
        merit = 0.0_wp
        if (searching) call measure(self, system, stage, u, merit, slope)
        has_met_inadmissible = .false.
        part = 1.0_wp
        u = u + self%increment
        do halving = 0, max_halvings
            call tangent%evaluate(system, stage, u, admissible)
            if (admissible .and. searching) then
                call measure(self, system, stage, u, trial_merit)
                admissible = trial_merit <= merit + 1.0e-4_wp*part*slope + 8.0_wp*epsilon(merit)*abs(merit)
            else if (.not. admissible) then
                if (.not. has_met_inadmissible) report%rejected = evaluated(stage, u)
                has_met_inadmissible = .true.
            end if
            if (admissible) then
                if (halving > 0) last = 0.0_wp
                return
            end if
            part = 0.5_wp*part
            u = u - part*self%increment
        end do
        report%outcome = merge(newton_inadmissible, newton_stuck, has_met_inadmissible)
    end subroutine advance

    !> Where a state's internal force is evaluated.
    pure function evaluated(stage, u) result(u_e)
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp) :: u_e(size(u))

        call stage%evaluation_point(u, u_e)
    end function evaluated

    !> Whether rounding alone explains the residual at u, where `tangent` has been evaluated. It is no more
    !> than sum |k_ij| |d_j|: where no increment d_j is above unit round-off times the least that its field
    !> counts for in the bound, the bound, which costs a tangent, need not be known. So a beam that waits at
    !> rest for its load costs little.
    logical function is_round_off(self, tangent, system, stage, u)
        class(newton_t), intent(in) :: self
        class(linearised_t), intent(inout) :: tangent
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp), allocatable :: r(:), bound(:)
        real(wp) :: least(n_fields)

        least = system%field_scale
        least(1:2) = 2.0_wp*minval(system%half_length)
        is_round_off = all(largest_values(self%increment) <= epsilon(1.0_wp)*least)
        if (is_round_off) return
        allocate (r(system%n), bound(system%n))
        call tangent%residual(system, stage, u, r)
        call system%round_off(evaluated(stage, u), stage%force_factor, stage%mass_factor, bound)
        is_round_off = all(abs(r) <= bound)
    end function is_round_off

    !> What a line search compares at u, where `evaluate` has just been: the stage's potential and its slope
    !> along the increment; where there is none (unsymmetric tangent), half the square of the residual.
    subroutine measure(self, system, stage, u, merit, slope)
        class(newton_t), intent(in) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out) :: merit
        real(wp), intent(out), optional :: slope
        real(wp), allocatable :: drag(:)
        logical :: admissible

        if (self%is_symmetric) then
            call system%strain_energy(self%banded%u_e, merit, admissible)
            merit = merit/stage%force_factor - dot_product(stage%f_external, u)
            if (stage%mass_factor > 0.0_wp) merit = merit + stage%mass_factor*system%mass%energy(u &
                - stage%u_mass)
            if (stage%mass_factor > 0.0_wp .and. allocated(system%damping%a)) then
                allocate (drag(system%n))
                call system%damping%multiply(u - stage%u_damping, drag)
                merit = merit + 0.5_wp*stage%damping_factor*dot_product(u - stage%u_damping, drag)
            end if
            if (present(slope)) slope = dot_product(self%banded%r, self%increment)
        else
            merit = 0.5_wp*sum((reshape(self%banded%r, [n_fields, system%n/n_fields]) &
                                *spread(system%field_scale, 2, system%n/n_fields))**2)
            if (present(slope)) slope = -2.0_wp*merit
        end if
    end subroutine measure

end module gb_newton
