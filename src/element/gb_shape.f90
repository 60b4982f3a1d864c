!> Lagrange shape functions on equidistant nodes, eq. (27), and their tables at the Gauss points of an
!> element.
module gb_shape
    use gb_kinds, only: wp
    use gb_quadrature, only: gauss_legendre
    implicit none
    private

    integer, parameter, public :: max_nodes = 5, max_points = 5

    !> Shape functions of one kind of element at its integration points, on the parent interval [-1, 1].
    type, public :: shape_table_t
        integer :: nodes = 0                                    !! nodes of the element
        integer :: points = 0                                   !! integration points
        real(wp) :: n(max_nodes, max_points) = 0.0_wp           !! N_I at the points [-]
        real(wp) :: d(max_nodes, max_points) = 0.0_wp           !! dN_I/ds on the parent interval [-]
        real(wp) :: w(max_points) = 0.0_wp                      !! weights, sum 2 [-]
    end type shape_table_t

    public :: lagrange, shape_table

contains

    !> Values and slopes of the Lagrange polynomials of size(n) equidistant nodes at s in [-1, 1].
    pure subroutine lagrange(s, n, d)
        real(wp), intent(in) :: s           !! parent coordinate [-]
        real(wp), intent(out) :: n(:)       !! N_I(s) (nodes)
        real(wp), intent(out) :: d(:)       !! dN_I/ds (nodes)
        real(wp) :: node(size(n)), factor
        integer :: i, j, k, m

        m = size(n)
        node = [(-1.0_wp + 2.0_wp*real(i - 1, wp)/real(m - 1, wp), i=1, m)]
        do i = 1, m
            n(i) = 1.0_wp
            d(i) = 0.0_wp
            do j = 1, m
                if (j == i) cycle
                n(i) = n(i)*(s - node(j))/(node(i) - node(j))
                factor = 1.0_wp/(node(i) - node(j))
                do k = 1, m
                    if (k /= i .and. k /= j) factor = factor*(s - node(k))/(node(i) - node(k))
                end do
                d(i) = d(i) + factor
            end do
        end do
    end subroutine lagrange

    !> The table of an element of `nodes` nodes at `points` Gauss points.
    pure function shape_table(nodes, points) result(table)
        integer, intent(in) :: nodes, points
        type(shape_table_t) :: table
        real(wp) :: s(points)
        integer :: i

        table%nodes = nodes
        table%points = points
        call gauss_legendre(s, table%w(:points))
        do i = 1, points
            call lagrange(s(i), table%n(:nodes, i), table%d(:nodes, i))
        end do
    end function shape_table

end module gb_shape
