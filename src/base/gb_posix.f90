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

        subroutine c_set_default(name, value) bind(c, name="gb_set_default")
            import :: c_char
            character(kind=c_char), intent(in) :: name(*), value(*)
        end subroutine c_set_default
    end interface

    public :: standard_error_is_terminal, try_to_write, set_environment_default

contains

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
        integer :: i

        reason = ''
        buffer = c_null_char
        if (c_try_to_write(path // c_null_char, int(bytes, c_size_t), buffer, int(reason_size, &
            c_size_t)) == 0) return
        do i = 1, reason_size
            if (buffer(i) == c_null_char) exit
            reason = reason // buffer(i)
        end do
    end function try_to_write

    !> Give an environment variable a value for this process, unless the user has set it.
    subroutine set_environment_default(name, value)
        character(*), intent(in) :: name, value

        call c_set_default(name // c_null_char, value // c_null_char)
    end subroutine set_environment_default

end module gb_posix
