!> Runs the tests of a program one after the other, counts them and reports.
!!
!! The code that `pf_preprocess.py` writes announces each test by `begins` and concludes it by `ends`.
module funit_runner
    use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
    use funit, only: SourceLocation, anyExceptions, funit_take_failures
    implicit none
    private

    public :: runner_t

    type :: runner_t
        private
        logical :: verbose = .false.
        character(:), allocatable :: filter       !! only tests with this in their full name are run
        character(:), allocatable :: test         !! the test that is running
        type(SourceLocation) :: location          !! where that test begins
        character(:), allocatable :: failures     !! one line for each exception left behind
        integer :: passed = 0
        integer :: failed = 0
        integer :: disabled = 0
    contains
        procedure :: start
        procedure :: begins
        procedure :: ends
        procedure :: skip
        procedure :: finish
    end type runner_t

contains

    !> Read the command line: `-v` names each test as it runs, `-f text` runs those with text in their name.
    subroutine start(self)
        class(runner_t), intent(inout) :: self
        character(len=256) :: argument
        integer :: i

        self%filter = ''
        self%failures = ''
        i = 1
        do while (i <= command_argument_count())
            call get_command_argument(i, argument)
            if (argument == '-v') then
                self%verbose = .true.
            else if (argument == '-f' .and. i < command_argument_count()) then
                i = i + 1
                call get_command_argument(i, argument)
                self%filter = trim(argument)
            else
                write (error_unit, '(a)') 'unknown or incomplete option: ' // trim(argument), &
                    'usage: [-v] [-f substring]'
                stop 1
            end if
            i = i + 1
        end do
    end subroutine start

    !> Announce a test; whether it is to be run.
    logical function begins(self, suite, test, line)
        class(runner_t), intent(inout) :: self
        character(*), intent(in) :: suite     !! the module of the test, named as its file
        character(*), intent(in) :: test      !! the test procedure, with its parameter if it has one
        integer, intent(in) :: line           !! where that procedure begins in the file
        character(:), allocatable :: full_name

        full_name = suite // '_suite.' // test
        begins = index(full_name, self%filter) > 0
        if (.not. begins) return
        self%test = test
        self%location = SourceLocation(suite // '.pf', line)
        if (.not. self%verbose) return
        write (output_unit, '(a)', advance='no') full_name // ' ... '
        flush (output_unit)
    end function begins

    !> The announced test and its fixture are done: count it, and keep what it left behind.
    subroutine ends(self)
        class(runner_t), intent(inout) :: self

        if (self%verbose) write (output_unit, '(a)') trim(merge('FAILED', 'ok    ', anyExceptions()))
        if (anyExceptions()) then
            self%failed = self%failed + 1
            self%failures = self%failures // funit_take_failures(self%test, self%location)
        else
            self%passed = self%passed + 1
        end if
    end subroutine ends

    !> Count a test that is disabled.
    subroutine skip(self, suite, test, line)
        class(runner_t), intent(inout) :: self
        character(*), intent(in) :: suite, test
        integer, intent(in) :: line

        if (.not. self%begins(suite, test, line)) return
        if (self%verbose) write (output_unit, '(a)') 'disabled'
        self%disabled = self%disabled + 1
    end subroutine skip

    !> Print the closing lines, and stop with 2 if a test failed, 3 if none was run.
    subroutine finish(self)
        class(runner_t), intent(in) :: self

        if (self%failed > 0) then
            write (output_unit, '(a)') ' FAILURES!!!'
            write (output_unit, '(a)', advance='no') self%failures
        else if (self%passed > 0) then
            write (output_unit, '(a)') ' OK'
            write (output_unit, '(a, i0, a, i0, a)') ' (', self%passed, ' tests, ', self%disabled, &
                ' disabled)'
        else
            write (output_unit, '(a)') ' FAILURES!!!', 'no test was run'
        end if
        write (output_unit, '(i0, a, i0, a)') self%passed, ' passed, ', self%failed, ' failed'
        if (self%failed > 0) stop 2
        if (self%passed == 0) stop 3
    end subroutine finish

end module funit_runner
