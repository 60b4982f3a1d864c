!> The tangents of several beams side by side, one beam a lane: elements one after the other from the left end
!> to the right one, their middle nodes and then their left nodes eliminated at once, so that everything
!> between condensation and elimination stays near the processor.
module gb_chain_lanes
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_lanes, only: lanes
    use gb_element_columns, only: n_element, n_kept, n_condensed, at_ll, at_rr, at_lr, at_l, at_r, at_raw
    use gb_inertia_lanes, only: inertia_t
    use gb_element_lanes, only: condense_element, recover_middle
    use gb_energy_lanes, only: stored_energy, lane_kinetic_energy => kinetic_energy
    use gb_blocks_lanes, only: n_triangle, n_kept_node, eliminate_node, eliminate_last_node, back_substitute
    use gb_slots, only: element_constants, has_square_power, has_chain_limit
    use gb_stage, only: stage_t
    use gb_system, only: system_t
    implicit none
    private

    integer, parameter :: raw_right = at_raw + 2*n_fields

    !> Unknowns of all beams lie as x(lanes, 5, nodes), and are passed on as such.
    type, public :: chain_t
        integer :: n_elements = 0
        integer :: pairs = 0                            !! of heights
        logical :: has_middle = .false., is_square = .true., has_limit = .true.
        real(wp), allocatable :: constants(:, :, :)     !! (lanes, n_element, elements)
        logical, allocatable :: is_held(:, :)           !! at end nodes (5, 0:elements)
        logical, allocatable :: has_support(:)          !! any of them (0:elements)
        real(wp), allocatable :: kept(:, :, :)          !! of middle nodes (lanes, n_kept, elements)
        real(wp), allocatable :: kept_node(:, :, :)     !! of end nodes (lanes, n_kept_node, 0:elements)
        real(wp) :: residuals(lanes, n_fields) = 0.0_wp !! largest of a node
        real(wp) :: forces(lanes, n_fields) = 0.0_wp    !! largest of an element on an end node
    contains
        procedure :: set_up
        procedure :: take_member
        procedure :: linearise
        procedure :: solve
        procedure :: strain_energy
        procedure :: kinetic_energy
    end type chain_t

    public :: join

contains

    !> Room for members like this one.
    pure subroutine set_up(self, system)
        class(chain_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        integer :: e, points

        associate (n => system%n_elements)
            self%n_elements = n
            points = system%sections(system%kind(1))%nz
            self%pairs = points/2
            self%has_middle = modulo(points, 2) == 1
            self%is_square = has_square_power(system)
            self%has_limit = has_chain_limit(system)
            allocate (self%constants(lanes, n_element, n))
            allocate (self%is_held(n_fields, 0:n), self%has_support(0:n))
            do e = 0, n
                self%is_held(:, e) = system%fixed(2*n_fields*e + 1:2*n_fields*e + n_fields)
                self%has_support(e) = any(self%is_held(:, e))
            end do
            allocate (self%kept(lanes, n_kept, n), self%kept_node(lanes, n_kept_node, 0:n))
            self%kept_node(:, :, n) = 0.0_wp
        end associate
    end subroutine set_up

    !> Put a member into a lane.
    pure subroutine take_member(self, lane, system)
        class(chain_t), intent(inout) :: self
        integer, intent(in) :: lane
        type(system_t), intent(in) :: system
        integer :: e

        do e = 1, self%n_elements
            associate (kind => system%kind(e))
                self%constants(lane, :, e) = element_constants(system%sections(kind), &
                    2.0_wp*system%half_length(e), system%mass%density(:, kind))
            end associate
        end do
    end subroutine take_member

    !> Residual and factorised tangent of a stage in motion at u. Where room is not positive, u is not
    !> admissible; where pivot is not, the tangent is not definite. As in gb_block the increment that is
    !> solved for is that of the point where the internal force is evaluated.
    subroutine linearise(self, stage, u, room, pivot)
        class(chain_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: u(lanes, n_fields, 2*self%n_elements + 1)
        real(wp), intent(out) :: room(lanes), pivot(lanes)

        if (stage%force_factor < 1.0_wp) then
            call eliminate_chain(self, self%n_elements, stage%mass_factor, stage%force_factor, u, &
                stage%u_mass, stage%u_start, stage%f_external, room, pivot)
        else
            call eliminate_chain(self, self%n_elements, stage%mass_factor, 1.0_wp, u, stage%u_mass, u, &
                stage%f_external, room, pivot)
        end if
    end subroutine linearise

    !> Two elements' parts are kept: what the left one has left in the node between them, and the right one.
    subroutine eliminate_chain(self, n, mass_factor, force_factor, u, u_mass, u_start, f, room, pivot)
        class(chain_t), intent(inout) :: self
        integer, intent(in) :: n
        real(wp), intent(in) :: mass_factor, force_factor
        real(wp), intent(in), dimension(lanes, n_fields, 2*n + 1) :: u, u_mass, u_start, f
        real(wp), intent(out) :: room(lanes), pivot(lanes)
        real(wp) :: part(lanes, n_condensed, 0:1), fields(lanes, n_fields, 3), a(lanes, n_fields, 3)
        real(wp) :: k(lanes, n_triangle), r(lanes, n_fields), raw(lanes, n_fields), inverse(lanes, n_fields)
        type(inertia_t) :: inertia
        integer :: e, now, before

        inertia%mass_factor = mass_factor/force_factor
        room = 1.0_wp
        pivot = 1.0_wp
        part(:, :, 0) = 0.0_wp
        self%residuals = 0.0_wp
        self%forces = 0.0_wp
        do e = 1, n
            now = modulo(e, 2)
            before = 1 - now
            call accelerate(mass_factor, u(1, 1, 2*e - 1), u_mass(1, 1, 2*e - 1), a)
            if (force_factor < 1.0_wp) then
                call go_back(force_factor, u(1, 1, 2*e - 1), u_start(1, 1, 2*e - 1), fields)
                call condense_element(self%pairs, self%has_middle, self%is_square, self%has_limit, &
                    self%constants(:, :, e), inertia, fields, a, a, f(1, 1, 2*e), &
                    part(:, :, now), self%kept(:, :, e), room, pivot)
            else
                call condense_element(self%pairs, self%has_middle, self%is_square, self%has_limit, &
                    self%constants(:, :, e), inertia, u(1, 1, 2*e - 1), a, a, f(1, 1, 2*e), &
                    part(:, :, now), self%kept(:, :, e), room, pivot)
            end if
            call join(part(:, :, before), part(:, :, now), f(1, 1, 2*e - 1), k, r, raw)
            if (self%has_support(e - 1)) call hold(self%is_held(:, e - 1), k, r, part(1, at_lr + 1, now), raw)
            if (self%has_support(e)) call hold_next(self%is_held(:, e), part(1, at_lr + 1, now))
            call watch(part(:, :, now), raw, self%residuals, self%forces)
            call eliminate_node(k, part(1, at_lr + 1, now), r, part(1, at_rr + 1, now), &
                part(1, at_r + 1, now), self%kept_node(:, :, e - 1), inverse, pivot)
        end do
        call eliminate_last(self, part(:, :, modulo(n, 2)), f(1, 1, 2*n + 1), pivot)
    end subroutine eliminate_chain

    !> Accelerations of an element's nodes.
    pure subroutine accelerate(mass_factor, u, u_mass, a)
        real(wp), intent(in) :: mass_factor
        real(wp), intent(in), dimension(lanes, 3*n_fields) :: u, u_mass
        real(wp), intent(out) :: a(lanes, 3*n_fields)
        integer :: i

        !GCC$ unroll 15
        do i = 1, 3*n_fields
            a(:, i) = mass_factor*(u(:, i) - u_mass(:, i))
        end do
    end subroutine accelerate

    !> An element's fields where the internal force is evaluated.
    pure subroutine go_back(force_factor, u, u_start, fields)
        real(wp), intent(in) :: force_factor
        real(wp), intent(in), dimension(lanes, 3*n_fields) :: u, u_start
        real(wp), intent(out) :: fields(lanes, 3*n_fields)
        integer :: i

        !GCC$ unroll 15
        do i = 1, 3*n_fields
            fields(:, i) = u_start(:, i) + force_factor*(u(:, i) - u_start(:, i))
        end do
    end subroutine go_back

    !> Block and residual of an element's left node: what the element before has left there and its own,
    !> less the external force; and the residual before any elimination.
    pure subroutine join(before, part, f, k, r, raw)
        real(wp), intent(in) :: before(lanes, n_condensed), part(lanes, n_condensed), f(lanes, n_fields)
        real(wp), intent(out) :: k(lanes, n_triangle), r(lanes, n_fields), raw(lanes, n_fields)
        integer :: i

        !GCC$ unroll 15
        do i = 1, n_triangle
            k(:, i) = before(:, at_rr + i) + part(:, at_ll + i)
        end do
        !GCC$ unroll 5
        do i = 1, n_fields
            r(:, i) = before(:, at_r + i) + (part(:, at_l + i) - f(:, i))
            raw(:, i) = before(:, raw_right + i) + (part(:, at_raw + i) - f(:, i))
        end do
    end subroutine join

    !> The largest residuals of an element's left and middle nodes, and its largest forces on the end nodes.
    pure subroutine watch(part, raw, residuals, forces)
        real(wp), intent(in) :: part(lanes, n_condensed)
        real(wp), intent(in) :: raw(lanes, n_fields)        !! of the left node
        real(wp), intent(inout) :: residuals(lanes, n_fields), forces(lanes, n_fields)
        integer :: i

        !GCC$ unroll 5
        do i = 1, n_fields
            residuals(:, i) = max(residuals(:, i), abs(raw(:, i)), abs(part(:, at_raw + n_fields + i)))
            forces(:, i) = max(forces(:, i), abs(part(:, at_raw + i)), abs(part(:, raw_right + i)))
        end do
    end subroutine watch

    !> Held fields of a node: their rows and columns turn into those of the identity.
    pure subroutine hold(is_held, k, r, c, raw)
        logical, intent(in) :: is_held(n_fields)
        real(wp), intent(inout) :: k(lanes, n_triangle), r(lanes, n_fields), c(lanes, n_fields, n_fields)
        real(wp), intent(inout) :: raw(lanes, n_fields)
        integer :: i, j

        !GCC$ unroll 5
        do i = 1, n_fields
            if (.not. is_held(i)) cycle
            !GCC$ unroll 5
            do j = 1, n_fields
                k(:, max(i, j)*(max(i, j) - 1)/2 + min(i, j)) = 0.0_wp
                c(:, i, j) = 0.0_wp
            end do
            k(:, i*(i + 1)/2) = 1.0_wp
            r(:, i) = 0.0_wp
            raw(:, i) = 0.0_wp
        end do
    end subroutine hold

    !> Held fields of the node that another one is coupled to.
    pure subroutine hold_next(is_held, c)
        logical, intent(in) :: is_held(n_fields)
        real(wp), intent(inout) :: c(lanes, n_fields, n_fields)
        integer :: i

        do i = 1, n_fields
            if (is_held(i)) c(:, :, i) = 0.0_wp
        end do
    end subroutine hold_next

    !> The right end of the beams.
    subroutine eliminate_last(self, part, f, pivot)
        class(chain_t), intent(inout) :: self
        real(wp), intent(in) :: part(lanes, n_condensed), f(lanes, n_fields)
        real(wp), intent(inout) :: pivot(lanes)
        real(wp) :: k(lanes, n_triangle), r(lanes, n_fields), raw(lanes, n_fields)
        real(wp) :: no_coupling(lanes, n_fields, n_fields)

        k = part(:, at_rr + 1:at_rr + n_triangle)
        r = part(:, at_r + 1:at_r + n_fields) - f
        raw = part(:, raw_right + 1:raw_right + n_fields) - f
        if (self%has_support(self%n_elements)) then
            call hold(self%is_held(:, self%n_elements), k, r, no_coupling, raw)
        end if
        self%residuals = max(self%residuals, abs(raw))
        call eliminate_last_node(k, r, self%kept_node(:, :, self%n_elements), pivot)
    end subroutine eliminate_last

    !> Increments of all nodes, from the right end to the left one, and the largest of each field; `check` is
    !> zero where they are finite.
    subroutine solve(self, force_factor, du, norm, check)
        class(chain_t), intent(in) :: self
        real(wp), intent(in) :: force_factor
        real(wp), intent(out) :: du(lanes, n_fields, 2*self%n_elements + 1)
        real(wp), intent(out) :: norm(lanes, n_fields), check(lanes)
        real(wp) :: beyond(lanes, n_fields)
        integer :: e, n

        n = self%n_elements
        beyond = 0.0_wp
        norm = 0.0_wp
        check = 0.0_wp
        call back_substitute(self%kept_node(:, :, n), beyond, du(1, 1, 2*n + 1))
        call measure(1, du(1, 1, 2*n + 1), norm, check)
        do e = n, 1, -1
            call back_substitute(self%kept_node(:, :, e - 1), du(1, 1, 2*e + 1), du(1, 1, 2*e - 1))
            call recover_middle(self%constants(:, :, e), self%kept(:, :, e), du(1, 1, 2*e - 1))
            call measure(2, du(1, 1, 2*e - 1), norm, check)
        end do
        if (force_factor < 1.0_wp) then
            du = du/force_factor
            norm = norm/force_factor
        end if
    end subroutine solve

    !> Take nodes into the largest values of the fields, and into `check`: 0 times infinities and NaNs is a
    !> NaN.
    pure subroutine measure(nodes, x, norm, check)
        integer, intent(in) :: nodes
        real(wp), intent(in) :: x(lanes, n_fields, nodes)
        real(wp), intent(inout) :: norm(lanes, n_fields), check(lanes)
        real(wp) :: sum(lanes)
        integer :: node, i

        do node = 1, nodes
            do i = 1, lanes
                sum(i) = 0.0_wp
            end do
            !GCC$ unroll 5
            do i = 1, n_fields
                norm(:, i) = max(norm(:, i), abs(x(:, i, node)))
                sum = sum + 0.0_wp*x(:, i, node)
            end do
            check = check + sum
        end do
    end subroutine measure

    !> Strain energy [F L] of the states u; meaningless where room is not positive.
    pure subroutine strain_energy(self, u, energy, room)
        class(chain_t), intent(in) :: self
        real(wp), intent(in) :: u(lanes, n_fields, 2*self%n_elements + 1)
        real(wp), intent(out) :: energy(lanes), room(lanes)
        real(wp) :: part(lanes)
        integer :: e

        energy = 0.0_wp
        room = 1.0_wp
        do e = 1, self%n_elements
            call stored_energy(self%pairs, self%has_middle, self%is_square, self%has_limit, &
                self%constants(:, :, e), u(1, 1, 2*e - 1), part, room)
            energy = energy + part
        end do
    end subroutine strain_energy

    !> Kinetic energy [F L] of the velocities v.
    pure subroutine kinetic_energy(self, v, energy)
        class(chain_t), intent(in) :: self
        real(wp), intent(in) :: v(lanes, n_fields, 2*self%n_elements + 1)
        real(wp), intent(out) :: energy(lanes)
        real(wp) :: part(lanes)
        integer :: e

        energy = 0.0_wp
        do e = 1, self%n_elements
            call lane_kinetic_energy(self%constants(:, :, e), .false., v(1, 1, 2*e - 1), &
                v(1, 1, 2*e - 1), part)
            energy = energy + part
        end do
    end subroutine kinetic_energy

end module gb_chain_lanes
