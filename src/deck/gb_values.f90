!> Values of keys: what stands after the equals sign, by the kind the table asks for.
module gb_values
    use gb_kinds, only: wp
    use gb_command, only: value_t
    use gb_diagnostics, only: diagnostics_t, span_t, quoted
    use gb_expression, only: compile_expression, expression_t, parameters_t
    use gb_lexer, only: token_t, token_quoted, token_list, split_list
    use gb_names, only: max_name
    use gb_program, only: function_names
    use gb_schema, only: key_t, max_keyword, split_words, kind_real, kind_integer, kind_reals, kind_text, &
        kind_choice, kind_choices, kind_name, kind_names, kind_formula
    use gb_text, only: lower_case, nearest_name, to_text
    implicit none
    private

    public :: parse_value, default_value, report_expression, join_words, suggestion, token_text

contains

    !> The value of a key that was not given.
    pure subroutine default_value(key, value)
        type(key_t), intent(in) :: key
        type(value_t), intent(out) :: value

        value%key = key%name
        value%text = trim(key%default)
        value%number = key%default_number
        if (key%kind == kind_choices) value%words = [character(max_name) :: key%default]
    end subroutine default_value

    !> Read the value in a token. `sound` is false where something was wrong, which has been reported.
    pure subroutine parse_value(text, token, key, parameters, diagnostics, value, sound)
        character(*), intent(in) :: text
        type(token_t), intent(in) :: token
        type(key_t), intent(in) :: key
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(value_t), intent(inout) :: value
        logical, intent(out) :: sound

        value%at = token%at
        call check_token(token, key, diagnostics, sound)
        if (.not. sound) return
        select case (key%kind)
        case (kind_real, kind_integer)
            call parse_number(text, token%at, key, parameters, diagnostics, value%number, sound)
        case (kind_reals)
            call parse_numbers(text, token, key, parameters, diagnostics, value, sound)
        case (kind_formula)
            call parse_formula(text, token%at, key, parameters, diagnostics, value, sound)
        case (kind_choice)
            value%text = lower_case(token_text(text, token))
            call check_choice(value%text, token%at, key, diagnostics, sound)
        case (kind_choices, kind_names)
            call parse_words(text, token, key, diagnostics, value, sound)
        case (kind_name)
            value%text = token_text(text, token)
            sound = len_trim(value%text) > 0
            if (.not. sound) call diagnostics%add(token%at, quoted(trim(key%name)) // &
                ' needs a name, and the quotes hold none')
        case (kind_text)
            value%text = token_text(text, token)
        end select
    end subroutine parse_value

    !> Whether the token's kind fits: a list only where one is asked for, no quotes round numbers.
    pure subroutine check_token(token, key, diagnostics, sound)
        type(token_t), intent(in) :: token
        type(key_t), intent(in) :: key
        type(diagnostics_t), intent(inout) :: diagnostics
        logical, intent(out) :: sound

        sound = .true.
        if (token%kind == token_list) then
            sound = any(key%kind == [kind_reals, kind_choices, kind_names])
            if (.not. sound) call diagnostics%add(token%at, quoted(trim(key%name)) // &
                ' takes one value, not a list')
        else if (token%kind == token_quoted) then
            sound = .not. any(key%kind == [kind_real, kind_integer, kind_reals, kind_formula])
            if (.not. sound) call diagnostics%add(token%at, quoted(trim(key%name)) // &
                                                  ' takes a number, not a quoted text')
        end if
    end subroutine check_token

    pure subroutine parse_number(text, at, key, parameters, diagnostics, number, sound)
        character(*), intent(in) :: text
        type(span_t), intent(in) :: at
        type(key_t), intent(in) :: key
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        real(wp), intent(out) :: number
        logical, intent(out) :: sound
        type(expression_t) :: expression

        number = 0.0_wp
        call compile_expression(text, at, parameters, ' ', expression)
        sound = expression%sound
        if (.not. sound) then
            call report_expression(expression, parameters, diagnostics)
            return
        end if
        number = expression%value
        sound = abs(number) <= key%range%limit
        if (.not. sound) then
            call diagnostics%add(at, quoted(trim(key%name)) // ' is ' // to_text(number, 12) // &
                                 ', too large to compute with')
            return
        end if
        if (key%kind == kind_integer) then
            sound = abs(number - anint(number)) <= 1.0e-9_wp*max(1.0_wp, abs(number))
            if (.not. sound) then
                call diagnostics%add(at, quoted(trim(key%name)) // ' must be a whole number, and is ' // &
                                     to_text(number, 12))
                return
            end if
            number = anint(number)
        end if
        sound = key%range%holds(number)
        if (.not. sound) call diagnostics%add(at, quoted(trim(key%name)) // ' must be ' // &
            key%range%words() // ', and is ' // to_text(number, 12))
    end subroutine parse_number

    !> A list of numbers, or a single one. A list is given up at its first error.
    pure subroutine parse_numbers(text, token, key, parameters, diagnostics, value, sound)
        character(*), intent(in) :: text
        type(token_t), intent(in) :: token
        type(key_t), intent(in) :: key
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(value_t), intent(inout) :: value
        logical, intent(out) :: sound
        integer :: i

        call list_parts(text, token, value%parts)
        allocate (value%numbers(size(value%parts)))
        sound = size(value%parts) > 0
        if (.not. sound) call diagnostics%add(token%at, 'the list is empty')
        do i = 1, size(value%parts)
            call parse_number(text, value%parts(i), key, parameters, diagnostics, value%numbers(i), sound)
            if (.not. sound) return
        end do
    end subroutine parse_numbers

    pure subroutine parse_formula(text, at, key, parameters, diagnostics, value, sound)
        character(*), intent(in) :: text
        type(span_t), intent(in) :: at
        type(key_t), intent(in) :: key
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(value_t), intent(inout) :: value
        logical, intent(out) :: sound
        type(expression_t) :: expression

        call compile_expression(text, at, parameters, key%variable, expression)
        sound = expression%sound
        if (sound) then
            value%formula = expression%program
        else
            call report_expression(expression, parameters, diagnostics)
        end if
    end subroutine parse_formula

    !> A list of choices or names, or a single one.
    pure subroutine parse_words(text, token, key, diagnostics, value, sound)
        character(*), intent(in) :: text
        type(token_t), intent(in) :: token
        type(key_t), intent(in) :: key
        type(diagnostics_t), intent(inout) :: diagnostics
        type(value_t), intent(inout) :: value
        logical, intent(out) :: sound
        character(:), allocatable :: word
        logical :: right
        integer :: i

        call list_parts(text, token, value%parts)
        if (allocated(value%words)) deallocate (value%words)
        allocate (value%words(size(value%parts)))
        sound = size(value%parts) > 0
        if (.not. sound) call diagnostics%add(token%at, 'the list is empty')
        do i = 1, size(value%parts)
            word = unquoted(text(value%parts(i)%first:value%parts(i)%last))
            if (key%kind == kind_choices) then
                word = lower_case(word)
                call check_choice(word, value%parts(i), key, diagnostics, right)
                sound = sound .and. right
            end if
            value%words(i) = '?'        ! what is too long for a name matches none
            if (len(word) <= max_name) value%words(i) = word
        end do
    end subroutine parse_words

    pure subroutine list_parts(text, token, parts)
        character(*), intent(in) :: text
        type(token_t), intent(in) :: token
        type(span_t), allocatable, intent(out) :: parts(:)

        if (token%kind == token_list) then
            call split_list(text, token%at, parts)
        else
            allocate (parts(1))
            parts(1) = token%at
        end if
    end subroutine list_parts

    pure subroutine check_choice(word, at, key, diagnostics, sound)
        character(*), intent(in) :: word
        type(span_t), intent(in) :: at
        type(key_t), intent(in) :: key
        type(diagnostics_t), intent(inout) :: diagnostics
        logical, intent(out) :: sound
        character(max_keyword), allocatable :: choices(:)

        sound = .false.
        allocate (choices, source=split_words(key%choices))
        if (len(word) <= max_keyword) sound = any(choices == word)
        if (.not. sound) then
            call diagnostics%add(at, quoted(trim(key%name)) // ' must be ' // join_words(choices, 'or') // &
                                 ', and is ' // quoted(word), hint=suggestion(word, choices, diagnostics))
        end if
    end subroutine check_choice

    !> Report what is wrong with an expression; nothing where that has been done before. `origin` is where
    !> the expression comes from if it is not in the deck's text.
    pure subroutine report_expression(expression, parameters, diagnostics, origin)
        type(expression_t), intent(in) :: expression
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        character(*), intent(in), optional :: origin
        character(:), allocatable :: hint

        if (expression%sound .or. len(expression%message) == 0) return
        hint = expression%hint
        if (expression%called) then
            hint = suggestion(expression%unknown, function_names, diagnostics)
        else if (len(expression%unknown) > 0 .and. .not. diagnostics%is_full()) then
            hint = suggestion(expression%unknown, [character(max_name) :: parameters%names%known(), 'pi'], &
                diagnostics)
        end if
        call diagnostics%add(expression%at, expression%message, hint=hint, other=expression%other, &
                             note=expression%note, origin=origin)
    end subroutine report_expression

    !> What a token says, without quotes.
    pure function token_text(text, token) result(word)
        character(*), intent(in) :: text
        type(token_t), intent(in) :: token
        character(:), allocatable :: word

        word = text(token%at%first:token%at%last)
        if (token%kind == token_quoted) word = unquoted(word)
    end function token_text

    pure function unquoted(text) result(bare)
        character(*), intent(in) :: text
        character(:), allocatable :: bare

        bare = text
        if (len(text) < 2) return
        if (text(1:1) == '"' .and. text(len(text):) == '"') bare = text(2:len(text) - 1)
    end function unquoted

    !> a, b or c
    pure function join_words(words, last_by) result(joined)
        character(*), intent(in) :: words(:), last_by
        character(:), allocatable :: joined
        integer :: i

        joined = ''
        do i = 1, size(words)
            if (i > 1 .and. i == size(words)) then
                joined = joined // ' ' // last_by // ' '
            else if (i > 1) then
                joined = joined // ', '
            end if
            joined = joined // trim(words(i))
        end do
    end function join_words

    !> A hint that names the candidate a word was meant for; empty where none is near, or where nobody will
    !> see it.
    pure function suggestion(word, candidates, diagnostics) result(hint)
        character(*), intent(in) :: word, candidates(:)
        type(diagnostics_t), intent(in) :: diagnostics
        character(:), allocatable :: hint

        hint = ''
        if (diagnostics%is_full()) return
        hint = nearest_name(word, candidates)
        if (len(hint) > 0) hint = 'did you mean ' // quoted(hint) // '?'
    end function suggestion

end module gb_values
