!> The beam element: energy, residual and tangent of one element by Gauss points along its length, eq. (39-41,
!> 49, 50) corrected. Fields are interpolated by Lagrange polynomials; a section rule turns generalised
!> strains into generalised stresses and their tangent.
module gb_beam
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_shape, only: max_nodes, max_points
    use gb_gent, only: n_constants
    use gb_section, only: rule_gauss
    use gb_section_gauss, only: n_strains, gauss_energy, gauss_stress, gauss_tangent
    use gb_section_linear, only: linear_energy, linear_stress, linear_tangent
    use gb_section_average, only: average_tangent
    implicit none
    private

    integer, parameter, public :: max_heights = 10      !! Gauss points through the thickness at most

    !> All that a section's kernels need, by value.
    type, public :: section_data_t
        integer :: rule = rule_gauss
        integer :: nz = 0
        real(wp) :: z(max_heights) = 0.0_wp             !! heights of the points [L]
        real(wp) :: wz(max_heights) = 0.0_wp            !! their areas [L^2]
        real(wp) :: area = 0.0_wp                       !! A [L^2]
        real(wp) :: inertia = 0.0_wp                    !! I [L^4]
        real(wp) :: p(n_constants) = 0.0_wp             !! mu, c [F/L^2], beta, 1/jm
    end type section_data_t

    public :: element_strains, element_energy, element_force, element_tangent, element_average_tangent, &
        element_mass

contains

    !> Generalised strains (u1', u3', y1', y3', xi', y1, y3, xi) at a point with shape functions n and slopes
    !> d.
    pure function element_strains(nodes, n, d, u) result(g)
        integer, intent(in) :: nodes
        real(wp), intent(in) :: n(nodes)                !! N_I [-]
        real(wp), intent(in) :: d(nodes)                !! dN_I/dX1 [1/L]
        real(wp), intent(in) :: u(n_fields, nodes)      !! the five fields at the nodes
        real(wp) :: g(n_strains)
        real(wp) :: slopes(n_fields), values(n_fields)
        integer :: i

        slopes = 0.0_wp
        values = 0.0_wp
        do i = 1, nodes
            slopes = slopes + d(i)*u(:, i)
            values = values + n(i)*u(:, i)
        end do
        g(1:5) = slopes
        g(6:8) = values(3:5)
    end function element_strains

    !> Strain energy of an element [F L].
    pure subroutine element_energy(nodes, points, n, d, w, section, u, energy, admissible)
        integer, intent(in) :: nodes, points
        real(wp), intent(in) :: n(max_nodes, max_points)    !! N_I at the points
        real(wp), intent(in) :: d(max_nodes, max_points)    !! dN_I/dX1 at the points [1/L]
        real(wp), intent(in) :: w(max_points)               !! weights [L]
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: u(n_fields, nodes)
        real(wp), intent(out) :: energy
        logical, intent(out) :: admissible
        real(wp) :: g(n_strains), density
        integer :: i

        energy = 0.0_wp
        do i = 1, points
            g = element_strains(nodes, n(:, i), d(:, i), u)
            if (section%rule == rule_gauss) then
                call gauss_energy(section%nz, section%z, section%wz, section%p, g, density, admissible)
            else
                call linear_energy(section%area, section%inertia, section%p, g, density, admissible)
            end if
            if (.not. admissible) return
            energy = energy + w(i)*density
        end do
    end subroutine element_energy

    !> Internal force of an element, conjugate to its nodal fields.
    pure subroutine element_force(nodes, points, n, d, w, section, u, f, admissible)
        integer, intent(in) :: nodes, points
        real(wp), intent(in) :: n(max_nodes, max_points), d(max_nodes, max_points), w(max_points)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: u(n_fields, nodes)
        real(wp), intent(out) :: f(n_fields, nodes)
        logical, intent(out) :: admissible
        real(wp) :: g(n_strains), s(n_strains)
        integer :: i

        f = 0.0_wp
        do i = 1, points
            g = element_strains(nodes, n(:, i), d(:, i), u)
            if (section%rule == rule_gauss) then
                call gauss_stress(section%nz, section%z, section%wz, section%p, g, s, admissible)
            else
                call linear_stress(section%area, section%inertia, section%p, g, s, admissible)
            end if
            if (.not. admissible) return
            call add_force(nodes, n(:, i), d(:, i), w(i)*s, f)
        end do
    end subroutine element_force

    !> Internal force of an element and its exact tangent k(:, I, :, J) = df(:, I)/du(:, J).
    pure subroutine element_tangent(nodes, points, n, d, w, section, u, f, k, admissible)
        integer, intent(in) :: nodes, points
        real(wp), intent(in) :: n(max_nodes, max_points), d(max_nodes, max_points), w(max_points)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: u(n_fields, nodes)
        real(wp), intent(out) :: f(n_fields, nodes)
        real(wp), intent(out) :: k(n_fields, nodes, n_fields, nodes)
        logical, intent(out) :: admissible
        real(wp) :: g(n_strains), s(n_strains), t(n_strains, n_strains)
        integer :: i

        f = 0.0_wp
        do i = 1, points
            g = element_strains(nodes, n(:, i), d(:, i), u)
            if (section%rule == rule_gauss) then
                call gauss_tangent(section%nz, section%z, section%wz, section%p, g, s, t, admissible)
            else
                call linear_tangent(section%area, section%inertia, section%p, g, s, t, admissible)
            end if
            if (.not. admissible) return
            call add_force(nodes, n(:, i), d(:, i), w(i)*s, f)
            call add_stiffness(nodes, n(:, i), d(:, i), w(i), t, i == 1, k)
        end do
    end subroutine element_tangent

    !> Internal force averaged between the states u0 and u (gb_section_average), and its tangent in u
    !> (unsymmetric).
    pure subroutine element_average_tangent(nodes, points, n, d, w, section, u0, u, f, k, admissible)
        integer, intent(in) :: nodes, points
        real(wp), intent(in) :: n(max_nodes, max_points), d(max_nodes, max_points), w(max_points)
        type(section_data_t), intent(in) :: section             !! of rule gauss
        real(wp), intent(in) :: u0(n_fields, nodes), u(n_fields, nodes)
        real(wp), intent(out) :: f(n_fields, nodes)
        real(wp), intent(out) :: k(n_fields, nodes, n_fields, nodes)
        logical, intent(out) :: admissible
        real(wp) :: g0(n_strains), g(n_strains), s(n_strains), t(n_strains, n_strains)
        integer :: i

        f = 0.0_wp
        do i = 1, points
            g0 = element_strains(nodes, n(:, i), d(:, i), u0)
            g = element_strains(nodes, n(:, i), d(:, i), u)
            call average_tangent(section%nz, section%z, section%wz, section%p, g0, g, s, t, admissible)
            if (.not. admissible) return
            call add_force(nodes, n(:, i), d(:, i), w(i)*s, f)
            call add_stiffness(nodes, n(:, i), d(:, i), w(i), t, i == 1, k)
        end do
    end subroutine element_average_tangent

    !> f_I <- f_I + B_I' s.
    pure subroutine add_force(nodes, n, d, s, f)
        integer, intent(in) :: nodes
        real(wp), intent(in) :: n(nodes), d(nodes), s(n_strains)
        real(wp), intent(inout) :: f(n_fields, nodes)
        integer :: i

        do i = 1, nodes
            f(:, i) = f(:, i) + d(i)*s(1:5)
            f(3:5, i) = f(3:5, i) + n(i)*s(6:8)
        end do
    end subroutine add_force

    !> k_IJ <- k_IJ + w B_I' t B_J. B only scales and adds columns and rows of t: no matrix product is needed.
    !> Rows of t are put five by five, slopes and values of all fields, since short vectors of one length are
    !> what the compiler and the processor handle best.
    pure subroutine add_stiffness(nodes, n, d, w, t, is_first, k)
        integer, intent(in) :: nodes
        real(wp), intent(in) :: n(nodes), d(nodes), w, t(n_strains, n_strains)
        logical, intent(in) :: is_first                     !! k is nothing yet
        real(wp), intent(inout) :: k(n_fields, nodes, n_fields, nodes)
        real(wp) :: by_value(n_fields, n_strains), slopes(n_fields), values(n_fields)
        integer :: i, j, m

        by_value(1:2, :) = 0.0_wp
        by_value(3:5, :) = t(6:8, :)
        do j = 1, nodes
            do m = 1, n_fields
                slopes = (w*d(j))*t(1:5, m)
                values = (w*d(j))*by_value(:, m)
                if (m > 2) then
                    slopes = slopes + (w*n(j))*t(1:5, m + 3)
                    values = values + (w*n(j))*by_value(:, m + 3)
                end if
                do i = 1, nodes
                    if (is_first) then
                        k(:, i, m, j) = d(i)*slopes + n(i)*values
                    else
                        k(:, i, m, j) = k(:, i, m, j) + d(i)*slopes + n(i)*values
                    end if
                end do
            end do
        end do
    end subroutine add_stiffness

    !> Consistent mass of an element, eq. (28-32) corrected: density(f) times the integral of N_I N_J, field
    !> by field.
    pure subroutine element_mass(nodes, points, n, w, density, m)
        integer, intent(in) :: nodes, points
        real(wp), intent(in) :: n(max_nodes, max_points), w(max_points)
        real(wp), intent(in) :: density(n_fields)  !! mass a unit length of each field, rho (A, A, I, I, I4)
        real(wp), intent(out) :: m(n_fields, nodes, n_fields, nodes)
        integer :: i, j, q, field

        m = 0.0_wp
        do q = 1, points
            do j = 1, nodes
                do i = 1, nodes
                    do field = 1, n_fields
                        m(field, i, field, j) = m(field, i, field, j) + w(q)*n(i, q)*n(j, q)*density(field)
                    end do
                end do
            end do
        end do
    end subroutine element_mass

end module gb_beam
