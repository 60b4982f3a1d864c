!> The state of the beam: what changes while a model is solved.
module gb_state
    use gb_kinds, only: wp
    use gb_memory, only: memory_t
    implicit none
    private

    !> Fields and their time derivatives, node by node (u1, u3, y1, y3, xi).
    type, public :: state_t
        real(wp) :: time = 0.0_wp               !! of the running transient [T]
        real(wp) :: load = 0.0_wp               !! load factor that statics has reached [-]
        real(wp), allocatable :: u(:)           !! (5 nn)
        real(wp), allocatable :: v(:)           !! (5 nn) [field/T]
        real(wp), allocatable :: a(:)           !! (5 nn) [field/T^2]
    contains
        procedure :: exchange
        procedure :: pass_memory
    end type state_t

contains

    !> Change places with another state, load factor apart: nothing is copied.
    pure subroutine exchange(self, other)
        class(state_t), intent(inout) :: self
        type(state_t), intent(inout) :: other
        real(wp) :: time

        time = self%time
        self%time = other%time
        other%time = time
        call exchange_arrays(self%u, other%u)
        call exchange_arrays(self%v, other%v)
        call exchange_arrays(self%a, other%a)
    end subroutine exchange

    pure subroutine exchange_arrays(a, b)
        real(wp), allocatable, intent(inout) :: a(:), b(:)
        real(wp), allocatable :: kept(:)

        call move_alloc(a, kept)
        call move_alloc(b, a)
        call move_alloc(kept, b)
    end subroutine exchange_arrays

    !> All of it, under names that begin with `prefix`.
    subroutine pass_memory(self, memory, prefix)
        class(state_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory
        character(*), intent(in) :: prefix

        call memory%pass(prefix // '.time', self%time)
        call memory%pass(prefix // '.load', self%load)
        call memory%pass(prefix // '.u', self%u)
        call memory%pass(prefix // '.v', self%v)
        call memory%pass(prefix // '.a', self%a)
    end subroutine pass_memory

end module gb_state
