!> Section rule `gauss n` in lanes: gradient and Hessian of the energy of a unit length, Phi(g), in closed
!> form.
!>
!> Generalised strains as in gb_section_gauss, g = (u1', u3', y1', y3', xi', y1, y3, xi). With a = (1+u1',
!> u3'), e = (y1', y3'), d = (y1, 1+y3), c = xi e + xi' d, q = 1 + 2 xi z, zeta = z + xi z^2 and the cross
!> products A = a x d, B = e x d:
!>     f = a + z e + z^2 c,   I1 = f.f + q^2 d.d,   J = q (A + zeta B).
!> J does not depend on xi', and W = phi(I1) + psi(J) has no mixed term. So the Hessian is made of
!>     a dyad a height, 4 phi'' (dI1/2)(dI1/2)';
!> six moments of psi'', since dJ is a sum of three functions of z (q, q zeta, dJ/dxi) times constant vectors;
!>     moments of phi' and psi' in powers of z, for the second derivatives of I1 and J.
!> Gauss points come in pairs +-z and, for an odd number, one at z = 0, where most terms vanish. Chains
!> without a limit (jm beyond round-off, neo-Hookean) have phi'' = 0: no dyads.
module gb_section_lanes
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_element_columns, only: n_strains, n_section, n_moments, max_pairs, at_z, at_weight, &
        p0, p1, p2, p3, p4, g0, g1, g2, g3, r00, r01, r11, r02, r12, r22
    use gb_moments_lanes, only: measure_middle, measure_pair
    implicit none
    private

    public :: section_tangent

contains

    !> Gradient s and Hessian h (upper triangle, i <= j) of the energy. Where `room`, the smallest of J and,
    !> with a limit, 1 - (I1-2)/jm over the heights, is not positive the state is inadmissible: the lane's s
    !> and h are finite and meaningless. A limit that is not felt is looked at once a step (gb_energy_lanes).
    pure subroutine section_tangent(pairs, has_middle, is_square, has_limit, con, g, s, h, room)
        integer, intent(in) :: pairs                        !! pairs of heights
        logical, intent(in) :: has_middle                   !! whether there is a height z = 0
        logical, intent(in) :: is_square                    !! whether beta = -2 in every lane
        logical, intent(in) :: has_limit                    !! whether 1/jm is felt in some lane
        real(wp), intent(in) :: con(lanes, n_section)
        real(wp), intent(in) :: g(lanes, n_strains)
        real(wp), intent(out) :: s(lanes, n_strains)
        real(wp), intent(out) :: h(lanes, n_strains, n_strains)
        real(wp), intent(inout) :: room(lanes)              !! lowered to what is found here [-]
        real(wp) :: m(lanes, n_moments), v(lanes, n_strains, 2, max_pairs), pv(lanes, n_strains, 2, max_pairs)
        real(wp) :: bend(lanes)
        integer :: k, i, j

        ! Column by column: an array as a whole is cleared by a string instruction, which is slow to start.
        !GCC$ unroll 15
        do i = 1, n_moments
            m(:, i) = 0.0_wp
        end do
        do i = 1, lanes
            bend(i) = 0.0_wp
        end do
        if (has_middle) call measure_middle(is_square, has_limit, con, g, m, bend, room)
        do k = 1, pairs
            call measure_pair(is_square, has_limit, con, con(:, at_z + k), con(:, at_weight + k), g, m, &
                v(:, :, :, k), pv(:, :, :, k), room)
        end do
        call gradient_of_moments(g, m, s)
        call hessian_of_moments(g, m, bend, h)
        if (.not. has_limit) return
        do k = 1, pairs
            !GCC$ unroll 8
            do j = 1, n_strains
                !GCC$ unroll 8
                do i = 1, j
                    h(:, i, j) = h(:, i, j) + pv(:, i, 1, k)*v(:, j, 1, k) + pv(:, i, 2, k)*v(:, j, 2, k)
                end do
            end do
        end do
    end subroutine section_tangent

    !> s = dPhi/dg.
    pure subroutine gradient_of_moments(g, m, s)
        real(wp), intent(in) :: g(lanes, n_strains), m(lanes, n_moments)
        real(wp), intent(out) :: s(lanes, n_strains)
        real(wp) :: a1, a3, e1, e3, d1, d3, xi, dxi, c1, c3, n1, n3, m1, m3, gq, gz, qq
        integer :: l

        do l = 1, lanes
            a1 = 1.0_wp + g(l, 1)
            a3 = g(l, 2)
            e1 = g(l, 3)
            e3 = g(l, 4)
            dxi = g(l, 5)
            d1 = g(l, 6)
            d3 = 1.0_wp + g(l, 7)
            xi = g(l, 8)
            c1 = xi*e1 + dxi*d1
            c3 = xi*e3 + dxi*d3
            ! sums of P z^2 f, G q and G q zeta
            n1 = m(l, p2)*a1 + m(l, p3)*e1 + m(l, p4)*c1
            n3 = m(l, p2)*a3 + m(l, p3)*e3 + m(l, p4)*c3
            m1 = m(l, p1)*a1 + m(l, p2)*e1 + m(l, p3)*c1 + xi*n1
            m3 = m(l, p1)*a3 + m(l, p2)*e3 + m(l, p3)*c3 + xi*n3
            gq = m(l, g0) + 2.0_wp*xi*m(l, g1)
            gz = m(l, g1) + xi*(3.0_wp*m(l, g2) + 2.0_wp*xi*m(l, g3))
            qq = m(l, p0) + 4.0_wp*xi*(m(l, p1) + xi*m(l, p2))
            s(l, 1) = m(l, p0)*a1 + m(l, p1)*e1 + m(l, p2)*c1 + gq*d3
            s(l, 2) = m(l, p0)*a3 + m(l, p1)*e3 + m(l, p2)*c3 - gq*d1
            s(l, 3) = m1 + gz*d3
            s(l, 4) = m3 - gz*d1
            s(l, 5) = d1*n1 + d3*n3
            s(l, 6) = dxi*n1 + qq*d1 - gq*a3 - gz*e3
            s(l, 7) = dxi*n3 + qq*d3 + gq*a1 + gz*e1
            s(l, 8) = e1*n1 + e3*n3 + 2.0_wp*(d1*d1 + d3*d3)*(m(l, p1) + 2.0_wp*xi*m(l, p2)) &
                      + 2.0_wp*(a1*d3 - a3*d1)*m(l, g1) &
                      + (e1*d3 - e3*d1)*(3.0_wp*m(l, g2) + 4.0_wp*xi*m(l, g3))
        end do
    end subroutine gradient_of_moments

    !> The part of the Hessian that the moments give, and the dyad of the height z = 0.
    pure subroutine hessian_of_moments(g, m, bend, h)
        real(wp), intent(in) :: g(lanes, n_strains), m(lanes, n_moments), bend(lanes)
        real(wp), intent(inout) :: h(lanes, n_strains, n_strains)
        real(wp) :: a1, a3, e1, e3, d1, d3, xi, dxi, c1, c3, n1, n3, gq, gz, gx, pz, pzz, pk, pkz, w1, w3, &
            x1, &
            x3, b, pd, t1, t3, u1, u3
        integer :: l

        do l = 1, lanes
            a1 = 1.0_wp + g(l, 1)
            a3 = g(l, 2)
            e1 = g(l, 3)
            e3 = g(l, 4)
            dxi = g(l, 5)
            d1 = g(l, 6)
            d3 = 1.0_wp + g(l, 7)
            xi = g(l, 8)
            c1 = xi*e1 + dxi*d1
            c3 = xi*e3 + dxi*d3
            b = e1*d3 - e3*d1
            n1 = m(l, p2)*a1 + m(l, p3)*e1 + m(l, p4)*c1
            n3 = m(l, p2)*a3 + m(l, p3)*e3 + m(l, p4)*c3
            gq = m(l, g0) + 2.0_wp*xi*m(l, g1)
            gz = m(l, g1) + xi*(3.0_wp*m(l, g2) + 2.0_wp*xi*m(l, g3))
            gx = 3.0_wp*m(l, g2) + 4.0_wp*xi*m(l, g3)
            pkz = m(l, p3) + xi*m(l, p4)            ! sum of P z^2 zeta
            pz = m(l, p1) + xi*m(l, p2)
            pzz = m(l, p2) + xi*(m(l, p3) + pkz)
            pk = dxi*m(l, p2)
            pd = 4.0_wp*(m(l, p1) + 2.0_wp*xi*m(l, p2))
            t1 = bend(l)*a1
            t3 = bend(l)*a3
            u1 = bend(l)*d1
            u3 = bend(l)*d3
            h(l, 1, 1) = m(l, p0) + m(l, r00)*d3*d3 + t1*a1
            h(l, 1, 2) = -m(l, r00)*d1*d3 + t1*a3
            h(l, 2, 2) = m(l, p0) + m(l, r00)*d1*d1 + t3*a3
            h(l, 1, 3) = pz + m(l, r01)*d3*d3
            h(l, 2, 3) = -m(l, r01)*d1*d3
            h(l, 1, 4) = -m(l, r01)*d1*d3
            h(l, 2, 4) = pz + m(l, r01)*d1*d1
            h(l, 3, 3) = pzz + m(l, r11)*d3*d3
            h(l, 3, 4) = -m(l, r11)*d1*d3
            h(l, 4, 4) = pzz + m(l, r11)*d1*d1
            h(l, 1, 5) = m(l, p2)*d1
            h(l, 2, 5) = m(l, p2)*d3
            h(l, 3, 5) = pkz*d1
            h(l, 4, 5) = pkz*d3
            h(l, 5, 5) = m(l, p4)*(d1*d1 + d3*d3)
            ! R-weighted dJ/dd: w goes with dJ/da, x with dJ/de
            w1 = -m(l, r00)*a3 - m(l, r01)*e3
            w3 = m(l, r00)*a1 + m(l, r01)*e1
            x1 = -m(l, r01)*a3 - m(l, r11)*e3
            x3 = m(l, r01)*a1 + m(l, r11)*e1
            h(l, 1, 6) = pk + d3*w1 + t1*d1
            h(l, 2, 6) = -gq - d1*w1 + t3*d1
            h(l, 3, 6) = dxi*pkz + d3*x1
            h(l, 4, 6) = -gz - d1*x1
            h(l, 5, 6) = dxi*m(l, p4)*d1 + n1
            h(l, 1, 7) = gq + d3*w3 + t1*d3
            h(l, 2, 7) = pk - d1*w3 + t3*d3
            h(l, 3, 7) = gz + d3*x3
            h(l, 4, 7) = dxi*pkz - d1*x3
            h(l, 5, 7) = dxi*m(l, p4)*d3 + n3
            pk = dxi*dxi*m(l, p4) + m(l, p0) + 4.0_wp*xi*(m(l, p1) + xi*m(l, p2))
            h(l, 6, 6) = pk - a3*w1 - e3*x1 + u1*d1
            h(l, 6, 7) = a1*w1 + e1*x1 + u1*d3
            h(l, 7, 7) = pk + a1*w3 + e1*x3 + u3*d3
            h(l, 1, 8) = m(l, p2)*e1 + (2.0_wp*m(l, g1) + m(l, r02))*d3
            h(l, 2, 8) = m(l, p2)*e3 - (2.0_wp*m(l, g1) + m(l, r02))*d1
            h(l, 3, 8) = pkz*e1 + n1 + (gx + m(l, r12))*d3
            h(l, 4, 8) = pkz*e3 + n3 - (gx + m(l, r12))*d1
            h(l, 5, 8) = m(l, p4)*(e1*d1 + e3*d3)
            w1 = 2.0_wp*m(l, g1) + m(l, r02)
            x1 = gx + m(l, r12)
            h(l, 6, 8) = dxi*m(l, p4)*e1 + pd*d1 - w1*a3 - x1*e3
            h(l, 7, 8) = dxi*m(l, p4)*e3 + pd*d3 + w1*a1 + x1*e1
            h(l, 8, 8) = m(l, p4)*(e1*e1 + e3*e3) + 4.0_wp*m(l, p2)*(d1*d1 + d3*d3) &
                         + 4.0_wp*m(l, g3)*b + m(l, r22)
        end do
    end subroutine hessian_of_moments

end module gb_section_lanes
