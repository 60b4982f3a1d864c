!> The joints of gb_block, end nodes between chunks and between the elements left over: in which order they
!> are eliminated, two in a step, one from each end of the beam, and which of their fields are held.
module gb_joints
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_lanes, only: lanes, pair
    use gb_slots, only: slots_t, n_node
    use gb_system, only: system_t
    implicit none
    private

    type, public :: joints_t
        integer :: steps = 0                            !! before the joint in which both ends meet
        integer :: meeting = 0                          !! this joint, an end node (0:elements)
        integer, allocatable :: nodes(:, :)             !! end nodes of a step (2, steps + 1)
        logical, allocatable :: meets_support(:)        !! whether a step or the one after does (steps + 1)
        integer, allocatable, private :: support(:)     !! of an end node, 0: none (0:elements)
        logical, allocatable, private :: is_held(:, :)  !! fields (5, 0:supports)
    contains
        procedure :: set_up
        procedure :: has_support
        procedure :: free_fields
    end type joints_t

contains

    pure subroutine set_up(self, system, slots)
        class(joints_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        type(slots_t), intent(in) :: slots
        integer :: s, step

        self%steps = sum([((slots%n_used(s) + 1)/2, s=max(1, slots%chunk), slots%n_slots)])
        call find_supports(self, system)
        call find_order(self, slots)
        allocate (self%meets_support(self%steps + 1))
        do step = 1, self%steps + 1
            self%meets_support(step) = self%has_support(self%nodes(:, step)) .or. &
                self%has_support(self%nodes(:, min(step, self%steps) + 1))
        end do
    end subroutine set_up

    !> Which fields of which end nodes are held; most nodes have column 0, which holds none.
    pure subroutine find_supports(self, system)
        class(joints_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        integer :: e, column

        allocate (self%support(0:system%n_elements))
        column = 0
        do e = 0, system%n_elements
            self%support(e) = 0
            if (.not. any(system%fixed(n_node*e + 1:n_node*e + n_fields))) cycle
            column = column + 1
            self%support(e) = column
        end do
        allocate (self%is_held(n_fields, 0:column))
        self%is_held(:, 0) = .false.
        do e = 0, system%n_elements
            column = self%support(e)
            if (column > 0) self%is_held(:, column) = system%fixed(n_node*e + 1:n_node*e + n_fields)
        end do
    end subroutine find_supports

    !> Nodes that are eliminated together, and at last the one in which both ends of the beam meet.
    pure subroutine find_order(self, slots)
        class(joints_t), intent(inout) :: self
        type(slots_t), intent(in) :: slots
        integer :: s, l, step

        allocate (self%nodes(pair, self%steps + 1))
        l = 2*((slots%n_used(slots%n_slots) + 1)/2) - 1
        self%meeting = slots%element(l, slots%n_slots)
        self%nodes(:, self%steps + 1) = self%meeting
        step = 0
        do s = 1, slots%n_slots
            if (s > 1 .and. s <= slots%chunk) cycle
            do l = 1, slots%n_used(s), pair
                step = step + 1
                self%nodes(1, step) = slots%outer(l, s)
                self%nodes(2, step) = slots%outer(min(l + 1, lanes), s)
            end do
        end do
    end subroutine find_order

    !> Whether any of some end nodes is held.
    pure logical function has_support(self, nodes)
        class(joints_t), intent(in) :: self
        integer, intent(in) :: nodes(:)
        integer :: i

        has_support = .false.
        do i = 1, size(nodes)
            has_support = has_support .or. self%support(nodes(i)) > 0
        end do
    end function has_support

    !> 0 where a field is held, else 1.
    pure function free_fields(self, nodes) result(free)
        class(joints_t), intent(in) :: self
        integer, intent(in) :: nodes(:)
        real(wp) :: free(size(nodes), n_fields)
        integer :: i

        do i = 1, size(nodes)
            free(i, :) = merge(0.0_wp, 1.0_wp, self%is_held(:, self%support(nodes(i))))
        end do
    end function free_fields

end module gb_joints
