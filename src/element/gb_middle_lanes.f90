!> The middle node of the elements of gb_element_lanes: its part of the tangent, factorised, and what
!> couples it to the ends, eliminated. Parts of the tangent are formed from the Hessians where they are used:
!> they need not be stored then, and fit the registers.
module gb_middle_lanes
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_fields, only: n_fields
    use gb_element_columns, only: n_strains, n_element, n_kept, at_kappa, at_bubble, &
        n_full, on_pp
    use gb_blocks_lanes, only: n_triangle, factorise
    implicit none
    private

    public :: factorise_middle, eliminate_middle

contains

    !> The tangent in p, factorised: its unit factor L into `kept`, and 1/D.
    pure subroutine factorise_middle(con, mass, h1, h2, is_full, full, kept, inverse, pivot)
        real(wp), intent(in) :: con(lanes, n_element)
        real(wp), intent(in) :: mass(lanes, n_fields)       !! mass of each field times the stage's factor
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2  !! Hessians of the points
        logical, intent(in) :: is_full                      !! whether there is full inertia
        real(wp), intent(in) :: full(lanes, n_triangle, n_full)     !! its part of the tangent
        real(wp), intent(inout) :: kept(lanes, n_kept)
        real(wp), intent(out) :: inverse(lanes, n_fields)
        real(wp), intent(inout) :: pivot(lanes)             !! as gb_blocks_lanes' factorise
        real(wp) :: k(lanes, n_triangle)

        call middle_tangent(con, mass, h1, h2, k)
        if (is_full) k = k + full(:, :, on_pp)
        call factorise(k, kept, inverse, pivot)
    end subroutine factorise_middle

    !> Tangent in p, upper triangle, from the Hessians of the points. With s for slopes and v for values,
    !>     pp = h1_ss + kappa^2 h2_vv,  qq = h2_ss + kappa^2 h1_vv,  pq = kappa (h1_sv - h2_vs),
    !> and q = E - p, it is pp - pq - pq' + qq. u1 and u3 have no values in the strains.
    pure subroutine middle_tangent(con, mass, h1, h2, k)
        real(wp), intent(in) :: con(lanes, n_element), mass(lanes, n_fields)
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2
        real(wp), intent(out) :: k(lanes, n_triangle)
        real(wp) :: kappa, bubble, t(lanes)
        integer :: l, i, j

        !GCC$ unroll 5
        do j = 1, n_fields
            !GCC$ unroll 5
            do i = 1, j
                t = h1(:, i, j) + h2(:, i, j)
                if (j > 2) t = t - con(:, at_kappa)*(h1(:, i, j + 3) - h2(:, i, j + 3))
                if (i > 2) then
                    do l = 1, lanes
                        kappa = con(l, at_kappa)
                        t(l) = t(l) - kappa*(h1(l, j, i + 3) - h2(l, j, i + 3)) &
                            + kappa*kappa*(h1(l, i + 3, j + 3) + h2(l, i + 3, j + 3))
                    end do
                end if
                if (i == j) then
                    do l = 1, lanes
                        bubble = con(l, at_bubble)
                        t(l) = t(l) + mass(l, i)*((8.0_wp/15.0_wp)*bubble*bubble)
                    end do
                end if
                k(:, j*(j - 1)/2 + i) = t
            end do
        end do
    end subroutine middle_tangent

    !> Tangent between p and the field j of E, a column: pq - qq.
    pure subroutine couple_slope(con, mass, h1, h2, j, y)
        real(wp), intent(in) :: con(lanes, n_element), mass(lanes, n_fields)
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2
        integer, intent(in) :: j
        real(wp), intent(out) :: y(lanes, n_fields)
        real(wp) :: kappa, bubble
        integer :: l, i

        !GCC$ unroll 5
        do i = 1, n_fields
            y(:, i) = -h2(:, min(i, j), max(i, j))
            if (j > 2) y(:, i) = y(:, i) + con(:, at_kappa)*h1(:, i, j + 3)
            if (i > 2) y(:, i) = y(:, i) - con(:, at_kappa)*h2(:, j, i + 3)
            if (min(i, j) > 2) then
                do l = 1, lanes
                    kappa = con(l, at_kappa)
                    y(l, i) = y(l, i) - kappa*kappa*h1(l, min(i, j) + 3, max(i, j) + 3)
                end do
            end if
            if (i == j) then
                do l = 1, lanes
                    bubble = con(l, at_bubble)
                    y(l, i) = y(l, i) - mass(l, i)*((4.0_wp/15.0_wp)*bubble*bubble)
                end do
            end if
        end do
    end subroutine couple_slope

    !> The same of S: pS - qS with pS = h1_sv - kappa h2_vv and qS = h2_sv + kappa h1_vv.
    pure subroutine couple_mean(con, mass, h1, h2, j, y)
        real(wp), intent(in) :: con(lanes, n_element), mass(lanes, n_fields)
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2
        integer, intent(in) :: j
        real(wp), intent(out) :: y(lanes, n_fields)
        integer :: i

        !GCC$ unroll 5
        do i = 1, n_fields
            if (j > 2) then
                y(:, i) = h1(:, i, j + 3) - h2(:, i, j + 3)
                if (i > 2) y(:, i) = y(:, i) - con(:, at_kappa)*(h1(:, min(i, j) + 3, max(i, j) + 3) &
                    + h2(:, min(i, j) + 3, max(i, j) + 3))
            else
                y(:, i) = 0.0_wp
            end if
            if (i == j) y(:, i) = y(:, i) - mass(:, i)*((2.0_wp/3.0_wp)*con(:, at_bubble))
        end do
    end subroutine couple_mean

    !> Forward elimination, column by column of E, S and the residual: c = L^-1 times the column, and D^-1 c
    !> into `kept`, where the unit factor L is.
    pure subroutine eliminate_middle(con, mass, h1, h2, r, inverse, c, kept)
        real(wp), intent(in) :: con(lanes, n_element), mass(lanes, n_fields)
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2
        real(wp), intent(in) :: r(lanes, n_fields, 0:2)
        real(wp), intent(in) :: inverse(lanes, n_fields)    !! 1/D
        real(wp), intent(out) :: c(lanes, n_fields, 2*n_fields + 1)
        real(wp), intent(inout) :: kept(lanes, n_kept)
        real(wp) :: x(lanes, n_fields), y2, y3, y4, y5
        integer :: l, j

        !GCC$ unroll 11
        do j = 1, 2*n_fields + 1
            if (j <= n_fields) then
                call couple_slope(con, mass, h1, h2, j, x)
            else if (j <= 2*n_fields) then
                call couple_mean(con, mass, h1, h2, j - n_fields, x)
            else
                x = r(:, :, 0)
            end if
            do l = 1, lanes
                y2 = x(l, 2) - kept(l, 1)*x(l, 1)
                y3 = x(l, 3) - kept(l, 2)*x(l, 1) - kept(l, 3)*y2
                y4 = x(l, 4) - kept(l, 4)*x(l, 1) - kept(l, 5)*y2 - kept(l, 6)*y3
                y5 = x(l, 5) - kept(l, 7)*x(l, 1) - kept(l, 8)*y2 - kept(l, 9)*y3 - kept(l, 10)*y4
                kept(l, 5*j + 6) = inverse(l, 1)*x(l, 1)
                kept(l, 5*j + 7) = inverse(l, 2)*y2
                kept(l, 5*j + 8) = inverse(l, 3)*y3
                kept(l, 5*j + 9) = inverse(l, 4)*y4
                kept(l, 5*j + 10) = inverse(l, 5)*y5
                c(l, 1, j) = x(l, 1)
                c(l, 2, j) = y2
                c(l, 3, j) = y3
                c(l, 4, j) = y4
                c(l, 5, j) = y5
            end do
        end do
    end subroutine eliminate_middle

end module gb_middle_lanes
