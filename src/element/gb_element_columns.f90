!> What stands where in the arrays of the element's lane kernels (gb_element_lanes).
module gb_element_columns
    use gb_fields, only: n_fields
    use gb_section_lanes, only: n_section
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
    integer, parameter, public :: n_element = at_mass + n_fields

    !> Parts of a condensed element's tangent and residual, part(lanes, n_condensed): upper triangles by
    !> columns. Then the residual before the elimination, at left, middle and right node, without external
    !> forces on the ends.
    integer, parameter, public :: at_ll = 0, at_rr = 15, at_lr = 30, at_l = 55, at_r = 60, at_raw = 65, &
        n_condensed = 80
    !> What brings the middle node back, kept(lanes, n_kept): unit factor (10), multipliers (5, 11).
    integer, parameter, public :: n_kept = 65

end module gb_element_columns
