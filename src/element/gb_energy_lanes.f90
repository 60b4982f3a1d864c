!> Stored and kinetic energy of the elements of gb_element_lanes, in lanes. Heights and points of one weight
!> share their logarithms: ln J1 + ln J2 = ln(1 + x1 + x2 + x1 x2) with J = 1 + x, which cancels no more than
!> the logarithms themselves.
module gb_energy_lanes
    use gb_kinds, only: wp, log1p
    use gb_lanes, only: lanes
    use gb_fields, only: n_fields
    use gb_element_columns, only: n_strains, n_element, at_mu, at_log, at_power, at_minus_beta, &
        at_inverse_jm, at_middle, at_z, at_weight, at_slope, at_swing, at_mass
    use gb_element_lanes, only: strains
    use gb_inertia_lanes, only: full_kinetic_energy
    implicit none
    private

    public :: stored_energy, kinetic_energy

    !> In place of 1/jm = 0: the logarithm is that of the neo-Hookean material to the last digit.
    real(wp), parameter :: least_inverse_jm = 1.0e-30_wp

contains

    !> Strain energy of every lane's element [F L]; meaningless where room is not positive.
    pure subroutine stored_energy(pairs, has_middle, is_square, has_limit, con, u, energy, room)
        integer, intent(in) :: pairs
        logical, intent(in) :: has_middle, is_square, has_limit     !! as section_tangent's
        real(wp), intent(in) :: con(lanes, n_element)
        real(wp), intent(in) :: u(lanes, n_fields, 3)       !! fields at left, middle and right node
        real(wp), intent(out) :: energy(lanes)
        real(wp), intent(inout) :: room(lanes)              !! smallest of J and 1 - (I1-2)/jm [-]
        real(wp), dimension(lanes, n_strains) :: g1, g2
        real(wp), dimension(lanes) :: x, t, power
        integer :: k

        call strains(con, u, g1, g2)
        energy = 0.0_wp
        if (has_middle) then
            x = 0.0_wp
            t = 0.0_wp
            power = 0.0_wp
            call gather_point(is_square, con, spread(0.0_wp, 1, lanes), g1, x, t, power, room)
            call gather_point(is_square, con, spread(0.0_wp, 1, lanes), g2, x, t, power, room)
            call add_logarithms(has_limit, con, con(:, at_middle), x, t, power, energy)
        end if
        do k = 1, pairs
            x = 0.0_wp
            t = 0.0_wp
            power = 0.0_wp
            call gather_point(is_square, con, con(:, at_z + k), g1, x, t, power, room)
            call gather_point(is_square, con, -con(:, at_z + k), g1, x, t, power, room)
            call gather_point(is_square, con, con(:, at_z + k), g2, x, t, power, room)
            call gather_point(is_square, con, -con(:, at_z + k), g2, x, t, power, room)
            call add_logarithms(has_limit, con, con(:, at_weight + k), x, t, power, energy)
        end do
    end subroutine stored_energy

    !> Take a point into 1 + x = product of J, 1 + t = product of 1 - (I1-2)/jm, power = sum of J^-beta - 1.
    pure subroutine gather_point(is_square, con, z, g, x, t, power, room)
        logical, intent(in) :: is_square
        real(wp), intent(in) :: con(lanes, n_element), z(lanes), g(lanes, n_strains)
        real(wp), intent(inout), dimension(lanes) :: x, t, power, room
        real(wp) :: xi, zeta, k, d3, g11, f31, f13, g33, by_jm, i1
        real(wp) :: j(lanes)
        integer :: l

        do l = 1, lanes
            xi = g(l, 8)
            zeta = z(l) + xi*z(l)*z(l)
            k = z(l)*z(l)*g(l, 5)
            d3 = 1.0_wp + g(l, 7)
            g11 = g(l, 1) + zeta*g(l, 3) + k*g(l, 6)
            f31 = g(l, 2) + zeta*g(l, 4) + k*d3
            f13 = (1.0_wp + 2.0_wp*xi*z(l))*g(l, 6)
            g33 = g(l, 7) + 2.0_wp*xi*z(l)*d3
            by_jm = max(con(l, at_inverse_jm), least_inverse_jm)
            i1 = -(2.0_wp*(g11 + g33) + g11*g11 + g33*g33 + f31*f31 + f13*f13)*by_jm
            j(l) = g11 + g33 + g11*g33 - f13*f31
            room(l) = min(room(l), 1.0_wp + j(l), 1.0_wp + i1)
            j(l) = merge(j(l), 0.0_wp, j(l) > -1.0_wp)
            i1 = merge(i1, 0.0_wp, i1 > -1.0_wp)
            x(l) = x(l) + j(l) + x(l)*j(l)
            t(l) = t(l) + i1 + t(l)*i1
        end do
        if (is_square) then
            power = power + j*(2.0_wp + j)
        else
            power = power + ((1.0_wp + j)**con(:, at_minus_beta) - 1.0_wp)
        end if
    end subroutine gather_point

    !> Where no limit is felt, ln(1 + t) is t to the last digit.
    pure subroutine add_logarithms(has_limit, con, weight, x, t, power, energy)
        logical, intent(in) :: has_limit
        real(wp), intent(in) :: con(lanes, n_element)
        real(wp), intent(in), dimension(lanes) :: weight, x, t, power
        real(wp), intent(inout) :: energy(lanes)
        real(wp), dimension(lanes) :: log_j, log_room
        integer :: l

        do l = 1, lanes
            log_j(l) = log1p(x(l))
            log_room(l) = t(l)
        end do
        if (has_limit) then
            do l = 1, lanes
                log_room(l) = log1p(t(l))
            end do
        end if
        energy = energy + weight*(con(:, at_power)/con(:, at_minus_beta)*power - con(:, at_log)*log_j &
            - 0.5_wp*con(:, at_mu)*log_room/max(con(:, at_inverse_jm), least_inverse_jm))
    end subroutine add_logarithms

    !> Kinetic energy of every lane's element [F L], with the mass of gb_element_lanes.
    pure subroutine kinetic_energy(con, is_full, u, v, energy)
        real(wp), intent(in) :: con(lanes, n_element)
        logical, intent(in) :: is_full                      !! whether some element has inertia=full
        real(wp), intent(in) :: u(lanes, n_fields, 3)       !! fields there, where inertia is full
        real(wp), intent(in) :: v(lanes, n_fields, 3)       !! velocities at left, middle and right node
        real(wp), intent(out) :: energy(lanes)
        real(wp) :: mean, b, e
        integer :: l, i

        energy = 0.0_wp
        do i = 1, n_fields
            do l = 1, lanes
                mean = 0.5_wp*(v(l, i, 1) + v(l, i, 3))
                b = mean - v(l, i, 2)
                e = con(l, at_slope)*(v(l, i, 3) - v(l, i, 1))
                energy(l) = energy(l) + con(l, at_mass + i)*(0.5_wp*mean*mean - (2.0_wp/3.0_wp)*mean*b &
                    + (4.0_wp/15.0_wp)*b*b + 0.5_wp*con(l, at_swing)*e*e)
            end do
        end do
        if (is_full) call full_kinetic_energy(con, u, v, energy)
    end subroutine kinetic_energy

end module gb_energy_lanes
