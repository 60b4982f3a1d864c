!> The processor's peak of fused multiply-adds, measured: bench_peak. Ten independent vectors hide their
!> latency.
program bench_peak
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use bench_models, only: seconds
    implicit none
    integer, parameter :: vectors = 10, rounds = 200000, repeats = 30
    real(wp) :: x(lanes, vectors), factor(lanes), least, start
    integer :: repeat, i, k

    factor = 0.999999_wp
    least = huge(least)
    do repeat = 1, repeats
        x = 1.0_wp
        start = seconds()
        do i = 1, rounds
            !GCC$ unroll 10
            do k = 1, vectors
                x(:, k) = x(:, k)*factor + 1.0e-9_wp
            end do
        end do
        least = min(least, seconds() - start)
        if (any(x > 2.0_wp)) print '(a)', 'overflow'
    end do
    print '(f8.2,a)', 2.0e-9_wp*real(lanes*vectors, wp)*real(rounds, wp)/least, ' Gflop/s'
end program bench_peak
