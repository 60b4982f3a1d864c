!> Section rule `gauss n` for the energy and momentum conserving scheme. The stored energy depends on the
!> generalised strains g only through eight invariants of rotation,
!>     p = (x'.x', x'.w, w.w, x'.w', w.w', w'.w', xi, xi'),   x' = (1+u1', u3'),  w = (y1, 1+y3),
!> in which p(g1) - p(g0) = Dp((g0+g1)/2) (g1 - g0) exactly. The average of dPhi/dp over the straight path
!> from p0 to p1,
!>     s = Dp(g_mid)' integral_0^1 dPhi/dp (p0 + r (p1-p0)) dr,
!> therefore does the work s.(g1-g0) = Phi(g1) - Phi(g0), and turns with the beam.
!>
!> Metric at height z, with zeta = z + xi z^2, k = z^2 xi', q = 1 + 2 xi z:
!> C11 = p1 + zeta^2 p6 + k^2 p3 + 2 zeta p4 + 2 k p2 + 2 zeta k p5,  C13 = q (p2 + zeta p5 + k p3),  C33 =
!> q^2 p3.
module gb_section_average
    use gb_kinds, only: wp
    use gb_gent, only: n_constants, is_admissible, gent_curvatures
    use gb_section_gauss, only: n_strains, gauss_invariants
    implicit none
    private

    integer, parameter :: n_path = 3
    !> Gauss points on the path from 0 to 1, and their weights.
    real(wp), parameter :: root = 0.38729833462074168852_wp     ! sqrt(3/5)/2
    real(wp), parameter :: path(n_path) = [0.5_wp - root, 0.5_wp, 0.5_wp + root]
    real(wp), parameter :: path_weight(n_path) = [5.0_wp, 8.0_wp, 5.0_wp]/18.0_wp

    public :: average_tangent

contains

    !> Average generalised stresses s between g0 and g1, and t = ds/dg1 (unsymmetric).
    pure subroutine average_tangent(nz, z, wz, c, g0, g1, s, t, admissible)
        integer, intent(in) :: nz
        real(wp), intent(in) :: z(nz), wz(nz)           !! heights [L] and areas [L^2] of the points
        real(wp), intent(in) :: c(n_constants)          !! mu, c [F/L^2], beta, 1/jm
        real(wp), intent(in) :: g0(n_strains), g1(n_strains)
        real(wp), intent(out) :: s(n_strains), t(n_strains, n_strains)
        logical, intent(out) :: admissible
        real(wp) :: p0(n_strains), p1(n_strains), slope(n_strains), curvature(n_strains, n_strains)
        real(wp) :: part(n_strains), part2(n_strains, n_strains), d_mid(n_strains, n_strains), &
            d_end(n_strains, n_strains)
        real(wp) :: i1_minus_2, j
        integer :: i

        s = 0.0_wp
        t = 0.0_wp
        do i = 1, nz
            call gauss_invariants(z(i), g1, i1_minus_2, j)
            admissible = is_admissible(i1_minus_2, j, c(4))
            if (.not. admissible) return
        end do
        p0 = invariants_of(g0)
        p1 = invariants_of(g1)
        slope = 0.0_wp
        curvature = 0.0_wp
        do i = 1, n_path
            call energy_in_invariants(nz, z, wz, c, p0 + path(i)*(p1 - p0), part, part2, admissible)
            if (.not. admissible) return
            slope = slope + path_weight(i)*part
            curvature = curvature + (path_weight(i)*path(i))*part2
        end do
        d_mid = invariant_gradient(0.5_wp*(g0 + g1))
        d_end = invariant_gradient(g1)
        s = matmul(slope, d_mid)
        t = matmul(transpose(d_mid), matmul(curvature, d_end))
        call add_half_second_gradient(slope, t)
    end subroutine average_tangent

    !> p(g).
    pure function invariants_of(g) result(p)
        real(wp), intent(in) :: g(n_strains)
        real(wp) :: p(n_strains)
        real(wp) :: a(2), d(2), e(2)

        a = [1.0_wp + g(1), g(2)]
        e = g(3:4)
        d = [g(6), 1.0_wp + g(7)]
        p = [dot_product(a, a), dot_product(a, d), dot_product(d, d), dot_product(a, e), dot_product(d, e), &
             dot_product(e, e), g(8), g(5)]
    end function invariants_of

    !> dp_i/dg_k; linear in g but for its last two rows, which are constant.
    pure function invariant_gradient(g) result(dp)
        real(wp), intent(in) :: g(n_strains)
        real(wp) :: dp(n_strains, n_strains)
        real(wp) :: a(2), d(2), e(2)

        a = [1.0_wp + g(1), g(2)]
        e = g(3:4)
        d = [g(6), 1.0_wp + g(7)]
        dp = 0.0_wp
        dp(1, 1:2) = 2.0_wp*a
        dp(2, 1:2) = d
        dp(2, 6:7) = a
        dp(3, 6:7) = 2.0_wp*d
        dp(4, 1:2) = e
        dp(4, 3:4) = a
        dp(5, 6:7) = e
        dp(5, 3:4) = d
        dp(6, 3:4) = 2.0_wp*e
        dp(7, 8) = 1.0_wp
        dp(8, 5) = 1.0_wp
    end function invariant_gradient

    !> t <- t + (1/2) sum_i slope_i d2p_i/dg2: the middle moves half as far as the end.
    pure subroutine add_half_second_gradient(slope, t)
        real(wp), intent(in) :: slope(n_strains)
        real(wp), intent(inout) :: t(n_strains, n_strains)
        integer :: i

        do i = 1, 2
            t(i, i) = t(i, i) + slope(1)
            t(5 + i, 5 + i) = t(5 + i, 5 + i) + slope(3)
            t(2 + i, 2 + i) = t(2 + i, 2 + i) + slope(6)
            t(i, 5 + i) = t(i, 5 + i) + 0.5_wp*slope(2)
            t(5 + i, i) = t(5 + i, i) + 0.5_wp*slope(2)
            t(i, 2 + i) = t(i, 2 + i) + 0.5_wp*slope(4)
            t(2 + i, i) = t(2 + i, i) + 0.5_wp*slope(4)
            t(5 + i, 2 + i) = t(5 + i, 2 + i) + 0.5_wp*slope(5)
            t(2 + i, 5 + i) = t(2 + i, 5 + i) + 0.5_wp*slope(5)
        end do
    end subroutine add_half_second_gradient

    !> dPhi/dp and d2Phi/dp2 by the chain rule through the metric (C11, C33, C13).
    pure subroutine energy_in_invariants(nz, z, wz, c, p, slope, curvature, admissible)
        integer, intent(in) :: nz
        real(wp), intent(in) :: z(nz), wz(nz), c(n_constants), p(n_strains)
        real(wp), intent(out) :: slope(n_strains), curvature(n_strains, n_strains)
        logical, intent(out) :: admissible
        real(wp) :: metric(3), dm(n_strains, 3), w1(3), w2(3, 3), determinant
        integer :: i

        slope = 0.0_wp
        curvature = 0.0_wp
        do i = 1, nz
            call metric_gradient(z(i), p, metric, dm)
            determinant = metric(1)*metric(2) - metric(3)**2
            admissible = is_admissible(metric(1) + metric(2) - 2.0_wp, determinant, c(4)) &
                .and. metric(2) > 0.0_wp
            if (.not. admissible) return
            call energy_in_metric(c, metric, sqrt(determinant), w1, w2)
            w1 = wz(i)*w1
            w2 = wz(i)*w2
            slope = slope + matmul(dm, w1)
            curvature = curvature + matmul(dm, matmul(w2, transpose(dm)))
            call add_metric_hessians(z(i), p, w1, curvature)
        end do
    end subroutine energy_in_invariants

    !> (C11, C33, C13) at height z and their gradients in p, dm(:, a) = dC_a/dp.
    pure subroutine metric_gradient(z, p, metric, dm)
        real(wp), intent(in) :: z, p(n_strains)
        real(wp), intent(out) :: metric(3), dm(n_strains, 3)
        real(wp) :: zeta, k, q, z2, shear

        z2 = z**2
        zeta = z + p(7)*z2
        k = z2*p(8)
        q = 1.0_wp + 2.0_wp*p(7)*z
        shear = p(2) + zeta*p(5) + k*p(3)
        metric(1) = p(1) + zeta**2*p(6) + k**2*p(3) + 2.0_wp*(zeta*p(4) + k*p(2) + zeta*k*p(5))
        metric(2) = q**2*p(3)
        metric(3) = q*shear
        dm = 0.0_wp
        dm(1:6, 1) = [1.0_wp, 2.0_wp*k, k**2, 2.0_wp*zeta, 2.0_wp*zeta*k, zeta**2]
        dm(7, 1) = 2.0_wp*z2*(zeta*p(6) + p(4) + k*p(5))
        dm(8, 1) = 2.0_wp*z2*shear
        dm(3, 2) = q**2
        dm(7, 2) = 4.0_wp*z*q*p(3)
        dm(2, 3) = q
        dm(3, 3) = q*k
        dm(5, 3) = q*zeta
        dm(7, 3) = 2.0_wp*z*shear + q*z2*p(5)
        dm(8, 3) = q*z2*p(3)
    end subroutine metric_gradient

    !> dW/dC and d2W/dC2 in (C11, C33, C13), C13 standing for both off-diagonal terms; I1 = C11 + C33, J^2 =
    !> det C.
    pure subroutine energy_in_metric(c, metric, j, w1, w2)
        real(wp), intent(in) :: c(n_constants), metric(3), j
        real(wp), intent(out) :: w1(3), w2(3, 3)
        real(wp) :: phi_1, psi_1, phi_2, psi_2, dj(3)

        call gent_curvatures(c, metric(1) + metric(2) - 2.0_wp, j, phi_1, psi_1, phi_2, psi_2)
        dj = [0.5_wp*metric(2), 0.5_wp*metric(1), -metric(3)]/j
        w1 = psi_1*dj
        w1(1:2) = w1(1:2) + phi_1
        w2 = (psi_2 - psi_1/j)*spread(dj, 2, 3)*spread(dj, 1, 3)
        w2(1:2, 1:2) = w2(1:2, 1:2) + phi_2
        w2(1, 2) = w2(1, 2) + 0.5_wp*psi_1/j
        w2(2, 1) = w2(2, 1) + 0.5_wp*psi_1/j
        w2(3, 3) = w2(3, 3) - psi_1/j
    end subroutine energy_in_metric

    !> h <- h + sum_a w1_a d2C_a/dp2.
    pure subroutine add_metric_hessians(z, p, w1, h)
        real(wp), intent(in) :: z, p(n_strains), w1(3)
        real(wp), intent(inout) :: h(n_strains, n_strains)
        real(wp) :: zeta, k, q, z2

        z2 = z**2
        zeta = z + p(7)*z2
        k = z2*p(8)
        q = 1.0_wp + 2.0_wp*p(7)*z
        call add_pair(h, 2, 7, 2.0_wp*z*w1(3))
        call add_pair(h, 2, 8, 2.0_wp*z2*w1(1))
        call add_pair(h, 3, 7, 4.0_wp*z*q*w1(2) + 2.0_wp*z*k*w1(3))
        call add_pair(h, 3, 8, 2.0_wp*k*z2*w1(1) + q*z2*w1(3))
        call add_pair(h, 4, 7, 2.0_wp*z2*w1(1))
        call add_pair(h, 5, 7, 2.0_wp*k*z2*w1(1) + (2.0_wp*z*zeta + q*z2)*w1(3))
        call add_pair(h, 5, 8, 2.0_wp*zeta*z2*w1(1))
        call add_pair(h, 6, 7, 2.0_wp*zeta*z2*w1(1))
        call add_pair(h, 7, 8, 2.0_wp*z2**2*p(5)*w1(1) + 2.0_wp*z*z2*p(3)*w1(3))
        h(7, 7) = h(7, 7) + 2.0_wp*z2**2*p(6)*w1(1) + 8.0_wp*z2*p(3)*w1(2) + 4.0_wp*z*z2*p(5)*w1(3)
        h(8, 8) = h(8, 8) + 2.0_wp*z2**2*p(3)*w1(1)
    end subroutine add_metric_hessians

    pure subroutine add_pair(h, m, n, value)
        real(wp), intent(inout) :: h(n_strains, n_strains)
        integer, intent(in) :: m, n
        real(wp), intent(in) :: value

        h(m, n) = h(m, n) + value
        h(n, m) = h(n, m) + value
    end subroutine add_pair

end module gb_section_average
