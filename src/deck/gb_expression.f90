!> Expressions of the deck: text to postfix programs, by recursive descent. Constant parts are computed
!> while they are read, so that a division by zero is reported where it stands.
!>
!>     sum      = product  { (+|-) product }
!>     product  = signed   { (*|/) signed }
!>     signed   = { + | - } power
!>     power    = primary  [ ^ signed ]
!>     primary  = number | pi | parameter | variable | function ( sum { , sum } ) | ( sum )
module gb_expression
    use gb_kinds, only: wp, pi
    use gb_diagnostics, only: span_t, quoted
    use gb_lexer, only: skip_filler
    use gb_names, only: name_table_t, max_name
    use gb_number, only: read_number, byte_at, digits, letters
    use gb_program, only: program_t, instruction_t, op_constant, op_variable, op_add, op_subtract, &
        op_multiply, op_divide, op_power, op_negate, op_function, function_names, function_arguments
    use gb_text, only: lower_case, to_text, end_of_character
    implicit none
    private

    !> The parameters an expression may use.
    type, public :: parameters_t
        type(name_table_t) :: names
        real(wp), allocatable :: values(:)
        type(name_table_t) :: later             !! every parameter the whole deck defines, for better messages
        type(name_table_t) :: ghosts            !! what commands that were not understood may have defined
    end type parameters_t

    !> What became of an expression.
    type, public :: expression_t
        type(program_t) :: program
        logical :: constant = .true.            !! no free variable in it
        real(wp) :: value = 0.0_wp              !! of a constant expression
        logical :: sound = .true.
        type(span_t) :: at                      !! the place of the error, if there is one to report
        character(:), allocatable :: message    !! empty: a parameter it uses has been reported before
        character(:), allocatable :: hint
        character(:), allocatable :: unknown    !! a name that means nothing: something like it may be meant
        logical :: called = .false.             !! it stands before a parenthesis, as a function does
        type(span_t) :: other                   !! a second place, see `note`
        character(:), allocatable :: note
    end type expression_t

    !> The state of one reading.
    type :: reader_t
        integer :: place = 1, last = 0          !! the next byte that is not blank, and the last of all
        integer :: taken = 0                    !! the last byte read
        integer :: nesting = 0
        integer :: height = 0                   !! stack places in use
        type(instruction_t), allocatable :: code(:)
        integer :: n = 0
        character(1) :: variable = ' '
        type(expression_t) :: result
    end type reader_t

    !> A part of the expression that has been read.
    type :: operand_t
        logical :: constant = .true.
        type(span_t) :: at
    end type operand_t

    integer, parameter :: deepest = 100         !! nested parentheses, powers and calls

    public :: compile_expression, define_parameter, is_reserved

contains

    !> Compile the expression in text(at%first:at%last). `variable` is the letter of the free variable (x or
    !> t), or blank. An expression in vain is told in the result: nothing is reported here.
    pure subroutine compile_expression(text, at, parameters, variable, expression)
        character(*), intent(in) :: text
        type(span_t), intent(in) :: at
        type(parameters_t), intent(in) :: parameters
        character(1), intent(in) :: variable
        type(expression_t), intent(out) :: expression
        type(reader_t) :: reader
        type(operand_t) :: whole

        reader%last = at%last
        call advance(reader, text, at%first)
        reader%variable = variable
        reader%result%message = ''
        reader%result%hint = ''
        reader%result%note = ''
        reader%result%unknown = ''
        allocate (reader%code(8))
        call read_sum(reader, text, parameters, whole)
        if (reader%result%sound .and. reader%place <= reader%last) call complain_of_rest(reader, text)
        expression = reader%result
        if (.not. expression%sound) return
        expression%constant = whole%constant
        if (whole%constant) expression%value = reader%code(1)%value
        allocate (expression%program%code(reader%n))
        expression%program%code = reader%code(:reader%n)
        expression%program%depth = reader%result%program%depth
    end subroutine compile_expression

    !> Enter a parameter with its value.
    pure subroutine define_parameter(parameters, name, at, value, sound)
        type(parameters_t), intent(inout) :: parameters
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        real(wp), intent(in) :: value
        logical, intent(in) :: sound
        real(wp), allocatable :: grown(:)

        if (.not. allocated(parameters%values)) allocate (parameters%values(8))
        if (parameters%names%n == size(parameters%values)) then
            allocate (grown(2*parameters%names%n))
            grown(:parameters%names%n) = parameters%values
            call move_alloc(grown, parameters%values)
        end if
        call parameters%names%define(name, at, sound)
        parameters%values(parameters%names%n) = value
    end subroutine define_parameter

    !> Whether a name has a meaning of its own in expressions.
    pure logical function is_reserved(name)
        character(*), intent(in) :: name

        is_reserved = any(function_names == lower_case(name)) .or. &
            any(['pi', 'x ', 't '] == lower_case(name))
    end function is_reserved

    pure recursive subroutine read_sum(reader, text, parameters, whole)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        type(operand_t), intent(out) :: whole
        type(operand_t) :: right
        integer :: operation

        call read_product(reader, text, parameters, whole)
        do while (reader%result%sound)
            select case (peek(reader, text))
            case ('+')
                operation = op_add
            case ('-')
                operation = op_subtract
            case default
                return
            end select
            call advance(reader, text, reader%place + 1)
            call read_product(reader, text, parameters, right)
            if (reader%result%sound) call combine(reader, operation, whole, right)
        end do
    end subroutine read_sum

    pure recursive subroutine read_product(reader, text, parameters, whole)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        type(operand_t), intent(out) :: whole
        type(operand_t) :: right
        integer :: operation

        call read_signed(reader, text, parameters, whole)
        do while (reader%result%sound)
            select case (peek(reader, text))
            case ('*')
                operation = op_multiply
            case ('/')
                operation = op_divide
            case default
                return
            end select
            call advance(reader, text, reader%place + 1)
            call read_signed(reader, text, parameters, right)
            if (reader%result%sound) call combine(reader, operation, whole, right)
        end do
    end subroutine read_product

    pure recursive subroutine read_signed(reader, text, parameters, whole)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        type(operand_t), intent(out) :: whole
        logical :: negative
        integer :: first

        negative = .false.
        first = 0
        do while (scan(peek(reader, text), '+-') > 0)
            if (first == 0) first = reader%place
            negative = negative .neqv. text(reader%place:reader%place) == '-'
            call advance(reader, text, reader%place + 1)
        end do
        call read_power(reader, text, parameters, whole)
        if (.not. reader%result%sound) return
        if (first > 0) whole%at%first = first
        if (.not. negative) return
        if (whole%constant) then
            reader%code(reader%n)%value = -reader%code(reader%n)%value
        else
            call emit(reader, op_negate, 0.0_wp, 0)
        end if
    end subroutine read_signed

    pure recursive subroutine read_power(reader, text, parameters, whole)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        type(operand_t), intent(out) :: whole
        type(operand_t) :: exponent

        call read_primary(reader, text, parameters, whole)
        if (.not. reader%result%sound) return
        if (peek(reader, text) /= '^') return
        call enter(reader, span_t(reader%place, reader%place))
        call advance(reader, text, reader%place + 1)
        if (reader%result%sound) call read_signed(reader, text, parameters, exponent)
        if (reader%result%sound) call combine(reader, op_power, whole, exponent)
        reader%nesting = reader%nesting - 1
    end subroutine read_power

    pure recursive subroutine read_primary(reader, text, parameters, whole)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        type(operand_t), intent(out) :: whole
        character(1) :: next
        integer :: first

        next = peek(reader, text)
        first = reader%place
        if (first > reader%last) then
            call complain_of_end(reader, text)
        else if (scan(next, digits // '.') > 0) then
            call take_number(reader, text)
        else if (scan(next, letters) > 0) then
            call read_name(reader, text, parameters, whole)
        else if (next == '(') then
            call enter(reader, span_t(first, first))
            call advance(reader, text, first + 1)
            if (reader%result%sound) call read_sum(reader, text, parameters, whole)
            if (reader%result%sound) call close_parenthesis(reader, text, first)
            reader%nesting = reader%nesting - 1
        else if (next == '*' .and. text(max(1, first - 1):max(1, first - 1)) == '*') then
            call complain(reader, first - 1, first, "'**' is no operator", "write '^' for a power")
        else
            call complain(reader, first, end_of_character(text, first, reader%last), &
                'a value is expected before ' // &
                          quoted(text(first:end_of_character(text, first, reader%last))))
        end if
        whole%at = span_t(first, reader%taken)
    end subroutine read_primary

    pure subroutine close_parenthesis(reader, text, opened)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        integer, intent(in) :: opened

        if (peek(reader, text) == ')') then
            call advance(reader, text, reader%place + 1)
        else if (reader%place > reader%last) then
            call complain(reader, opened, opened, "this '(' is never closed")
        else
            call complain_of_rest(reader, text)
        end if
    end subroutine close_parenthesis

    !> A parameter, a variable, pi or a function with its arguments.
    pure recursive subroutine read_name(reader, text, parameters, whole)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        type(operand_t), intent(inout) :: whole
        integer :: first, length, number
        character(max_name) :: name

        first = reader%place
        length = verify(text(first:reader%last), letters // digits // '_') - 1
        if (length < 0) length = reader%last - first + 1
        call advance(reader, text, first + length)
        name = ''
        if (length <= max_name) name = lower_case(text(first:first + length - 1))
        do number = 1, size(function_names)
            if (function_names(number) /= name) cycle
            call read_call(reader, text, parameters, number, span_t(first, first + length - 1), whole)
            return
        end do
        if (name == 'pi') then
            call emit(reader, op_constant, pi, 1)
        else if (name /= '' .and. name == reader%variable) then
            whole%constant = .false.
            call emit(reader, op_variable, 0.0_wp, 1)
        else
            call read_parameter(reader, text, parameters, span_t(first, first + length - 1))
        end if
    end subroutine read_name

    pure subroutine read_parameter(reader, text, parameters, at)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        type(span_t), intent(in) :: at
        character(:), allocatable :: name
        integer :: number

        name = text(at%first:at%last)
        number = parameters%names%find(name)
        if (peek(reader, text) == '(') then
            call complain_of_call(reader, name, at, number > 0)
        else if (number == 0) then
            call complain_of_name(reader, name, at, parameters)
        else if (parameters%names%is_sound(number)) then
            call emit(reader, op_constant, parameters%values(number), 1)
        else
            reader%result%sound = .false.
        end if
    end subroutine read_parameter

    pure recursive subroutine read_call(reader, text, parameters, number, at, whole)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        type(parameters_t), intent(in) :: parameters
        integer, intent(in) :: number           !! of the function
        type(span_t), intent(in) :: at
        type(operand_t), intent(inout) :: whole
        type(operand_t) :: argument
        character(:), allocatable :: name
        integer :: opened, n

        name = trim(function_names(number))
        if (peek(reader, text) /= '(') then
            call complain(reader, at%first, at%last, quoted(name) // &
                          ' is a function: its argument follows in parentheses')
            return
        end if
        opened = reader%place
        call enter(reader, span_t(opened, opened))
        n = 0
        do while (reader%result%sound)
            call advance(reader, text, reader%place + 1)
            if (n == 0 .and. peek(reader, text) == ')') exit
            call read_sum(reader, text, parameters, argument)
            if (.not. reader%result%sound) return
            n = n + 1
            if (n == 1) then
                whole%constant = argument%constant
                whole%at = argument%at
            else if (function_arguments(number) == 2) then
                call combine(reader, op_function + number, whole, argument)
            end if
            if (peek(reader, text) /= ',') exit
        end do
        if (reader%result%sound) call close_parenthesis(reader, text, opened)
        reader%nesting = reader%nesting - 1
        if (.not. reader%result%sound) return
        if (n < function_arguments(number) .or. (function_arguments(number) == 1 .and. n > 1)) then
            call complain(reader, at%first, reader%taken, quoted(name) // ' takes ' // trim(merge( &
                          'one argument         ', 'two arguments or more', &
                          function_arguments(number) == 1)) // ', and has ' // to_text(n) // ' here')
        else if (function_arguments(number) == 1) then
            call apply(reader, number, span_t(at%first, reader%taken), whole%constant)
        end if
    end subroutine read_call

    !> Apply a function of one argument to the top of the stack.
    pure subroutine apply(reader, number, at, constant)
        type(reader_t), intent(inout) :: reader
        integer, intent(in) :: number
        type(span_t), intent(in) :: at
        logical, intent(in) :: constant
        type(program_t) :: small
        real(wp) :: value
        logical :: defined

        if (.not. constant) then
            call emit(reader, op_function + number, 0.0_wp, 0)
            return
        end if
        allocate (small%code(2))
        small%code(1) = reader%code(reader%n)
        small%code(2)%operation = op_function + number
        small%depth = 1
        call small%evaluate(0.0_wp, value, defined)
        if (defined) then
            reader%code(reader%n)%value = value
        else
            call complain(reader, at%first, at%last, trim(function_names(number)) // ' of ' // &
                          to_text(small%code(1)%value) // ' is not a finite number')
        end if
    end subroutine apply

    !> Apply an operation to the two values on top of the stack; the left operand becomes the whole.
    pure subroutine combine(reader, operation, left, right)
        type(reader_t), intent(inout) :: reader
        integer, intent(in) :: operation
        type(operand_t), intent(inout) :: left
        type(operand_t), intent(in) :: right
        type(program_t) :: small
        real(wp) :: value
        logical :: defined

        if (operation == op_divide .and. right%constant .and. &
            abs(reader%code(reader%n)%value) <= 0.0_wp) then
            call complain(reader, right%at%first, right%at%last, 'division by zero')
            return
        end if
        if (left%constant .and. right%constant) then
            allocate (small%code(3))
            small%code(1:2) = reader%code(reader%n - 1:reader%n)
            small%code(3)%operation = operation
            small%depth = 2
            call small%evaluate(0.0_wp, value, defined)
            if (.not. defined) then
                call complain_of_result(reader, operation, small%code(1)%value, small%code(2)%value, &
                                        span_t(left%at%first, right%at%last))
                return
            end if
            reader%n = reader%n - 1
            reader%height = reader%height - 1
            reader%code(reader%n)%value = value
        else
            call emit(reader, operation, 0.0_wp, -1)
        end if
        left%constant = left%constant .and. right%constant
        left%at%last = right%at%last
    end subroutine combine

    pure subroutine complain_of_result(reader, operation, left, right, at)
        type(reader_t), intent(inout) :: reader
        integer, intent(in) :: operation
        real(wp), intent(in) :: left, right
        type(span_t), intent(in) :: at

        if (operation == op_power .and. abs(left) <= 0.0_wp) then
            call complain(reader, at%first, at%last, 'zero to a negative power is not a finite number')
        else if (operation == op_power .and. left < 0.0_wp .and. abs(right - anint(right)) > 0.0_wp) then
            call complain(reader, at%first, at%last, &
                'a negative number has no power that is not a whole number')
        else
            call complain(reader, at%first, at%last, 'the result is not a finite number')
        end if
    end subroutine complain_of_result

    pure subroutine take_number(reader, text)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        character(:), allocatable :: message
        real(wp) :: value
        integer :: first, next

        first = reader%place
        call read_number(text(:reader%last), first, next, value, message)
        call advance(reader, text, next)
        if (len(message) > 0) then
            call complain(reader, first, next - 1, message)
        else
            call emit(reader, op_constant, value, 1)
        end if
    end subroutine take_number

    !> Go on to byte `place`, or to what follows the blanks there.
    pure subroutine advance(reader, text, place)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        integer, intent(in) :: place

        reader%taken = place - 1
        reader%place = place
        call skip_filler(text, reader%last, reader%place, commas=.false.)
    end subroutine advance

    !> The next character that is not blank; blank at the end.
    pure character(1) function peek(reader, text)
        type(reader_t), intent(in) :: reader
        character(*), intent(in) :: text

        peek = byte_at(text(:reader%last), reader%place)
    end function peek

    pure subroutine enter(reader, at)
        type(reader_t), intent(inout) :: reader
        type(span_t), intent(in) :: at

        reader%nesting = reader%nesting + 1
        if (reader%nesting > deepest) call complain(reader, at%first, at%last, 'nested deeper than ' // &
                                                    to_text(deepest) // ' levels')
    end subroutine enter

    pure subroutine emit(reader, operation, value, growth)
        type(reader_t), intent(inout) :: reader
        integer, intent(in) :: operation
        real(wp), intent(in) :: value
        integer, intent(in) :: growth           !! of the stack
        type(instruction_t), allocatable :: grown(:)

        if (reader%n == size(reader%code)) then
            allocate (grown(2*reader%n))
            grown(:reader%n) = reader%code
            call move_alloc(grown, reader%code)
        end if
        reader%n = reader%n + 1
        reader%code(reader%n) = instruction_t(operation, value)
        reader%height = reader%height + growth
        reader%result%program%depth = max(reader%result%program%depth, reader%height)
    end subroutine emit

    pure subroutine complain(reader, first, last, message, hint)
        type(reader_t), intent(inout) :: reader
        integer, intent(in) :: first, last
        character(*), intent(in) :: message
        character(*), intent(in), optional :: hint

        if (.not. reader%result%sound) return
        reader%result%sound = .false.
        reader%result%at = span_t(first, last)
        reader%result%message = message
        if (present(hint)) reader%result%hint = hint
    end subroutine complain

    !> The expression stops where a value should follow.
    pure subroutine complain_of_end(reader, text)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        integer :: before

        before = reader%last
        if (before < 1 .or. before > len(text)) then
            call complain(reader, 1, 1, 'a value is expected')
        else
            call complain(reader, before, before, 'a value is expected after ' // &
                quoted(text(before:before)))
        end if
    end subroutine complain_of_end

    !> Something follows that is no part of the expression.
    pure subroutine complain_of_rest(reader, text)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: text
        integer :: place, last

        place = reader%place
        last = end_of_character(text, place, reader%last)
        if (text(place:place) == ')') then
            call complain(reader, place, place, "')' without '('")
        else if (text(place:place) == ',') then
            call complain(reader, place, place, "a ',' stands only between the arguments of a function")
        else if (scan(text(place:place), letters // digits // '.(') > 0) then
            call complain(reader, place, last, 'an operator is expected before ' // &
                quoted(text(place:last)))
        else
            call complain(reader, place, last, 'unexpected ' // quoted(text(place:last)) // &
                ' in an expression')
        end if
    end subroutine complain_of_rest

    pure subroutine complain_of_call(reader, name, at, is_parameter)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        logical, intent(in) :: is_parameter

        if (is_parameter) then
            call complain(reader, at%first, at%last, quoted(name) // ' is a parameter, not a function', &
                          "write '*' to multiply")
        else
            call complain(reader, at%first, at%last, 'unknown function ' // quoted(name))
            reader%result%unknown = name
            reader%result%called = .true.
        end if
    end subroutine complain_of_call

    pure subroutine complain_of_name(reader, name, at, parameters)
        type(reader_t), intent(inout) :: reader
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        type(parameters_t), intent(in) :: parameters
        integer :: later

        later = parameters%later%find(name)
        if (parameters%ghosts%find(name) > 0) then
            reader%result%sound = .false.
        else if (name == 'x' .or. name == 'X') then
            call complain(reader, at%first, at%last, "'x' has no value here", &
                          "expressions of x stand in INITIAL alone")
        else if (name == 't' .or. name == 'T') then
            call complain(reader, at%first, at%last, "'t' has no value here", &
                          "expressions of t stand in HISTORY formula alone")
        else if (later > 0) then
            call complain(reader, at%first, at%last, 'parameter ' // quoted(name) // &
                ' is used before it is defined')
            reader%result%other = parameters%later%span(later)
            reader%result%note = 'defined here'
        else
            call complain(reader, at%first, at%last, 'undefined parameter ' // quoted(name))
            reader%result%unknown = name
        end if
    end subroutine complain_of_name

end module gb_expression
