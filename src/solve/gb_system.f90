!> The discretised model: elements, supports and mass ready for assembly. It answers the questions that the
!> solution methods ask: strain energy, internal force, tangent, mass.
module gb_system
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_section, only: material_t, section_t, unlimited_jm, rule_gauss, inertia_translational, inertia_full
    use gb_load, only: damping_t
    use gb_model, only: model_t
    use gb_solver_choice, only: block_obstacle
    use gb_quadrature, only: gauss_legendre
    use gb_shape, only: shape_table_t, shape_table, max_nodes, max_points
    use gb_section_gauss, only: n_strains, gauss_invariants
    use gb_beam, only: section_data_t, element_strains, element_energy, element_force, element_tangent, &
        element_average_tangent
    use gb_inertia, only: element_inertia, element_kinetic_energy
    use gb_lapack, only: dsyev
    use gb_band, only: band_t
    use gb_mass, only: mass_t
    implicit none
    private

    type, public :: system_t
        integer :: n = 0                                    !! unknowns, five a node
        integer :: n_elements = 0
        integer :: kd = 0                                   !! half band width
        logical :: symmetric = .true.                       !! whether the tangent is
        logical :: fits_block = .false.                     !! whether the block solver can do it
        integer, allocatable :: first(:)                    !! unknowns before an element's first (ne)
        integer, allocatable :: table(:)                    !! index in `tables` (ne)
        integer, allocatable :: kind(:)                     !! index in `sections` (ne)
        real(wp), allocatable :: half_length(:)             !! dX1/ds [L] (ne)
        type(shape_table_t), allocatable :: tables(:)       !! reduced and full integration of 2 to 5 nodes
        type(section_data_t), allocatable :: sections(:)    !! pairs of material and section
        type(mass_t) :: mass                                !! constant; without elements of full inertia
        type(band_t) :: damping                             !! Rayleigh damping; not allocated without DAMPING
        type(damping_t) :: rayleigh                         !! its factors
        logical, allocatable :: has_full_inertia(:)  !! elements whose mass depends on the configuration (ne)
        real(wp), allocatable :: mass_moments(:, :)         !! rho (A, I, I4) (3, sections)
        logical, allocatable :: fixed(:)                    !! held or driven unknowns (n)
        integer, allocatable :: fixed_list(:)
        logical :: has_massless = .false.
        logical, allocatable :: massless(:)  !! unknowns without inertia (n); where there are any
        real(wp) :: field_scale(n_fields) = 1.0_wp          !! natural size of the fields: L, L, 1, 1, 1/h
    contains
        procedure :: strain_energy
        procedure :: internal_force
        procedure :: tangent
        procedure :: average_tangent
        procedure :: add_inertia
        procedure :: drag
        procedure :: mass_at
        procedure :: lumped_mass
        procedure :: stable_step
        procedure :: kinetic_energy
        procedure :: round_off
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
            system%has_full_inertia = model%sections(mesh%section)%inertia == inertia_full
            system%symmetric = .not. (model%has_no_potential() .or. any(system%has_full_inertia))
            system%fits_block = block_obstacle(model) == ''
            system%first = n_fields*(mesh%first_node - 1)
            system%tables = [(shape_table(i, i - 1), i=2, max_nodes), (shape_table(i, i), i=2, max_nodes)]
            system%table = merge(mesh%nodes - 1 + max_nodes - 1, mesh%nodes - 1, mesh%full_integration)
            system%half_length = [(0.5_wp*mesh%element_length(e), e=1, mesh%n_elements())]
            system%kind = (mesh%section - 1)*size(model%materials) + mesh%material
            system%field_scale = [mesh%length(), mesh%length(), 1.0_wp, 1.0_wp, &
                                  1.0_wp/maxval(model%sections(mesh%section)%h)]
        end associate
        call build_sections(model, system%sections, system%mass_moments)
        system%fixed = reshape(model%fixed_fields(), [system%n])
        system%fixed_list = pack([(i, i=1, system%n)], system%fixed)
        call build_mass(model, system)
        call build_damping(model, system)
    end function build_system

    !> One set of kernel data for every pair of material and section, material running first.
    pure subroutine build_sections(model, sections, mass_moments)
        type(model_t), intent(in) :: model
        type(section_data_t), allocatable, intent(out) :: sections(:)
        real(wp), allocatable, intent(out) :: mass_moments(:, :)
        integer :: s, m, k

        allocate (sections(size(model%sections)*size(model%materials)))
        allocate (mass_moments(3, size(sections)))
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
                    mass_moments(:, k) = material%rho*[section%area(), section%second_moment(), &
                        section%fourth_moment()]
                end associate
            end do
        end do
    end subroutine build_sections

    !> The constant mass, and which unknowns have none at all.
    subroutine build_mass(model, system)
        type(model_t), intent(in) :: model
        type(system_t), intent(inout) :: system
        real(wp) :: density(n_fields, size(system%sections))
        integer :: s, m, k, e, i, j

        do s = 1, size(model%sections)
            do m = 1, size(model%materials)
                k = (s - 1)*size(model%materials) + m
                density(:, k) = field_density(model%materials(m), model%sections(s))
            end do
        end do
        allocate (system%massless(system%n))
        system%massless = .true.
        do e = 1, system%n_elements
            do j = 1, model%mesh%nodes(e)
                i = system%first(e) + n_fields*(j - 1)
                where (density(:, system%kind(e)) > 0.0_wp) system%massless(i + 1:i + n_fields) = .false.
            end do
        end do
        system%has_massless = any(system%massless)
        if (.not. system%has_massless) deallocate (system%massless)
        do s = 1, size(model%sections)
            if (model%sections(s)%inertia /= inertia_full) cycle
            k = (s - 1)*size(model%materials)
            density(:, k + 1:k + size(model%materials)) = 0.0_wp
        end do
        call system%mass%set_up(model%mesh, system%kind, density)
    end subroutine build_mass

    !> C = mass M + stiffness K, both of the undeformed beam, where the deck asks for damping.
    subroutine build_damping(model, system)
        type(model_t), intent(in) :: model
        type(system_t), intent(inout) :: system
        type(band_t) :: mass
        real(wp), allocatable :: rest(:), force(:)
        logical :: admissible

        system%rayleigh = model%damping
        if (model%damping%mass <= 0.0_wp .and. model%damping%stiffness <= 0.0_wp) return
        allocate (rest(system%n), force(system%n))
        rest = 0.0_wp
        call system%damping%set_up(system%n, system%kd, symmetric=.true.)
        call system%tangent(rest, force, system%damping, admissible)
        call system%mass_at(rest, mass)
        system%damping%a = model%damping%stiffness*system%damping%a + model%damping%mass*mass%a
    end subroutine build_damping

    !> Mass a unit length of each field, rho (A, A, I, I, I4), or rho (A, A, 0, 0, 0) for translational
    !> inertia.
    pure function field_density(material, section) result(density)
        type(material_t), intent(in) :: material
        type(section_t), intent(in) :: section
        real(wp) :: density(n_fields)

        density = material%rho*[section%area(), section%area(), section%second_moment(), &
            section%second_moment(), section%fourth_moment()]
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
                call element_energy(t%nodes, t%points, t%n, t%d*(1.0_wp/half), t%w*half, &
                    self%sections(self%kind(e)), u(first + 1:first + m), part, admissible)
            end associate
            if (.not. admissible) return
            energy = energy + part
        end do
    end subroutine strain_energy

    !> Internal force of the state u, conjugate to it; exactly none where the beam is undeformed, so that
    !> rounding does not set it in motion.
    pure subroutine internal_force(self, u, force, admissible)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: force(self%n)
        logical, intent(out) :: admissible
        real(wp) :: f(n_fields*max_nodes)
        integer :: e, m

        force = 0.0_wp
        admissible = .true.
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), half => self%half_length(e))
                m = n_fields*t%nodes
                if (all(abs(u(first + 1:first + m)) <= 0.0_wp)) cycle
                call element_force(t%nodes, t%points, t%n, t%d*(1.0_wp/half), t%w*half, &
                    self%sections(self%kind(e)), u(first + 1:first + m), f, admissible)
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
                ! One quotient an element, here as everywhere: 25 of them cost as much as its strains.
                call element_tangent(t%nodes, t%points, t%n, t%d*(1.0_wp/half), t%w*half, &
                    self%sections(self%kind(e)), u(first + 1:first + m), f, block, admissible)
                if (.not. admissible) return
                force(first + 1:first + m) = force(first + 1:first + m) + f(:m)
                call k%add_block(first, m, block)
            end associate
        end do
    end subroutine tangent

    !> Internal force averaged between the states u0 and u, and its tangent in u (gb_section_average); rule
    !> gauss only.
    pure subroutine average_tangent(self, u0, u, force, k, admissible)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u0(self%n), u(self%n)
        real(wp), intent(out) :: force(self%n)
        type(band_t), intent(inout) :: k                    !! general; cleared here
        logical, intent(out) :: admissible
        real(wp) :: f(n_fields*max_nodes), block((n_fields*max_nodes)**2)
        integer :: e, m

        force = 0.0_wp
        call k%clear()
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), half => self%half_length(e))
                m = n_fields*t%nodes
                call element_average_tangent(t%nodes, t%points, t%n, t%d*(1.0_wp/half), t%w*half, &
                    self%sections(self%kind(e)), u0(first + 1:first + m), u(first + 1:first + m), f, block, &
                    admissible)
                if (.not. admissible) return
                force(first + 1:first + m) = force(first + 1:first + m) + f(:m)
                call k%add_block(first, m, block)
            end associate
        end do
    end subroutine average_tangent

    !> force <- force + inertia force of the motion u, v, a;
    !> k <- k + factors(1) d/du + factors(2) d/dv + factors(3) d/da of it.
    pure subroutine add_inertia(self, u, v, a, factors, force, k)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n), v(self%n), a(self%n), factors(3)
        real(wp), intent(inout) :: force(self%n)
        type(band_t), intent(inout) :: k
        real(wp) :: constant_part(self%n), f(n_fields*max_nodes), block((n_fields*max_nodes)**2)
        integer :: e, m

        call self%mass%multiply(a, constant_part)
        force = force + constant_part
        call self%mass%add_to(factors(3), k)
        do e = 1, self%n_elements
            if (.not. self%has_full_inertia(e)) cycle
            associate (t => self%tables(exact_table(self, e)), first => self%first(e))
                m = n_fields*t%nodes
                call element_inertia(t%nodes, t%points, t%n, t%w*self%half_length(e), self%mass_moments(:, &
                    self%kind(e)), u(first + 1:first + m), v(first + 1:first + m), a(first + 1:first + m), &
                    factors, f, block)
                force(first + 1:first + m) = force(first + 1:first + m) + f(:m)
                call k%add_block(first, m, block)
            end associate
        end do
    end subroutine add_inertia

    !> Damping force C v, where there is damping; by the mass alone, which is never assembled, where that is
    !> all of it.
    pure subroutine drag(self, v, force)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: v(self%n)
        real(wp), intent(out) :: force(self%n)

        if (self%rayleigh%stiffness > 0.0_wp .or. any(self%has_full_inertia)) then
            call self%damping%multiply(v, force)
        else
            call self%mass%multiply(self%rayleigh%mass*v, force)
        end if
    end subroutine drag

    !> Number of the table that integrates an element's mass exactly: as many points as nodes.
    pure integer function exact_table(self, element)
        class(system_t), intent(in) :: self
        integer, intent(in) :: element

        exact_table = self%tables(self%table(element))%nodes - 1 + max_nodes - 1
    end function exact_table

    !> Mass matrix of the configuration u.
    pure subroutine mass_at(self, u, mass)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        type(band_t), intent(out) :: mass
        real(wp) :: rest(self%n), force(self%n)

        rest = 0.0_wp
        force = 0.0_wp
        call mass%set_up(self%n, self%kd, symmetric=.true.)
        call self%add_inertia(u, rest, rest, [0.0_wp, 0.0_wp, 1.0_wp], force, mass)
    end subroutine mass_at

    !> Row sums of the constant mass: a diagonal mass that keeps the total (n).
    pure function lumped_mass(self) result(lumped)
        class(system_t), intent(in) :: self
        real(wp) :: lumped(self%n)
        real(wp) :: ones(self%n)

        ones = 1.0_wp
        call self%mass%multiply(ones, lumped)
    end function lumped_mass

    !> A lower bound of the explicit scheme's stable step at the state u [T], 2/omega_max without damping: no
    !> frequency of the whole is higher than the highest of an element by itself, with lumped mass. A damping
    !> ratio d (of the highest frequency) makes it (2/omega_max) (sqrt(1 + 4 d^2) - 2 d).
    subroutine stable_step(self, u, step)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        real(wp), intent(out) :: step
        real(wp) :: f(n_fields*max_nodes), block((n_fields*max_nodes)**2), scale(n_fields*max_nodes), highest
        real(wp) :: values(n_fields*max_nodes), work(8*n_fields*max_nodes)
        real(wp), allocatable :: k(:, :)
        real(wp) :: omega, ratio
        logical :: admissible
        integer :: e, i, m, info

        highest = 0.0_wp
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), half => self%half_length(e))
                m = n_fields*t%nodes
                call element_tangent(t%nodes, t%points, t%n, t%d*(1.0_wp/half), t%w*half, &
                    self%sections(self%kind(e)), u(first + 1:first + m), f, block, admissible)
            end associate
            associate (t => self%tables(exact_table(self, e)), moments => self%mass_moments(:, self%kind(e)))
                do i = 1, t%nodes
                    scale(n_fields*(i - 1) + 1:n_fields*i) = self%half_length(e)*dot_product(t%w(:t%points), &
                                                             t%n(i, :t%points))*moments([1, 1, 2, 2, 3])
                end do
            end associate
            scale(:m) = 1.0_wp/sqrt(scale(:m))
            k = reshape(block(:m*m), [m, m])
            k = 0.5_wp*(k + transpose(k))*spread(scale(:m), 2, m)*spread(scale(:m), 1, m)
            call dsyev('N', 'U', m, k, m, values, work, size(work), info)
            highest = max(highest, values(m))
        end do
        omega = sqrt(highest)
        ratio = 0.5_wp*(self%rayleigh%mass/omega + self%rayleigh%stiffness*omega)
        step = 2.0_wp/(omega*(sqrt(1.0_wp + 4.0_wp*ratio**2) + 2.0_wp*ratio))
    end subroutine stable_step

    !> Kinetic energy of velocities v in the configuration u [F L].
    pure real(wp) function kinetic_energy(self, u, v)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n), v(self%n)
        integer :: e, m

        kinetic_energy = self%mass%energy(v)
        if (.not. any(self%has_full_inertia)) return
        do e = 1, self%n_elements
            if (.not. self%has_full_inertia(e)) cycle
            associate (t => self%tables(exact_table(self, e)), first => self%first(e))
                m = n_fields*t%nodes
                kinetic_energy = kinetic_energy + element_kinetic_energy(t%nodes, t%points, t%n, &
                    t%w*self%half_length(e), self%mass_moments(:, self%kind(e)), u(first + 1:first + m), &
                    v(first + 1:first + m))
            end associate
        end do
    end function kinetic_energy

    !> The part of each residual of a stage that rounding alone explains: unit round-off times sum |k_ij| u_j,
    !> where u_j is the largest value of the field and counts at least as its natural size (an element's
    !> length for displacements, since strains are differences of them).
    pure subroutine round_off(self, u, force_factor, mass_factor, bound)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)                   !! admissible
        real(wp), intent(in) :: force_factor, mass_factor   !! of the stage
        real(wp), intent(out) :: bound(self%n)
        real(wp) :: f(n_fields*max_nodes), block(n_fields*max_nodes*n_fields*max_nodes), sizes(n_fields, &
            max_nodes)
        real(wp), allocatable :: size_of(:)
        logical :: admissible
        integer :: e, field, m

        do field = 1, n_fields
            sizes(field, :) = maxval(abs(u(field::n_fields)))
        end do
        sizes(1:2, :) = max(sizes(1:2, :), 2.0_wp*minval(self%half_length))
        do field = 3, n_fields
            sizes(field, :) = max(sizes(field, :), self%field_scale(field))
        end do
        allocate (size_of(self%n))
        size_of = reshape(sizes(:, 1), [self%n], pad=sizes(:, 1))
        call self%mass%multiply(size_of, bound)
        bound = mass_factor*bound
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), half => self%half_length(e))
                m = n_fields*t%nodes
                call element_tangent(t%nodes, t%points, t%n, t%d*(1.0_wp/half), t%w*half, &
                    self%sections(self%kind(e)), &
                    u(first + 1:first + m), f, block, admissible)
                bound(first + 1:first + m) = bound(first + 1:first + m) + force_factor &
                    *matmul(reshape(abs(block(:m*m)), [m, m]), reshape(sizes(:, :t%nodes), [m]))
            end associate
        end do
        bound = epsilon(1.0_wp)*bound
    end subroutine round_off

    !> The point of the state u that is farthest into, or nearest to, the inadmissible: smallest J if some J
    !> is not positive, else largest (I1-2)/jm, else smallest J.
    pure function worst_point(self, u) result(worst)
        class(system_t), intent(in) :: self
        real(wp), intent(in) :: u(self%n)
        type(worst_point_t) :: worst
        real(wp) :: g(n_strains), i1_minus_2, j, badness, worst_badness
        integer :: e, i, k, nz

        worst_badness = -huge(1.0_wp)
        do e = 1, self%n_elements
            associate (t => self%tables(self%table(e)), first => self%first(e), &
                part => self%sections(self%kind(e)))
                nz = merge(part%nz, 1, part%rule == rule_gauss)
                do i = 1, t%points
                    g = element_strains(t%nodes, t%n(:, i), t%d(:, i)/self%half_length(e), &
                                        reshape(u(first + 1:first + n_fields*t%nodes), [n_fields, t%nodes]))
                    do k = 1, nz
                        call gauss_invariants(merge(part%z(k), 0.0_wp, part%rule == rule_gauss), g, &
                            i1_minus_2, j)
                        badness = max(i1_minus_2*part%p(4), 1.0_wp - j)
                        if (.not. badness <= worst_badness) then
                            worst_badness = badness
                            worst = worst_point_t(e, i, merge(part%z(k), 0.0_wp, part%rule == rule_gauss), &
                                i1_minus_2, j, unlimited_jm)
                            if (part%p(4) > 0.0_wp) worst%jm = 1.0_wp/part%p(4)
                        end if
                    end do
                end do
            end associate
        end do
    end function worst_point

end module gb_system
