!> Small text helpers: case, numbers as people write them, and the nearest of a set of names.
module gb_text
    use gb_kinds, only: wp
    implicit none
    private

    public :: lower_case, upper_case, to_text, exact_text, hexadecimal, edit_distance, &
        nearest_name, end_of_character

    character(1), parameter, public :: newline = achar(10)

    !> The shortest plain text of a number: 10, 0.5, 1.35e-4.
    interface to_text
        module procedure integer_to_text, real_to_text
    end interface to_text

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

    pure function integer_to_text(number) result(text)
        integer, intent(in) :: number
        character(:), allocatable :: text
        character(24) :: buffer

        write (buffer, '(i0)') number
        text = trim(buffer)
    end function integer_to_text

    !> A real with `digits` significant digits (default 6), trailing zeros dropped, as %g of C writes it.
    pure function real_to_text(number, digits) result(text)
        real(wp), intent(in) :: number
        integer, intent(in), optional :: digits
        character(:), allocatable :: text
        character(48) :: buffer
        character(:), allocatable :: sign, figures
        integer :: nd, exponent, mark

        nd = 6
        if (present(digits)) nd = max(1, min(17, digits))
        if (.not. abs(number) <= huge(number)) then
            write (buffer, *) number
            text = trim(adjustl(buffer))
            return
        end if
        write (buffer, scientific_layout(nd)) number
        buffer = adjustl(buffer)
        mark = index(buffer, 'E')
        exponent = small_integer(buffer(mark + 2:mark + 4))
        if (buffer(mark + 1:mark + 1) == '-') exponent = -exponent
        sign = ''
        if (buffer(1:1) == '-') sign = '-'
        figures = buffer(len(sign) + 1:len(sign) + 1) // buffer(len(sign) + 3:mark - 1)
        if (exponent < -3 .or. exponent >= max(nd, 6)) then
            text = without_zeros(buffer(:mark - 1)) // 'e' // integer_to_text(exponent)
        else if (exponent < 0) then
            text = sign // without_zeros('0.' // repeat('0', -exponent - 1) // figures)
        else if (exponent < nd) then
            text = sign // without_zeros(figures(:exponent + 1) // '.' // figures(exponent + 2:))
        else
            write (buffer, '(f40.0)') number
            text = without_zeros(trim(adjustl(buffer)))
        end if
    end function real_to_text

    !> The format of a real with so many significant digits.
    pure function scientific_layout(digits) result(layout)
        integer, intent(in) :: digits           !! 1 to 17
        character(11) :: layout

        layout = '(es32.' // achar(iachar('0') + (digits - 1)/10) // achar(iachar('0') &
            + modulo(digits - 1, 10)) // 'e3)'
    end function scientific_layout

    !> A number of digits only.
    pure integer function small_integer(digits) result(number)
        character(*), intent(in) :: digits
        integer :: i

        number = 0
        do i = 1, len(digits)
            number = 10*number + iachar(digits(i:i)) - iachar('0')
        end do
    end function small_integer

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

    pure function without_zeros(digits) result(short)
        character(*), intent(in) :: digits
        character(:), allocatable :: short
        integer :: last

        last = len(digits)
        if (index(digits, '.') > 0) then
            do while (digits(last:last) == '0')
                last = last - 1
            end do
            if (digits(last:last) == '.') last = last - 1
        end if
        short = digits(:last)
        if (len(short) == 0 .or. short == '-') short = '0'
    end function without_zeros

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
