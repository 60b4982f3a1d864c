!> The tangent of one beam as a chain of nodes, three-node elements side by side in lanes (gb_slots). Middle
!> nodes are eliminated in the element (gb_element_lanes), the nodes between the elements of a chunk after
!> them, tied to the chunk's outer end (gb_blocks_lanes, gb_tie_lanes). What is left, a block-tridiagonal
!> system of five unknowns a joint of chunks and of elements left over, is eliminated from both ends of the
!> beam towards its middle, two joints at a time (gb_blocks_pair).
module gb_block
    use gb_kinds, only: wp, i8
    use gb_stream, only: put_aside, beyond_caches
    use gb_fields, only: n_fields
    use gb_lanes, only: lanes, pair
    use gb_element_columns, only: n_kept, n_condensed, at_ll, at_rr, at_lr, at_l, at_r, at_raw
    use gb_inertia_lanes, only: inertia_t
    use gb_element_lanes, only: condense_element, recover_middle
    use gb_energy_lanes, only: stored_energy, lane_kinetic_energy => kinetic_energy
    use gb_blocks_lanes, only: n_block, hold_between => hold, eliminate_between => eliminate_node, &
        back_substitute_between => back_substitute
    use gb_tie_lanes, only: hold_tie, pass_on_tie, follow_tie
    use gb_chain_lanes, only: join
    use gb_blocks_pair, only: n_triangle, n_kept_node, hold, eliminate_node, eliminate_last_node, &
        back_substitute
    use gb_stage, only: stage_t
    use gb_system, only: system_t
    use gb_slots, only: slots_t, n_node
    use gb_joints, only: joints_t
    use gb_linearised, only: linearised_t
    implicit none
    private

    type, extends(linearised_t), public :: block_t
        private
        type(slots_t) :: slots                              !! elements side by side
        real(wp), allocatable :: u_mass(:, :)               !! of the stage, side by side (lanes, 5 nodes)
        real(wp), allocatable :: u_damping(:, :)
        real(wp), allocatable :: u_start(:, :)
        real(wp), allocatable :: f_external(:, :, :, :)     !! at outer ends, middles (lanes, 5, 2, slots)
        type(joints_t) :: joints                            !! of chunks, and of elements left over
        !> Whether what is kept of elements and joints leaves the caches before it is used; it is formed in
        !> the arrays' places 0 then, and put aside.
        logical :: is_put_aside = .false.
        real(wp), allocatable :: kept(:, :, :)              !! of middle nodes (lanes, n_kept, 0:slots)
        real(wp), allocatable :: kept_between(:, :, :)      !! in chunks (lanes, n_kept_node, 2:chunk)
        real(wp), allocatable :: tie(:, :, :)               !! of these (lanes, n_block, 2:chunk)
        real(wp), allocatable :: kept_joint(:, :, :)        !! (2, n_kept_node, 0:steps + 1)
        real(wp) :: residuals(lanes, n_fields) = 0.0_wp     !! largest inside chunks and elements
        real(wp) :: end_residuals(pair, n_fields) = 0.0_wp  !! largest of a joint
        real(wp) :: forces(lanes, n_fields) = 0.0_wp        !! largest of an element on an end node
        logical :: may_be_indefinite = .false.              !! the tangent, of this stage
        real(wp) :: force_factor = 1.0_wp                   !! of the stage
        type(inertia_t) :: inertia                          !! of the stage, over its force_factor
    contains
        procedure :: set_up
        procedure :: take_stage
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
        integer :: i

        call self%slots%set_up(system)
        call self%joints%set_up(system, self%slots)
        self%inertia%drag = system%rayleigh%mass
        self%inertia%is_full = self%slots%has_full_inertia
        self%is_exact = .not. self%slots%has_full_inertia
        i = self%joints%steps + 1
        allocate (self%kept(lanes, n_kept, 0:self%slots%n_slots), self%kept_joint(pair, n_kept_node, 0:i))
        self%kept_joint(:, :, i) = 0.0_wp
        self%is_put_aside = storage_size(1.0_wp)/8*(size(self%kept, kind=i8) + size(self%kept_joint, &
            kind=i8)) > beyond_caches
        allocate (self%f_external(lanes, n_fields, 2, self%slots%n_slots))
        i = n_fields*self%slots%n_nodes
        allocate (self%u_mass(lanes, i), self%u_start(lanes, i))
        if (.not. needs_velocity(self)) i = 0
        allocate (self%u_damping(lanes, i))
        associate (chunk => self%slots%chunk)
            allocate (self%kept_between(lanes, n_kept_node, 2:chunk), self%tie(lanes, n_block, 2:chunk))
        end associate
    end subroutine set_up

    !> Put side by side what does not change from one iteration to the next.
    subroutine take_stage(self, stage)
        class(block_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
        real(wp) :: fields(lanes, n_fields, 3)
        integer :: s

        ! At rest a pivot that is not positive is a buckled state or a mechanism: LAPACK's matter. In motion
        ! it is a guess that is far off, which Newton's method leaves by itself; where it ends all must be.
        self%may_be_indefinite = stage%mass_factor > 0.0_wp
        self%force_factor = stage%force_factor
        self%inertia%mass_factor = stage%mass_factor/stage%force_factor
        self%inertia%damping_factor = stage%damping_factor/stage%force_factor
        if (stage%mass_factor > 0.0_wp) then
            call self%slots%gather_nodes(stage%u_mass, self%u_mass)
            if (needs_velocity(self)) call self%slots%gather_nodes(stage%u_damping, self%u_damping)
        end if
        if (stage%force_factor < 1.0_wp) call self%slots%gather_nodes(stage%u_start, self%u_start)
        do s = 1, self%slots%n_slots
            call self%slots%gather(s, stage%f_external, fields)
            self%f_external(:, :, :, s) = fields(:, :, :2)
        end do
    end subroutine take_stage

    !> Whether velocities are asked for, in motion.
    pure logical function needs_velocity(self)
        class(block_t), intent(in) :: self

        needs_velocity = self%inertia%drag > 0.0_wp .or. self%inertia%is_full
    end function needs_velocity

    subroutine evaluate(self, system, stage, u, admissible)
        class(block_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        logical, intent(out) :: admissible

        call condense_and_eliminate(self, stage, u, admissible)
    end subroutine evaluate

    subroutine residual(self, system, stage, u, r)
        class(block_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out), contiguous :: r(:)
        logical :: admissible

        call condense_and_eliminate(self, stage, u, admissible, r)
        where (system%fixed) r = 0.0_wp
    end subroutine residual

    !> From the ends of the beam to its middle: the chunks element by element and the joints between them,
    !> then the elements left over and theirs. The increment that is solved for is that of the point where the
    !> internal force is evaluated, force_factor times that of the unknowns: then the tangent of the internal
    !> force needs no scaling.
    subroutine condense_and_eliminate(self, stage, u, admissible, r)
        class(block_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        logical, intent(out) :: admissible
        real(wp), intent(out), contiguous, optional :: r(:)     !! residual, unknown by unknown
        real(wp) :: joined(lanes, n_condensed)      !! chunks, each as if an element, or elements left over
        real(wp) :: part(lanes, n_condensed, 0:1)   !! the last elements of the chunks, and those before
        real(wp) :: room(lanes), pivot(lanes)
        real(wp) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields), pivots(pair)
        integer :: s, now, step

        if (present(r)) r = -stage%f_external
        room = 1.0_wp
        pivot = 1.0_wp
        pivots = 1.0_wp
        k = 0.0_wp
        rhs = 0.0_wp
        raw = 0.0_wp
        self%residuals = 0.0_wp
        self%end_residuals = 0.0_wp
        self%forces = 0.0_wp
        step = 0
        do s = 1, self%slots%n_slots
            now = modulo(s, 2)
            if (s > self%slots%chunk) then
                call condense_slot(self, s, stage, u, joined, room, pivot)
                if (present(r)) call add_residual(self, s, joined, r)
            else
                call condense_slot(self, s, stage, u, part(:, :, now), room, pivot)
                if (present(r)) call add_residual(self, s, part(:, :, now), r)
                if (s == 1) then
                    joined = part(:, :, now)
                else
                    call lengthen(self, s, part(:, :, 1 - now), part(:, :, now), joined, pivot)
                end if
                if (s == self%slots%chunk) call close_chunks(part(:, :, now), joined)
            end if
            admissible = all(room > 0.0_wp)
            if (.not. admissible) return
            self%is_trusted = all(pivot > 0.0_wp) .and. all(pivots > 0.0_wp)
            if (.not. (self%is_trusted .or. self%may_be_indefinite)) return
            if (s >= self%slots%chunk) call eliminate_joints(self, s, joined, k, rhs, raw, pivots, step)
        end do
        call eliminate_last(self, stage%f_external, k, rhs, raw, pivots)
        self%is_trusted = all(pivot > 0.0_wp) .and. all(pivots > 0.0_wp)
    end subroutine condense_and_eliminate

    !> The elements of a slot, their middle nodes eliminated.
    subroutine condense_slot(self, slot, stage, u, part, room, pivot)
        class(block_t), intent(inout) :: self
        integer, intent(in) :: slot
        type(stage_t), intent(in) :: stage
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out) :: part(lanes, n_condensed)
        real(wp), intent(inout) :: room(lanes), pivot(lanes)
        real(wp), dimension(lanes, 3*n_fields) :: fields, v, a
        integer :: i, last, at, to

        at = self%slots%place(slot)
        call self%slots%gather(slot, u, fields)
        last = at + 3*n_fields
        if (stage%mass_factor > 0.0_wp) call move(self, slot, stage, fields, v, a)
        if (stage%force_factor < 1.0_wp) fields = self%u_start(:, at + 1:last) &
            + stage%force_factor*(fields - self%u_start(:, at + 1:last))
        to = merge(0, slot, self%is_put_aside)
        call condense_element(self%slots%pairs, self%slots%has_middle, self%slots%is_square, &
            self%slots%has_limit, self%slots%constants(:, :, self%slots%constants_of(slot)), &
            self%inertia, fields, v, a, self%f_external(:, :, 2, slot), part, &
            self%kept(:, :, to), room, pivot)
        if (self%is_put_aside) call put_aside(self%kept(:, :, 0), self%kept(:, :, slot), lanes*n_kept)
        !GCC$ unroll 5
        do i = 1, n_fields
            self%residuals(:, i) = max(self%residuals(:, i), abs(part(:, at_raw + n_fields + i)))
            self%forces(:, i) = max(self%forces(:, i), abs(part(:, at_raw + i)), abs(part(:, at_raw &
                + n_node + i)))
        end do
    end subroutine condense_slot

    !> Velocities v of a slot's elements, where something depends on them, and accelerations a, to which the
    !> damping by the mass adds `drag` v.
    pure subroutine move(self, slot, stage, u, v, a)
        class(block_t), intent(in) :: self
        integer, intent(in) :: slot
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: u(lanes, 3*n_fields)        !! fields at the end of the stage
        real(wp), intent(out), dimension(lanes, 3*n_fields) :: v, a
        integer :: first, last

        first = self%slots%place(slot) + 1
        last = self%slots%place(slot) + 3*n_fields
        a = stage%mass_factor*(u - self%u_mass(:, first:last))
        if (.not. needs_velocity(self)) return
        v = stage%damping_factor*(u - self%u_damping(:, first:last))
        a = a + self%inertia%drag*v
    end subroutine move

    !> Eliminate the nodes between the chunks so far and the elements of a slot.
    subroutine lengthen(self, slot, before, part, chunk, pivot)
        class(block_t), intent(inout) :: self
        integer, intent(in) :: slot
        real(wp), intent(in) :: before(lanes, n_condensed)      !! elements of the slot before
        real(wp), intent(inout) :: part(lanes, n_condensed)
        real(wp), intent(inout) :: chunk(lanes, n_condensed)    !! outer ends, and couplings to the inner ones
        real(wp), intent(inout) :: pivot(lanes)
        real(wp), dimension(lanes, n_fields) :: r, raw, inverse, free, next_free
        real(wp) :: k(lanes, n_triangle)

        call join(before, part, self%f_external(:, :, 1, slot), k, r, raw)
        if (self%joints%has_support(self%slots%outer(:, slot))) then
            free = self%joints%free_fields(self%slots%outer(:, slot))
            next_free = 1.0_wp
            call hold_between(free, next_free, k, part(1, at_lr + 1), r, raw)
            call hold_tie(free, chunk(1, at_lr + 1))
        end if
        self%residuals = max(self%residuals, abs(raw))
        associate (kept => self%kept_between(:, :, slot))
            call eliminate_between(k, part(1, at_lr + 1), r, part(1, at_rr + 1), part(1, at_r + 1), kept, &
                inverse, pivot)
            call pass_on_tie(kept, inverse, chunk(1, at_lr + 1), chunk(1, at_ll + 1), chunk(1, at_l + 1), &
                self%tie(:, :, slot))
        end associate
    end subroutine lengthen

    !> Inner ends of the chunks are those of their last elements.
    pure subroutine close_chunks(part, chunk)
        real(wp), intent(in) :: part(lanes, n_condensed)
        real(wp), intent(inout) :: chunk(lanes, n_condensed)

        chunk(:, at_rr + 1:at_rr + n_triangle) = part(:, at_rr + 1:at_rr + n_triangle)
        chunk(:, at_r + 1:at_r + n_fields) = part(:, at_r + 1:at_r + n_fields)
        chunk(:, at_raw + n_node + 1:) = part(:, at_raw + n_node + 1:)
    end subroutine close_chunks

    !> r <- r + the residual of a slot's elements on their nodes (external forces are in r already).
    pure subroutine add_residual(self, slot, part, r)
        class(block_t), intent(in) :: self
        integer, intent(in) :: slot
        real(wp), intent(in) :: part(lanes, n_condensed)
        real(wp), intent(inout) :: r(:)
        integer :: l, outer, middle, inner

        do l = 1, self%slots%n_used(slot)
            middle = n_node*self%slots%element(l, slot) - n_fields
            outer = n_node*self%slots%outer(l, slot)
            inner = 2*middle - outer
            r(outer + 1:outer + 5) = r(outer + 1:outer + 5) + part(l, at_raw + 1:at_raw + 5)
            r(middle + 1:middle + 5) = part(l, at_raw + 6:at_raw + 10)
            r(inner + 1:inner + 5) = r(inner + 1:inner + 5) + part(l, at_raw + 11:at_raw + 15)
        end do
    end subroutine add_residual

    !> Eliminate the outer ends of a slot's parts, two at a time (an odd lane's on the left of the beam and an
    !> even one's on the right). k, rhs and raw are what the joints before have left: block, right-hand side,
    !> and residual before any elimination. The last part may be alone: it is eliminated from the left then.
    subroutine eliminate_joints(self, slot, part, k, rhs, raw, pivots, step)
        class(block_t), intent(inout) :: self
        integer, intent(in) :: slot
        real(wp), intent(in) :: part(lanes, n_condensed)
        real(wp), intent(inout) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields), pivots(pair)
        integer, intent(inout) :: step                  !! steps so far
        real(wp) :: this_k(pair, n_triangle), c(pair, n_fields, n_fields)
        real(wp), dimension(pair, n_fields) :: this_rhs, this_raw, inverse, free, next_free
        real(wp) :: right_k(n_triangle), right_rhs(n_fields), right_raw(n_fields)
        integer :: lane, outermost, to
        logical :: is_alone

        outermost = merge(1, slot, slot == self%slots%chunk)
        do lane = 1, self%slots%n_used(slot), pair
            step = step + 1
            is_alone = lane == self%slots%n_used(slot)
            if (is_alone) then
                right_k = k(2, :)
                right_rhs = rhs(2, :)
                right_raw = raw(2, :)
            end if
            call enter(part(lane, 1), self%f_external(lane, 1, 1, outermost), k, rhs, raw, this_k, this_rhs, &
                this_raw, c)
            if (self%joints%meets_support(step)) then
                free = self%joints%free_fields(self%joints%nodes(:, step))
                next_free = self%joints%free_fields(self%joints%nodes(:, step + 1))
                call hold(free, next_free, this_k, c, this_rhs, this_raw)
            end if
            to = merge(0, step, self%is_put_aside)
            call eliminate_node(this_k, c, this_rhs, k, rhs, self%kept_joint(:, :, to), inverse, pivots)
            if (self%is_put_aside) call put_aside(self%kept_joint(:, :, 0), self%kept_joint(:, :, step), &
                pair*n_kept_node)
            if (is_alone) then
                k(2, :) = right_k
                rhs(2, :) = right_rhs
                raw(2, :) = right_raw
                this_raw(2, :) = 0.0_wp
            end if
            self%end_residuals = max(self%end_residuals, abs(this_raw))
        end do
    end subroutine eliminate_joints

    !> The blocks of a step: what is carried (k, rhs, raw) plus the outer ends of the next two parts less the
    !> external force there, and their coupling; and their inner ends, to be carried on.
    pure subroutine enter(part, f, k, rhs, raw, this_k, this_rhs, this_raw, c)
        real(wp), intent(in) :: part(lanes, *), f(lanes, *)     !! from the lane of the first of the two on
        real(wp), intent(inout) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields)
        real(wp), intent(out) :: this_k(pair, n_triangle)
        real(wp), intent(out), dimension(pair, n_fields) :: this_rhs, this_raw
        real(wp), intent(out) :: c(pair, n_fields, n_fields)
        integer, parameter :: two = min(pair, lanes)            !! a single lane stands for both
        integer :: i, j, l

        !GCC$ unroll 15
        do j = 1, n_triangle
            do l = 1, pair
                this_k(l, j) = k(l, j) + part(min(l, two), at_ll + j)
                k(l, j) = part(min(l, two), at_rr + j)
            end do
        end do
        !GCC$ unroll 5
        do j = 1, n_fields
            do l = 1, pair
                this_rhs(l, j) = rhs(l, j) + (part(min(l, two), at_l + j) - f(min(l, two), j))
                rhs(l, j) = part(min(l, two), at_r + j)
                this_raw(l, j) = raw(l, j) + (part(min(l, two), at_raw + j) - f(min(l, two), j))
                raw(l, j) = part(min(l, two), at_raw + n_node + j)
            end do
            !GCC$ unroll 5
            do i = 1, n_fields
                do l = 1, pair
                    c(l, i, j) = part(min(l, two), at_lr + 5*(j - 1) + i)
                end do
            end do
        end do
    end subroutine enter

    !> The joint in which both ends meet; both lanes do the same.
    subroutine eliminate_last(self, f_external, k, rhs, raw, pivots)
        class(block_t), intent(inout) :: self
        real(wp), intent(in) :: f_external(:)
        real(wp), intent(inout) :: k(pair, n_triangle), rhs(pair, n_fields), raw(pair, n_fields), pivots(pair)
        real(wp) :: no_coupling(pair, n_fields, n_fields), free(pair, n_fields)
        integer :: last, i

        last = self%joints%steps + 1
        do i = 1, n_triangle
            k(:, i) = k(1, i) + k(2, i)
        end do
        do i = 1, n_fields
            associate (f => f_external(n_node*self%joints%meeting + i))
                rhs(:, i) = rhs(1, i) + rhs(2, i) - f
                raw(:, i) = raw(1, i) + raw(2, i) - f
            end associate
        end do
        if (self%joints%meets_support(last)) then
            no_coupling = 0.0_wp
            free = self%joints%free_fields(self%joints%nodes(:, last))
            call hold(free, free, k, no_coupling, rhs, raw)
        end if
        self%end_residuals = max(self%end_residuals, abs(raw))
        call eliminate_last_node(k, rhs, self%kept_joint(:, :, last), pivots)
    end subroutine eliminate_last

    !> Back from the joint in the middle of the beam to its ends, from the joints into the chunks, and from
    !> the ends of the elements to their middles.
    subroutine solve(self, increment, singular)
        class(block_t), intent(inout) :: self
        real(wp), intent(out), contiguous :: increment(:)
        integer, intent(out) :: singular
        real(wp) :: x(pair, n_fields), next(pair, n_fields), du(lanes, n_fields, 3)
        integer :: step, s, middle

        singular = merge(0, -1, self%is_trusted .or. self%may_be_indefinite)
        if (singular /= 0) return
        step = self%joints%steps + 1
        next = 0.0_wp
        call back_substitute(self%kept_joint(:, :, step), next, x)
        middle = n_node*self%joints%meeting
        increment(middle + 1:middle + n_fields) = x(1, :)
        do s = self%slots%n_slots, max(1, self%slots%chunk), -1
            call solve_joints(self, s, x, step, du)
            if (s == self%slots%chunk) then
                call solve_chunks(self, du, increment)
            else
                call recover_middle(self%slots%constants(:, :, self%slots%constants_of(s)), &
                    self%kept(:, :, s), du)
                call self%slots%scatter(s, du, increment)
            end if
        end do
        if (self%force_factor < 1.0_wp) increment = increment/self%force_factor
    end subroutine solve

    !> Increments of the ends of a slot's parts: outer ones (du 1) from the inner ones (du 3).
    pure subroutine solve_joints(self, slot, x, step, du)
        class(block_t), intent(in) :: self
        integer, intent(in) :: slot
        real(wp), intent(inout) :: x(pair, n_fields)            !! of the joints last solved for
        integer, intent(inout) :: step                          !! last step that has been undone
        real(wp), intent(out) :: du(lanes, n_fields, 3)
        real(wp) :: next(pair, n_fields)
        integer :: lane, l, i

        du = 0.0_wp
        associate (n_used => self%slots%n_used(slot))
            do lane = pair*((n_used - 1)/pair) + 1, 1, -pair
                step = step - 1
                next = x
                call back_substitute(self%kept_joint(:, :, step), next, x)
                ! Where the last part was eliminated from the left alone, the right goes on from the middle.
                if (lane == n_used) x(2, :) = next(2, :)
                do i = 1, n_fields
                    do l = 1, min(pair, lanes)
                        du(lane + l - 1, i, 1) = x(l, i)
                        du(lane + l - 1, i, 3) = next(l, i)
                    end do
                end do
            end do
        end associate
    end subroutine solve_joints

    !> Increments inside the chunks, from their inner ends to the outer ones.
    subroutine solve_chunks(self, du, increment)
        class(block_t), intent(inout) :: self
        real(wp), intent(inout) :: du(lanes, n_fields, 3)       !! at the chunks' ends
        real(wp), intent(inout), contiguous :: increment(:)
        real(wp) :: outer(lanes, n_fields)
        integer :: s

        outer = du(:, :, 1)
        do s = self%slots%chunk, 1, -1
            if (s > 1) then
                call follow_tie(self%tie(:, :, s), outer, self%kept_between(:, :, s))
                call back_substitute_between(self%kept_between(:, :, s), du(:, :, 3), du(:, :, 1))
            else
                du(:, :, 1) = outer
            end if
            call recover_middle(self%slots%constants(:, :, self%slots%constants_of(s)), &
                self%kept(:, :, s), du)
            call self%slots%scatter(s, du, increment)
            du(:, :, 3) = du(:, :, 1)
        end do
    end subroutine solve_chunks

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
            call self%slots%gather(s, u, fields)
            call stored_energy(self%slots%pairs, self%slots%has_middle, self%slots%is_square, &
                self%slots%has_limit, self%slots%constants(:, :, self%slots%constants_of(s)), fields, &
                part, room)
            energy = energy + sum(part(:self%slots%n_used(s)))
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
            call self%slots%gather(s, v, rates)
            if (self%slots%has_full_inertia) call self%slots%gather(s, u, fields)
            call lane_kinetic_energy(self%slots%constants(:, :, self%slots%constants_of(s)), &
                self%slots%has_full_inertia, fields, rates, part)
            kinetic_energy = kinetic_energy + sum(part(:self%slots%n_used(s)))
        end do
    end function kinetic_energy

    !> Pivots that vanish are another solver's matter (`solve`).
    integer function mechanism(self)
        class(block_t), intent(in) :: self

        mechanism = 0
    end function mechanism

end module gb_block
