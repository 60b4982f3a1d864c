!> Errors as values: a routine that can fail takes `type(error_t), allocatable, intent(out) :: error` last,
!> and leaves it unallocated when all went well.
module gb_error
    implicit none
    private

    !> Exit statuses of the program (docs/results.md).
    integer, parameter, public :: status_ok = 0
    integer, parameter, public :: status_input = 1      !! the deck or the command line is wrong
    integer, parameter, public :: status_solution = 2   !! the solution failed
    integer, parameter, public :: status_file = 3       !! a file could not be read or written
    integer, parameter, public :: status_interrupted = 4    !! stopped from outside, with a checkpoint

    !> What went wrong, in a sentence for the user, and the exit status it leads to.
    type, public :: error_t
        integer :: status = status_input
        character(:), allocatable :: message
    end type error_t

    public :: raise

contains

    !> Allocate `error` with the given status and sentence.
    pure subroutine raise(error, status, message)
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in) :: status
        character(*), intent(in) :: message

        allocate (error)
        error%status = status
        error%message = message
    end subroutine raise

end module gb_error
