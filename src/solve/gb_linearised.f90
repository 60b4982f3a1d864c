!> What Newton's method asks of an equation R(u) = 0 (gb_stage) that has been linearised at a state: its
!> residual's size, and the increment that makes the linearised residual vanish.
module gb_linearised
    use gb_kinds, only: wp
    use gb_stage, only: stage_t
    use gb_system, only: system_t
    implicit none
    private

    type, abstract, public :: linearised_t
        logical :: is_exact = .true.    !! whether the tangent is the residual's derivative, all of it
        logical :: is_trusted = .true.  !! whether no increment of it can be small by a pivot's fault
    contains
        procedure :: take_stage
        procedure(evaluate_i), deferred :: evaluate
        procedure(solve_i), deferred :: solve
        procedure(relative_residual_i), deferred :: relative_residual
        procedure(residual_i), deferred :: residual
        procedure(mechanism_i), deferred :: mechanism
    end type linearised_t

    abstract interface
        !> Linearise at the state u, with the supports' rows and columns removed. Not admissible: nothing may
        !> be asked of it.
        subroutine evaluate_i(self, system, stage, u, admissible)
            import :: linearised_t, system_t, stage_t, wp
            class(linearised_t), intent(inout) :: self
            type(system_t), intent(in) :: system
            type(stage_t), intent(in) :: stage
            real(wp), intent(in), contiguous :: u(:)
            logical, intent(out) :: admissible
        end subroutine evaluate_i

        !> The increment -K^-1 R, once after `evaluate`. singular > 0: the unknown whose pivot vanishes;
        !> singular < 0: this kind of solver cannot tell, another one must try.
        subroutine solve_i(self, increment, singular)
            import :: linearised_t, wp
            class(linearised_t), intent(inout) :: self
            real(wp), intent(out), contiguous :: increment(:)
            integer, intent(out) :: singular
        end subroutine solve_i

        !> Norm of the residual over that of the forces that balance in it, field by field made comparable by
        !> the fields' sizes.
        real(wp) function relative_residual_i(self, system, stage)
            import :: linearised_t, system_t, stage_t, wp
            class(linearised_t), intent(in) :: self
            type(system_t), intent(in) :: system
            type(stage_t), intent(in) :: stage
        end function relative_residual_i

        !> The residual at the state u, where `evaluate` has just been, unknown by unknown.
        subroutine residual_i(self, system, stage, u, r)
            import :: linearised_t, system_t, stage_t, wp
            class(linearised_t), intent(inout) :: self
            type(system_t), intent(in) :: system
            type(stage_t), intent(in) :: stage
            real(wp), intent(in), contiguous :: u(:)
            real(wp), intent(out), contiguous :: r(:)
        end subroutine residual_i

        !> After `solve`: the unknown of a pivot that vanishes but for rounding, a mechanism's; 0 where there
        !> is none.
        integer function mechanism_i(self)
            import :: linearised_t
            class(linearised_t), intent(in) :: self
        end function mechanism_i
    end interface

contains

    !> Take what a stage holds constant, before the first `evaluate`; most linearisations need not.
    subroutine take_stage(self, stage)
        class(linearised_t), intent(inout) :: self
        type(stage_t), intent(in) :: stage
    end subroutine take_stage

end module gb_linearised
