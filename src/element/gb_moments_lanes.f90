!> What section_tangent (gb_section_lanes) sums up over the heights of a section: moments of the material's
!> slopes and curvatures, and the dyads of chains with a limit. What follows a choice between two numbers is a
!> loop of its own: in the same one the compiler makes a branch of the choice.
module gb_moments_lanes
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_element_columns, only: n_strains, n_section, n_moments, at_mu, at_log, at_power, at_bend, &
        at_minus_beta, at_inverse_jm, at_middle, p0, p1, p2, p3, p4, g0, g1, g2, g3, r00, r01, r11, r02, &
        r12, r22
    implicit none
    private

    public :: measure_middle, measure_pair

contains

    !> J^-beta for any beta.
    pure subroutine raise_j(con, j, power)
        real(wp), intent(in) :: con(lanes, n_section), j(lanes)
        real(wp), intent(out) :: power(lanes)

        power = j**con(:, at_minus_beta)
    end subroutine raise_j

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
        power = j*j
        if (.not. is_square) call raise_j(con, j, power)
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
        power = j*j
        if (.not. is_square) then
            call raise_j(con, j(:, 1), power(:, 1))
            call raise_j(con, j(:, 2), power(:, 2))
        end if
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

end module gb_moments_lanes
