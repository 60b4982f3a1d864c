!> Diagnostics as compilers give them: what is wrong, where in the user's own text, and what may have been
!> meant. A diagnostic keeps the span of the text it speaks of; line, column and the excerpt are worked out
!> when it is shown.
module gb_diagnostics
    use gb_text, only: to_text, newline
    implicit none
    private

    !> A stretch of the source text, by its first and last byte; `first` = 0 is nowhere.
    type, public :: span_t
        integer :: first = 0, last = -1
    end type span_t

    !> One finding.
    type, public :: diagnostic_t
        type(span_t) :: at                          !! the place in the source text
        character(:), allocatable :: message
        character(:), allocatable :: hint           !! a line of advice, or empty
        character(:), allocatable :: origin         !! where it comes from if not from the text: `--set jm=1`
        type(span_t) :: other                       !! a second place, such as a first definition
        character(:), allocatable :: note           !! what the second place is
    end type diagnostic_t

    !> All findings of one reading.
    type, public :: diagnostics_t
        private
        type(diagnostic_t), allocatable :: list(:)
        integer :: stored = 0
        integer :: total = 0
    contains
        procedure :: add
        procedure :: count => count_findings
        procedure :: is_full
        procedure :: clear
        procedure :: render
    end type diagnostics_t

    integer, parameter :: max_stored = 200          !! what a hopeless text may cost
    integer, parameter :: max_shown = 20
    integer, parameter :: whole_line = 160          !! source lines up to this many bytes are shown whole
    integer, parameter :: window = 60               !! of longer ones, this many characters on each side
    character(4), parameter :: indent = '    '

    public :: quoted, printable, utf8_mark

    character(3), parameter :: utf8_mark = char(239) // char(187) // char(191)    !! byte-order mark

contains

    !> Record a finding. `at` may be nowhere if `origin` tells where it comes from.
    pure subroutine add(self, at, message, hint, other, note, origin)
        class(diagnostics_t), intent(inout) :: self
        type(span_t), intent(in) :: at
        character(*), intent(in) :: message
        character(*), intent(in), optional :: hint, note, origin
        type(span_t), intent(in), optional :: other

        self%total = self%total + 1
        if (self%is_full()) return
        if (.not. allocated(self%list)) allocate (self%list(max_stored))
        self%stored = self%stored + 1
        associate (entry => self%list(self%stored))
            entry%at = at
            entry%message = message
            entry%hint = ''
            if (present(hint)) entry%hint = hint
            entry%origin = ''
            if (present(origin)) entry%origin = origin
            entry%note = ''
            if (present(other)) entry%other = other
            if (present(note)) entry%note = note
        end associate
    end subroutine add

    pure integer function count_findings(self)
        class(diagnostics_t), intent(in) :: self

        count_findings = self%total
    end function count_findings

    !> Whether further findings are only counted: then a suggestion is not worth looking for.
    pure logical function is_full(self)
        class(diagnostics_t), intent(in) :: self

        is_full = self%stored >= max_stored
    end function is_full

    pure subroutine clear(self)
        class(diagnostics_t), intent(inout) :: self

        if (allocated(self%list)) deallocate (self%list)
        self%stored = 0
        self%total = 0
    end subroutine clear

    !> The text shown to the user: the first findings in the order of the source, then how many more there
    !> are. Every line ends with a line feed; without findings the text is empty.
    pure function render(self, file, text) result(report)
        class(diagnostics_t), intent(in) :: self
        character(*), intent(in) :: file            !! name of the source as the user knows it
        character(*), intent(in) :: text            !! the whole source
        character(:), allocatable :: report
        integer :: order(self%stored)
        integer :: i, shown

        report = ''
        order = reading_order(self)
        shown = min(self%stored, max_shown)
        do i = 1, shown
            report = report // render_one(self%list(order(i)), file, text)
        end do
        if (self%total > shown) then
            report = report // printable(file) // ': ' // to_text(self%total - shown) // ' more error' // &
                     trim(merge('s', ' ', self%total - shown > 1)) // newline
        end if
    end function render

    !> Findings sorted by place (insertion sort: they come nearly sorted, and are few).
    pure function reading_order(self) result(order)
        class(diagnostics_t), intent(in) :: self
        integer :: order(self%stored)
        integer :: i, j, moved

        do i = 1, self%stored
            moved = i
            j = i - 1
            do while (j >= 1)
                if (self%list(order(j))%at%first <= self%list(moved)%at%first) exit
                order(j + 1) = order(j)
                j = j - 1
            end do
            order(j + 1) = moved
        end do
    end function reading_order

    pure function render_one(entry, file, text) result(report)
        type(diagnostic_t), intent(in) :: entry
        character(*), intent(in) :: file, text
        character(:), allocatable :: report

        if (len(entry%origin) > 0) then
            report = printable(entry%origin) // ': error: ' // printable(entry%message) // newline
        else
            report = render_label(entry%at, 'error: ' // entry%message, file, text)
        end if
        if (len(entry%hint) > 0) report = report // indent // printable(entry%hint) // newline
        if (len(entry%note) > 0) report = report // &
            render_label(entry%other, 'note: ' // entry%note, file, text)
    end function render_one

    !> file:line:column: message, the source line and the caret.
    pure function render_label(at, message, file, text) result(report)
        type(span_t), intent(in) :: at
        character(*), intent(in) :: message, file, text
        character(:), allocatable :: report
        integer :: line, line_first, line_last, column

        call find_line(text, at%first, line, line_first, line_last)
        column = 1 + count_characters(text(line_first:min(at%first - 1, len(text))))
        report = printable(file) // ':' // to_text(line) // ':' // to_text(column) // ': ' // &
            printable(message) // newline
        if (line_last >= line_first) report = report // render_excerpt(text, at, line_first, line_last)
    end function render_label

    !> Number and extent of the line that holds byte `place`, without line end and byte-order mark.
    pure subroutine find_line(text, place, line, line_first, line_last)
        character(*), intent(in) :: text
        integer, intent(in) :: place
        integer, intent(out) :: line, line_first, line_last
        integer :: i

        line = 1
        line_first = 1
        do i = 1, min(place - 1, len(text))
            if (text(i:i) == newline) then
                line = line + 1
                line_first = i + 1
            end if
        end do
        if (line == 1 .and. index(text(:min(3, len(text))), utf8_mark) == 1) line_first = 4
        line_last = line_first - 1
        do while (line_last < len(text))
            if (text(line_last + 1:line_last + 1) == newline) exit
            line_last = line_last + 1
        end do
        do while (line_last >= line_first)
            if (text(line_last:line_last) /= achar(13)) exit
            line_last = line_last - 1
        end do
    end subroutine find_line

    !> The source line, or a window of it, and the caret under the span.
    pure function render_excerpt(text, at, line_first, line_last) result(report)
        character(*), intent(in) :: text
        type(span_t), intent(in) :: at
        integer, intent(in) :: line_first, line_last
        character(:), allocatable :: report
        character(:), allocatable :: before, under, after, opening, closing
        integer :: first, last, left, right, reach

        first = max(line_first, min(at%first, line_last + 1))
        last = max(first - 1, min(at%last, line_last))
        reach = merge(huge(reach), window, line_last - line_first < whole_line)
        left = walk_back(text, first, line_first, reach)
        right = walk_on(text, first, line_last, reach)
        last = min(last, right)
        before = printable(text(left:first - 1))
        under = printable(text(first:last))
        after = printable(text(last + 1:right))
        opening = ''
        closing = ''
        if (left > line_first) opening = '...'
        if (right < line_last) closing = '...'
        report = indent // opening // before // under // after // closing // newline // &
                 indent // repeat(' ', len(opening)) // blanks_for(before) // '^' // &
                 repeat('~', max(0, count_characters(under) - 1)) // newline
    end function render_excerpt

    !> The byte at most `reach` characters before `from`, not before `bound`.
    pure integer function walk_back(text, from, bound, reach) result(place)
        character(*), intent(in) :: text
        integer, intent(in) :: from, bound, reach
        integer :: steps

        place = from
        steps = 0
        do while (place > bound .and. steps < reach)
            place = place - 1
            if (.not. is_continuation(text(place:place))) steps = steps + 1
        end do
    end function walk_back

    !> The last byte of the character at most `reach` characters after `from`, not beyond `bound`.
    pure integer function walk_on(text, from, bound, reach) result(place)
        character(*), intent(in) :: text
        integer, intent(in) :: from, bound, reach
        integer :: steps

        place = from - 1
        steps = 0
        do while (place < bound)
            if (.not. is_continuation(text(place + 1:place + 1))) then
                if (steps == reach) exit
                steps = steps + 1
            end if
            place = place + 1
        end do
    end function walk_on

    !> What must stand before the caret so that it falls under its text: tabs stay tabs, the rest is blank.
    pure function blanks_for(text) result(blanks)
        character(*), intent(in) :: text
        character(:), allocatable :: blanks
        integer :: i, n

        allocate (character(len(text)) :: blanks)
        n = 0
        do i = 1, len(text)
            if (is_continuation(text(i:i))) cycle
            n = n + 1
            blanks(n:n) = merge(text(i:i), ' ', text(i:i) == achar(9))
        end do
        blanks = blanks(:n)
    end function blanks_for

    !> Characters (code points) of a UTF-8 text.
    pure integer function count_characters(text) result(n)
        character(*), intent(in) :: text
        integer :: i

        n = 0
        do i = 1, len(text)
            if (.not. is_continuation(text(i:i))) n = n + 1
        end do
    end function count_characters

    pure logical function is_continuation(byte)
        character(1), intent(in) :: byte

        is_continuation = iand(ichar(byte), 192) == 128
    end function is_continuation

    !> The text with every control character but tabs replaced by `?`: nothing a terminal would obey.
    pure function printable(text) result(safe)
        character(*), intent(in) :: text
        character(:), allocatable :: safe
        integer :: i, n, code
        logical :: c1

        allocate (character(len(text)) :: safe)
        n = 0
        i = 0
        do while (i < len(text))
            i = i + 1
            n = n + 1
            code = ichar(text(i:i))
            safe(n:n) = text(i:i)
            if ((code < 32 .and. code /= 9) .or. code == 127) safe(n:n) = '?'
            c1 = code == 194 .and. i < len(text)
            if (c1) c1 = ichar(text(i + 1:i + 1)) < 160
            if (c1) then
                safe(n:n) = '?'
                i = i + 1
            end if
        end do
        safe = safe(:n)
    end function printable

    !> A user's text in quotes for a message, cut short where it is long.
    pure function quoted(text) result(short)
        character(*), intent(in) :: text
        character(:), allocatable :: short
        integer, parameter :: longest = 40
        integer :: last

        last = walk_on(text, 1, len(text), longest)
        short = "'" // text(:last)
        if (last < len(text)) short = short // '...'
        short = short // "'"
    end function quoted

end module gb_diagnostics
