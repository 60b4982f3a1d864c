!> What a unit test may use: assertions, exceptions, fixtures and parameters.
!!
!! This module stands in for pFUnit's module of the same name where pFUnit is not installed, and offers
!! the part of it the unit tests are written in. `pf_preprocess.py` turns the directives of a .pf file
!! into calls of the procedures below. It wraps the two operands of a comparison in `funit_operand`, so
!! that one procedure serves all types and ranks. Names that pFUnit does not have begin with `funit_`.
module funit
    use, intrinsic :: iso_fortran_env, only: int64, real64
    implicit none
    private

    public :: TestCase, ParameterizedTestCase, AbstractTestParameter
    public :: SourceLocation, throw, catch, anyExceptions
    public :: assertEqual, assertNotEqual, assertLessThan, assertLessThanOrEqual
    public :: assertGreaterThan, assertGreaterThanOrEqual, assertRelativelyEqual
    public :: assertTrue, assertFalse, assertAll, assertAny, assertNone, assertNotAll
    public :: assertIsNaN, assertIsFinite, assertFail, assertExceptionRaised
    public :: funit_operand, funit_take_failures

    !> The line of a .pf file an assertion stands on; line 0 means unknown.
    type :: SourceLocation
        character(len=64) :: file = ''
        integer :: line = 0
    end type SourceLocation

    !> A fixture: a fresh object is set up for every test of a file and torn down after it.
    type, abstract :: TestCase
    contains
        procedure :: setUp => do_nothing
        procedure :: tearDown => do_nothing
    end type TestCase

    !> One of the values a parameterised test is run with.
    type, abstract :: AbstractTestParameter
    contains
        !> Text that tells this value from the others in the name of the test.
        procedure(text_of_parameter), deferred :: toString
    end type AbstractTestParameter

    abstract interface
        function text_of_parameter(this) result(string)
            import :: AbstractTestParameter
            class(AbstractTestParameter), intent(in) :: this
            character(:), allocatable :: string
        end function text_of_parameter
    end interface

    !> A fixture whose tests are run once for each parameter.
    type, abstract, extends(TestCase) :: ParameterizedTestCase
        class(AbstractTestParameter), allocatable :: testParameter
    end type ParameterizedTestCase

    type :: exception_t
        character(:), allocatable :: message
        type(SourceLocation) :: location
    end type exception_t

    !> Exceptions thrown and not yet caught. A test that leaves one behind has failed.
    type(exception_t), allocatable, save :: pending(:)

    !> An operand of a comparison. Integers and logicals (1 true, 0 false) are exact as reals, so that a
    !! single procedure compares them all.
    type :: operand_t
        character(len=7) :: type = ''           !! integer, real, logical or text
        integer, allocatable :: shape(:)        !! empty for a scalar
        real(real64), allocatable :: value(:)   !! in array element order
        character(:), allocatable :: text
    end type operand_t

    !> What a comparison is given: an integer, real(real64), logical or character of the ranks listed.
    interface funit_operand
        procedure :: integer_rank_0, integer_rank_1
        procedure :: real_rank_0, real_rank_1, real_rank_2
        procedure :: logical_rank_0, logical_rank_1
        procedure :: text_rank_0
    end interface funit_operand

    interface assertTrue
        procedure :: true_rank_0, assertAll
    end interface assertTrue

    interface assertFalse
        procedure :: false_rank_0, assertNone
    end interface assertFalse

contains

    ! ---- exceptions ----------------------------------------------------------------------------------

    !> Record an exception; the test it is thrown in fails unless it is caught.
    subroutine throw(message, location)
        character(*), intent(in) :: message
        type(SourceLocation), intent(in), optional :: location
        type(exception_t), allocatable :: grown(:)
        integer :: i, n

        n = count_pending()
        allocate (grown(n + 1))
        do i = 1, n
            grown(i) = pending(i)
        end do
        grown(n + 1)%message = trim(message)
        if (present(location)) grown(n + 1)%location = location
        call move_alloc(grown, pending)
    end subroutine throw

    !> Whether there was an exception, the latest one or one with this message; it is removed.
    logical function catch(message)
        character(*), intent(in), optional :: message
        type(exception_t), allocatable :: rest(:)
        integer :: i, found

        found = count_pending()
        if (present(message)) then
            do i = found, 1, -1
                if (pending(i)%message == message) exit
            end do
            found = i
        end if
        catch = found > 0
        if (.not. catch) return
        allocate (rest(size(pending) - 1))
        do i = 1, size(rest)
            rest(i) = pending(merge(i, i + 1, i < found))
        end do
        call move_alloc(rest, pending)
    end function catch

    logical function anyExceptions()
        anyExceptions = count_pending() > 0
    end function anyExceptions

    !> The exceptions left behind by a test, one line `file:line: message [test]` each; none is pending after.
    function funit_take_failures(test, location) result(lines)
        character(*), intent(in) :: test
        type(SourceLocation), intent(in) :: location   !! stands in for the location of a bare throw
        character(:), allocatable :: lines
        type(SourceLocation) :: where_thrown
        integer :: i

        lines = ''
        do i = 1, count_pending()
            where_thrown = pending(i)%location
            if (where_thrown%line == 0) where_thrown = location
            lines = lines // trim(where_thrown%file) // ':' // text_of_integer(where_thrown%line) // ': ' // &
                            pending(i)%message // ' [' // test // ']' // new_line('a')
        end do
        if (allocated(pending)) deallocate (pending)
    end function funit_take_failures

    integer function count_pending()
        count_pending = 0
        if (allocated(pending)) count_pending = size(pending)
    end function count_pending

    ! ---- operands ------------------------------------------------------------------------------------

    pure function integer_rank_0(x) result(operand)
        integer, intent(in) :: x
        type(operand_t) :: operand
        operand = new_operand('integer', shape(x), [real(x, real64)])
    end function integer_rank_0

    pure function integer_rank_1(x) result(operand)
        integer, intent(in) :: x(:)
        type(operand_t) :: operand
        operand = new_operand('integer', shape(x), real(x, real64))
    end function integer_rank_1

    pure function real_rank_0(x) result(operand)
        real(real64), intent(in) :: x
        type(operand_t) :: operand
        operand = new_operand('real', shape(x), [x])
    end function real_rank_0

    pure function real_rank_1(x) result(operand)
        real(real64), intent(in) :: x(:)
        type(operand_t) :: operand
        operand = new_operand('real', shape(x), x)
    end function real_rank_1

    pure function real_rank_2(x) result(operand)
        real(real64), intent(in) :: x(:, :)
        type(operand_t) :: operand
        operand = new_operand('real', shape(x), reshape(x, [size(x)]))
    end function real_rank_2

    pure function logical_rank_0(x) result(operand)
        logical, intent(in) :: x
        type(operand_t) :: operand
        operand = new_operand('logical', shape(x), [merge(1.0_real64, 0.0_real64, x)])
    end function logical_rank_0

    pure function logical_rank_1(x) result(operand)
        logical, intent(in) :: x(:)
        type(operand_t) :: operand
        operand = new_operand('logical', shape(x), merge(1.0_real64, 0.0_real64, x))
    end function logical_rank_1

    pure function text_rank_0(x) result(operand)
        character(*), intent(in) :: x
        type(operand_t) :: operand
        operand = new_operand('text', shape(x), [real(real64) ::])
        operand%text = x
    end function text_rank_0

    pure function new_operand(type_name, shape_of_x, value) result(operand)
        character(*), intent(in) :: type_name
        integer, intent(in) :: shape_of_x(:)
        real(real64), intent(in) :: value(:)
        type(operand_t) :: operand

        operand%type = type_name
        operand%shape = shape_of_x
        operand%value = value
    end function new_operand

    ! ---- assertions on two operands ------------------------------------------------------------------

    !> Every element equals what was expected, reals to within `tolerance`; NaN equals nothing.
    !! Text is compared without leading and trailing blanks.
    subroutine assertEqual(expected, actual, tolerance, message, location)
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        call compare('assertEqual', expected, actual, tolerance, message, location)
    end subroutine assertEqual

    !> Every element differs from its partner, reals by more than `tolerance`.
    subroutine assertNotEqual(expected, actual, tolerance, message, location)
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        call compare('assertNotEqual', expected, actual, tolerance, message, location)
    end subroutine assertNotEqual

    !> expected < actual + tolerance for every element.
    subroutine assertLessThan(expected, actual, tolerance, message, location)
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        call compare('assertLessThan', expected, actual, tolerance, message, location)
    end subroutine assertLessThan

    !> expected <= actual + tolerance for every element.
    subroutine assertLessThanOrEqual(expected, actual, tolerance, message, location)
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        call compare('assertLessThanOrEqual', expected, actual, tolerance, message, location)
    end subroutine assertLessThanOrEqual

    !> expected > actual - tolerance for every element.
    subroutine assertGreaterThan(expected, actual, tolerance, message, location)
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        call compare('assertGreaterThan', expected, actual, tolerance, message, location)
    end subroutine assertGreaterThan

    !> expected >= actual - tolerance for every element.
    subroutine assertGreaterThanOrEqual(expected, actual, tolerance, message, location)
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        call compare('assertGreaterThanOrEqual', expected, actual, tolerance, message, location)
    end subroutine assertGreaterThanOrEqual

    !> |actual - expected| <= tolerance |expected| for every element; nothing is relatively equal to zero.
    subroutine assertRelativelyEqual(expected, actual, tolerance, message, location)
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in) :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        call compare('assertRelativelyEqual', expected, actual, tolerance, message, location)
    end subroutine assertRelativelyEqual

    !> Fail at the first element for which the assertion does not hold, or if the operands do not go together.
    subroutine compare(assertion, expected, actual, tolerance, message, location)
        use, intrinsic :: ieee_arithmetic, only: ieee_all, ieee_get_status, ieee_set_halting_mode, &
                                                                                          ieee_set_status, &
                                                                                          ieee_status_type
        character(*), intent(in) :: assertion
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        type(ieee_status_type) :: status
        character(:), allocatable :: reason

        reason = mismatch(assertion, expected, actual, present(tolerance))
        if (reason == '') then
            ! A program built to stop on invalid operations is to report a NaN here, not to die of it.
            call ieee_get_status(status)
            call ieee_set_halting_mode(ieee_all, .false.)
            reason = first_difference(assertion, expected, actual, tolerance)
            call ieee_set_status(status)
        end if
        if (reason /= '') call fail(assertion // ': ' // reason, message, location)
    end subroutine compare

    !> Why pFUnit has no such assertion on these operands; '' if it has.
    pure function mismatch(assertion, expected, actual, has_tolerance) result(reason)
        character(*), intent(in) :: assertion
        type(operand_t), intent(in) :: expected, actual
        logical, intent(in) :: has_tolerance
        character(:), allocatable :: reason
        logical :: allowed, conformable

        select case (actual%type)
        case ('integer', 'real'); allowed = .true.
        case ('logical'); allowed = assertion == 'assertEqual' .or. assertion == 'assertNotEqual'
        case default; allowed = assertion == 'assertEqual'
        end select
        if (has_tolerance) allowed = allowed .and. actual%type == 'real'
        conformable = size(expected%shape) == 0
        if (size(expected%shape) == size(actual%shape)) conformable = all(expected%shape == actual%shape)

        reason = ''
        if (expected%type /= actual%type .or. .not. allowed) then
            reason = 'not defined for ' // trim(expected%type) // ' and ' // trim(actual%type)
            if (has_tolerance) reason = reason // ' with a tolerance'
        else if (.not. conformable) then
            reason = 'expected shape ' // text_of_list(expected%shape) // ', actual shape ' // &
                              text_of_list(actual%shape)
        end if
    end function mismatch

    !> The first pair of elements for which the assertion does not hold, in words; '' if there is none.
    pure function first_difference(assertion, expected, actual, tolerance) result(reason)
        character(*), intent(in) :: assertion
        type(operand_t), intent(in) :: expected, actual
        real(real64), intent(in), optional :: tolerance
        character(:), allocatable :: reason
        real(real64) :: t, e, a
        integer :: i

        reason = ''
        if (actual%type == 'text') then
            if (trim(adjustl(expected%text)) == trim(adjustl(actual%text))) return
            reason = 'expected "' // expected%text // '", actual "' // actual%text // '"'
            return
        end if
        t = 0.0_real64
        if (present(tolerance)) t = tolerance
        do i = 1, size(actual%value)
            e = expected%value(min(i, size(expected%value)))
            a = actual%value(i)
            if (holds(assertion, e, a, t)) cycle
            reason = 'expected ' // text_of(e, actual%type) // ', actual ' // text_of(a, actual%type)
            if (index(assertion, 'Than') > 0) reason = text_of(e, actual%type) // ' and ' // text_of(a, &
                actual%type)
            if (actual%type == 'real') reason = reason // ', difference ' // text_of(a - e, 'real')
            if (present(tolerance)) reason = reason // ', tolerance ' // text_of(t, 'real')
            reason = reason // place(i, actual%shape)
            return
        end do
    end function first_difference

    !> What an assertion says of a single pair. Equality is not left to the difference alone, which is not
    !! a number for two infinities.
    pure logical function holds(assertion, e, a, t)
        character(*), intent(in) :: assertion
        real(real64), intent(in) :: e, a, t
        logical :: equal

        equal = e <= a .and. e >= a
        select case (assertion)
        case ('assertEqual');              holds = equal .or. abs(a - e) <= t
        case ('assertNotEqual');           holds = .not. equal .and. abs(a - e) > t
        case ('assertLessThan');           holds = e < a + t
        case ('assertLessThanOrEqual');    holds = e <= a + t
        case ('assertGreaterThan');        holds = e > a - t
        case ('assertGreaterThanOrEqual'); holds = e >= a - t
        case ('assertRelativelyEqual');    holds = abs(e) > 0.0_real64 .and. abs(a - e) <= t * abs(e)
        case default;                      holds = .false.
        end select
    end function holds

    !> ' at (i)' or ' at (i, j)' for the element with this place in array element order, '' for a scalar.
    pure function place(element, shape) result(text)
        integer, intent(in) :: element, shape(:)
        character(:), allocatable :: text

        select case (size(shape))
        case (1)
            text = ' at ' // text_of_list([element])
        case (2)
            text = ' at ' // text_of_list([1 + mod(element - 1, shape(1)), 1 + (element - 1) / shape(1)])
        case default
            text = ''
        end select
    end function place

    pure function text_of(x, type_name) result(text)
        real(real64), intent(in) :: x
        character(*), intent(in) :: type_name
        character(:), allocatable :: text
        character(len=40) :: buffer

        select case (type_name)
        case ('integer')
            text = text_of_integer(nint(x))
        case ('logical')
            text = trim(merge('true ', 'false', x > 0.5_real64))
        case default
            write (buffer, '(g0)') x
            text = trim(adjustl(buffer))
        end select
    end function text_of

    pure function text_of_integer(i) result(text)
        integer, intent(in) :: i
        character(:), allocatable :: text
        character(len=16) :: buffer

        write (buffer, '(i0)') i
        text = trim(buffer)
    end function text_of_integer

    pure function text_of_list(list) result(text)
        integer, intent(in) :: list(:)
        character(:), allocatable :: text
        integer :: i

        text = '('
        do i = 1, size(list)
            if (i > 1) text = text // ', '
            text = text // text_of_integer(list(i))
        end do
        text = text // ')'
    end function text_of_list

    !> Throw what went wrong, after the message of whoever wrote the assertion.
    subroutine fail(reason, message, location)
        character(*), intent(in) :: reason
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location

        if (present(message)) then
            call throw(trim(message) // ': ' // reason, location)
        else
            call throw(reason, location)
        end if
    end subroutine fail

    ! ---- assertions on one operand -------------------------------------------------------------------

    subroutine true_rank_0(condition, message, location)
        logical, intent(in) :: condition
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (.not. condition) call fail('the condition is false', message, location)
    end subroutine true_rank_0

    subroutine false_rank_0(condition, message, location)
        logical, intent(in) :: condition
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (condition) call fail('the condition is true', message, location)
    end subroutine false_rank_0

    subroutine assertAll(conditions, message, location)
        logical, intent(in) :: conditions(:)
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (.not. all(conditions)) call fail('not all conditions are true', message, location)
    end subroutine assertAll

    subroutine assertAny(conditions, message, location)
        logical, intent(in) :: conditions(:)
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (.not. any(conditions)) call fail('no condition is true', message, location)
    end subroutine assertAny

    subroutine assertNone(conditions, message, location)
        logical, intent(in) :: conditions(:)
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (any(conditions)) call fail('a condition is true', message, location)
    end subroutine assertNone

    subroutine assertNotAll(conditions, message, location)
        logical, intent(in) :: conditions(:)
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (all(conditions)) call fail('all conditions are true', message, location)
    end subroutine assertNotAll

    subroutine assertIsNaN(x, message, location)
        real(real64), intent(in) :: x
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (is_finite(x) .or. fraction_bits(x) == 0) call fail('it is a number', message, location)
    end subroutine assertIsNaN

    subroutine assertIsFinite(x, message, location)
        real(real64), intent(in) :: x
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location
        if (.not. is_finite(x)) call fail('it is infinite or NaN', message, location)
    end subroutine assertIsFinite

    !> Told from the exponent's bits: any other look at a signalling NaN is an invalid operation, and may
    !> trap.
    pure logical function is_finite(x)
        real(real64), intent(in) :: x
        is_finite = ibits(transfer(x, 0_int64), 52, 11) /= 2047
    end function is_finite

    pure integer(int64) function fraction_bits(x)
        real(real64), intent(in) :: x
        fraction_bits = ibits(transfer(x, 0_int64), 0, 52)
    end function fraction_bits

    subroutine assertFail(message, location)
        character(*), intent(in) :: message
        type(SourceLocation), intent(in) :: location
        call throw(message, location)
    end subroutine assertFail

    !> Catch the exception that the call before was to throw; without one, the test fails.
    subroutine assertExceptionRaised(message, location)
        character(*), intent(in), optional :: message
        type(SourceLocation), intent(in) :: location

        if (catch(message)) return
        if (present(message)) then
            call throw('no exception "' // trim(message) // '"', location)
        else
            call throw('no exception', location)
        end if
    end subroutine assertExceptionRaised

    subroutine do_nothing(this)
        class(TestCase), intent(inout) :: this
        associate (unused => this)
        end associate
    end subroutine do_nothing

end module funit
