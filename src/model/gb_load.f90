!> Supports, dead loads, initial conditions and damping, as the deck gives them: by place, not by node, so
!> that the same scene can be meshed again.
module gb_load
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_program, only: program_t
    implicit none
    private

    !> The commands a load acts in.
    integer, parameter, public :: stage_all = 1, stage_static = 2, stage_transient = 3

    !> CLAMP, PIN, ROLLER, SLIDE, FIX: fields held at a node.
    type, public :: support_t
        real(wp) :: x = 0.0_wp                      !! [L]
        logical :: fixed(n_fields) = .false.
    end type support_t

    !> PRESCRIBE: fields that follow value * history at a node.
    type, public :: prescribed_t
        real(wp) :: x = 0.0_wp                      !! [L]
        logical :: driven(n_fields) = .false.
        real(wp) :: value(n_fields) = 0.0_wp        !! units of the fields
        integer :: history = 1
    end type prescribed_t

    !> POINT: forces f1, f3 [F] on u1, u3 and couples m1, m3 [F L] on y1, y3.
    type, public :: point_load_t
        real(wp) :: x = 0.0_wp                      !! [L]
        real(wp) :: value(4) = 0.0_wp               !! f1, f3, m1, m3
        integer :: history = 1
        integer :: stage = stage_all
    end type point_load_t

    !> DISTRIBUTED: dead load a reference length.
    type, public :: distributed_load_t
        real(wp) :: from = 0.0_wp, to = 0.0_wp      !! [L]
        real(wp) :: q(2) = 0.0_wp                   !! q1, q3 [F/L]
        integer :: history = 1
        integer :: stage = stage_all
    end type distributed_load_t

    !> GRAVITY: acceleration on all mass.
    type, public :: gravity_t
        real(wp) :: g(2) = 0.0_wp                   !! g1, g3 [L/T^2]
        integer :: history = 1
        integer :: stage = stage_all
    end type gravity_t

    !> INITIAL: one field as a function of x.
    type, public :: initial_t
        logical :: is_velocity = .false.            !! else displacement
        integer :: field = 1
        type(program_t) :: formula                  !! of the variable x [L]
    end type initial_t

    !> DAMPING: C = mass M + stiffness K(initial).
    type, public :: damping_t
        real(wp) :: mass = 0.0_wp                   !! [1/T]
        real(wp) :: stiffness = 0.0_wp              !! [T]
    end type damping_t

end module gb_load
