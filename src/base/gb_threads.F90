!> Threads of the linear algebra library. OpenBLAS starts one for every core, and on the small bands of a beam
!> they cost more than they give: the program runs its members in parallel, not its bands.
module gb_threads
    use, intrinsic :: iso_c_binding, only: c_int
    implicit none
    private

    public :: use_one_blas_thread

#ifdef GENTBEAM_HAS_OPENBLAS
    interface
        subroutine openblas_set_num_threads(count) bind(c, name="openblas_set_num_threads")
            import :: c_int
            integer(c_int), value, intent(in) :: count
        end subroutine openblas_set_num_threads
    end interface
#endif

contains

    subroutine use_one_blas_thread()
#ifdef GENTBEAM_HAS_OPENBLAS
        call openblas_set_num_threads(1_c_int)
#endif
    end subroutine use_one_blas_thread

end module gb_threads
