!> How the elements of one beam go through the lane kernels: from both ends of the beam towards its middle,
!> odd lanes from the left end and even lanes from the right one, where they see elements in the mirror (as if
!> their lengths were negative). First every lane takes a chunk of consecutive elements, all of one number:
!> lanes 1 and 2 the outermost ones, 3 and 4 the next. The elements left over lie between the chunks and are
!> taken one a lane, outermost first. A slot is what one call of a kernel works on: the elements of the chunks
!> that have the same number, or some of those left over (lanes without one repeat another's).
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

    integer, parameter, public :: n_node = 2*n_fields   !! unknowns from one end node to the next
    integer, parameter :: both = min(2, lanes)          !! 1 with a single lane, which sees no mirror
    !> Every other lane. (A loop in the constant would need a variable, which all threads would share.)
    logical, parameter :: is_mirrored(lanes) = reshape([.false., .true.], [lanes], pad=[.false., .true.])
    integer, parameter :: stride(lanes) = merge(-n_fields, n_fields, is_mirrored)   !! from node to node
    !> Shorter chunks do not pay, nor longer ones: what they keep leaves the cache. With two lanes none does:
    !> each end of the beam has one.
    integer, parameter :: least_chunk = merge(4, huge(1), lanes > 2), most_chunk = 1000

    type, public :: slots_t
        integer :: n_slots = 0
        integer :: chunk = 0                            !! elements of a lane's chunk
        integer :: n_nodes = 0                          !! of a lane, all slots together
        integer :: pairs = 0                            !! of heights
        logical :: has_middle = .false.                 !! a height at the mid-line
        logical :: is_square = .true.                   !! beta = -2 everywhere
        logical :: has_limit = .true.                   !! 1/jm is felt somewhere
        logical :: has_full_inertia = .false.           !! mass depends on the configuration somewhere
        integer, allocatable :: element(:, :)           !! which element a lane has (lanes, slots)
        integer, allocatable :: outer(:, :)             !! its end node nearer to the lane's end of the beam
        integer, allocatable :: place(:)                !! unknowns of a lane before a slot's first (slots)
        integer, allocatable :: n_used(:)               !! lanes with an element of their own (slots)
        integer, allocatable :: constants_of(:)         !! which constants a slot has (slots)
        real(wp), allocatable :: constants(:, :, :)     !! (lanes, n_element, sets)
    contains
        procedure :: set_up
        procedure :: gather
        procedure :: gather_nodes
        procedure :: scatter
    end type slots_t

    public :: element_constants, has_square_power, has_chain_limit

contains

    subroutine set_up(self, system)
        class(slots_t), intent(inout) :: self
        type(system_t), intent(in) :: system
        integer :: points

        points = system%sections(system%kind(1))%nz
        self%pairs = points/2
        self%has_middle = modulo(points, 2) == 1
        self%is_square = has_square_power(system)
        self%has_limit = has_chain_limit(system)
        self%has_full_inertia = any(system%has_full_inertia)
        call plan_slots(self, system%n_elements)
        call build_constants(self, system)
    end subroutine set_up

    !> Cut the beam into chunks, one a lane, and these and what is left over into slots.
    pure subroutine plan_slots(self, n_elements)
        class(slots_t), intent(inout) :: self
        integer, intent(in) :: n_elements
        integer :: n_rest, l, s, before, done

        self%chunk = min(n_elements/lanes, most_chunk)
        if (self%chunk < least_chunk) self%chunk = 0
        n_rest = n_elements - lanes*self%chunk
        self%n_slots = self%chunk + (n_rest + lanes - 1)/lanes
        allocate (self%element(lanes, self%n_slots), self%outer(lanes, self%n_slots))
        allocate (self%n_used(self%n_slots), self%place(self%n_slots), self%constants_of(self%n_slots))
        self%n_nodes = 0
        do s = 1, self%n_slots
            done = lanes/both*(s - self%chunk - 1)      ! of the elements left over, from each end
            self%n_used(s) = merge(lanes, min(lanes, n_rest - both*done), s <= self%chunk)
            do l = 1, lanes
                if (s <= self%chunk) then
                    before = self%chunk*((l - 1)/both) + s - 1
                else
                    before = self%chunk*(lanes/both) + done + min(l - 1, self%n_used(s) - 1)/both
                end if
                self%element(l, s) = merge(n_elements - before, before + 1, is_mirrored(l))
                self%outer(l, s) = merge(n_elements - before, before, is_mirrored(l))
            end do
            ! Consecutive elements of a chunk share a node.
            if (s > 1 .and. s <= self%chunk) self%n_nodes = self%n_nodes - 1
            self%place(s) = n_fields*self%n_nodes
            self%n_nodes = self%n_nodes + 3
        end do
    end subroutine plan_slots

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
            e = self%element(l, slot)
            constants(l, :) = element_constants(system%sections(system%kind(e)), &
                merge(-2.0_wp, 2.0_wp, is_mirrored(l))*system%half_length(e), &
                system%mass%density(:, system%kind(e)))
            ! A mass has no sign: it is the same in the mirror.
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
        real(wp), intent(in) :: length                  !! negative: seen in the mirror [L]
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
        if (modulo(section%nz, 2) == 1) con(at_middle) = 0.5_wp*abs(length)*section%wz(pairs + 1)
        do k = 1, pairs
            con(at_z + k) = section%z(section%nz + 1 - k)
            con(at_weight + k) = 0.5_wp*abs(length)*section%wz(section%nz + 1 - k)
        end do
        con(at_slope) = 2.0_wp/length
        con(at_kappa) = length/(2.0_wp*sqrt(3.0_wp))
        con(at_bubble) = length*sqrt(3.0_wp)/4.0_wp
        con(at_by_bubble) = 4.0_wp/(length*sqrt(3.0_wp))
        con(at_swing) = length**2/48.0_wp
        con(at_mass + 1:at_mass + n_fields) = abs(length)*density
    end function element_constants

    !> Unknowns of the nodes of a slot's elements, side by side.
    pure subroutine gather(self, slot, u, fields)
        class(slots_t), intent(in) :: self
        integer, intent(in) :: slot
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(out) :: fields(lanes, n_fields, 3)
        integer :: l, i, n, at(lanes)

        at = n_node*self%outer(:, slot)
        !GCC$ unroll 3
        do n = 1, 3
            do i = 1, n_fields
                !GCC$ unroll 16
                do l = 1, lanes
                    fields(l, i, n) = u(at(l) + (n - 1)*stride(l) + i)
                end do
            end do
        end do
    end subroutine gather

    !> All unknowns, side by side.
    pure subroutine gather_nodes(self, u, fields)
        class(slots_t), intent(in) :: self
        real(wp), intent(in), contiguous :: u(:)
        real(wp), intent(inout) :: fields(lanes, n_fields*self%n_nodes)
        integer :: s

        do s = 1, self%n_slots
            call self%gather(s, u, fields(1, self%place(s) + 1))
        end do
    end subroutine gather_nodes

    !> The way back for the first two nodes.
    pure subroutine scatter(self, slot, fields, u)
        class(slots_t), intent(in) :: self
        integer, intent(in) :: slot
        real(wp), intent(in) :: fields(lanes, n_fields, 2)
        real(wp), intent(inout), contiguous :: u(:)
        integer :: l, i, at, next

        do l = 1, self%n_used(slot)
            at = n_node*self%outer(l, slot)
            next = at + stride(l)
            !GCC$ unroll 5
            do i = 1, n_fields
                u(at + i) = fields(l, i, 1)
                u(next + i) = fields(l, i, 2)
            end do
        end do
    end subroutine scatter

end module gb_slots
