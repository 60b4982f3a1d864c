!> What the fuzzer calls: the deck reader on a text, as the program calls it, and the words that a deck knows.
module fuzz_target
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
    use gb_commands, only: command_table
    use gb_deck, only: read_deck, source_from_text, source_t, override_t, diagnostics_t
    use gb_kinds, only: wp
    use gb_problem, only: problem_t
    use gb_program, only: function_names
    use gb_schema, only: schema_t
    use gb_text, only: newline
    implicit none
    private

    public :: fuzz_deck, fuzz_words

    !> A comment of this form at the start of a deck stands for --set on the command line.
    character(*), parameter :: set_mark = '#set '

contains

    !> Read the text as a deck. 1 where it is accepted, 0 where it is refused; a refusal that says nothing, or
    !> a deck accepted that is not whole, is -1.
    function fuzz_deck(bytes, count) bind(c, name="fuzz_deck") result(outcome)
        integer(c_size_t), value, intent(in) :: count
        character(kind=c_char), intent(in) :: bytes(count)
        integer(c_int) :: outcome
        type(source_t) :: source
        type(problem_t) :: problem
        type(diagnostics_t) :: diagnostics
        type(override_t), allocatable :: overrides(:)
        character(:), allocatable :: text, report
        integer :: i

        allocate (character(count) :: text)
        do i = 1, int(count)
            text(i:i) = bytes(i)
        end do
        source = source_from_text('fuzz.inp', text)
        call take_overrides(source%text, overrides)
        call read_deck(source, overrides, problem, diagnostics)
        outcome = 1
        if (diagnostics%count() > 0) then
            report = diagnostics%render(source%name, source%text)
            outcome = merge(0, -1, index(report, ': error: ') > 0)
        else if (.not. is_whole(problem)) then
            outcome = -1
        end if
    end function fuzz_deck

    subroutine take_overrides(text, overrides)
        character(*), intent(in) :: text
        type(override_t), allocatable, intent(out) :: overrides(:)
        type(override_t) :: override
        integer :: first, last, equals

        allocate (overrides(0))
        first = 1
        do while (first + len(set_mark) < len(text))
            if (text(first:first + len(set_mark) - 1) /= set_mark) return
            last = index(text(first:), newline) + first - 2
            if (last < first) return
            equals = index(text(first:last), '=') + first - 1
            if (equals < first + len(set_mark) .or. equals >= last) return
            override%name = trim(adjustl(text(first + len(set_mark):equals - 1)))
            override%text = text(equals + 1:last)
            overrides = [overrides, override]
            first = last + 2
        end do
    end subroutine take_overrides

    !> What the solver takes for granted of an accepted deck.
    logical function is_whole(problem)
        type(problem_t), intent(in) :: problem
        integer :: i

        associate (model => problem%model, mesh => problem%model%mesh)
            is_whole = size(problem%tasks) > 0 .and. mesh%n_elements() > 0
            if (.not. is_whole) return
            is_whole = all(mesh%x(2:) > mesh%x(:size(mesh%x) - 1)) &
                .and. all(mesh%section >= 1 .and. mesh%section <= size(model%sections)) &
                .and. all(mesh%material >= 1 .and. mesh%material <= size(model%materials))
            do i = 1, size(model%histories)
                call try_history(i, problem, is_whole)
            end do
            do i = 1, size(problem%tasks)
                is_whole = is_whole .and. len(problem%tasks(i)%name) > 0
            end do
        end associate
    end function is_whole

    !> A history has a value, or says that it has none, at all times.
    subroutine try_history(i, problem, is_whole)
        integer, intent(in) :: i
        type(problem_t), intent(in) :: problem
        logical, intent(inout) :: is_whole
        real(wp), parameter :: times(5) = [0.0_wp, 1.0e-9_wp, 1.0_wp, 3.7e5_wp, 1.0e12_wp]
        real(wp) :: factor
        logical :: defined
        integer :: k

        do k = 1, size(times)
            call problem%model%histories(i)%evaluate(times(k), k == 2, factor, defined)
            if (defined) is_whole = is_whole .and. abs(factor) <= huge(factor)
        end do
    end subroutine try_history

    !> All words of the deck, one a line; the number of bytes.
    function fuzz_words(bytes, size_of_bytes) bind(c, name="fuzz_words") result(n)
        integer(c_size_t), value, intent(in) :: size_of_bytes
        character(kind=c_char), intent(out) :: bytes(size_of_bytes)
        integer(c_size_t) :: n
        type(schema_t) :: table
        integer :: i

        n = 0
        table = command_table()
        do i = 1, table%n_forms
            call add(trim(table%forms(i)%command))
            call add(trim(table%forms(i)%variant))
            call add_each(table%forms(i)%words)
        end do
        do i = 1, table%n_keys
            call add(trim(table%keys(i)%name) // '=')
            call add_each(table%keys(i)%choices)
        end do
        do i = 1, size(function_names)
            call add(trim(function_names(i)) // '(')
        end do

    contains

        subroutine add(word)
            character(*), intent(in) :: word
            integer :: k

            if (len(word) == 0 .or. n + len(word) + 1 > size_of_bytes) return
            do k = 1, len(word)
                bytes(n + k) = word(k:k)
            end do
            bytes(n + len(word) + 1) = newline
            n = n + len(word) + 1
        end subroutine add

        subroutine add_each(words)
            character(*), intent(in) :: words
            integer :: first, last

            first = 1
            do while (first <= len_trim(words))
                last = scan(words(first:) // ' ', ' ') + first - 2
                call add(words(first:last))
                first = last + 2
            end do
        end subroutine add_each

    end function fuzz_words

end module fuzz_target
