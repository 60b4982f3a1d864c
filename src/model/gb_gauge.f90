!> What a row of results may ask of a state beyond its fields: strains, stresses, resultants. The results file
!> asks through this abstract type, so that it knows nothing of elements; the solver's library answers.
module gb_gauge
    use gb_kinds, only: wp
    use gb_strip, only: strip_t, strip_heights
    implicit none
    private

    !> Stations are the integration points along the beam; each has the same number of heights: bottom, the
    !> Gauss points through the thickness, top.
    type, abstract, public :: gauge_t
        integer :: n = 0                                    !! unknowns of a state
        integer :: stations = 0
        integer :: heights = 0
        real(wp), allocatable :: x(:)                       !! reference X1 of the stations [L] (stations)
        integer, allocatable :: element(:)                  !! their elements, from 1 (stations)
        real(wp), allocatable :: x3(:, :)                   !! reference X3 [L] (heights, stations)
        type(strip_t) :: strip
    contains
        procedure(read_strains_i), deferred :: read_strains
        procedure(read_resultants_i), deferred :: read_resultants
        procedure(read_stresses_i), deferred :: read_stresses
        procedure(read_columns_i), deferred :: read_columns
    end type gauge_t

    abstract interface
        !> Green-Lagrange strains and the two invariants.
        pure subroutine read_strains_i(self, u, e, i1_minus_2, j)
            import :: gauge_t, wp
            class(gauge_t), intent(in) :: self
            real(wp), intent(in) :: u(self%n)
            real(wp), intent(out) :: e(3, self%heights, self%stations)          !! E11 E33 E13 [-]
            real(wp), intent(out) :: i1_minus_2(self%heights, self%stations)    !! [-]
            real(wp), intent(out) :: j(self%heights, self%stations)             !! [-]
        end subroutine read_strains_i

        !> Forces and moment of the sections.
        pure subroutine read_resultants_i(self, u, axial, shear, moment)
            import :: gauge_t, wp
            class(gauge_t), intent(in) :: self
            real(wp), intent(in) :: u(self%n)
            real(wp), intent(out) :: axial(self%stations), shear(self%stations)     !! [F]
            real(wp), intent(out) :: moment(self%stations)                          !! [F L]
        end subroutine read_resultants_i

        !> Second Piola-Kirchhoff and Cauchy stresses. A face beyond the material's limits has none: that of
        !> the nearest integration point stands in for it, and `beyond` counts such faces.
        pure subroutine read_stresses_i(self, u, s, cauchy, beyond)
            import :: gauge_t, wp
            class(gauge_t), intent(in) :: self
            real(wp), intent(in) :: u(self%n)
            real(wp), intent(out) :: s(3, self%heights, self%stations)          !! S11 S33 S13 [F/L^2]
            real(wp), intent(out) :: cauchy(3, self%heights, self%stations)     !! 11 33 13 in space [F/L^2]
            integer, intent(out) :: beyond
        end subroutine read_stresses_i

        !> Values at the columns of the strip: extrapolated from the stations of each element, the mean where
        !> two elements meet. Energy density [F/L^2] as read_stresses treats stress.
        pure subroutine read_columns_i(self, u, e11, e33, i1_minus_2, j, energy)
            import :: gauge_t, wp, strip_heights
            class(gauge_t), intent(in) :: self
            real(wp), intent(in) :: u(self%n)
            real(wp), intent(out) :: e11(strip_heights, self%strip%columns)
            real(wp), intent(out) :: e33(strip_heights, self%strip%columns)
            real(wp), intent(out) :: i1_minus_2(strip_heights, self%strip%columns)
            real(wp), intent(out) :: j(strip_heights, self%strip%columns)
            real(wp), intent(out) :: energy(strip_heights, self%strip%columns)
        end subroutine read_columns_i
    end interface

end module gb_gauge
