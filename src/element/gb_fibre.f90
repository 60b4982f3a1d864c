!> Strain and stress at one height of a section, and the section's resultants: what is recovered from a
!> solution, as against what solving needs. Tensors are in the order 11, 33, 13.
!>
!> Rule gauss has the full deformation gradient of eq. (5); rule linear has F0 + X3 F1, and its stress is its
!> own, S0 + X3 S1.
module gb_fibre
    use gb_kinds, only: wp
    use gb_gent, only: is_admissible, gent_energy, gent_slopes
    use gb_section, only: rule_gauss
    use gb_section_gauss, only: n_strains, gauss_stress
    use gb_section_linear, only: linear_stress, linear_fibre
    use gb_beam, only: section_data_t
    implicit none
    private

    public :: fibre_strain, fibre_stress, fibre_energy, section_resultants

contains

    !> Displacement gradient F - 1 at the height z, as (11, 33, 13, 31).
    pure function gradient(section, g, z) result(d)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(in) :: z               !! X3 [L]
        real(wp) :: d(4)
        real(wp) :: zeta, k

        zeta = z
        k = 0.0_wp
        if (section%rule == rule_gauss) then
            zeta = z + g(8)*z**2
            k = z**2*g(5)
        end if
        d(1) = g(1) + zeta*g(3) + k*g(6)
        d(2) = g(7) + 2.0_wp*g(8)*z*(1.0_wp + g(7))
        d(3) = (1.0_wp + 2.0_wp*g(8)*z)*g(6)
        d(4) = g(2) + zeta*g(4) + k*(1.0_wp + g(7))
    end function gradient

    !> I1-2 and J of a displacement gradient, written so that small strains do not cancel.
    pure subroutine invariants(d, i1_minus_2, j)
        real(wp), intent(in) :: d(4)
        real(wp), intent(out) :: i1_minus_2, j

        i1_minus_2 = 2.0_wp*(d(1) + d(2)) + sum(d**2)
        j = 1.0_wp + (d(1) + d(2) + d(1)*d(2) - d(3)*d(4))
    end subroutine invariants

    !> Green-Lagrange strain E, I1-2 and J.
    pure subroutine fibre_strain(section, g, z, e, i1_minus_2, j)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: g(n_strains), z
        real(wp), intent(out) :: e(3), i1_minus_2, j
        real(wp) :: d(4)

        d = gradient(section, g, z)
        call invariants(d, i1_minus_2, j)
        e(1) = d(1) + 0.5_wp*(d(1)**2 + d(4)**2)
        e(2) = d(2) + 0.5_wp*(d(2)**2 + d(3)**2)
        e(3) = 0.5_wp*((1.0_wp + d(1))*d(3) + (1.0_wp + d(2))*d(4))
    end subroutine fibre_strain

    !> Second Piola-Kirchhoff stress S = a 1 + b C^-1 and Cauchy stress (a F F' + b 1)/J [F/L^2]. They do not
    !> exist beyond the material's limits.
    pure subroutine fibre_stress(section, g, z, s, cauchy, exists)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: g(n_strains), z
        real(wp), intent(out) :: s(3), cauchy(3)
        logical, intent(out) :: exists
        real(wp) :: d(4), f11, f33, i1_minus_2, j, phi_1, psi_1, a, b

        s = 0.0_wp
        cauchy = 0.0_wp
        d = gradient(section, g, z)
        call invariants(d, i1_minus_2, j)
        f11 = 1.0_wp + d(1)
        f33 = 1.0_wp + d(2)
        if (section%rule == rule_gauss) then
            exists = is_admissible(i1_minus_2, j, section%p(4))
            if (.not. exists) return
            call gent_slopes(section%p, i1_minus_2, j, phi_1, psi_1)
            a = 2.0_wp*phi_1
            b = psi_1*j
            s = a*[1.0_wp, 1.0_wp, 0.0_wp] + (b/j**2)*[d(3)**2 + f33**2, f11**2 + d(4)**2, &
                -(f11*d(3) + f33*d(4))]
        else
            call linear_fibre(section%p, g, z, s, exists)
            exists = exists .and. j > 0.0_wp
            if (.not. exists) return
        end if
        cauchy(1) = f11**2*s(1) + d(3)**2*s(2) + 2.0_wp*f11*d(3)*s(3)
        cauchy(2) = d(4)**2*s(1) + f33**2*s(2) + 2.0_wp*f33*d(4)*s(3)
        cauchy(3) = f11*d(4)*s(1) + f33*d(3)*s(2) + (f11*f33 + d(3)*d(4))*s(3)
        cauchy = cauchy/j
    end subroutine fibre_stress

    !> Strain energy density W [F/L^2], eq. (15) corrected.
    pure subroutine fibre_energy(section, i1_minus_2, j, energy, exists)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: i1_minus_2, j
        real(wp), intent(out) :: energy
        logical, intent(out) :: exists

        energy = 0.0_wp
        exists = is_admissible(i1_minus_2, j, section%p(4))
        if (exists) energy = gent_energy(section%p, i1_minus_2, j)
    end subroutine fibre_energy

    !> Resultants of a section, exact for both rules since the generalised stresses are conjugate to the
    !> generalised strains: R = dPhi/du' is the force across the section, dPhi/dy' the integral of zeta P1.
    !> With the director w = (y1, 1+y3) that spans the deformed section,
    !>     axial = R . n,  shear = R . w/|w|,  n = (w3, -w1)/|w|,  moment = integral of zeta P1 x w.
    !> A moment is positive where it stretches the side of positive X3.
    pure subroutine section_resultants(section, g, axial, shear, moment, admissible)
        type(section_data_t), intent(in) :: section
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: axial, shear       !! [F]
        real(wp), intent(out) :: moment             !! [F L]
        logical, intent(out) :: admissible
        real(wp) :: s(n_strains), w(2), length

        if (section%rule == rule_gauss) then
            call gauss_stress(section%nz, section%z, section%wz, section%p, g, s, admissible)
        else
            call linear_stress(section%area, section%inertia, section%p, g, s, admissible)
        end if
        w = [g(6), 1.0_wp + g(7)]
        length = norm2(w)
        axial = (s(1)*w(2) - s(2)*w(1))/length
        shear = (s(1)*w(1) + s(2)*w(2))/length
        moment = s(3)*w(2) - s(4)*w(1)
    end subroutine section_resultants

end module gb_fibre
