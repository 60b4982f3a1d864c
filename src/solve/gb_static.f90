!> STATIC: equilibrium under loads that grow in steps, by Newton's method; a load step that fails is cut in
!> halves.
module gb_static
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
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

contains

    !> From the state's load factor to task%load in task%steps equal steps; every step is told to the
    !> recorder. On failure the state is the last equilibrium found.
    subroutine run_static(system, external, mesh, task, state, recorder, error)
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        type(task_t), intent(in) :: task
        type(state_t), intent(inout) :: state
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(newton_t) :: newton
        type(newton_report_t) :: report
        type(stage_t) :: stage
        type(substeps_t) :: parts
        type(step_record_t) :: step
        real(wp), allocatable :: force(:), u(:), last_change(:), reaction(:)
        real(wp) :: start, from, target, last_factor
        integer :: i
        logical :: exhausted, admissible

        call newton%set_up(system, task%tolerance, task%iterations, &
                           block=system%fits_block .and. task%solver /= solver_lapack)
        parts%max_level = task%cuts
        allocate (force(system%n))
        call external%static_forces(force)
        allocate (last_change(system%n), stage%f_external(system%n), u(system%n))
        last_factor = 0.0_wp
        state%v = 0.0_wp
        state%a = 0.0_wp
        start = state%load
        call system%internal_force(state%u, last_change, admissible)
        reaction = last_change(external%motion%unknown) - start*force(external%motion%unknown)
        last_change = 0.0_wp
        step%abscissa = start
        call newton%strain_energy(system, state%u, step%strain, admissible)
        call recorder%record_step(step, state, error)
        if (allocated(error)) return
        do i = 1, task%steps
            step%iterations = 0
            step%cuts = 0
            from = state%load
            target = merge(task%load, start + (task%load - start)*real(i, wp)/real(task%steps, wp), &
                i == task%steps)
            call parts%begin_interval()
            do while (.not. parts%is_finished())
                associate (factor => from + (target - from)*parts%next_end())
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
                        call parts%reject(exhausted)
                        last_factor = 0.0_wp
                        if (exhausted) then
                            call raise(error, status_solution, 'STATIC: step ' // to_text(i) // ' of ' &
                                // to_text(task%steps) // ' failed at load factor ' // to_text(factor) &
                                // ' after ' // to_text(task%cuts) // ' cuts: ' // failure_reason(system, &
                                report, u, mesh%x) // '. Try more steps=, or stop at a smaller load=')
                            return
                        end if
                        cycle
                    end if
                    last_change = u - state%u
                    last_factor = factor - state%load
                    step%external = step%external &
                                    + 0.5_wp*(state%load + factor)*dot_product(force, last_change)
                    call add_support_work(system, external, stage, u, last_change, reaction, step%external)
                    state%u = u
                    state%load = factor
                    call parts%accept()
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
