!> Section rule `linear`: the paper's resultants A S0 and I S1 of a second Piola-Kirchhoff stress that is
!> linear through the thickness, eq. (20, 21, 24, 25, 37, 38, 41) corrected. Virtual work a unit length:
!>     A S0 : dE0 + I S1 : dE1,   E0 = (C0 - I)/2,  E1 = C1/2,   S1 = CC(C0) : E1.
!> This is not the derivative of an energy (S0's own expansion has second-order terms that are left out), so
!> the tangent is unsymmetric where E1 is not zero, and a motion does not conserve energy exactly.
!>
!> Generalised strains as in gb_section_gauss; xi' does not appear. Tensors are in the order 11, 33, 13,
!> strains with the engineering shear 2 E13. With a = (1+u1', u3'), d = (y1, 1+y3), e = (y1', y3'): F0 = [a
!> d], F1 = [e 2 xi d].
module gb_section_linear
    use gb_kinds, only: wp
    use gb_gent, only: n_constants, is_admissible, gent_energy, power_of_j
    use gb_section_gauss, only: n_strains, gauss_invariants
    implicit none
    private

    public :: linear_energy, linear_stress, linear_tangent, linear_fibre

contains

    !> The energy that the rule's stresses belong to near a state without bending, A W(C0) + I/2 S1 : E1 [F];
    !> the energy ledger uses it. Bending at finite strain makes it differ from the work done.
    pure subroutine linear_energy(area, inertia, p, g, energy, admissible)
        real(wp), intent(in) :: area                !! A [L^2]
        real(wp), intent(in) :: inertia             !! I [L^4]
        real(wp), intent(in) :: p(n_constants)
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: energy
        logical, intent(out) :: admissible
        real(wp) :: i1_minus_2, j, e1(3), s0(3), s1(3)

        energy = 0.0_wp
        call gauss_invariants(0.0_wp, g, i1_minus_2, j)
        admissible = is_admissible(i1_minus_2, j, p(4))
        if (.not. admissible) return
        call bending_strain(g, e1)
        call stresses(p, g, i1_minus_2, j, e1, s0, s1)
        energy = area*gent_energy(p, i1_minus_2, j) + 0.5_wp*inertia*dot_product(s1, e1)
    end subroutine linear_energy

    !> Generalised stresses s = A S0 : dE0/dg + I S1 : dE1/dg.
    pure subroutine linear_stress(area, inertia, p, g, s, admissible)
        real(wp), intent(in) :: area, inertia, p(n_constants), g(n_strains)
        real(wp), intent(out) :: s(n_strains)
        logical, intent(out) :: admissible
        real(wp) :: i1_minus_2, j, e1(3), s0(3), s1(3), d0(3, n_strains), d1(3, n_strains)

        s = 0.0_wp
        call gauss_invariants(0.0_wp, g, i1_minus_2, j)
        admissible = is_admissible(i1_minus_2, j, p(4))
        if (.not. admissible) return
        call bending_strain(g, e1)
        call stresses(p, g, i1_minus_2, j, e1, s0, s1)
        call strain_gradients(g, d0, d1)
        s = area*matmul(s0, d0) + inertia*matmul(s1, d1)
    end subroutine linear_stress

    !> Generalised stresses s and their exact tangent t = ds/dg (unsymmetric), eq. (24, 25) corrected:
    !> A (dE0' CC0 dE0 + S0 d2E0) + I (dE1' (CC1 dE0 + CC0 dE1) + S1 d2E1).
    pure subroutine linear_tangent(area, inertia, p, g, s, t, admissible)
        real(wp), intent(in) :: area, inertia, p(n_constants), g(n_strains)
        real(wp), intent(out) :: s(n_strains), t(n_strains, n_strains)
        logical, intent(out) :: admissible
        real(wp) :: i1_minus_2, j, e1(3), s0(3), s1(3), d0(3, n_strains), d1(3, n_strains), cc0(3, 3), &
            cc1(3, 3)

        s = 0.0_wp
        t = 0.0_wp
        call gauss_invariants(0.0_wp, g, i1_minus_2, j)
        admissible = is_admissible(i1_minus_2, j, p(4))
        if (.not. admissible) return
        call bending_strain(g, e1)
        call stresses(p, g, i1_minus_2, j, e1, s0, s1)
        call strain_gradients(g, d0, d1)
        s = area*matmul(s0, d0) + inertia*matmul(s1, d1)
        call moduli(p, g, i1_minus_2, j, e1, cc0, cc1)
        t = area*matmul(transpose(d0), matmul(cc0, d0)) &
            + inertia*matmul(transpose(d1), matmul(cc1, d0) + matmul(cc0, d1))
        call add_second_gradients(g, area*s0, inertia*s1, t)
    end subroutine linear_tangent

    !> The rule's own stress at the height z, S0 + z S1 as (11, 33, 13) [F/L^2].
    pure subroutine linear_fibre(p, g, z, s, admissible)
        real(wp), intent(in) :: p(n_constants), g(n_strains)
        real(wp), intent(in) :: z                   !! X3 [L]
        real(wp), intent(out) :: s(3)
        logical, intent(out) :: admissible
        real(wp) :: i1_minus_2, j, e1(3), s0(3), s1(3)

        s = 0.0_wp
        call gauss_invariants(0.0_wp, g, i1_minus_2, j)
        admissible = is_admissible(i1_minus_2, j, p(4))
        if (.not. admissible) return
        call bending_strain(g, e1)
        call stresses(p, g, i1_minus_2, j, e1, s0, s1)
        s = s0 + z*s1
    end subroutine linear_fibre

    !> E1 = C1/2, C1 = F0'F1 + F1'F0, as (11, 33, 2x13).
    pure subroutine bending_strain(g, e1)
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: e1(3)          !! [1/L]
        real(wp) :: a(2), d(2), e(2)

        call vectors(g, a, d, e)
        e1(1) = dot_product(a, e)
        e1(2) = 2.0_wp*g(8)*dot_product(d, d)
        e1(3) = 2.0_wp*g(8)*dot_product(a, d) + dot_product(d, e)
    end subroutine bending_strain

    !> a = (1+u1', u3'), d = (y1, 1+y3), e = (y1', y3').
    pure subroutine vectors(g, a, d, e)
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: a(2), d(2), e(2)

        a = [1.0_wp + g(1), g(2)]
        d = [g(6), 1.0_wp + g(7)]
        e = g(3:4)
    end subroutine vectors

    !> C0^-1 as (11, 33, 13).
    pure subroutine inverse_metric(g, j, inverse)
        real(wp), intent(in) :: g(n_strains), j
        real(wp), intent(out) :: inverse(3)
        real(wp) :: a(2), d(2), e(2)

        call vectors(g, a, d, e)
        inverse = [dot_product(d, d), dot_product(a, a), -dot_product(a, d)]/j**2
    end subroutine inverse_metric

    !> -C0^-1 X C0^-1 of a symmetric X given as strain (11, 33, 2x13), as (11, 33, 13).
    pure function sandwich(inverse, x) result(y)
        real(wp), intent(in) :: inverse(3), x(3)
        real(wp) :: y(3)
        real(wp) :: m(2, 2)

        m = reshape([inverse(1), inverse(3), inverse(3), inverse(2)], [2, 2])
        m = -matmul(m, matmul(reshape([x(1), 0.5_wp*x(3), 0.5_wp*x(3), x(2)], [2, 2]), m))
        y = [m(1, 1), m(2, 2), m(1, 2)]
    end function sandwich

    !> S0 and S1 as (11, 33, 13), eq. (20, 21) corrected:
    !> S0 = a I + b C0*,  S1 = a' I11 I + b C1* + c J0^(-beta-1) J1 C0*,  C1* = -C0^-1 C1 C0^-1.
    pure subroutine stresses(p, g, i1_minus_2, j, e1, s0, s1)
        real(wp), intent(in) :: p(n_constants), g(n_strains), i1_minus_2, j, e1(3)
        real(wp), intent(out) :: s0(3)              !! [F/L^2]
        real(wp), intent(out) :: s1(3)              !! [F/L^3]
        real(wp), parameter :: identity(3) = [1.0_wp, 1.0_wp, 0.0_wp]
        real(wp) :: room, a, da, b, power, inverse(3), trace_c1

        room = 1.0_wp/(1.0_wp - i1_minus_2*p(4))
        a = p(1)*room
        da = a*p(4)*room
        power = power_of_j(j, p(3))
        b = -p(1) + p(2)/p(3)*(1.0_wp - power)
        call inverse_metric(g, j, inverse)
        s0 = a*identity + b*inverse
        ! J1/J0 = tr(F0^-1 F1) = C0^-1 : E1, since the antisymmetric part of F0'F1 drops out.
        trace_c1 = 2.0_wp*(e1(1) + e1(2))
        s1 = (da*trace_c1)*identity + 2.0_wp*b*sandwich(inverse, e1) + (p(2)*power*dot_product(inverse, &
            e1))*inverse
    end subroutine stresses

    !> CC0 = dS/dE at C0 and CC1 = dS1/dE0 at fixed E1, in (11, 33, 13), eq. (22, 24, 25) corrected.
    pure subroutine moduli(p, g, i1_minus_2, j, e1, cc0, cc1)
        real(wp), intent(in) :: p(n_constants), g(n_strains), i1_minus_2, j, e1(3)
        real(wp), intent(out) :: cc0(3, 3)          !! [F/L^2]
        real(wp), intent(out) :: cc1(3, 3)          !! [F/L^3]
        real(wp), parameter :: identity(3) = [1.0_wp, 1.0_wp, 0.0_wp]
        real(wp) :: room, da, dda, b, power, c0(3), c1(3), j1_over_j, trace_c1, fourth(3, 3), mixed(3, 3)

        room = 1.0_wp/(1.0_wp - i1_minus_2*p(4))
        da = p(1)*p(4)*room**2
        dda = 2.0_wp*da*p(4)*room
        power = power_of_j(j, p(3))
        b = -p(1) + p(2)/p(3)*(1.0_wp - power)
        call inverse_metric(g, j, c0)
        c1 = 2.0_wp*sandwich(c0, e1)
        j1_over_j = dot_product(c0, e1)
        trace_c1 = 2.0_wp*(e1(1) + e1(2))
        fourth = symmetric_product(c0, c0)
        mixed = symmetric_product(c0, c1) + symmetric_product(c1, c0)
        cc0 = 2.0_wp*da*outer(identity, identity) + p(2)*power*outer(c0, c0) - b*fourth
        cc1 = 2.0_wp*dda*trace_c1*outer(identity, identity) + p(2)*power*(outer(c0, c1) + outer(c1, c0)) &
              - p(2)*p(3)*power*j1_over_j*outer(c0, c0) - b*mixed - p(2)*power*j1_over_j*fourth
    end subroutine moduli

    pure function outer(x, y) result(xy)
        real(wp), intent(in) :: x(3), y(3)
        real(wp) :: xy(3, 3)

        xy = spread(x, 2, 3)*spread(y, 1, 3)
    end function outer

    !> X (x)bar Y + X (x)ubar Y, X_ik Y_jl + X_il Y_jk, averaged over i <-> j, in (11, 33, 13).
    pure function symmetric_product(x, y) result(xy)
        real(wp), intent(in) :: x(3), y(3)
        real(wp) :: xy(3, 3)
        integer, parameter :: row(3) = [1, 2, 1], column(3) = [1, 2, 2]
        real(wp) :: a(2, 2), b(2, 2)
        integer :: m, n

        a = reshape([x(1), x(3), x(3), x(2)], [2, 2])
        b = reshape([y(1), y(3), y(3), y(2)], [2, 2])
        do n = 1, 3
            do m = 1, 3
                associate (i => row(m), j => column(m), k => row(n), l => column(n))
                    xy(m, n) = 0.5_wp*(a(i, k)*b(j, l) + a(i, l)*b(j, k) + a(j, k)*b(i, l) + a(j, l)*b(i, k))
                end associate
            end do
        end do
    end function symmetric_product

    !> dE0/dg and dE1/dg, rows (11, 33, 2x13).
    pure subroutine strain_gradients(g, d0, d1)
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: d0(3, n_strains), d1(3, n_strains)
        real(wp) :: a(2), d(2), e(2), xi2

        call vectors(g, a, d, e)
        xi2 = 2.0_wp*g(8)
        d0 = 0.0_wp
        d0(1, 1:2) = a
        d0(2, 6:7) = d
        d0(3, 1:2) = d
        d0(3, 6:7) = a
        d1 = 0.0_wp
        d1(1, 1:2) = e
        d1(1, 3:4) = a
        d1(2, 6:7) = 2.0_wp*xi2*d
        d1(2, 8) = 2.0_wp*dot_product(d, d)
        d1(3, 1:2) = xi2*d
        d1(3, 3:4) = d
        d1(3, 6:7) = xi2*a + e
        d1(3, 8) = 2.0_wp*dot_product(a, d)
    end subroutine strain_gradients

    !> t <- t + n0 : d2E0/dg2 + n1 : d2E1/dg2, the geometric part (eq. 50).
    pure subroutine add_second_gradients(g, n0, n1, t)
        real(wp), intent(in) :: g(n_strains), n0(3), n1(3)
        real(wp), intent(inout) :: t(n_strains, n_strains)
        real(wp) :: a(2), d(2), e(2), xi2, couple
        integer :: i

        call vectors(g, a, d, e)
        xi2 = 2.0_wp*g(8)
        do i = 1, 2
            t(i, i) = t(i, i) + n0(1)
            t(5 + i, 5 + i) = t(5 + i, 5 + i) + n0(2) + 2.0_wp*xi2*n1(2)
            call add_pair(t, i, 5 + i, n0(3) + xi2*n1(3))
            call add_pair(t, i, 2 + i, n1(1))
            call add_pair(t, 2 + i, 5 + i, n1(3))
            call add_pair(t, i, 8, 2.0_wp*d(i)*n1(3))
            couple = 4.0_wp*d(i)*n1(2) + 2.0_wp*a(i)*n1(3)
            call add_pair(t, 5 + i, 8, couple)
        end do
    end subroutine add_second_gradients

    pure subroutine add_pair(t, m, n, value)
        real(wp), intent(inout) :: t(n_strains, n_strains)
        integer, intent(in) :: m, n
        real(wp), intent(in) :: value

        t(m, n) = t(m, n) + value
        t(n, m) = t(n, m) + value
    end subroutine add_pair

end module gb_section_linear
