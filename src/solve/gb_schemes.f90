!> The register of time integration schemes: a new one is a file of its own and one case here.
module gb_schemes
    use gb_problem, only: task_t
    use gb_scheme, only: scheme_t
    use gb_newmark, only: newmark_t
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
            allocate (scheme, source=newmark_t(beta=task%beta, gamma=task%gamma))
        end select
    end subroutine make_scheme

end module gb_schemes
