!> gentbeam: large, fast motions of soft beams. See README.md.
program gentbeam
    use, intrinsic :: iso_c_binding, only: c_int
    use gb_run, only: run_program
    implicit none

    interface
        !> C's exit: an exit status that is not a constant, which Fortran 2008's STOP cannot give.
        subroutine c_exit(status) bind(c, name="exit")
            import :: c_int
            integer(c_int), value, intent(in) :: status
        end subroutine c_exit
    end interface

    integer :: status

    call run_program(status)
    call c_exit(int(status, c_int))
end program gentbeam
