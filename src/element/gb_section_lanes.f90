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
    use gb_kinds, only: wp, log1p
    use gb_lanes, only: lanes
    implicit none
    private

    integer, parameter, public :: max_pairs = 5             !! pairs of heights at most
    integer, parameter, public :: n_strains = 8

    !> Columns of the constants that a section's kernels read, con(lanes, n_section).
    integer, parameter, public :: at_mu = 1                 !! mu [F/L^2]
    integer, parameter, public :: at_log = 2                !! mu - c/beta, which multiplies -ln J [F/L^2]
    integer, parameter, public :: at_power = 3              !! -c/beta [F/L^2]
    integer, parameter, public :: at_bend = 4               !! (c/beta) (beta + 1) [F/L^2]
    integer, parameter, public :: at_minus_beta = 5         !! -beta [-]
    integer, parameter, public :: at_inverse_jm = 6         !! 1/jm [-]
    integer, parameter, public :: at_middle = 7             !! weight of the height z = 0
    integer, parameter, public :: at_z = 7                  !! + k: height of the k-th pair [L]
    integer, parameter, public :: at_weight = at_z + max_pairs  !! + k: weight of each point of the k-th pair
    integer, parameter, public :: n_section = at_weight + max_pairs

    !> Columns of the moments over the section. P = 2 phi' weight times z^0 ... z^4; G = psi' weight times
    !> z^0 ... z^3; R = psi'' weight times products of q, q zeta and dJ/dxi.
    integer, parameter :: p0 = 1, p1 = 2, p2 = 3, p3 = 4, p4 = 5, g0 = 6, g1 = 7, g2 = 8, g3 = 9, &
        r00 = 10, r01 = 11, r11 = 12, r02 = 13, r12 = 14, r22 = 15, n_moments = 15

    public :: section_tangent

contains

    !> Gradient s and Hessian h (upper triangle, i <= j) of the energy. Where `room`, the smallest of J and
    !> 1 - (I1-2)/jm over the heights, is not positive the state is inadmissible: the lane's s and h are
    !> finite and meaningless.
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

    !> J^-beta.
    pure subroutine power_of_j(is_square, con, j, power)
        logical, intent(in) :: is_square
        real(wp), intent(in) :: con(lanes, n_section), j(lanes)
        real(wp), intent(out) :: power(lanes)

        if (is_square) then
            power = j*j
        else
            power = j**con(:, at_minus_beta)
        end if
    end subroutine power_of_j

    !> The height z = 0: f = a, q = 1, zeta = 0. Its moments, and the factor of its dyad, 4 phi'' weight.
    pure subroutine measure_middle(is_square, has_limit, con, g, m, bend, room)
        logical, intent(in) :: is_square, has_limit
        real(wp), intent(in) :: con(lanes, n_section), g(lanes, n_strains)
        real(wp), intent(inout) :: m(lanes, n_moments), bend(lanes), room(lanes)
        real(wp), dimension(lanes) :: j, power, left
        real(wp) :: a1, a3, d1, d3, by_room, by_j
        integer :: l

        do l = 1, lanes
            j(l) = (1.0_wp + g(l, 1))*(1.0_wp + g(l, 7)) - g(l, 2)*g(l, 6)
            room(l) = min(room(l), j(l))
            j(l) = merge(j(l), 1.0_wp, j(l) > 0.0_wp)
        end do
        call power_of_j(is_square, con, j, power)
        do l = 1, lanes
            by_j = 1.0_wp/j(l)
            m(l, p0) = con(l, at_middle)*con(l, at_mu)
            m(l, g0) = con(l, at_middle)*(con(l, at_power)*power(l) - con(l, at_log))*by_j
            m(l, r00) = con(l, at_middle)*(con(l, at_bend)*power(l) + con(l, at_log))*by_j*by_j
        end do
        if (.not. has_limit) return
        do l = 1, lanes
            a1 = 1.0_wp + g(l, 1)
            a3 = g(l, 2)
            d1 = g(l, 6)
            d3 = 1.0_wp + g(l, 7)
            left(l) = 1.0_wp - (a1*a1 + a3*a3 + d1*d1 + d3*d3 - 2.0_wp)*con(l, at_inverse_jm)
            room(l) = min(room(l), left(l))
            left(l) = merge(left(l), 1.0_wp, left(l) > 0.0_wp)
        end do
        do l = 1, lanes
            by_room = 1.0_wp/left(l)
            m(l, p0) = m(l, p0)*by_room
            bend(l) = 2.0_wp*m(l, p0)*con(l, at_inverse_jm)*by_room
        end do
    end subroutine measure_middle

    !> A pair of heights +-z: their moments, and for their dyads v = dI1/2 and pv = 4 phi'' weight v.
    pure subroutine measure_pair(is_square, has_limit, con, z, weight, g, m, v, pv, room)
        logical, intent(in) :: is_square, has_limit
        real(wp), intent(in) :: con(lanes, n_section)
        real(wp), intent(in) :: z(lanes), weight(lanes)
        real(wp), intent(in) :: g(lanes, n_strains)
        real(wp), intent(inout) :: m(lanes, n_moments), room(lanes)
        real(wp), intent(inout) :: v(lanes, n_strains, 2), pv(lanes, n_strains, 2)
        real(wp), dimension(lanes, 2) :: j, power, f1, f3, by_room, p

        call volumes_of_pair(z, g, j, room)
        call power_of_j(is_square, con, j(:, 1), power(:, 1))
        call power_of_j(is_square, con, j(:, 2), power(:, 2))
        call add_volume_moments(con, z, weight, g, j, power, m)
        if (has_limit) then
            call rooms_of_pair(con, z, weight, g, f1, f3, by_room, p, room)
            call add_moments(z, p, m)
            call gradients_of_pair(z, g, f1, f3, v)
            call bend_pair(con, by_room, p, v, pv)
        else
            call add_even_moments(con, z, weight, m)
        end if
    end subroutine measure_pair

    !> J (replaced by 1 where not positive) at the heights +z and -z.
    pure subroutine volumes_of_pair(z, g, j, room)
        real(wp), intent(in) :: z(lanes), g(lanes, n_strains)
        real(wp), intent(out) :: j(lanes, 2)
        real(wp), intent(inout) :: room(lanes)
        real(wp) :: d1, d3, xi, h, xz, a, b, upper, lower
        integer :: l

        do l = 1, lanes
            d1 = g(l, 6)
            d3 = 1.0_wp + g(l, 7)
            xi = g(l, 8)
            h = z(l)
            xz = xi*h*h
            a = (1.0_wp + g(l, 1))*d3 - g(l, 2)*d1
            b = g(l, 3)*d3 - g(l, 4)*d1
            upper = (1.0_wp + 2.0_wp*xi*h)*(a + (xz + h)*b)
            lower = (1.0_wp - 2.0_wp*xi*h)*(a + (xz - h)*b)
            room(l) = min(room(l), upper, lower)
            j(l, 1) = merge(upper, 1.0_wp, upper > 0.0_wp)
            j(l, 2) = merge(lower, 1.0_wp, lower > 0.0_wp)
        end do
    end subroutine volumes_of_pair

    !> At the heights +z and -z: (F11, F31), by_room = 1/(1 - (I1-2)/jm), which is 1 where that is not
    !> positive, and p = 2 phi' weight.
    pure subroutine rooms_of_pair(con, z, weight, g, f1, f3, by_room, p, room)
        real(wp), intent(in) :: con(lanes, n_section), z(lanes), weight(lanes), g(lanes, n_strains)
        real(wp), intent(out), dimension(lanes, 2) :: f1, f3, by_room, p
        real(wp), intent(inout) :: room(lanes)
        real(wp) :: d1, d3, xi, h, k, xz, even1, even3, odd1, odd3, dd, q, left(lanes)
        integer :: l, side

        !GCC$ unroll 2
        do side = 1, 2
            do l = 1, lanes
                d1 = g(l, 6)
                d3 = 1.0_wp + g(l, 7)
                xi = g(l, 8)
                h = merge(z(l), -z(l), side == 1)
                k = h*h*g(l, 5)
                xz = xi*h*h
                even1 = 1.0_wp + g(l, 1) + xz*g(l, 3) + k*d1
                even3 = g(l, 2) + xz*g(l, 4) + k*d3
                odd1 = h*g(l, 3)
                odd3 = h*g(l, 4)
                dd = d1*d1 + d3*d3
                q = 1.0_wp + 2.0_wp*xi*h
                f1(l, side) = even1 + odd1
                f3(l, side) = even3 + odd3
                left(l) = 1.0_wp - (f1(l, side)*f1(l, side) + f3(l, side)*f3(l, side) + q*q*dd - 2.0_wp) &
                    *con(l, at_inverse_jm)
                room(l) = min(room(l), left(l))
                left(l) = merge(left(l), 1.0_wp, left(l) > 0.0_wp)
            end do
            do l = 1, lanes
                by_room(l, side) = 1.0_wp/left(l)
                p(l, side) = weight(l)*con(l, at_mu)*by_room(l, side)
            end do
        end do
    end subroutine rooms_of_pair

    !> dI1/2 at the heights +z and -z.
    pure subroutine gradients_of_pair(z, g, f1, f3, v)
        real(wp), intent(in) :: z(lanes), g(lanes, n_strains)
        real(wp), intent(in), dimension(lanes, 2) :: f1, f3
        real(wp), intent(out) :: v(lanes, n_strains, 2)
        real(wp) :: d1, d3, xi, h, hh, dd, q, qq, zeta, k
        integer :: l, side

        !GCC$ unroll 2
        do side = 1, 2
            do l = 1, lanes
                d1 = g(l, 6)
                d3 = 1.0_wp + g(l, 7)
                xi = g(l, 8)
                h = merge(z(l), -z(l), side == 1)
                hh = h*h
                k = hh*g(l, 5)
                dd = d1*d1 + d3*d3
                q = 1.0_wp + 2.0_wp*xi*h
                qq = q*q
                zeta = xi*hh + h
                v(l, 1, side) = f1(l, side)
                v(l, 2, side) = f3(l, side)
                v(l, 3, side) = zeta*f1(l, side)
                v(l, 4, side) = zeta*f3(l, side)
                v(l, 5, side) = hh*(d1*f1(l, side) + d3*f3(l, side))
                v(l, 6, side) = k*f1(l, side) + qq*d1
                v(l, 7, side) = k*f3(l, side) + qq*d3
                v(l, 8, side) = hh*(g(l, 3)*f1(l, side) + g(l, 4)*f3(l, side)) + 2.0_wp*h*q*dd
            end do
        end do
    end subroutine gradients_of_pair

    !> pv = 4 phi'' weight v at both heights.
    pure subroutine bend_pair(con, by_room, p, v, pv)
        real(wp), intent(in) :: con(lanes, n_section)
        real(wp), intent(in), dimension(lanes, 2) :: by_room, p
        real(wp), intent(in) :: v(lanes, n_strains, 2)
        real(wp), intent(out) :: pv(lanes, n_strains, 2)
        real(wp) :: bend(lanes)
        integer :: i, side

        !GCC$ unroll 2
        do side = 1, 2
            bend = 2.0_wp*p(:, side)*con(:, at_inverse_jm)*by_room(:, side)
            !GCC$ unroll 8
            do i = 1, n_strains
                pv(:, i, side) = bend*v(:, i, side)
            end do
        end do
    end subroutine bend_pair

    !> m <- m + the moments of P of a pair of heights.
    pure subroutine add_moments(z, p, m)
        real(wp), intent(in) :: z(lanes), p(lanes, 2)
        real(wp), intent(inout) :: m(lanes, n_moments)
        real(wp) :: h, hh, even, odd
        integer :: l

        do l = 1, lanes
            h = z(l)
            hh = h*h
            even = p(l, 1) + p(l, 2)
            odd = h*(p(l, 1) - p(l, 2))
            m(l, p0) = m(l, p0) + even
            m(l, p1) = m(l, p1) + odd
            m(l, p2) = m(l, p2) + hh*even
            m(l, p3) = m(l, p3) + hh*odd
            m(l, p4) = m(l, p4) + hh*hh*even
        end do
    end subroutine add_moments

    !> The same without a limit: P is mu weight.
    pure subroutine add_even_moments(con, z, weight, m)
        real(wp), intent(in) :: con(lanes, n_section), z(lanes), weight(lanes)
        real(wp), intent(inout) :: m(lanes, n_moments)
        real(wp) :: even, hh
        integer :: l

        do l = 1, lanes
            hh = z(l)*z(l)
            even = 2.0_wp*weight(l)*con(l, at_mu)
            m(l, p0) = m(l, p0) + even
            m(l, p2) = m(l, p2) + hh*even
            m(l, p4) = m(l, p4) + hh*hh*even
        end do
    end subroutine add_even_moments

    !> m <- m + the moments of G and R of a pair of heights.
    pure subroutine add_volume_moments(con, z, weight, g, j, power, m)
        real(wp), intent(in) :: con(lanes, n_section), z(lanes), weight(lanes)
        real(wp), intent(in) :: g(lanes, n_strains), j(lanes, 2), power(lanes, 2)
        real(wp), intent(inout) :: m(lanes, n_moments)
        real(wp) :: h, hh, even, odd, a, b, xi, q, qz, x, r, rq, rz, by_j, w, gj(lanes, 2)
        integer :: l, side

        !GCC$ unroll 2
        do side = 1, 2
            do l = 1, lanes
                h = merge(z(l), -z(l), side == 1)
                xi = g(l, 8)
                by_j = 1.0_wp/j(l, side)
                w = weight(l)*by_j
                gj(l, side) = w*(con(l, at_power)*power(l, side) - con(l, at_log))
                r = w*by_j*(con(l, at_bend)*power(l, side) + con(l, at_log))
                a = (1.0_wp + g(l, 1))*(1.0_wp + g(l, 7)) - g(l, 2)*g(l, 6)
                b = g(l, 3)*(1.0_wp + g(l, 7)) - g(l, 4)*g(l, 6)
                q = 1.0_wp + 2.0_wp*xi*h
                qz = q*(h + xi*h*h)
                x = 2.0_wp*h*a + h*h*(3.0_wp + 4.0_wp*xi*h)*b
                rq = r*q
                rz = r*qz
                m(l, r00) = m(l, r00) + rq*q
                m(l, r01) = m(l, r01) + rq*qz
                m(l, r02) = m(l, r02) + rq*x
                m(l, r11) = m(l, r11) + rz*qz
                m(l, r12) = m(l, r12) + rz*x
                m(l, r22) = m(l, r22) + r*x*x
            end do
        end do
        do l = 1, lanes
            h = z(l)
            hh = h*h
            even = gj(l, 1) + gj(l, 2)
            odd = h*(gj(l, 1) - gj(l, 2))
            m(l, g0) = m(l, g0) + even
            m(l, g1) = m(l, g1) + odd
            m(l, g2) = m(l, g2) + hh*even
            m(l, g3) = m(l, g3) + hh*odd
        end do
    end subroutine add_volume_moments

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
