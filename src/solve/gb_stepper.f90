!> One step of a transient: proposed, solved, and only then committed; a step that fails leaves the committed
!> state as it was. The stepper also keeps the energy ledger.
module gb_stepper
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
    use gb_memory, only: memory_t
    use gb_text, only: to_text
    use gb_band, only: band_t
    use gb_problem, only: task_t
    use gb_solver_choice, only: solver_lapack
    use gb_state, only: state_t
    use gb_system, only: system_t
    use gb_external, only: external_t
    use gb_stage, only: stage_t
    use gb_newton, only: newton_t, newton_report_t, newton_converged, newton_inadmissible
    use gb_scheme, only: scheme_t
    use gb_schemes, only: make_scheme
    implicit none
    private

    !> The explicit scheme stays this far below its limit, which is computed anew every so many steps.
    real(wp), parameter :: limit_safety = 0.9_wp
    integer, parameter :: limit_interval = 20

    !> What a committed step changes besides the state.
    type :: mark_t
        type(state_t) :: state
        real(wp), allocatable :: factors_start(:), reaction(:)
        real(wp) :: external = 0.0_wp, dissipated = 0.0_wp, strain = 0.0_wp
        logical :: is_at_rest = .false.
    end type mark_t

    type, public :: stepper_t
        class(scheme_t), allocatable :: scheme
        type(newton_t) :: newton
        type(newton_report_t) :: report             !! of the last solution
        type(state_t) :: trial                      !! the state proposed
        type(state_t) :: previous                   !! end of the previous stage of the step
        type(stage_t) :: stage
        real(wp) :: span = 0.0_wp  !! natural step: driven supports are differentiated on its scale [T]
        real(wp), allocatable :: factors_start(:)   !! of loads at the committed state, after a jump
        real(wp), allocatable :: factors_end(:)     !! of loads at the proposed state, before a jump
        real(wp), allocatable :: lumped(:)          !! explicit scheme: diagonal mass (n)
        real(wp), allocatable :: reaction(:)        !! of the driven unknowns at the committed state
        real(wp) :: external = 0.0_wp               !! work of loads and driven supports so far [F L]
        real(wp) :: dissipated = 0.0_wp             !! energy taken by damping so far [F L]
        type(mark_t) :: mark                        !! where `go_back` returns to
        real(wp) :: strain = 0.0_wp                 !! strain energy of the committed state [F L]
        real(wp) :: trial_strain = 0.0_wp           !! and of the proposed one [F L]
        logical :: is_at_rest = .false.             !! whether the committed state is known to balance its
        logical :: trial_is_at_rest = .false.       !! loads without motion, and whether the proposed one is
        real(wp) :: limit = huge(1.0_wp)            !! explicit scheme: largest stable step [T] ...
        integer :: limit_age = 0                    !! ... and how many steps ago it was computed
        integer :: iterations = 0                   !! since the last call of `take_iterations`
    contains
        procedure :: start
        procedure :: resume
        procedure :: propose
        procedure :: commit
        procedure :: explicit_limit
        procedure :: remember
        procedure :: go_back
        procedure :: kinetic
        procedure :: take_iterations
        procedure :: pass_memory
    end type stepper_t

contains

    !> Make the state ready at time 0: driven supports in place, acceleration from equilibrium.
    subroutine start(self, system, external, task, span, state, error, after)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(task_t), intent(in) :: task
        real(wp), intent(in) :: span                !! [T]
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp), intent(in), optional :: after     !! as restart's; else 0
        logical :: admissible

        call prepare(self, system, external, task, span)
        state%time = 0.0_wp
        call restart(self, system, external, state, error, after)
        if (allocated(error)) return
        call self%newton%strain_energy(system, state%u, self%strain, admissible)
        if (self%scheme%is_explicit) call measure_limit(self, system, state)
        self%trial = state
    end subroutine start

    !> Make ready to go on from a state in the middle of a command, with what `memory` holds of the stepper.
    subroutine resume(self, system, external, task, span, memory, state)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(task_t), intent(in) :: task
        real(wp), intent(in) :: span                !! [T]
        type(memory_t), intent(inout) :: memory
        type(state_t), intent(in) :: state

        call prepare(self, system, external, task, span)
        call self%pass_memory(memory)
        self%trial = state
    end subroutine resume

    !> What a committed step leaves to the next one, besides the state.
    subroutine pass_memory(self, memory)
        class(stepper_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory

        call memory%pass('stepper.factors_start', self%factors_start)
        call memory%pass('stepper.reaction', self%reaction)
        call memory%pass('stepper.external', self%external)
        call memory%pass('stepper.dissipated', self%dissipated)
        call memory%pass('stepper.strain', self%strain)
        call memory%pass('stepper.is_at_rest', self%is_at_rest)
        call memory%pass('stepper.limit', self%limit)
        call memory%pass('stepper.limit_age', self%limit_age)
        call self%newton%pass_memory(memory)
    end subroutine pass_memory

    !> What does not depend on the state: the scheme, and room for what steps are made of.
    subroutine prepare(self, system, external, task, span)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(task_t), intent(in) :: task
        real(wp), intent(in) :: span                !! [T]

        call make_scheme(task, self%scheme)
        call self%newton%set_up(system, task%tolerance, task%iterations, &
            system%symmetric .and. self%scheme%has_symmetric_tangent, system%fits_block .and. &
            self%scheme%has_symmetric_tangent .and. .not. self%scheme%is_explicit .and. task%solver &
                /= solver_lapack)
        self%stage%needs_velocity = self%scheme%is_explicit .or. allocated(system%damping%a) .or. &
                                    any(system%has_full_inertia)
        allocate (self%factors_start(size(external%patterns)), self%factors_end(size(external%patterns)))
        allocate (self%stage%f_external(system%n))
        allocate (self%reaction(size(external%motion%unknown)))
        self%reaction = 0.0_wp
        if (self%scheme%is_explicit) self%lumped = system%lumped_mass()
        self%span = span
    end subroutine prepare

    !> At time 0 and after a jump: driven supports and loads have their values from then on, and accelerations
    !> follow.
    subroutine restart(self, system, external, state, error, after)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp), intent(in), optional :: after     !! the instant of these values, if not the state's [T]
        real(wp) :: instant, strain_before, strain_after
        logical :: admissible

        instant = state%time
        if (present(after)) instant = after
        if (external%motion%is_driven()) then
            call self%newton%strain_energy(system, state%u, strain_before, admissible)
            call external%motion%restart(instant, self%span, state, error)
            if (allocated(error)) return
            call self%newton%strain_energy(system, state%u, strain_after, admissible)
            if (admissible .and. state%time > 0.0_wp) self%external = self%external + strain_after &
                - strain_before
            if (admissible) self%strain = strain_after
        end if
        call external%factors_at(instant, .false., self%factors_start, error)
        if (allocated(error)) return
        call equilibrium_acceleration(self, system, external, self%factors_start, state, admissible)
        if (.not. admissible) then
            call raise(error, status_solution, 'TRANSIENT: the state at t = ' // to_text(state%time) // &
                       ' is not admissible (J <= 0 or I1-2 >= jm somewhere): check INITIAL and PRESCRIBE')
            return
        end if
        ! Fields without inertia have no acceleration that would tell whether they balance.
        self%is_at_rest = .not. (system%has_massless .or. external%motion%is_driven()) .and. &
            all(abs(state%v) <= 0.0_wp) .and. all(abs(state%a) <= 0.0_wp)
        if (external%motion%is_driven()) call find_reaction(self, system, external, self%factors_start, &
            state)
    end subroutine restart

    !> Solve for the state at time `until`. The committed state is not touched.
    subroutine propose(self, system, external, state, until, is_solved, error)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(state_t), intent(in) :: state
        real(wp), intent(in) :: until               !! [T]
        logical, intent(out) :: is_solved
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: dt, fraction, weight
        integer :: number

        dt = until - state%time
        call find_rest(self, external, state, until, is_solved, error)
        self%trial_is_at_rest = is_solved
        if (allocated(error) .or. is_solved) return
        do number = 1, self%scheme%stages
            call self%scheme%load_mix(number, fraction, weight)
            self%trial%time = merge(until, state%time + fraction*dt, fraction >= 1.0_wp)
            call external%factors_at(self%trial%time, .true., self%factors_end, error)
            if (allocated(error)) return
            call self%scheme%set_stage(number, dt, state, self%previous, self%stage)
            if (self%scheme%is_explicit) then
                call explicit_state(self, system, external, state, is_solved, error)
            else
                call external%forces(self%factors_end, self%stage%f_external, weight, self%factors_start)
                call solve_stage(self, system, external, fraction*dt, state, error)
                if (allocated(error)) return
                is_solved = self%report%outcome == newton_converged
            end if
            if (allocated(error) .or. .not. is_solved) return
            call self%scheme%finish_stage(number, dt, state, self%previous, self%trial)
            if (external%motion%is_driven()) call external%motion%follow(self%trial%time, fraction*dt, &
                self%trial, error)
            if (allocated(error)) return
            if (system%has_massless) call settle_massless(system, fraction*dt, state, self%trial)
            if (number < self%scheme%stages) self%previous = self%trial
        end do
        ! A scheme that balances forces elsewhere than at the end of the step may still end beyond the limits.
        call self%newton%strain_energy(system, self%trial%u, self%trial_strain, is_solved)
        if (.not. is_solved) then
            self%report%outcome = newton_inadmissible
            self%report%rejected = self%trial%u
        end if
    end subroutine propose

    !> A beam in equilibrium at rest whose loads stay as they are stays there: the same state is proposed,
    !> without an equation. `restart` has found it so: the acceleration that a scheme ends a step with may
    !> vanish without equilibrium.
    subroutine find_rest(self, external, state, until, is_at_rest, error)
        class(stepper_t), intent(inout) :: self
        type(external_t), intent(in) :: external
        type(state_t), intent(in) :: state
        real(wp), intent(in) :: until               !! [T]
        logical, intent(out) :: is_at_rest
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: fraction, weight
        integer :: number

        is_at_rest = .false.
        if (.not. self%is_at_rest) return
        do number = 1, self%scheme%stages
            call self%scheme%load_mix(number, fraction, weight)
            call external%factors_at(merge(until, state%time + fraction*(until - state%time), &
                fraction >= 1.0_wp), .true., self%factors_end, error)
            if (allocated(error)) return
            if (any(abs(self%factors_end - self%factors_start) > 0.0_wp)) return
        end do
        is_at_rest = .true.
        self%trial%time = until
        self%trial%u = state%u
        self%trial%v = 0.0_wp
        self%trial%a = 0.0_wp
        self%trial_strain = self%strain
        self%report = newton_report_t(outcome=newton_converged)
        allocate (self%report%increments(0))
    end subroutine find_rest

    !> Solve a stage by the block solver where it is in use, and by LAPACK's where it is not or fails.
    subroutine solve_stage(self, system, external, step, state, error)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        real(wp), intent(in) :: step                !! of the stage [T]
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error

        call guess(self, system, external, step, state, error)
        if (allocated(error)) return
        if (self%newton%has_block) then
            call self%newton%solve_block(system, self%stage, state%u, self%trial%u, self%report)
            self%iterations = self%iterations + self%report%iterations
            if (self%report%outcome == newton_converged) return
            call guess(self, system, external, step, state, error)
            if (allocated(error)) return
        end if
        call self%newton%solve(system, self%stage, state%u, self%trial%u, self%report)
        self%iterations = self%iterations + self%report%iterations
    end subroutine solve_stage

    !> Put the driven unknowns where they are at the end of the stage, and let inertia and damping act on the
    !> derivatives of their histories: those that a scheme would make of the displacements alone drift.
    subroutine drive(self, external, step, state, error)
        class(stepper_t), intent(inout) :: self
        type(external_t), intent(in) :: external
        real(wp), intent(in) :: step                !! of the stage [T]
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error

        call external%motion%follow(self%trial%time, step, self%trial, error)
        if (allocated(error)) return
        associate (i => external%motion%unknown, weight_a => self%scheme%weight_a, &
            weight_v => self%scheme%weight_v)
            self%stage%u_mass(i) = self%trial%u(i) - (weight_a*self%trial%a(i) &
                                                      + (1.0_wp - weight_a)*state%a(i))/self%stage%mass_factor
            if (self%stage%needs_velocity) self%stage%u_damping(i) = self%trial%u(i) &
                - (weight_v*self%trial%v(i) &
                                                         + (1.0_wp &
                                                         - weight_v)*state%v(i))/self%stage%damping_factor
        end associate
    end subroutine drive

    !> The state of an explicit scheme: displacements as predicted, acceleration from equilibrium with lumped
    !> mass.
    subroutine explicit_state(self, system, external, state, is_solved, error)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(state_t), intent(in) :: state
        logical, intent(out) :: is_solved
        type(error_t), allocatable, intent(out) :: error

        self%trial%u = self%stage%u_mass
        self%trial%u(system%fixed_list) = state%u(system%fixed_list)
        self%trial%v = self%stage%damping_factor*(self%trial%u - self%stage%u_damping)
        self%trial%a = state%a
        if (external%motion%is_driven()) call external%motion%follow(self%trial%time, &
            self%trial%time - state%time, self%trial, error)
        if (allocated(error)) return
        call equilibrium_acceleration(self, system, external, self%factors_end, self%trial, is_solved)
        self%report = newton_report_t(outcome=newton_converged)
        if (.not. is_solved) then
            self%report%outcome = newton_inadmissible
            self%report%rejected = self%trial%u
        end if
        allocate (self%report%increments(0))
    end subroutine explicit_state

    !> First guess of a stage: the velocities go on, and driven supports are where they are at its end.
    subroutine guess(self, system, external, dt, state, error)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error
        integer :: i

        self%trial%u = state%u + dt*state%v
        do i = 1, size(system%fixed_list)
            associate (fixed => system%fixed_list(i))
                self%trial%u(fixed) = state%u(fixed)
            end associate
        end do
        if (external%motion%is_driven()) call drive(self, external, dt, state, error)
    end subroutine guess

    !> Fields without inertia follow the others: the scheme's own formulas would let their derivatives, which
    !> nothing depends on, alternate from step to step.
    pure subroutine settle_massless(system, dt, state, reached)
        type(system_t), intent(in) :: system
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: state
        type(state_t), intent(inout) :: reached

        where (system%massless)
            reached%v = (reached%u - state%u)/dt
            reached%a = 0.0_wp
        end where
    end subroutine settle_massless

    !> The proposed state becomes the committed one, and the ledger is carried on.
    subroutine commit(self, system, external, at_event, state, error, after)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        logical, intent(in) :: at_event  !! whether a load or a driven support jumps or has a corner there
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp), intent(in), optional :: after     !! as restart's, at an event
        real(wp), allocatable :: drag(:)
        real(wp) :: instant

        self%external = self%external + external%work(self%factors_start, self%factors_end, state%u, &
            self%trial%u)
        if (allocated(system%damping%a)) then
            allocate (drag(system%n))
            call system%drag(0.5_wp*(state%v + self%trial%v), drag)
            self%dissipated = self%dissipated + dot_product(drag, self%trial%u - state%u)
        end if
        if (external%motion%is_driven()) call add_support_work(self, system, external, state)
        self%strain = self%trial_strain
        self%is_at_rest = self%trial_is_at_rest
        self%limit_age = self%limit_age + 1
        call state%exchange(self%trial)
        if (at_event) then
            instant = state%time
            if (present(after)) instant = after
            call external%factors_at(instant, .false., self%factors_start, error)
            if (allocated(error)) return
            if (external%motion%is_driven() .or. &
                any(abs(self%factors_start - self%factors_end) > 0.0_wp)) then
                call restart(self, system, external, state, error, after)
            end if
        else
            self%factors_start = self%factors_end
        end if
    end subroutine commit

    !> Work of the driven supports over the step from `state` to the proposed one: by the mean of their
    !> reactions at its ends, or by the reaction to a force that is itself the mean over the step.
    subroutine add_support_work(self, system, external, state)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(state_t), intent(in) :: state
        real(wp), allocatable :: mean(:), before(:)

        if (self%stage%averages_force) then
            mean = mean_reaction(self, system, external, state)
        else
            before = self%reaction
            call find_reaction(self, system, external, self%factors_end, self%trial)
            mean = 0.5_wp*(before + self%reaction)
        end if
        associate (i => external%motion%unknown)
            self%external = self%external + dot_product(mean, self%trial%u(i) - state%u(i))
        end associate
    end subroutine add_support_work

    !> Residual of an averaging stage at the driven unknowns.
    function mean_reaction(self, system, external, state) result(mean)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(state_t), intent(in) :: state
        real(wp), allocatable :: mean(:)
        real(wp), allocatable :: r(:), part(:)
        logical :: admissible

        allocate (r(system%n), part(system%n))
        associate (stage => self%stage, u => self%trial%u)
            call self%newton%prepare_banded(system)
            call system%average_tangent(state%u, u, r, self%newton%banded%k, admissible)
            call system%mass%multiply(stage%mass_factor*(u - stage%u_mass), part)
            r = r + part - stage%f_external
            if (allocated(system%damping%a)) then
                call system%drag(stage%damping_factor*(u - stage%u_damping), part)
                r = r + part
            end if
        end associate
        mean = r(external%motion%unknown)
    end function mean_reaction

    !> Largest step that the explicit scheme takes at the committed state [T], computed anew now and then.
    real(wp) function explicit_limit(self, system, state)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(state_t), intent(in) :: state

        if (self%limit_age >= limit_interval) call measure_limit(self, system, state)
        explicit_limit = self%limit
    end function explicit_limit

    subroutine measure_limit(self, system, state)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(state_t), intent(in) :: state

        call system%stable_step(state%u, self%limit)
        self%limit = limit_safety*self%limit
        self%limit_age = 0
    end subroutine measure_limit

    !> Keep the committed state, so that steps committed from here on can be taken back.
    subroutine remember(self, state)
        class(stepper_t), intent(inout) :: self
        type(state_t), intent(in) :: state

        self%mark%state = state
        self%mark%factors_start = self%factors_start
        self%mark%reaction = self%reaction
        self%mark%external = self%external
        self%mark%dissipated = self%dissipated
        self%mark%strain = self%strain
        self%mark%is_at_rest = self%is_at_rest
    end subroutine remember

    !> Return to the state that was remembered.
    subroutine go_back(self, state)
        class(stepper_t), intent(inout) :: self
        type(state_t), intent(inout) :: state

        state = self%mark%state
        self%factors_start = self%mark%factors_start
        self%reaction = self%mark%reaction
        self%external = self%mark%external
        self%dissipated = self%mark%dissipated
        self%strain = self%mark%strain
        self%is_at_rest = self%mark%is_at_rest
    end subroutine go_back

    !> state%a from M a = f - f_int(u) - C v - (inertia force at a = 0); held fields keep their acceleration
    !> (that of the drive, or none), fields without inertia have none.
    subroutine equilibrium_acceleration(self, system, external, factors, state, admissible)
        class(stepper_t), intent(in) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        real(wp), intent(in) :: factors(:)          !! of loads
        type(state_t), intent(inout) :: state
        logical, intent(out) :: admissible
        type(band_t) :: mass
        real(wp), allocatable :: r(:), part(:), held(:)
        logical, allocatable :: without(:)
        integer :: i, singular

        allocate (r(system%n), part(system%n), held(system%n))
        call system%internal_force(state%u, r, admissible)
        if (.not. admissible) return
        call external%forces(factors, part)
        r = r - part
        if (allocated(system%damping%a)) then
            call system%drag(state%v, part)
            r = r + part
        end if
        held = 0.0_wp
        held(external%motion%unknown) = state%a(external%motion%unknown)
        without = system%fixed
        if (system%has_massless) without = without .or. system%massless
        if (self%scheme%is_explicit) then
            state%a = merge(held, (-r)/merge(1.0_wp, self%lumped, without), without)
            return
        end if
        if (any(system%has_full_inertia)) then
            call mass%set_up(system%n, system%kd, symmetric=.true.)
            call system%add_inertia(state%u, state%v, held, [0.0_wp, 0.0_wp, 1.0_wp], r, mass)
            call mass%constrain(pack([(i, i=1, system%n)], without))
            state%a = merge(0.0_wp, -r, without)
            call mass%factorise(singular)
            call mass%solve(1, state%a)
        else
            if (external%motion%is_driven()) then
                call system%mass%multiply(held, part)
                r = r + part
            end if
            call system%mass%solve(without, -r, state%a)
        end if
        state%a = merge(held, state%a, without)
    end subroutine equilibrium_acceleration

    !> What the drives push with: f_int + inertia + C v - f at the driven unknowns.
    subroutine find_reaction(self, system, external, factors, state)
        class(stepper_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        real(wp), intent(in) :: factors(:)          !! of loads
        type(state_t), intent(in) :: state
        type(band_t) :: mass
        real(wp), allocatable :: r(:), part(:)
        logical :: admissible

        allocate (r(system%n), part(system%n))
        call system%internal_force(state%u, r, admissible)
        if (self%scheme%is_explicit) then
            r = r + self%lumped*state%a
        else if (any(system%has_full_inertia)) then
            call mass%set_up(system%n, system%kd, symmetric=.true.)
            call system%add_inertia(state%u, state%v, state%a, [0.0_wp, 0.0_wp, 1.0_wp], r, mass)
        else
            call system%mass%multiply(state%a, part)
            r = r + part
        end if
        if (allocated(system%damping%a)) then
            call system%drag(state%v, part)
            r = r + part
        end if
        call external%forces(factors, part)
        self%reaction = r(external%motion%unknown) - part(external%motion%unknown)
    end subroutine find_reaction

    !> Kinetic energy of a state, with the mass that the scheme works with [F L].
    pure real(wp) function kinetic(self, system, state)
        class(stepper_t), intent(in) :: self
        type(system_t), intent(in) :: system
        type(state_t), intent(in) :: state

        if (self%scheme%is_explicit) then
            kinetic = 0.5_wp*sum(self%lumped*state%v**2)
        else
            kinetic = self%newton%kinetic_energy(system, state%u, state%v)
        end if
    end function kinetic

    !> Newton iterations since the last call.
    integer function take_iterations(self)
        class(stepper_t), intent(inout) :: self

        take_iterations = self%iterations
        self%iterations = 0
    end function take_iterations

end module gb_stepper
