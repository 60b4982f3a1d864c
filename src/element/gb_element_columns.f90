!> What stands where in the arrays of the lane kernels of sections (gb_section_lanes) and elements
!> (gb_element_lanes).
module gb_element_columns
    use gb_fields, only: n_fields
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
    integer, parameter, public :: p0 = 1, p1 = 2, p2 = 3, p3 = 4, p4 = 5, g0 = 6, g1 = 7, g2 = 8, g3 = 9, &
        r00 = 10, r01 = 11, r11 = 12, r02 = 13, r12 = 14, r22 = 15, n_moments = 15

    !> Columns of an element's constants, after those of its section, con(lanes, n_element). The weights of
    !> the section hold length/2 too.
    integer, parameter, public :: at_slope = n_section + 1      !! 2/length [1/L]
    integer, parameter, public :: at_kappa = n_section + 2      !! length/(2 sqrt 3) [L]
    integer, parameter, public :: at_bubble = n_section + 3     !! length sqrt(3)/4 [L]
    integer, parameter, public :: at_by_bubble = n_section + 4  !! 1/bubble [1/L]
    integer, parameter, public :: at_swing = n_section + 5  !! length^2/48, mean square of E over E^2 [L^2]
    integer, parameter, public :: at_mass = n_section + 5       !! + field: mass, rho (A, A, I, I, I4) length
    !> + 1 ... 3: rho (A, I, I4) length/2 where inertia is full, and mass is 0 then.
    integer, parameter, public :: at_mass_moment = at_mass + n_fields, n_mass_moments = 3
    integer, parameter, public :: n_element = at_mass_moment + n_mass_moments

    !> Parts of a condensed element's tangent and residual, part(lanes, n_condensed): upper triangles by
    !> columns. Then the residual before the elimination, at left, middle and right node, without external
    !> forces on the ends.
    integer, parameter, public :: at_ll = 0, at_rr = 15, at_lr = 30, at_l = 55, at_r = 60, at_raw = 65, &
        n_condensed = 80
    !> What full inertia adds to an element's tangent, full(lanes, n_triangle, n_full): all symmetric, upper
    !> triangles by columns. In p, between p and E, p and S; at left and right node, and between them.
    integer, parameter, public :: on_pp = 1, on_pe = 2, on_ps = 3, on_ll = 4, on_rr = 5, on_lr = 6, n_full = 6
    !> What brings the middle node back, kept(lanes, n_kept): unit factor (10), multipliers (5, 11).
    integer, parameter, public :: n_kept = 65

end module gb_element_columns
