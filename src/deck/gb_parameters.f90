!> PARAMETER: named numbers, and the values that --set puts in their place.
module gb_parameters
    use gb_diagnostics, only: diagnostics_t, span_t, quoted
    use gb_expression, only: compile_expression, define_parameter, expression_t, is_reserved, parameters_t
    use gb_kinds, only: wp
    use gb_lexer, only: statement_t, token_word, token_equals, token_list
    use gb_names, only: is_name, name_table_t
    use gb_parser, only: is_key, is_value, blank_hint
    use gb_text, only: exact_text, lower_case, newline
    use gb_values, only: suggestion, report_expression, token_text
    implicit none
    private

    !> --set name=text, or the value that a member of a SWEEP has.
    type, public :: override_t
        character(:), allocatable :: name
        character(:), allocatable :: text
        logical :: is_swept = .false.
        real(wp) :: value = 0.0_wp      !! of a swept parameter
    end type override_t

    public :: parse_parameters, parameter_lines, check_overrides

contains

    !> Every override must name a parameter of the deck.
    subroutine check_overrides(overrides, parameters, diagnostics)
        type(override_t), intent(in) :: overrides(:)
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: i

        do i = 1, size(overrides)
            if (parameters%later%find(overrides(i)%name) > 0) cycle
            call diagnostics%add(span_t(), 'the deck has no parameter ' // quoted(overrides(i)%name), &
                origin= origin_of(overrides(i)), &
                                 hint=suggestion(overrides(i)%name, parameters%later%known(), diagnostics))
        end do
    end subroutine check_overrides

    !> PARAMETER name=expression ... Of parameters that are not among the `varying` ones, the values may be
    !> `known`.
    subroutine parse_parameters(text, statement, overrides, parameters, diagnostics, known, varying)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(override_t), intent(in) :: overrides(:)
        type(parameters_t), intent(inout) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(parameters_t), intent(in), optional :: known
        type(name_table_t), intent(in), optional :: varying
        integer :: i
        logical :: refused

        refused = .false.
        if (statement%n == 1 .and. statement%sound) call diagnostics%add(statement%tokens(1)%at, &
            'PARAMETER defines nothing: name=value is missing')
        i = 2
        do while (i <= statement%n)
            if (statement%tokens(i)%kind == token_equals) then
                call diagnostics%add(statement%tokens(i)%at, "'=' without a name before it")
                i = i + merge(2, 1, is_value(statement, i + 1))
            else if (is_key(statement, i)) then
                if (present(known)) then
                    call define_again(text, statement, i, overrides, parameters, diagnostics, known, varying)
                else
                    call define_one(text, statement, i, overrides, parameters, diagnostics)
                end if
                i = i + merge(3, 2, is_value(statement, i + 2))
            else
                if (.not. refused) call complain_of_word(text, statement, i, diagnostics)
                refused = .true.
                i = i + 1
            end if
        end do
    end subroutine parse_parameters

    !> The same as `define_one`, for a member of a SWEEP.
    subroutine define_again(text, statement, i, overrides, parameters, diagnostics, known, varying)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        type(override_t), intent(in) :: overrides(:)
        type(parameters_t), intent(inout) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(parameters_t), intent(in) :: known
        type(name_table_t), intent(in) :: varying
        character(:), allocatable :: name

        name = token_text(text, statement%tokens(i))
        if (varying%find(name) > 0) then
            call define_one(text, statement, i, overrides, parameters, diagnostics)
        else
            call define_parameter(parameters, name, statement%tokens(i)%at, &
                known%values(known%names%find(name)), sound=.true.)
        end if
    end subroutine define_again

    subroutine complain_of_word(text, statement, i, diagnostics)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: hint

        hint = blank_hint(text, statement, i)
        if (len(hint) == 0) hint = 'parameters are defined as name=value'
        call diagnostics%add(statement%tokens(i)%at, 'unexpected ' // &
                             quoted(token_text(text, statement%tokens(i))) // ' in PARAMETER', hint=hint)
    end subroutine complain_of_word

    !> The parameter whose name is token i. One whose value is wrong is defined all the same, as unusable, so
    !> that its uses are not reported again.
    subroutine define_one(text, statement, i, overrides, parameters, diagnostics)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        type(override_t), intent(in) :: overrides(:)
        type(parameters_t), intent(inout) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: name
        type(expression_t) :: expression
        integer :: k

        name = token_text(text, statement%tokens(i))
        if (.not. is_value(statement, i + 2)) then
            if (statement%sound .or. i + 1 < statement%n) &
                call diagnostics%add(statement%tokens(i)%at, 'a value is missing after ' // quoted(name // &
                '='))
            expression%sound = .false.
        else
            call read_value(text, statement, i + 2, parameters, diagnostics, expression)
        end if
        if (.not. is_right_name(name, statement%tokens(i)%at, parameters, diagnostics)) return
        do k = 1, size(overrides)
            if (lower_case(overrides(k)%name) == lower_case(name)) &
                call override_value(overrides(k), parameters, diagnostics, expression)
        end do
        call define_parameter(parameters, name, statement%tokens(i)%at, expression%value, expression%sound)
    end subroutine define_one

    subroutine read_value(text, statement, i, parameters, diagnostics, expression)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(expression_t), intent(out) :: expression

        if (statement%tokens(i)%kind == token_word) then
            call compile_expression(text, statement%tokens(i)%at, parameters, ' ', expression)
            call report_expression(expression, parameters, diagnostics)
        else
            call diagnostics%add(statement%tokens(i)%at, 'a parameter is one number, not a ' // &
                                 trim(merge('list       ', 'quoted text', &
                                 statement%tokens(i)%kind == token_list)))
            expression%sound = .false.
        end if
    end subroutine read_value

    subroutine override_value(override, parameters, diagnostics, expression)
        type(override_t), intent(in) :: override
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(expression_t), intent(out) :: expression

        if (override%is_swept) then
            expression%value = override%value
            return
        end if
        call compile_expression(override%text, span_t(1, len(override%text)), parameters, ' ', expression)
        call report_expression(expression, parameters, diagnostics, origin=origin_of(override))
    end subroutine override_value

    logical function is_right_name(name, at, parameters, diagnostics)
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: first

        is_right_name = .false.
        if (.not. is_name(name, hyphens=.false.)) then
            call diagnostics%add(at, quoted(name) // ' is not a name for a parameter', &
            hint="it starts with a letter; letters, digits and '_' follow, 32 characters at most")
        else if (is_reserved(name)) then
            call diagnostics%add(at, quoted(name) // &
                ' has a meaning of its own in expressions: choose another name')
        else
            first = parameters%names%find(name)
            is_right_name = first == 0
            if (first > 0) call diagnostics%add(at, 'parameter ' // quoted(name) // ' is defined twice', &
                                                other=parameters%names%span(first), note='first defined here')
        end if
    end function is_right_name

    pure function origin_of(override) result(origin)
        type(override_t), intent(in) :: override
        character(:), allocatable :: origin
        character(:), allocatable :: whole

        whole = quoted(override%name // '=' // override%text)
        origin = '--set ' // whole(2:len(whole) - 1)
    end function origin_of

    !> A line "name=value" for every parameter, as the results file keeps them.
    function parameter_lines(parameters) result(lines)
        type(parameters_t), intent(in) :: parameters
        character(:), allocatable :: lines
        character(:), allocatable :: buffer, line
        integer :: i, n

        allocate (character(64*parameters%names%n) :: buffer)
        n = 0
        do i = 1, parameters%names%n
            line = trim(parameters%names%names(i)) // '=' // exact_text(parameters%values(i)) // newline
            buffer(n + 1:n + len(line)) = line
            n = n + len(line)
        end do
        lines = buffer(:n)
    end function parameter_lines

end module gb_parameters
