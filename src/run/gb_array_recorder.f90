!> Keeps results in memory, as arrays under the names they have in the results file ("transient/u"), for
!> programs that call the library. What is kept follows OUTPUT, as in the file.
module gb_array_recorder
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_fields, only: n_fields
    use gb_gauge, only: gauge_t
    use gb_problem, only: problem_t, task_t, output_t, task_modal
    use gb_recorder, only: recorder_t, step_record_t
    use gb_sensor, only: sensor_t, place_sensor
    use gb_state, only: state_t
    use gb_text, only: newline
    implicit none
    private

    integer, parameter, public :: max_rank = 4

    !> The series of a command, in the order of series_names.
    integer, parameter :: in_time = 1, in_u = 2, in_v = 3, in_a = 4, in_strain = 5, in_i1 = 6, in_j = 7, &
        in_axial = 8, in_shear = 9, in_moment = 10, in_s = 11, in_cauchy = 12, in_all_time = 13, &
        in_energy = 14, &
        in_solver = 19, n_series = 22
    character(18), parameter :: series_names(n_series) = [character(18) :: 'time', 'u', 'v', 'a', &
        'strain/E', &
        'strain/I1-2', 'strain/J', 'stress/axial', 'stress/shear', 'stress/moment', 'stress/S', &
        'stress/cauchy', &
        'probes/time', 'energy/kinetic', 'energy/strain', 'energy/external', 'energy/dissipated', &
        'energy/balance', 'solver/iterations', 'solver/cuts', 'solver/step', 'solver/residual']

    !> Numbers of the given shape, the first dimension slowest, as C and h5py see it.
    type, public :: array_t
        character(:), allocatable :: name
        integer :: rank = 1
        integer :: shape(max_rank) = 0
        real(wp), allocatable :: values(:)              !! with room behind for more rows
    end type array_t

    type, extends(recorder_t), public :: array_recorder_t
        type(array_t), allocatable :: arrays(:)
        integer :: count = 0
        character(:), allocatable :: notes              !! lines that the solution methods had for the log
        type(output_t), private :: output
        class(gauge_t), allocatable, private :: gauge
        type(sensor_t), allocatable, private :: sensors(:)
        character(64), allocatable, private :: probes(:)
        integer, private :: nodes = 0
        character(:), allocatable, private :: command   !! name of the running one
        integer, private :: at(n_series) = 0            !! arrays of the running command's series, 0 for none
        integer, allocatable, private :: at_probes(:)
        integer, private :: grid_steps = 0
        real(wp), private :: start_energy = 0.0_wp
        logical, private :: has_unwritten = .false.     !! the latest state was left out by OUTPUT every=
        real(wp), private :: unwritten_abscissa = 0.0_wp
        type(state_t), private :: unwritten
    contains
        procedure :: open => open_recorder
        procedure :: find
        procedure :: begin_task
        procedure :: record_step
        procedure :: record_modes
        procedure :: end_task
        procedure :: note
    end type array_recorder_t

contains

    subroutine open_recorder(self, problem, gauge)
        class(array_recorder_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        class(gauge_t), intent(in) :: gauge
        integer :: i

        allocate (self%arrays(32))
        self%notes = ''
        self%output = problem%output
        allocate (self%gauge, source=gauge)
        self%nodes = problem%model%mesh%n_nodes()
        self%sensors = [(place_sensor(problem%model%mesh, problem%probes(i)), i=1, size(problem%probes))]
        allocate (self%probes(size(problem%probes)))
        do i = 1, size(self%probes)
            self%probes(i) = problem%probes(i)%name
        end do
        call put(self, 'mesh/x', problem%model%mesh%x)
        if (self%output%strain .or. self%output%stress) then
            call put(self, 'mesh/stations/x', gauge%x)
            call put(self, 'mesh/stations/x3', reshape(gauge%x3, [size(gauge%x3)]), [gauge%heights])
        end if
    end subroutine open_recorder

    !> Number of the array of that name, 0 if there is none.
    pure integer function find(self, name)
        class(array_recorder_t), intent(in) :: self
        character(*), intent(in) :: name

        do find = self%count, 1, -1
            if (self%arrays(find)%name == name) return
        end do
    end function find

    !> A new array: rows of the given shape (Fortran's order), none for single numbers.
    subroutine add(self, name, row_shape)
        class(array_recorder_t), intent(inout) :: self
        character(*), intent(in) :: name
        integer, intent(in) :: row_shape(:)
        type(array_t), allocatable :: grown(:)
        integer :: i

        if (self%count == size(self%arrays)) then
            allocate (grown(2*self%count))
            do i = 1, self%count
                grown(i)%name = self%arrays(i)%name
                grown(i)%rank = self%arrays(i)%rank
                grown(i)%shape = self%arrays(i)%shape
                call move_alloc(self%arrays(i)%values, grown(i)%values)
            end do
            call move_alloc(grown, self%arrays)
        end if
        self%count = self%count + 1
        associate (array => self%arrays(self%count))
            array%name = name
            array%rank = 1 + size(row_shape)
            array%shape = 0
            array%shape(2:array%rank) = row_shape(size(row_shape):1:-1)
            allocate (array%values(0))
        end associate
    end subroutine add

    !> One more row of an array.
    subroutine append(self, number, row)
        class(array_recorder_t), intent(inout) :: self
        integer, intent(in) :: number
        real(wp), intent(in) :: row(:)
        real(wp), allocatable :: grown(:)
        integer :: first

        associate (array => self%arrays(number))
            first = array%shape(1)*size(row)
            if (first + size(row) > size(array%values)) then
                allocate (grown(max(2*size(array%values), 64*size(row))))
                grown(:first) = array%values(:first)
                call move_alloc(grown, array%values)
            end if
            array%values(first + 1:first + size(row)) = row
            array%shape(1) = array%shape(1) + 1
        end associate
    end subroutine append

    !> A whole array at once.
    subroutine put(self, name, values, row_shape)
        class(array_recorder_t), intent(inout) :: self
        character(*), intent(in) :: name
        real(wp), intent(in) :: values(:)
        integer, intent(in), optional :: row_shape(:)
        integer, parameter :: none(0) = [integer ::]

        if (present(row_shape)) then
            call add(self, name, row_shape)
            self%arrays(self%count)%shape(1) = size(values)/product(row_shape)
        else
            call add(self, name, none)
            self%arrays(self%count)%shape(1) = size(values)
        end if
        self%arrays(self%count)%values = values
    end subroutine put

    subroutine begin_task(self, task, error)
        class(array_recorder_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error
        integer, parameter :: single(0) = [integer ::]
        integer :: i

        self%command = task%name
        self%grid_steps = 0
        self%at = 0
        if (task%kind == task_modal) return
        call open_series(in_time, single)
        if (self%output%u) call open_series(in_u, [n_fields, self%nodes])
        if (self%output%v) call open_series(in_v, [n_fields, self%nodes])
        if (self%output%a) call open_series(in_a, [n_fields, self%nodes])
        associate (nz => self%gauge%heights, ns => self%gauge%stations)
            if (self%output%strain) then
                call open_series(in_strain, [3, nz, ns])
                call open_series(in_i1, [nz, ns])
                call open_series(in_j, [nz, ns])
            end if
            if (self%output%stress) then
                do i = in_axial, in_moment
                    call open_series(i, [ns])
                end do
                call open_series(in_s, [3, nz, ns])
                call open_series(in_cauchy, [3, nz, ns])
            end if
        end associate
        do i = in_all_time, n_series
            call open_series(i, single)
        end do
        self%at_probes = [(self%count + i, i=1, size(self%probes))]
        do i = 1, size(self%probes)
            call add(self, task%name // '/probes/' // trim(self%probes(i)), single)
        end do

    contains

        subroutine open_series(which, row_shape)
            integer, intent(in) :: which, row_shape(:)

            call add(self, task%name // '/' // trim(series_names(which)), row_shape)
            self%at(which) = self%count
        end subroutine open_series

    end subroutine begin_task

    subroutine record_step(self, step, state, error)
        class(array_recorder_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: balance, solver(4)
        integer :: i

        if (step%number == 0) self%start_energy = step%kinetic + step%strain
        balance = step%kinetic + step%strain - step%external + step%dissipated - self%start_energy
        if (step%on_grid .and. step%number > 0) self%grid_steps = self%grid_steps + 1
        self%has_unwritten = .not. (self%output%every == 1 .or. (step%on_grid .and. &
            modulo(self%grid_steps, self%output%every) == 0))
        if (self%has_unwritten) then
            self%unwritten_abscissa = step%abscissa
            self%unwritten = state
        else
            call keep_row(self, step%abscissa, state)
        end if
        call append(self, self%at(in_all_time), [step%abscissa])
        do i = 1, size(self%sensors)
            call append(self, self%at_probes(i), [self%sensors(i)%reading(state)])
        end do
        associate (energies => [step%kinetic, step%strain, step%external, step%dissipated, balance])
            do i = 1, size(energies)
                call append(self, self%at(in_energy + i - 1), energies(i:i))
            end do
        end associate
        solver = [real(step%iterations, wp), real(step%cuts, wp), step%step, step%residual]
        do i = 1, size(solver)
            call append(self, self%at(in_solver + i - 1), solver(i:i))
        end do
    end subroutine record_step

    subroutine keep_row(self, abscissa, state)
        class(array_recorder_t), intent(inout) :: self
        real(wp), intent(in) :: abscissa
        type(state_t), intent(in) :: state
        real(wp), allocatable :: tensor(:), other(:), first(:), second(:), third(:)
        integer :: beyond

        call append(self, self%at(in_time), [abscissa])
        if (self%output%u) call append(self, self%at(in_u), state%u)
        if (self%output%v) call append(self, self%at(in_v), state%v)
        if (self%output%a) call append(self, self%at(in_a), state%a)
        associate (nz => self%gauge%heights, ns => self%gauge%stations)
            allocate (tensor(3*nz*ns), other(3*nz*ns))
            if (self%output%strain) then
                allocate (first(nz*ns), second(nz*ns))
                call self%gauge%read_strains(state%u, tensor, first, second)
                call append(self, self%at(in_strain), tensor)
                call append(self, self%at(in_i1), first)
                call append(self, self%at(in_j), second)
                deallocate (first, second)
            end if
            if (.not. self%output%stress) return
            allocate (first(ns), second(ns), third(ns))
            call self%gauge%read_resultants(state%u, first, second, third)
            call append(self, self%at(in_axial), first)
            call append(self, self%at(in_shear), second)
            call append(self, self%at(in_moment), third)
            call self%gauge%read_stresses(state%u, tensor, other, beyond)
            call append(self, self%at(in_s), tensor)
            call append(self, self%at(in_cauchy), other)
        end associate
    end subroutine keep_row

    subroutine record_modes(self, frequency, modes, error)
        class(array_recorder_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:)
        real(wp), intent(in) :: modes(:, :)
        type(error_t), allocatable, intent(out) :: error

        call put(self, self%command // '/frequency', frequency)
        call put(self, self%command // '/modes', reshape(modes, [size(modes)]), [n_fields, self%nodes])
    end subroutine record_modes

    subroutine end_task(self, failure, error)
        class(array_recorder_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: failure
        type(error_t), allocatable, intent(out) :: error

        if (self%has_unwritten) call keep_row(self, self%unwritten_abscissa, self%unwritten)
        self%has_unwritten = .false.
    end subroutine end_task

    subroutine note(self, text)
        class(array_recorder_t), intent(inout) :: self
        character(*), intent(in) :: text

        self%notes = self%notes // text // newline
    end subroutine note

end module gb_array_recorder
