!> TRANSIENT: implicit time integration in steps that end on every jump or corner of a load history. A step is
!> proposed, solved and only then committed; one that fails leaves the committed state as it was and is repeated in
!> halves.
module gb_transient
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
    use gb_text, only: to_text
    use gb_band, only: band_t
    use gb_mesh, only: mesh_t
    use gb_problem, only: task_t
    use gb_state, only: state_t
    use gb_recorder, only: recorder_t, step_record_t
    use gb_system, only: system_t
    use gb_external, only: external_t
    use gb_stage, only: stage_t
    use gb_newton, only: newton_t, newton_report_t, newton_converged
    use gb_substeps, only: substeps_t
    use gb_scheme, only: scheme_t
    use gb_schemes, only: make_scheme
    use gb_failure, only: failure_reason
    implicit none
    private

    public :: run_transient, equilibrium_acceleration

    !> Two instants closer than this part of a step are one.
    real(wp), parameter :: same_instant = 1.0e-9_wp

    !> All that one step needs, so that it is allocated once.
    type :: stepper_t
        class(scheme_t), allocatable :: scheme
        type(newton_t) :: newton
        type(newton_report_t) :: report
        type(stage_t) :: stage
        type(state_t) :: previous, trial
        real(wp), allocatable :: f_start(:), f_end(:)   !! external force at the start (after a jump) and the end (before one)
    end type stepper_t

contains

    !> Integrate from rest or from the state's velocities over task%end_time; every step is told to the recorder.
    !> On failure the state is that of the last step solved.
    subroutine run_transient(system, external, mesh, task, state, recorder, error)
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        type(task_t), intent(in) :: task
        type(state_t), intent(inout) :: state
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(stepper_t) :: stepper
        type(substeps_t) :: parts
        type(step_record_t) :: step
        real(wp), allocatable :: events(:)
        real(wp) :: from, target
        integer :: grid
        logical :: admissible

        call make_scheme(task, stepper%scheme)
        call stepper%newton%set_up(system, task%tolerance, task%iterations)
        allocate (stepper%f_start(system%n), stepper%f_end(system%n), stepper%stage%f_external(system%n))
        parts%max_level = task%cuts
        state%time = 0.0_wp
        call external%force_at(0.0_wp, .false., stepper%f_start, error)
        if (allocated(error)) return
        call equilibrium_acceleration(system, stepper%f_start, state, error)
        if (allocated(error)) return
        step%kinetic = system%kinetic_energy(state%v)
        call system%strain_energy(state%u, step%strain, admissible)
        call recorder%record_step(step, state, error)
        if (allocated(error)) return
        stepper%previous = state
        stepper%trial = state
        events = external%events(task%end_time)
        grid = 0
        do while (state%time < task%end_time)
            from = state%time
            call next_instant(task, events, from, grid, target, step%on_grid)
            call walk(stepper, system, external, mesh, from, target, parts, state, step, error)
            if (allocated(error)) then
                error%message = 'TRANSIENT: step ' // to_text(step%number + 1) // error%message
                return
            end if
            step%number = step%number + 1
            step%abscissa = state%time
            step%step = target - from
            step%progress = state%time/task%end_time
            step%residual = stepper%report%residual
            step%increments = stepper%report%increments
            step%kinetic = system%kinetic_energy(state%v)
            call system%strain_energy(state%u, step%strain, admissible)
            call recorder%record_step(step, state, error)
            if (allocated(error)) return
        end do
    end subroutine run_transient

    !> Where the step that starts at `from` ends: on the next multiple of the step, on a load's event, or at the end.
    pure subroutine next_instant(task, events, from, grid, target, on_grid)
        type(task_t), intent(in) :: task
        real(wp), intent(in) :: events(:)           !! increasing [T]
        real(wp), intent(in) :: from                !! [T]
        integer, intent(inout) :: grid              !! multiples of the step behind
        real(wp), intent(out) :: target             !! [T]
        logical, intent(out) :: on_grid             !! whether it is a multiple of the step, or the end
        real(wp) :: slack, multiple
        integer :: i

        slack = same_instant*task%step
        multiple = real(grid + 1, wp)*task%step
        if (multiple > task%end_time - slack) multiple = task%end_time
        target = multiple
        on_grid = .true.
        do i = 1, size(events)
            if (events(i) <= from + slack) cycle
            if (events(i) < multiple - slack) then
                target = events(i)
                on_grid = .false.
            else if (events(i) <= multiple + slack) then
                target = events(i)
            end if
            exit
        end do
        if (on_grid) grid = grid + 1
    end subroutine next_instant

    !> Go from one instant to the next, in as many halvings as it takes.
    subroutine walk(stepper, system, external, mesh, from, target, parts, state, step, error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        real(wp), intent(in) :: from, target        !! [T]
        type(substeps_t), intent(inout) :: parts
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: until, part
        logical :: exhausted, is_solved

        step%iterations = 0
        step%cuts = 0
        call parts%begin_interval()
        do while (.not. parts%is_finished())
            part = parts%next_end()
            until = merge(target, from + (target - from)*part, part >= 1.0_wp)
            call propose(stepper, system, external, state, until, step, is_solved, error)
            if (allocated(error)) return
            if (.not. is_solved) then
                step%cuts = step%cuts + 1
                call parts%reject(exhausted)
                if (.not. exhausted) cycle
                call raise(error, status_solution, ' failed from t = ' // to_text(state%time) // ' to ' // to_text(until) &
                           // ' after ' // to_text(parts%max_level) // ' cuts: ' &
                           // failure_reason(system, stepper%report, stepper%trial%u, mesh%x) &
                           // '. Try a smaller step=, or a scheme that damps or conserves')
                return
            end if
            step%external = step%external + 0.5_wp*dot_product(stepper%f_start + stepper%f_end, stepper%trial%u - state%u)
            call commit(stepper, system, external, state, error)
            if (allocated(error)) return
            call parts%accept()
        end do
    end subroutine walk

    !> Solve the stages of a step that ends at `until`; the committed state is not touched.
    subroutine propose(stepper, system, external, state, until, step, is_solved, error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(state_t), intent(in) :: state
        real(wp), intent(in) :: until               !! [T]
        type(step_record_t), intent(inout) :: step
        logical, intent(out) :: is_solved
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: dt, fraction, weight
        integer :: number

        dt = until - state%time
        stepper%previous = state
        do number = 1, stepper%scheme%stages
            call stepper%scheme%load_mix(number, fraction, weight)
            stepper%trial%time = merge(until, state%time + fraction*dt, fraction >= 1.0_wp)
            call external%force_at(stepper%trial%time, .true., stepper%f_end, error)
            if (allocated(error)) return
            call stepper%scheme%set_stage(number, dt, state, stepper%previous, stepper%stage)
            stepper%stage%f_external = weight*stepper%f_end + (1.0_wp - weight)*stepper%f_start
            call guess(system, stepper%stage, fraction*dt, state, stepper%trial%u)
            call stepper%newton%solve(system, stepper%stage, stepper%trial%u, stepper%report)
            step%iterations = step%iterations + stepper%report%iterations
            is_solved = stepper%report%outcome == newton_converged
            if (.not. is_solved) return
            call stepper%scheme%finish_stage(number, dt, state, stepper%previous, stepper%trial)
            call settle_massless(system, fraction*dt, state, stepper%trial)
            if (number < stepper%scheme%stages) stepper%previous = stepper%trial
        end do
    end subroutine propose

    !> First guess of a stage: the velocities go on; where that is inadmissible, nothing moves.
    pure subroutine guess(system, stage, dt, state, u)
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: dt
        type(state_t), intent(in) :: state
        real(wp), intent(inout) :: u(:)
        real(wp) :: energy, u_e(size(u))
        logical :: admissible

        u = state%u + dt*state%v
        call stage%evaluation_point(u, u_e)
        call system%strain_energy(u_e, energy, admissible)
        if (.not. admissible) u = state%u
    end subroutine guess

    !> Fields without inertia follow the others: the scheme's own formulas would let their derivatives, which nothing
    !> depends on, alternate from step to step.
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

    !> The proposed state becomes the committed one; where a load jumps there, the acceleration is computed anew.
    subroutine commit(stepper, system, external, state, error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error

        state%time = stepper%trial%time
        state%u = stepper%trial%u
        state%v = stepper%trial%v
        state%a = stepper%trial%a
        call external%force_at(state%time, .false., stepper%f_start, error)
        if (allocated(error)) return
        if (any(abs(stepper%f_start - stepper%f_end) > 0.0_wp)) then
            call equilibrium_acceleration(system, stepper%f_start, state, error)
        end if
    end subroutine commit

    !> state%a from M a = f - f_int(u), held fields and fields without inertia at zero.
    subroutine equilibrium_acceleration(system, force, state, error)
        type(system_t), intent(in) :: system
        real(wp), intent(in) :: force(:)
        type(state_t), intent(inout) :: state
        type(error_t), allocatable, intent(out) :: error
        type(band_t) :: mass
        real(wp), allocatable :: internal(:), a(:, :)
        integer :: i, singular
        logical :: admissible

        allocate (internal(system%n), a(system%n, 1))
        call system%internal_force(state%u, internal, admissible)
        if (.not. admissible) then
            call raise(error, status_solution, 'TRANSIENT: the start state is not admissible (J <= 0 or I1-2 >= jm somewhere)')
            return
        end if
        mass = system%mass
        call mass%constrain(pack([(i, i=1, system%n)], system%fixed .or. system%massless))
        a(:, 1) = merge(0.0_wp, force - internal, system%fixed .or. system%massless)
        call mass%factorise(singular)
        call mass%solve(a)
        state%a = a(:, 1)
    end subroutine equilibrium_acceleration

end module gb_transient
