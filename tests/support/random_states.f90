!> Random admissible states for the tests, from a generator of our own: the same numbers on every machine.
module random_states
    use gb_kinds, only: wp, i8
    use gb_quadrature, only: gauss_legendre
    use complex_reference, only: specimen_t, deformation_gradient, invariants
    implicit none
    private

    type, public :: random_t
        integer(i8) :: seed = 20260101_i8
    contains
        procedure :: uniform
        procedure :: signed
    end type random_t

    public :: random_specimen, random_strains, is_inside

contains

    !> A number in ]0, 1[ (Lehmer's generator).
    real(wp) function uniform(self)
        class(random_t), intent(inout) :: self

        self%seed = modulo(self%seed*48271_i8, 2147483647_i8)
        uniform = real(self%seed, wp)/2147483647.0_wp
    end function uniform

    !> A number in ]-size, size[.
    real(wp) function signed(self, size)
        class(random_t), intent(inout) :: self
        real(wp), intent(in) :: size

        signed = size*(2.0_wp*self%uniform() - 1.0_wp)
    end function signed

    !> Constants of all orders: Jm from 0.05 to 1e20, beta from -2 to 9 without 0, thin and thick sections.
    function random_specimen(random, points) result(s)
        class(random_t), intent(inout) :: random
        integer, intent(in) :: points
        type(specimen_t) :: s
        real(wp), parameter :: jms(6) = [0.05_wp, 0.5_wp, 2.0_wp, 10.0_wp, 1.0e4_wp, 1.0e20_wp]
        real(wp), parameter :: betas(6) = [-2.0_wp, -1.0_wp, 0.5_wp, 2.0_wp, 5.0_wp, 9.0_wp]

        s%mu = 10.0_wp**random%signed(3.0_wp)
        s%c = s%mu*(0.1_wp + 3.0_wp*random%uniform())
        s%beta = betas(1 + int(6.0_wp*random%uniform()))
        s%jm = jms(1 + int(6.0_wp*random%uniform()))
        s%b = 0.5_wp + random%uniform()
        s%h = 10.0_wp**random%signed(1.0_wp)
        allocate (s%z(points), s%wz(points))
        call gauss_legendre(s%z, s%wz)
        s%z = 0.5_wp*s%h*s%z
        s%wz = 0.5_wp*s%b*s%h*s%wz
    end function random_specimen

    !> Generalised strains of size 0.5 turned by a random angle, shrunk until they are well inside the
    !> admissible set.
    function random_strains(random, s) result(g)
        class(random_t), intent(inout) :: random
        type(specimen_t), intent(in) :: s
        real(wp) :: g(8)
        real(wp) :: strain(8), angle
        integer :: k

        do k = 1, 8
            strain(k) = random%signed(0.5_wp)
        end do
        strain([3, 4, 8]) = strain([3, 4, 8])/s%h
        strain(5) = strain(5)/s%h**2
        angle = random%signed(3.0_wp)
        do
            g = turned(strain, angle)
            if (is_inside(s, g)) exit
            strain = 0.7_wp*strain
        end do
    end function random_strains

    !> x' and w turned by an angle: the same strains, far from the reference state.
    function turned(strain, angle) result(g)
        real(wp), intent(in) :: strain(8), angle
        real(wp) :: g(8)
        real(wp) :: q(2, 2)

        q = reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [2, 2])
        g = strain
        g(1:2) = matmul(q, [1.0_wp + strain(1), strain(2)]) - [1.0_wp, 0.0_wp]
        g(3:4) = matmul(q, strain(3:4))
        g(6:7) = matmul(q, [strain(6), 1.0_wp + strain(7)]) - [0.0_wp, 1.0_wp]
    end function turned

    !> Whether 0.2 < J and I1-2 < 0.95 jm at every height and at the mid-line.
    logical function is_inside(s, g)
        type(specimen_t), intent(in) :: s
        real(wp), intent(in) :: g(8)
        complex(wp) :: t, j
        integer :: i

        is_inside = .true.
        do i = 0, size(s%z)
            call invariants(deformation_gradient(cmplx(g, 0.0_wp, wp), merge(0.0_wp, s%z(max(1, i)), &
                i == 0)), t, j)
            is_inside = is_inside .and. real(j) > 0.2_wp .and. real(t) < 0.95_wp*s%jm
        end do
    end function is_inside

end module random_states
