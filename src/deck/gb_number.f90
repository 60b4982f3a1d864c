!> Numbers as people and Fortran write them: 10, .5, 1.35e-4, 1.35d-4.
module gb_number
    use gb_kinds, only: wp, i8
    use gb_diagnostics, only: quoted
    use gb_text, only: to_text
    implicit none
    private

    public :: read_number, byte_at

    character(*), parameter, public :: digits = '0123456789'
    character(*), parameter, public :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
    integer, parameter :: longest_number = 400
    real(wp), parameter :: tens(0:22) = [1.0e0_wp, 1.0e1_wp, 1.0e2_wp, 1.0e3_wp, 1.0e4_wp, 1.0e5_wp, &
        1.0e6_wp, &
        1.0e7_wp, 1.0e8_wp, 1.0e9_wp, 1.0e10_wp, 1.0e11_wp, 1.0e12_wp, 1.0e13_wp, 1.0e14_wp, 1.0e15_wp, &
        1.0e16_wp, 1.0e17_wp, 1.0e18_wp, 1.0e19_wp, 1.0e20_wp, 1.0e21_wp, 1.0e22_wp]

contains

    !> Read the number that starts at byte `first`; `next` is the byte behind it. Where it is none, `message`
    !> says why and text(first:next - 1) is what it speaks of; else `message` is empty.
    pure subroutine read_number(text, first, next, value, message)
        character(*), intent(in) :: text
        integer, intent(in) :: first
        integer, intent(out) :: next
        real(wp), intent(out) :: value
        character(:), allocatable, intent(out) :: message
        integer :: exponent_at
        logical :: fits

        value = 0.0_wp
        message = ''
        next = after_digits(text, first)
        if (byte_at(text, next) == '.') next = after_digits(text, next + 1)
        exponent_at = 0
        if (scan(byte_at(text, next), 'eEdD') > 0) then
            exponent_at = next - first + 1
            next = next + 1
            if (scan(byte_at(text, next), '+-') > 0) next = next + 1
            if (after_digits(text, next) == next) then
                message = 'the exponent has no digits'
                return
            end if
            next = after_digits(text, next)
        end if
        if (scan(byte_at(text, next), letters // digits // '._') > 0) then
            do while (scan(byte_at(text, next), letters // digits // '._') > 0)
                next = next + 1
            end do
            message = quoted(text(first:next - 1)) // ' is not a number'
        else if (text(first:next - 1) == '.') then
            message = "'.' is not a number"
        else if (next - first > longest_number) then
            message = 'this number has more than ' // to_text(longest_number) // ' characters'
        else
            call convert(text(first:next - 1), exponent_at, value, fits)
            if (.not. fits) message = quoted(text(first:next - 1)) // ' is beyond the largest number, ' // &
                to_text(huge(value), 4)
        end if
    end subroutine read_number

    !> Value of a well-formed number. The decimal exponent is looked at first: the runtime library would
    !> overflow.
    pure subroutine convert(number, mark, value, fits)
        character(*), intent(in) :: number
        integer, intent(in) :: mark             !! place of the exponent's letter, 0 without
        real(wp), intent(out) :: value
        logical, intent(out) :: fits
        character(17), parameter :: largest = '17976931348623157'      !! digits of huge(value)
        character(:), allocatable :: mantissa
        character(longest_number + 16) :: buffer
        integer :: exponent, leading, point, first, status

        exponent = 0
        if (mark > 0) exponent = bounded_integer(number(mark + 1:))
        call convert_short(number(:merge(mark - 1, len(number), mark > 0)), exponent, value, fits)
        if (fits) return
        mantissa = number
        if (mark > 0) mantissa = number(:mark - 1)
        value = 0.0_wp
        fits = .true.
        first = verify(mantissa, '0.')
        if (first == 0) return
        point = index(mantissa // '.', '.')
        leading = exponent + merge(point - first - 1, point - first, first < point)
        fits = leading <= range(value) + 1
        if (leading == range(value) + 1) fits = leading_digits(mantissa(first:)) <= largest
        if (.not. fits .or. leading < -range(value) - 20) return
        buffer = mantissa // 'e' // to_text(exponent)
        read (buffer, *, iostat=status) value
        fits = status == 0
    end subroutine convert

    !> A number of few digits, as nearly all are: it is a whole number times or over a power of ten, both of
    !> which are exact, so that the one rounding of the product makes it the nearest to what is written.
    pure subroutine convert_short(mantissa, exponent, value, is_short)
        character(*), intent(in) :: mantissa        !! digits with or without a point
        integer, intent(in) :: exponent
        real(wp), intent(inout) :: value
        logical, intent(out) :: is_short
        integer, parameter :: most_digits = 15, most_tens = 22
        integer :: i, digit, power
        integer(i8) :: whole

        is_short = len(mantissa) <= most_digits
        if (.not. is_short) return
        whole = 0
        power = exponent
        do i = 1, len(mantissa)
            digit = ichar(mantissa(i:i)) - ichar('0')
            if (digit >= 0) whole = 10*whole + digit
        end do
        i = index(mantissa, '.')
        if (i > 0) power = power - (len(mantissa) - i)
        is_short = abs(power) <= most_tens
        if (.not. is_short) return
        value = real(whole, wp)
        if (power >= 0) then
            value = value*tens(power)
        else
            value = value/tens(-power)
        end if
    end subroutine convert_short

    !> The first 17 digits of a mantissa, its point left out.
    pure character(17) function leading_digits(mantissa)
        character(*), intent(in) :: mantissa
        integer :: i, n

        leading_digits = repeat('0', 17)
        n = 0
        do i = 1, len(mantissa)
            if (mantissa(i:i) == '.') cycle
            if (n == 17) exit
            n = n + 1
            leading_digits(n:n) = mantissa(i:i)
        end do
    end function leading_digits

    !> A whole number whose size beyond a million does not matter.
    pure integer function bounded_integer(text) result(number)
        character(*), intent(in) :: text
        integer :: i

        number = 0
        do i = 1, len(text)
            if (scan(text(i:i), digits) > 0) number = min(1000000, 10*number + index(digits, text(i:i)) - 1)
        end do
        if (text(1:1) == '-') number = -number
    end function bounded_integer

    pure integer function after_digits(text, first) result(place)
        character(*), intent(in) :: text
        integer, intent(in) :: first

        place = first
        do while (scan(byte_at(text, place), digits) > 0)
            place = place + 1
        end do
    end function after_digits

    !> The byte at `place`, blank beyond the end.
    pure character(1) function byte_at(text, place)
        character(*), intent(in) :: text
        integer, intent(in) :: place

        byte_at = ' '
        if (place <= len(text)) byte_at = text(place:place)
    end function byte_at

end module gb_number
