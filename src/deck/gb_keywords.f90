!> The deck reference, written from the keyword table: as plain text for `--keywords`, as Markdown for
!> docs/deck.md, in roff for the manual page.
module gb_keywords
    use gb_commands, only: command_table
    use gb_page, only: page_t
    use gb_schema, only: schema_t, form_t, key_t, split_words, kind_real, kind_integer, kind_reals, &
        kind_text, kind_choice, kind_choices, kind_name, kind_names, kind_formula, max_keyword
    use gb_values, only: join_words
    implicit none
    private

    public :: keyword_reference, add_keywords_roff, roff

    integer, parameter :: width = 100, margin = 4       !! of the plain text

contains

    !> The reference as plain text or Markdown.
    pure function keyword_reference(markdown) result(text)
        logical, intent(in) :: markdown
        character(:), allocatable :: text
        type(page_t) :: page
        type(schema_t) :: table
        integer :: i

        table = command_table()
        if (.not. markdown) then
            call page%line('Commands of the deck. A key marked * is required; of those marked + one at ' // &
                'least;')
            call page%line('defaults stand in parentheses.')
        end if
        do i = 1, table%n_forms
            if (markdown) then
                call add_section(page, table, i)
            else
                call add_form(page, table, i)
            end if
        end do
        text = page%text
    end function keyword_reference

    !> The reference as sub-sections of a manual page.
    pure subroutine add_keywords_roff(page)
        type(page_t), intent(inout) :: page
        type(schema_t) :: table
        integer :: form, key

        table = command_table()
        do form = 1, table%n_forms
            call page%line('.SS "' // roff(usage(table%forms(form))) // '"')
            call page%line(roff(trim(table%forms(form)%description)))
            do key = table%forms(form)%first_key, table%forms(form)%last_key
                if (first_form_with(table, form, key) /= form) cycle
                call page%line('.TP')
                call page%line('.B ' // roff(trim(label(table%keys(key)))))
                call page%line(roff(remark(table%keys(key))))
            end do
            if (len(shared_keys(table, form, '')) > 0) then
                call page%line('.PP')
                call page%line(roff(shared_keys(table, form, '')))
            end if
        end do
    end subroutine add_keywords_roff

    !> A line of text, so that roff takes nothing in it for a command.
    pure function roff(text) result(safe)
        character(*), intent(in) :: text
        character(:), allocatable :: safe
        integer :: i

        safe = ''
        do i = 1, len(text)
            select case (text(i:i))
            case ('\')
                safe = safe // '\e'
            case ('-')
                safe = safe // '\-'
            case ('"')
                safe = safe // '\(dq'
            case ("'", '.')
                if (i == 1) safe = safe // '\&'
                safe = safe // text(i:i)
            case default
                safe = safe // text(i:i)
            end select
        end do
    end function roff

    pure subroutine add_form(page, table, form)
        type(page_t), intent(inout) :: page
        type(schema_t), intent(in) :: table
        integer, intent(in) :: form
        integer :: i

        call page%line('')
        call page%line(usage(table%forms(form)))
        call add_wrapped(page, repeat(' ', margin), trim(table%forms(form)%description))
        do i = table%forms(form)%first_key, table%forms(form)%last_key
            if (first_form_with(table, form, i) == form) &
                call add_wrapped(page, repeat(' ', margin) // label(table%keys(i)), remark(table%keys(i)))
        end do
        if (len(shared_keys(table, form, '')) > 0) &
            call add_wrapped(page, repeat(' ', margin), shared_keys(table, form, ''))
    end subroutine add_form

    !> Text behind a heading, broken between words; further lines are indented as far as the heading is long.
    pure subroutine add_wrapped(page, heading, text)
        type(page_t), intent(inout) :: page
        character(*), intent(in) :: heading, text
        integer :: first, last

        first = 1
        do while (first <= len(text))
            last = len(text)
            if (len(heading) + last - first + 1 > width) &
                last = first - 1 + index(text(first:first + width - len(heading)), ' ', back=.true.)
            if (last < first) last = len(text)
            if (first == 1) then
                call page%line(heading // trim(text(:last)))
            else
                call page%line(repeat(' ', len(heading)) // trim(text(first:last)))
            end if
            first = last + 1
        end do
    end subroutine add_wrapped

    pure subroutine add_section(page, table, form)
        type(page_t), intent(inout) :: page
        type(schema_t), intent(in) :: table
        integer, intent(in) :: form
        logical :: own
        integer :: i

        call page%line('### `' // usage(table%forms(form)) // '`')
        call page%line('')
        call page%line(trim(table%forms(form)%description))
        call page%line('')
        if (table%forms(form)%last_key < table%forms(form)%first_key) return
        own = any([(first_form_with(table, form, i) == form, i=table%forms(form)%first_key, &
                    table%forms(form)%last_key)])
        if (own) then
            call page%line('| key | default | takes | meaning |')
            call page%line('|---|---|---|---|')
        end if
        do i = table%forms(form)%first_key, table%forms(form)%last_key
            if (first_form_with(table, form, i) /= form) cycle
            associate (key => table%keys(i))
                call page%line('| `' // trim(key%name) // '` | ' // default_text(key) // ' | ' // &
                    takes(key) // ' | ' // trim(key%description) // ' |')
            end associate
        end do
        if (own) call page%line('')
        if (len(shared_keys(table, form, '`')) > 0) then
            call page%line(shared_keys(table, form, '`'))
            call page%line('')
        end if
    end subroutine add_section

    !> The first form of the same command whose key is the same in every respect, if there are many such: then
    !> the key is not described again. Else the form itself.
    pure integer function first_form_with(table, form, key) result(first)
        type(schema_t), intent(in) :: table
        integer, intent(in) :: form, key
        integer :: same

        do first = 1, form - 1
            if (table%forms(first)%command == table%forms(form)%command) exit
        end do
        if (first == form) return
        same = table%find_key(first, table%keys(key)%name)
        if (same > 0) then
            if (table%keys(same)%description == table%keys(key)%description .and. &
                table%keys(same)%default == table%keys(key)%default) return
        end if
        first = form
    end function first_form_with

    !> The keys a form shares with the first form of its command, in a sentence; empty if there are none.
    pure function shared_keys(table, form, quote) result(sentence)
        type(schema_t), intent(in) :: table
        integer, intent(in) :: form
        character(*), intent(in) :: quote
        character(:), allocatable :: sentence
        integer :: i, first

        sentence = ''
        first = form
        do i = table%forms(form)%first_key, table%forms(form)%last_key
            if (first_form_with(table, form, i) == form) cycle
            first = first_form_with(table, form, i)
            if (len(sentence) > 0) sentence = sentence // ', '
            sentence = sentence // quote // trim(table%keys(i)%name) // quote
        end do
        if (first < form) sentence = 'As in ' // table%title(first) // ': ' // sentence // '.'
    end function shared_keys

    !> The command with its words, as it is typed.
    pure function usage(form) result(line)
        type(form_t), intent(in) :: form
        character(:), allocatable :: line

        line = trim(form%command)
        if (form%named) line = line // ' name'
        if (form%variant /= '') line = line // ' ' // trim(form%variant)
        if (form%most_words == 1) line = line // ' field'
        if (form%most_words > 1) line = line // ' field ...'
        if (form%command == 'SWEEP') then
            line = line // ' parameter=[values]'
        else if (form%open) then
            line = line // ' name=value ...'
        end if
        if (form%command == 'GENTBEAM') line = line // ' title'
    end function usage

    !> Name and mark of a key, in a column.
    pure function label(key) result(column)
        type(key_t), intent(in) :: key
        character(max_keyword) :: column

        column = trim(key%name)
        if (key%required) column = trim(column) // '*'
        if (key%one_of) column = trim(column) // '+'
    end function label

    pure function remark(key) result(line)
        type(key_t), intent(in) :: key
        character(:), allocatable :: line

        line = trim(key%description) // '; ' // takes(key)
        if (key%default /= '') line = line // ' (' // trim(key%default) // ')'
    end function remark

    pure function default_text(key) result(words)
        type(key_t), intent(in) :: key
        character(:), allocatable :: words

        if (key%required) then
            words = 'required'
        else if (key%one_of) then
            words = 'one of these'
        else
            words = trim(key%default)
        end if
    end function default_text

    !> What kind of value a key takes, and in which range.
    pure function takes(key) result(words)
        type(key_t), intent(in) :: key
        character(:), allocatable :: words

        select case (key%kind)
        case (kind_real)
            words = 'a number'
        case (kind_integer)
            words = 'a whole number'
        case (kind_reals)
            words = 'a list of numbers'
        case (kind_text)
            words = 'a text'
        case (kind_choice)
            words = join_words(split_words(key%choices), 'or')
        case (kind_choices)
            words = 'one or a list of ' // join_words(split_words(key%choices), 'and')
        case (kind_names)
            words = 'a name or a list of names'
        case (kind_name)
            words = 'a name'
        case (kind_formula)
            words = 'an expression of ' // key%variable
        end select
        if (len(key%range%words()) > 0) words = words // ' ' // key%range%words()
    end function takes

end module gb_keywords
