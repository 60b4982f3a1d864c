!> Numbers as people and Fortran write them: 10, .5, 1.35e-4, 1.35d-4.
module gb_number
    use gb_kinds, only: wp
    use gb_diagnostics, only: quoted
    use gb_text, only: to_text
    implicit none
    private

    public :: read_number, byte_at

    character(*), parameter, public :: digits = '0123456789'
    character(*), parameter, public :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
    integer, parameter :: longest_number = 400

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

        mantissa = number
        exponent = 0
        if (mark > 0) then
            mantissa = number(:mark - 1)
            exponent = bounded_integer(number(mark + 1:))
        end if
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
