!> Small text helpers: case, numbers as people write them, and the nearest of a set of names.
module gb_text
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int
    use gb_kinds, only: wp, i8
    implicit none
    private

    public :: lower_case, upper_case, to_text, exact_text, hexadecimal, edit_distance, &
        nearest_name, end_of_character, shell_word

    character(1), parameter, public :: newline = achar(10)

    !> The shortest plain text of a number: 10, 0.5, 1.35e-4.
    !>
    !> Threads that solve side by side write texts too. gfortran keeps the length of a result that is
    !> `character(:), allocatable` in one place for all of them, so what they call has results of known
    !> length.
    interface to_text
        module procedure integer_to_text, real_to_text, digits_to_text
    end interface to_text

    integer, parameter :: usual_digits = 6
    integer, parameter :: most_digits = 17      !! that tell a number from its neighbours

    interface
        pure subroutine c_figures(number, count, figures, exponent) bind(c, name="gb_figures")
            import :: c_char, c_double, c_int
            real(c_double), value, intent(in) :: number
            integer(c_int), value, intent(in) :: count
            character(kind=c_char), intent(inout) :: figures(*)
            integer(c_int), intent(out) :: exponent
        end subroutine c_figures
    end interface

contains

    pure function lower_case(text) result(lower)
        character(*), intent(in) :: text
        character(len(text)) :: lower
        integer :: i, code

        do i = 1, len(text)
            code = iachar(text(i:i))
            if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
            lower(i:i) = achar(code)
        end do
    end function lower_case

    !> A text as one word of a command line, in quotes where the shell would make something else of it.
    pure function shell_word(text) result(word)
        character(*), intent(in) :: text
        character(:), allocatable :: word
        character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz', marks = '0123456789._/+-=:,@%'
        character(*), parameter :: quote = achar(39)
        integer :: i

        word = text
        if (len(text) > 0 .and. verify(lower_case(text), letters // marks) == 0) return
        word = quote
        do i = 1, len(text)
            if (text(i:i) == quote) then
                word = word // quote // '\' // quote // quote
            else
                word = word // text(i:i)
            end if
        end do
        word = word // quote
    end function shell_word

    pure function upper_case(text) result(upper)
        character(*), intent(in) :: text
        character(len(text)) :: upper
        integer :: i, code

        do i = 1, len(text)
            code = iachar(text(i:i))
            if (code >= iachar('a') .and. code <= iachar('z')) code = code - 32
            upper(i:i) = achar(code)
        end do
    end function upper_case

    pure integer function integer_length(number) result(length)
        integer, intent(in) :: number
        integer(i8) :: rest

        length = merge(2, 1, number < 0)
        rest = abs(int(number, i8))/10
        do while (rest > 0)
            length = length + 1
            rest = rest/10
        end do
    end function integer_length

    pure integer function real_length(number, digits) result(length)
        real(wp), intent(in) :: number
        integer, intent(in) :: digits

        length = len_trim(written(number, digits))
    end function real_length

    pure function integer_to_text(number) result(text)
        integer, intent(in) :: number
        character(integer_length(number)) :: text
        integer(i8) :: rest
        integer :: i

        text = '-'
        rest = abs(int(number, i8))
        do i = len(text), 1, -1
            text(i:i) = achar(iachar('0') + int(modulo(rest, 10_i8)))
            rest = rest/10
            if (rest == 0) exit
        end do
    end function integer_to_text

    !> A real with 6 significant digits, trailing zeros dropped, as %g of C writes it.
    pure function real_to_text(number) result(text)
        real(wp), intent(in) :: number
        character(real_length(number, usual_digits)) :: text

        text = written(number, usual_digits)
    end function real_to_text

    !> The same with another number of significant digits.
    pure function digits_to_text(number, digits) result(text)
        real(wp), intent(in) :: number
        integer, intent(in) :: digits
        character(real_length(number, digits)) :: text

        text = written(number, digits)
    end function digits_to_text

    !> The number on the left of a field that is long enough for all.
    pure function written(number, digits) result(text)
        real(wp), intent(in) :: number
        integer, intent(in) :: digits
        character(48) :: text
        character(most_digits) :: figures
        character(:), allocatable :: minus
        integer :: nd, exponent

        nd = max(1, min(most_digits, digits))
        if (.not. abs(number) <= huge(number)) then
            write (text, *) number
            text = adjustl(text)
            return
        end if
        minus = ''
        if (sign(1.0_wp, number) < 0.0_wp) minus = '-'
        call find_figures(number, nd, figures, exponent)
        if (exponent < -3 .or. exponent >= max(nd, 6)) then
            text = minus // figures(1:1) // '.' // figures(2:)
            call drop_zeros(text)
            text = trim(text) // 'e' // to_text(exponent)
        else if (exponent < 0) then
            text = minus // '0.' // repeat('0', -exponent - 1) // figures
            call drop_zeros(text)
        else
            ! All figures before the point are written, also where fewer were asked for. Rounded to these the
            ! number may have been a power of ten that it is below.
            if (exponent >= nd) then
                nd = exponent + 1
                call find_figures(number, nd, figures, exponent)
                if (exponent < nd - 1) call find_figures(number, nd - 1, figures, exponent)
            end if
            text = minus // figures(:exponent + 1) // '.' // figures(exponent + 2:)
            call drop_zeros(text)
        end if
    end function written

    !> The first significant figures of a finite number, rounded, with zeros behind them, and the power of ten
    !> of the first one.
    pure subroutine find_figures(number, n, figures, exponent)
        real(wp), intent(in) :: number
        integer, intent(in) :: n
        character(most_digits), intent(out) :: figures
        integer, intent(out) :: exponent
        character(kind=c_char) :: found(most_digits)

        found = '0'
        call c_figures(real(number, c_double), int(n, c_int), found, exponent)
        figures = transfer(found, figures)
    end subroutine find_figures

    !> Zeros at the end behind a point mean nothing.
    pure subroutine drop_zeros(text)
        character(*), intent(inout) :: text
        integer :: last

        last = len_trim(text)
        if (index(text, '.') > 0) then
            last = verify(text(:last), '0', back=.true.)
            if (text(last:last) == '.') last = last - 1
        end if
        text = text(:last)
        if (text == '' .or. text == '-') text = '0'
    end subroutine drop_zeros

    !> The shortest plain text that reads back as the same number.
    pure function exact_text(number) result(text)
        real(wp), intent(in) :: number
        character(:), allocatable :: text
        character(48) :: buffer
        real(wp) :: again
        integer :: digits, status

        do digits = 15, 17
            text = to_text(number, digits)
            ! Rounded up, the largest numbers could not be read.
            if (abs(number) > 0.1_wp*huge(number) .and. digits < 17) cycle
            buffer = text
            read (buffer, *, iostat=status) again
            if (status == 0 .and. .not. abs(again - number) > 0.0_wp) return
        end do
    end function exact_text

    !> A byte as people write it in hexadecimal: 0x1F.
    pure function hexadecimal(byte) result(text)
        character(1), intent(in) :: byte
        character(4) :: text

        write (text, '("0x",z2.2)') ichar(byte)
    end function hexadecimal

    !> Edits (insert, delete, replace, swap two neighbours) that turn one name into the other
    !> (Damerau-Levenshtein).
    pure function edit_distance(from, into) result(distance)
        character(*), intent(in) :: from, into
        integer :: distance
        integer :: cost(0:len(from), 0:len(into))
        integer :: i, j, change

        do i = 0, len(from)
            cost(i, 0) = i
        end do
        do j = 0, len(into)
            cost(0, j) = j
        end do
        do j = 1, len(into)
            do i = 1, len(from)
                change = merge(0, 1, from(i:i) == into(j:j))
                cost(i, j) = min(cost(i - 1, j) + 1, cost(i, j - 1) + 1, cost(i - 1, j - 1) + change)
                if (i > 1 .and. j > 1) then
                    if (from(i:i) == into(j - 1:j - 1) .and. from(i - 1:i - 1) == into(j:j)) then
                        cost(i, j) = min(cost(i, j), cost(i - 2, j - 2) + 1)
                    end if
                end if
            end do
        end do
        distance = cost(len(from), len(into))
    end function edit_distance

    !> The candidate a user most likely meant, or an empty text when none is near: at most a third of the
    !> longer name may differ. Names longer than 64 characters are no misspelling.
    pure function nearest_name(name, candidates) result(nearest)
        character(*), intent(in) :: name
        character(*), intent(in) :: candidates(:)
        character(:), allocatable :: nearest
        character(:), allocatable :: wanted, candidate
        integer :: i, distance, best

        nearest = ''
        if (len_trim(name) == 0 .or. len_trim(name) > 64) return
        wanted = trim(lower_case(name))
        best = huge(best)
        do i = 1, size(candidates)
            candidate = trim(lower_case(candidates(i)))
            distance = edit_distance(wanted, candidate)
            if (3*distance <= max(len(wanted), len(candidate)) .and. distance < best) then
                best = distance
                nearest = trim(candidates(i))
            end if
        end do
    end function nearest_name

    !> Last byte of the UTF-8 character that starts at `first`.
    pure integer function end_of_character(text, first, bound) result(last)
        character(*), intent(in) :: text
        integer, intent(in) :: first, bound

        last = first
        do while (last < bound)
            if (iand(ichar(text(last + 1:last + 1)), 192) /= 128) exit
            last = last + 1
        end do
    end function end_of_character

end module gb_text
