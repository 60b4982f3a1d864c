!> Gauss-Legendre quadrature on [-1, 1].
module gb_quadrature
    use gb_kinds, only: wp, pi
    implicit none
    private

    public :: gauss_legendre

contains

    !> The rule of n = size(points) points, increasing; exact for polynomials of degree 2n-1. Roots of the
    !> Legendre polynomial by Newton's method from Tricomi's estimate.
    pure subroutine gauss_legendre(points, weights)
        real(wp), intent(out) :: points(:)      !! [-] (n)
        real(wp), intent(out) :: weights(:)     !! [-] (n)
        real(wp) :: x, p, slope, change
        integer :: n, i, iteration

        n = size(points)
        do i = 1, n
            x = -cos(pi*(real(i, wp) - 0.25_wp)/(real(n, wp) + 0.5_wp))
            do iteration = 1, 50
                call legendre(n, x, p, slope)
                change = p/slope
                x = x - change
                if (abs(change) <= epsilon(1.0_wp)) exit
            end do
            call legendre(n, x, p, slope)
            points(i) = x
            weights(i) = 2.0_wp/((1.0_wp - x**2)*slope**2)
        end do
        if (modulo(n, 2) == 1) points((n + 1)/2) = 0.0_wp
    end subroutine gauss_legendre

    !> Legendre polynomial P_n and its derivative at x by the three-term recurrence.
    pure subroutine legendre(n, x, p, slope)
        integer, intent(in) :: n
        real(wp), intent(in) :: x
        real(wp), intent(out) :: p, slope
        real(wp) :: before, last
        integer :: k

        last = 1.0_wp
        p = x
        do k = 2, n
            before = last
            last = p
            p = (real(2*k - 1, wp)*x*last - real(k - 1, wp)*before)/real(k, wp)
        end do
        slope = real(n, wp)*(x*p - last)/(x**2 - 1.0_wp)
    end subroutine legendre

end module gb_quadrature
