!> The three-node beam element with reduced integration, rule gauss, in lanes: residual and tangent of one
!> stage (gb_stage), the middle node eliminated.
!>
!> With two Gauss points the fields of an element with the nodes l, m, r are best described by their slopes p
!> and q at the two points and the mean S = (l + r)/2: with kappa = length/(2 sqrt 3), point one has slopes p
!> and values S + kappa q, point two slopes q and values S - kappa p. So the tangent in (p, q, S) is made of
!> the two section Hessians by a few sums. Since p + q = E with E = 2 (r - l)/length, p can stand for the
!> middle node and is eliminated; (E, S) are the two ends. From p the middle node follows as m = S - bubble (p
!> - E/2), bubble = length sqrt(3)/4.
module gb_element_lanes
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_fields, only: n_fields
    use gb_section_lanes, only: n_strains, n_section, section_tangent
    use gb_blocks_lanes, only: n_triangle, factorise
    use gb_inertia_lanes, only: n_moments, add_full_inertia
    implicit none
    private

    !> Columns of an element's constants, after those of its section, con(lanes, n_element). The weights of
    !> the section hold length/2 too.
    integer, parameter, public :: at_slope = n_section + 1      !! 2/length [1/L]
    integer, parameter, public :: at_kappa = n_section + 2      !! length/(2 sqrt 3) [L]
    integer, parameter, public :: at_bubble = n_section + 3     !! length sqrt(3)/4 [L]
    integer, parameter, public :: at_by_bubble = n_section + 4  !! 1/bubble [1/L]
    integer, parameter, public :: at_swing = n_section + 5  !! length^2/48, mean square of E over E^2 [L^2]
    integer, parameter, public :: at_mass = n_section + 5       !! + field: mass, rho (A, A, I, I, I4) length
    !> + 1 ... 3: rho (A, I, I4) length/2 where inertia is full, and mass is 0 then.
    integer, parameter, public :: at_moment = at_mass + n_fields
    integer, parameter, public :: n_element = at_moment + n_moments

    !> What the inertia of a stage asks of the elements, besides accelerations.
    type, public :: inertia_t
        real(wp) :: mass_factor = 0.0_wp            !! as the stage's; 0 in statics [1/T^2]
        real(wp) :: damping_factor = 0.0_wp         !! as the stage's [1/T]
        real(wp) :: drag = 0.0_wp                   !! damping by the mass at rest over that mass [1/T]
        logical :: is_full = .false.                !! whether some element has inertia=full
    end type inertia_t

    !> Parts of a condensed element's tangent and residual, part(lanes, n_condensed): upper triangles by
    !> columns. Then the residual before the elimination, at left, middle and right node, without external
    !> forces on the ends.
    integer, parameter, public :: at_ll = 0, at_rr = 15, at_lr = 30, at_l = 55, at_r = 60, at_raw = 65, &
        n_condensed = 80
    !> What brings the middle node back, kept(lanes, n_kept): unit factor (10), multipliers (5, 11).
    integer, parameter, public :: n_kept = 65

    public :: strains, condense_element, recover_middle

contains

    !> Residual and tangent of the elements of one slot, the middle node eliminated.
    pure subroutine condense_element(pairs, has_middle, is_square, has_limit, con, inertia, u, v, a, f, &
        part, kept, room, pivot)
        integer, intent(in) :: pairs
        logical, intent(in) :: has_middle, is_square, has_limit     !! as section_tangent's
        real(wp), intent(in) :: con(lanes, n_element)
        type(inertia_t), intent(in) :: inertia              !! its factors over the stage's force_factor
        real(wp), intent(in) :: u(lanes, n_fields, 3)       !! fields at left, middle and right node
        real(wp), intent(in) :: v(lanes, n_fields, 3)       !! velocities there, where inertia is full
        real(wp), intent(in) :: a(lanes, n_fields, 3)       !! accelerations there plus drag times velocities
        real(wp), intent(in) :: f(lanes, n_fields)          !! external force on the middle node
        real(wp), intent(out) :: part(lanes, n_condensed)
        real(wp), intent(out) :: kept(lanes, n_kept)
        real(wp), intent(inout) :: room(lanes)              !! smallest of J and 1 - (I1-2)/jm [-]
        real(wp), intent(inout) :: pivot(lanes)             !! as gb_blocks_lanes' factorise
        real(wp), dimension(lanes, n_strains) :: g1, g2, s1, s2
        real(wp), dimension(lanes, n_strains, n_strains) :: h1, h2
        real(wp) :: k(lanes, n_triangle), c(lanes, n_fields, 2*n_fields + 1)
        real(wp) :: ee(lanes, n_fields, n_fields), es(lanes, n_fields, n_fields), ss(lanes, n_fields, &
            n_fields)
        real(wp) :: r(lanes, n_fields, 2)

        call strains(con, u, g1, g2)
        call section_tangent(pairs, has_middle, is_square, has_limit, con, g1, s1, h1, room)
        call section_tangent(pairs, has_middle, is_square, has_limit, con, g2, s2, h2, room)
        call join_points(con, h1, h2, k, c, ee, es, ss)
        call join_stresses(con, s1, s2, c, r)
        if (inertia%mass_factor > 0.0_wp) then
            call add_inertia(con, inertia%mass_factor + inertia%drag*inertia%damping_factor, a, k, c, ee, &
                es, ss, r)
            if (inertia%is_full) call add_full_inertia(con(:, at_moment + 1:at_moment + n_moments), &
                con(:, at_bubble), 0.5_wp/con(:, at_slope), [1.0_wp, inertia%damping_factor, &
                inertia%mass_factor], inertia%drag, u, v, a, k, c, ee, es, ss, r)
        end if
        call add_load(con, f, c, r, part)
        call eliminate(k, c, kept, pivot)
        call to_ends(con, c, kept, ee, es, ss, r, part)
    end subroutine condense_element

    !> Generalised strains at the two points.
    pure subroutine strains(con, u, g1, g2)
        real(wp), intent(in) :: con(lanes, n_element), u(lanes, n_fields, 3)
        real(wp), intent(out) :: g1(lanes, n_strains), g2(lanes, n_strains)
        real(wp) :: mean, half, bubble
        integer :: l, i

        !GCC$ unroll 5
        do i = 1, n_fields
            do l = 1, lanes
                half = (u(l, i, 3) - u(l, i, 1))*(0.5_wp*con(l, at_slope))
                mean = 0.5_wp*(u(l, i, 1) + u(l, i, 3))
                bubble = (mean - u(l, i, 2))*con(l, at_by_bubble)
                g1(l, i) = half + bubble
                g2(l, i) = half - bubble
            end do
        end do
        !GCC$ unroll 5
        do i = 3, n_fields
            do l = 1, lanes
                mean = 0.5_wp*(u(l, i, 1) + u(l, i, 3))
                g1(l, i + 3) = mean + con(l, at_kappa)*g2(l, i)
                g2(l, i + 3) = mean - con(l, at_kappa)*g1(l, i)
            end do
        end do
    end subroutine strains

    !> Tangent in p (k, upper triangle), between p and (E, S) (c), and in (E, S), from the Hessians of the
    !> points:
    !>     pp = h1_ss + kappa^2 h2_vv,  qq = h2_ss + kappa^2 h1_vv,  pq = kappa (h1_sv - h2_vs),
    !>     pS = h1_sv - kappa h2_vv,  qS = h2_sv + kappa h1_vv,  SS = h1_vv + h2_vv  (s slopes, v values),
    !> with q = E - p: k = pp - pq - pq' + qq, c = (pq - qq, pS - qS), ee = qq, es = qS, ss = SS.
    !> u1 and u3 have no values in the strains.
    pure subroutine join_points(con, h1, h2, k, c, ee, es, ss)
        real(wp), intent(in) :: con(lanes, n_element)
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2
        real(wp), intent(out) :: k(lanes, n_triangle), c(lanes, n_fields, 2*n_fields + 1)
        real(wp), intent(out), dimension(lanes, n_fields, n_fields) :: ee, es, ss
        real(wp) :: kappa, pq, qp, values
        integer :: l, i, j

        !GCC$ unroll 5
        do j = 1, 2
            !GCC$ unroll 5
            do i = 1, n_fields
                c(:, i, n_fields + j) = 0.0_wp
                es(:, i, j) = 0.0_wp
                ss(:, min(i, j), max(i, j)) = 0.0_wp
            end do
            !GCC$ unroll 5
            do i = 1, j
                k(:, j*(j - 1)/2 + i) = h1(:, i, j) + h2(:, i, j)
                ee(:, i, j) = h2(:, i, j)
                c(:, i, j) = -h2(:, i, j)
                c(:, j, i) = -h2(:, i, j)
            end do
        end do
        !GCC$ unroll 5
        do j = 3, n_fields
            !GCC$ unroll 5
            do i = 1, 2
                do l = 1, lanes
                    pq = con(l, at_kappa)*h1(l, i, j + 3)
                    qp = con(l, at_kappa)*h2(l, i, j + 3)
                    k(l, j*(j - 1)/2 + i) = h1(l, i, j) + h2(l, i, j) - (pq - qp)
                    ee(l, i, j) = h2(l, i, j)
                    c(l, i, j) = pq - h2(l, i, j)
                    c(l, j, i) = -qp - h2(l, i, j)
                    c(l, i, n_fields + j) = h1(l, i, j + 3) - h2(l, i, j + 3)
                    es(l, i, j) = h2(l, i, j + 3)
                end do
            end do
            !GCC$ unroll 5
            do i = 3, j
                do l = 1, lanes
                    kappa = con(l, at_kappa)
                    pq = kappa*(h1(l, i, j + 3) - h2(l, j, i + 3))
                    qp = kappa*(h1(l, j, i + 3) - h2(l, i, j + 3))
                    values = h1(l, i + 3, j + 3) + h2(l, i + 3, j + 3)
                    k(l, j*(j - 1)/2 + i) = h1(l, i, j) + h2(l, i, j) + kappa*kappa*values - (pq + qp)
                    ss(l, i, j) = values
                    ee(l, i, j) = h2(l, i, j) + kappa*kappa*h1(l, i + 3, j + 3)
                    c(l, i, j) = pq - ee(l, i, j)
                    c(l, j, i) = qp - ee(l, i, j)
                    c(l, i, n_fields + j) = h1(l, i, j + 3) - h2(l, i, j + 3) - kappa*values
                    c(l, j, n_fields + i) = h1(l, j, i + 3) - h2(l, j, i + 3) - kappa*values
                    es(l, i, j) = h2(l, i, j + 3) + kappa*h1(l, i + 3, j + 3)
                    es(l, j, i) = h2(l, j, i + 3) + kappa*h1(l, i + 3, j + 3)
                end do
            end do
        end do
    end subroutine join_points

    !> Residual of the internal force in p (last column of c) and in E, S.
    pure subroutine join_stresses(con, s1, s2, c, r)
        real(wp), intent(in) :: con(lanes, n_element)
        real(wp), intent(in), dimension(lanes, n_strains) :: s1, s2
        real(wp), intent(inout) :: c(lanes, n_fields, 2*n_fields + 1)
        real(wp), intent(out) :: r(lanes, n_fields, 2)
        integer :: i

        !GCC$ unroll 5
        do i = 1, 2
            c(:, i, 11) = s1(:, i) - s2(:, i)
            r(:, i, 1) = s2(:, i)
            r(:, i, 2) = 0.0_wp
        end do
        !GCC$ unroll 5
        do i = 3, n_fields
            r(:, i, 2) = s1(:, i + 3) + s2(:, i + 3)
            r(:, i, 1) = s2(:, i) + con(:, at_kappa)*s1(:, i + 3)
            c(:, i, 11) = s1(:, i) - s2(:, i) - con(:, at_kappa)*r(:, i, 2)
        end do
    end subroutine join_stresses

    !> The consistent mass of the element, exact: with B = bubble (p - E/2) a motion is S - B (1-s^2) + s E
    !> length/4 on the parent interval.
    pure subroutine add_inertia(con, mass_factor, a, k, c, ee, es, ss, r)
        real(wp), intent(in) :: con(lanes, n_element), mass_factor, a(lanes, n_fields, 3)
        real(wp), intent(inout) :: k(lanes, n_triangle), c(lanes, n_fields, 2*n_fields + 1)
        real(wp), intent(inout), dimension(lanes, n_fields, n_fields) :: ee, es, ss
        real(wp), intent(inout) :: r(lanes, n_fields, 2)
        real(wp) :: mean, b, m, sb, bb, on_b, swing
        integer :: l, i

        !GCC$ unroll 5
        do i = 1, n_fields
            do l = 1, lanes
                sb = (-2.0_wp/3.0_wp)*con(l, at_bubble)
                bb = (-0.8_wp)*con(l, at_bubble)*sb
                swing = con(l, at_swing)
                m = con(l, at_mass + i)
                mean = 0.5_wp*(a(l, i, 1) + a(l, i, 3))
                b = (mean - a(l, i, 2))*con(l, at_by_bubble)
                on_b = m*(sb*mean + bb*b)
                c(l, i, 11) = c(l, i, 11) + on_b
                r(l, i, 1) = r(l, i, 1) - 0.5_wp*on_b + m*((a(l, i, 3) - a(l, i, 1))*(swing*con(l, at_slope)))
                r(l, i, 2) = r(l, i, 2) + m*(mean + sb*b)
                m = mass_factor*m
                k(l, i*(i + 1)/2) = k(l, i*(i + 1)/2) + m*bb
                c(l, i, i) = c(l, i, i) - m*(0.5_wp*bb)
                c(l, i, n_fields + i) = c(l, i, n_fields + i) + m*sb
                ee(l, i, i) = ee(l, i, i) + m*(0.25_wp*bb + swing)
                es(l, i, i) = es(l, i, i) - m*(0.5_wp*sb)
                ss(l, i, i) = ss(l, i, i) + m
            end do
        end do
    end subroutine add_inertia

    !> The external force on the middle node, and the residual of the three nodes.
    pure subroutine add_load(con, f, c, r, part)
        real(wp), intent(in) :: con(lanes, n_element), f(lanes, n_fields)
        real(wp), intent(inout) :: c(lanes, n_fields, 2*n_fields + 1), r(lanes, n_fields, 2)
        real(wp), intent(inout) :: part(lanes, n_condensed)
        real(wp) :: middle
        integer :: l, i

        !GCC$ unroll 5
        do i = 1, n_fields
            do l = 1, lanes
                middle = -c(l, i, 11)*con(l, at_by_bubble)
                part(l, at_raw + 5 + i) = middle - f(l, i)
                middle = 0.5_wp*(r(l, i, 2) - middle)
                part(l, at_raw + i) = middle - con(l, at_slope)*(r(l, i, 1) + 0.5_wp*c(l, i, 11))
                part(l, at_raw + 10 + i) = middle + con(l, at_slope)*(r(l, i, 1) + 0.5_wp*c(l, i, 11))
                c(l, i, 11) = c(l, i, 11) + con(l, at_bubble)*f(l, i)
                r(l, i, 1) = r(l, i, 1) - 0.5_wp*con(l, at_bubble)*f(l, i)
                r(l, i, 2) = r(l, i, 2) - f(l, i)
            end do
        end do
    end subroutine add_load

    !> Forward elimination: kept <- the unit factor L of k = L D L' and D^-1 L^-1 c, c <- L^-1 c.
    pure subroutine eliminate(k, c, kept, pivot)
        real(wp), intent(in) :: k(lanes, n_triangle)
        real(wp), intent(inout) :: c(lanes, n_fields, 2*n_fields + 1)
        real(wp), intent(out) :: kept(lanes, n_kept)
        real(wp), intent(inout) :: pivot(lanes)
        real(wp) :: inverse(lanes, n_fields), y2, y3, y4, y5
        integer :: l, j

        call factorise(k, kept, inverse, pivot)
        !GCC$ unroll 11
        do j = 1, 2*n_fields + 1
            do l = 1, lanes
                y2 = c(l, 2, j) - kept(l, 1)*c(l, 1, j)
                y3 = c(l, 3, j) - kept(l, 2)*c(l, 1, j) - kept(l, 3)*y2
                y4 = c(l, 4, j) - kept(l, 4)*c(l, 1, j) - kept(l, 5)*y2 - kept(l, 6)*y3
                y5 = c(l, 5, j) - kept(l, 7)*c(l, 1, j) - kept(l, 8)*y2 - kept(l, 9)*y3 - kept(l, 10)*y4
                kept(l, 5*j + 6) = inverse(l, 1)*c(l, 1, j)
                kept(l, 5*j + 7) = inverse(l, 2)*y2
                kept(l, 5*j + 8) = inverse(l, 3)*y3
                kept(l, 5*j + 9) = inverse(l, 4)*y4
                kept(l, 5*j + 10) = inverse(l, 5)*y5
                c(l, 2, j) = y2
                c(l, 3, j) = y3
                c(l, 4, j) = y4
                c(l, 5, j) = y5
            end do
        end do
    end subroutine eliminate

    !> What (E, S) keep after the elimination, their Schur complement, turned to the end nodes: E = slope (r -
    !> l), S = (l + r)/2.
    pure subroutine to_ends(con, c, kept, ee, es, ss, r, part)
        real(wp), intent(in) :: con(lanes, n_element)
        real(wp), intent(in) :: c(lanes, n_fields, 2*n_fields + 1), kept(lanes, n_kept)
        real(wp), intent(in), dimension(lanes, n_fields, n_fields) :: ee, es, ss
        real(wp), intent(in) :: r(lanes, n_fields, 2)
        real(wp), intent(inout) :: part(lanes, n_condensed)
        real(wp) :: e_s, s_e, means, slopes, even, odd
        integer :: l, i, j

        !GCC$ unroll 5
        do j = 1, n_fields
            !GCC$ unroll 5
            do i = 1, j
                do l = 1, lanes
                    slopes = ee(l, i, j) - c(l, 1, i)*kept(l, 5*j + 6) - c(l, 2, i)*kept(l, 5*j + 7) &
                        - c(l, 3, i)*kept(l, 5*j + 8) - c(l, 4, i)*kept(l, 5*j + 9) - c(l, 5, i)*kept(l, &
                            5*j + 10)
                    means = ss(l, i, j) - c(l, 1, i + 5)*kept(l, 5*j + 31) - c(l, 2, i + 5)*kept(l, 5*j &
                        + 32) &
                        - c(l, 3, i + 5)*kept(l, 5*j + 33) - c(l, 4, i + 5)*kept(l, 5*j + 34) &
                        - c(l, 5, i + 5)*kept(l, 5*j + 35)
                    e_s = es(l, i, j) - c(l, 1, i)*kept(l, 5*j + 31) - c(l, 2, i)*kept(l, 5*j + 32) &
                        - c(l, 3, i)*kept(l, 5*j + 33) - c(l, 4, i)*kept(l, 5*j + 34) - c(l, 5, i)*kept(l, &
                            5*j + 35)
                    s_e = es(l, j, i) - c(l, 1, i + 5)*kept(l, 5*j + 6) - c(l, 2, i + 5)*kept(l, 5*j + 7) &
                        - c(l, 3, i + 5)*kept(l, 5*j + 8) - c(l, 4, i + 5)*kept(l, 5*j + 9) &
                        - c(l, 5, i + 5)*kept(l, 5*j + 10)
                    means = 0.25_wp*means
                    slopes = con(l, at_slope)*con(l, at_slope)*slopes
                    even = (0.5_wp*con(l, at_slope))*(e_s + s_e)
                    odd = (0.5_wp*con(l, at_slope))*(s_e - e_s)
                    part(l, at_ll + j*(j - 1)/2 + i) = means + slopes - even
                    part(l, at_rr + j*(j - 1)/2 + i) = means + slopes + even
                    part(l, at_lr + 5*(j - 1) + i) = means - slopes + odd
                    part(l, at_lr + 5*(i - 1) + j) = means - slopes - odd
                end do
            end do
            do l = 1, lanes
                slopes = r(l, j, 1) - c(l, 1, 11)*kept(l, 5*j + 6) - c(l, 2, 11)*kept(l, 5*j + 7) &
                    - c(l, 3, 11)*kept(l, 5*j + 8) - c(l, 4, 11)*kept(l, 5*j + 9) - c(l, 5, 11)*kept(l, 5*j &
                        + 10)
                means = r(l, j, 2) - c(l, 1, 11)*kept(l, 5*j + 31) - c(l, 2, 11)*kept(l, 5*j + 32) &
                    - c(l, 3, 11)*kept(l, 5*j + 33) - c(l, 4, 11)*kept(l, 5*j + 34) - c(l, 5, 11)*kept(l, &
                        5*j + 35)
                part(l, at_l + j) = 0.5_wp*means - con(l, at_slope)*slopes
                part(l, at_r + j) = 0.5_wp*means + con(l, at_slope)*slopes
            end do
        end do
    end subroutine to_ends

    !> Increment of the middle node from those of the ends (1 left, 2 middle, 3 right).
    pure subroutine recover_middle(con, kept, du)
        real(wp), intent(in) :: con(lanes, n_element), kept(lanes, n_kept)
        real(wp), intent(inout) :: du(lanes, n_fields, 3)
        real(wp), dimension(lanes, n_fields) :: e, s, p
        integer :: n, i

        !GCC$ unroll 5
        do i = 1, n_fields
            e(:, i) = con(:, at_slope)*(du(:, i, 3) - du(:, i, 1))
            s(:, i) = 0.5_wp*(du(:, i, 1) + du(:, i, 3))
        end do
        !GCC$ unroll 5
        do n = 1, n_fields
            p(:, n) = -kept(:, 60 + n)
            !GCC$ unroll 5
            do i = 1, n_fields
                p(:, n) = p(:, n) - kept(:, 5*i + 5 + n)*e(:, i) - kept(:, 5*i + 30 + n)*s(:, i)
            end do
        end do
        do i = 1, lanes
            p(i, 4) = p(i, 4) - kept(i, 10)*p(i, 5)
            p(i, 3) = p(i, 3) - kept(i, 6)*p(i, 4) - kept(i, 9)*p(i, 5)
            p(i, 2) = p(i, 2) - kept(i, 3)*p(i, 3) - kept(i, 5)*p(i, 4) - kept(i, 8)*p(i, 5)
            p(i, 1) = p(i, 1) - kept(i, 1)*p(i, 2) - kept(i, 2)*p(i, 3) - kept(i, 4)*p(i, 4) - kept(i, &
                7)*p(i, 5)
        end do
        !GCC$ unroll 5
        do i = 1, n_fields
            du(:, i, 2) = s(:, i) - con(:, at_bubble)*(p(:, i) - 0.5_wp*e(:, i))
        end do
    end subroutine recover_middle

end module gb_element_lanes
