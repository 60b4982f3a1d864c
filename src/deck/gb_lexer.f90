!> From text to statements: a statement is one command with its continuation lines, cut into words, quoted
!> texts, lists and equals signs. Tokens are spans of the source, so that every later message finds its place.
module gb_lexer
    use gb_diagnostics, only: diagnostics_t, span_t
    use gb_text, only: lower_case, newline
    implicit none
    private

    integer, parameter, public :: token_word = 1, token_quoted = 2, token_equals = 3, token_list = 4, &
        token_title = 5

    type, public :: token_t
        integer :: kind = token_word
        type(span_t) :: at              !! brackets and quotes included
        logical :: lettered = .false.   !! a word that starts as names do
    end type token_t

    type, public :: statement_t
        type(token_t), allocatable :: tokens(:)
        integer :: n = 0                !! tokens in use; 0: the text has ended
        logical :: sound = .true.       !! no bracket or quote is open
    end type statement_t

    !> The command whose line is a title and not cut into tokens.
    character(*), parameter :: title_command = 'gentbeam'

    public :: next_statement, split_list, skip_filler, title_text

contains

    !> The next statement of text(:limit) from `position` on, which is moved behind it.
    pure subroutine next_statement(text, limit, position, statement, diagnostics)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position
        type(statement_t), intent(inout) :: statement
        type(diagnostics_t), intent(inout) :: diagnostics

        statement%n = 0
        statement%sound = .true.
        call skip_empty_lines(text, limit, position)
        do while (position <= limit)
            select case (text(position:position))
            case (' ', ',', achar(9), achar(13))
                position = position + 1
            case (newline)
                position = position + 1
                exit
            case ('!', '#')
                position = end_of_line(text, limit, position) + 1
            case ('=')
                call push(statement, token_equals, position, position)
                position = position + 1
            case ('"')
                call read_quoted(text, limit, position, statement, diagnostics)
            case ('[')
                call read_list(text, limit, position, statement, diagnostics)
            case (']')
                call diagnostics%add(span_t(position, position), "']' without '['")
                statement%sound = .false.
                position = position + 1
            case default
                if (ends_line(text, limit, position)) then
                    call continue_line(text, limit, position, statement, diagnostics)
                else
                    call read_word(text, limit, position, statement, diagnostics)
                    if (statement%n == 1) call read_title(text, limit, position, statement)
                end if
            end select
        end do
    end subroutine next_statement

    !> The parts of the list in brackets at `at`: spans of its values, which blanks and commas separate.
    pure subroutine split_list(text, at, parts)
        character(*), intent(in) :: text
        type(span_t), intent(in) :: at
        type(span_t), allocatable, intent(out) :: parts(:)
        type(span_t), allocatable :: grown(:)
        integer :: place, last, depth, n

        allocate (parts(8))
        n = 0
        place = at%first + 1
        do
            call skip_filler(text, at%last - 1, place, commas=.true.)
            if (place > at%last - 1) exit
            last = place
            depth = 0
            if (text(place:place) == '"') last = place + index(text(place + 1:at%last), '"')
            do while (last < at%last - 1)
                if (text(last:last) == '(') depth = depth + 1
                if (text(last:last) == ')') depth = depth - 1
                if (depth <= 0 .and. scan(text(last + 1:last + 1), ' ,!#"' // achar(9) // newline // &
                    achar(13)) > 0) exit
                if (ends_line(text, at%last, last + 1)) exit
                last = last + 1
            end do
            if (n == size(parts)) then
                allocate (grown(2*n))
                grown(:n) = parts
                call move_alloc(grown, parts)
            end if
            n = n + 1
            parts(n) = span_t(place, last)
            place = last + 1
        end do
        parts = parts(:n)
    end subroutine split_list

    !> Pass over what separates values inside brackets and parentheses: blanks, line ends with their `&`,
    !> comments.
    pure subroutine skip_filler(text, limit, place, commas)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: place
        logical, intent(in) :: commas

        do while (place <= limit)
            select case (text(place:place))
            case (' ', achar(9), achar(13), newline)
                place = place + 1
            case (',')
                if (.not. commas) exit
                place = place + 1
            case ('!', '#')
                place = end_of_line(text, limit, place) + 1
            case ('&')
                if (.not. ends_line(text, limit, place)) exit
                place = place + 1
            case default
                exit
            end select
        end do
    end subroutine skip_filler

    pure subroutine skip_empty_lines(text, limit, place)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: place

        do while (place <= limit)
            select case (text(place:place))
            case (' ', ',', achar(9), achar(13), newline)
                place = place + 1
            case ('!', '#')
                place = end_of_line(text, limit, place) + 1
            case default
                exit
            end select
        end do
    end subroutine skip_empty_lines

    !> The last byte before the line feed.
    pure integer function end_of_line(text, limit, place) result(last)
        character(*), intent(in) :: text
        integer, intent(in) :: limit, place

        last = place - 1
        do while (last < limit)
            if (text(last + 1:last + 1) == newline) exit
            last = last + 1
        end do
    end function end_of_line

    !> Whether `&` stands at `place` and only blanks and a comment follow on its line.
    pure logical function ends_line(text, limit, place)
        character(*), intent(in) :: text
        integer, intent(in) :: limit, place
        integer :: i

        ends_line = .false.
        if (place > limit) return
        if (text(place:place) /= '&') return
        do i = place + 1, limit
            if (scan(text(i:i), ' ' // achar(9) // achar(13)) > 0) cycle
            ends_line = scan(text(i:i), '!#' // newline) > 0
            return
        end do
        ends_line = .true.
    end function ends_line

    !> From the `&` to the next line that says something.
    pure subroutine continue_line(text, limit, position, statement, diagnostics)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position
        type(statement_t), intent(inout) :: statement
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: mark

        mark = position
        position = end_of_line(text, limit, position) + 2
        call skip_empty_lines(text, limit, position)
        if (position <= limit) return
        call diagnostics%add(span_t(mark, mark), "the deck ends where '&' says that the line goes on")
        statement%sound = .false.
    end subroutine continue_line

    pure subroutine read_quoted(text, limit, position, statement, diagnostics)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position
        type(statement_t), intent(inout) :: statement
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: closing

        closing = closing_quote(text, limit, position)
        if (closing > 0) then
            call push(statement, token_quoted, position, closing)
            position = closing + 1
        else
            call diagnostics%add(span_t(position, position), 'this quote is not closed on its line')
            statement%sound = .false.
            position = end_of_line(text, limit, position) + 1
        end if
    end subroutine read_quoted

    !> The quote that closes the one at `place`, 0 where the line ends first.
    pure integer function closing_quote(text, limit, place) result(closing)
        character(*), intent(in) :: text
        integer, intent(in) :: limit, place

        do closing = place + 1, limit
            if (text(closing:closing) == '"') return
            if (text(closing:closing) == newline) exit
        end do
        closing = 0
    end function closing_quote

    pure subroutine read_list(text, limit, position, statement, diagnostics)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position
        type(statement_t), intent(inout) :: statement
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: first, closing

        first = position
        position = position + 1
        do while (position <= limit)
            call skip_continuations(text, limit, position)
            if (position > limit) exit
            select case (text(position:position))
            case (']')
                call push(statement, token_list, first, position)
                position = position + 1
                return
            case (newline, '!', '#')
                exit
            case ('"')
                closing = closing_quote(text, limit, position)
                if (closing == 0) exit
                position = closing + 1
            case default
                position = position + 1
            end select
        end do
        call diagnostics%add(span_t(first, first), "this '[' is never closed")
        statement%sound = .false.
        position = end_of_line(text, limit, position) + 1
    end subroutine read_list

    !> A word goes on to the next blank, comma or `=` outside parentheses.
    pure subroutine read_word(text, limit, position, statement, diagnostics)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position
        type(statement_t), intent(inout) :: statement
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: first, depth, open_at, last

        first = position
        depth = 0
        open_at = 0
        do
            last = position
            if (depth > 0) call skip_continuations(text, limit, position)
            if (position > limit) exit
            if (scan(text(position:position), newline // '!#') > 0) exit
            if (depth == 0) then
                if (scan(text(position:position), ' ,="]' // achar(9) // achar(13)) > 0) exit
                if (ends_line(text, limit, position)) exit
            end if
            if (text(position:position) == '(') then
                if (depth == 0) open_at = position
                depth = depth + 1
            else if (text(position:position) == ')' .and. depth > 0) then
                depth = depth - 1
            end if
            position = position + 1
        end do
        if (depth > 0) then
            call diagnostics%add(span_t(open_at, open_at), "this '(' is never closed")
            statement%sound = .false.
        else
            call push(statement, token_word, first, last - 1)
            statement%tokens(statement%n)%lettered = scan(lower_case(text(first:first)), &
                                                          'abcdefghijklmnopqrstuvwxyz') > 0
        end if
    end subroutine read_word

    pure subroutine skip_continuations(text, limit, position)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position

        do while (ends_line(text, limit, position))
            position = end_of_line(text, limit, position) + 2
            call skip_empty_lines(text, limit, position)
        end do
    end subroutine skip_continuations

    !> After the title command: the rest of the line, up to a comment, is one token.
    pure subroutine read_title(text, limit, position, statement)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position
        type(statement_t), intent(inout) :: statement
        integer :: first, last

        associate (word => statement%tokens(1)%at)
            if (.not. is_title_command(text(word%first:word%last))) return
        end associate
        call skip_continuations(text, limit, position)
        do while (position <= limit)
            if (scan(text(position:position), ' ,' // achar(9) // achar(13)) == 0) exit
            position = position + 1
        end do
        first = position
        last = position - 1
        if (position <= limit) call skip_quoted(text, limit, position, last)
        do while (position <= limit)
            call skip_continuations(text, limit, position)
            if (position > limit) exit
            if (scan(text(position:position), newline // '!#') > 0) exit
            if (scan(text(position:position), ' ,' // achar(9) // achar(13)) == 0) last = position
            position = position + 1
        end do
        if (last >= first) call push(statement, token_title, first, last)
    end subroutine read_title

    !> In a quoted title no character is special.
    pure subroutine skip_quoted(text, limit, position, last)
        character(*), intent(in) :: text
        integer, intent(in) :: limit
        integer, intent(inout) :: position, last
        integer :: length

        if (text(position:position) /= '"') return
        length = index(text(position + 1:end_of_line(text, limit, position)), '"')
        if (length == 0) return
        last = position + length
        position = last + 1
    end subroutine skip_quoted

    !> The title a token holds: quotes round all of it dropped, continued lines joined by one blank.
    pure function title_text(text, at) result(title)
        character(*), intent(in) :: text
        type(span_t), intent(in) :: at
        character(:), allocatable :: title
        integer :: place, n

        allocate (character(at%last - at%first + 1) :: title)
        n = 0
        place = at%first
        do while (place <= at%last)
            if (ends_line(text, at%last, place)) then
                call skip_continuations(text, at%last, place)
                n = len_trim(title(:n)) + 1
                title(n:n) = ' '
            else
                n = n + 1
                title(n:n) = text(place:place)
                place = place + 1
            end if
        end do
        title = title(:n)
        if (n >= 2) then
            if (title(1:1) == '"' .and. index(title(2:), '"') == n - 1) title = title(2:n - 1)
        end if
    end function title_text

    pure logical function is_title_command(word)
        character(*), intent(in) :: word

        is_title_command = len(word) >= 4 .and. len(word) <= len(title_command)
        if (is_title_command) is_title_command = lower_case(word) == title_command(:len(word))
    end function is_title_command

    pure subroutine push(statement, kind, first, last)
        type(statement_t), intent(inout) :: statement
        integer, intent(in) :: kind, first, last
        type(token_t), allocatable :: grown(:)

        if (.not. allocated(statement%tokens)) allocate (statement%tokens(32))
        if (statement%n == size(statement%tokens)) then
            allocate (grown(2*statement%n))
            grown(:statement%n) = statement%tokens
            call move_alloc(grown, statement%tokens)
        end if
        statement%n = statement%n + 1
        statement%tokens(statement%n) = token_t(kind, span_t(first, last))
    end subroutine push

end module gb_lexer
