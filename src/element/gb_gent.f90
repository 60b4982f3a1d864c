!> The compressible Gent material, eq. (15) corrected, split into a part of I1 and a part of J:
!>     W = phi(I1) + psi(J),  phi = -(mu jm/2) ln(1 - (I1-2)/jm),
!>     psi = -mu ln J + (c/beta^2) (beta ln J + J^-beta - 1).
!> Constants travel as p = (mu, c, beta, 1/jm); 1/jm = 0 is the compressible neo-Hookean material.
!> States with J <= 0 or I1-2 >= jm are inadmissible; nothing here may be called for them.
module gb_gent
    use gb_kinds, only: wp, log1p
    implicit none
    private

    integer, parameter, public :: n_constants = 4

    public :: is_admissible, gent_energy, gent_slopes, gent_curvatures, power_of_j

contains

    !> Whether the logarithms of the energy exist: J > 0 and I1-2 < jm.
    pure elemental logical function is_admissible(i1_minus_2, j, inverse_jm)
        real(wp), intent(in) :: i1_minus_2, j, inverse_jm

        is_admissible = j > 0.0_wp .and. i1_minus_2*inverse_jm < 1.0_wp
    end function is_admissible

    !> W(I1, J) [F/L^2], eq. (15) corrected. Written with log1p so that neither jm = 1e20 nor a small strain
    !> cancels.
    pure real(wp) function gent_energy(p, i1_minus_2, j) result(w)
        real(wp), intent(in) :: p(n_constants)      !! mu, c [F/L^2], beta, 1/jm
        real(wp), intent(in) :: i1_minus_2, j       !! I1-2, J [-]
        real(wp) :: t, log_j

        t = i1_minus_2*p(4)
        log_j = log1p(j - 1.0_wp)
        if (abs(t) > 1.0e-8_wp) then
            w = -0.5_wp*p(1)*i1_minus_2*log1p(-t)/t
        else
            w = 0.5_wp*p(1)*i1_minus_2*(1.0_wp + 0.5_wp*t)
        end if
        w = w - p(1)*log_j + p(2)/p(3)**2*(p(3)*log_j + (power_of_j(j, p(3)) - 1.0_wp))
    end function gent_energy

    !> dphi/dI1 = a/2 with a = mu/(1 - (I1-2)/jm), and dpsi/dJ = b/J with b = -mu + (c/beta)(1 - J^-beta), eq.
    !> (16) corrected [F/L^2].
    pure subroutine gent_slopes(p, i1_minus_2, j, phi_1, psi_1)
        real(wp), intent(in) :: p(n_constants), i1_minus_2, j
        real(wp), intent(out) :: phi_1, psi_1

        phi_1 = 0.5_wp*p(1)/(1.0_wp - i1_minus_2*p(4))
        psi_1 = (-p(1) + p(2)/p(3)*(1.0_wp - power_of_j(j, p(3))))/j
    end subroutine gent_slopes

    !> Slopes as gent_slopes, and the curvatures phi'' = a/(2 (jm - I1 + 2)), psi'' = (c J^-beta - b)/J^2
    !> [F/L^2].
    pure subroutine gent_curvatures(p, i1_minus_2, j, phi_1, psi_1, phi_2, psi_2)
        real(wp), intent(in) :: p(n_constants), i1_minus_2, j
        real(wp), intent(out) :: phi_1, psi_1, phi_2, psi_2
        real(wp) :: room, power, b, inverse_j

        room = 1.0_wp/(1.0_wp - i1_minus_2*p(4))
        phi_1 = 0.5_wp*p(1)*room
        phi_2 = phi_1*p(4)*room
        power = power_of_j(j, p(3))
        inverse_j = 1.0_wp/j
        b = -p(1) + p(2)/p(3)*(1.0_wp - power)
        psi_1 = b*inverse_j
        psi_2 = (p(2)*power - b)*inverse_j**2
    end subroutine gent_curvatures

    !> J^-beta; a product where beta = -2, the usual case.
    pure real(wp) function power_of_j(j, beta)
        real(wp), intent(in) :: j, beta

        if (abs(beta + 2.0_wp) <= 0.0_wp) then
            power_of_j = j*j
        else
            power_of_j = j**(-beta)
        end if
    end function power_of_j

end module gb_gent
