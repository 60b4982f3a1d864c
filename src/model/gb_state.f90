!> The state of the beam: what changes while a model is solved.
module gb_state
    use gb_kinds, only: wp
    implicit none
    private

    !> Fields and their time derivatives, node by node (u1, u3, y1, y3, xi).
    type, public :: state_t
        real(wp) :: time = 0.0_wp               !! of the running transient [T]
        real(wp) :: load = 0.0_wp               !! load factor that statics has reached [-]
        real(wp), allocatable :: u(:)           !! (5 nn)
        real(wp), allocatable :: v(:)           !! (5 nn) [field/T]
        real(wp), allocatable :: a(:)           !! (5 nn) [field/T^2]
    end type state_t

end module gb_state
