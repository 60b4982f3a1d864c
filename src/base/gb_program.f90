!> Compiled expressions: a short postfix program evaluated on a stack. The deck's reader compiles the text;
!> histories and initial conditions keep the program and evaluate it while the model runs.
module gb_program
    use gb_kinds, only: wp
    implicit none
    private

    !> Operations of a program. `op_constant` pushes the instruction's value, `op_variable` the free variable.
    integer, parameter, public :: op_constant = 1, op_variable = 2, op_add = 3, op_subtract = 4, &
        op_multiply = 5, op_divide = 6, op_power = 7, op_negate = 8, op_function = 100

    !> Names of the functions; function number i is operation op_function + i.
    character(5), parameter, public :: function_names(13) = [character(5) :: 'sqrt', 'exp', 'log', 'log10', &
        'sin', 'cos', 'tan', 'asin', 'acos', 'atan', 'abs', 'min', 'max']
    !> How many arguments each function takes.
    integer, parameter, public :: function_arguments(13) = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2]

    type, public :: instruction_t
        integer :: operation = op_constant
        real(wp) :: value = 0.0_wp
    end type instruction_t

    !> A compiled expression of one free variable at most.
    type, public :: program_t
        type(instruction_t), allocatable :: code(:)
        integer :: depth = 0    !! stack places it needs
    contains
        procedure :: evaluate
    end type program_t

contains

    !> The program's value at `x`. `defined` is false where the value is not a finite number (a division by
    !> zero, the root of a negative number, an overflow): then the value is 0 and no arithmetic trap has been
    !> raised.
    pure subroutine evaluate(self, x, value, defined)
        class(program_t), intent(in) :: self
        real(wp), intent(in) :: x            !! the free variable (x or t)
        real(wp), intent(out) :: value
        logical, intent(out) :: defined
        real(wp) :: stack(max(1, self%depth))
        integer :: i, top, operation

        top = 0
        value = 0.0_wp
        defined = .true.
        do i = 1, size(self%code)
            operation = self%code(i)%operation
            select case (operation)
            case (op_constant)
                top = top + 1
                stack(top) = self%code(i)%value
            case (op_variable)
                top = top + 1
                stack(top) = x
            case (op_negate)
                stack(top) = -stack(top)
            case default
                if (takes_two(operation)) then
                    top = top - 1
                    call apply_two(operation, stack(top), stack(top + 1), defined)
                else
                    call apply_one(operation, stack(top), defined)
                end if
                if (.not. defined) return
            end select
        end do
        value = stack(1)
    end subroutine evaluate

    pure function takes_two(operation) result(two)
        integer, intent(in) :: operation
        logical :: two

        if (operation > op_function) then
            two = function_arguments(operation - op_function) == 2
        else
            two = .true.
        end if
    end function takes_two

    !> a <- a op b, told undefined before the machine would trap.
    pure subroutine apply_two(operation, a, b, defined)
        integer, intent(in) :: operation
        real(wp), intent(inout) :: a
        real(wp), intent(in) :: b
        logical, intent(out) :: defined
        real(wp), parameter :: log_huge = log(huge(1.0_wp))

        defined = .true.
        select case (operation)
        case (op_add)
            defined = abs(0.5_wp*a + 0.5_wp*b) < 0.5_wp*huge(a)
            if (defined) a = a + b
        case (op_subtract)
            defined = abs(0.5_wp*a - 0.5_wp*b) < 0.5_wp*huge(a)
            if (defined) a = a - b
        case (op_multiply)
            if (abs(a) > 1.0_wp) defined = abs(b) < huge(a)/abs(a)
            if (defined) a = a*b
        case (op_divide)
            defined = abs(b) > 0.0_wp
            if (defined .and. abs(b) < 1.0_wp) defined = abs(a) < huge(a)*abs(b)
            if (defined) a = a/b
        case (op_power)
            call raise_to_power(a, b, log_huge, defined)
        case default
            select case (trim(function_names(operation - op_function)))
            case ('min')
                a = min(a, b)
            case ('max')
                a = max(a, b)
            end select
        end select
    end subroutine apply_two

    pure subroutine raise_to_power(a, b, log_huge, defined)
        real(wp), intent(inout) :: a
        real(wp), intent(in) :: b, log_huge
        logical, intent(out) :: defined
        logical :: whole
        real(wp) :: magnitude

        whole = abs(b - anint(b)) <= 0.0_wp
        if (abs(a) <= 0.0_wp) then
            defined = b >= 0.0_wp
            if (defined) a = merge(0.0_wp, 1.0_wp, b > 0.0_wp)
            return
        end if
        defined = a > 0.0_wp .or. whole
        if (.not. defined) return
        ! The bound on b keeps the product from overflowing; it is far beyond what decides.
        magnitude = min(abs(b), 1.0e300_wp)*abs(log(abs(a)))
        defined = magnitude < log_huge .or. (b < 0.0_wp .neqv. abs(a) < 1.0_wp)
        if (.not. defined) return
        if (magnitude >= log_huge) then
            a = 0.0_wp
        else if (whole .and. abs(b) < 1.0e9_wp) then
            a = a**nint(b)
        else if (a > 0.0_wp) then
            a = a**b
        else
            ! A huge whole number: its parity is that of the nearest even number's distance.
            a = abs(a)**b*merge(1.0_wp, -1.0_wp, modulo(b, 2.0_wp) <= 0.0_wp)
        end if
    end subroutine raise_to_power

    pure subroutine apply_one(operation, a, defined)
        integer, intent(in) :: operation
        real(wp), intent(inout) :: a
        logical, intent(out) :: defined

        defined = .true.
        select case (trim(function_names(operation - op_function)))
        case ('sqrt')
            defined = a >= 0.0_wp
            if (defined) a = sqrt(a)
        case ('exp')
            defined = a < log(huge(a))
            if (defined) a = merge(0.0_wp, exp(max(a, -700.0_wp)), a < -700.0_wp)
        case ('log')
            defined = a > 0.0_wp
            if (defined) a = log(a)
        case ('log10')
            defined = a > 0.0_wp
            if (defined) a = log10(a)
        case ('sin')
            a = sin(a)
        case ('cos')
            a = cos(a)
        case ('tan')
            a = tan(a)
        case ('asin')
            defined = abs(a) <= 1.0_wp
            if (defined) a = asin(a)
        case ('acos')
            defined = abs(a) <= 1.0_wp
            if (defined) a = acos(a)
        case ('atan')
            a = atan(a)
        case ('abs')
            a = abs(a)
        end select
    end subroutine apply_one

end module gb_program
