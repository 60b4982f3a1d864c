!> The tangent of one beam as a chain of nodes: three-node elements side by side in lanes, their middle nodes
!> eliminated (gb_element_lanes); what is left, a block-tridiagonal system of five unknowns an end node, is
!> eliminated from both ends of the beam towards its middle, two nodes at a time (gb_blocks_pair).
module gb_block
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_lanes, only: lanes, pair
    use gb_element_columns, only: n_kept, n_condensed, at_ll, at_rr, at_lr, at_l, at_r, at_raw
    use gb_inertia_lanes, only: inertia_t
    use gb_element_lanes, only: condense_element, recover_middle
    use gb_energy_lanes, only: stored_energy, lane_kinetic_energy => kinetic_energy
    use gb_blocks_pair, only: n_triangle, n_kept_node, eliminate_node, eliminate_last_node, back_substitute
    use gb_stage, only: stage_t
    use gb_system, only: system_t
    use gb_slots, only: slots_t, n_node, pass_slots
    use gb_linearised, only: linearised_t
    implicit none
    private

    type, extends(linearised_t), public :: block_t
        private
        integer :: n_elements = 0
        type(slots_t) :: slots                              !! elements side by side
        logical, allocatable :: is_held(:, :)               !! at end nodes (5, 0:n_elements)
        logical, allocatable :: has_support(:)              !! any of them (0:n_elements)
        real(wp), allocatable :: kept(:, :, :)              !! of middle nodes (lanes, n_kept, slots)
        real(wp), allocatable :: kept_node(:, :, :)         !! of end nodes (2, n_kept_node, steps + 1)
        real(wp) :: residuals(lanes, n_fields) = 0.0_wp     !! largest of a middle node
        real(wp) :: end_residuals(pair, n_fields) = 0.0_wp  !! largest of an end node
        real(wp) :: forces(lanes, n_fields) = 0.0_wp        !! largest of an element on an end node
        logical :: may_be_indefinite = .false.              !! the tangent, of this stage
        real(wp) :: force_factor = 1.0_wp                   !! of the stage
        type(inertia_t) :: inertia                          !! of the stage, over its force_factor
    contains
        procedure :: set_up
        procedure :: evaluate
        procedure :: solve
        procedure :: relative_residual
        procedure :: residual
        procedure :: mechanism
        procedure :: strain_energy
        procedure :: kinetic_energy
    end type block_t

contains

    !> For a system that gb_solver_choice finds fit: three-node elements with reduced integration, rule gauss
    !> with one number of points, supports at element ends alone, no damping but by the mass.
    subroutine set_up(self, system)
        class(block_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        integer :: n, e

        n = system%n_elements
        self%n_elements = n
        call self%slots%set_up(system)
        self%inertia%drag = system%rayleigh%mass
        self%inertia%is_full = self%slots%has_full_inertia
        self%is_exact = .not. self%slots%has_full_inertia
        allocate (self%is_held(n_fields, 0:n), self%has_support(0:n))
        do e = 0, n
            self%is_held(:, e) = system%fixed(n_node*e + 1:n_node*e + n_fields)
            self%has_support(e) = any(self%is_held(:, e))
        end do
        allocate (self%kept(lanes, n_kept, self%slots%n_slots))
        allocate (self%kept_node(pair, n_kept_node, (n + 1)/2 + 1))
        self%kept_node(:, :, (n + 1)/2 + 1) = 0.0_wp
    end subroutine set_up

    subroutine evaluate(self, system, stage, u, admissible)
        class(block_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        logical, intent(out) :: admissible
        real(wp) :: no_residual(0)

        call linearise(self, stage, u, no_residual, admissible)
    end subroutine evaluate

    subroutine residual(self, system, stage, u, r)
        class(block_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out), contiguous :: r(:)
        logical :: admissible

        call linearise(self, stage, u, r, admissible)
        where (system%fixed) r = 0.0_wp
    end subroutine residual

    !> The increment that is solved for is that of the point where the internal force is evaluated,
    !> force_factor times that of the unknowns: then the tangent of the internal force needs no scaling.
    subroutine linearise(self, stage, u, r, admissible)
        class(block_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out), contiguous :: r(:)  !! residual, unknown by unknown, where there is room for it
        logical, intent(out) :: admissible

        self%force_factor = stage%force_factor
        self%inertia%mass_factor = stage%mass_factor/stage%force_factor
        self%inertia%damping_factor = stage%damping_factor/stage%force_factor
        associate (factor => stage%force_factor)
            if (factor < 1.0_wp) then
                call condense_and_eliminate(self, stage, stage%u_start + factor*(u - stage%u_start), u, &
                    r, admissible)
            else
                call condense_and_eliminate(self, stage, u, u, r, admissible)
            end if
        end associate
    end subroutine linearise

    !> From the ends of the beam to its middle, pass by pass.
    subroutine condense_and_eliminate(self, stage, u_e, u, r, admissible)
        class(block_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u_e(:)  !! where the internal force is evaluated
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out), contiguous :: r(:)
        logical, intent(out) :: admissible
        real(wp) :: part(lanes, n_condensed, pass_slots), room(lanes), pivot(lanes)
        real(wp) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields), pivots(pair)
        integer :: pass, s, first

        ! At rest a pivot that is not positive is a buckled state or a mechanism: LAPACK's matter. In motion
        ! it is a guess that is far off, which Newton's method leaves by itself; where it ends all must be.
        self%may_be_indefinite = stage%mass_factor > 0.0_wp
        if (size(r) > 0) r = -stage%f_external
        room = 1.0_wp
        pivot = 1.0_wp
        pivots = 1.0_wp
        k = 0.0_wp
        rhs = 0.0_wp
        raw = 0.0_wp
        self%residuals = 0.0_wp
        self%end_residuals = 0.0_wp
        self%forces = 0.0_wp
        do pass = 1, size(self%slots%pass_step)
            first = self%slots%pass_slot(pass)
            do s = first + 1, self%slots%pass_slot(pass + 1)
                call condense_slot(self, s, stage, u_e, u, part(:, :, s - first), room, pivot)
                if (size(r) > 0) call gather_residual(self, s, part(:, :, s - first), r)
            end do
            admissible = all(room > 0.0_wp)
            if (.not. admissible) return
            call eliminate_pass(self, pass, part, stage%f_external, k, rhs, raw, pivots)
            self%is_trusted = all(pivot > 0.0_wp) .and. all(pivots > 0.0_wp)
            if (.not. (self%is_trusted .or. self%may_be_indefinite)) return
        end do
        call eliminate_last(self, stage%f_external, k, rhs, raw, pivots)
        self%is_trusted = all(pivot > 0.0_wp) .and. all(pivots > 0.0_wp)
    end subroutine condense_and_eliminate

    !> The elements of a slot, their middle nodes eliminated.
    subroutine condense_slot(self, slot, stage, u_e, u, part, room, pivot)
        class(block_t), intent(inout) :: self
        integer, intent(in) :: slot
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u_e(:), u(:)
        real(wp), intent(out) :: part(lanes, n_condensed)
        real(wp), intent(inout) :: room(lanes), pivot(lanes)
        real(wp), dimension(lanes, 3*n_fields) :: fields, at_end, v, a
        real(wp) :: f(lanes, n_fields)
        integer :: i

        call self%slots%gather(slot, 0, 3, u_e, fields)
        if (stage%mass_factor > 0.0_wp) then
            if (stage%force_factor < 1.0_wp) then
                call self%slots%gather(slot, 0, 3, u, at_end)
                call move(self, slot, stage, at_end, v, a)
            else
                call move(self, slot, stage, fields, v, a)
            end if
        end if
        call self%slots%gather(slot, 1, 1, stage%f_external, f)
        call condense_element(self%slots%pairs, self%slots%has_middle, self%slots%is_square, &
            self%slots%has_limit, self%slots%constants(:, :, self%slots%constants_of(slot)), &
            self%inertia, fields, v, a, f, part, self%kept(:, :, slot), room, pivot)
        !GCC$ unroll 5
        do i = 1, n_fields
            self%residuals(:, i) = max(self%residuals(:, i), abs(part(:, at_raw + n_fields + i)))
            self%forces(:, i) = max(self%forces(:, i), abs(part(:, at_raw + i)), abs(part(:, at_raw &
                + n_node + i)))
        end do
    end subroutine condense_slot

    !> Velocities v of a slot's elements, where something depends on them, and accelerations a, to which the
    !> damping by the mass adds `drag` v.
    subroutine move(self, slot, stage, u, v, a)
        class(block_t), intent(in) :: self
        integer, intent(in) :: slot
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: u(lanes, 3*n_fields)        !! fields at the end of the stage
        real(wp), intent(out), dimension(lanes, 3*n_fields) :: v, a
        real(wp) :: from(lanes, 3*n_fields)

        call self%slots%gather(slot, 0, 3, stage%u_mass, from)
        a = stage%mass_factor*(u - from)
        if (self%inertia%drag <= 0.0_wp .and. .not. self%inertia%is_full) return
        call self%slots%gather(slot, 0, 3, stage%u_damping, from)
        v = stage%damping_factor*(u - from)
        a = a + self%inertia%drag*v
    end subroutine move

    !> r <- r + the residual of a slot's elements on their nodes (external forces are in r already).
    subroutine gather_residual(self, slot, part, r)
        class(block_t), intent(in) :: self
        integer, intent(in) :: slot
        real(wp), intent(in) :: part(lanes, n_condensed)
        real(wp), intent(inout) :: r(:)
        integer :: e, l, first

        do e = self%slots%first(slot), self%slots%last(slot)
            l = e - self%slots%first(slot) + 1
            first = n_node*(e - 1)
            r(first + 1:first + 5) = r(first + 1:first + 5) + part(l, at_raw + 1:at_raw + 5)
            r(first + 6:first + 10) = part(l, at_raw + 6:at_raw + 10)
            r(first + 11:first + 15) = r(first + 11:first + 15) + part(l, at_raw + 11:at_raw + 15)
        end do
    end subroutine gather_residual

    !> Eliminate the end nodes of a pass, one from each end of the beam at a time (lane 1 from the left, lane
    !> 2 from the right). k, rhs and raw are what the nodes before have left: block, right-hand side, and
    !> residual before any elimination. With an odd number of elements the last one is eliminated from the
    !> left alone.
    subroutine eliminate_pass(self, pass, part, f_external, k, rhs, raw, pivots)
        class(block_t), intent(inout) :: self
        integer, intent(in) :: pass
        real(wp), intent(in) :: part(lanes, n_condensed, pass_slots)
        real(wp), intent(in), contiguous :: f_external(:)
        real(wp), intent(inout) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields), pivots(pair)
        real(wp) :: this_k(pair, n_triangle), c(pair, n_fields, n_fields)
        real(wp), dimension(pair, n_fields) :: this_rhs, this_raw
        real(wp) :: right_k(n_triangle), right_rhs(n_fields), right_raw(n_fields)
        integer :: i, step, left, right, near, far
        logical :: is_alone

        do i = 1, (self%slots%pass_elements(pass) + 1)/2
            step = self%slots%pass_step(pass) + i
            left = i - 1
            right = self%slots%pass_elements(pass) - i
            is_alone = left == right
            near = step - 1
            far = self%n_elements + 1 - step
            if (is_alone) then
                right_k = k(2, :)
                right_rhs = rhs(2, :)
                right_raw = raw(2, :)
            end if
            call enter(part(:, :, left/lanes + 1), part(:, :, right/lanes + 1), modulo(left, lanes) + 1, &
                modulo(right, lanes) + 1, f_external(n_node*near + 1:n_node*near + n_fields), &
                f_external(n_node*far + 1:n_node*far + n_fields), k, rhs, raw, this_k, this_rhs, this_raw, c)
            if (self%has_support(near) .or. self%has_support(near + 1)) then
                call support(self, near, near + 1, 1, this_k, this_rhs, this_raw, c)
            end if
            if (self%has_support(far) .or. self%has_support(far - 1)) then
                call support(self, far, far - 1, 2, this_k, this_rhs, this_raw, c)
            end if
            call eliminate_node(this_k, c, this_rhs, k, rhs, self%kept_node(:, :, step), pivots)
            if (is_alone) then
                k(2, :) = right_k
                rhs(2, :) = right_rhs
                raw(2, :) = right_raw
                this_raw(2, :) = 0.0_wp
            end if
            self%end_residuals = max(self%end_residuals, abs(this_raw))
        end do
    end subroutine eliminate_pass

    !> The blocks of a step: what is carried (k, rhs, raw) plus the near end of the next element less the
    !> external force there (f1, f2), the element's coupling; and its far end, to be carried on. The right
    !> element (part2, lane l2) is seen in the mirror.
    pure subroutine enter(part1, part2, l1, l2, f1, f2, k, rhs, raw, this_k, this_rhs, this_raw, c)
        real(wp), intent(in) :: part1(lanes, n_condensed), part2(lanes, n_condensed)
        integer, intent(in) :: l1, l2
        real(wp), intent(in) :: f1(n_fields), f2(n_fields)
        real(wp), intent(inout) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields)
        real(wp), intent(out) :: this_k(pair, n_triangle)
        real(wp), intent(out), dimension(pair, n_fields) :: this_rhs, this_raw
        real(wp), intent(out) :: c(pair, n_fields, n_fields)
        integer :: i, j

        !GCC$ unroll 15
        do j = 1, n_triangle
            this_k(1, j) = k(1, j) + part1(l1, at_ll + j)
            this_k(2, j) = k(2, j) + part2(l2, at_rr + j)
            k(1, j) = part1(l1, at_rr + j)
            k(2, j) = part2(l2, at_ll + j)
        end do
        !GCC$ unroll 5
        do j = 1, n_fields
            this_rhs(1, j) = rhs(1, j) + (part1(l1, at_l + j) - f1(j))
            this_rhs(2, j) = rhs(2, j) + (part2(l2, at_r + j) - f2(j))
            rhs(1, j) = part1(l1, at_r + j)
            rhs(2, j) = part2(l2, at_l + j)
            this_raw(1, j) = raw(1, j) + (part1(l1, at_raw + j) - f1(j))
            this_raw(2, j) = raw(2, j) + (part2(l2, at_raw + n_node + j) - f2(j))
            raw(1, j) = part1(l1, at_raw + n_node + j)
            raw(2, j) = part2(l2, at_raw + j)
            !GCC$ unroll 5
            do i = 1, n_fields
                c(1, i, j) = part1(l1, at_lr + 5*(j - 1) + i)
                c(2, i, j) = part2(l2, at_lr + 5*(i - 1) + j)
            end do
        end do
    end subroutine enter

    !> Supports of a node, whose rows and columns turn into those of the identity, and of the next one.
    pure subroutine support(self, node, next, lane, k, rhs, raw, c)
        class(block_t), intent(in) :: self
        integer, intent(in) :: node, next, lane
        real(wp), intent(inout) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields)
        real(wp), intent(inout) :: c(pair, n_fields, n_fields)
        integer :: i, j

        if (self%has_support(node)) then
            !GCC$ unroll 5
            do i = 1, n_fields
                if (.not. self%is_held(i, node)) cycle
                !GCC$ unroll 5
                do j = 1, n_fields
                    k(lane, max(i, j)*(max(i, j) - 1)/2 + min(i, j)) = 0.0_wp
                    c(lane, i, j) = 0.0_wp
                end do
                k(lane, i*(i + 1)/2) = 1.0_wp
                rhs(lane, i) = 0.0_wp
                raw(lane, i) = 0.0_wp
            end do
        end if
        if (self%has_support(next)) then
            do i = 1, n_fields
                if (self%is_held(i, next)) c(lane, :, i) = 0.0_wp
            end do
        end if
    end subroutine support

    !> The node in which both ends meet; both lanes do the same.
    subroutine eliminate_last(self, f_external, k, rhs, raw, pivots)
        class(block_t), intent(inout) :: self
        real(wp), intent(in) :: f_external(:)
        real(wp), intent(inout) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields), pivots(pair)
        real(wp) :: no_coupling(pair, n_fields, n_fields)
        integer :: steps, lane, i

        steps = (self%n_elements + 1)/2
        do i = 1, n_triangle
            k(:, i) = k(1, i) + k(2, i)
        end do
        do i = 1, n_fields
            rhs(:, i) = rhs(1, i) + rhs(2, i) - f_external(n_node*steps + i)
            raw(:, i) = raw(1, i) + raw(2, i) - f_external(n_node*steps + i)
        end do
        do lane = 1, pair
            call support(self, steps, steps, lane, k, rhs, raw, no_coupling)
        end do
        self%end_residuals = max(self%end_residuals, abs(raw))
        call eliminate_last_node(k, rhs, self%kept_node(:, :, steps + 1), pivots)
    end subroutine eliminate_last

    !> Back from the middle of the beam to its ends, and from the ends of the elements to their middles.
    subroutine solve(self, increment, singular)
        class(block_t), intent(inout) :: self
        real(wp), intent(out), contiguous :: increment(:)
        integer, intent(out) :: singular
        real(wp) :: x(pair, n_fields), next(pair, n_fields)
        integer :: step, steps, right, s

        singular = merge(0, -1, self%is_trusted .or. self%may_be_indefinite)
        if (singular /= 0) return
        steps = (self%n_elements + 1)/2
        next = 0.0_wp
        call back_substitute(self%kept_node(:, :, steps + 1), next, x)
        increment(n_node*steps + 1:n_node*steps + n_fields) = x(1, :)
        do step = steps, 1, -1
            next = x
            call back_substitute(self%kept_node(:, :, step), next, x)
            increment(n_node*(step - 1) + 1:n_node*(step - 1) + n_fields) = x(1, :)
            right = n_node*(self%n_elements + 1 - step)
            ! Where the last element was eliminated from the left alone, the right end goes on from the
            ! middle.
            if (2*step > self%n_elements) then
                x(2, :) = next(2, :)
            else
                increment(right + 1:right + n_fields) = x(2, :)
            end if
        end do
        do s = 1, self%slots%n_slots
            call recover_slot(self, s, increment)
        end do
        if (self%force_factor < 1.0_wp) increment = increment/self%force_factor
    end subroutine solve

    !> Increments of the middle nodes of a slot.
    pure subroutine recover_slot(self, slot, increment)
        class(block_t), intent(in) :: self
        integer, intent(in) :: slot
        real(wp), intent(inout), contiguous :: increment(:)
        real(wp) :: du(lanes, 3*n_fields)
        integer :: l, i, first

        call self%slots%gather(slot, 0, 1, increment, du)
        call self%slots%gather(slot, 2, 1, increment, du(:, n_node + 1:))
        call recover_middle(self%slots%constants(:, :, self%slots%constants_of(slot)), self%kept(:, :, &
            slot), du)
        do l = 1, self%slots%last(slot) - self%slots%first(slot) + 1
            first = n_node*(self%slots%first(slot) + l - 2) + n_fields
            do i = 1, n_fields
                increment(first + i) = du(l, n_fields + i)
            end do
        end do
    end subroutine recover_slot

    real(wp) function relative_residual(self, system, stage)
        class(block_t), intent(in) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp) :: forces
        integer :: i

        relative_residual = 0.0_wp
        forces = 0.0_wp
        do i = 1, n_fields
            relative_residual = max(relative_residual, system%field_scale(i) &
                *max(maxval(self%residuals(:, i)), maxval(self%end_residuals(:, i))))
            forces = max(forces, system%field_scale(i)*maxval(self%forces(:, i)))
        end do
        ! Where nothing but inertia acts, the residual is all there is.
        if (relative_residual > 0.0_wp) relative_residual = relative_residual/max(forces, relative_residual)
    end function relative_residual

    !> Strain energy [F L] of the state u. Not admissible: energy is meaningless.
    pure subroutine strain_energy(self, u, energy, admissible)
        class(block_t), intent(in) :: self
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out) :: energy
        logical, intent(out) :: admissible
        real(wp) :: fields(lanes, 3*n_fields), part(lanes), room(lanes)
        integer :: s

        energy = 0.0_wp
        room = 1.0_wp
        do s = 1, self%slots%n_slots
            call self%slots%gather(s, 0, 3, u, fields)
            call stored_energy(self%slots%pairs, self%slots%has_middle, self%slots%is_square, &
                self%slots%has_limit, self%slots%constants(:, :, self%slots%constants_of(s)), fields, &
                part, room)
            energy = energy + sum(part(:self%slots%last(s) - self%slots%first(s) + 1))
        end do
        admissible = all(room > 0.0_wp)
    end subroutine strain_energy

    !> Kinetic energy of the velocities v at the state u [F L].
    pure real(wp) function kinetic_energy(self, u, v)
        class(block_t), intent(in) :: self
        real(wp), intent(in), contiguous :: u(:), v(:)
        real(wp), dimension(lanes, 3*n_fields) :: fields, rates
        real(wp) :: part(lanes)
        integer :: s

        kinetic_energy = 0.0_wp
        do s = 1, self%slots%n_slots
            call self%slots%gather(s, 0, 3, v, rates)
            if (self%slots%has_full_inertia) call self%slots%gather(s, 0, 3, u, fields)
            call lane_kinetic_energy(self%slots%constants(:, :, self%slots%constants_of(s)), &
                self%slots%has_full_inertia, fields, rates, part)
            kinetic_energy = kinetic_energy + sum(part(:self%slots%last(s) - self%slots%first(s) + 1))
        end do
    end function kinetic_energy

    !> Pivots that vanish are another solver's matter (`solve`).
    integer function mechanism(self)
        class(block_t), intent(in) :: self

        mechanism = 0
    end function mechanism

end module gb_block
