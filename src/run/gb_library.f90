!> The library as C sees it (include/gentbeam.h): run a deck, read the arrays it leaves in memory. No file is
!> written, nothing is printed. A result lives until gentbeam_free; what is handed out points into it.
module gb_library
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_int, c_loc, c_null_char, &
        c_null_ptr, &
        c_ptr, c_size_t
    use gb_error, only: error_t, status_ok, status_input
    use gb_deck, only: override_t, read_deck, read_source, source_from_text, source_t, diagnostics_t
    use gb_kinds, only: wp
    use gb_external, only: external_t, build_external
    use gb_initial, only: initial_state
    use gb_array_recorder, only: array_recorder_t
    use gb_problem, only: problem_t, task_static, task_modal
    use gb_recovery, only: build_recovery
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_memory, only: memory_t
    use gb_log, only: log_t, log_quiet
    use gb_make_choices, only: make_choices
    use gb_task, only: run_task
    use gb_threads, only: use_one_blas_thread
    use gb_version, only: program_version
    implicit none
    private

    !> A text that C may hold on to.
    type :: c_text_t
        character(kind=c_char), allocatable :: characters(:)
    end type c_text_t

    type :: result_t
        integer :: status = status_ok
        type(c_text_t) :: message
        type(array_recorder_t) :: kept
        type(c_text_t), allocatable :: names(:)     !! of the arrays
        type(c_text_t), allocatable :: keys(:), words(:)    !! texts about the run, by key
    end type result_t

    character(kind=c_char), target, save :: version_text(len(program_version) + 1) = &
        transfer(program_version // c_null_char, [c_null_char])

contains

    function gentbeam_version() bind(c, name="gentbeam_version") result(text)
        type(c_ptr) :: text

        text = c_loc(version_text)
    end function gentbeam_version

    function gentbeam_run_file(path, n_set, set) bind(c, name="gentbeam_run_file") result(handle)
        character(kind=c_char), intent(in) :: path(*)
        integer(c_int), value, intent(in) :: n_set
        type(c_ptr), intent(in) :: set(*)
        type(c_ptr) :: handle
        type(result_t), pointer :: result
        type(source_t) :: source
        type(override_t), allocatable :: overrides(:)
        type(error_t), allocatable :: error

        allocate (result)
        call read_source(fortran_text(path), source, error)
        call read_overrides(n_set, set, overrides)
        call run_source(source, overrides, error, result)
        handle = c_loc(result)
    end function gentbeam_run_file

    function gentbeam_run_text(text, n_set, set) bind(c, name="gentbeam_run_text") result(handle)
        character(kind=c_char), intent(in) :: text(*)
        integer(c_int), value, intent(in) :: n_set
        type(c_ptr), intent(in) :: set(*)
        type(c_ptr) :: handle
        type(result_t), pointer :: result
        type(override_t), allocatable :: overrides(:)
        type(error_t), allocatable :: error

        allocate (result)
        call read_overrides(n_set, set, overrides)
        call run_source(source_from_text('<text>', fortran_text(text)), overrides, error, result)
        handle = c_loc(result)
    end function gentbeam_run_text

    !> Read the deck and run its commands; what went wrong becomes status and message.
    subroutine run_source(source, overrides, error, result)
        type(source_t), intent(in) :: source
        type(override_t), intent(in) :: overrides(:)
        type(error_t), allocatable, intent(inout) :: error
        type(result_t), intent(inout), target :: result
        type(diagnostics_t) :: diagnostics
        type(problem_t) :: problem
        type(system_t) :: system
        type(external_t) :: external
        type(state_t) :: state
        type(memory_t) :: memory
        type(log_t) :: log
        logical :: has_velocities
        integer :: i

        result%message = c_text('')
        allocate (result%names(0), result%keys(0), result%words(0))
        if (.not. allocated(error)) then
            call read_deck(source, overrides, problem, diagnostics)
            if (diagnostics%count() > 0) then
                result%status = status_input
                result%message = c_text(diagnostics%render(source%name, source%text))
                return
            end if
            if (problem%sweep%members() > 0) then
                result%status = status_input
                result%message &
                    = c_text('the library runs one beam at a time: give parameters in place of SWEEP')
                return
            end if
            call use_one_blas_thread()
            log%level = log_quiet
            call make_choices(problem, log, 0.0_wp, error)
        end if
        if (.not. allocated(error)) then
            system = build_system(problem%model)
            external = build_external(problem%model)
            call result%kept%open(problem, build_recovery(problem%model, system))
            call describe_run(problem, result)
            call initial_state(problem%model, system, state, error)
            has_velocities = .true.
            do i = 1, size(problem%tasks)
                if (allocated(error)) exit
                call run_task(problem, i, system, external, .false., memory, has_velocities, state, &
                    result%kept, &
                    error)
            end do
        end if
        if (allocated(error)) then
            result%status = error%status
            result%message = c_text(error%message)
        end if
        deallocate (result%names)
        allocate (result%names(result%kept%count))
        do i = 1, result%kept%count
            result%names(i) = c_text(result%kept%arrays(i)%name)
        end do
    end subroutine run_source

    !> Texts by key: title, units, and the commands with their kinds.
    subroutine describe_run(problem, result)
        type(problem_t), intent(in) :: problem
        type(result_t), intent(inout) :: result
        character(:), allocatable :: commands
        integer :: i

        commands = ''
        do i = 1, size(problem%tasks)
            if (i > 1) commands = commands // ' '
            commands = commands // problem%tasks(i)%name
            select case (problem%tasks(i)%kind)
            case (task_static)
                call add_text(result, problem%tasks(i)%name // '/kind', 'static')
            case (task_modal)
                call add_text(result, problem%tasks(i)%name // '/kind', 'modal')
            case default
                call add_text(result, problem%tasks(i)%name // '/kind', 'transient')
                call add_text(result, problem%tasks(i)%name // '/scheme', problem%tasks(i)%scheme)
            end select
        end do
        call add_text(result, 'commands', commands)
        call add_text(result, 'title', problem%model%title)
        call add_text(result, 'units/length', problem%model%units%length)
        call add_text(result, 'units/force', problem%model%units%force)
        call add_text(result, 'units/time', problem%model%units%time)
        call add_text(result, 'parameters', problem%parameters)
    end subroutine describe_run

    subroutine add_text(result, key, word)
        type(result_t), intent(inout) :: result
        character(*), intent(in) :: key, word

        call grow(result%keys)
        call grow(result%words)
        result%keys(size(result%keys)) = c_text(key)
        result%words(size(result%words)) = c_text(word)

    contains

        !> Room for one more. (An array constructor of such texts would leak them.)
        subroutine grow(list)
            type(c_text_t), allocatable, intent(inout) :: list(:)
            type(c_text_t), allocatable :: grown(:)
            integer :: i

            allocate (grown(size(list) + 1))
            do i = 1, size(list)
                call move_alloc(list(i)%characters, grown(i)%characters)
            end do
            call move_alloc(grown, list)
        end subroutine grow
    end subroutine add_text

    integer(c_int) function gentbeam_status(handle) bind(c, name="gentbeam_status") result(status)
        type(c_ptr), value, intent(in) :: handle
        type(result_t), pointer :: result

        call c_f_pointer(handle, result)
        status = int(result%status, c_int)
    end function gentbeam_status

    function gentbeam_message(handle) bind(c, name="gentbeam_message") result(text)
        type(c_ptr), value, intent(in) :: handle
        type(c_ptr) :: text
        type(result_t), pointer :: result

        call c_f_pointer(handle, result)
        text = c_loc(result%message%characters)
    end function gentbeam_message

    !> A text about the run, or NULL.
    function gentbeam_text(handle, key) bind(c, name="gentbeam_text") result(text)
        type(c_ptr), value, intent(in) :: handle
        character(kind=c_char), intent(in) :: key(*)
        type(c_ptr) :: text
        type(result_t), pointer :: result
        character(:), allocatable :: wanted
        integer :: i

        call c_f_pointer(handle, result)
        wanted = fortran_text(key)
        text = c_null_ptr
        do i = 1, size(result%keys)
            if (fortran_text(result%keys(i)%characters) == wanted) text = c_loc(result%words(i)%characters)
        end do
    end function gentbeam_text

    integer(c_int) function gentbeam_count(handle) bind(c, name="gentbeam_count") result(count)
        type(c_ptr), value, intent(in) :: handle
        type(result_t), pointer :: result

        call c_f_pointer(handle, result)
        count = size(result%names)
    end function gentbeam_count

    !> Name of array `number`, counted from 0; NULL beyond the last.
    function gentbeam_name(handle, number) bind(c, name="gentbeam_name") result(text)
        type(c_ptr), value, intent(in) :: handle
        integer(c_int), value, intent(in) :: number
        type(c_ptr) :: text
        type(result_t), pointer :: result

        call c_f_pointer(handle, result)
        text = c_null_ptr
        if (number >= 0 .and. number < size(result%names)) text = c_loc(result%names(number + 1)%characters)
    end function gentbeam_name

    !> The numbers of an array, its rank and shape; NULL where there is no array of that name, or it is empty
    !> (rank and shape tell).
    function gentbeam_array(handle, name, rank, shape) bind(c, name="gentbeam_array") result(values)
        type(c_ptr), value, intent(in) :: handle
        character(kind=c_char), intent(in) :: name(*)
        integer(c_int), intent(out) :: rank
        integer(c_size_t), intent(out) :: shape(4)
        type(c_ptr) :: values
        type(result_t), pointer :: result
        integer :: number

        call c_f_pointer(handle, result)
        rank = 0
        shape = 0
        values = c_null_ptr
        number = result%kept%find(fortran_text(name))
        if (number == 0) return
        rank = result%kept%arrays(number)%rank
        shape = int(result%kept%arrays(number)%shape, c_size_t)
        if (shape(1) > 0) values = c_loc(result%kept%arrays(number)%values)
    end function gentbeam_array

    subroutine gentbeam_free(handle) bind(c, name="gentbeam_free")
        type(c_ptr), value, intent(in) :: handle
        type(result_t), pointer :: result

        call c_f_pointer(handle, result)
        if (associated(result)) deallocate (result)
    end subroutine gentbeam_free

    pure function c_text(text) result(kept)
        character(*), intent(in) :: text
        type(c_text_t) :: kept
        integer :: i

        allocate (kept%characters(len(text) + 1))
        do i = 1, len(text)
            kept%characters(i) = text(i:i)
        end do
        kept%characters(len(text) + 1) = c_null_char
    end function c_text

    pure function fortran_text(characters) result(text)
        character(kind=c_char), intent(in) :: characters(*)
        character(:), allocatable :: text
        integer :: i, n

        n = 0
        do while (characters(n + 1) /= c_null_char)
            n = n + 1
        end do
        allocate (character(n) :: text)
        do i = 1, n
            text(i:i) = characters(i)
        end do
    end function fortran_text

    !> "name=value" texts; one without a value is left for the deck's reader to refuse.
    subroutine read_overrides(n_set, set, overrides)
        integer(c_int), intent(in) :: n_set
        type(c_ptr), intent(in) :: set(*)
        type(override_t), allocatable, intent(out) :: overrides(:)
        character(kind=c_char), pointer :: characters(:)
        character(:), allocatable :: text
        integer, parameter :: longest = 65536
        integer :: i, mark

        allocate (overrides(n_set))
        do i = 1, n_set
            call c_f_pointer(set(i), characters, [longest])
            text = fortran_text(characters)
            mark = index(text // '=', '=')
            overrides(i)%name = trim(adjustl(text(:mark - 1)))
            overrides(i)%text = text(mark + 1:)
        end do
    end subroutine read_overrides

end module gb_library
