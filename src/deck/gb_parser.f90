!> Statements matched against the keyword table. What a command means is not known here: the table says
!> which words and keys it takes and what their values are like.
module gb_parser
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t, span_t, quoted
    use gb_expression, only: parameters_t
    use gb_lexer, only: statement_t, token_word, token_quoted, token_equals
    use gb_names, only: is_name
    use gb_schema, only: schema_t, max_keyword, split_words
    use gb_synonyms, only: command_for, key_for, plane_hint
    use gb_text, only: lower_case, nearest_name
    use gb_values, only: parse_value, default_value, join_words, suggestion, token_text
    implicit none
    private

    public :: find_form, parse_command, is_key, is_value, blank_hint

    character(*), parameter, public :: name_rule = &
        "a name starts with a letter; letters, digits, '_' and '-' follow, 32 characters at most"

contains

    !> The table's first form of the statement's command; 0, and a report, where it is none. `meant` is the
    !> command that a misspelt one stands for, if that can be told.
    pure subroutine find_form(text, statement, table, diagnostics, form, meant)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        type(diagnostics_t), intent(inout) :: diagnostics
        integer, intent(out) :: form
        character(:), allocatable, intent(out) :: meant
        character(:), allocatable :: word, hint

        form = 0
        meant = ''
        associate (token => statement%tokens(1))
            if (token%kind /= token_word) then
                call diagnostics%add(token%at, 'a command is expected here')
                return
            end if
            word = text(token%at%first:token%at%last)
            if (is_key(statement, 1)) then
                call diagnostics%add(token%at, 'a command is expected here, and ' // quoted(word) // &
                    ' is a key', hint="a command goes on on the next line where '&' ends its line")
                return
            end if
            form = table%find_command(word)
            if (form > 0) return
            hint = ''
            if (.not. diagnostics%is_full()) meant = intended_command(word, table)
            if (len(meant) > 0) hint = 'did you mean ' // quoted(meant) // '?'
            if (len(command_for(word)) > 0) then
                meant = command_for(word)
                hint = 'here that is ' // meant
            end if
            call diagnostics%add(token%at, 'unknown command ' // quoted(word), hint=hint)
        end associate
    end subroutine find_form

    !> The command a misspelt word may stand for: one it begins, or the nearest.
    pure function intended_command(word, table) result(meant)
        character(*), intent(in) :: word
        type(schema_t), intent(in) :: table
        character(:), allocatable :: meant
        character(max_keyword), allocatable :: names(:)
        integer :: i

        allocate (names, source=table%command_names())
        if (len(word) == 3) then
            do i = 1, size(names)
                if (lower_case(names(i)(:3)) == lower_case(word)) then
                    meant = trim(names(i))
                    return
                end if
            end do
        end if
        meant = nearest_name(word, names)
    end function intended_command

    !> Parse a statement whose command is known. Whatever is wrong has been reported when `command%sound` is
    !> false.
    pure subroutine parse_command(text, statement, table, first_form, parameters, diagnostics, command)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        integer, intent(in) :: first_form
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(out) :: command
        integer :: next, i

        command%at = statement%tokens(1)%at
        command%sound = statement%sound
        command%name = ''
        command%title = trim(table%forms(first_form)%command)
        next = 2
        if (table%forms(first_form)%named) call take_name(text, statement, table, first_form, next, &
            diagnostics, command)
        call take_variant(text, statement, table, first_form, next, diagnostics, command)
        if (command%form == 0) return
        associate (form => table%forms(command%form))
            allocate (command%words(0), command%values(form%last_key - form%first_key + 1))
            do i = 1, size(command%values)
                call default_value(table%keys(form%first_key + i - 1), command%values(i))
            end do
            call take_items(text, statement, table, next, parameters, diagnostics, command)
        end associate
    end subroutine parse_command

    pure subroutine take_name(text, statement, table, form, next, diagnostics, command)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        integer, intent(in) :: form
        integer, intent(inout) :: next
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command

        command%name_at = command%at
        if (.not. is_free_word(statement, next)) then
            command%sound = .false.
            if (statement%sound) call diagnostics%add(command%at, trim(table%forms(form)%command) // &
                                                      ' needs a name, which follows it at once')
            return
        end if
        command%name_at = statement%tokens(next)%at
        command%name = token_text(text, statement%tokens(next))
        next = next + 1
        if (is_name(command%name, hyphens=.true.)) return
        call diagnostics%add(command%name_at, quoted(command%name) // ' is not a name', hint=name_rule)
        command%sound = .false.
    end subroutine take_name

    !> The word that chooses the form. Where it is missing or unknown, or the form cannot be had, form is 0.
    pure subroutine take_variant(text, statement, table, first_form, next, diagnostics, command)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        integer, intent(in) :: first_form
        integer, intent(inout) :: next
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        character(max_keyword), allocatable :: variants(:)
        character(:), allocatable :: word
        type(span_t) :: at

        at = command%at
        allocate (variants, source=table%variants(table%forms(first_form)%command))
        if (size(variants) > 0 .and. is_free_word(statement, next)) then
            word = token_text(text, statement%tokens(next))
            if (len(word) <= max_keyword) command%form = table%find_form(table%forms(first_form)%command, &
                word)
            if (command%form > 0 .and. len(word) > 0) then
                at = statement%tokens(next)%at
                next = next + 1
            else
                command%form = table%find_form(table%forms(first_form)%command, '')
                if (command%form == 0) call diagnostics%add(statement%tokens(next)%at, 'unknown kind ' // &
                    quoted(word) // ' of ' // command%title // ' (' // join_words(variants, 'or') // ')', &
                    hint=suggestion(word, variants, diagnostics))
            end if
        else
            command%form = table%find_form(table%forms(first_form)%command, '')
            if (command%form == 0 .and. statement%sound .and. (command%sound .or. next > 2)) then
                call complain_of_variant(table%forms(first_form)%named, variants, diagnostics, command)
            end if
        end if
        if (command%form > 0) then
            command%title = table%title(command%form)
            return
        end if
        command%sound = .false.
    end subroutine take_variant

    !> The kind is missing; perhaps it was given in place of the name.
    pure subroutine complain_of_variant(named, variants, diagnostics, command)
        logical, intent(in) :: named
        character(max_keyword), intent(in) :: variants(:)
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(in) :: command

        if (named .and. any(variants == lower_case(command%name))) then
            call diagnostics%add(command%name_at, command%title // ' needs a name before ' // &
                quoted(command%name))
        else
            call diagnostics%add(command%at, command%title // ' needs its kind: ' // join_words(variants, &
                'or'))
        end if
    end subroutine complain_of_variant

    !> Everything after the leading words: keys with values, and words.
    pure subroutine take_items(text, statement, table, first, parameters, diagnostics, command)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        integer, intent(in) :: first
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        logical :: word_refused, sign_refused
        integer :: i

        word_refused = .false.
        sign_refused = .false.
        i = first
        do while (i <= statement%n)
            if (statement%tokens(i)%kind == token_equals) then
                call diagnostics%add(statement%tokens(i)%at, "'=' without a key before it")
                sign_refused = .true.
                i = i + 1
                if (is_value(statement, i)) i = i + 1
            else if (.not. is_key(statement, i)) then
                call take_word(text, statement, i, table, diagnostics, command, word_refused)
                i = i + 1
            else if (is_value(statement, i + 2)) then
                call take_pair(text, statement, i, table, parameters, diagnostics, command)
                i = i + 3
            else
                call take_key_alone(text, statement, i, diagnostics, command)
            end if
        end do
        command%sound = command%sound .and. .not. sign_refused
        if (statement%sound .and. .not. sign_refused) call find_missing(table, diagnostics, command)
    end subroutine take_items

    !> A key without a value; a doubled equals sign is passed over with the value behind it.
    pure subroutine take_key_alone(text, statement, i, diagnostics, command)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(inout) :: i
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        logical :: doubled

        call mark_given(token_text(text, statement%tokens(i)), statement%tokens(i)%at, command)
        command%sound = .false.
        doubled = .false.
        if (i + 2 <= statement%n) doubled = statement%tokens(i + 2)%kind == token_equals
        if (doubled) then
            call diagnostics%add(statement%tokens(i + 2)%at, "a second '='")
            i = i + 3
            if (is_value(statement, i)) i = i + 1
        else
            if (statement%sound .or. i + 1 < statement%n) call diagnostics%add(statement%tokens(i)%at, &
                'a value is missing after ' // quoted(token_text(text, statement%tokens(i)) // '='))
            i = i + 2
        end if
    end subroutine take_key_alone

    !> A key that was meant but went wrong is not reported as missing on top of that.
    pure subroutine mark_given(name, at, command)
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        type(command_t), intent(inout) :: command
        integer :: number

        number = command%value_of(lower_case(name))
        if (number == 0) return
        if (command%values(number)%given) return
        command%values(number)%given = .true.
        command%values(number)%is_guess = .true.
        command%values(number)%text = ''
        command%values(number)%key_at = at
        command%values(number)%at = at
    end subroutine mark_given

    pure subroutine take_pair(text, statement, i, table, parameters, diagnostics, command)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        type(schema_t), intent(in) :: table
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        character(:), allocatable :: name
        integer :: key
        logical :: sound

        name = token_text(text, statement%tokens(i))
        key = 0
        if (len(name) <= max_keyword) key = table%find_key(command%form, name)
        sound = .false.
        if (key == 0) then
            call complain_of_key(name, statement%tokens(i)%at, table, diagnostics, command)
        else
            associate (value => command%values(key - table%forms(command%form)%first_key + 1))
                if (value%given .and. .not. value%is_guess) then
                    call diagnostics%add(statement%tokens(i)%at, 'key ' // quoted(name) // &
                        ' is given twice', other=value%key_at, note='first given here')
                else
                    value%given = .true.
                    value%is_guess = .false.
                    value%text = ''
                    value%key_at = statement%tokens(i)%at
                    call parse_value(text, statement%tokens(i + 2), table%keys(key), parameters, &
                        diagnostics, value, sound)
                end if
            end associate
        end if
        command%sound = command%sound .and. sound
    end subroutine take_pair

    pure subroutine complain_of_key(name, at, table, diagnostics, command)
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        type(schema_t), intent(in) :: table
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        character(:), allocatable :: hint, meant
        integer :: i

        hint = ''
        if (.not. diagnostics%is_full()) then
            associate (form => table%forms(command%form))
                meant = key_for(name, key_names(command))
                if (len(meant) == 0) meant = nearest_name(name, key_names(command))
                if (len(meant) > 0) call mark_given(meant, at, command)
                if (len(meant) > 0) hint = 'did you mean ' // quoted(meant) // '?'
                do i = 1, table%n_forms
                    if (table%forms(i)%command /= form%command .or. len(name) > max_keyword) cycle
                    if (table%find_key(i, name) == 0) cycle
                    hint = quoted(lower_case(name)) // ' goes with ' // table%title(i)
                    exit
                end do
                if (len(hint) == 0) then
                    hint = plane_hint(name, key_names(command))
                    if (len(hint) > 0) call mark_given(name(:1) // '3', at, command)
                end if
            end associate
        end if
        call diagnostics%add(at, 'unknown key ' // quoted(name) // ' in ' // command%title, hint=hint)
    end subroutine complain_of_key

    pure function key_names(command) result(names)
        type(command_t), intent(in) :: command
        character(max_keyword) :: names(size(command%values))
        integer :: i

        do i = 1, size(names)
            names(i) = command%values(i)%key
        end do
    end function key_names

    !> A word that is not a key: one of the form's words, or one too many.
    pure subroutine take_word(text, statement, i, table, diagnostics, command, refused)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        type(schema_t), intent(in) :: table
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        logical, intent(inout) :: refused
        character(max_keyword), allocatable :: choices(:)
        character(:), allocatable :: word, hint

        word = lower_case(token_text(text, statement%tokens(i)))
        associate (form => table%forms(command%form), at => statement%tokens(i)%at)
            allocate (choices, source=split_words(form%words))
            if (len(word) <= max_keyword .and. any(choices == word) .and. &
                size(command%words) < form%most_words) then
                if (any(command%words == word)) then
                    call diagnostics%add(at, quoted(word) // ' is given twice')
                    command%sound = .false.
                else
                    command%words = [character(max_keyword) :: command%words, word]
                end if
                return
            end if
            command%sound = .false.
            if (refused) return
            refused = .true.
            if (size(command%words) < form%most_words) then
                hint = plane_hint(word, choices)
                if (len(hint) == 0) hint = suggestion(word, choices, diagnostics)
                call diagnostics%add(at, quoted(token_text(text, statement%tokens(i))) // &
                    ' is not a field (' // join_words(choices, 'or') // ')', hint=hint)
            else
                call complain_of_word(text, statement, i, table, diagnostics, command)
            end if
        end associate
    end subroutine take_word

    pure subroutine complain_of_word(text, statement, i, table, diagnostics, command)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        type(schema_t), intent(in) :: table
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        character(:), allocatable :: word, hint

        word = token_text(text, statement%tokens(i))
        hint = ''
        call mark_given(word, statement%tokens(i)%at, command)
        if (word == '&') then
            hint = "'&' continues a line only at its end"
        else if (len(word) <= max_keyword) then
            if (table%find_key(command%form, word) > 0) &
                hint = 'a key takes a value: ' // lower_case(word) // '=...'
        end if
        if (len(hint) == 0) hint = blank_hint(text, statement, i)
        call diagnostics%add(statement%tokens(i)%at, 'unexpected ' // quoted(word) // ' in ' // &
            command%title, hint=hint)
    end subroutine complain_of_word

    !> Advice for a word that looks like the rest of the number or expression before it; else empty.
    pure function blank_hint(text, statement, i) result(hint)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i
        character(:), allocatable :: hint
        character(*), parameter :: operators = '+-*/^(', digits = '0123456789'
        integer :: before, here

        hint = ''
        if (i < 5) return
        if (statement%tokens(i - 2)%kind /= token_equals) return
        before = statement%tokens(i - 1)%at%last
        here = statement%tokens(i)%at%first
        if (scan(text(before:before), operators) > 0 .or. scan(text(here:here), operators) > 0) &
            hint = 'a value holds no blanks, unless inside parentheses'
        if (here == before + 2 .and. text(before + 1:before + 1) == ',' .and. scan(text(before:before), &
            digits) > 0 .and. scan(text(here:here), digits) > 0) hint = 'decimals stand behind a point: ' &
            // text(statement%tokens(i - 1)%at%first:before) // '.' // text(here:statement%tokens(i)%at%last)
    end function blank_hint

    !> Words and keys that must be given and are not.
    pure subroutine find_missing(table, diagnostics, command)
        type(schema_t), intent(in) :: table
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t), intent(inout) :: command
        character(max_keyword) :: missing(size(command%values)), choices(size(command%values))
        logical :: one_given
        integer :: i, n_missing, n_choices

        associate (form => table%forms(command%form))
            if (form%most_words > 0 .and. size(command%words) == 0) then
                if (command%sound) call diagnostics%add(command%at, command%title // ' needs a field: ' // &
                                                        join_words(split_words(form%words), 'or'))
                command%sound = .false.
            end if
            n_missing = 0
            n_choices = 0
            one_given = .false.
            do i = 1, size(command%values)
                associate (key => table%keys(form%first_key + i - 1), given => command%values(i)%given)
                    if (key%required .and. .not. given) call append(missing, n_missing, key%name)
                    if (key%one_of) call append(choices, n_choices, key%name)
                    one_given = one_given .or. (key%one_of .and. given)
                end associate
            end do
        end associate
        if (n_choices == 1 .and. .not. one_given) call append(missing, n_missing, choices(1))
        if (n_missing > 0) call diagnostics%add(command%at, 'missing key' // trim(merge('s', ' ', &
            n_missing > 1)) // ' ' // quoted_list(missing(:n_missing)) // ' in ' // command%title)
        if (n_choices > 1 .and. .not. one_given) then
            call diagnostics%add(command%at, command%title // ' needs one of ' // &
                join_words(choices(:n_choices), 'or'))
            command%sound = .false.
        end if
        command%sound = command%sound .and. n_missing == 0
    end subroutine find_missing

    pure subroutine append(list, n, word)
        character(max_keyword), intent(inout) :: list(:)
        integer, intent(inout) :: n
        character(max_keyword), intent(in) :: word

        n = n + 1
        list(n) = word
    end subroutine append

    pure function quoted_list(names) result(list)
        character(max_keyword), intent(in) :: names(:)
        character(:), allocatable :: list
        integer :: i

        list = quoted(trim(names(1)))
        do i = 2, size(names)
            list = list // ', ' // quoted(trim(names(i)))
        end do
    end function quoted_list

    !> Whether token i is a key: a word with an equals sign behind it. Behind another equals sign it must
    !> look like a name, or else it is a value and the second sign is stray.
    pure logical function is_key(statement, i)
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i

        is_key = i < statement%n
        if (is_key) is_key = statement%tokens(i + 1)%kind == token_equals .and. &
            statement%tokens(i)%kind == token_word
        if (is_key .and. i > 1) is_key = statement%tokens(i)%lettered .or. &
            statement%tokens(i - 1)%kind /= token_equals
    end function is_key

    !> Whether token i can be a value: it is there, and neither an equals sign nor the next key.
    pure logical function is_value(statement, i)
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i

        is_value = i <= statement%n
        if (is_value) is_value = statement%tokens(i)%kind /= token_equals .and. .not. is_key(statement, i)
    end function is_value

    !> Whether token i is a word and no key.
    pure logical function is_free_word(statement, i)
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: i

        is_free_word = i <= statement%n
        if (.not. is_free_word) return
        is_free_word = any(statement%tokens(i)%kind == [token_word, token_quoted]) .and. &
            .not. is_key(statement, i)
    end function is_free_word

end module gb_parser
