!> A run from the command line to the exit status: read, check, solve, say how it ended.
module gb_run
    use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
    use gb_error, only: error_t, raise, status_ok, status_input, status_file, status_interrupted
    use gb_memory, only: memory_t
    use gb_checkpoint, only: checkpoint_t
    use gb_text, only: to_text
    use gb_version, only: program_version, git_revision
    use gb_log, only: log_t
    use gb_capacity, only: lacks_memory
    use gb_posix, only: ignore_write_signals
    use gb_threads, only: use_one_blas_thread
    use gb_problem, only: problem_t, task_static, task_modal
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_external, only: external_t, build_external
    use gb_initial, only: initial_state, initial_velocities
    use gb_static, only: run_static
    use gb_modal, only: run_modal
    use gb_transient, only: run_transient
    use gb_deck, only: read_deck, read_source, source_t, diagnostics_t
    use gb_keywords, only: print_keywords
    use gb_summary, only: print_summary
    use gb_command_line, only: options_t, read_command_line, help_text
    use gb_monitor, only: monitor_t
    use gb_needs, only: memory_needed
    implicit none
    private

    public :: run_program

contains

    !> All that the program does; `status` is its exit status (docs/results.md).
    subroutine run_program(status)
        integer, intent(out) :: status
        type(options_t) :: options
        type(error_t), allocatable :: error

        call ignore_write_signals()
        status = status_ok
        call read_command_line(options, error)
        if (.not. allocated(error)) then
            if (options%show_help) then
                write (output_unit, '(a)') help_text()
                return
            else if (options%show_version) then
                write (output_unit, '(a)') 'gentbeam ' // program_version // ' (' // git_revision // ')'
                return
            else if (options%show_keywords) then
                call print_keywords(output_unit, options%as_markdown)
                return
            end if
            call run_deck(options, status, error)
        end if
        if (allocated(error)) then
            status = error%status
            if (status == status_interrupted) then
                write (error_unit, '(a)') 'gentbeam: ' // error%message
            else
                write (error_unit, '(a)') 'gentbeam: error: ' // error%message
            end if
        end if
    end subroutine run_program

    subroutine run_deck(options, status, error)
        type(options_t), intent(in) :: options
        integer, intent(out) :: status
        type(error_t), allocatable, intent(out) :: error
        type(source_t) :: source
        type(diagnostics_t) :: diagnostics
        type(problem_t) :: problem
        type(log_t) :: log

        status = status_ok
        call read_source(options%deck, source, error)
        if (allocated(error)) return
        call read_deck(source, options%overrides, problem, diagnostics)
        if (diagnostics%count() > 0) then
            write (error_unit, '(a)', advance='no') diagnostics%render(source%name, source%text)
            status = status_input
            return
        end if
        if (len(options%output) > 0) problem%output%file = options%output
        log%level = options%log_level
        call print_summary(problem, log)
        if (options%check_only) return
        call check_memory(problem, error)
        if (.not. allocated(error)) call solve_problem(problem, options, error)
    end subroutine run_deck

    !> A model that is too large for the machine is told before it takes all there is.
    subroutine check_memory(problem, error)
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: reason

        reason = lacks_memory(memory_needed(problem))
        if (len(reason) > 0) call raise(error, status_input, 'the model of ' &
            // to_text(problem%model%mesh%n_nodes()) // ' nodes is too large for this machine: ' // reason)
    end subroutine check_memory

    !> Run the solution commands in their order, each from the state the last one left; or those that a
    !> checkpoint leaves to do.
    subroutine solve_problem(problem, options, error)
        type(problem_t), intent(in) :: problem
        type(options_t), intent(in) :: options
        type(error_t), allocatable, intent(out) :: error
        type(monitor_t) :: monitor
        type(checkpoint_t) :: checkpoint
        type(system_t) :: system
        type(external_t) :: external
        type(state_t) :: state
        logical :: has_velocities
        integer :: i

        call use_one_blas_thread()
        call monitor%watch%begin(options%max_seconds)
        if (len(options%restart) > 0) then
            call monitor%resume(problem, options%log_level, options%restart, checkpoint, error)
        else
            call monitor%open(problem, options%log_level, error)
        end if
        if (allocated(error)) return
        system = build_system(problem%model)
        external = build_external(problem%model)
        call initial_state(problem%model, system, state, error)
        has_velocities = .true.
        if (monitor%number > 0 .and. .not. monitor%is_inside .and. .not. allocated(error)) then
            call pass_memory(checkpoint%memory, has_velocities, state)
            call checkpoint%memory%check(error)
        end if
        do i = monitor%number + merge(0, 1, monitor%is_inside), size(problem%tasks)
            if (allocated(error)) exit
            call run_task(problem, i, system, external, checkpoint%memory, has_velocities, state, monitor, &
                error)
            if (allocated(error) .or. i == size(problem%tasks)) exit
            call offer_memory(has_velocities, state, monitor, error)
        end do
        call finish(monitor, error)
    end subroutine solve_problem

    !> What one command leaves to the next.
    subroutine pass_memory(memory, has_velocities, state)
        type(memory_t), intent(inout) :: memory
        logical, intent(inout) :: has_velocities
        type(state_t), intent(inout) :: state

        call memory%pass('run.has_velocities', has_velocities)
        call state%pass_memory(memory, 'state')
    end subroutine pass_memory

    !> Between two commands: a checkpoint, where the run is to stop there.
    subroutine offer_memory(has_velocities, state, monitor, error)
        logical, intent(inout) :: has_velocities
        type(state_t), intent(inout) :: state
        type(monitor_t), intent(inout) :: monitor
        type(error_t), allocatable, intent(out) :: error
        type(memory_t) :: memory

        if (.not. monitor%wants_memory()) return
        call pass_memory(memory, has_velocities, state)
        call monitor%keep_memory(memory, error)
    end subroutine offer_memory

    !> Close the results file with the word on how the run ended, and say so.
    subroutine finish(monitor, error)
        type(monitor_t), intent(inout) :: monitor
        type(error_t), allocatable, intent(inout) :: error
        type(error_t), allocatable :: file_error
        character(:), allocatable :: outcome, message, line, wall

        outcome = 'complete'
        message = ''
        wall = to_text(monitor%wall_seconds(), 3) // ' s'
        line = 'done in ' // wall // ' (' // to_text(monitor%cpu_seconds(), 3) // ' s CPU)'
        if (allocated(error)) then
            if (error%status == status_file) return
            message = error%message
            outcome = 'failed'
            line = 'failed after ' // wall // ': ' // message
            if (error%status == status_interrupted) then
                outcome = 'interrupted'
                line = message
            end if
        end if
        call monitor%results%close(outcome, message, monitor%wall_seconds(), monitor%cpu_seconds(), &
            file_error)
        if (allocated(file_error)) then
            call move_alloc(file_error, error)
            return
        end if
        call monitor%log%line('')
        call monitor%log%line(line)
        if (monitor%log%has_failed .and. .not. allocated(error)) then
            call raise(error, status_file, &
                'the log could not be written to standard output (the results file is complete)')
        end if
    end subroutine finish

    !> A command from its start, or from where `memory`, if it is being recalled, was taken.
    subroutine run_task(problem, number, system, external, memory, has_velocities, state, monitor, error)
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(memory_t), intent(inout) :: memory
        logical, intent(inout) :: has_velocities  !! whether the state's velocities are those to go on with
        type(state_t), intent(inout) :: state
        type(monitor_t), intent(inout) :: monitor
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: file_error

        associate (task => problem%tasks(number))
            if (.not. monitor%is_inside) then
                call memory%clear()
                call monitor%begin_task(task, error)
                if (allocated(error)) return
            end if
            select case (task%kind)
            case (task_static)
                has_velocities = .false.
                call run_static(system, external, problem%model%mesh, task, memory, state, monitor, error)
            case (task_modal)
                call run_modal(system, problem%model, task, state, monitor, error)
            case default
                if (.not. has_velocities) call initial_velocities(problem%model, system, state%v, error)
                has_velocities = .true.
                if (.not. allocated(error)) call run_transient(system, external, problem%model%mesh, task, &
                    memory, state, monitor, error)
            end select
        end associate
        if (allocated(error)) then
            if (error%status == status_file) return
        end if
        call monitor%end_task(error, file_error)
        if (allocated(file_error)) call move_alloc(file_error, error)
    end subroutine run_task

end module gb_run
