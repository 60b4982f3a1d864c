!> A run from the command line to the exit status: read, check, solve, say how it ended.
module gb_run
    use, intrinsic :: iso_fortran_env, only: error_unit
    use gb_kinds, only: wp
    use gb_files, only: leaves_folder
    use gb_error, only: error_t, raise, status_ok, status_input, status_file, status_interrupted
    use gb_memory, only: memory_t
    use gb_checkpoint, only: checkpoint_t
    use gb_text, only: to_text, newline
    use gb_version, only: program_version, git_revision
    use gb_colour, only: has_colours, colour_report, standard_error
    use gb_log, only: log_t
    use gb_make_choices, only: make_choices
    use gb_capacity, only: lacks_memory
    use gb_sketch, only: draw_model
    use gb_posix, only: hold_standard_files, ignore_write_signals, write_output
    use gb_threads, only: use_one_blas_thread
    use gb_problem, only: problem_t
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_external, only: external_t, build_external
    use gb_recovery, only: build_recovery
    use gb_initial, only: initial_state
    use gb_task, only: run_task
    use gb_deck, only: read_deck, read_source, source_t, diagnostics_t, recipe_t
    use gb_keywords, only: keyword_reference
    use gb_summary, only: print_summary
    use gb_options, only: help_text
    use gb_manual, only: manual_page, completion
    use gb_command_line, only: options_t, read_command_line
    use gb_merge_run, only: run_merge
    use gb_monitor, only: monitor_t
    use gb_needs, only: memory_needed
    use gb_share, only: share_t
    use gb_signals, only: watch_signals
    use gb_study_options, only: choose_share, choose_threads
    use gb_study_run, only: run_sweep
    implicit none
    private

    public :: run_program

contains

    !> All that the program does; `status` is its exit status (docs/results.md).
    subroutine run_program(status)
        integer, intent(out) :: status
        type(options_t) :: options
        type(error_t), allocatable :: error
        character(:), allocatable :: message, text
        logical :: failed

        call hold_standard_files()
        call ignore_write_signals()
        status = status_ok
        call read_command_line(options, error)
        if (.not. allocated(error)) then
            text = asked_text(options)
            if (len(text) > 0) then
                call write_output(text, failed)
                if (failed) call raise(error, status_file, 'standard output took no more')
            else if (len(options%merge_into) > 0) then
                call run_merge(options, error)
            else
                call run_deck(options, status, error)
            end if
        end if
        if (allocated(error)) then
            status = error%status
            message = 'gentbeam: error: ' // error%message
            if (status == status_interrupted) message = 'gentbeam: ' // error%message
            if (has_colours(standard_error)) message = colour_report(message)
            write (error_unit, '(a)') message
        end if
    end subroutine run_program

    !> What the options ask to be printed in place of a run; empty: they ask for a run.
    pure function asked_text(options) result(text)
        type(options_t), intent(in) :: options
        character(:), allocatable :: text

        text = ''
        if (options%show_help) then
            text = help_text()
        else if (options%show_version) then
            text = 'gentbeam ' // program_version // ' (' // git_revision // ')' // newline
        else if (options%show_manual) then
            text = manual_page()
        else if (options%show_completion) then
            text = completion()
        else if (options%show_keywords) then
            text = keyword_reference(options%as_markdown)
        end if
    end function asked_text

    subroutine run_deck(options, status, error)
        type(options_t), intent(in) :: options
        integer, intent(out) :: status
        type(error_t), allocatable, intent(out) :: error
        type(source_t) :: source
        type(diagnostics_t) :: diagnostics
        character(:), allocatable :: report
        type(problem_t) :: problem
        type(recipe_t) :: recipe
        type(share_t) :: share
        type(log_t) :: log
        integer :: threads

        status = status_ok
        call read_source(options%deck, source, error)
        if (allocated(error)) return
        call read_deck(source, options%overrides, problem, diagnostics, recipe)
        if (diagnostics%count() > 0) then
            report = diagnostics%render(source%name, source%text)
            if (has_colours(standard_error)) report = colour_report(report)
            write (error_unit, '(a)', advance='no') report
            status = status_input
            return
        end if
        if (len(options%output) > 0) problem%output%file = options%output
        call choose_share(options, problem, share, error)
        if (allocated(error)) return
        log%level = options%log_level
        call print_summary(problem, log)
        if (len(options%output) == 0) call tell_other_folder(problem, log)
        if (options%check_only) then
            call draw_model(problem%model, log)
            if (log%has_failed) call raise(error, status_file, &
                'what was found could not be written to standard output')
            return
        end if
        if (share%members == 0) then
            call use_one_blas_thread()
            call choose_and_solve(problem, options, log, error)
            return
        end if
        call check_study(problem, error)
        if (.not. allocated(error)) call choose_threads(options, threads, error)
        if (.not. allocated(error)) call check_memory(problem, error)
        if (.not. allocated(error)) call run_sweep(problem, recipe, options, share, threads, error)
    end subroutine run_deck

    !> A deck may come from somebody else: where it has files written outside this folder, that is told.
    subroutine tell_other_folder(problem, log)
        type(problem_t), intent(in) :: problem
        type(log_t), intent(inout) :: log
        integer :: i

        if (leaves_folder(problem%output%file)) call log%line('  warning: the deck puts the results ' &
            // 'outside this folder, into ' // problem%output%file // '.h5 (-o gives another name)')
        do i = 1, size(problem%tasks)
            if (.not. allocated(problem%tasks(i)%safeguard%file)) cycle
            associate (file => problem%tasks(i)%safeguard%file)
                if (.not. leaves_folder(file)) cycle
                call log%line('  warning: the deck puts checkpoints outside this folder, into ' // file)
                return
            end associate
        end do
    end subroutine tell_other_folder

    !> Decide what the deck leaves open, and run it. What the deciding takes counts for --max-time.
    subroutine choose_and_solve(problem, options, log, error)
        type(problem_t), intent(inout) :: problem
        type(options_t), intent(in) :: options
        type(log_t), intent(inout) :: log
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: before, after

        call cpu_time(before)
        call watch_signals()
        call make_choices(problem, log, options%max_seconds, error)
        if (.not. allocated(error)) call check_memory(problem, error)
        if (allocated(error)) return
        call cpu_time(after)
        call solve_problem(problem, options, after - before, error)
    end subroutine choose_and_solve

    !> What a study of many members does not have.
    subroutine check_study(problem, error)
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error

        if (problem%output%strain .or. problem%output%stress) call raise(error, status_input, &
            'OUTPUT fields= strain and stress are not kept for members of a SWEEP: ' &
            // 'run the members that matter one by one with --set')
    end subroutine check_study

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
    subroutine solve_problem(problem, options, spent_seconds, error)
        type(problem_t), intent(in) :: problem
        type(options_t), intent(in) :: options
        real(wp), intent(in) :: spent_seconds       !! that choosing the model has taken [s]
        type(error_t), allocatable, intent(out) :: error
        type(monitor_t) :: monitor
        type(checkpoint_t) :: checkpoint
        type(system_t) :: system
        type(external_t) :: external
        type(state_t) :: state
        logical :: has_velocities
        integer :: i

        system = build_system(problem%model)
        call monitor%watch%begin(options%max_seconds, spent_seconds)
        if (len(options%restart) > 0) then
            call monitor%resume(problem, build_recovery(problem%model, system), options%log_level, &
                options%restart, checkpoint, error)
        else
            call monitor%open(problem, build_recovery(problem%model, system), options%log_level, error)
        end if
        if (allocated(error)) return
        external = build_external(problem%model)
        call initial_state(problem%model, system, state, error)
        has_velocities = .true.
        if (monitor%number > 0 .and. .not. monitor%is_inside .and. .not. allocated(error)) then
            call pass_memory(checkpoint%memory, has_velocities, state)
            call checkpoint%memory%check(error)
        end if
        do i = monitor%number + merge(0, 1, monitor%is_inside), size(problem%tasks)
            if (allocated(error)) exit
            call run_task(problem, i, system, external, monitor%is_inside, checkpoint%memory, &
                has_velocities, &
                state, monitor, error)
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
            if (error%status == status_file .and. .not. monitor%lacks_checkpoint) return
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

end module gb_run
