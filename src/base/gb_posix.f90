!> Questions to the operating system that Fortran has no words for.
module gb_posix
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
    implicit none
    private

    !> Characters that C may use to say why something failed.
    integer, parameter, public :: reason_size = 256

    interface
        function c_isatty(descriptor) bind(c, name="isatty") result(answer)
            import :: c_int
            integer(c_int), value, intent(in) :: descriptor
            integer(c_int) :: answer
        end function c_isatty

        function c_write_output(text, length) bind(c, name="gb_write_output") result(failed)
            import :: c_char, c_int, c_size_t
            character(kind=c_char), intent(in) :: text(*)
            integer(c_size_t), value, intent(in) :: length
            integer(c_int) :: failed
        end function c_write_output

        !> Standard input, output and error that are closed stay so: no file that is opened takes their place.
        subroutine hold_standard_files() bind(c, name="gb_hold_standard_files")
        end subroutine hold_standard_files

        !> From now on a write to a closed pipe, or beyond the limit of a file's size, fails and does not
        !> kill.
        subroutine ignore_write_signals() bind(c, name="gb_ignore_write_signals")
        end subroutine ignore_write_signals

        !> From now on the program may open as many files at once as the system allows.
        subroutine raise_file_limit() bind(c, name="gb_raise_file_limit")
        end subroutine raise_file_limit

        !> Let others work for a tenth of a millisecond.
        subroutine pause_briefly() bind(c, name="gb_pause_briefly")
        end subroutine pause_briefly
    end interface

    public :: hold_standard_files, is_terminal, standard_error_is_terminal, write_output, to_fortran
    public :: ignore_write_signals, pause_briefly, raise_file_limit

contains

    !> Whether an open file (0 input, 1 output, 2 error) is a terminal.
    logical function is_terminal(descriptor)
        integer, intent(in) :: descriptor

        is_terminal = c_isatty(int(descriptor, c_int)) /= 0
    end function is_terminal

    logical function standard_error_is_terminal()
        standard_error_is_terminal = c_isatty(2_c_int) /= 0
    end function standard_error_is_terminal

    !> A text of C's, up to its NUL.
    pure function to_fortran(characters) result(text)
        character(kind=c_char), intent(in) :: characters(:)
        character(:), allocatable :: text
        integer :: i

        text = ''
        do i = 1, size(characters)
            if (characters(i) == c_null_char) exit
            text = text // characters(i)
        end do
    end function to_fortran

    !> Write a text to standard output at once. (gfortran's own flush does not tell of a full disk.)
    subroutine write_output(text, failed)
        character(*), intent(in) :: text
        logical, intent(out) :: failed

        failed = c_write_output(text, int(len(text), c_size_t)) /= 0
    end subroutine write_output

end module gb_posix
