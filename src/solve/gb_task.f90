!> One solution command: the method that its kind asks for.
module gb_task
    use gb_error, only: error_t, status_file
    use gb_external, only: external_t
    use gb_initial, only: initial_velocities
    use gb_memory, only: memory_t
    use gb_modal, only: run_modal
    use gb_problem, only: problem_t, task_static, task_modal
    use gb_recorder, only: recorder_t
    use gb_state, only: state_t
    use gb_static, only: run_static
    use gb_system, only: system_t
    use gb_transient, only: run_transient
    implicit none
    private

    public :: run_task

contains

    !> Run solution command `number` from the state the last one left, or from where `memory` was taken inside
    !> it, and tell the recorder. On failure the
    !> state is the last one reached.
    subroutine run_task(problem, number, system, external, is_inside, memory, has_velocities, state, &
        recorder, error)
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        logical, intent(in) :: is_inside            !! whether the command goes on from `memory`
        type(memory_t), intent(inout) :: memory
        logical, intent(inout) :: has_velocities  !! whether the state's velocities are those to go on with
        type(state_t), intent(inout) :: state
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: file_error

        associate (task => problem%tasks(number))
            if (.not. is_inside) then
                call memory%clear()
                call recorder%begin_task(task, error)
                if (allocated(error)) return
            end if
            select case (task%kind)
            case (task_static)
                has_velocities = .false.
                call run_static(system, external, problem%model%mesh, task, memory, state, &
                    recorder, error)
            case (task_modal)
                call run_modal(system, problem%model, task, state, recorder, error)
            case default
                if (.not. has_velocities) call initial_velocities(problem%model, system, state%v, error)
                has_velocities = .true.
                if (.not. allocated(error)) call run_transient(system, external, problem%model%mesh, task, &
                    memory, state, recorder, error)
            end select
        end associate
        if (allocated(error)) then
            if (error%status == status_file) return
        end if
        call recorder%end_task(error, file_error)
        if (allocated(file_error)) call move_alloc(file_error, error)
    end subroutine run_task

end module gb_task
