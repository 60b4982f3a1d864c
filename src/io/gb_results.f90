!> The results file (docs/results.md): what is written where, with its unit and description.
module gb_results
    use gb_kinds, only: wp, i8
    use gb_error, only: error_t, raise, status_file
    use gb_posix, only: claim_file, try_to_write
    use gb_text, only: to_text
    use gb_results_header, only: write_header, write_units, write_mesh
    use gb_results_recovery, only: recovery_series_t, write_stations
    use gb_fields, only: n_fields, field_names, field_length_power
    use gb_model, only: units_t
    use gb_paraview, only: paraview_t
    use gb_gauge, only: gauge_t
    use gb_problem, only: problem_t, task_t, probe_t, output_t, task_static, task_modal, task_transient, &
        quantity_displacement, quantity_velocity
    use gb_state, only: state_t
    use gb_recorder, only: step_record_t
    use gb_hdf5, only: hid_t, series_t, create_file, flush_file, close_file, create_group, close_group, &
        put_attribute, put_array, replace_attribute
    implicit none
    private

    integer, parameter :: n_energies = 5, n_solver = 4
    character(10), parameter :: energy_names(n_energies) = [character(10) :: 'kinetic', 'strain', &
        'external', 'dissipated', 'balance']
    character(64), parameter :: energy_descriptions(n_energies) = [character(64) :: &
        'kinetic energy', 'strain energy', 'work of the loads since the command began', &
        'energy taken by damping since the command began', &
        'kinetic + strain - external + dissipated, from its start value']
    character(10), parameter :: solver_names(n_solver) = [character(10) :: 'iterations', 'cuts', 'step', &
        'residual']
    character(64), parameter :: solver_descriptions(n_solver) = [character(64) :: &
        'Newton iterations, those of rejected attempts included', 'times the step was halved', &
        'size of the step', 'last residual over the forces that balance in it']
    character(1), parameter :: set_names(3) = ['u', 'v', 'a']
    character(40), &
        parameter :: set_descriptions(3) = [character(40) :: 'fields u1 u3 y1 y3 xi at every node', &
        'their velocities', 'their accelerations']
    !> Wall seconds between two moments at which everything gathered so far is handed to the file.
    real(wp), parameter :: flush_seconds = 2.0_wp

    type, public :: results_t
        private
        character(:), allocatable, public :: path
        integer(hid_t) :: file = -1
        logical :: is_open = .false.
        type(units_t) :: units
        integer :: commands = 0                     !! solution commands begun
        integer :: commands_shown = 0               !! those with a course in time or load
        integer :: every = 1
        integer :: nodes = 0
        integer :: grid_steps = 0                   !! whole steps of the running command
        integer(hid_t) :: group = -1                !! of the running command
        logical :: has_fields(3) = .false.          !! u, v, a
        real(wp) :: start_energy = 0.0_wp
        logical :: has_unwritten = .false.          !! the latest state was left out by OUTPUT every=
        real(wp) :: unwritten_abscissa = 0.0_wp
        type(state_t) :: unwritten                  !! it is written if it turns out to be the last
        type(series_t) :: time, fields(3), all_time, energies(n_energies), solver(n_solver)
        type(series_t), allocatable :: probes(:)
        class(gauge_t), allocatable :: gauge        !! reads strains and stresses off a state
        type(output_t) :: output
        type(recovery_series_t) :: recovered
        type(paraview_t) :: paraview
        real(wp), allocatable :: x(:)               !! reference X1 of the nodes [L]
        integer(i8) :: last_flush = 0
    contains
        procedure :: open => open_results
        procedure :: begin_task
        procedure :: write_step
        procedure :: write_modes
        procedure :: end_task
        procedure :: close => close_results
        procedure :: faces_beyond
        procedure, private :: fail
    end type results_t

contains

    !> Create NAME.h5 and write all that does not change. A file that cannot be written is reported with the
    !> system's reason.
    subroutine open_results(self, problem, gauge, error)
        class(results_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        class(gauge_t), intent(in) :: gauge
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: reason

        self%path = problem%output%file // '.h5'
        self%units = problem%model%units
        self%every = problem%output%every
        self%nodes = problem%model%mesh%n_nodes()
        self%output = problem%output
        self%x = problem%model%mesh%x
        allocate (self%gauge, source=gauge)
        self%has_fields = [problem%output%u, problem%output%v, problem%output%a]
        allocate (self%probes(size(problem%probes)))
        reason = claim_file(self%path)
        if (len(reason) > 0) then
            call raise(error, status_file, 'cannot write the results file ' // self%path // ': ' // reason)
            return
        end if
        call create_file(self%path, self%file, error)
        if (allocated(error)) then
            call self%fail(error)
            return
        end if
        self%is_open = .true.
        call write_header(self%file, problem, error)
        if (.not. allocated(error)) call write_units(self%file, self%units, error)
        if (.not. allocated(error)) call write_mesh(self%file, problem%model, error)
        if (.not. allocated(error) .and. (self%output%strain .or. self%output%stress)) then
            call write_stations(self%file, self%gauge, self%units, error)
        end if
        if (.not. allocated(error)) call flush_file(self%file, error)
        if (allocated(error)) call self%fail(error)
        call system_clock(self%last_flush)
    end subroutine open_results

    !> Turn HDF5's failure into a sentence with the file's name and the system's reason: a write beside the
    !> file meets the same trouble and is told why.
    subroutine fail(self, error)
        class(results_t), intent(inout) :: self
        type(error_t), allocatable, intent(inout) :: error
        integer, parameter :: telling_size = 1048576
        character(:), allocatable :: reason

        reason = try_to_write(self%path // '.probe', telling_size)
        if (len(reason) == 0) reason = error%message
        call raise(error, status_file, 'cannot write the results file ' // self%path // ': ' // reason)
    end subroutine fail

    !> Open a solution command's group and its series.
    subroutine begin_task(self, task, probes, error)
        class(results_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(probe_t), intent(in) :: probes(:)
        type(error_t), allocatable, intent(out) :: error

        self%commands = self%commands + 1
        self%grid_steps = 0
        call create_group(self%file, task%name, self%group, error)
        if (.not. allocated(error)) call write_task_attributes(self%group, task, self%commands, error)
        if (.not. allocated(error) .and. task%kind /= task_modal) call create_all_series(self, task, &
            probes, error)
        if (.not. allocated(error)) call flush_file(self%file, error)
        if (allocated(error)) call self%fail(error)
    end subroutine begin_task

    subroutine write_task_attributes(group, task, order, error)
        integer(hid_t), intent(in) :: group
        type(task_t), intent(in) :: task
        integer, intent(in) :: order
        type(error_t), allocatable, intent(out) :: error

        call put_attribute(group, 'order', order, error)
        if (allocated(error)) return
        select case (task%kind)
        case (task_static)
            call put_attribute(group, 'kind', 'static', error)
            if (.not. allocated(error)) call put_attribute(group, 'scheme', 'newton', error)
            if (.not. allocated(error)) call put_attribute(group, 'steps', task%steps, error)
            if (.not. allocated(error)) call put_attribute(group, 'load', task%load, error)
        case (task_modal)
            call put_attribute(group, 'kind', 'modal', error)
            if (.not. allocated(error)) call put_attribute(group, 'scheme', 'subspace iteration', error)
        case (task_transient)
            call put_attribute(group, 'kind', 'transient', error)
            if (.not. allocated(error)) call put_attribute(group, 'scheme', task%scheme, error)
            if (.not. allocated(error)) call put_attribute(group, 'dt', task%step, error)
            if (.not. allocated(error) .and. task%accuracy > 0.0_wp) then
                call put_attribute(group, 'accuracy', task%accuracy, error)
            end if
            if (.not. allocated(error)) call put_attribute(group, 'end', task%end_time, error)
            if (.not. allocated(error)) call write_scheme_numbers(group, task, error)
        end select
        if (.not. allocated(error) .and. task%kind /= task_modal) call put_attribute(group, 'tolerance', &
            task%tolerance, error)
    end subroutine write_task_attributes

    subroutine write_scheme_numbers(group, task, error)
        integer(hid_t), intent(in) :: group
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        select case (task%scheme)
        case ('newmark')
            call put_attribute(group, 'beta', task%beta, error)
            if (.not. allocated(error)) call put_attribute(group, 'gamma', task%gamma, error)
        case ('hht')
            call put_attribute(group, 'alpha', task%alpha, error)
        case ('generalized', 'bathe')
            call put_attribute(group, 'rho', task%rho, error)
        end select
    end subroutine write_scheme_numbers

    subroutine create_all_series(self, task, probes, error)
        class(results_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(probe_t), intent(in) :: probes(:)
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: time_unit, abscissa, energy_unit
        integer(hid_t) :: group
        integer :: i

        time_unit = merge_text(task%kind == task_static, '', self%units%time)
        abscissa = merge_text(task%kind == task_static, 'load factor', 'time since the command began')
        energy_unit = product_unit(self%units%force, self%units%length)
        call self%time%create(self%group, 'time', [integer ::], .false., time_unit, abscissa &
            // ' of every row', error)
        if (allocated(error)) return
        do i = 1, 3
            if (.not. self%has_fields(i)) cycle
            call self%fields(i)%create(self%group, set_names(i), [n_fields, self%nodes], .false., &
                field_units(self%units, i), trim(set_descriptions(i)), error)
            if (allocated(error)) return
        end do
        if (self%commands_shown == 0 .and. self%output%u) then
            call self%paraview%open(self%file, self%x, self%gauge, self%units, self%output%strain, error)
        end if
        if (allocated(error)) return
        self%commands_shown = self%commands_shown + 1
        call self%paraview%begin_task()
        call self%recovered%create(self%group, self%gauge, self%output, self%units, error)
        if (allocated(error)) return
        call create_group(self%group, 'probes', group, error)
        if (allocated(error)) return
        call self%all_time%create(group, 'time', [integer ::], .false., time_unit, abscissa &
            // ' of every step', error)
        if (allocated(error)) return
        do i = 1, size(probes)
            call self%probes(i)%create(group, probes(i)%name, [integer ::], .false., &
                derived_unit(self%units, field_length_power(probes(i)%field), probes(i)%quantity), &
                probe_description(probes(i)), error)
            if (allocated(error)) return
        end do
        call close_group(group)
        call create_group(self%group, 'energy', group, error)
        if (allocated(error)) return
        do i = 1, n_energies
            call self%energies(i)%create(group, trim(energy_names(i)), [integer ::], .false., energy_unit, &
                                         trim(energy_descriptions(i)), error)
            if (allocated(error)) return
        end do
        call close_group(group)
        call create_group(self%group, 'solver', group, error)
        if (allocated(error)) return
        do i = 1, n_solver
            call self%solver(i)%create(group, trim(solver_names(i)), [integer ::], i <= 2, &
                                       merge_text(i == 3, time_unit, ''), trim(solver_descriptions(i)), error)
            if (allocated(error)) return
        end do
        call close_group(group)
    end subroutine create_all_series

    !> "u3 at x = 10", "velocity of u3 at x = 10".
    pure function probe_description(probe) result(text)
        type(probe_t), intent(in) :: probe
        character(:), allocatable :: text

        text = field_names(probe%field) // ' at x = ' // to_text(probe%x)
        if (probe%quantity == quantity_velocity) then
            text = 'velocity of ' // text
        else if (probe%quantity > quantity_displacement) then
            text = 'acceleration of ' // text
        end if
    end function probe_description

    pure function merge_text(condition, yes, no) result(text)
        logical, intent(in) :: condition
        character(*), intent(in) :: yes, no
        character(:), allocatable :: text

        if (condition) then
            text = yes
        else
            text = no
        end if
    end function merge_text

    !> "lbf*in", or nothing where the deck names no units.
    pure function product_unit(first, second) result(text)
        character(*), intent(in) :: first, second
        character(:), allocatable :: text

        text = ''
        if (len(first) > 0 .and. len(second) > 0) text = first // '*' // second
    end function product_unit

    !> Unit of a field's time derivative of the given order: "in/s^2".
    pure function derived_unit(units, length_power, order) result(text)
        type(units_t), intent(in) :: units
        integer, intent(in) :: length_power, order
        character(:), allocatable :: text

        text = ''
        if (len(units%length) == 0 .or. (order > 0 .and. len(units%time) == 0)) return
        select case (length_power)
        case (1)
            text = units%length
        case (-1)
            text = '1/' // units%length
        case default
            text = '1'
        end select
        if (order >= 1) text = text // '/' // units%time
        if (order == 2) text = text // '^2'
    end function derived_unit

    !> Units of the five fields of u, v or a (set = 1, 2, 3).
    pure function field_units(units, set) result(text)
        type(units_t), intent(in) :: units
        integer, intent(in) :: set
        character(:), allocatable :: text
        integer :: i

        text = derived_unit(units, field_length_power(1), set - 1)
        if (len(text) == 0) return
        do i = 2, n_fields
            text = text // ', ' // derived_unit(units, field_length_power(i), set - 1)
        end do
    end function field_units

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
        if (.not. allocated(error)) call self%all_time%append([step%abscissa], error)
        do i = 1, size(self%probes)
            if (.not. allocated(error)) call self%probes(i)%append([probe_values(i)], error)
        end do
        do i = 1, n_energies
            if (.not. allocated(error)) call self%energies(i)%append([energies(i)], error)
        end do
        do i = 1, n_solver
            if (.not. allocated(error)) call self%solver(i)%append([solver(i)], error)
        end do
        if (.not. allocated(error)) call flush_in_time(self, error)
        if (allocated(error)) call self%fail(error)
    end subroutine write_step

    subroutine write_row(self, abscissa, state, error)
        class(results_t), intent(inout) :: self
        real(wp), intent(in) :: abscissa
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error

        call self%time%append([abscissa], error)
        if (self%has_fields(1) .and. .not. allocated(error)) call self%fields(1)%append(state%u, error)
        if (self%has_fields(2) .and. .not. allocated(error)) call self%fields(2)%append(state%v, error)
        if (self%has_fields(3) .and. .not. allocated(error)) call self%fields(3)%append(state%a, error)
        if (.not. allocated(error)) call self%recovered%append(self%gauge, state%u, error)
        if (.not. allocated(error)) call self%paraview%append(self%gauge, abscissa, state%u, error)
    end subroutine write_row

    !> Now and then everything gathered goes to the file, so that a long run can be looked at while it goes
    !> on.
    subroutine flush_in_time(self, error)
        class(results_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error
        integer(i8) :: count, rate

        call system_clock(count, rate)
        if (real(count - self%last_flush, wp) < flush_seconds*real(rate, wp)) return
        self%last_flush = count
        call for_every_series(self, .false., error)
        if (.not. allocated(error)) call self%paraview%flush(error)
        if (.not. allocated(error)) call flush_file(self%file, error)
    end subroutine flush_in_time

    !> Flush, or (closing) flush and close, every series of the running command.
    subroutine for_every_series(self, closing, error)
        class(results_t), intent(inout) :: self
        logical, intent(in) :: closing
        type(error_t), allocatable, intent(out) :: error
        integer :: i

        call one(self%time)
        do i = 1, 3
            call one(self%fields(i))
        end do
        do i = 1, size(self%recovered%series)
            call one(self%recovered%series(i))
        end do
        call one(self%all_time)
        do i = 1, size(self%probes)
            call one(self%probes(i))
        end do
        do i = 1, n_energies
            call one(self%energies(i))
        end do
        do i = 1, n_solver
            call one(self%solver(i))
        end do

    contains

        subroutine one(series)
            type(series_t), intent(inout) :: series

            ! A set of fields that is not asked for has no series.
            if (allocated(error) .or. series%dataset < 0) return
            if (closing) then
                call series%close(error)
            else
                call series%flush(error)
            end if
        end subroutine one

    end subroutine for_every_series

    !> Natural frequencies [cycles/T] and modes (5, nn, nm) of the running MODAL command.
    subroutine write_modes(self, frequency, modes, error)
        class(results_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:)
        real(wp), intent(in) :: modes(:, :)         !! (5 nn, nm)
        type(error_t), allocatable, intent(out) :: error
        real(wp), allocatable :: shaped(:, :, :)
        character(:), allocatable :: unit

        unit = ''
        if (len(self%units%time) > 0) unit = '1/' // self%units%time
        shaped = reshape(modes, [n_fields, self%nodes, size(frequency)])
        call put_array(self%group, 'frequency', frequency, unit, &
                       'natural frequencies, cycles a unit of time; negative for a mode that grows', error)
        if (.not. allocated(error)) call put_array(self%group, 'modes', shaped, field_units(self%units, 1), &
            'fields u1 u3 y1 y3 xi of every mode, largest displacement 1', error)
        if (allocated(error)) call self%fail(error)
    end subroutine write_modes

    !> How many faces of the command's rows lay beyond the material's limits, so that another point's stress
    !> stands in for theirs.
    pure integer function faces_beyond(self)
        class(results_t), intent(in) :: self

        faces_beyond = self%recovered%beyond
    end function faces_beyond

    !> Close the running command's group.
    subroutine end_task(self, error)
        class(results_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (self%has_unwritten) call write_row(self, self%unwritten_abscissa, self%unwritten, error)
        self%has_unwritten = .false.
        if (.not. allocated(error)) call for_every_series(self, .true., error)
        if (.not. allocated(error)) call close_group(self%group)
        if (.not. allocated(error)) call self%paraview%flush(error)
        if (.not. allocated(error)) call flush_file(self%file, error)
        if (allocated(error)) call self%fail(error)
    end subroutine end_task

    !> Write how the run ended, and close.
    subroutine close_results(self, status, message, wall_seconds, cpu_seconds, error)
        class(results_t), intent(inout) :: self
        character(*), intent(in) :: status          !! complete, failed or interrupted
        character(*), intent(in) :: message
        real(wp), intent(in) :: wall_seconds, cpu_seconds
        type(error_t), allocatable, intent(out) :: error

        if (.not. self%is_open) return
        call self%paraview%close(error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'status', status, error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'message', message, error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'wall_seconds', wall_seconds, &
            error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'cpu_seconds', cpu_seconds, &
            error)
        if (.not. allocated(error)) call close_file(self%file, error)
        self%is_open = .false.
        if (allocated(error)) call self%fail(error)
    end subroutine close_results

end module gb_results
