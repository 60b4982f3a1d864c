!> Section rule `gauss n`: the energy of a unit length of beam, Phi(g) = integral over the section of W(F(g,
!> X3)), by Gauss points through the thickness, with the full deformation gradient of eq. (5). Stress
!> resultants and tangent are exact derivatives of this one potential.
!>
!> Generalised strains, slopes first:  g = (u1', u3', y1', y3', xi', y1, y3, xi),  ' = d/dX1.
!> With a = (1+u1', u3'), d = (y1, 1+y3), e = (y1', y3'), zeta = z + xi z^2, k = z^2 xi', q = 1 + 2 xi z:
!>     (F11, F31) = a + zeta e + k d,   (F13, F33) = q d,   J = q (a x d + zeta e x d).
module gb_section_gauss
    use gb_kinds, only: wp
    use gb_gent, only: n_constants, is_admissible, gent_energy, gent_slopes, gent_curvatures
    implicit none
    private

    integer, parameter, public :: n_strains = 8

    public :: gauss_energy, gauss_stress, gauss_tangent, gauss_invariants

contains

    !> I1-2 [-] and J [-] at the height z of the section: what decides whether a state is admissible.
    pure subroutine gauss_invariants(z, g, i1_minus_2, j)
        real(wp), intent(in) :: z               !! X3 [L]
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: i1_minus_2, j
        real(wp) :: zeta, k, q, d3, g11, f31, f13, g33

        zeta = z + g(8)*z**2
        k = z**2*g(5)
        q = 1.0_wp + 2.0_wp*g(8)*z
        d3 = 1.0_wp + g(7)
        g11 = g(1) + zeta*g(3) + k*g(6)
        f31 = g(2) + zeta*g(4) + k*d3
        f13 = q*g(6)
        g33 = g(7) + 2.0_wp*g(8)*z*d3
        i1_minus_2 = 2.0_wp*(g11 + g33) + g11**2 + g33**2 + f31**2 + f13**2
        j = 1.0_wp + (g11 + g33 + g11*g33 - f13*f31)
    end subroutine gauss_invariants

    !> Energy a unit length [F].
    pure subroutine gauss_energy(nz, z, wz, p, g, energy, admissible)
        integer, intent(in) :: nz
        real(wp), intent(in) :: z(nz)           !! heights of the points [L]
        real(wp), intent(in) :: wz(nz)          !! their areas [L^2]
        real(wp), intent(in) :: p(n_constants)
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: energy
        logical, intent(out) :: admissible
        real(wp) :: i1_minus_2, j
        integer :: i

        energy = 0.0_wp
        do i = 1, nz
            call gauss_invariants(z(i), g, i1_minus_2, j)
            admissible = is_admissible(i1_minus_2, j, p(4))
            if (.not. admissible) return
            energy = energy + wz(i)*gent_energy(p, i1_minus_2, j)
        end do
    end subroutine gauss_energy

    !> Generalised stresses s = dPhi/dg.
    pure subroutine gauss_stress(nz, z, wz, p, g, s, admissible)
        integer, intent(in) :: nz
        real(wp), intent(in) :: z(nz), wz(nz), p(n_constants), g(n_strains)
        real(wp), intent(out) :: s(n_strains)
        logical, intent(out) :: admissible
        real(wp) :: i1_minus_2, j, phi_1, psi_1, v(n_strains), w(n_strains)
        integer :: i

        s = 0.0_wp
        do i = 1, nz
            call gauss_invariants(z(i), g, i1_minus_2, j)
            admissible = is_admissible(i1_minus_2, j, p(4))
            if (.not. admissible) return
            call gent_slopes(p, i1_minus_2, j, phi_1, psi_1)
            call invariant_gradients(z(i), g, v, w)
            s = s + (wz(i)*phi_1)*v + (wz(i)*psi_1)*w
        end do
    end subroutine gauss_stress

    !> Generalised stresses s and tangent t = d2Phi/dg2 (symmetric):
    !> sum of wz (phi'' v v' + psi'' w w' + phi' d2I1 + psi' d2J), v = dI1/dg, w = dJ/dg.
    pure subroutine gauss_tangent(nz, z, wz, p, g, s, t, admissible)
        integer, intent(in) :: nz
        real(wp), intent(in) :: z(nz), wz(nz), p(n_constants), g(n_strains)
        real(wp), intent(out) :: s(n_strains), t(n_strains, n_strains)
        logical, intent(out) :: admissible
        real(wp) :: i1_minus_2, j, phi_1, psi_1, phi_2, psi_2, v(n_strains), w(n_strains)
        real(wp) :: i1_moments(0:4), j_moments(0:3)     !! sums of wz phi' z^n and wz psi' z^n
        integer :: i, m, n

        s = 0.0_wp
        t = 0.0_wp
        i1_moments = 0.0_wp
        j_moments = 0.0_wp
        do i = 1, nz
            call gauss_invariants(z(i), g, i1_minus_2, j)
            admissible = is_admissible(i1_minus_2, j, p(4))
            if (.not. admissible) return
            call invariant_gradients(z(i), g, v, w)
            call gent_curvatures(p, i1_minus_2, j, phi_1, psi_1, phi_2, psi_2)
            call add_moments(4, z(i), wz(i)*phi_1, i1_moments)
            call add_moments(3, z(i), wz(i)*psi_1, j_moments)
            s = s + (wz(i)*phi_1)*v + (wz(i)*psi_1)*w
            phi_2 = wz(i)*phi_2
            psi_2 = wz(i)*psi_2
            do n = 1, n_strains
                t(:, n) = t(:, n) + (phi_2*v(n))*v + (psi_2*w(n))*w
            end do
        end do
        call add_invariant_hessians(g, i1_moments, j_moments, t)
        do n = 1, n_strains - 1
            do m = n + 1, n_strains
                t(m, n) = t(n, m)
            end do
        end do
    end subroutine gauss_tangent

    !> moments(n) <- moments(n) + weight z^n.
    pure subroutine add_moments(last, z, weight, moments)
        integer, intent(in) :: last
        real(wp), intent(in) :: z, weight
        real(wp), intent(inout) :: moments(0:last)
        real(wp) :: part
        integer :: n

        part = weight
        do n = 0, last
            moments(n) = moments(n) + part
            part = part*z
        end do
    end subroutine add_moments

    !> v = dI1/dg and w = dJ/dg at height z.
    pure subroutine invariant_gradients(z, g, v, w)
        real(wp), intent(in) :: z, g(n_strains)
        real(wp), intent(out) :: v(n_strains), w(n_strains)
        real(wp) :: z2, zeta, k, q, a1, d1, d3, f11, f31, f13, f33, b0

        z2 = z**2
        zeta = z + g(8)*z2
        k = z2*g(5)
        q = 1.0_wp + 2.0_wp*g(8)*z
        a1 = 1.0_wp + g(1)
        d1 = g(6)
        d3 = 1.0_wp + g(7)
        f11 = a1 + zeta*g(3) + k*d1
        f31 = g(2) + zeta*g(4) + k*d3
        f13 = q*d1
        f33 = q*d3
        v(1) = 2.0_wp*f11
        v(2) = 2.0_wp*f31
        v(3) = zeta*v(1)
        v(4) = zeta*v(2)
        v(5) = z2*(d1*v(1) + d3*v(2))
        v(6) = k*v(1) + 2.0_wp*q*f13
        v(7) = k*v(2) + 2.0_wp*q*f33
        v(8) = z2*(g(3)*v(1) + g(4)*v(2)) + 4.0_wp*z*(f13*d1 + f33*d3)
        b0 = g(3)*d3 - g(4)*d1
        w(1) = q*d3
        w(2) = -q*d1
        w(3) = zeta*w(1)
        w(4) = zeta*w(2)
        w(5) = 0.0_wp
        w(6) = -q*(g(2) + zeta*g(4))
        w(7) = q*(a1 + zeta*g(3))
        w(8) = 2.0_wp*z*(a1*d3 - g(2)*d1 + zeta*b0) + q*z2*b0
    end subroutine invariant_gradients

    !> t <- t + the sum of a d2I1/dg2 + b d2J/dg2 over the heights z, upper triangle. Both Hessians are
    !> polynomials in z: the sums of a z^n and b z^n are all that is needed of the heights.
    pure subroutine add_invariant_hessians(g, a, b, t)
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(in) :: a(0:4)          !! sums of a z^n
        real(wp), intent(in) :: b(0:3)          !! sums of b z^n
        real(wp), intent(inout) :: t(n_strains, n_strains)
        real(wp) :: xi, xi_1, a1, a3, e1, e3, d1, d3
        real(wp) :: r(0:4), r_zeta, r_zeta2, r_z2_zeta, r_q2, r_zq, r_f11, r_f31, b_q, b_q_zeta, b_z, cross

        xi = g(8)
        xi_1 = g(5)
        a1 = 1.0_wp + g(1)
        a3 = g(2)
        e1 = g(3)
        e3 = g(4)
        d1 = g(6)
        d3 = 1.0_wp + g(7)
        r = 2.0_wp*a
        r_zeta = r(1) + xi*r(2)
        r_zeta2 = r(2) + xi*(2.0_wp*r(3) + xi*r(4))
        r_z2_zeta = r(3) + xi*r(4)
        r_q2 = r(0) + 4.0_wp*xi*r_zeta
        r_zq = 4.0_wp*(r(1) + 2.0_wp*xi*r(2))
        r_f11 = a1*r(2) + e1*r_z2_zeta + xi_1*d1*r(4)
        r_f31 = a3*r(2) + e3*r_z2_zeta + xi_1*d3*r(4)
        b_q = b(0) + 2.0_wp*xi*b(1)
        b_q_zeta = b(1) + xi*(3.0_wp*b(2) + 2.0_wp*xi*b(3))
        b_z = 2.0_wp*b(1)
        cross = 3.0_wp*b(2) + 4.0_wp*xi*b(3)
        t(1, 1) = t(1, 1) + r(0)
        t(2, 2) = t(2, 2) + r(0)
        t(1, 3) = t(1, 3) + r_zeta
        t(2, 4) = t(2, 4) + r_zeta
        t(3, 3) = t(3, 3) + r_zeta2
        t(4, 4) = t(4, 4) + r_zeta2
        t(1, 5) = t(1, 5) + r(2)*d1
        t(2, 5) = t(2, 5) + r(2)*d3
        t(3, 5) = t(3, 5) + r_z2_zeta*d1
        t(4, 5) = t(4, 5) + r_z2_zeta*d3
        t(5, 5) = t(5, 5) + r(4)*(d1**2 + d3**2)
        t(1, 6) = t(1, 6) + r(2)*xi_1
        t(2, 6) = t(2, 6) - b_q
        t(3, 6) = t(3, 6) + r_z2_zeta*xi_1
        t(4, 6) = t(4, 6) - b_q_zeta
        t(5, 6) = t(5, 6) + r(4)*xi_1*d1 + r_f11
        t(6, 6) = t(6, 6) + r(4)*xi_1**2 + r_q2
        t(1, 7) = t(1, 7) + b_q
        t(2, 7) = t(2, 7) + r(2)*xi_1
        t(3, 7) = t(3, 7) + b_q_zeta
        t(4, 7) = t(4, 7) + r_z2_zeta*xi_1
        t(5, 7) = t(5, 7) + r(4)*xi_1*d3 + r_f31
        t(7, 7) = t(7, 7) + r(4)*xi_1**2 + r_q2
        t(1, 8) = t(1, 8) + r(2)*e1 + b_z*d3
        t(2, 8) = t(2, 8) + r(2)*e3 - b_z*d1
        t(3, 8) = t(3, 8) + r_z2_zeta*e1 + r_f11 + cross*d3
        t(4, 8) = t(4, 8) + r_z2_zeta*e3 + r_f31 - cross*d1
        t(5, 8) = t(5, 8) + r(4)*(e1*d1 + e3*d3)
        t(6, 8) = t(6, 8) + r(4)*xi_1*e1 + r_zq*d1 - b_z*a3 - cross*e3
        t(7, 8) = t(7, 8) + r(4)*xi_1*e3 + r_zq*d3 + b_z*a1 + cross*e1
        t(8, 8) = t(8, 8) + r(4)*(e1**2 + e3**2) + 4.0_wp*r(2)*(d1**2 + d3**2) &
                  + 4.0_wp*b(3)*(e1*d3 - e3*d1)
    end subroutine add_invariant_hessians

end module gb_section_gauss
