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
    use gb_section_lanes, only: section_tangent
    use gb_element_columns, only: n_strains, n_element, n_condensed, n_kept, at_slope, at_kappa, &
        at_bubble, at_by_bubble, at_swing, at_mass, at_raw, n_full
    use gb_blocks_lanes, only: n_triangle
    use gb_inertia_lanes, only: inertia_t, full_inertia, eliminate_full, add_to_ends
    use gb_middle_lanes, only: factorise_middle, eliminate_middle
    use gb_ends_lanes, only: condense_to_ends
    implicit none
    private

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
        real(wp), dimension(lanes, n_fields) :: mass, inverse
        real(wp) :: c(lanes, n_fields, 2*n_fields + 1), r(lanes, n_fields, 0:2)
        real(wp) :: full(lanes, n_triangle, n_full), force(lanes, n_fields, 0:2), mass_factor
        logical :: is_full
        integer :: i

        is_full = inertia%is_full .and. inertia%mass_factor > 0.0_wp
        mass_factor = inertia%mass_factor + inertia%drag*inertia%damping_factor
        call strains(con, u, g1, g2)
        call section_tangent(pairs, has_middle, is_square, has_limit, con, g1, s1, h1, room)
        call section_tangent(pairs, has_middle, is_square, has_limit, con, g2, s2, h2, room)
        !GCC$ unroll 5
        do i = 1, n_fields
            mass(:, i) = mass_factor*con(:, at_mass + i)
        end do
        if (is_full) call full_inertia(con, inertia, u, v, a, force, full)
        ! The pivots are a long chain of divisions, beside which the processor sums up the residual.
        call factorise_middle(con, mass, h1, h2, is_full, full, kept, inverse, pivot)
        call join_stresses(con, s1, s2, r)
        if (mass_factor > 0.0_wp) call add_inertia(con, a, r)
        if (is_full) r = r + force
        call add_load(con, f, r, part)
        call eliminate_middle(con, mass, h1, h2, r, inverse, c, kept)
        if (is_full) call eliminate_full(full, inverse, c, kept)
        call condense_to_ends(con, mass, h1, h2, c, kept, r, part)
        if (is_full) call add_to_ends(full, part)
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

    !> Residual of the internal force in p (index 0), E (1) and S (2).
    pure subroutine join_stresses(con, s1, s2, r)
        real(wp), intent(in) :: con(lanes, n_element)
        real(wp), intent(in), dimension(lanes, n_strains) :: s1, s2
        real(wp), intent(out) :: r(lanes, n_fields, 0:2)
        integer :: i

        !GCC$ unroll 5
        do i = 1, 2
            r(:, i, 0) = s1(:, i) - s2(:, i)
            r(:, i, 1) = s2(:, i)
            r(:, i, 2) = 0.0_wp
        end do
        !GCC$ unroll 5
        do i = 3, n_fields
            r(:, i, 2) = s1(:, i + 3) + s2(:, i + 3)
            r(:, i, 1) = s2(:, i) + con(:, at_kappa)*s1(:, i + 3)
            r(:, i, 0) = s1(:, i) - s2(:, i) - con(:, at_kappa)*r(:, i, 2)
        end do
    end subroutine join_stresses

    !> Residual of the inertia: with B = bubble (p - E/2) a motion is S - B (1-s^2) + s E length/4 on the
    !> parent interval, and its consistent mass is exact: mass (S^2 - 4/3 S B + 8/15 B^2 + swing E^2).
    pure subroutine add_inertia(con, a, r)
        real(wp), intent(in) :: con(lanes, n_element), a(lanes, n_fields, 3)
        real(wp), intent(inout) :: r(lanes, n_fields, 0:2)
        real(wp) :: mean, b, m, sb, bb, on_b
        integer :: l, i

        !GCC$ unroll 5
        do i = 1, n_fields
            do l = 1, lanes
                sb = (-2.0_wp/3.0_wp)*con(l, at_bubble)
                bb = (-0.8_wp)*con(l, at_bubble)*sb
                m = con(l, at_mass + i)
                mean = 0.5_wp*(a(l, i, 1) + a(l, i, 3))
                b = (mean - a(l, i, 2))*con(l, at_by_bubble)
                on_b = m*(sb*mean + bb*b)
                r(l, i, 0) = r(l, i, 0) + on_b
                r(l, i, 1) = r(l, i, 1) - 0.5_wp*on_b &
                    + m*((a(l, i, 3) - a(l, i, 1))*(con(l, at_swing)*con(l, at_slope)))
                r(l, i, 2) = r(l, i, 2) + m*(mean + sb*b)
            end do
        end do
    end subroutine add_inertia

    !> The external force on the middle node, and the residual of the three nodes.
    pure subroutine add_load(con, f, r, part)
        real(wp), intent(in) :: con(lanes, n_element), f(lanes, n_fields)
        real(wp), intent(inout) :: r(lanes, n_fields, 0:2)
        real(wp), intent(inout) :: part(lanes, n_condensed)
        real(wp) :: middle, ends, swing
        integer :: l, i

        !GCC$ unroll 5
        do i = 1, n_fields
            do l = 1, lanes
                middle = -r(l, i, 0)*con(l, at_by_bubble)
                ends = 0.5_wp*(r(l, i, 2) - middle)
                swing = con(l, at_slope)*(r(l, i, 1) + 0.5_wp*r(l, i, 0))
                part(l, at_raw + i) = ends - swing
                part(l, at_raw + 5 + i) = middle - f(l, i)
                part(l, at_raw + 10 + i) = ends + swing
                r(l, i, 0) = r(l, i, 0) + con(l, at_bubble)*f(l, i)
                r(l, i, 1) = r(l, i, 1) - 0.5_wp*con(l, at_bubble)*f(l, i)
                r(l, i, 2) = r(l, i, 2) - f(l, i)
            end do
        end do
    end subroutine add_load

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
