!> What a time integration scheme is to the rest of the program: it turns a step into one or more implicit
!> stages (gb_stage) and their solutions into displacements, velocities and accelerations. It knows no element
!> and no load.
module gb_scheme
    use gb_kinds, only: wp
    use gb_state, only: state_t
    use gb_stage, only: stage_t
    implicit none
    private

    type, abstract, public :: scheme_t
        integer :: stages = 1                           !! implicit equations a step
        !> Inertia and damping act on weight * (end of the stage) + (1 - weight) * (start of the step).
        real(wp) :: weight_a = 1.0_wp, weight_v = 1.0_wp
        logical :: is_explicit = .false.                !! needs no equations solved
        logical :: has_symmetric_tangent = .true.       !! where the elements' tangent is symmetric
    contains
        procedure(set_stage_i), deferred :: set_stage
        procedure(finish_stage_i), deferred :: finish_stage
        procedure(load_mix_i), deferred :: load_mix
    end type scheme_t

    abstract interface
        !> Factors and reference displacements of the number-th stage of a step dt from the committed state.
        pure subroutine set_stage_i(self, number, dt, committed, previous, stage)
            import :: scheme_t, wp, state_t, stage_t
            class(scheme_t), intent(in) :: self
            integer, intent(in) :: number
            real(wp), intent(in) :: dt                      !! [T]
            type(state_t), intent(in) :: committed
            type(state_t), intent(in) :: previous           !! end of the previous stage
            type(stage_t), intent(inout) :: stage
        end subroutine set_stage_i

        !> Velocities and accelerations at the end of a stage whose displacements stand in reached%u.
        pure subroutine finish_stage_i(self, number, dt, committed, previous, reached)
            import :: scheme_t, wp, state_t
            class(scheme_t), intent(in) :: self
            integer, intent(in) :: number
            real(wp), intent(in) :: dt
            type(state_t), intent(in) :: committed, previous
            type(state_t), intent(inout) :: reached
        end subroutine finish_stage_i

        !> The stage ends at `fraction` of the step, and its external force is weight f(end) + (1-weight)
        !> f(start of step).
        pure subroutine load_mix_i(self, number, fraction, weight)
            import :: scheme_t, wp
            class(scheme_t), intent(in) :: self
            integer, intent(in) :: number
            real(wp), intent(out) :: fraction, weight
        end subroutine load_mix_i
    end interface

end module gb_scheme
