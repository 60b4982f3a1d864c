!> What is left of the elements of gb_element_lanes at their end nodes when the middle node has been
!> eliminated.
module gb_ends_lanes
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_fields, only: n_fields
    use gb_element_columns, only: n_strains, n_element, n_kept, n_condensed, at_slope, at_kappa, &
        at_bubble, at_swing, at_ll, at_rr, at_lr, at_l, at_r
    implicit none
    private

    public :: condense_to_ends

contains

    !> Tangent in (E, S) before the elimination, of the fields i and j (i <= j): qq, qS and its mirror Sq, and
    !> SS = h1_vv + h2_vv.
    pure subroutine tangent_of_ends(con, mass, h1, h2, i, j, ee, es, se, ss)
        real(wp), intent(in) :: con(lanes, n_element), mass(lanes, n_fields)
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2
        integer, intent(in) :: i, j
        real(wp), intent(out), dimension(lanes) :: ee, es, se, ss
        real(wp) :: kappa, bubble
        integer :: l

        ee = h2(:, i, j)
        es = 0.0_wp
        se = 0.0_wp
        ss = 0.0_wp
        if (j > 2) es = h2(:, i, j + 3)
        if (i > 2) then
            do l = 1, lanes
                kappa = con(l, at_kappa)
                ee(l) = ee(l) + kappa*kappa*h1(l, i + 3, j + 3)
                es(l) = es(l) + kappa*h1(l, i + 3, j + 3)
                se(l) = h2(l, j, i + 3) + kappa*h1(l, i + 3, j + 3)
                ss(l) = h1(l, i + 3, j + 3) + h2(l, i + 3, j + 3)
            end do
        end if
        if (i == j) then
            do l = 1, lanes
                bubble = con(l, at_bubble)
                ee(l) = ee(l) + mass(l, i)*((2.0_wp/15.0_wp)*bubble*bubble + con(l, at_swing))
                es(l) = es(l) + mass(l, i)*((1.0_wp/3.0_wp)*bubble)
                ss(l) = ss(l) + mass(l, i)
            end do
            se = es
        end if
    end subroutine tangent_of_ends

    !> What (E, S) keep after the elimination, their Schur complement, turned to the end nodes: E = slope (r -
    !> l), S = (l + r)/2.
    pure subroutine condense_to_ends(con, mass, h1, h2, c, kept, r, part)
        real(wp), intent(in) :: con(lanes, n_element), mass(lanes, n_fields)
        real(wp), intent(in), dimension(lanes, n_strains, n_strains) :: h1, h2
        real(wp), intent(in) :: c(lanes, n_fields, 2*n_fields + 1), kept(lanes, n_kept)
        real(wp), intent(in) :: r(lanes, n_fields, 0:2)
        real(wp), intent(inout) :: part(lanes, n_condensed)
        real(wp), dimension(lanes) :: slopes, e_s, s_e, means
        real(wp) :: even, odd, slope, mean
        integer :: l, i, j, e, s

        !GCC$ unroll 5
        do j = 1, n_fields
            e = 5*j + 5
            s = e + 25
            !GCC$ unroll 5
            do i = 1, j
                call tangent_of_ends(con, mass, h1, h2, i, j, slopes, e_s, s_e, means)
                do l = 1, lanes
                    slopes(l) = slopes(l) - c(l, 1, i)*kept(l, e + 1) - c(l, 2, i)*kept(l, e + 2) &
                        - c(l, 3, i)*kept(l, e + 3) - c(l, 4, i)*kept(l, e + 4) - c(l, 5, i)*kept(l, e + 5)
                    means(l) = means(l) - c(l, 1, i + 5)*kept(l, s + 1) - c(l, 2, i + 5)*kept(l, s + 2) &
                        - c(l, 3, i + 5)*kept(l, s + 3) - c(l, 4, i + 5)*kept(l, s + 4) &
                        - c(l, 5, i + 5)*kept(l, s + 5)
                    e_s(l) = e_s(l) - c(l, 1, i)*kept(l, s + 1) - c(l, 2, i)*kept(l, s + 2) &
                        - c(l, 3, i)*kept(l, s + 3) - c(l, 4, i)*kept(l, s + 4) - c(l, 5, i)*kept(l, s + 5)
                end do
                if (i == j) then
                    s_e = e_s
                else
                    do l = 1, lanes
                        s_e(l) = s_e(l) - c(l, 1, i + 5)*kept(l, e + 1) - c(l, 2, i + 5)*kept(l, e + 2) &
                            - c(l, 3, i + 5)*kept(l, e + 3) - c(l, 4, i + 5)*kept(l, e + 4) &
                            - c(l, 5, i + 5)*kept(l, e + 5)
                    end do
                end if
                do l = 1, lanes
                    mean = 0.25_wp*means(l)
                    slope = con(l, at_slope)*con(l, at_slope)*slopes(l)
                    even = (0.5_wp*con(l, at_slope))*(e_s(l) + s_e(l))
                    odd = (0.5_wp*con(l, at_slope))*(s_e(l) - e_s(l))
                    part(l, at_ll + j*(j - 1)/2 + i) = mean + slope - even
                    part(l, at_rr + j*(j - 1)/2 + i) = mean + slope + even
                    part(l, at_lr + 5*(j - 1) + i) = mean - slope + odd
                    part(l, at_lr + 5*(i - 1) + j) = mean - slope - odd
                end do
            end do
            do l = 1, lanes
                slope = r(l, j, 1) - c(l, 1, 11)*kept(l, e + 1) - c(l, 2, 11)*kept(l, e + 2) &
                    - c(l, 3, 11)*kept(l, e + 3) - c(l, 4, 11)*kept(l, e + 4) - c(l, 5, 11)*kept(l, e + 5)
                mean = r(l, j, 2) - c(l, 1, 11)*kept(l, s + 1) - c(l, 2, 11)*kept(l, s + 2) &
                    - c(l, 3, 11)*kept(l, s + 3) - c(l, 4, 11)*kept(l, s + 4) - c(l, 5, 11)*kept(l, s + 5)
                part(l, at_l + j) = 0.5_wp*mean - con(l, at_slope)*slope
                part(l, at_r + j) = 0.5_wp*mean + con(l, at_slope)*slope
            end do
        end do
    end subroutine condense_to_ends

end module gb_ends_lanes
