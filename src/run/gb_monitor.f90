!> Watches a solution: what a method tells goes to the results file, the log and the progress bar.
module gb_monitor
    use gb_kinds, only: wp, pi
    use gb_error, only: error_t, raise, status_file, status_interrupted
    use gb_memory, only: memory_t
    use gb_text, only: to_text, shell_word
    use gb_member, only: extremes_t
    use gb_problem, only: problem_t, task_t, probe_t, task_static, task_modal, task_transient, &
        quantity_displacement
    use gb_gauge, only: gauge_t
    use gb_state, only: state_t
    use gb_recorder, only: recorder_t, step_record_t
    use gb_sensor, only: sensor_t, place_sensor
    use gb_log, only: log_t, log_normal, log_verbose
    use gb_checkpoint, only: origin_t, checkpoint_t, origin_of, read_checkpoint, write_checkpoint
    use gb_places, only: check_places, check_restart_place
    use gb_results, only: results_t
    use gb_tuning, only: tuning_t
    use gb_watch, only: watch_t
    implicit none
    private

    type, extends(recorder_t), public :: monitor_t
        type(log_t) :: log
        type(results_t) :: results
        type(probe_t), allocatable :: probes(:)
        type(sensor_t), allocatable :: sensors(:)
        type(extremes_t), allocatable :: extremes(:)
        type(tuning_t), allocatable :: tuning       !! of a deck with `auto`
        type(task_t) :: task
        type(step_record_t) :: first, last
        logical :: lacks_checkpoint = .false.       !! stopped, and the checkpoint could not be written
        logical :: has_energy = .true.              !! whether every section has a stored energy
        integer :: iterations = 0, cuts = 0         !! of the running command
        real(wp) :: largest_energy = 0.0_wp         !! of the running command [F L]
        real(wp) :: largest_drift = 0.0_wp          !! of the energy balance from zero [F L]
        real(wp) :: when_drift = 0.0_wp
        real(wp) :: next_line = 0.0_wp              !! progress at which the log gets its next line
        type(watch_t) :: watch
        type(origin_t) :: origin                    !! what a checkpoint must fit
        integer :: number = 0                       !! of the running command
        logical :: is_inside = .false.              !! whether it has begun, and not ended
        real(wp) :: wall_before = 0.0_wp, cpu_before = 0.0_wp   !! before a restart [s]
    contains
        procedure :: open => open_monitor
        procedure :: resume => resume_monitor
        procedure :: wants_memory
        procedure :: keep_memory
        procedure :: wall_seconds
        procedure :: cpu_seconds
        procedure :: begin_task
        procedure :: record_step
        procedure :: record_modes
        procedure :: end_task
        procedure :: note
    end type monitor_t

    !> The log of a command has about so many lines, whatever the number of steps.
    integer, parameter :: lines_a_command = 10
    integer, parameter :: shown_probes = 4

contains

    !> Open the results file and place the probes.
    subroutine open_monitor(self, problem, gauge, log_level, error)
        class(monitor_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        class(gauge_t), intent(in) :: gauge
        integer, intent(in) :: log_level
        type(error_t), allocatable, intent(out) :: error

        call describe(self, problem, log_level)
        call check_places(problem, problem%output%file // '.h5', error)
        if (.not. allocated(error)) call self%results%open(problem, gauge, error)
        if (.not. allocated(error)) call self%log%line('  results: ' // self%results%path)
    end subroutine open_monitor

    subroutine describe(self, problem, log_level)
        class(monitor_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: log_level
        integer :: i

        self%log%level = log_level
        self%origin = origin_of(problem)
        self%probes = problem%probes
        if (allocated(problem%tuning)) self%tuning = problem%tuning
        self%has_energy = .not. problem%model%has_no_potential()
        allocate (self%extremes(size(self%probes)))
        self%sensors = [(place_sensor(problem%model%mesh, self%probes(i)), i=1, size(self%probes))]
    end subroutine describe

    !> Go on as the checkpoint in the file `path` says: with its results, and inside or behind command
    !> `self%number`.
    subroutine resume_monitor(self, problem, gauge, log_level, path, checkpoint, error)
        class(monitor_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        class(gauge_t), intent(in) :: gauge
        integer, intent(in) :: log_level
        character(*), intent(in) :: path
        type(checkpoint_t), intent(inout) :: checkpoint
        type(error_t), allocatable, intent(out) :: error

        call describe(self, problem, log_level)
        call read_checkpoint(path, self%origin, checkpoint, error)
        if (allocated(error)) return
        self%wall_before = checkpoint%wall_seconds
        self%cpu_before = checkpoint%cpu_seconds
        call pass_memory(self, checkpoint%memory)
        call checkpoint%memory%check(error)
        if (.not. allocated(error) .and. (self%number < 1 .or. self%number > size(problem%tasks))) then
            call raise(error, status_file, 'the checkpoint ' // path // ' does not fit the deck''s commands')
        end if
        if (allocated(error)) return
        self%task = problem%tasks(self%number)
        call check_places(problem, problem%output%file // '.h5', error)
        if (.not. allocated(error)) call check_restart_place(problem%output%file // '.h5', path, error)
        if (allocated(error)) return
        call self%results%resume(problem, gauge, self%origin, checkpoint, path, self%number, &
            self%is_inside, error)
        if (allocated(error)) return
        call self%watch%begin_task(self%task%safeguard)
        call self%log%line('  results: ' // self%results%path)
        call self%log%line('  going on from ' // path // ': ' // checkpoint%command // ', step ' &
                           // to_text(checkpoint%step))
        if (self%is_inside) then
            call self%log%line('')
            call self%log%line(task_heading(self%task))
            call self%log%line(column_heading(self))
        end if
        call self%log%start_bar()
    end subroutine resume_monitor

    !> What the log and the results file remember of the commands so far.
    subroutine pass_memory(self, memory)
        class(monitor_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory

        call memory%pass('run.command', self%number)
        call memory%pass('run.is_inside', self%is_inside)
        if (.not. self%is_inside) return
        call memory%pass('monitor.iterations', self%iterations)
        call memory%pass('monitor.cuts', self%cuts)
        call memory%pass('monitor.largest_energy', self%largest_energy)
        call memory%pass('monitor.largest_drift', self%largest_drift)
        call memory%pass('monitor.when_drift', self%when_drift)
        call memory%pass('monitor.next_line', self%next_line)
        call self%first%pass_memory(memory, 'monitor.first')
        call self%last%pass_memory(memory, 'monitor.last')
        call memory%pass('monitor.largest', self%extremes%largest)
        call memory%pass('monitor.smallest', self%extremes%smallest)
        call memory%pass('monitor.when_largest', self%extremes%when_largest)
        call memory%pass('monitor.when_smallest', self%extremes%when_smallest)
    end subroutine pass_memory

    !> Whether a checkpoint is due after the step just recorded, or after a command.
    logical function wants_memory(self)
        class(monitor_t), intent(inout) :: self

        wants_memory = self%watch%is_due(self%last%number)
    end function wants_memory

    !> Write a checkpoint. Where the run is to stop, error says so; a checkpoint on the way that cannot be
    !> written is only warned of, since the run itself is well.
    subroutine keep_memory(self, memory, error)
        class(monitor_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: trouble
        type(checkpoint_t) :: checkpoint
        character(:), allocatable :: path, place
        logical :: stopping

        stopping = self%watch%must_stop()
        path = self%results%path(:len(self%results%path) - 3) // '.chk.h5'
        if (allocated(self%task%safeguard%file)) path = self%task%safeguard%file
        call self%results%sync(error)
        if (allocated(error)) return
        call pass_memory(self, memory)
        call self%results%pass_memory(memory, self%is_inside)
        checkpoint%created = self%results%created
        checkpoint%results = self%results%path
        checkpoint%command = self%task%name
        checkpoint%step = self%last%number
        checkpoint%abscissa = self%last%abscissa
        checkpoint%wall_seconds = self%wall_seconds()
        checkpoint%cpu_seconds = self%cpu_seconds()
        checkpoint%memory = memory
        call write_checkpoint(path, self%origin, checkpoint, trouble)
        call self%watch%note_checkpoint()
        place = 'step ' // to_text(self%last%number) // ' of ' // self%task%name
        if (.not. self%is_inside) place = 'the end of ' // self%task%name
        if (allocated(trouble)) then
            self%lacks_checkpoint = stopping
            if (stopping) then
                call raise(error, trouble%status, 'stopped by ' // self%watch%reason() // ' after ' // place &
                           // ', and ' // trouble%message)
            else
                call self%log%line('  warning: ' // trouble%message // '; the run goes on')
            end if
            return
        end if
        call self%log%detail('      checkpoint ' // path)
        if (stopping) call raise(error, status_interrupted, 'stopped by ' // self%watch%reason() &
                                 // ' after ' // place // '; go on with --restart ' &
                                 // shell_word(path))
    end subroutine keep_memory

    !> Time that the run has taken, that before a restart included [s].
    real(wp) function wall_seconds(self)
        class(monitor_t), intent(in) :: self

        wall_seconds = self%wall_before + self%watch%elapsed()
    end function wall_seconds

    real(wp) function cpu_seconds(self)
        class(monitor_t), intent(in) :: self

        call cpu_time(cpu_seconds)
        cpu_seconds = self%cpu_before + cpu_seconds
    end function cpu_seconds

    subroutine begin_task(self, task, error)
        class(monitor_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        self%task = task
        self%number = self%number + 1
        self%is_inside = .true.
        call self%watch%begin_task(task%safeguard)
        self%iterations = 0
        self%cuts = 0
        self%next_line = 0.0_wp
        self%largest_energy = 0.0_wp
        self%largest_drift = 0.0_wp
        self%extremes = extremes_t()
        call self%results%begin_task(task, self%probes, error)
        if (allocated(error)) return
        call self%log%line('')
        call self%log%line(task_heading(task))
        if (task%kind /= task_modal) call self%log%line(column_heading(self))
        call self%log%start_bar()
    end subroutine begin_task

    function task_heading(task) result(text)
        type(task_t), intent(in) :: task
        character(:), allocatable :: text

        select case (task%kind)
        case (task_static)
            text = task%name // ': static, ' // to_text(task%steps) // ' steps to load ' // to_text(task%load)
        case (task_modal)
            text = task%name // ': ' // to_text(task%count) // ' natural modes about the current state'
        case default
            text = task%name // ': ' // task%scheme
            if (task%accuracy > 0.0_wp) then
                text = text // ', adaptive steps of accuracy ' // to_text(task%accuracy)
            else
                text = text // ', step ' // to_text(task%step)
            end if
            text = text // ' to time ' // to_text(task%end_time)
        end select
    end function task_heading

    function column_heading(self) result(text)
        class(monitor_t), intent(in) :: self
        character(:), allocatable :: text
        integer :: i

        text = '    step  ' // padded(trim(merge('load', 'time', self%task%kind == task_static)), 13) &
            // '  Newton'
        do i = 1, min(shown_probes, size(self%probes))
            text = text // padded(self%probes(i)%name, 14)
        end do
    end function column_heading

    !> Right-aligned, a name too long is cut.
    pure function padded(text, width) result(field)
        character(*), intent(in) :: text
        integer, intent(in) :: width
        character(width) :: field

        if (len(text) >= width) then
            field = ' ' // text(:width - 1)
        else
            field = repeat(' ', width - len(text)) // text
        end if
    end function padded

    subroutine record_step(self, step, state, error)
        class(monitor_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: values(size(self%probes))
        integer :: i

        values = [(self%sensors(i)%reading(state), i=1, size(self%probes))]
        do i = 1, size(values)
            call self%extremes(i)%widen(values(i), step%abscissa)
        end do
        if (step%number == 0) self%first = step
        self%last = step
        self%iterations = self%iterations + step%iterations
        self%cuts = self%cuts + step%cuts
        self%largest_energy = max(self%largest_energy, abs(step%kinetic), abs(step%strain), &
            abs(step%external))
        if (abs(balance(self)) > self%largest_drift) then
            self%largest_drift = abs(balance(self))
            self%when_drift = step%abscissa
        end if
        call self%results%write_step(step, state, values, error)
        if (allocated(error)) return
        if (allocated(step%increments) .and. self%log%level >= log_verbose) then
            do i = 1, size(step%increments)
                call self%log%detail('      iteration ' // to_text(i) // '  increment ' &
                    // to_text(step%increments(i), 4))
            end do
        end if
        ! Numbers in words cost more than a small step: only for those who read them.
        if (step%progress >= self%next_line - 1.0e-9_wp .or. step%cuts > 0) then
            if (self%log%level >= log_normal) call self%log%line(step_line(step, values))
            self%next_line = real(floor(step%progress*lines_a_command + 1.0e-9_wp) + 1, &
                wp)/real(lines_a_command, wp)
        else if (self%log%level >= log_verbose) then
            call self%log%detail(step_line(step, values))
        end if
        call self%log%show_bar(step%progress)
    end subroutine record_step

    function step_line(step, values) result(text)
        type(step_record_t), intent(in) :: step
        real(wp), intent(in) :: values(:)
        character(:), allocatable :: text
        integer :: i

        text = padded(to_text(step%number), 8) // '  ' // padded(to_text(step%abscissa), 13) &
            // padded(to_text(step%iterations), 8)
        do i = 1, min(shown_probes, size(values))
            text = text // padded(to_text(values(i)), 14)
        end do
        if (step%cuts == 1) text = text // '   cut once'
        if (step%cuts > 1) text = text // '   cut ' // to_text(step%cuts) // ' times'
    end function step_line

    subroutine record_modes(self, frequency, modes, error)
        class(monitor_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:), modes(:, :)
        type(error_t), allocatable, intent(out) :: error
        integer :: i

        call self%results%write_modes(frequency, modes, error)
        if (allocated(error)) return
        call self%log%line('    mode     frequency     angular')
        do i = 1, size(frequency)
            call self%log%line(padded(to_text(i), 8) // padded(to_text(frequency(i), 7), 14) // &
                               padded(to_text(2.0_wp*pi*frequency(i), 7), 14))
        end do
    end subroutine record_modes

    subroutine end_task(self, failure, error)
        class(monitor_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: failure
        type(error_t), allocatable, intent(out) :: error

        call self%log%clear_bar()
        self%is_inside = .false.
        call self%results%end_task(error)
        if (allocated(error) .or. allocated(failure) .or. self%task%kind == task_modal) return
        call report_extremes(self)
        call self%log%line('  ' // to_text(self%last%number) // ' steps, ' // to_text(self%iterations) // &
                           ' Newton iterations, ' // to_text(self%cuts) // ' cuts')
        if (self%task%kind == task_transient) call report_energy(self)
        if (self%results%faces_beyond() > 0) call self%log%line('  warning: ' &
            // to_text(self%results%faces_beyond()) // ' times a face lay beyond the material''s limits, ' &
            // 'where no stress exists; that of the next integration point stands there')
    end subroutine end_task

    subroutine report_extremes(self)
        class(monitor_t), intent(inout) :: self
        character(:), allocatable :: at
        integer :: i

        at = ' at t = '
        if (self%task%kind == task_static) at = ' at load '
        do i = 1, size(self%probes)
            if (self%task%kind == task_static .and. self%probes(i)%quantity /= quantity_displacement) cycle
            associate (probe => self%probes(i), e => self%extremes(i))
                call self%log%line('  ' // probe%name // ': largest ' // to_text(e%largest) // at // &
                                   to_text(e%when_largest) // ', smallest ' // to_text(e%smallest) // at // &
                                   to_text(e%when_smallest) // error_bar(self, i))
            end associate
        end do
    end subroutine report_extremes

    !> What `auto` estimates a probe's error to be, root mean square over the command; empty without it.
    function error_bar(self, probe) result(text)
        class(monitor_t), intent(in) :: self
        integer, intent(in) :: probe
        character(:), allocatable :: text
        integer :: i

        text = ''
        if (.not. allocated(self%tuning)) return
        do i = 1, size(self%tuning%bars)
            associate (bar => self%tuning%bars(i))
                if (bar%task == self%number .and. bar%probe == probe) text = '; error bar ' &
                    // to_text(bar%absolute, 2) // ' (' // to_text(100.0_wp*bar%relative, 2) // ' %)'
            end associate
        end do
    end function error_bar

    !> What the running command's energies fail to add up to, zero at its start [F L].
    pure real(wp) function balance(self)
        class(monitor_t), intent(in) :: self

        associate (first => self%first, last => self%last)
            balance = last%kinetic + last%strain - last%external + last%dissipated - first%kinetic &
                - first%strain
        end associate
    end function balance

    !> The energy ledger of a transient, and a warning where it has drifted.
    subroutine report_energy(self)
        class(monitor_t), intent(inout) :: self
        real(wp), parameter :: worrying_part = 0.01_wp
        real(wp) :: part
        character(:), allocatable :: text

        associate (last => self%last)
            call self%log%line('  energy: kinetic ' // to_text(last%kinetic) // ', strain ' &
                // to_text(last%strain) // ', external work ' // to_text(last%external) // ', dissipated ' &
                // to_text(last%dissipated) // ', balance ' // to_text(balance(self), 3))
        end associate
        if (self%largest_energy <= 0.0_wp) return
        part = self%largest_drift/self%largest_energy
        if (part <= worrying_part) return
        text = '  warning: the energy balance drifts by ' // to_text(100.0_wp*part, 3) &
               // ' % of the largest energy (worst at t = ' // to_text(self%when_drift) // '); '
        if (self%has_energy) then
            text = text // 'compare with a smaller step'
            if (self%task%scheme /= 'energy') text = text // ' or another scheme'
        else
            text = text // 'rule linear has no exact stored energy: compare with rule gauss'
        end if
        call self%log%line(text)
    end subroutine report_energy

    subroutine note(self, text)
        class(monitor_t), intent(inout) :: self
        character(*), intent(in) :: text

        call self%log%line('  ' // text)
    end subroutine note

end module gb_monitor
