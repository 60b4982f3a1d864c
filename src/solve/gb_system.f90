!> The discretised model: elements, supports and mass ready for assembly. It answers the questions that the solution
!> methods ask: strain energy, internal force, tangent, mass.
module gb_system
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_section, only: material_t, section_t, unlimited_jm, inertia_translational
    use gb_model, only: model_t
    use gb_quadrature, only: gauss_legendre
    use gb_shape, only: shape_table_t, shape_table, max_nodes, max_points
    use gb_section_gauss, only: n_strains, gauss_invariants
    use gb_beam, only: section_data_t, element_strains, element_energy, element_force, element_tangent, element_mass
    use gb_section, only: rule_gauss
    use gb_band, only: band_t
    implicit none
    private

    type, public :: system_t
        integer :: n = 0                                    !! unknowns, five a node
        integer :: n_elements = 0
        integer :: kd = 0                                   !! half band width
        logical :: symmetric = .true.                       !! whether the tangent is
        integer, allocatable :: first(:)                    !! unknowns before an element's first (ne)
        integer, allocatable :: table(:)                    !! index in `tables` (ne)
        integer, allocatable :: kind(:)                     !! index in `sections` (ne)
        real(wp), allocatable :: half_length(:)             !! dX1/ds [L] (ne)
        type(shape_table_t), allocatable :: tables(:)       !! reduced and full integration of 2 to 5 nodes
        type(section_data_t), allocatable :: sections(:)    !! pairs of material and section
        type(band_t) :: mass                                !! consistent; without the supports' rows removed
        logical, allocatable :: fixed(:)                    !! held or driven unknowns (n)
        integer, allocatable :: fixed_list(:)
        logical, allocatable :: massless(:)                 !! unknowns without inertia (n)
        real(wp) :: field_scale(n_fields) = 1.0_wp          !! natural size of the fields: L, L, 1, 1, 1/h
    contains
        procedure :: strain_energy
        procedure :: internal_force
        procedure :: tangent
        procedure :: kinetic_energy
        procedure :: worst_point
    end type system_t

    !> The integration point nearest to, or beyond, the limits of admissible states.
    type, public :: worst_point_t
        integer :: element = 0, point = 0                   !! 1-based
        real(wp) :: height = 0.0_wp                         !! X3 [L]
        real(wp) :: i1_minus_2 = 0.0_wp, j = 1.0_wp, jm = 0.0_wp
    end type worst_point_t

    public :: build_system

contains

    function build_system(model) result(system)
        type(model_t), intent(in) :: model
        type(system_t) :: system
        integer :: e, i

        associate (mesh => model%mesh)
            system%n = n_fields*mesh%n_nodes()
            system%n_elements = mesh%n_elements()
            system%kd = n_fields*maxval(mesh%nodes) - 1
            system%symmetric = .not. model%has_no_potential()
            system%first = n_fields*(mesh%first_node - 1)
            system%tables = [(shape_table(i, i - 1), i=2, max_nodes), (shape_table(i, i), i=2, max_nodes)]
            system%table = merge(mesh%nodes - 1 + max_nodes - 1, mesh%nodes - 1, mesh%full_integration)
            system%half_length = [(0.5_wp*mesh%element_length(e), e=1, mesh%n_elements())]
            system%kind = (mesh%section - 1)*size(model%materials) + mesh%material
            system%field_scale = [mesh%length(), mesh%length(), 1.0_wp, 1.0_wp, &
                                  1.0_wp/maxval(model%sections(mesh%section)%h)]
        end associate
        call build_sections(model, system%sections)
        system%fixed = reshape(model%fixed_fields(), [system%n])
        system%fixed_list = pack([(i, i=1, system%n)], system%fixed)
        call build_mass(model, system)
    end function build_system

    !> One set of kernel data for every pair of material and section, material running first.
    pure subroutine build_sections(model, sections)
        type(model_t), intent(in) :: model
        type(section_data_t), allocatable, intent(out) :: sections(:)
        integer :: s, m, k

        allocate (sections(size(model%sections)*size(model%materials)))
        do s = 1, size(model%sections)
            do m = 1, size(model%materials)
                k = (s - 1)*size(model%materials) + m
                associate (part => sections(k), section => model%sections(s), material => model%materials(m))
                    part%rule = section%rule
                    part%nz = section%points
                    call gauss_legendre(part%z(:part%nz), part%wz(:part%nz))
                    part%z = 0.5_wp*section%h*part%z
                    part%wz = 0.5_wp*section%area()*part%wz
                    part%area = section%area()
                    part%inertia = section%second_moment()
                    part%p = [material%mu, material%c, material%beta, 1.0_wp/material%jm]
                    if (material%jm >= unlimited_jm) part%p(4) = 0.0_wp
                end associate
            end do
        end do
    end subroutine build_sections

    !> Consistent mass, integrated exactly (as many Gauss points as nodes).
    subroutine build_mass(model, system)
        type(model_t), intent(in) :: model
        type(system_t), intent(inout) :: system
        type(shape_table_t) :: table
        real(wp) :: m(n_fields*max_nodes, n_fields*max_nodes), density(n_fields)
        integer :: e, nodes, i

        call system%mass%set_up(system%n, system%kd, symmetric=.true.)
        allocate (system%massless(system%n))
        system%massless = .true.
        do e = 1, system%n_elements
            nodes = model%mesh%nodes(e)
            table = system%tables(nodes - 1 + max_nodes - 1)
            density = field_density(model%materials(model%mesh%material(e)), model%sections(model%mesh%section(e)))
            call element_mass(nodes, table%points, table%n, system%half_length(e)*table%w, density, m)
            call system%mass%add_block(system%first(e), n_fields*nodes, m)
            do i = 1, n_fields*nodes
                if (density(1 + modulo(i - 1, n_fields)) > 0.0_wp) system%massless(system%first(e) + i) = .false.
            end do
        end do
    end subroutine build_mass

    !> Mass a unit length of each field, rho (A, A, I, I, I4), or rho (A, A, 0, 0, 0) for translational inertia.
    pure function field_density(material, section) result(density)
        type(material_t), intent(in) :: material
        type(section_t), intent(in) :: section
        real(wp) :: density(n_fields)

        density = material%rho*[section%area(), section%area(), section%second_moment(), section%second_moment(), &
                                section%fourth_moment()]
        if (section%inertia == inertia_translational) density(3:5) = 0.0_wp
    end function field_density

    !> Strain energy [F L] of the state u. Not admissible: energy is meaningless.
    pure subroutine strain_energy(self, u, energy, admissible)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: energy
        logical, intent(out) :: admissible
        real(wp) :: part
        integer :: e, m

        energy = 0.0_wp
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), half => self%half_length(e))
                m = n_fields*t%nodes
                call element_energy(t%nodes, t%points, t%n, t%d/half, t%w*half, self%sections(self%kind(e)), &
                                    u(first + 1:first + m), part, admissible)
            end associate
            if (.not. admissible) return
            energy = energy + part
        end do
    end subroutine strain_energy

    !> Internal force of the state u, conjugate to it.
    pure subroutine internal_force(self, u, force, admissible)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: force(self%n)
        logical, intent(out) :: admissible
        real(wp) :: f(n_fields*max_nodes)
        integer :: e, m

        force = 0.0_wp
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), half => self%half_length(e))
                m = n_fields*t%nodes
                call element_force(t%nodes, t%points, t%n, t%d/half, t%w*half, self%sections(self%kind(e)), &
                                   u(first + 1:first + m), f, admissible)
                if (.not. admissible) return
                force(first + 1:first + m) = force(first + 1:first + m) + f(:m)
            end associate
        end do
    end subroutine internal_force

    !> Internal force of the state u and its tangent, df/du.
    pure subroutine tangent(self, u, force, k, admissible)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: force(self%n)
        type(band_t), intent(inout) :: k                    !! cleared here
        logical, intent(out) :: admissible
        real(wp) :: f(n_fields*max_nodes), block((n_fields*max_nodes)**2)
        integer :: e, m

        force = 0.0_wp
        call k%clear()
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), half => self%half_length(e))
                m = n_fields*t%nodes
                call element_tangent(t%nodes, t%points, t%n, t%d/half, t%w*half, self%sections(self%kind(e)), &
                                     u(first + 1:first + m), f, block, admissible)
                if (.not. admissible) return
                force(first + 1:first + m) = force(first + 1:first + m) + f(:m)
                call k%add_block(first, m, block)
            end associate
        end do
    end subroutine tangent

    !> Kinetic energy v M v / 2 [F L].
    pure real(wp) function kinetic_energy(self, v)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: v(self%n)
        real(wp) :: momentum(self%n)

        call self%mass%multiply(v, momentum)
        kinetic_energy = 0.5_wp*dot_product(v, momentum)
    end function kinetic_energy

    !> The point of the state u that is farthest into, or nearest to, the inadmissible: smallest J if some J is not
    !> positive, else largest (I1-2)/jm, else smallest J.
    pure function worst_point(self, u) result(worst)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        type(worst_point_t) :: worst
        real(wp) :: g(n_strains), i1_minus_2, j, badness, worst_badness
        integer :: e, i, k, nz

        worst_badness = -huge(1.0_wp)
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), part => self%sections(self%kind(e)))
                nz = merge(part%nz, 1, part%rule == rule_gauss)
                do i = 1, t%points
                    g = element_strains(t%nodes, t%n(:, i), t%d(:, i)/self%half_length(e), &
                                        reshape(u(first + 1:first + n_fields*t%nodes), [n_fields, t%nodes]))
                    do k = 1, nz
                        call gauss_invariants(merge(part%z(k), 0.0_wp, part%rule == rule_gauss), g, i1_minus_2, j)
                        badness = max(i1_minus_2*part%p(4), 1.0_wp - j)
                        if (.not. badness <= worst_badness) then
                            worst_badness = badness
                            worst = worst_point_t(e, i, merge(part%z(k), 0.0_wp, part%rule == rule_gauss), i1_minus_2, j, &
                                                  unlimited_jm)
                            if (part%p(4) > 0.0_wp) worst%jm = 1.0_wp/part%p(4)
                        end if
                    end do
                end do
            end associate
        end do
    end function worst_point

end module gb_system
