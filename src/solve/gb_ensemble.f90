!> TRANSIENT of several beams side by side, one beam a lane (gb_newton_lanes): members of a study that share
!> the number of elements, supports, time steps and scheme, and differ in numbers. Each gets what it would get
!> alone, whichever others are with it, in the same bits. A member that does not go through step by step is
!> given up: the ordinary path can cut steps and search, and has the words for what went wrong.
module gb_ensemble
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_fields, only: n_fields
    use gb_lanes, only: lanes
    use gb_problem, only: task_t, task_transient
    use gb_solver_choice, only: solver_lapack
    use gb_state, only: state_t
    use gb_recorder, only: recorder_t, step_record_t
    use gb_system, only: system_t
    use gb_external, only: external_t, events_t
    use gb_slots, only: has_square_power, has_chain_limit
    use gb_scheme, only: scheme_t
    use gb_schemes, only: make_scheme
    use gb_stage, only: stage_t
    use gb_transient, only: next_instant
    use gb_newton_lanes, only: newton_lanes_t
    implicit none
    private

    public :: fits_ensemble, are_alike, run_ensemble

    !> Unknowns of all beams lie as x(lanes, 5, nodes), one after the other.
    type :: ensemble_t
        integer :: members = 0
        integer :: n = 0                                !! unknowns of a beam
        class(scheme_t), allocatable :: scheme
        type(newton_lanes_t) :: newton
        type(stage_t) :: stage
        type(state_t) :: state                          !! committed, of all beams
        type(state_t) :: trial                          !! proposed
        type(state_t) :: unused                         !! no scheme here has two stages
        real(wp), allocatable :: f_start(:), f_end(:)   !! as stepper_t's (lanes n)
        real(wp), allocatable :: loads(:)               !! the forces computed last, and their factors
        real(wp), allocatable :: factors(:, :)          !! (patterns, lanes)
        logical, allocatable :: is_massless(:)          !! unknowns of a beam without inertia, if any (n)
        logical :: is_running(lanes) = .false.          !! the other lanes lie at rest without load
        real(wp) :: external(lanes) = 0.0_wp            !! work of the loads so far [F L]
        real(wp) :: strain(lanes) = 0.0_wp              !! energies of the committed states [F L]
        real(wp) :: kinetic(lanes) = 0.0_wp
    end type ensemble_t

contains

    !> Whether a TRANSIENT of this model can be run in a lane. It depends on nothing else: a member takes the
    !> same path, and gets the same bits, whichever other members there are.
    pure logical function fits_ensemble(system, external, task)
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(task_t), intent(in) :: task

        fits_ensemble = system%fits_block .and. .not. allocated(system%damping%a) .and. &
            .not. any(system%has_full_inertia) .and. task%kind == task_transient .and. &
            task%step > 0.0_wp .and. task%solver /= solver_lapack .and. &
            .not. external%motion%is_driven() .and. &
            (task%scheme == 'newmark' .or. task%scheme == 'hht' .or. task%scheme == 'generalized')
    end function fits_ensemble

    !> Whether two models that fit can share lanes in a command.
    pure logical function are_alike(system, external, task, other_system, other_external, other_task)
        type(system_t), intent(in) :: system, other_system
        type(external_t), intent(in) :: external, other_external
        type(task_t), intent(in) :: task, other_task
        type(events_t) :: events, other_events

        are_alike = .false.
        if (system%n_elements /= other_system%n_elements) return
        if (system%sections(system%kind(1))%nz /= other_system%sections(other_system%kind(1))%nz) return
        if (any(system%fixed .neqv. other_system%fixed)) return
        if (has_square_power(system) .neqv. has_square_power(other_system)) return
        if (has_chain_limit(system) .neqv. has_chain_limit(other_system)) return
        if (system%has_massless .neqv. other_system%has_massless) return
        if (system%has_massless) then
            if (any(system%massless .neqv. other_system%massless)) return
        end if
        if (task%scheme /= other_task%scheme .or. task%iterations /= other_task%iterations) return
        if (differ([task%end_time, task%step, task%beta, task%gamma, task%alpha, task%rho, task%tolerance], &
            [other_task%end_time, other_task%step, other_task%beta, other_task%gamma, other_task%alpha, &
            other_task%rho, other_task%tolerance])) return
        events = external%events(task%end_time, task%step)
        other_events = other_external%events(task%end_time, task%step)
        if (size(events%first) /= size(other_events%first)) return
        are_alike = .not. differ([events%first, events%last, events%start, events%end_time], &
            [other_events%first, other_events%last, other_events%start, other_events%end_time])
    end function are_alike

    pure logical function differ(a, b)
        real(wp), intent(in) :: a(:), b(:)

        differ = any(abs(a - b) > 0.0_wp)
    end function differ

    !> Run a TRANSIENT of at most `lanes` members that fit and are alike, those that are running; every step
    !> is told to each member's recorder. A member that is not running any more afterwards has been given up:
    !> its state and what its recorder was told are worthless.
    subroutine run_ensemble(systems, externals, task, states, recorders, is_running)
        type(system_t), intent(in) :: systems(:)
        type(external_t), intent(in) :: externals(:)
        type(task_t), intent(in) :: task
        type(state_t), intent(inout) :: states(:)
        class(recorder_t), intent(inout) :: recorders(:)
        logical, intent(inout) :: is_running(:)
        type(ensemble_t) :: ensemble
        type(step_record_t) :: step
        type(events_t) :: events
        real(wp) :: from, target, after
        integer :: grid, member
        logical :: at_event

        call set_up(ensemble, systems, externals, task, states, is_running)
        events = externals(1)%events(task%end_time, task%step)
        call restart(ensemble, systems, externals, events%start)
        call ensemble%newton%chain%strain_energy(ensemble%state%u, ensemble%strain, ensemble%kinetic)
        call report(ensemble, task, 0.0_wp, step, recorders)
        grid = 0
        do while (ensemble%state%time < events%end_time .and. any(ensemble%is_running))
            from = ensemble%state%time
            call next_instant(task, events, from, grid, target, after, step%on_grid, at_event)
            call take_step(ensemble, systems, externals, target)
            if (at_event) call pass_event(ensemble, systems, externals, after)
            step%number = step%number + 1
            call report(ensemble, task, target - from, step, recorders)
        end do
        do member = 1, size(systems)
            if (.not. ensemble%is_running(member)) cycle
            states(member)%time = ensemble%state%time
            states(member)%u = ensemble%state%u(member::lanes)
            states(member)%v = ensemble%state%v(member::lanes)
            states(member)%a = ensemble%state%a(member::lanes)
        end do
        is_running = ensemble%is_running(:size(systems))
    end subroutine run_ensemble

    subroutine set_up(self, systems, externals, task, states, is_running)
        class(ensemble_t), intent(inout) :: self
        type(system_t), intent(in) :: systems(:)
        type(external_t), intent(in) :: externals(:)
        type(task_t), intent(in) :: task
        type(state_t), intent(in) :: states(:)
        logical, intent(in) :: is_running(:)
        integer :: member, patterns

        self%members = size(systems)
        self%n = systems(1)%n
        call make_scheme(task, self%scheme)
        call self%newton%set_up(systems, task%tolerance, task%iterations)
        self%stage%needs_velocity = .false.
        if (systems(1)%has_massless) self%is_massless = systems(1)%massless
        associate (all_unknowns => lanes*self%n)
            allocate (self%f_start(all_unknowns), self%f_end(all_unknowns))
            allocate (self%stage%f_external(all_unknowns), self%loads(all_unknowns))
            allocate (self%state%u(all_unknowns), self%state%v(all_unknowns), self%state%a(all_unknowns))
        end associate
        self%state%u = 0.0_wp
        self%state%v = 0.0_wp
        self%state%a = 0.0_wp
        self%f_start = 0.0_wp
        self%f_end = 0.0_wp
        self%loads = 0.0_wp
        patterns = 0
        do member = 1, self%members
            patterns = max(patterns, size(externals(member)%patterns))
        end do
        allocate (self%factors(patterns, lanes))
        self%factors = 0.0_wp
        do member = 1, self%members
            self%is_running(member) = is_running(member)
            if (.not. is_running(member)) cycle
            self%state%u(member::lanes) = states(member)%u
            self%state%v(member::lanes) = states(member)%v
        end do
        self%trial = self%state
    end subroutine set_up

    !> Give a member up: its lane lies at rest without load.
    pure subroutine give_up(self, lane)
        class(ensemble_t), intent(inout) :: self
        integer, intent(in) :: lane

        self%is_running(lane) = .false.
        self%state%u(lane::lanes) = 0.0_wp
        self%state%v(lane::lanes) = 0.0_wp
        self%state%a(lane::lanes) = 0.0_wp
        self%trial%u(lane::lanes) = 0.0_wp
        self%trial%v(lane::lanes) = 0.0_wp
        self%trial%a(lane::lanes) = 0.0_wp
        self%f_start(lane::lanes) = 0.0_wp
        self%f_end(lane::lanes) = 0.0_wp
        self%loads(lane::lanes) = 0.0_wp
    end subroutine give_up

    !> External forces of all members; nothing is computed for loads that stay as they are.
    subroutine gather_loads(self, externals, t, before)
        class(ensemble_t), intent(inout) :: self
        type(external_t), intent(in) :: externals(:)
        real(wp), intent(in) :: t               !! [T]
        logical, intent(in) :: before           !! values just before a jump
        type(error_t), allocatable :: error
        real(wp) :: force(self%n), factors(size(self%factors, 1))
        integer :: member

        do member = 1, self%members
            if (.not. self%is_running(member)) cycle
            call externals(member)%factors_at(t, before, factors, error)
            if (.not. allocated(error)) then
                if (.not. differ(factors, self%factors(:, member))) cycle
                call externals(member)%forces(factors, force)
                self%loads(member::lanes) = force
                self%factors(:, member) = factors
            else
                call give_up(self, member)
                deallocate (error)
            end if
        end do
    end subroutine gather_loads

    !> At time 0: loads have their values from then on, and accelerations follow.
    subroutine restart(self, systems, externals, start)
        class(ensemble_t), intent(inout) :: self
        type(system_t), intent(in) :: systems(:)
        type(external_t), intent(in) :: externals(:)
        real(wp), intent(in) :: start           !! from when on all that happens at time 0 has happened [T]
        integer :: member

        call gather_loads(self, externals, start, .false.)
        self%f_start = self%loads
        do member = 1, self%members
            if (self%is_running(member)) call balance(self, systems(member), member)
        end do
    end subroutine restart

    !> The same after a jump or a corner, for members whose loads do jump.
    subroutine pass_event(self, systems, externals, after)
        class(ensemble_t), intent(inout) :: self
        type(system_t), intent(in) :: systems(:)
        type(external_t), intent(in) :: externals(:)
        real(wp), intent(in) :: after           !! from when on all of the event has happened [T]
        integer :: member

        call gather_loads(self, externals, after, .false.)
        self%f_start = self%loads
        do member = 1, self%members
            if (.not. self%is_running(member)) cycle
            if (differ(self%f_start(member::lanes), self%f_end(member::lanes))) then
                call balance(self, systems(member), member)
            end if
        end do
    end subroutine pass_event

    !> A member's acceleration from M a = f - f_int(u).
    subroutine balance(self, system, lane)
        class(ensemble_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        integer, intent(in) :: lane
        real(wp) :: u(self%n), r(self%n), a(self%n)
        logical :: without(self%n), admissible

        u = self%state%u(lane::lanes)
        call system%internal_force(u, r, admissible)
        if (.not. admissible) then
            call give_up(self, lane)
            return
        end if
        without = system%fixed
        if (system%has_massless) without = without .or. system%massless
        call system%mass%solve(without, self%f_start(lane::lanes) - r, a)
        self%state%a(lane::lanes) = merge(0.0_wp, a, without)
    end subroutine balance

    !> One step of all members, committed where it is solved.
    subroutine take_step(self, systems, externals, until)
        class(ensemble_t), intent(inout) :: self
        type(system_t), intent(in) :: systems(:)
        type(external_t), intent(in) :: externals(:)
        real(wp), intent(in) :: until               !! [T]
        real(wp) :: dt, fraction, weight, strain(lanes), room(lanes)
        integer :: lane

        dt = until - self%state%time
        call self%scheme%load_mix(1, fraction, weight)
        call gather_loads(self, externals, until, .true.)
        self%f_end = self%loads
        call self%scheme%set_stage(1, dt, self%state, self%unused, self%stage)
        self%stage%f_external = weight*self%f_end + (1.0_wp - weight)*self%f_start
        self%trial%u = self%state%u + dt*self%state%v
        call keep_held(systems(1)%fixed_list, self%n, self%state%u, self%trial%u)
        call self%newton%solve(systems, self%stage, self%state%u, self%is_running, self%trial%u)
        call self%newton%chain%strain_energy(self%trial%u, strain, room)
        do lane = 1, self%members
            if (.not. self%is_running(lane)) cycle
            if (self%newton%has_converged(lane) .and. room(lane) > 0.0_wp) cycle
            call give_up(self, lane)
        end do
        call self%scheme%finish_stage(1, dt, self%state, self%unused, self%trial)
        if (allocated(self%is_massless)) call settle_massless(self%n, self%is_massless, dt, self%state%u, &
            self%trial%u, self%trial%v, self%trial%a)
        call add_work(self%n, self%f_start, self%f_end, self%state%u, self%trial%u, self%external)
        self%strain = strain
        self%trial%time = until
        call self%state%exchange(self%trial)
        self%f_start = self%f_end
    end subroutine take_step

    !> Held unknowns stay where they are.
    pure subroutine keep_held(held, n, from, u)
        integer, intent(in) :: held(:), n
        real(wp), intent(in) :: from(lanes, n)
        real(wp), intent(inout) :: u(lanes, n)
        integer :: i

        do i = 1, size(held)
            u(:, held(i)) = from(:, held(i))
        end do
    end subroutine keep_held

    !> As stepper_t's: fields without inertia follow the others.
    pure subroutine settle_massless(n, is_massless, dt, from, u, v, a)
        integer, intent(in) :: n
        logical, intent(in) :: is_massless(n)
        real(wp), intent(in) :: dt, from(lanes, n), u(lanes, n)
        real(wp), intent(inout) :: v(lanes, n), a(lanes, n)
        integer :: i

        do i = 1, n
            if (.not. is_massless(i)) cycle
            v(:, i) = (u(:, i) - from(:, i))/dt
            a(:, i) = 0.0_wp
        end do
    end subroutine settle_massless

    !> Work of the loads on the way of a step.
    pure subroutine add_work(n, f_start, f_end, from, u, work)
        integer, intent(in) :: n
        real(wp), intent(in), dimension(lanes, n) :: f_start, f_end, from, u
        real(wp), intent(inout) :: work(lanes)
        real(wp) :: part(lanes)
        integer :: i

        part = 0.0_wp
        do i = 1, n
            part = part + (f_start(:, i) + f_end(:, i))*(u(:, i) - from(:, i))
        end do
        work = work + 0.5_wp*part
    end subroutine add_work

    !> Tell each member's recorder of the state that has been reached in a step of the given size.
    subroutine report(self, task, size_of_step, step, recorders)
        class(ensemble_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        real(wp), intent(in) :: size_of_step            !! [T]
        type(step_record_t), intent(inout) :: step
        class(recorder_t), intent(inout) :: recorders(:)
        type(error_t), allocatable :: error
        type(state_t) :: state
        integer :: member

        call self%newton%chain%kinetic_energy(self%state%v, self%kinetic)
        step%abscissa = self%state%time
        step%step = size_of_step
        step%progress = self%state%time/task%end_time
        state%time = self%state%time
        allocate (state%u(self%n), state%v(self%n), state%a(self%n))
        do member = 1, self%members
            if (.not. self%is_running(member)) cycle
            step%iterations = self%newton%iterations(member)
            step%residual = self%newton%residual(member)
            step%increments = self%newton%increments(:step%iterations, member)
            step%kinetic = self%kinetic(member)
            step%strain = self%strain(member)
            step%external = self%external(member)
            call take_lane(member, self%n, self%state%u, state%u)
            call take_lane(member, self%n, self%state%v, state%v)
            call take_lane(member, self%n, self%state%a, state%a)
            call recorders(member)%record_step(step, state, error)
            if (allocated(error)) call give_up(self, member)
        end do
    end subroutine report

    pure subroutine take_lane(lane, n, all_lanes, own)
        integer, intent(in) :: lane, n
        real(wp), intent(in) :: all_lanes(lanes, n)
        real(wp), intent(out) :: own(n)

        own = all_lanes(lane, :)
    end subroutine take_lane

end module gb_ensemble
