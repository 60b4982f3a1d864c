!> Newton's method for one stage (gb_stage) of several beams side by side, one beam a lane, by the rules of
!> gb_newton, lane by lane: a lane that has converged keeps its state until all have, and no lane takes notice
!> of the others. What needs more than full steps and their halves (a tangent that is not definite, a line
!> search) is not tried here: such a lane fails.
module gb_newton_lanes
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_lanes, only: lanes
    use gb_system, only: system_t
    use gb_stage, only: stage_t
    use gb_newton, only: smallest_part, largest_part, coarse_part, max_halvings, may_be_rounding, is_last
    use gb_chain_lanes, only: chain_t
    implicit none
    private

    !> Unknowns of all beams lie as x(lanes, 5, nodes), and are passed on as such.
    type, public :: newton_lanes_t
        type(chain_t) :: chain
        real(wp) :: tolerance = 1.0e-10_wp
        integer :: max_iterations = 25
        integer :: n_nodes = 0
        integer :: members = 0                          !! lanes that are looked at; the others copy the last
        integer :: iterations(lanes) = 0                !! of the last solution
        logical :: has_converged(lanes) = .false.
        real(wp) :: residual(lanes) = 0.0_wp            !! last one over the forces that balance in it [-]
        real(wp), allocatable :: increments(:, :)       !! largest scaled one of each iteration (iter., lanes)
        real(wp) :: largest(lanes, n_fields) = 0.0_wp   !! largest value of each field so far
        real(wp) :: field_scale(lanes, n_fields) = 1.0_wp
        real(wp) :: curvature(lanes) = 0.0_wp           !! as newton_t's, also of the running solution alone,
        real(wp) :: own_curvature(lanes) = 0.0_wp       !! and as it was before
        real(wp) :: old_curvature(lanes) = 0.0_wp
        real(wp) :: last(lanes) = 0.0_wp                !! last increment, 0 where it was not taken whole
        real(wp) :: pivot(lanes) = 1.0_wp
        logical :: is_active(lanes) = .false.           !! still iterating
        real(wp), allocatable :: increment(:, :, :)     !! (lanes, 5, nodes)
    contains
        procedure :: set_up
        procedure :: solve
    end type newton_lanes_t

contains

    !> Take the members, one a lane; their systems must be alike (gb_ensemble).
    pure subroutine set_up(self, systems, tolerance, iterations)
        class(newton_lanes_t), intent(inout) :: self
        type(system_t), intent(in) :: systems(:)
        real(wp), intent(in) :: tolerance
        integer, intent(in) :: iterations
        integer :: l, member

        self%members = size(systems)
        self%tolerance = tolerance
        self%max_iterations = iterations
        self%n_nodes = systems(1)%n/n_fields
        call self%chain%set_up(systems(1))
        do l = 1, lanes
            member = min(l, self%members)
            call self%chain%take_member(l, systems(member))
            self%field_scale(l, :) = systems(member)%field_scale
        end do
        allocate (self%increments(iterations, lanes), self%increment(lanes, n_fields, self%n_nodes))
    end subroutine set_up

    !> Solve R(u) = 0 in the wanted lanes, from the guess u or, where that is not admissible, from the state
    !> `origin`. Where has_converged is false afterwards, u is worthless.
    subroutine solve(self, systems, stage, origin, is_wanted, u)
        class(newton_lanes_t), intent(inout) :: self
        type(system_t), intent(in) :: systems(:)
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: origin(lanes, n_fields, self%n_nodes)
        logical, intent(in) :: is_wanted(lanes)
        real(wp), intent(inout) :: u(lanes, n_fields, self%n_nodes)
        real(wp) :: norm(lanes, n_fields), check(lanes)
        logical :: takes(lanes), is_coarse(lanes)
        integer :: iteration

        self%is_active = is_wanted
        self%has_converged = .false.
        self%iterations = 0
        self%last = 0.0_wp
        self%own_curvature = 0.0_wp
        self%old_curvature = self%curvature
        call start(self, stage, origin, u)
        call widen(self, u, self%is_active)
        do iteration = 1, self%max_iterations
            if (.not. any(self%is_active)) exit
            call self%chain%solve(stage%force_factor, self%increment, norm, check)
            call clear_lanes(self%n_nodes, .not. abs(check) <= 0.0_wp, self%increment)
            call judge(self, systems, stage, iteration, u, norm, check, takes, is_coarse)
            call add_increment(self%n_nodes, merge(1.0_wp, 0.0_wp, takes), self%increment, u)
            if (.not. any(self%is_active)) exit
            call advance(self, stage, u)
            if (any(is_coarse .and. self%is_active)) call widen(self, u, is_coarse .and. self%is_active)
        end do
        call note_residuals(self, self%is_active)
        self%is_active = .false.
    end subroutine solve

    !> Linearise at the guess; lanes where that is not admissible begin at `origin`.
    subroutine start(self, stage, origin, u)
        class(newton_lanes_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
        real(wp), intent(in) :: origin(lanes, n_fields, self%n_nodes)
        real(wp), intent(inout) :: u(lanes, n_fields, self%n_nodes)
        real(wp) :: room(lanes)
        integer :: l

        call self%chain%linearise(stage, u, room, self%pivot)
        if (all(room > 0.0_wp .or. .not. self%is_active)) return
        do l = 1, lanes
            if (self%is_active(l) .and. .not. room(l) > 0.0_wp) u(l, :, :) = origin(l, :, :)
        end do
        call self%chain%linearise(stage, u, room, self%pivot)
        self%is_active = self%is_active .and. room > 0.0_wp
    end subroutine start

    !> Look at the increments of the lanes that iterate: which are taken, which are the last ones, and which
    !> are so coarse that the largest values of the fields may change.
    subroutine judge(self, systems, stage, iteration, u, norm, check, takes, is_coarse)
        class(newton_lanes_t), intent(inout) :: self
        type(system_t), intent(in) :: systems(:)
        type(stage_t), intent(in) :: stage
        integer, intent(in) :: iteration
        real(wp), intent(in) :: u(lanes, n_fields, self%n_nodes), norm(lanes, n_fields), check(lanes)
        logical, intent(out) :: takes(lanes), is_coarse(lanes)
        logical :: was_active(lanes)
        integer :: l

        was_active = self%is_active
        takes = .false.
        is_coarse = .false.
        do l = 1, lanes
            if (.not. self%is_active(l)) cycle
            self%is_active(l) = self%pivot(l) > 0.0_wp .and. abs(check(l)) <= 0.0_wp .and. &
                all(norm(l, :) <= largest_part*max(self%field_scale(l, :), self%largest(l, :)))
            if (.not. self%is_active(l)) cycle
            call judge_lane(self, systems(min(l, self%members)), stage, iteration, l, u, &
                maxval(norm(l, :)/self%largest(l, :)), takes(l))
            is_coarse(l) = self%last(l) > coarse_part
        end do
        call note_residuals(self, was_active .and. .not. self%is_active)
    end subroutine judge

    subroutine judge_lane(self, system, stage, iteration, l, u, increment, takes)
        class(newton_lanes_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        integer, intent(in) :: iteration, l
        real(wp), intent(in) :: u(lanes, n_fields, self%n_nodes)
        real(wp), intent(in) :: increment               !! largest value, scaled
        logical, intent(out) :: takes
        real(wp) :: last

        takes = .false.
        last = self%last(l)
        self%iterations(l) = iteration
        self%increments(iteration, l) = increment
        if (may_be_rounding(self%tolerance, iteration, increment, last)) then
            if (is_round_off(system, stage, l, self%n_nodes, u)) then
                self%iterations(l) = iteration - 1
                self%has_converged(l) = .true.
                self%is_active(l) = .false.
                return
            end if
        end if
        if (last > 0.0_wp .and. increment > self%tolerance) then
            self%own_curvature(l) = max(self%own_curvature(l), increment/last**2)
            self%curvature(l) = max(self%own_curvature(l), 0.5_wp*self%old_curvature(l))
        end if
        takes = .true.
        self%has_converged(l) = is_last(self%tolerance, self%curvature(l)*increment**2, increment, &
            last > 0.0_wp)
        self%is_active(l) = .not. self%has_converged(l)
        self%last(l) = increment
    end subroutine judge_lane

    !> Increments that are not finite are nobody's, and shall not be met again.
    pure subroutine clear_lanes(n_nodes, is_meant, increment)
        integer, intent(in) :: n_nodes
        logical, intent(in) :: is_meant(lanes)
        real(wp), intent(inout) :: increment(lanes, n_fields, n_nodes)
        integer :: l

        if (.not. any(is_meant)) return
        do l = 1, lanes
            if (is_meant(l)) increment(l, :, :) = 0.0_wp
        end do
    end subroutine clear_lanes

    !> u <- u + part * increment, lane by lane.
    pure subroutine add_increment(n_nodes, part, increment, u)
        integer, intent(in) :: n_nodes
        real(wp), intent(in) :: part(lanes)
        real(wp), intent(in) :: increment(lanes, n_fields, n_nodes)
        real(wp), intent(inout) :: u(lanes, n_fields, n_nodes)
        integer :: node, i

        do node = 1, n_nodes
            !GCC$ unroll 5
            do i = 1, n_fields
                u(:, i, node) = u(:, i, node) + part*increment(:, i, node)
            end do
        end do
    end subroutine add_increment

    !> Linearise at the new states; where these are not admissible, take half the increment, a quarter, ...
    subroutine advance(self, stage, u)
        class(newton_lanes_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
        real(wp), intent(inout) :: u(lanes, n_fields, self%n_nodes)
        real(wp) :: room(lanes), part
        logical :: is_beyond(lanes)
        integer :: halving

        part = 1.0_wp
        do halving = 0, max_halvings
            call self%chain%linearise(stage, u, room, self%pivot)
            is_beyond = self%is_active .and. .not. room > 0.0_wp
            if (.not. any(is_beyond)) return
            part = 0.5_wp*part
            where (is_beyond) self%last = 0.0_wp
            call add_increment(self%n_nodes, merge(-part, 0.0_wp, is_beyond), self%increment, u)
        end do
        self%is_active = self%is_active .and. .not. is_beyond
    end subroutine advance

    !> Keep the largest value of every field so far.
    pure subroutine widen(self, u, is_meant)
        class(newton_lanes_t), intent(inout) :: self
        real(wp), intent(in) :: u(lanes, n_fields, self%n_nodes)
        logical, intent(in) :: is_meant(lanes)
        real(wp) :: largest(lanes, n_fields)
        integer :: node, i

        largest = 0.0_wp
        do node = 1, self%n_nodes
            !GCC$ unroll 5
            do i = 1, n_fields
                largest(:, i) = max(largest(:, i), abs(u(:, i, node)))
            end do
        end do
        do i = 1, n_fields
            where (is_meant) self%largest(:, i) = max(self%largest(:, i), largest(:, i), &
                smallest_part*self%field_scale(:, i))
        end do
    end subroutine widen

    !> Keep the residuals of lanes whose iteration ends here.
    pure subroutine note_residuals(self, is_meant)
        class(newton_lanes_t), intent(inout) :: self
        logical, intent(in) :: is_meant(lanes)
        real(wp) :: forces, residual
        integer :: l

        do l = 1, lanes
            if (.not. is_meant(l)) cycle
            residual = maxval(self%field_scale(l, :)*self%chain%residuals(l, :))
            forces = maxval(self%field_scale(l, :)*self%chain%forces(l, :))
            if (residual > 0.0_wp) residual = residual/max(forces, residual)
            self%residual(l) = residual
        end do
    end subroutine note_residuals

    !> Whether rounding alone explains the residual of a lane.
    logical function is_round_off(system, stage, l, n_nodes, u)
        type(system_t), intent(in) :: system
        type(stage_t), intent(in) :: stage
        integer, intent(in) :: l, n_nodes
        real(wp), intent(in) :: u(lanes, n_fields*n_nodes)
        real(wp), allocatable :: own(:), u_e(:), r(:), inertia(:), bound(:)
        logical :: admissible

        allocate (r(system%n), inertia(system%n), bound(system%n))
        own = u(l, :)
        u_e = own
        if (stage%force_factor < 1.0_wp) u_e = stage%u_start(l::lanes) + stage%force_factor*(own &
            - stage%u_start(l::lanes))
        call system%internal_force(u_e, r, admissible)
        call system%mass%multiply(stage%mass_factor*(own - stage%u_mass(l::lanes)), inertia)
        r = r + inertia - stage%f_external(l::lanes)
        call system%round_off(u_e, stage%force_factor, stage%mass_factor, bound)
        is_round_off = admissible .and. all(abs(r) <= bound .or. system%fixed)
    end function is_round_off

end module gb_newton_lanes
