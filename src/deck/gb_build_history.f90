!> Load histories of the deck, and the two-column tables they may come from.
module gb_build_history
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t
    use gb_draft, only: draft_t, resize, space_history
    use gb_error, only: error_t
    use gb_history, only: history_t, history_step, history_ramp, history_pulse, history_sine, &
        history_table, history_formula
    use gb_kinds, only: wp
    use gb_source, only: read_text
    use gb_text, only: newline, to_text
    implicit none
    private

    public :: build_history

contains

    subroutine build_history(command, draft, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(history_t) :: history
        integer :: number

        if (command%sound) call read_history(command, draft%folder, history, diagnostics)
        call draft%define(space_history, command, diagnostics, number)
        if (number == 0) return
        call resize(draft%problem%model%histories, number)
        history%name = command%name
        draft%problem%model%histories(number) = history
    end subroutine build_history

    subroutine read_history(command, folder, history, diagnostics)
        type(command_t), intent(inout) :: command
        character(*), intent(in) :: folder
        type(history_t), intent(inout) :: history
        type(diagnostics_t), intent(inout) :: diagnostics

        select case (command%title)
        case ('HISTORY ramp')
            history%kind = history_ramp
            history%start = command%number('start')
            history%rise = command%number('rise')
        case ('HISTORY pulse')
            history%kind = history_pulse
            history%start = command%number('start')
            history%stop = command%number('stop')
            if (history%stop > history%start) return
            call diagnostics%add(command%place('stop'), "'stop' must be after 'start', and " // &
                                 to_text(history%stop, 12) // ' is not after ' // &
                                 to_text(history%start, 12))
            command%sound = .false.
        case ('HISTORY sine')
            history%kind = history_sine
            history%frequency = command%number('frequency')
            history%phase = command%number('phase')
        case ('HISTORY table')
            history%kind = history_table
            call read_table(command, folder, history, diagnostics)
        case ('HISTORY formula')
            history%kind = history_formula
            history%formula = command%values(command%value_of('f'))%formula
        case default
            history%kind = history_step
            history%start = command%number('start')
        end select
    end subroutine read_history

    !> The points of a table, from two lists or from a file.
    subroutine read_table(command, folder, history, diagnostics)
        type(command_t), intent(inout) :: command
        character(*), intent(in) :: folder
        type(history_t), intent(inout) :: history
        type(diagnostics_t), intent(inout) :: diagnostics
        logical :: lists
        integer :: before

        before = diagnostics%count()
        lists = command%given('t') .or. command%given('f')
        if (lists .eqv. command%given('file')) then
            call diagnostics%add(command%at, 'HISTORY table needs either t= and f=, or file=')
        else if (lists) then
            call take_lists(command, history, diagnostics)
        else
            call read_columns(command, folder, history, diagnostics)
        end if
        command%sound = diagnostics%count() == before
    end subroutine read_table

    subroutine take_lists(command, history, diagnostics)
        type(command_t), intent(in) :: command
        type(history_t), intent(inout) :: history
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: i

        if (.not. (command%given('t') .and. command%given('f'))) then
            call diagnostics%add(command%at, 'HISTORY table needs both t= and f=')
            return
        end if
        associate (t => command%values(command%value_of('t')), f => command%values(command%value_of('f')))
            if (size(t%numbers) /= size(f%numbers)) then
                call diagnostics%add(f%at, 't= has ' // to_text(size(t%numbers)) // &
                                     ' values, and f= has ' // to_text(size(f%numbers)))
                return
            end if
            do i = 2, size(t%numbers)
                if (t%numbers(i) > t%numbers(i - 1)) cycle
                call diagnostics%add(t%parts(i), 'times must increase, and ' // to_text(t%numbers(i), 12) // &
                                     ' is not beyond ' // to_text(t%numbers(i - 1), 12))
                return
            end do
            history%t = t%numbers
            history%f = f%numbers
        end associate
    end subroutine take_lists

    !> Read a text file of two columns; lines that start with # or ! and a heading are passed over. A path
    !> that is not absolute starts at the deck's folder.
    subroutine read_columns(command, folder, history, diagnostics)
        type(command_t), intent(in) :: command
        character(*), intent(in) :: folder
        type(history_t), intent(inout) :: history
        type(diagnostics_t), intent(inout) :: diagnostics
        type(error_t), allocatable :: error
        character(:), allocatable :: path, text
        integer :: n, first, last, line
        real(wp), allocatable :: columns(:, :)
        logical :: sound

        path = command%text('file')
        if (len(path) == 0) then
            call diagnostics%add(command%place('file'), 'the name of the file is empty')
            return
        end if
        if (path(1:1) /= '/') path = folder // path
        history%file = path
        call read_text(path, text, error)
        if (allocated(error)) then
            call diagnostics%add(command%place('file'), error%message)
            return
        end if
        allocate (columns(2, count_lines(text)))
        n = 0
        line = 0
        first = 1
        do while (first <= len(text))
            line = line + 1
            last = index(text(first:), newline) + first - 2
            if (last < first - 1) last = len(text)
            call read_row(text(first:last), columns, n, sound)
            if (.not. sound) then
                call diagnostics%add(command%place('file'), path // ':' // to_text(line) // &
                                     ': two numbers are expected, the first above those before it')
                return
            end if
            first = last + 2
        end do
        if (n == 0) then
            call diagnostics%add(command%place('file'), path // ' holds no numbers')
            return
        end if
        history%t = columns(1, :n)
        history%f = columns(2, :n)
    end subroutine read_columns

    !> Take the row of a line, if it is one: not empty, no comment, no heading above the numbers.
    subroutine read_row(line, columns, n, sound)
        character(*), intent(in) :: line
        real(wp), intent(inout) :: columns(:, :)
        integer, intent(inout) :: n
        logical, intent(out) :: sound
        integer, parameter :: longest = 256
        character(longest) :: row
        real(wp) :: pair(2)
        integer :: i, status

        sound = .true.
        row = ''
        do i = 1, min(len(line), longest)
            row(i:i) = line(i:i)
            if (scan(line(i:i), ',;' // achar(9) // achar(13)) > 0) row(i:i) = ' '
        end do
        row = adjustl(row)
        if (row == '' .or. scan(row(1:1), '#!') > 0) return
        sound = verify(trim(row), '0123456789+-.eEdD ') == 0 .and. len_trim(line) <= longest
        if (sound) then
            read (row, *, iostat=status) pair
            sound = status == 0 .and. all(abs(pair) <= huge(1.0_wp))
        else if (n == 0) then
            ! A heading.
            sound = scan(row(1:1), '0123456789+-.') == 0
            return
        end if
        if (sound .and. n > 0) sound = pair(1) > columns(1, max(1, n))
        if (.not. sound) return
        n = n + 1
        columns(:, n) = pair
    end subroutine read_row

    pure integer function count_lines(text) result(n)
        character(*), intent(in) :: text
        integer :: i

        n = 1
        do i = 1, len(text)
            if (text(i:i) == newline) n = n + 1
        end do
    end function count_lines

end module gb_build_history
