!> An independent statement of the element for the tests: the formulas of the theory with 2x2 matrices in
!> complex arithmetic, so that the imaginary part of f(x + ih)/h is a derivative without cancellation.
!> Generalised strains in the order of the program: (u1', u3', y1', y3', xi', y1, y3, xi).
module complex_reference
    use gb_kinds, only: wp
    implicit none
    private

    real(wp), parameter, public :: tiny_step = 1.0e-100_wp

    !> Material constants and section of a test.
    type, public :: specimen_t
        real(wp) :: mu = 1.0_wp, c = 1.0_wp, beta = -2.0_wp, jm = 1.0_wp
        real(wp) :: b = 1.0_wp, h = 1.0_wp
        real(wp), allocatable :: z(:), wz(:)
    end type specimen_t

    public :: section_energy, section_stress, linear_work, deformation_gradient, invariants

contains

    !> F(g, X3), eq. (5).
    pure function deformation_gradient(g, z) result(f)
        complex(wp), intent(in) :: g(8)
        real(wp), intent(in) :: z
        complex(wp) :: f(2, 2)
        complex(wp) :: zeta

        zeta = z + g(8)*z**2
        f(1, 1) = 1.0_wp + g(1) + zeta*g(3) + z**2*g(5)*g(6)
        f(2, 1) = g(2) + zeta*g(4) + z**2*g(5)*(1.0_wp + g(7))
        f(1, 2) = (1.0_wp + 2.0_wp*g(8)*z)*g(6)
        f(2, 2) = (1.0_wp + 2.0_wp*g(8)*z)*(1.0_wp + g(7))
    end function deformation_gradient

    !> I1-2 and J of a deformation gradient.
    pure subroutine invariants(f, i1_minus_2, j)
        complex(wp), intent(in) :: f(2, 2)
        complex(wp), intent(out) :: i1_minus_2, j

        i1_minus_2 = sum(f**2) - 2.0_wp
        j = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
    end subroutine invariants

    !> Phi(g) = integral of W over the section, W by eq. (15) corrected.
    pure function section_energy(s, g) result(energy)
        type(specimen_t), intent(in) :: s
        complex(wp), intent(in) :: g(8)
        complex(wp) :: energy
        complex(wp) :: t, j, gent
        integer :: i

        energy = 0.0_wp
        do i = 1, size(s%z)
            call invariants(deformation_gradient(g, s%z(i)), t, j)
            if (s%jm < 1.0e6_wp) then
                gent = -0.5_wp*s%mu*s%jm*log(1.0_wp - t/s%jm)
            else
                gent = 0.5_wp*s%mu*t*(1.0_wp + 0.5_wp*t/s%jm)
            end if
            energy = energy + s%wz(i)*(gent - s%mu*log(j) &
                                       + s%c/s%beta**2*(s%beta*log(j) + exp(-s%beta*log(j)) - 1.0_wp))
        end do
    end function section_energy

    !> dPhi/dg_k = integral of P : dF/dg_k, P = a F + b F^-T, eq. (16) corrected.
    pure function section_stress(s, g) result(stress)
        type(specimen_t), intent(in) :: s
        complex(wp), intent(in) :: g(8)
        complex(wp) :: stress(8)
        complex(wp) :: f(2, 2), p(2, 2), t, j, b, df(2, 2)
        integer :: i, k

        stress = 0.0_wp
        do i = 1, size(s%z)
            f = deformation_gradient(g, s%z(i))
            call invariants(f, t, j)
            b = -s%mu + s%c/s%beta*(1.0_wp - exp(-s%beta*log(j)))
            p = s%mu/(1.0_wp - t/s%jm)*f + b*transpose(inverse(f))
            do k = 1, 8
                df = gradient_of_f(g, s%z(i), k)
                stress(k) = stress(k) + s%wz(i)*sum(p*df)
            end do
        end do
    end function section_stress

    !> dF/dg_k at height z, written out from eq. (5).
    pure function gradient_of_f(g, z, k) result(df)
        complex(wp), intent(in) :: g(8)
        real(wp), intent(in) :: z
        integer, intent(in) :: k
        complex(wp) :: df(2, 2)
        complex(wp) :: zeta

        zeta = z + g(8)*z**2
        df = 0.0_wp
        select case (k)
        case (1)
            df(1, 1) = 1.0_wp
        case (2)
            df(2, 1) = 1.0_wp
        case (3)
            df(1, 1) = zeta
        case (4)
            df(2, 1) = zeta
        case (5)
            df(1, 1) = z**2*g(6)
            df(2, 1) = z**2*(1.0_wp + g(7))
        case (6)
            df(1, 1) = z**2*g(5)
            df(1, 2) = 1.0_wp + 2.0_wp*g(8)*z
        case (7)
            df(2, 1) = z**2*g(5)
            df(2, 2) = 1.0_wp + 2.0_wp*g(8)*z
        case (8)
            df(1, 1) = z**2*g(3)
            df(2, 1) = z**2*g(4)
            df(1, 2) = 2.0_wp*z*g(6)
            df(2, 2) = 2.0_wp*z*(1.0_wp + g(7))
        end select
    end function gradient_of_f

    pure function inverse(m) result(inv)
        complex(wp), intent(in) :: m(2, 2)
        complex(wp) :: inv(2, 2)

        inv(1, 1) = m(2, 2)
        inv(2, 2) = m(1, 1)
        inv(1, 2) = -m(1, 2)
        inv(2, 1) = -m(2, 1)
        inv = inv/(m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1))
    end function inverse

    !> Rule `linear`: A S0 : dE0/dg_k + I S1 : dE1/dg_k with S0, S1 of eq. (20, 21) corrected, in matrices.
    pure function linear_work(s, g) result(work)
        type(specimen_t), intent(in) :: s
        complex(wp), intent(in) :: g(8)
        complex(wp) :: work(8)
        complex(wp) :: f0(2, 2), f1(2, 2), df0(2, 2), df1(2, 2), c0(2, 2), c1(2, 2), ci(2, 2), s0(2, 2), &
            s1(2, 2)
        complex(wp) :: t, j0, j1, a, da, b, power
        complex(wp) :: identity(2, 2)
        integer :: k

        identity = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
        f0 = reshape([1.0_wp + g(1), g(2), g(6), 1.0_wp + g(7)], [2, 2])
        f1 = reshape([g(3), g(4), 2.0_wp*g(8)*g(6), 2.0_wp*g(8)*(1.0_wp + g(7))], [2, 2])
        c0 = matmul(transpose(f0), f0)
        c1 = matmul(transpose(f0), f1) + matmul(transpose(f1), f0)
        ci = inverse(c0)
        t = c0(1, 1) + c0(2, 2) - 2.0_wp
        j0 = f0(1, 1)*f0(2, 2) - f0(1, 2)*f0(2, 1)
        j1 = j0*trace(matmul(inverse(f0), f1))
        a = s%mu/(1.0_wp - t/s%jm)
        da = s%mu/s%jm/(1.0_wp - t/s%jm)**2
        power = exp(-s%beta*log(j0))
        b = -s%mu + s%c/s%beta*(1.0_wp - power)
        s0 = a*identity + b*ci
        s1 = da*trace(c1)*identity - b*matmul(ci, matmul(c1, ci)) + s%c*power/j0*j1*ci
        do k = 1, 8
            df0 = 0.0_wp
            df1 = 0.0_wp
            select case (k)
            case (1)
                df0(1, 1) = 1.0_wp
            case (2)
                df0(2, 1) = 1.0_wp
            case (3)
                df1(1, 1) = 1.0_wp
            case (4)
                df1(2, 1) = 1.0_wp
            case (6)
                df0(1, 2) = 1.0_wp
                df1(1, 2) = 2.0_wp*g(8)
            case (7)
                df0(2, 2) = 1.0_wp
                df1(2, 2) = 2.0_wp*g(8)
            case (8)
                df1(1, 2) = 2.0_wp*g(6)
                df1(2, 2) = 2.0_wp*(1.0_wp + g(7))
            end select
            work(k) = s%b*s%h*sum(s0*matmul(transpose(f0), df0)) + s%b*s%h**3/12.0_wp &
                      *sum(s1*(matmul(transpose(f0), df1) + matmul(transpose(f1), df0)))
        end do
    end function linear_work

    pure function trace(m) result(t)
        complex(wp), intent(in) :: m(2, 2)
        complex(wp) :: t

        t = m(1, 1) + m(2, 2)
    end function trace

end module complex_reference
