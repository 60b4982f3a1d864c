!> The register of time integration schemes: a new one is a file of its own and one case here.
module gb_schemes
    use gb_problem, only: task_t
    use gb_scheme, only: scheme_t
    use gb_generalized_alpha, only: newmark, hilber_hughes_taylor, chung_hulbert
    use gb_bathe, only: bathe
    use gb_energy_momentum, only: energy_momentum
    use gb_central, only: central
    implicit none
    private

    public :: make_scheme

contains

    !> The scheme that a TRANSIENT command asks for.
    subroutine make_scheme(task, scheme)
        type(task_t), intent(in) :: task
        class(scheme_t), allocatable, intent(out) :: scheme

        select case (task%scheme)
        case ('newmark')
            allocate (scheme, source=newmark(task%beta, task%gamma))
        case ('hht')
            allocate (scheme, source=hilber_hughes_taylor(task%alpha))
        case ('generalized')
            allocate (scheme, source=chung_hulbert(task%rho))
        case ('bathe')
            allocate (scheme, source=bathe(task%rho))
        case ('energy')
            allocate (scheme, source=energy_momentum())
        case ('central')
            allocate (scheme, source=central())
        end select
    end subroutine make_scheme

end module gb_schemes
