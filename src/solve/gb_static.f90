!> STATIC: equilibrium under loads that grow in steps, by Newton's method; a load step that fails is cut in
!> halves.
module gb_static
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
    use gb_memory, only: memory_t
    use gb_text, only: to_text
    use gb_mesh, only: mesh_t
    use gb_problem, only: task_t
    use gb_solver_choice, only: solver_lapack
    use gb_state, only: state_t
    use gb_recorder, only: recorder_t, step_record_t
    use gb_system, only: system_t
    use gb_external, only: external_t
    use gb_stage, only: stage_t
    use gb_newton, only: newton_t, newton_report_t, newton_converged
    use gb_substeps, only: substeps_t
    use gb_failure, only: failure_reason
    implicit none
    private

    public :: run_static

    !> What the loop over the load steps carries from one to the next.
    type :: pace_t
        real(wp) :: start = 0.0_wp                  !! load factor at the start of the command [-]
        real(wp), allocatable :: last_change(:)     !! of the displacements, in the last part of a step (n)
        real(wp) :: last_factor = 0.0_wp            !! what the load factor changed by in it; 0: no guide
        real(wp), allocatable :: reaction(:)        !! of the driven unknowns
        type(substeps_t) :: parts                   !! halvings in force
    contains
        procedure :: pass_memory => pass_pace
    end type pace_t

contains

    !> From the state's load factor to task%load in task%steps equal steps; every step is told to the
    !> recorder. A memory that is being recalled takes the place of the start: the command goes on from there.
    !> On failure the state is the last equilibrium found.
    subroutine run_static(system, external, mesh, task, memory, state, recorder, error)
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        type(task_t), intent(in) :: task
        type(memory_t), intent(inout) :: memory
        type(state_t), intent(inout) :: state
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(newton_t) :: newton
        type(newton_report_t) :: report
        type(stage_t) :: stage
        type(pace_t) :: pace
        type(step_record_t) :: step
        real(wp), allocatable :: force(:), u(:)
        real(wp) :: from, target
        integer :: i
        logical :: exhausted, admissible

        call newton%set_up(system, task%tolerance, task%iterations, &
                           block=system%fits_block .and. task%solver /= solver_lapack)
        allocate (force(system%n), stage%f_external(system%n))
        call external%static_forces(force)
        allocate (pace%last_change(system%n), pace%reaction(size(external%motion%unknown)), u(system%n))
        pace%parts%max_level = task%cuts
        if (memory%is_recalling) then
            call pass_all(newton, pace, state, step, memory)
            call memory%check(error)
        else
            call start(newton, system, external, force, pace, state, step)
            call recorder%record_step(step, state, error)
        end if
        if (allocated(error)) return
        do i = step%number + 1, task%steps
            step%iterations = 0
            step%cuts = 0
            from = state%load
            target = pace%start + (task%load - pace%start)*real(i, wp)/real(task%steps, wp)
            if (i == task%steps) target = task%load
            call pace%parts%begin_interval()
            do while (.not. pace%parts%is_finished())
                associate (factor => from + (target - from)*pace%parts%next_end(), &
                    last_factor => pace%last_factor, last_change => pace%last_change)
                    stage%f_external = factor*force
                    report = newton_report_t()
                    call guess(external, state, factor, last_factor, last_change, u)
                    if (newton%has_block) then
                        call newton%solve_block(system, stage, state%u, u, report)
                        if (report%outcome /= newton_converged) then
                            step%iterations = step%iterations + report%iterations
                            call guess(external, state, factor, last_factor, last_change, u)
                        end if
                    end if
                    if (report%outcome /= newton_converged) call newton%solve(system, stage, state%u, u, &
                        report)
                    step%iterations = step%iterations + report%iterations
                    if (report%outcome /= newton_converged) then
                        step%cuts = step%cuts + 1
                        call pace%parts%reject(exhausted)
                        last_factor = 0.0_wp
                        if (exhausted) then
                            call raise(error, status_solution, 'STATIC: step ' // to_text(i) // ' of ' &
                                // to_text(task%steps) // ' failed at load factor ' // to_text(factor) &
                                // ' after ' // to_text(task%cuts) // ' cuts: ' // trim(failure_reason( &
                                system, report, u, mesh%x)) // &
                                '. Try more steps=, or stop at a smaller load=')
                            return
                        end if
                        cycle
                    end if
                    last_change = u - state%u
                    last_factor = factor - state%load
                    step%external = step%external &
                                    + 0.5_wp*(state%load + factor)*dot_product(force, last_change)
                    call add_support_work(system, external, stage, u, last_change, pace%reaction, &
                        step%external)
                    state%u = u
                    state%load = factor
                    call pace%parts%accept()
                end associate
            end do
            step%number = i
            step%abscissa = state%load
            step%step = state%load - from
            step%progress = real(i, wp)/real(task%steps, wp)
            step%residual = report%residual
            step%increments = report%increments
            call newton%strain_energy(system, state%u, step%strain, admissible)
            call recorder%record_step(step, state, error)
            if (.not. allocated(error)) call offer_memory(newton, pace, state, step, recorder, error)
            if (allocated(error)) return
        end do
    end subroutine run_static

    !> First guess of a load step: the last change goes on; driven supports follow the load factor.
    subroutine guess(external, state, factor, last_factor, last_change, u)
        type(external_t), intent(in) :: external
        type(state_t), intent(in) :: state
        real(wp), intent(in) :: factor              !! load factor aimed at [-]
        real(wp), intent(in) :: last_factor         !! last increase of it; 0: nothing to go on with
        real(wp), intent(in) :: last_change(:)      !! of the displacements in it (n)
        real(wp), intent(inout) :: u(:)

        u = state%u
        if (abs(last_factor) > 0.0_wp) u = u + ((factor - state%load)/last_factor)*last_change
        call external%motion%impose_factor(factor, u)
    end subroutine guess

    !> The state the command starts from, at rest, and its record.
    subroutine start(newton, system, external, force, pace, state, step)
        type(newton_t), intent(inout) :: newton
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        real(wp), intent(in) :: force(:)            !! loads at factor 1 (n)
        type(pace_t), intent(inout) :: pace
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        logical :: admissible

        state%v = 0.0_wp
        state%a = 0.0_wp
        pace%start = state%load
        call system%internal_force(state%u, pace%last_change, admissible)
        associate (i => external%motion%unknown)
            pace%reaction = pace%last_change(i) - pace%start*force(i)
        end associate
        pace%last_change = 0.0_wp
        step%abscissa = pace%start
        call newton%strain_energy(system, state%u, step%strain, admissible)
    end subroutine start

    subroutine pass_pace(self, memory)
        class(pace_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory

        call memory%pass('pace.start', self%start)
        call memory%pass('pace.last_change', self%last_change)
        call memory%pass('pace.last_factor', self%last_factor)
        call memory%pass('pace.reaction', self%reaction)
        call self%parts%pass_memory(memory)
    end subroutine pass_pace

    !> All that the next load step depends on.
    subroutine pass_all(newton, pace, state, step, memory)
        type(newton_t), intent(inout) :: newton
        type(pace_t), intent(inout) :: pace
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        type(memory_t), intent(inout) :: memory

        call state%pass_memory(memory, 'state')
        call step%pass_memory(memory, 'step')
        call pace%pass_memory(memory)
        call newton%pass_memory(memory)
    end subroutine pass_all

    !> After a step: where the recorder asks for it, hand it all that.
    subroutine offer_memory(newton, pace, state, step, recorder, error)
        type(newton_t), intent(inout) :: newton
        type(pace_t), intent(inout) :: pace
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(memory_t) :: memory

        if (.not. recorder%wants_memory()) return
        call pass_all(newton, pace, state, step, memory)
        call recorder%keep_memory(memory, error)
    end subroutine offer_memory

    !> Work of the driven supports over a step, by the mean of their reactions at its ends.
    subroutine add_support_work(system, external, stage, u, change, reaction, work)
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: u(:), change(:)
        real(wp), intent(inout) :: reaction(:)  !! of the driven unknowns, at the start in and at the end out
        real(wp), intent(inout) :: work
        real(wp), allocatable :: force(:)
        logical :: admissible

        if (.not. external%motion%is_driven()) return
        allocate (force(system%n))
        call system%internal_force(u, force, admissible)
        associate (i => external%motion%unknown)
            work = work + 0.5_wp*dot_product(reaction + (force(i) - stage%f_external(i)), change(i))
            reaction = force(i) - stage%f_external(i)
        end associate
    end subroutine add_support_work

end module gb_static
