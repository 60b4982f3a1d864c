!> Colours for terminals: never in files and pipes, never where the variable NO_COLOR has a value or
!> the terminal is a dumb one.
module gb_colour
    use gb_posix, only: is_terminal
    use gb_text, only: newline
    implicit none
    private

    character(*), parameter :: escape = achar(27) // '['
    character(*), parameter :: reset = escape // '0m', bold = escape // '1m', red = escape // '1;31m', &
        green = escape // '32m', yellow = escape // '33m', cyan = escape // '36m'
    integer, parameter, public :: standard_output = 1, standard_error = 2

    public :: has_colours, colour_report, colour_line

contains

    !> Whether the stream (standard_output, standard_error) takes colours.
    logical function has_colours(stream)
        integer, intent(in) :: stream
        character(8) :: value
        integer :: length, status

        call get_environment_variable('NO_COLOR', value, length, status)
        has_colours = status == 1 .or. length == 0
        if (.not. has_colours) return
        call get_environment_variable('TERM', value, length, status)
        has_colours = status /= 1 .and. value /= 'dumb'
        if (has_colours) has_colours = is_terminal(stream)
    end function has_colours

    !> A report of diagnostics with its places, kinds and carets in colour. Lines of the user's own text are
    !> indented and stay as they are.
    pure function colour_report(report) result(text)
        character(*), intent(in) :: report
        character(:), allocatable :: text
        integer :: first, last

        text = ''
        first = 1
        do while (first <= len(report))
            last = index(report(first:), newline)
            last = merge(len(report), first + last - 2, last == 0)
            text = text // colour_diagnostic(report(first:last))
            if (last < len(report)) text = text // newline
            first = last + 2
        end do
    end function colour_report

    pure function colour_diagnostic(line) result(text)
        character(*), intent(in) :: line
        character(:), allocatable :: text
        integer :: mark

        text = line
        if (len_trim(line) == 0) return
        if (line(1:1) == ' ') then
            if (verify(line, ' ^~') == 0) text = green // line // reset
            return
        end if
        mark = index(line, 'error: ')
        if (mark > 0) then
            text = bold // line(:mark - 1) // reset // red // 'error:' // reset // line(mark + 6:)
            return
        end if
        mark = index(line, 'note: ')
        if (mark > 0) text = bold // line(:mark - 1) // reset // cyan // 'note:' // reset // line(mark + 5:)
    end function colour_diagnostic

    !> A line of the log: warnings, failures and the good end in colour.
    pure function colour_line(line) result(text)
        character(*), intent(in) :: line
        character(:), allocatable :: text

        text = line
        if (index(adjustl(line), 'warning:') == 1) text = yellow // line // reset
        if (index(line, 'failed after') == 1) text = red // line // reset
        if (index(line, 'done in') == 1) text = green // line // reset
    end function colour_line

end module gb_colour
