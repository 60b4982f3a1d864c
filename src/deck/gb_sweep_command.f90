!> SWEEP: the values that a parameter takes from member to member, from a list or from a table in a file.
module gb_sweep_command
    use gb_diagnostics, only: diagnostics_t, span_t, quoted
    use gb_error, only: error_t
    use gb_expression, only: compile_expression, expression_t, parameters_t
    use gb_kinds, only: wp
    use gb_lexer, only: statement_t, split_list, token_equals, token_list
    use gb_names, only: is_name, max_name
    use gb_parameters, only: override_t
    use gb_parser, only: is_key, is_value
    use gb_source, only: read_text
    use gb_sweep, only: factor_t, sweep_t, most_members
    use gb_text, only: lower_case, newline, to_text
    use gb_values, only: suggestion, report_expression, token_text
    implicit none
    private

    public :: parse_sweep

    character(*), parameter :: form = 'SWEEP takes parameter=[values] or file="table"'

contains

    !> SWEEP parameter=[values], or SWEEP file="table with a header line of parameter names".
    subroutine parse_sweep(text, statement, overrides, parameters, folder, sweep, diagnostics)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(override_t), intent(in) :: overrides(:)
        type(parameters_t), intent(in) :: parameters
        character(*), intent(in) :: folder          !! where the table is looked for; ends with / or is empty
        type(sweep_t), intent(inout) :: sweep
        type(diagnostics_t), intent(inout) :: diagnostics
        type(factor_t) :: factor
        character(:), allocatable :: key
        integer :: before, i

        if (.not. statement%sound) return
        before = diagnostics%count()
        call check_form(text, statement, diagnostics)
        if (diagnostics%count() > before) return
        key = token_text(text, statement%tokens(2))
        associate (value => statement%tokens(4))
            if (lower_case(key) == 'file' .and. value%kind /= token_list) then
                call read_table(token_text(text, value), value%at, folder, factor, diagnostics)
            else if (value%kind /= token_list) then
                call diagnostics%add(value%at, 'SWEEP takes a list of values: ' // key // '=[' // &
                    token_text(text, value) // ' ...]')
            else
                call check_name(key, statement%tokens(2)%at, overrides, parameters, sweep, diagnostics)
                allocate (factor%names(1))
                factor%names(1) = key
                call read_list(text, value%at, parameters, factor, diagnostics)
            end if
            if (diagnostics%count() > before) return
            if (value%kind /= token_list) then
                do i = 1, size(factor%names)
                    call check_name(trim(factor%names(i)), value%at, overrides, parameters, sweep, &
                        diagnostics)
                end do
            end if
        end associate
        if (diagnostics%count() > before) return
        call sweep%add(factor)
        if (sweep%members() > most_members) call diagnostics%add(statement%tokens(1)%at, &
            'the sweep has more than ' // to_text(int(most_members)) // ' members')
    end subroutine parse_sweep

    !> One key and its value, no more.
    subroutine check_form(text, statement, diagnostics)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: i

        if (statement%n == 1) then
            call diagnostics%add(statement%tokens(1)%at, 'SWEEP varies nothing', hint=form)
            return
        end if
        if (.not. is_key(statement, 2)) then
            if (statement%tokens(2)%kind == token_equals) then
                call diagnostics%add(statement%tokens(2)%at, "'=' without a name before it", hint=form)
            else
                call diagnostics%add(statement%tokens(2)%at, 'unexpected ' // quoted(token_text(text, &
                    statement%tokens(2))) // ' in SWEEP', hint=form)
            end if
        else if (.not. is_value(statement, 4)) then
            call diagnostics%add(statement%tokens(2)%at, 'a value is missing after ' // &
                quoted(token_text(text, statement%tokens(2)) // '='))
        else if (statement%n > 4) then
            i = 5
            if (is_key(statement, i)) then
                call diagnostics%add(statement%tokens(i)%at, 'a SWEEP varies one parameter, or those of a ' &
                    // 'table', hint='write a SWEEP for each parameter to combine all their values, or a ' &
                    // 'table (file=) to vary them together')
            else
                call diagnostics%add(statement%tokens(i)%at, 'unexpected ' // quoted(token_text(text, &
                    statement%tokens(i))) // ' in SWEEP', hint=form)
            end if
        end if
    end subroutine check_form

    subroutine read_list(text, at, parameters, factor, diagnostics)
        character(*), intent(in) :: text
        type(span_t), intent(in) :: at
        type(parameters_t), intent(in) :: parameters
        type(factor_t), intent(inout) :: factor
        type(diagnostics_t), intent(inout) :: diagnostics
        type(span_t), allocatable :: parts(:)
        type(expression_t) :: expression
        integer :: i

        call split_list(text, at, parts)
        if (size(parts) == 0) call diagnostics%add(at, 'the list is empty')
        allocate (factor%values(1, size(parts)))
        do i = 1, size(parts)
            call compile_expression(text, parts(i), parameters, ' ', expression)
            call report_expression(expression, parameters, diagnostics)
            if (.not. expression%sound) return
            factor%values(1, i) = expression%value
        end do
    end subroutine read_list

    !> A parameter that is varied is one of the deck's, and nothing else gives it a value.
    subroutine check_name(name, at, overrides, parameters, sweep, diagnostics)
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        type(override_t), intent(in) :: overrides(:)
        type(parameters_t), intent(in) :: parameters
        type(sweep_t), intent(in) :: sweep
        type(diagnostics_t), intent(inout) :: diagnostics
        character(max_name), allocatable :: others(:)
        integer :: i

        if (parameters%names%find(name) == 0) then
            if (parameters%later%find(name) > 0) then
                call diagnostics%add(at, 'parameter ' // quoted(name) // ' is defined only further down', &
                    hint='SWEEP stands below the PARAMETER it varies')
            else
                call diagnostics%add(at, 'the deck has no parameter ' // quoted(name), &
                    hint=suggestion(name, parameters%names%known(), diagnostics))
            end if
            return
        end if
        others = sweep%names()
        do i = 1, size(others)
            if (lower_case(others(i)) /= lower_case(name)) cycle
            call diagnostics%add(at, 'parameter ' // quoted(name) // ' is varied by an earlier SWEEP')
            return
        end do
        do i = 1, size(overrides)
            if (lower_case(overrides(i)%name) /= lower_case(name)) cycle
            call diagnostics%add(at, 'parameter ' // quoted(name) // ' is varied here, and given by --set')
            return
        end do
    end subroutine check_name

    !> A text of columns under a line of names; lines that start with # or ! are passed over. A path that is
    !> not absolute starts at the deck's folder.
    subroutine read_table(file, at, folder, factor, diagnostics)
        character(*), intent(in) :: file, folder
        type(span_t), intent(in) :: at
        type(factor_t), intent(inout) :: factor
        type(diagnostics_t), intent(inout) :: diagnostics
        type(error_t), allocatable :: error
        character(:), allocatable :: path, text, trouble
        real(wp), allocatable :: values(:, :)
        integer :: first, last, line, n

        if (len(file) == 0) then
            call diagnostics%add(at, 'the name of the file is empty')
            return
        end if
        path = folder // file
        if (file(1:1) == '/') path = file
        factor%file = path
        call read_text(path, text, error)
        if (allocated(error)) then
            call diagnostics%add(at, error%message)
            return
        end if
        n = 0
        line = 0
        first = 1
        trouble = ''
        do while (first <= len(text))
            line = line + 1
            last = index(text(first:), newline) + first - 2
            if (last < first - 1) last = len(text)
            if (.not. is_remark(text(first:last))) then
                if (.not. allocated(factor%names)) then
                    call read_header(text(first:last), factor%names, trouble)
                    allocate (values(size(factor%names), count_lines(text(last + 1:))))
                else
                    n = n + 1
                    call read_row(text(first:last), values(:, n), trouble)
                end if
                if (len(trouble) > 0) then
                    call diagnostics%add(at, path // ':' // to_text(line) // ': ' // trouble)
                    return
                end if
            end if
            first = last + 2
        end do
        if (n == 0) then
            call diagnostics%add(at, path // ' holds no rows of values')
        else
            factor%values = values(:, :n)
        end if
    end subroutine read_table

    pure logical function is_remark(line)
        character(*), intent(in) :: line
        integer :: place

        place = verify(line, separators())
        is_remark = place == 0
        if (.not. is_remark) is_remark = scan(line(place:place), '#!') > 0
    end function is_remark

    !> What stands between the columns.
    pure function separators()
        character(5) :: separators

        separators = ' ,;' // achar(9) // achar(13)
    end function separators

    !> The next word of a line behind `last`; first > last where there is none.
    pure subroutine next_word(line, first, last)
        character(*), intent(in) :: line
        integer, intent(out) :: first
        integer, intent(inout) :: last
        integer :: step

        step = verify(line(last + 1:), separators())
        first = last + step
        if (step == 0) then
            first = len(line) + 1
            last = len(line)
            return
        end if
        step = scan(line(first:), separators())
        last = first + step - 2
        if (step == 0) last = len(line)
    end subroutine next_word

    subroutine read_header(line, names, trouble)
        character(*), intent(in) :: line
        character(max_name), allocatable, intent(out) :: names(:)
        character(:), allocatable, intent(out) :: trouble
        integer :: first, last, i

        trouble = ''
        allocate (names(0))
        last = 0
        do
            call next_word(line, first, last)
            if (first > last) exit
            if (.not. is_name(line(first:last), hyphens=.false.)) then
                trouble = 'the first line must name parameters, and ' // quoted(line(first:last)) // &
                    ' is no name'
                return
            end if
            if (any([(lower_case(names(i)) == lower_case(line(first:last)), i=1, size(names))])) then
                trouble = 'parameter ' // quoted(line(first:last)) // ' has two columns'
                return
            end if
            names = [character(max_name) :: names, line(first:last)]
        end do
    end subroutine read_header

    subroutine read_row(line, row, trouble)
        character(*), intent(in) :: line
        real(wp), intent(out) :: row(:)
        character(:), allocatable, intent(out) :: trouble
        integer :: first, last, i, status

        trouble = ''
        row = 0.0_wp
        last = 0
        do i = 1, size(row)
            call next_word(line, first, last)
            if (first > last) then
                trouble = to_text(size(row)) // ' values are expected, and there are ' // to_text(i - 1)
                return
            end if
            status = verify(line(first:last), '0123456789+-.eEdD')
            if (status == 0) read (line(first:last), *, iostat=status) row(i)
            if (status == 0 .and. .not. abs(row(i)) <= huge(row)) status = 1
            if (status /= 0) then
                trouble = quoted(line(first:last)) // ' is not a number'
                return
            end if
        end do
        call next_word(line, first, last)
        if (first <= last) trouble = 'there are more values than the ' // to_text(size(row)) // &
            ' names of the first line'
    end subroutine read_row

    pure integer function count_lines(text) result(n)
        character(*), intent(in) :: text
        integer :: i

        n = 1
        do i = 1, len(text)
            if (text(i:i) == newline) n = n + 1
        end do
    end function count_lines

end module gb_sweep_command
