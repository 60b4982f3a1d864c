!> Runs the members of a deck with SWEEPs: a source that reads each member's deck, and a sink that hands what
!> they tell to the results file and counts them in the log.
module gb_study_run
    use gb_kinds, only: wp, i8
    use gb_checkpoint, only: origin_t, checkpoint_t, origin_of, read_checkpoint, write_checkpoint
    use gb_places, only: check_places, check_restart_place
    use gb_command_line, only: options_t
    use gb_files, only: is_file, check_seal
    use gb_lanes, only: lanes
    use gb_deck, only: recipe_t, read_member, diagnostics_t
    use gb_choose_points, only: choose_points
    use gb_error, only: error_t, raise, status_solution, status_file, status_interrupted
    use gb_log, only: log_t
    use gb_member, only: member_t, member_complete, member_failed, member_waiting
    use gb_resume, only: find_source
    use gb_names, only: max_name
    use gb_problem, only: problem_t, task_static, task_modal
    use gb_share, only: share_t, study_end
    use gb_study, only: member_source_t, member_sink_t, run_study
    use gb_signals, only: watch_signals, stop_after, has_caught_signal, caught_signal
    use gb_sweep, only: sweep_t
    use gb_sweep_file, only: sweep_file_t
    use gb_sweep_merge, only: sort_members
    use gb_text, only: to_text, newline, shell_word
    use gb_threads, only: use_one_blas_thread
    implicit none
    private

    type, extends(member_source_t) :: deck_members_t
        type(recipe_t) :: recipe
        type(sweep_t) :: sweep
        character(max_name), allocatable :: names(:)
    contains
        procedure :: make
    end type deck_members_t

    type, extends(member_sink_t) :: study_monitor_t
        type(sweep_file_t) :: file
        type(log_t) :: log
        type(origin_t) :: origin
        character(max_name), allocatable :: names(:)    !! of the parameters that vary
        character(:), allocatable :: ticket         !! path of the study's checkpoint
        integer :: earlier = 0                      !! members that an earlier run has finished
        integer :: wanted = 0                       !! members of this run
        integer :: taken = 0                        !! of them
        character(:), allocatable :: first_failure
        integer(i8) :: start = 0, last_line = 0     !! clock counts
        integer :: next_line = 0                    !! members at which the log gets its next line
    contains
        procedure :: take
        procedure :: wants_stop
    end type study_monitor_t

    !> The log of a study has about so many lines, and one a minute at least.
    integer, parameter :: lines_a_study = 10
    real(wp), parameter :: seconds_a_line = 60.0_wp
    integer, parameter :: shown_failures = 5
    !> Members go to the threads in batches, to share the cost of the queue and to be solved side by side.
    integer, parameter :: largest_batch = 8
    !> What may wait for the results file [bytes].
    real(wp), parameter :: memory = 64.0e6_wp
    !> Time that --max-time leaves for closing the results file [s], at most this part of the whole.
    real(wp), parameter :: reserve_seconds = 2.0_wp, reserve_part = 0.1_wp

    public :: run_sweep

contains

    !> Run the share of the study that the options ask for: what --restart has not, or the file of the same
    !> shard.
    subroutine run_sweep(problem, recipe, options, share, threads, error)
        type(problem_t), intent(in) :: problem
        type(recipe_t), intent(in) :: recipe
        type(options_t), intent(in) :: options
        type(share_t), intent(in) :: share
        integer, intent(in) :: threads
        type(error_t), allocatable, intent(out) :: error
        type(deck_members_t) :: source
        type(study_monitor_t) :: monitor
        integer, allocatable :: numbers(:)
        integer :: members_a_batch, batches_ahead, i
        real(wp) :: cpu_start

        call watch_signals()
        call use_one_blas_thread()
        call system_clock(monitor%start)
        call cpu_time(cpu_start)
        monitor%log%level = options%log_level
        monitor%origin = origin_of(problem)
        call open_file(monitor, problem, options%restart, share, error)
        if (allocated(error)) return
        monitor%earlier = monitor%file%finished
        numbers = pack([(share%number(i), i=1, share%n())], .not. monitor%file%has_run)
        call write_tickets(monitor, problem)
        if (options%max_seconds > 0.0_wp) call stop_in_time(monitor, options%max_seconds)
        source%recipe = recipe
        source%sweep = problem%sweep
        source%names = problem%sweep%names()
        monitor%names = source%names
        monitor%wanted = size(numbers)
        call print_head(monitor, problem, share, threads)
        call choose_batches(problem, size(numbers), threads, members_a_batch, batches_ahead)
        call monitor%log%start_bar()
        monitor%last_line = monitor%start
        call run_study(source, monitor, numbers, threads, members_a_batch, batches_ahead, error)
        call monitor%log%clear_bar()
        if (allocated(error)) return
        call finish(monitor, cpu_start, error)
    end subroutine run_sweep

    !> The share's results file: that of an earlier run, which --restart names or whose shard this is, or a
    !> new one.
    subroutine open_file(monitor, problem, restart, share, error)
        type(study_monitor_t), intent(inout) :: monitor
        type(problem_t), intent(in) :: problem
        character(*), intent(in) :: restart         !! a checkpoint or results file, or empty
        type(share_t), intent(in) :: share
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: path, source
        logical :: has_begun, is_damaged

        path = problem%output%file // '.h5'
        if (share%shards > 1) path = problem%output%file // '.shard-' // to_text(share%shard) // '-of-' &
            // to_text(share%shards) // '.h5'
        call check_places(problem, path, error)
        if (allocated(error)) return
        if (len(restart) > 0) then
            call find_results(monitor, path, restart, source, error)
            if (.not. allocated(error)) call monitor%file%resume(path, source, problem, monitor%origin, &
                share, is_damaged, error)
            return
        end if
        has_begun = .false.
        if (share%shards > 1) has_begun = is_file(path)
        if (has_begun) then
            call monitor%file%resume(path, path, problem, monitor%origin, share, is_damaged, error)
            if (.not. (allocated(error) .and. is_damaged)) return
            call monitor%log%line('  ' // error%message // '; it is begun anew')
            deallocate (error)
            monitor%file = sweep_file_t()
        end if
        call monitor%file%create(path, problem, share, error)
    end subroutine open_file

    !> The results file that --restart leads to: by a checkpoint, or itself.
    subroutine find_results(monitor, path, restart, source, error)
        type(study_monitor_t), intent(in) :: monitor
        character(*), intent(in) :: path, restart
        character(:), allocatable, intent(out) :: source
        type(error_t), allocatable, intent(out) :: error
        type(checkpoint_t) :: checkpoint
        character(:), allocatable :: reason
        logical :: is_checkpoint

        source = restart
        call check_seal(restart, is_checkpoint, reason)
        if (len(reason) > 0) then
            call raise(error, status_file, 'cannot restart from ' // restart // ': ' // reason)
        else if (is_checkpoint) then
            call read_checkpoint(restart, monitor%origin, checkpoint, error)
            if (.not. allocated(error)) call check_restart_place(path, restart, error)
            if (.not. allocated(error)) call find_source(path, restart, monitor%origin, checkpoint, &
                .false., source, error)
        end if
    end subroutine find_results

    !> A checkpoint of a study only leads to its results file, which has all that is finished: it is written
    !> once, where the deck asks for checkpoints. One that cannot be written is warned of.
    subroutine write_tickets(monitor, problem)
        type(study_monitor_t), intent(inout) :: monitor
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable :: trouble
        integer :: i

        do i = 1, size(problem%tasks)
            associate (safeguard => problem%tasks(i)%safeguard)
                if (safeguard%every <= 0 .and. safeguard%seconds <= 0.0_wp) cycle
                if (allocated(safeguard%file)) monitor%ticket = safeguard%file
            end associate
            call write_ticket(monitor, trouble)
            if (allocated(trouble)) call monitor%log%line('  warning: ' // trouble%message)
            return
        end do
    end subroutine write_tickets

    subroutine write_ticket(monitor, error)
        type(study_monitor_t), intent(inout) :: monitor
        type(error_t), allocatable, intent(out) :: error
        type(checkpoint_t) :: checkpoint

        associate (path => monitor%file%path)
            if (.not. allocated(monitor%ticket)) monitor%ticket = path(:len(path) - len('.h5')) // '.chk.h5'
            checkpoint%created = monitor%file%created
            checkpoint%results = path
            checkpoint%command = 'sweep'
            checkpoint%step = monitor%file%finished
        end associate
        call write_checkpoint(monitor%ticket, monitor%origin, checkpoint, error)
    end subroutine write_ticket

    !> --max-time: the signal comes so early that what is finished can still be written.
    subroutine stop_in_time(monitor, max_seconds)
        type(study_monitor_t), intent(in) :: monitor
        real(wp), intent(in) :: max_seconds
        integer(i8) :: now, rate

        call system_clock(now, rate)
        call stop_after(max_seconds - min(reserve_seconds, reserve_part*max_seconds) &
            - real(now - monitor%start, wp)/real(rate, wp))
    end subroutine stop_in_time

    subroutine print_head(monitor, problem, share, threads)
        type(study_monitor_t), intent(inout) :: monitor
        type(problem_t), intent(in) :: problem
        type(share_t), intent(in) :: share
        integer, intent(in) :: threads
        character(:), allocatable :: text
        integer :: i

        associate (log => monitor%log)
            text = '  sweep: ' // to_text(share%members) // ' members'
            do i = 1, size(problem%sweep%factors)
                associate (factor => problem%sweep%factors(i))
                    text = text // trim(merge(' of ', ' x  ', i == 1)) // ' ' &
                        // to_text(size(factor%values, 2)) // ' ' // joined(factor%names)
                end associate
            end do
            call log%line(text)
            if (share%shards > 1) call log%line('  shard ' // to_text(share%shard) // ' of ' &
                // to_text(share%shards) // ': ' // to_text(share%n()) // ' members')
            if (monitor%earlier > 0) call log%line('  ' // to_text(monitor%earlier) &
                // ' of them were finished by an earlier run')
            call log%line('  threads: ' // to_text(threads))
            call log%line('  results: ' // monitor%file%path)
            call log%line('')
            call log%line('     members      failed   members/s   time left')
        end associate
        monitor%next_line = max(1, monitor%wanted/lines_a_study)
    end subroutine print_head

    function joined(names) result(text)
        character(*), intent(in) :: names(:)
        character(:), allocatable :: text
        integer :: i

        text = trim(names(1))
        do i = 2, size(names)
            text = text // '+' // trim(names(i))
        end do
    end function joined

    !> How many members a thread takes at once, and how many batches may wait for the file, so that what waits
    !> keeps within bounds.
    pure subroutine choose_batches(problem, members, threads, members_a_batch, batches_ahead)
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: members, threads
        integer, intent(out) :: members_a_batch, batches_ahead
        real(wp) :: bytes, fitting

        bytes = record_bytes(problem)
        fitting = min(1.0e6_wp, memory/bytes)
        members_a_batch = min(max(largest_batch, lanes), members/(4*threads), int(fitting/(2*threads)))
        ! Whole lanes, where there are enough members.
        if (members_a_batch < lanes) members_a_batch = min(lanes, members/threads, int(fitting/(2*threads)))
        if (members_a_batch > lanes) members_a_batch = members_a_batch - modulo(members_a_batch, lanes)
        members_a_batch = max(1, members_a_batch)
        batches_ahead = max(2*threads, min(64*threads, int(fitting/members_a_batch)))
    end subroutine choose_batches

    !> About what one member has to tell [bytes].
    pure real(wp) function record_bytes(problem) result(bytes)
        type(problem_t), intent(in) :: problem
        real(wp), parameter :: fixed = 10000.0_wp, adaptive_steps = 1000.0_wp, bytes_a_number = 8.0_wp
        real(wp) :: steps, sets
        integer :: i

        bytes = fixed
        sets = real(count([problem%output%u, problem%output%v, problem%output%a]), wp)
        if (sets <= 0.0_wp) return
        do i = 1, size(problem%tasks)
            associate (task => problem%tasks(i))
                if (task%kind == task_modal) then
                    steps = real(task%count, wp)
                else if (task%kind == task_static) then
                    steps = real(task%steps, wp)
                else if (task%step > 0.0_wp) then
                    steps = task%end_time/task%step
                else
                    steps = adaptive_steps
                end if
                bytes = bytes + bytes_a_number*steps*(10.0_wp + real(size(problem%probes), wp) &
                    + 5.0_wp*sets*real(problem%model%mesh%n_nodes(), wp)/real(problem%output%every, wp))
            end associate
        end do
    end function record_bytes

    !> Read the deck for the member's values. Where it is wrong for them, the first thing wrong is why the
    !> member failed.
    subroutine make(self, number, member)
        class(deck_members_t), intent(in) :: self
        integer, intent(in) :: number
        type(member_t), intent(inout) :: member
        type(diagnostics_t) :: diagnostics
        type(error_t), allocatable :: error

        member%number = number
        member%values = self%sweep%values(number)
        allocate (member%problem)
        ! The deck's reader is full of functions with texts for results, which gfortran does not keep apart by
        ! threads (see gb_text). It takes some hundredths of a millisecond.
        !$omp critical (gb_deck)
        call read_member(self%recipe, self%names, member%values, member%problem, diagnostics)
        if (diagnostics%count() > 0) then
            deallocate (member%problem)
            member%outcome = member_failed
            member%message = first_line(self%recipe%render(diagnostics))
        end if
        !$omp end critical (gb_deck)
        if (.not. allocated(member%problem)) return
        ! An error here is a signal: the study is about to stop.
        if (any(member%problem%model%sections%is_auto)) call choose_points(member%problem, 0.0_wp, error)
    end subroutine make

    pure function first_line(text) result(line)
        character(*), intent(in) :: text
        character(:), allocatable :: line

        line = text(:max(0, index(text // newline, newline) - 1))
    end function first_line

    subroutine take(self, member, error)
        class(study_monitor_t), intent(inout) :: self
        type(member_t), intent(inout) :: member
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: named
        integer(i8) :: now, rate

        ! A signal has cut it short: it is to be run again.
        if (member%outcome == member_waiting) return
        call self%file%take(member, error)
        if (allocated(error)) return
        self%taken = self%taken + 1
        if (member%outcome /= member_complete) then
            named = name_of(self, member)
            if (.not. allocated(self%first_failure)) self%first_failure = named // ': ' // member%message
            if (self%file%failed <= shown_failures) then
                call self%log%line('  ' // named // ' failed: ' // member%message)
            else
                call self%log%detail('  ' // named // ' failed: ' // member%message)
            end if
        end if
        call self%log%show_bar(real(self%taken, wp)/real(self%wanted, wp))
        call system_clock(now, rate)
        if (self%taken < self%next_line .and. real(now - self%last_line, wp) < seconds_a_line*real(rate, &
            wp)) &
            return
        if (self%taken >= self%next_line) self%next_line = self%next_line + max(1, self%wanted/lines_a_study)
        self%last_line = now
        call self%log%line(progress_line(self, real(now - self%start, wp)/real(rate, wp)))
    end subroutine take

    !> "member 3 (E = 12000, jm = 0.5)".
    pure function name_of(self, member) result(text)
        class(study_monitor_t), intent(in) :: self
        type(member_t), intent(in) :: member
        character(:), allocatable :: text
        integer :: i

        text = 'member ' // to_text(member%number) // ' ('
        do i = 1, size(self%names)
            if (i > 1) text = text // ', '
            text = text // trim(self%names(i)) // ' = ' // to_text(member%values(i))
        end do
        text = text // ')'
    end function name_of

    !> Members done, failed, the pace so far, and what it makes of the rest.
    pure function progress_line(self, seconds) result(text)
        class(study_monitor_t), intent(in) :: self
        real(wp), intent(in) :: seconds         !! since the study began
        character(:), allocatable :: text
        real(wp) :: pace

        pace = real(self%taken, wp)/max(seconds, 1.0e-6_wp)
        text = padded(to_text(self%earlier + self%taken), 12) // padded(to_text(self%file%failed), 12) &
            // padded(to_text(pace, 3), 12) // padded(duration(real(self%wanted - self%taken, wp)/pace), 12)
    end function progress_line

    pure function padded(text, width) result(field)
        character(*), intent(in) :: text
        integer, intent(in) :: width
        character(:), allocatable :: field

        field = repeat(' ', max(1, width - len(text))) // text
    end function padded

    !> 45 s, 12 min, 3.5 h
    pure function duration(seconds) result(text)
        real(wp), intent(in) :: seconds
        character(:), allocatable :: text

        if (seconds < 100.0_wp) then
            text = to_text(ceiling(seconds)) // ' s'
        else if (seconds < 6000.0_wp) then
            text = to_text(nint(seconds/60.0_wp)) // ' min'
        else
            text = to_text(seconds/3600.0_wp, 3) // ' h'
        end if
    end function duration

    !> A signal ends the study; members that have begun stop at their next step.
    logical function wants_stop(self)
        class(study_monitor_t), intent(inout) :: self

        wants_stop = has_caught_signal()
    end function wants_stop

    !> Say how the study ended, in the file and in the log's last line. All members failed: an error.
    subroutine finish(monitor, cpu_start, error)
        type(study_monitor_t), intent(inout) :: monitor
        real(wp), intent(in) :: cpu_start
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: counts, status
        integer(i8) :: now, rate
        real(wp) :: seconds, cpu_end

        call system_clock(now, rate)
        call cpu_time(cpu_end)
        seconds = real(now - monitor%start, wp)/real(rate, wp)
        associate (members => monitor%file%share%n())
            call study_end(members, monitor%file%failed, members - monitor%file%finished, status, counts)
        end associate
        call monitor%file%close(status, counts, seconds, cpu_end - cpu_start, error)
        if (allocated(error)) return
        if (status == 'interrupted') then
            call write_ticket(monitor, error)
        else if (.not. monitor%file%is_sorted) then
            call sort_members(monitor%file%path, error)
        end if
        if (allocated(error)) return
        call monitor%log%line('')
        call monitor%log%line(trim(merge('stopped after', 'done in      ', status == 'interrupted')) // ' ' &
            // to_text(seconds, 3) // ' s (' // to_text(cpu_end - cpu_start, 3) // ' s CPU): ' // counts)
        if (status == 'interrupted') then
            call raise(error, status_interrupted, 'stopped by ' // caught_signal() // ' with ' // counts &
                // '; to go on: gentbeam --restart ' // shell_word(monitor%ticket) // ' DECK')
        else if (status == 'failed') then
            if (.not. allocated(monitor%first_failure)) monitor%first_failure = 'see /sweep/message'
            call raise(error, status_solution, 'all members failed; ' // monitor%first_failure)
        else if (monitor%log%has_failed) then
            call raise(error, status_file, &
                'the log could not be written to standard output (the results file is complete)')
        end if
    end subroutine finish

end module gb_study_run
