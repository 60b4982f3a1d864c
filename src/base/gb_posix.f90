!> Questions to the operating system that Fortran has no words for.
module gb_posix
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
    implicit none
    private

    integer, parameter :: reason_size = 256

    interface
        function c_isatty(descriptor) bind(c, name="isatty") result(answer)
            import :: c_int
            integer(c_int), value, intent(in) :: descriptor
            integer(c_int) :: answer
        end function c_isatty

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

        function c_write_output(text, length) bind(c, name="gb_write_output") result(failed)
            import :: c_char, c_int, c_size_t
            character(kind=c_char), intent(in) :: text(*)
            integer(c_size_t), value, intent(in) :: length
            integer(c_int) :: failed
        end function c_write_output

        !> From now on a write to a closed pipe, or beyond the limit of a file's size, fails and does not
        !> kill.
        subroutine ignore_write_signals() bind(c, name="gb_ignore_write_signals")
        end subroutine ignore_write_signals

        subroutine c_set_default(name, value) bind(c, name="gb_set_default")
            import :: c_char
            character(kind=c_char), intent(in) :: name(*), value(*)
        end subroutine c_set_default
    end interface

    public :: is_terminal, standard_error_is_terminal, try_to_write, claim_file, write_output
    public :: ignore_write_signals, set_environment_default

contains

    !> Whether an open file (0 input, 1 output, 2 error) is a terminal.
    logical function is_terminal(descriptor)
        integer, intent(in) :: descriptor

        is_terminal = c_isatty(int(descriptor, c_int)) /= 0
    end function is_terminal

    logical function standard_error_is_terminal()
        standard_error_is_terminal = c_isatty(2_c_int) /= 0
    end function standard_error_is_terminal

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

    !> Write a text to standard output at once. (gfortran's own flush does not tell of a full disk.)
    subroutine write_output(text, failed)
        character(*), intent(in) :: text
        logical, intent(out) :: failed

        failed = c_write_output(text, int(len(text), c_size_t)) /= 0
    end subroutine write_output

    !> Give an environment variable a value for this process, unless the user has set it.
    subroutine set_environment_default(name, value)
        character(*), intent(in) :: name, value

        call c_set_default(name // c_null_char, value // c_null_char)
    end subroutine set_environment_default

end module gb_posix
