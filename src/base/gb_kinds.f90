!> Number kinds and constants shared by every room of the program.
module gb_kinds
    use, intrinsic :: iso_fortran_env, only: real64, int64
    implicit none
    private

    integer, parameter, public :: wp = real64   !! working precision
    integer, parameter, public :: i8 = int64    !! counters that may pass two thousand million
    real(wp), parameter, public :: pi = 3.14159265358979323846_wp

    !> C's log(1+x), which the standard library of Fortran 2008 lacks: exact for small x, where log(1+x)
    !> cancels.
    interface
        pure function log1p(x) bind(c, name="log1p") result(y)
            use, intrinsic :: iso_c_binding, only: c_double
            real(c_double), value, intent(in) :: x
            real(c_double) :: y
        end function log1p
    end interface
    public :: log1p

end module gb_kinds
