!> What acts on the beam from outside: every load as a vector of nodal forces times a history, and driven
!> supports.
module gb_external
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_sort, only: sorted
    use gb_fields, only: n_fields, dof_index, field_u1, field_y1
    use gb_history, only: history_t
    use gb_load, only: stage_all, stage_static, stage_transient
    use gb_mesh, only: mesh_t
    use gb_model, only: model_t
    use gb_motion, only: motion_t, build_motion
    use gb_quadrature, only: gauss_legendre
    use gb_shape, only: lagrange, max_nodes
    implicit none
    private

    !> Loads that share a history and a stage.
    type :: pattern_t
        integer :: history = 1
        integer :: stage = stage_all
        real(wp), allocatable :: force(:)           !! nodal forces at factor 1 (n)
    end type pattern_t

    type, public :: external_t
        type(pattern_t), allocatable :: patterns(:)
        type(history_t), allocatable :: histories(:)
        type(motion_t) :: motion                    !! driven supports
    contains
        procedure :: static_forces
        procedure :: factors_at
        procedure :: forces
        procedure :: work
        procedure :: events
    end type external_t

    !> When loads or driven supports jump or have a corner in a transient: instants that only rounding tells
    !> apart are one.
    type, public :: events_t
        real(wp), allocatable :: first(:)           !! of each event, increasing, in ]0, end_time[ [T] ...
        real(wp), allocatable :: last(:)            !! ... and from when on all of it has happened
        real(wp) :: start = 0.0_wp                  !! the same of events at time 0 [T]
        real(wp) :: end_time = 0.0_wp               !! where the last step ends: on an event that is there [T]
    end type events_t

    !> Two instants closer than this part of themselves are one.
    real(wp), parameter, public :: same_instant = 1.0e-9_wp

    public :: build_external

contains

    function build_external(model) result(external)
        type(model_t), intent(in) :: model
        type(external_t) :: external
        real(wp), allocatable :: force(:)
        integer :: i

        external%histories = model%histories
        external%motion = build_motion(model)
        allocate (external%patterns(0))
        allocate (force(n_fields*model%mesh%n_nodes()))
        do i = 1, size(model%point_loads)
            associate (load => model%point_loads(i))
                force = 0.0_wp
                call add_point(model%mesh, load%x, load%value, force)
                call add_pattern(external, load%history, load%stage, force)
            end associate
        end do
        do i = 1, size(model%distributed_loads)
            associate (load => model%distributed_loads(i))
                force = 0.0_wp
                call add_distributed(model%mesh, load%from, load%to, load%q, force)
                call add_pattern(external, load%history, load%stage, force)
            end associate
        end do
        do i = 1, size(model%gravity)
            associate (load => model%gravity(i))
                force = 0.0_wp
                call add_gravity(model, load%g, force)
                call add_pattern(external, load%history, load%stage, force)
            end associate
        end do
    end function build_external

    !> Join a load to the pattern of its history and stage, or open a new one.
    pure subroutine add_pattern(external, history, stage, force)
        type(external_t), intent(inout) :: external
        integer, intent(in) :: history, stage
        real(wp), intent(in) :: force(:)
        type(pattern_t), allocatable :: grown(:)
        integer :: i

        do i = 1, size(external%patterns)
            associate (pattern => external%patterns(i))
                if (pattern%history == history .and. pattern%stage == stage) then
                    pattern%force = pattern%force + force
                    return
                end if
            end associate
        end do
        allocate (grown(size(external%patterns) + 1))
        grown(:size(external%patterns)) = external%patterns
        grown(size(grown)) = pattern_t(history, stage, force)
        call move_alloc(grown, external%patterns)
    end subroutine add_pattern

    !> Forces f1, f3 on u1, u3 and couples m1, m3 on y1, y3 at a node.
    pure subroutine add_point(mesh, x, value, force)
        type(mesh_t), intent(in) :: mesh
        real(wp), intent(in) :: x, value(4)
        real(wp), intent(inout) :: force(:)
        integer :: first

        first = dof_index(field_u1, mesh%node_at(x))
        force(first:first + 3) = force(first:first + 3) + value
    end subroutine add_point

    !> Consistent nodal forces of a load spread evenly over [from, to], which may cut elements: exact, since
    !> the integrand is a shape function.
    pure subroutine add_distributed(mesh, from, to, q, force)
        type(mesh_t), intent(in) :: mesh
        real(wp), intent(in) :: from, to        !! [L]
        real(wp), intent(in) :: q(2)            !! [F/L]
        real(wp), intent(inout) :: force(:)
        real(wp) :: points(max_nodes), weights(max_nodes), n(max_nodes), d(max_nodes), left, length, low, &
            high, x
        integer :: e, i, node, first

        call gauss_legendre(points, weights)
        do e = mesh%element_at(from), mesh%element_at(to)
            associate (nodes => mesh%nodes(e))
                left = mesh%x(mesh%first_node(e))
                length = mesh%element_length(e)
                low = max(from, left)
                high = min(to, left + length)
                if (high <= low) cycle
                do i = 1, size(points)
                    x = low + 0.5_wp*(high - low)*(1.0_wp + points(i))
                    call lagrange(2.0_wp*(x - left)/length - 1.0_wp, n(:nodes), d(:nodes))
                    do node = 1, nodes
                        first = dof_index(field_u1, mesh%first_node(e) + node - 1)
                        force(first:first + 1) = force(first:first + 1) + 0.5_wp*(high &
                            - low)*weights(i)*n(node)*q
                    end do
                end do
            end associate
        end do
    end subroutine add_distributed

    !> Weight rho A g of every element, as a load spread over it.
    pure subroutine add_gravity(model, g, force)
        type(model_t), intent(in) :: model
        real(wp), intent(in) :: g(2)            !! [L/T^2]
        real(wp), intent(inout) :: force(:)
        real(wp) :: left, mass
        integer :: e

        associate (mesh => model%mesh)
            do e = 1, mesh%n_elements()
                left = mesh%x(mesh%first_node(e))
                mass = model%materials(mesh%material(e))%rho*model%sections(mesh%section(e))%area()
                call add_distributed(mesh, left, left + mesh%element_length(e), mass*g, force)
            end do
        end associate
    end subroutine add_gravity

    !> Nodal forces of statics at load factor 1, each history taken as 1.
    pure subroutine static_forces(self, force)
        class(external_t), intent(in) :: self
        real(wp), intent(out) :: force(:)
        integer :: i

        force = 0.0_wp
        do i = 1, size(self%patterns)
            if (self%patterns(i)%stage /= stage_transient) force = force + self%patterns(i)%force
        end do
    end subroutine static_forces

    !> What each pattern is multiplied with in a transient at time t, 0 for loads of statics; `before` asks
    !> for the values just before a jump.
    pure subroutine factors_at(self, t, before, factors, error)
        class(external_t), intent(in) :: self
        real(wp), intent(in) :: t               !! [T]
        logical, intent(in) :: before
        real(wp), intent(out) :: factors(:)     !! one a pattern [-]
        type(error_t), allocatable, intent(out) :: error
        integer :: i

        factors = 0.0_wp
        do i = 1, size(self%patterns)
            if (self%patterns(i)%stage == stage_static) cycle
            call self%histories(self%patterns(i)%history)%factor_at(t, before, factors(i), error)
            if (allocated(error)) return
        end do
    end subroutine factors_at

    !> Nodal forces, each pattern times its factor: weight * factors + (1 - weight) * others.
    pure subroutine forces(self, factors, force, weight, others)
        class(external_t), intent(in) :: self
        real(wp), intent(in) :: factors(:)      !! one a pattern [-]
        real(wp), intent(out) :: force(:)
        real(wp), intent(in), optional :: weight, others(:)
        real(wp) :: factor
        logical :: has_begun
        integer :: i

        has_begun = .false.
        do i = 1, size(self%patterns)
            if (self%patterns(i)%stage == stage_static) cycle
            factor = factors(i)
            if (present(weight)) factor = weight*factor + (1.0_wp - weight)*others(i)
            if (has_begun) then
                force = force + factor*self%patterns(i)%force
            else
                force = factor*self%patterns(i)%force
            end if
            has_begun = .true.
        end do
        if (.not. has_begun) force = 0.0_wp
    end subroutine forces

    !> Work of the loads on the way from one state to another, each by the mean of its factors there [F L].
    pure real(wp) function work(self, factors_from, factors_to, from, to)
        class(external_t), intent(in) :: self
        real(wp), intent(in) :: factors_from(:), factors_to(:)  !! one a pattern [-]
        real(wp), intent(in), contiguous :: from(:), to(:)
        integer :: i

        work = 0.0_wp
        do i = 1, size(self%patterns)
            if (self%patterns(i)%stage == stage_static) cycle
            work = work + 0.5_wp*(factors_from(i) + factors_to(i)) &
                *dot_product(self%patterns(i)%force, to - from)
        end do
    end function work

    !> All events up to end_time. Those within a small part of the step count as at time 0.
    pure function events(self, end_time, step)
        class(external_t), intent(in) :: self
        real(wp), intent(in) :: end_time            !! [T]
        real(wp), intent(in) :: step                !! fixed, or the first one [T]
        type(events_t) :: events
        real(wp), allocatable :: times(:)
        integer :: i, n

        allocate (times(0))
        do i = 1, size(self%patterns)
            if (self%patterns(i)%stage == stage_static) cycle
            times = [times, self%histories(self%patterns(i)%history)%events()]
        end do
        do i = 1, size(self%motion%unknown)
            times = [times, self%histories(self%motion%history(i))%events()]
        end do
        times = sorted(pack(times, times > 0.0_wp .and. times < end_time))
        allocate (events%first(size(times)), events%last(size(times)))
        events%end_time = end_time
        n = 0
        do i = 1, size(times)
            if (times(i) <= same_instant*step) then
                events%start = times(i)
            else if (times(i) >= end_time*(1.0_wp - same_instant)) then
                events%end_time = times(i)
                exit
            else
                if (n == 0) then
                    n = 1
                    events%first(n) = times(i)
                else if (times(i) > events%first(n)*(1.0_wp + same_instant)) then
                    n = n + 1
                    events%first(n) = times(i)
                end if
                events%last(n) = times(i)
            end if
        end do
        events%first = events%first(:n)
        events%last = events%last(:n)
    end function events

end module gb_external
