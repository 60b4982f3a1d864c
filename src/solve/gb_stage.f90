!> One implicit equation of a solution method, in the displacements U at its end:
!>
!>     R(U) = mass_factor M (U - u_mass) + damping_factor C (U - u_damping) + f_int(u_e) - f_ext = 0,
!>     u_e = u_start + force_factor (U - u_start).
!>
!> where an averaging stage takes for f_int the average over the path from u_start to U (gb_section_average).
!> Statics is mass_factor = damping_factor = 0 and force_factor = 1. Newton's method sees nothing else of a
!> scheme.
module gb_stage
    use gb_kinds, only: wp
    implicit none
    private

    type, public :: stage_t
        real(wp) :: mass_factor = 0.0_wp            !! [1/T^2]
        real(wp) :: damping_factor = 0.0_wp         !! [1/T]
        real(wp) :: force_factor = 1.0_wp           !! [-]
        logical :: averages_force = .false.
        logical :: needs_velocity = .true.          !! whether something depends on it: u_damping is kept
        real(wp), allocatable :: u_mass(:)          !! (n)
        real(wp), allocatable :: u_damping(:)       !! (n)
        real(wp), allocatable :: u_start(:)         !! (n), where force_factor < 1 or the force is averaged
        real(wp), allocatable :: f_external(:)      !! (n)
    contains
        procedure :: evaluation_point
    end type stage_t

contains

    !> The displacements at which the internal force is evaluated.
    pure subroutine evaluation_point(self, u, u_e)
        class(stage_t), intent(in) :: self
        real(wp), intent(in) :: u(:)
        real(wp), intent(out) :: u_e(:)

        if (self%force_factor < 1.0_wp) then
            u_e = self%u_start + self%force_factor*(u - self%u_start)
        else
            u_e = u
        end if
    end subroutine evaluation_point

end module gb_stage
