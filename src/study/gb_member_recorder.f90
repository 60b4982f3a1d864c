!> Gathers in memory what the methods tell about one member of a study.
module gb_member_recorder
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_interrupted
    use gb_member, only: command_record_t, extremes_t, n_energies, n_solver
    use gb_problem, only: problem_t, task_t, task_modal
    use gb_recorder, only: recorder_t, step_record_t
    use gb_sensor, only: sensor_t, place_sensor
    use gb_state, only: state_t
    use gb_signals, only: has_caught_signal
    implicit none
    private

    type, extends(recorder_t), public :: member_recorder_t
        logical :: has_histories = .true.           !! false: only extremes and frequencies are kept
        logical :: has_fields(3) = .false.          !! u, v, a
        integer :: every = 1
        type(sensor_t), allocatable :: sensors(:)
        type(extremes_t), allocatable :: extremes(:)
        type(command_record_t), allocatable :: commands(:)
        integer :: n = 0                            !! commands begun
        integer :: grid_steps = 0                   !! whole steps of the running command
        real(wp) :: start_energy = 0.0_wp           !! of the running command [F L]
        logical :: has_unwritten = .false.          !! the latest state was left out by OUTPUT every=
        real(wp) :: unwritten_abscissa = 0.0_wp
        type(state_t) :: unwritten                  !! it is kept if it turns out to be the last
    contains
        procedure :: open => open_recorder
        procedure :: begin_task
        procedure :: record_step
        procedure :: record_modes
        procedure :: end_task
        procedure :: note
    end type member_recorder_t

    integer, parameter :: first_rows = 64           !! room to begin with; it doubles

contains

    subroutine open_recorder(self, problem)
        class(member_recorder_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        integer :: i

        associate (output => problem%output)
            self%has_fields = [output%u, output%v, output%a]
            self%every = output%every
        end associate
        self%has_histories = any(self%has_fields)
        allocate (self%sensors(size(problem%probes)))
        do i = 1, size(problem%probes)
            self%sensors(i) = place_sensor(problem%model%mesh, problem%probes(i))
        end do
        allocate (self%extremes(size(problem%probes)), self%commands(size(problem%tasks)))
    end subroutine open_recorder

    subroutine begin_task(self, task, error)
        class(member_recorder_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        self%n = self%n + 1
        self%grid_steps = 0
        self%has_unwritten = .false.
        if (task%kind /= task_modal) self%extremes = extremes_t()
    end subroutine begin_task

    subroutine record_step(self, step, state, error)
        class(member_recorder_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: values(size(self%sensors))
        integer :: i

        if (has_caught_signal()) then
            call raise(error, status_interrupted, 'stopped')
            return
        end if
        do i = 1, size(values)
            values(i) = self%sensors(i)%reading(state)
            call self%extremes(i)%widen(values(i), step%abscissa)
        end do
        if (.not. self%has_histories) return
        if (step%on_grid .and. step%number > 0) self%grid_steps = self%grid_steps + 1
        if (self%every == 1 .or. (step%on_grid .and. modulo(self%grid_steps, self%every) == 0)) then
            self%has_unwritten = .false.
            call add_row(self%commands(self%n), self%has_fields, step%abscissa, state)
        else
            self%has_unwritten = .true.
            self%unwritten_abscissa = step%abscissa
            self%unwritten = state
        end if
        if (step%number == 0) self%start_energy = step%kinetic + step%strain
        call add_step(self%commands(self%n), step, values, self%start_energy)
    end subroutine record_step

    !> Keep the fields of a state.
    subroutine add_row(record, has_fields, abscissa, state)
        type(command_record_t), intent(inout) :: record
        logical, intent(in) :: has_fields(3)
        real(wp), intent(in) :: abscissa            !! time [T] or load factor [-]
        type(state_t), intent(in) :: state
        integer :: room

        if (.not. allocated(record%row_abscissa)) then
            allocate (record%row_abscissa(first_rows))
            if (has_fields(1)) allocate (record%u(size(state%u), first_rows))
            if (has_fields(2)) allocate (record%v(size(state%v), first_rows))
            if (has_fields(3)) allocate (record%a(size(state%a), first_rows))
        else if (record%rows == size(record%row_abscissa)) then
            room = 2*record%rows
            call grow_list(record%row_abscissa, room)
            if (has_fields(1)) call grow_columns(record%u, room)
            if (has_fields(2)) call grow_columns(record%v, room)
            if (has_fields(3)) call grow_columns(record%a, room)
        end if
        record%rows = record%rows + 1
        record%row_abscissa(record%rows) = abscissa
        if (has_fields(1)) record%u(:, record%rows) = state%u
        if (has_fields(2)) record%v(:, record%rows) = state%v
        if (has_fields(3)) record%a(:, record%rows) = state%a
    end subroutine add_row

    !> Keep the numbers of a step.
    subroutine add_step(record, step, values, start_energy)
        type(command_record_t), intent(inout) :: record
        type(step_record_t), intent(in) :: step
        real(wp), intent(in) :: values(:)           !! of the probes
        real(wp), intent(in) :: start_energy        !! [F L]
        integer :: room

        if (.not. allocated(record%abscissa)) then
            allocate (record%abscissa(first_rows), record%probes(first_rows, size(values)))
            allocate (record%energies(first_rows, n_energies), record%solver(first_rows, n_solver))
        else if (record%steps == size(record%abscissa)) then
            room = 2*record%steps
            call grow_list(record%abscissa, room)
            call grow_rows(record%probes, room)
            call grow_rows(record%energies, room)
            call grow_rows(record%solver, room)
        end if
        record%steps = record%steps + 1
        associate (i => record%steps)
            record%abscissa(i) = step%abscissa
            record%probes(i, :) = values
            record%energies(i, :4) = [step%kinetic, step%strain, step%external, step%dissipated]
            record%energies(i, 5) = step%kinetic + step%strain - step%external + step%dissipated &
                - start_energy
            record%solver(i, :) = [real(step%iterations, wp), real(step%cuts, wp), step%step, step%residual]
        end associate
    end subroutine add_step

    pure subroutine grow_list(list, room)
        real(wp), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: room
        real(wp), allocatable :: grown(:)

        allocate (grown(room))
        grown(:size(list)) = list
        call move_alloc(grown, list)
    end subroutine grow_list

    !> Room for more columns, as fields have.
    pure subroutine grow_columns(table, room)
        real(wp), allocatable, intent(inout) :: table(:, :)
        integer, intent(in) :: room
        real(wp), allocatable :: grown(:, :)

        allocate (grown(size(table, 1), room))
        grown(:, :size(table, 2)) = table
        call move_alloc(grown, table)
    end subroutine grow_columns

    !> Room for more rows, as series have.
    pure subroutine grow_rows(table, room)
        real(wp), allocatable, intent(inout) :: table(:, :)
        integer, intent(in) :: room
        real(wp), allocatable :: grown(:, :)

        allocate (grown(room, size(table, 2)))
        grown(:size(table, 1), :) = table
        call move_alloc(grown, table)
    end subroutine grow_rows

    subroutine record_modes(self, frequency, modes, error)
        class(member_recorder_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:), modes(:, :)
        type(error_t), allocatable, intent(out) :: error

        self%commands(self%n)%frequency = frequency
        if (self%has_histories) self%commands(self%n)%modes = modes
    end subroutine record_modes

    subroutine end_task(self, failure, error)
        class(member_recorder_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: failure
        type(error_t), allocatable, intent(out) :: error

        if (self%has_unwritten) call add_row(self%commands(self%n), self%has_fields, &
            self%unwritten_abscissa, self%unwritten)
        self%has_unwritten = .false.
    end subroutine end_task

    !> Remarks about single members would fill the log; they are not kept.
    subroutine note(self, text)
        class(member_recorder_t), intent(inout) :: self
        character(*), intent(in) :: text
    end subroutine note

end module gb_member_recorder
