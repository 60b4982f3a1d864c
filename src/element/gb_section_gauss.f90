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
        integer :: i, m, n

        s = 0.0_wp
        t = 0.0_wp
        do i = 1, nz
            call gauss_invariants(z(i), g, i1_minus_2, j)
            admissible = is_admissible(i1_minus_2, j, p(4))
            if (.not. admissible) return
            call gent_curvatures(p, i1_minus_2, j, phi_1, psi_1, phi_2, psi_2)
            call invariant_gradients(z(i), g, v, w)
            s = s + (wz(i)*phi_1)*v + (wz(i)*psi_1)*w
            phi_2 = wz(i)*phi_2
            psi_2 = wz(i)*psi_2
            do n = 1, n_strains
                t(1:n, n) = t(1:n, n) + (phi_2*v(n))*v(1:n) + (psi_2*w(n))*w(1:n)
            end do
            call add_invariant_hessians(z(i), g, 2.0_wp*wz(i)*phi_1, wz(i)*psi_1, t)
        end do
        do n = 1, n_strains - 1
            do m = n + 1, n_strains
                t(m, n) = t(n, m)
            end do
        end do
    end subroutine gauss_tangent

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

    !> t <- t + half_i1 (d2I1/dg2)/2 + by_j d2J/dg2 at height z, upper triangle.
    pure subroutine add_invariant_hessians(z, g, half_i1, by_j, t)
        real(wp), intent(in) :: z, g(n_strains), half_i1, by_j
        real(wp), intent(inout) :: t(n_strains, n_strains)
        real(wp) :: z2, zeta, k, q, a1, a3, e1, e3, d1, d3, f11, f31, r, rq, rz2, rzz2, rkz2, jq, cross

        z2 = z**2
        zeta = z + g(8)*z2
        k = z2*g(5)
        q = 1.0_wp + 2.0_wp*g(8)*z
        a1 = 1.0_wp + g(1)
        a3 = g(2)
        e1 = g(3)
        e3 = g(4)
        d1 = g(6)
        d3 = 1.0_wp + g(7)
        f11 = a1 + zeta*e1 + k*d1
        f31 = a3 + zeta*e3 + k*d3
        r = half_i1
        rz2 = r*z2
        rzz2 = rz2*zeta
        rkz2 = rz2*k
        rq = 4.0_wp*r*z*q
        jq = by_j*q
        cross = by_j*(2.0_wp*z*zeta + q*z2)
        t(1, 1) = t(1, 1) + r
        t(2, 2) = t(2, 2) + r
        t(1, 3) = t(1, 3) + r*zeta
        t(2, 4) = t(2, 4) + r*zeta
        t(3, 3) = t(3, 3) + r*zeta**2
        t(4, 4) = t(4, 4) + r*zeta**2
        t(1, 5) = t(1, 5) + rz2*d1
        t(2, 5) = t(2, 5) + rz2*d3
        t(3, 5) = t(3, 5) + rzz2*d1
        t(4, 5) = t(4, 5) + rzz2*d3
        t(5, 5) = t(5, 5) + rz2*z2*(d1**2 + d3**2)
        t(1, 6) = t(1, 6) + r*k
        t(2, 6) = t(2, 6) - jq
        t(3, 6) = t(3, 6) + r*k*zeta
        t(4, 6) = t(4, 6) - jq*zeta
        t(5, 6) = t(5, 6) + rkz2*d1 + rz2*f11
        t(6, 6) = t(6, 6) + r*(k**2 + q**2)
        t(1, 7) = t(1, 7) + jq
        t(2, 7) = t(2, 7) + r*k
        t(3, 7) = t(3, 7) + jq*zeta
        t(4, 7) = t(4, 7) + r*k*zeta
        t(5, 7) = t(5, 7) + rkz2*d3 + rz2*f31
        t(7, 7) = t(7, 7) + r*(k**2 + q**2)
        t(1, 8) = t(1, 8) + rz2*e1 + 2.0_wp*by_j*z*d3
        t(2, 8) = t(2, 8) + rz2*e3 - 2.0_wp*by_j*z*d1
        t(3, 8) = t(3, 8) + rzz2*e1 + rz2*f11 + cross*d3
        t(4, 8) = t(4, 8) + rzz2*e3 + rz2*f31 - cross*d1
        t(5, 8) = t(5, 8) + rz2*z2*(e1*d1 + e3*d3)
        t(6, 8) = t(6, 8) + rkz2*e1 + rq*d1 - 2.0_wp*by_j*z*a3 - cross*e3
        t(7, 8) = t(7, 8) + rkz2*e3 + rq*d3 + 2.0_wp*by_j*z*a1 + cross*e1
        t(8, 8) = t(8, 8) + rz2*z2*(e1**2 + e3**2) + 4.0_wp*rz2*(d1**2 + d3**2) &
                  + 4.0_wp*by_j*z*z2*(e1*d3 - e3*d1)
    end subroutine add_invariant_hessians

end module gb_section_gauss
