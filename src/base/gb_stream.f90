!> Arrays so large that what is written to them leaves the caches before it is read again (gb_stream_c.c).
module gb_stream
    use, intrinsic :: iso_c_binding, only: c_double, c_int
    use gb_kinds, only: i8
    implicit none
    private

    interface
        !> place <- numbers, past the caches.
        pure subroutine put_aside(numbers, place, count) bind(c, name="gb_put_aside")
            import :: c_double, c_int
            real(c_double), intent(in) :: numbers(*)
            real(c_double), intent(inout) :: place(*)
            integer(c_int), value :: count
        end subroutine put_aside
    end interface

    !> Bytes that no core has for itself, measured (docs/performance.md): with half of it writing past the
    !> caches costs a seventh of a run, with twice of it that saves a tenth.
    integer(i8), parameter :: beyond_caches = 20000000_i8

    public :: put_aside, beyond_caches

end module gb_stream
