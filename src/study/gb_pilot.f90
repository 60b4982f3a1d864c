!> Runs that only tell what a choice needs (auto, rule=auto): nothing of them is kept in a file, and natural
!> modes are not looked for, since nothing depends on them.
module gb_pilot
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_interrupted
    use gb_external, only: external_t, build_external
    use gb_initial, only: initial_state
    use gb_memory, only: memory_t
    use gb_problem, only: problem_t, task_t, task_modal
    use gb_recorder, only: recorder_t
    use gb_signals, only: has_caught_signal
    use gb_state, only: state_t
    use gb_system, only: system_t
    use gb_task, only: run_task
    implicit none
    private

    !> What follows such a run: extensions say what they look at in each step.
    type, abstract, extends(recorder_t), public :: pilot_t
        integer :: task = 0                         !! number of the running command
        real(wp) :: deadline = 0.0_wp               !! CPU time at which to stop [s]; 0: none
    contains
        procedure :: begin_task
        procedure :: record_modes
        procedure :: end_task
        procedure :: note
        procedure :: check_stop
    end type pilot_t

    public :: run_pilot

contains

    !> All commands but MODAL, in their order; an error ends them.
    subroutine run_pilot(problem, system, pilot, error)
        type(problem_t), intent(in) :: problem
        type(system_t), intent(in) :: system        !! of the problem's model
        class(pilot_t), intent(inout) :: pilot
        type(error_t), allocatable, intent(out) :: error
        type(external_t) :: external
        type(state_t) :: state
        type(memory_t) :: memory
        logical :: has_velocities
        integer :: i

        external = build_external(problem%model)
        call initial_state(problem%model, system, state, error)
        has_velocities = .true.
        do i = 1, size(problem%tasks)
            if (allocated(error)) return
            pilot%task = i
            if (problem%tasks(i)%kind == task_modal) cycle
            call run_task(problem, i, system, external, .false., memory, has_velocities, state, pilot, error)
        end do
    end subroutine run_pilot

    !> Raise an error where a signal has come, or the time is over. (The caller has the words for it.)
    subroutine check_stop(self, error)
        class(pilot_t), intent(in) :: self
        type(error_t), allocatable, intent(inout) :: error
        real(wp) :: now
        logical :: is_over

        is_over = has_caught_signal()
        if (self%deadline > 0.0_wp .and. .not. is_over) then
            call cpu_time(now)
            is_over = now > self%deadline
        end if
        if (is_over) call raise(error, status_interrupted, 'stopped')
    end subroutine check_stop

    subroutine begin_task(self, task, error)
        class(pilot_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error
    end subroutine begin_task

    subroutine record_modes(self, frequency, modes, error)
        class(pilot_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:), modes(:, :)
        type(error_t), allocatable, intent(out) :: error
    end subroutine record_modes

    subroutine end_task(self, failure, error)
        class(pilot_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: failure
        type(error_t), allocatable, intent(out) :: error
    end subroutine end_task

    subroutine note(self, text)
        class(pilot_t), intent(inout) :: self
        character(*), intent(in) :: text
    end subroutine note

end module gb_pilot
