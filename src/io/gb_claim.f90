!> Holding a results file that is changed in place against other writers, and why the system takes no more.
module gb_claim
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
    use gb_error, only: error_t, raise, status_file
    implicit none
    private

    integer, parameter :: reason_size = 256

    interface
        function c_try_to_write(path, bytes, reason, size) bind(c, name="gb_try_to_write") result(failed)
            import :: c_char, c_int, c_size_t
            character(kind=c_char), intent(in) :: path(*)
            integer(c_size_t), value, intent(in) :: bytes, size
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_int) :: failed
        end function c_try_to_write

        function c_claim_file(path, reason, size) bind(c, name="gb_claim_file") result(failed)
            import :: c_char, c_int, c_size_t
            character(kind=c_char), intent(in) :: path(*)
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_size_t), value, intent(in) :: size
            integer(c_int) :: failed
        end function c_claim_file

        subroutine c_set_default(name, value) bind(c, name="gb_set_default")
            import :: c_char
            character(kind=c_char), intent(in) :: name(*), value(*)
        end subroutine c_set_default
    end interface

    public :: claim_file, explain_failure, set_environment_default

contains

    !> Turn HDF5's failure into a sentence with the file's name and the system's reason: a write beside the
    !> file meets the same trouble and is told why.
    subroutine explain_failure(path, error)
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(inout) :: error
        integer, parameter :: telling_size = 1048576
        character(:), allocatable :: reason

        reason = try_to_write(path // '.probe', telling_size)
        if (len(reason) == 0) reason = error%message
        call raise(error, status_file, 'cannot write the results file ' // path // ': ' // reason)
    end subroutine explain_failure

    !> Try whether so many bytes can be written to a new file, which is removed again: the system's words for
    !> why not, or an empty text.
    function try_to_write(path, bytes) result(reason)
        character(*), intent(in) :: path
        integer, intent(in) :: bytes
        character(:), allocatable :: reason
        character(kind=c_char) :: buffer(reason_size)
        integer(c_int) :: failed

        buffer = c_null_char
        failed = c_try_to_write(path // c_null_char, int(bytes, c_size_t), buffer, int(reason_size, c_size_t))
        reason = told(failed, buffer)
    end function try_to_write

    !> Open a file for writing, without touching what is in it, and hold it against other writers: why that
    !> cannot be, or an empty text.
    function claim_file(path) result(reason)
        character(*), intent(in) :: path
        character(:), allocatable :: reason
        character(kind=c_char) :: buffer(reason_size)
        integer(c_int) :: failed

        buffer = c_null_char
        failed = c_claim_file(path // c_null_char, buffer, int(reason_size, c_size_t))
        reason = told(failed, buffer)
    end function claim_file

    pure function told(failed, buffer) result(reason)
        integer(c_int), intent(in) :: failed
        character(kind=c_char), intent(in) :: buffer(reason_size)
        character(:), allocatable :: reason
        integer :: i

        reason = ''
        if (failed == 0) return
        do i = 1, reason_size
            if (buffer(i) == c_null_char) exit
            reason = reason // buffer(i)
        end do
    end function told

    !> Give an environment variable a value for this process, unless the user has set it.
    subroutine set_environment_default(name, value)
        character(*), intent(in) :: name, value

        call c_set_default(name // c_null_char, value // c_null_char)
    end subroutine set_environment_default

end module gb_claim
