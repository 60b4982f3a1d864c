!> How the elements of one beam go through the lane kernels. They are worked on in passes: so many from the
!> left end and so many from the right one that what has been condensed but not yet eliminated stays in the
!> cache; the last pass has all that is left between. A slot is what one call of a kernel works on: `lanes`
!> consecutive elements of a pass (its last lanes may repeat its last element).
module gb_slots
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_lanes, only: lanes
    use gb_element_columns, only: n_element, at_mu, at_log, at_power, at_bend, at_minus_beta, at_inverse_jm, &
        at_middle, at_z, at_weight, at_slope, at_kappa, at_bubble, at_by_bubble, at_swing, at_mass, &
        at_mass_moment, n_mass_moments
    use gb_beam, only: section_data_t
    use gb_system, only: system_t
    implicit none
    private

    integer, parameter, public :: n_node = 2*n_fields       !! unknowns from one end node to the next
    integer, parameter :: side = 32                         !! elements of each end of the beam in a pass
    integer, parameter, public :: pass_slots = 2*side/lanes !! slots in a pass at most; lanes divides side

    type, public :: slots_t
        integer :: n_elements = 0
        integer :: n_slots = 0
        integer :: pairs = 0                            !! of heights
        logical :: has_middle = .false.                 !! a height at the mid-line
        logical :: is_square = .true.                   !! beta = -2 everywhere
        logical :: has_limit = .true.                   !! 1/jm is felt somewhere
        logical :: has_full_inertia = .false.           !! mass depends on the configuration somewhere
        integer, allocatable :: first(:), last(:)       !! a slot's first and last element (slots)
        integer, allocatable :: constants_of(:)         !! which constants a slot has (slots)
        integer, allocatable :: pass_slot(:)            !! slots before a pass's first (passes + 1)
        integer, allocatable :: pass_step(:)            !! elements of each end before a pass's first (passes)
        integer, allocatable :: pass_elements(:)        !! (passes)
        real(wp), allocatable :: constants(:, :, :)     !! (lanes, n_element, sets)
    contains
        procedure :: set_up
        procedure :: gather
    end type slots_t

    public :: element_constants, has_square_power, has_chain_limit

contains

    subroutine set_up(self, system)
        class(slots_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        integer :: points

        self%n_elements = system%n_elements
        points = system%sections(system%kind(1))%nz
        self%pairs = points/2
        self%has_middle = modulo(points, 2) == 1
        self%is_square = has_square_power(system)
        self%has_limit = has_chain_limit(system)
        self%has_full_inertia = any(system%has_full_inertia)
        call plan_passes(self)
        call build_constants(self, system)
    end subroutine set_up

    !> Cut the beam into passes and these into slots.
    subroutine plan_passes(self)
        class(slots_t), intent(inout) :: self
        integer :: passes, left, right, e, p, s

        passes = 1 + max(0, (self%n_elements - 1)/(2*side))
        left = side*(passes - 1)
        right = self%n_elements - left
        allocate (self%pass_slot(passes + 1), self%pass_step(passes), self%pass_elements(passes))
        self%pass_step = [(side*(p - 1), p=1, passes)]
        self%pass_elements = 2*side
        self%pass_elements(passes) = right - left
        s = 2*side/lanes*(passes - 1) + (right - left + lanes - 1)/lanes
        self%n_slots = s
        allocate (self%first(s), self%last(s), self%constants_of(s))
        s = 0
        do p = 1, passes
            left = self%pass_step(p)
            right = self%n_elements - left
            self%pass_slot(p) = s
            if (p == passes) then
                call add_slots(left + 1, right)
            else
                call add_slots(left + 1, left + side)
                call add_slots(right - side + 1, right)
            end if
        end do
        self%pass_slot(passes + 1) = s

    contains

        subroutine add_slots(first, last)
            integer, intent(in) :: first, last

            do e = first, last, lanes
                s = s + 1
                self%first(s) = e
                self%last(s) = min(e + lanes - 1, last)
            end do
        end subroutine add_slots

    end subroutine plan_passes

    !> Constants of every slot; neighbours that are alike share theirs.
    subroutine build_constants(self, system)
        class(slots_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        real(wp) :: constants(lanes, n_element), last(lanes, n_element), blur
        integer :: round, s, sets

        ! Lengths of elements are differences of coordinates, and known no better than these.
        blur = 2.0_wp*epsilon(1.0_wp)*system%field_scale(1)/minval(2.0_wp*system%half_length)
        ! The first round counts the sets, the second one fills them in.
        do round = 1, 2
            sets = 0
            last = -1.0_wp
            do s = 1, self%n_slots
                call slot_constants(self, system, s, constants)
                if (any(abs(constants - last) > blur*abs(last))) then
                    sets = sets + 1
                    last = constants
                    if (round == 2) self%constants(:, :, sets) = constants
                end if
                self%constants_of(s) = sets
            end do
            if (round == 1) allocate (self%constants(lanes, n_element, sets))
        end do
    end subroutine build_constants

    pure subroutine slot_constants(self, system, slot, constants)
        class(slots_t), intent(in) :: self
        type(system_t), intent(in) :: system
        integer, intent(in) :: slot
        real(wp), intent(out) :: constants(lanes, n_element)
        integer :: l, e

        do l = 1, lanes
            e = min(self%first(slot) + l - 1, self%last(slot))
            constants(l, :) = element_constants(system%sections(system%kind(e)), &
                2.0_wp*system%half_length(e), &
                                                system%mass%density(:, system%kind(e)))
            if (system%has_full_inertia(e)) constants(l, at_mass_moment + 1:at_mass_moment + n_mass_moments) &
                = system%half_length(e)*system%mass_moments(:, system%kind(e))
        end do
    end subroutine slot_constants

    !> Whether beta is -2 in every element: J^-beta is J^2 then.
    pure logical function has_square_power(system)
        type(system_t), intent(in) :: system
        integer :: e

        has_square_power = .true.
        do e = 1, system%n_elements
            if (abs(system%sections(system%kind(e))%p(3) + 2.0_wp) > 0.0_wp) has_square_power = .false.
        end do
    end function has_square_power

    !> Whether the chains' limit is felt at all in some element: 1/jm is added to numbers of the size of 1.
    pure logical function has_chain_limit(system)
        type(system_t), intent(in) :: system
        integer :: e

        has_chain_limit = .false.
        do e = 1, system%n_elements
            if (system%sections(system%kind(e))%p(4) > 0.1_wp*epsilon(1.0_wp)) has_chain_limit = .true.
        end do
    end function has_chain_limit

    !> What the lane kernels need to know of an element.
    pure function element_constants(section, length, density) result(con)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: length                  !! [L]
        real(wp), intent(in) :: density(n_fields)       !! mass a unit length of each field
        real(wp) :: con(n_element)
        integer :: k, pairs

        con = 0.0_wp
        con(at_mu) = section%p(1)
        con(at_log) = section%p(1) - section%p(2)/section%p(3)
        con(at_power) = -section%p(2)/section%p(3)
        con(at_bend) = section%p(2)/section%p(3)*(section%p(3) + 1.0_wp)
        con(at_minus_beta) = -section%p(3)
        con(at_inverse_jm) = section%p(4)
        pairs = section%nz/2
        if (modulo(section%nz, 2) == 1) con(at_middle) = 0.5_wp*length*section%wz(pairs + 1)
        do k = 1, pairs
            con(at_z + k) = section%z(section%nz + 1 - k)
            con(at_weight + k) = 0.5_wp*length*section%wz(section%nz + 1 - k)
        end do
        con(at_slope) = 2.0_wp/length
        con(at_kappa) = length/(2.0_wp*sqrt(3.0_wp))
        con(at_bubble) = length*sqrt(3.0_wp)/4.0_wp
        con(at_by_bubble) = 4.0_wp/(length*sqrt(3.0_wp))
        con(at_swing) = length**2/48.0_wp
        con(at_mass + 1:at_mass + n_fields) = length*density
    end function element_constants

    !> The first nodes of consecutive elements, side by side.
    pure subroutine take_lanes(nodes, u, fields)
        integer, intent(in) :: nodes
        real(wp), intent(in) :: u(*)
        real(wp), intent(out) :: fields(lanes, n_fields, nodes)
        integer :: l, i, n

        do n = 1, nodes
            !GCC$ unroll 5
            do i = 1, n_fields
                do l = 1, lanes
                    fields(l, i, n) = u(n_node*(l - 1) + n_fields*(n - 1) + i)
                end do
            end do
        end do
    end subroutine take_lanes

    !> The nodes of a slot's elements, side by side, from `skip` nodes behind the left one on.
    pure subroutine gather(self, slot, skip, nodes, u, fields)
        class(slots_t), intent(in) :: self
        integer, intent(in) :: slot, skip, nodes
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out) :: fields(lanes, n_fields, nodes)
        integer :: l, i, n, first

        first = n_node*(self%first(slot) - 1) + n_fields*skip
        if (self%last(slot) - self%first(slot) + 1 == lanes) then
            call take_lanes(nodes, u(first + 1:), fields)
        else
            do l = 1, lanes
                do n = 1, nodes
                    !GCC$ unroll 5
                    do i = 1, n_fields
                        fields(l, i, n) = u(first + n_fields*(n - 1) + i)
                    end do
                end do
                if (self%first(slot) + l <= self%last(slot)) first = first + n_node
            end do
        end if
    end subroutine gather

end module gb_slots
