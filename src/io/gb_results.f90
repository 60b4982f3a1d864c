!> The results file (docs/results.md): what is written where, with its unit and description.
module gb_results
    use gb_kinds, only: wp, i8
    use gb_error, only: error_t, raise, status_file
    use gb_memory, only: memory_t
    use gb_files, only: begin_rehearsal, end_rehearsal, rehearsal_went_well
    use gb_checkpoint, only: origin_t, checkpoint_t
    use gb_resume, only: find_source
    use gb_hdf5_input, only: hid_t, open_file, close_file, get_numbers, get_rows, verify
    use gb_results_header, only: write_header, write_units, write_mesh, now
    use gb_results_task, only: write_task_attributes, write_mode_shapes, n_energies, n_solver, &
        energy_names, energy_descriptions, solver_names, solver_descriptions, set_names, set_descriptions, &
        abscissa_name, abscissa_unit, probe_description, product_unit, derived_unit, field_units
    use gb_results_tuning, only: write_tuning
    use gb_results_recovery, only: recovery_series_t, write_stations
    use gb_fields, only: n_fields, field_length_power
    use gb_model, only: units_t
    use gb_paraview, only: paraview_t
    use gb_gauge, only: gauge_t
    use gb_problem, only: problem_t, task_t, probe_t, output_t, task_modal
    use gb_state, only: state_t
    use gb_recorder, only: step_record_t
    use gb_archive, only: archive_t, root, stored_real64, stored_int32, step_seconds, command_seconds
    implicit none
    private

    !> A model of so many nodes is visible from the start. A smaller one comes to its first step, or to its
    !> end, before anybody could look; half of what its file costs is saved.
    integer, parameter :: visible_nodes = 1000

    !> A restart that has not read its old results by then meets a loop in them [s].
    integer, parameter :: rehearsal_seconds = 600

    type, public :: results_t
        private
        character(:), allocatable, public :: path
        character(:), allocatable, public :: created    !! when the run began, ISO 8601
        type(archive_t) :: archive
        type(units_t) :: units
        integer :: commands = 0                     !! solution commands begun
        integer :: every = 1
        integer :: nodes = 0
        integer :: grid_steps = 0                   !! whole steps of the running command
        integer :: group = 0                        !! of the running command
        logical :: has_fields(3) = .false.          !! u, v, a
        real(wp) :: start_energy = 0.0_wp
        logical :: has_unwritten = .false.          !! the latest state was left out by OUTPUT every=
        real(wp) :: unwritten_abscissa = 0.0_wp
        type(state_t) :: unwritten                  !! it is written if it turns out to be the last
        !> Nodes of the running command's series.
        integer :: time = 0, fields(3) = 0, all_time = 0, energies(n_energies) = 0, solver(n_solver) = 0
        integer, allocatable :: probes(:)
        class(gauge_t), allocatable :: gauge        !! reads strains and stresses off a state
        type(output_t) :: output
        type(recovery_series_t) :: recovered
        type(paraview_t) :: paraview
        real(wp), allocatable :: x(:)               !! reference X1 of the nodes [L]
        integer :: commands_shown = 0               !! commands begun that have a course in time or load
    contains
        procedure :: open => open_results
        procedure :: resume => resume_results
        procedure :: pass_memory
        procedure :: sync
        procedure :: begin_task
        procedure :: write_step
        procedure :: write_modes
        procedure :: end_task
        procedure :: close => close_results
        procedure :: faces_beyond
    end type results_t

contains

    !> Create NAME.h5 with all that does not change. A file that cannot be written is reported with the
    !> system's reason.
    subroutine open_results(self, problem, gauge, error)
        class(results_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        class(gauge_t), intent(in) :: gauge
        type(error_t), allocatable, intent(out) :: error

        self%created = now()
        call begin_file(self, problem, gauge, error)
        if (.not. self%archive%is_open()) return
        if (self%nodes >= visible_nodes .and. .not. allocated(error)) call publish(self, error)
        if (allocated(error)) call self%archive%give_up(error%message)
    end subroutine open_results

    !> All that does not change, in a file that nobody sees yet.
    subroutine begin_file(self, problem, gauge, error)
        class(results_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        class(gauge_t), intent(in) :: gauge
        type(error_t), allocatable, intent(out) :: error
        integer :: mesh                             ! the group

        self%path = problem%output%file // '.h5'
        self%units = problem%model%units
        self%every = problem%output%every
        self%nodes = problem%model%mesh%n_nodes()
        self%output = problem%output
        self%x = problem%model%mesh%x
        allocate (self%gauge, source=gauge)
        self%has_fields = [problem%output%u, problem%output%v, problem%output%a]
        if (.not. allocated(self%probes)) allocate (self%probes(size(problem%probes)))
        call self%archive%open(self%path, error)
        if (allocated(error)) return
        call write_header(self%archive, problem, self%created)
        call write_units(self%archive, self%units)
        call write_mesh(self%archive, root, problem%model, mesh, error)
        if (.not. allocated(error) .and. (self%output%strain .or. self%output%stress)) then
            call write_stations(self%archive, mesh, self%gauge, self%units, error)
        end if
        if (allocated(problem%tuning) .and. .not. allocated(error)) call write_tuning(self%archive, problem, &
            error)
    end subroutine begin_file

    !> Go on with the results of an interrupted run: those up to the checkpoint are taken over into a new
    !> file, which then takes the old one's place. `inside` says that command `number` was running at the
    !> checkpoint; else it was over.
    subroutine resume_results(self, problem, gauge, origin, checkpoint, path, number, inside, error)
        class(results_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        class(gauge_t), intent(in) :: gauge
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(inout) :: checkpoint
        character(*), intent(in) :: path            !! of the checkpoint
        integer, intent(in) :: number
        logical, intent(in) :: inside
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: ignored
        character(:), allocatable :: source
        integer(hid_t) :: file
        integer :: process

        self%path = problem%output%file // '.h5'
        self%created = checkpoint%created
        ! HDF5 may crash on a file that is damaged, so another process looks at all of it before.
        process = begin_rehearsal(rehearsal_seconds)
        if (process == 0) then
            call open_source(self%path, path, origin, checkpoint, source, file, error)
            call end_rehearsal()
        end if
        if (rehearsal_went_well(process)) then
            call open_source(self%path, path, origin, checkpoint, source, file, error)
        else
            call raise(error, status_file, 'cannot go on with the results file ' // self%path &
                       // ': it is damaged, and reading it ends in a crash of HDF5, or never')
        end if
        if (allocated(error)) return
        call begin_file(self, problem, gauge, error)
        if (.not. allocated(error)) call take_over(self, problem, source, file, checkpoint, number, inside, &
            error)
        call close_file(file)
        if (.not. allocated(error)) then
            call publish(self, error)
            if (allocated(error)) call self%archive%give_up(error%message)
        else if (self%archive%is_open()) then
            call self%archive%close(ignored)
        end if
    end subroutine resume_results

    !> Find and open the results of the steps before the checkpoint, which must be what was written.
    subroutine open_source(path, beside, origin, checkpoint, source, file, error)
        character(*), intent(in) :: path            !! of the results
        character(*), intent(in) :: beside          !! path of the checkpoint
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(in) :: checkpoint
        character(:), allocatable, intent(out) :: source
        integer(hid_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error

        file = -1
        call find_source(path, beside, origin, checkpoint, .true., source, error)
        if (allocated(error)) return
        call open_file(source, file, error)
        if (.not. allocated(error)) then
            call verify(file, error)
            if (allocated(error)) call close_file(file)
        end if
        if (allocated(error)) error%message = 'cannot go on with the results file ' // source // ': ' &
            // error%message
    end subroutine open_source

    subroutine take_over(self, problem, source, file, checkpoint, number, inside, error)
        class(results_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        character(*), intent(in) :: source
        integer(hid_t), intent(in) :: file
        type(checkpoint_t), intent(inout) :: checkpoint
        integer, intent(in) :: number
        logical, intent(in) :: inside
        type(error_t), allocatable, intent(out) :: error
        integer :: i

        do i = 1, number
            call add_task(self, problem%tasks(i), problem%probes, error)
            if (allocated(error)) exit
            call take_over_task(self, problem%tasks(i), file, checkpoint%memory, inside .and. i == number, &
                error)
            if (allocated(error)) exit
        end do
        if (.not. inside .and. .not. allocated(error)) call replay_rows(self, file, checkpoint%memory, &
            inside, error)
        if (allocated(error)) error%message = 'cannot go on with the results file ' // source // ': ' &
            // error%message
    end subroutine take_over

    subroutine take_over_task(self, task, file, memory, inside, error)
        class(results_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        integer(hid_t), intent(in) :: file
        type(memory_t), intent(inout) :: memory
        logical, intent(in) :: inside
        type(error_t), allocatable, intent(out) :: error
        real(wp), allocatable :: frequency(:), modes(:, :)

        if (task%kind == task_modal) then
            call get_numbers(file, task%name // '/frequency', frequency, error)
            if (allocated(error)) return
            allocate (modes(n_fields*self%nodes, size(frequency)))
            call get_rows(file, task%name // '/modes', [int(n_fields, i8), int(self%nodes, i8)], 0_i8, &
                modes, error)
            if (.not. allocated(error)) call write_mode_shapes(self%archive, self%group, self%units, &
                frequency, modes, error)
        else if (inside) then
            call replay_rows(self, file, memory, inside, error)
        else
            call self%archive%replay(file, error, group=self%group)
        end if
        if (.not. allocated(error) .and. .not. inside) call self%archive%finish(self%group, error)
    end subroutine take_over_task

    !> The rows of every series that still grows, as many as there were at the checkpoint.
    subroutine replay_rows(self, file, memory, inside, error)
        class(results_t), intent(inout) :: self
        integer(hid_t), intent(in) :: file
        type(memory_t), intent(inout) :: memory
        logical, intent(in) :: inside
        type(error_t), allocatable, intent(out) :: error
        integer, allocatable :: counts(:)

        call self%pass_memory(memory, inside)
        counts = self%archive%row_counts()
        call memory%pass('results.rows', counts)
        call memory%check(error)
        if (.not. allocated(error)) call self%archive%replay(file, error, counts)
    end subroutine replay_rows

    !> What the next step is written by; and for a checkpoint, how many rows each series of the running
    !> command has.
    subroutine pass_memory(self, memory, inside)
        class(results_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory
        logical, intent(in) :: inside               !! whether a command is running
        integer, allocatable :: counts(:)
        integer :: n

        call self%paraview%pass_memory(memory)
        if (inside) then
            call memory%pass('results.faces_beyond', self%recovered%beyond)
            call memory%pass('results.grid_steps', self%grid_steps)
            call memory%pass('results.start_energy', self%start_energy)
            call memory%pass('results.has_unwritten', self%has_unwritten)
            if (self%has_unwritten) then
                n = n_fields*self%nodes
                if (.not. allocated(self%unwritten%u)) allocate (self%unwritten%u(n), self%unwritten%v(n), &
                    self%unwritten%a(n))
                call memory%pass('results.unwritten_abscissa', self%unwritten_abscissa)
                call self%unwritten%pass_memory(memory, 'results.unwritten')
            end if
        end if
        if (memory%is_recalling) return
        counts = self%archive%row_counts()
        call memory%pass('results.rows', counts)
    end subroutine pass_memory

    !> Everything so far is visible in the file, and the file on the disk, when this returns.
    subroutine sync(self, error)
        class(results_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        call self%archive%publish(.false., .true., error)
        if (allocated(error)) call self%archive%give_up(error%message)
    end subroutine sync

    !> Make all that is there visible.
    subroutine publish(self, error)
        class(results_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        call self%paraview%count_rows(self%archive)
        call self%archive%publish(.false., self%archive%age() > step_seconds, error)
    end subroutine publish

    !> Do so if that was not done for so many seconds.
    subroutine publish_in_time(self, seconds, error)
        class(results_t), intent(inout) :: self
        real(wp), intent(in) :: seconds
        type(error_t), allocatable, intent(out) :: error

        if (self%archive%is_due(seconds)) call publish(self, error)
    end subroutine publish_in_time

    !> Open a solution command's group and its series.
    subroutine begin_task(self, task, probes, error)
        class(results_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(probe_t), intent(in) :: probes(:)
        type(error_t), allocatable, intent(out) :: error

        call add_task(self, task, probes, error)
        if (.not. allocated(error)) call publish_in_time(self, command_seconds, error)
        if (allocated(error)) call self%archive%give_up(error%message)
    end subroutine begin_task

    subroutine add_task(self, task, probes, error)
        class(results_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(probe_t), intent(in) :: probes(:)
        type(error_t), allocatable, intent(out) :: error

        self%commands = self%commands + 1
        self%grid_steps = 0
        call self%archive%add_group(root, task%name, self%group)
        call write_task_attributes(self%archive, self%group, task, self%commands)
        if (task%kind /= task_modal) call add_all_series(self, task, probes, error)
    end subroutine add_task

    subroutine add_all_series(self, task, probes, error)
        class(results_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(probe_t), intent(in) :: probes(:)
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: time_unit, abscissa, energy_unit, unit
        integer :: group, i

        time_unit = abscissa_unit(task, self%units)
        abscissa = abscissa_name(task)
        energy_unit = product_unit(self%units%force, self%units%length)
        associate (archive => self%archive)
            call archive%add_series(self%group, 'time', [integer ::], stored_real64, time_unit, &
                abscissa // ' of every row', self%time)
            do i = 1, 3
                if (self%has_fields(i)) call archive%add_series(self%group, set_names(i), [n_fields, &
                    self%nodes], stored_real64, field_units(self%units, i), trim(set_descriptions(i)), &
                    self%fields(i))
            end do
            if (self%commands_shown == 0 .and. self%output%u) then
                call self%paraview%open(archive, self%x, self%gauge, self%units, self%output%strain, error)
                if (allocated(error)) return
            end if
            self%commands_shown = self%commands_shown + 1
            call self%paraview%begin_task()
            call self%recovered%create(archive, self%group, self%gauge, self%output, self%units)
            call archive%add_group(self%group, 'probes', group)
            call archive%add_series(group, 'time', [integer ::], stored_real64, time_unit, &
                abscissa // ' of every step', self%all_time)
            do i = 1, size(probes)
                call archive%add_series(group, probes(i)%name, [integer ::], stored_real64, &
                    derived_unit(self%units, field_length_power(probes(i)%field), probes(i)%quantity), &
                    probe_description(probes(i)), self%probes(i))
            end do
            call archive%add_group(self%group, 'energy', group)
            do i = 1, n_energies
                call archive%add_series(group, trim(energy_names(i)), [integer ::], stored_real64, &
                    energy_unit, trim(energy_descriptions(i)), self%energies(i))
            end do
            call archive%add_group(self%group, 'solver', group)
            do i = 1, n_solver
                unit = ''
                if (i == 3) unit = time_unit
                call archive%add_series(group, trim(solver_names(i)), [integer ::], &
                    merge(stored_int32, stored_real64, i <= 2), unit, &
                    trim(solver_descriptions(i)), self%solver(i))
            end do
        end associate
    end subroutine add_all_series

    !> Hand one step to the file's series; row 0 is the start state.
    subroutine write_step(self, step, state, probe_values, error)
        class(results_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        real(wp), intent(in) :: probe_values(:)
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: energies(n_energies), solver(n_solver)
        integer :: i

        energies(:4) = [step%kinetic, step%strain, step%external, step%dissipated]
        if (step%number == 0) self%start_energy = step%kinetic + step%strain
        energies(5) = step%kinetic + step%strain - step%external + step%dissipated - self%start_energy
        solver = [real(step%iterations, wp), real(step%cuts, wp), step%step, step%residual]
        if (step%on_grid .and. step%number > 0) self%grid_steps = self%grid_steps + 1
        if (self%every == 1 .or. (step%on_grid .and. modulo(self%grid_steps, self%every) == 0)) then
            self%has_unwritten = .false.
            call write_row(self, step%abscissa, state, error)
        else
            self%has_unwritten = .true.
            self%unwritten_abscissa = step%abscissa
            self%unwritten = state
        end if
        if (.not. allocated(error)) call self%archive%append(self%all_time, [step%abscissa], error)
        do i = 1, size(self%probes)
            if (.not. allocated(error)) call self%archive%append(self%probes(i), [probe_values(i)], error)
        end do
        do i = 1, n_energies
            if (.not. allocated(error)) call self%archive%append(self%energies(i), [energies(i)], error)
        end do
        do i = 1, n_solver
            if (.not. allocated(error)) call self%archive%append(self%solver(i), [solver(i)], error)
        end do
        if (.not. allocated(error)) call publish_in_time(self, step_seconds, error)
        if (allocated(error)) call self%archive%give_up(error%message)
    end subroutine write_step

    subroutine write_row(self, abscissa, state, error)
        class(results_t), intent(inout) :: self
        real(wp), intent(in) :: abscissa
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error

        associate (archive => self%archive)
            call archive%append(self%time, [abscissa], error)
            if (self%has_fields(1) .and. .not. allocated(error)) call archive%append(self%fields(1), &
                state%u, error)
            if (self%has_fields(2) .and. .not. allocated(error)) call archive%append(self%fields(2), &
                state%v, error)
            if (self%has_fields(3) .and. .not. allocated(error)) call archive%append(self%fields(3), &
                state%a, error)
            if (.not. allocated(error)) call self%recovered%append(archive, self%gauge, state%u, error)
            if (.not. allocated(error)) call self%paraview%append(archive, self%gauge, abscissa, state%u, &
                error)
        end associate
    end subroutine write_row

    !> Natural frequencies [cycles/T] and modes (5, nn, nm) of the running MODAL command.
    subroutine write_modes(self, frequency, modes, error)
        class(results_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:)
        real(wp), intent(in) :: modes(:, :)         !! (5 nn, nm)
        type(error_t), allocatable, intent(out) :: error

        call write_mode_shapes(self%archive, self%group, self%units, frequency, modes, error)
        if (allocated(error)) call self%archive%give_up(error%message)
    end subroutine write_modes

    !> How many faces of the command's rows lay beyond the material's limits, so that another point's stress
    !> stands in for theirs.
    pure integer function faces_beyond(self)
        class(results_t), intent(in) :: self

        faces_beyond = self%recovered%beyond
    end function faces_beyond

    !> Nothing is added to the running command's group any more.
    subroutine end_task(self, error)
        class(results_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (self%has_unwritten) call write_row(self, self%unwritten_abscissa, self%unwritten, error)
        self%has_unwritten = .false.
        if (.not. allocated(error)) call self%archive%finish(self%group, error)
        if (.not. allocated(error)) call publish_in_time(self, command_seconds, error)
        if (allocated(error)) call self%archive%give_up(error%message)
    end subroutine end_task

    !> Write how the run ended, and close.
    subroutine close_results(self, status, message, wall_seconds, cpu_seconds, error)
        class(results_t), intent(inout) :: self
        character(*), intent(in) :: status          !! complete, failed or interrupted
        character(*), intent(in) :: message
        real(wp), intent(in) :: wall_seconds, cpu_seconds
        type(error_t), allocatable, intent(out) :: error

        if (.not. self%archive%is_open()) return
        call self%paraview%count_rows(self%archive)
        call self%archive%set(root, 'status', status)
        call self%archive%set(root, 'message', message)
        call self%archive%set(root, 'wall_seconds', wall_seconds)
        call self%archive%set(root, 'cpu_seconds', cpu_seconds)
        call self%archive%publish(.true., self%archive%age() > step_seconds, error)
        if (allocated(error)) then
            call self%archive%give_up(error%message)
        else
            call self%archive%close(error)
        end if
    end subroutine close_results

end module gb_results
