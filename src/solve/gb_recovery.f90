!> Recovers strains, stresses and resultants from a state: the answers to gb_gauge's questions.
module gb_recovery
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_section, only: rule_gauss
    use gb_model, only: model_t
    use gb_strip, only: build_strip, strip_heights, strip_levels
    use gb_gauge, only: gauge_t
    use gb_quadrature, only: gauss_legendre
    use gb_shape, only: shape_table_t, max_nodes, max_points
    use gb_section_gauss, only: n_strains
    use gb_beam, only: section_data_t, element_strains
    use gb_fibre, only: fibre_strain, fibre_stress, fibre_energy, section_resultants
    use gb_system, only: system_t
    implicit none
    private

    type, extends(gauge_t), public :: recovery_t
        private
        integer, allocatable :: first(:)                    !! unknowns before an element's first (ne)
        integer, allocatable :: table(:)                    !! index in `tables` (ne)
        integer, allocatable :: kind(:)                     !! index in `sections` (ne)
        real(wp), allocatable :: half_length(:)             !! dX1/ds [L] (ne)
        type(shape_table_t), allocatable :: tables(:)
        real(wp), allocatable :: to_nodes(:, :, :)          !! from points to nodes (nodes, points, tables)
        type(section_data_t), allocatable :: sections(:)
        integer, allocatable :: first_station(:)            !! of an element (ne)
        integer, allocatable :: stand_in(:, :)  !! Gauss point whose stress stands in (heights, stations)
    contains
        procedure :: read_strains
        procedure :: read_resultants
        procedure :: read_stresses
        procedure :: read_columns
    end type recovery_t

    public :: build_recovery

contains

    function build_recovery(model, system) result(recovery)
        type(model_t), intent(in) :: model
        type(system_t), intent(in) :: system
        type(recovery_t) :: recovery
        integer :: i

        recovery%n = system%n
        recovery%first = system%first
        recovery%table = system%table
        recovery%kind = system%kind
        recovery%half_length = system%half_length
        recovery%tables = system%tables
        recovery%sections = system%sections
        recovery%strip = build_strip(model%mesh, model%sections)
        allocate (recovery%to_nodes(max_nodes, max_points, size(system%tables)))
        do i = 1, size(system%tables)
            call extrapolation(system%tables(i)%nodes, system%tables(i)%points, recovery%to_nodes(:, :, i))
        end do
        call place_stations(model, recovery)
        call choose_stand_ins(recovery)
    end function build_recovery

    !> Values of the polynomials through `points` Gauss points at the nodes of an element.
    pure subroutine extrapolation(nodes, points, matrix)
        integer, intent(in) :: nodes, points
        real(wp), intent(out) :: matrix(max_nodes, max_points)
        real(wp) :: s(points), weights(points), node
        integer :: i, p, q

        matrix = 0.0_wp
        call gauss_legendre(s, weights)
        do p = 1, points
            do i = 1, nodes
                node = -1.0_wp + 2.0_wp*real(i - 1, wp)/real(nodes - 1, wp)
                matrix(i, p) = 1.0_wp
                do q = 1, points
                    if (q /= p) matrix(i, p) = matrix(i, p)*(node - s(q))/(s(p) - s(q))
                end do
            end do
        end do
    end subroutine extrapolation

    !> Stations: every integration point along the beam. Heights: the faces, and between them as many Gauss
    !> points as the section with the most of them has (three for rule linear).
    subroutine place_stations(model, recovery)
        type(model_t), intent(in) :: model
        type(recovery_t), intent(inout) :: recovery
        integer, parameter :: least_points = 3
        real(wp), allocatable :: levels(:), weights(:)
        real(wp) :: left, s(max_points), w(max_points)
        integer :: e, station, points, most

        most = maxval(merge(model%sections(model%mesh%section)%points, least_points, &
            model%sections(model%mesh%section)%rule == rule_gauss))
        recovery%heights = most + 2
        recovery%stations = sum(recovery%tables(recovery%table)%points)
        allocate (levels(most), weights(most))
        call gauss_legendre(levels, weights)
        allocate (recovery%x(recovery%stations), recovery%element(recovery%stations))
        allocate (recovery%x3(recovery%heights, recovery%stations))
        allocate (recovery%first_station(size(recovery%first)))
        station = 0
        do e = 1, size(recovery%first)
            points = recovery%tables(recovery%table(e))%points
            left = model%mesh%x(model%mesh%first_node(e))
            call gauss_legendre(s(:points), w(:points))
            recovery%first_station(e) = station + 1
            recovery%x(station + 1:station + points) = left + recovery%half_length(e)*(1.0_wp + s(:points))
            recovery%element(station + 1:station + points) = e
            recovery%x3(:, station + 1:station + points) = spread( &
                0.5_wp*model%sections(model%mesh%section(e))%h*[-1.0_wp, levels, 1.0_wp], 2, points)
            station = station + points
        end do
    end subroutine place_stations

    !> For every height the section's own integration point that is nearest; rule linear has mid-height (0).
    pure subroutine choose_stand_ins(recovery)
        type(recovery_t), intent(inout) :: recovery
        integer :: station, k

        allocate (recovery%stand_in(recovery%heights, recovery%stations))
        recovery%stand_in = 0
        do station = 1, recovery%stations
            associate (section => recovery%sections(recovery%kind(recovery%element(station))))
                if (section%rule /= rule_gauss) cycle
                do k = 1, recovery%heights
                    recovery%stand_in(k, station) = minloc(abs(section%z(:section%nz) &
                        - recovery%x3(k, station)), 1)
                end do
            end associate
        end do
    end subroutine choose_stand_ins

    !> Generalised strains at every station.
    pure subroutine station_strains(self, u, g)
        class(recovery_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: g(n_strains, self%stations)
        integer :: e, i, station

        station = 0
        do e = 1, size(self%first)
            associate (t => self%tables(self%table(e)), first => self%first(e))
                do i = 1, t%points
                    station = station + 1
                    g(:, station) = element_strains(t%nodes, t%n(:, i), t%d(:, i)/self%half_length(e), &
                        reshape(u(first + 1:first + n_fields*t%nodes), [n_fields, t%nodes]))
                end do
            end associate
        end do
    end subroutine station_strains

    pure subroutine read_strains(self, u, e, i1_minus_2, j)
        class(recovery_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: e(3, self%heights, self%stations)
        real(wp), intent(out) :: i1_minus_2(self%heights, self%stations)
        real(wp), intent(out) :: j(self%heights, self%stations)
        real(wp) :: g(n_strains, self%stations)
        integer :: station, k

        call station_strains(self, u, g)
        do station = 1, self%stations
            associate (section => self%sections(self%kind(self%element(station))))
                do k = 1, self%heights
                    call fibre_strain(section, g(:, station), self%x3(k, station), e(:, k, station), &
                        i1_minus_2(k, station), j(k, station))
                end do
            end associate
        end do
    end subroutine read_strains

    pure subroutine read_resultants(self, u, axial, shear, moment)
        class(recovery_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: axial(self%stations), shear(self%stations), moment(self%stations)
        real(wp) :: g(n_strains, self%stations)
        logical :: admissible
        integer :: i

        call station_strains(self, u, g)
        do i = 1, self%stations
            call section_resultants(self%sections(self%kind(self%element(i))), g(:, i), axial(i), shear(i), &
                moment(i), admissible)
        end do
    end subroutine read_resultants

    pure subroutine read_stresses(self, u, s, cauchy, beyond)
        class(recovery_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: s(3, self%heights, self%stations)
        real(wp), intent(out) :: cauchy(3, self%heights, self%stations)
        integer, intent(out) :: beyond
        real(wp) :: g(n_strains, self%stations), z
        integer :: station, k
        logical :: exists

        beyond = 0
        call station_strains(self, u, g)
        do station = 1, self%stations
            associate (section => self%sections(self%kind(self%element(station))))
                do k = 1, self%heights
                    call fibre_stress(section, g(:, station), self%x3(k, station), s(:, k, station), &
                        cauchy(:, k, station), exists)
                    if (exists) cycle
                    beyond = beyond + 1
                    z = 0.0_wp
                    if (self%stand_in(k, station) > 0) z = section%z(self%stand_in(k, station))
                    call fibre_stress(section, g(:, station), z, s(:, k, station), cauchy(:, k, station), &
                        exists)
                end do
            end associate
        end do
    end subroutine read_stresses

    pure subroutine read_columns(self, u, e11, e33, i1_minus_2, j, energy)
        class(recovery_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: e11(strip_heights, self%strip%columns)
        real(wp), intent(out) :: e33(strip_heights, self%strip%columns)
        real(wp), intent(out) :: i1_minus_2(strip_heights, self%strip%columns)
        real(wp), intent(out) :: j(strip_heights, self%strip%columns)
        real(wp), intent(out) :: energy(strip_heights, self%strip%columns)
        real(wp) :: g(n_strains, self%stations), at_columns(n_strains, self%strip%columns), e(3)
        logical :: exists
        integer :: c, k

        call station_strains(self, u, g)
        call carry_to_columns(self, g, at_columns)
        do c = 1, self%strip%columns
            associate (section => self%sections(self%kind(self%strip%element(c))))
                do k = 1, strip_heights
                    call fibre_strain(section, at_columns(:, c), strip_levels(k)*self%strip%h(c), e, &
                        i1_minus_2(k, c), j(k, c))
                    e11(k, c) = e(1)
                    e33(k, c) = e(2)
                    call fibre_energy(section, i1_minus_2(k, c), j(k, c), energy(k, c), exists)
                    if (.not. exists) energy(k, c) = largest_energy(self, self%strip%element(c), g)
                end do
            end associate
        end do
    end subroutine read_columns

    !> Generalised strains at the columns.
    pure subroutine carry_to_columns(self, g, at_columns)
        class(recovery_t), intent(in) :: self
        real(wp), intent(in) :: g(n_strains, self%stations)
        real(wp), intent(out) :: at_columns(n_strains, self%strip%columns)
        integer :: e, i, p, c

        at_columns = 0.0_wp
        do e = 1, size(self%first)
            associate (t => self%tables(self%table(e)), matrix => self%to_nodes(:, :, self%table(e)))
                do i = 1, t%nodes
                    c = self%strip%first_column(e) + i - 1
                    do p = 1, t%points
                        at_columns(:, c) = at_columns(:, c) &
                            + (self%strip%share(c)*matrix(i, p))*g(:, self%first_station(e) + p - 1)
                    end do
                end do
            end associate
        end do
    end subroutine carry_to_columns

    !> Largest energy density at the integration points of an element, where it always exists [F/L^2].
    pure real(wp) function largest_energy(self, element, g) result(largest)
        class(recovery_t), intent(in) :: self
        integer, intent(in) :: element
        real(wp), intent(in) :: g(n_strains, self%stations)
        real(wp) :: e(3), i1_minus_2, j, energy, z
        integer :: station, k
        logical :: exists

        largest = 0.0_wp
        associate (section => self%sections(self%kind(element)))
            do station = self%first_station(element), &
                self%first_station(element) + self%tables(self%table(element))%points - 1
                do k = 1, merge(section%nz, 1, section%rule == rule_gauss)
                    z = merge(section%z(k), 0.0_wp, section%rule == rule_gauss)
                    call fibre_strain(section, g(:, station), z, e, i1_minus_2, j)
                    call fibre_energy(section, i1_minus_2, j, energy, exists)
                    if (exists) largest = max(largest, energy)
                end do
            end do
        end associate
    end function largest_energy

end module gb_recovery
