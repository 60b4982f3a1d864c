!> Inertia `full` (gb_inertia) of three-node elements in lanes: force and tangent in the variables of
!> gb_element_lanes, and kinetic energy. Three Gauss points along the element, as the plain path has them.
!>
!> The tangent is df/du of the mass and of the accelerations' terms, symmetric as it is, and the symmetric
!> half of what velocities and accelerations add to the coupling of u, y and xi. The half that is left out is,
!> over the mass, of the size of what xi and y change in a step: Newton's method converges linearly with
!> about that factor, to the same solution.
module gb_inertia_lanes
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_fields, only: n_fields
    use gb_blocks_lanes, only: n_triangle
    implicit none
    private

    integer, parameter, public :: n_moments = 3
    integer, parameter :: n_points = 3
    real(wp), parameter :: place(n_points) = [-0.774596669241483377_wp, 0.0_wp, 0.774596669241483377_wp]
    real(wp), parameter :: weight(n_points) = [5.0_wp, 8.0_wp, 5.0_wp]/9.0_wp
    !> N_I at the points: left, middle and right node, one after the other.
    real(wp), parameter :: shape(3, n_points) = reshape([ &
        0.5_wp*place(1)*(place(1) - 1.0_wp), 1.0_wp - place(1)**2, 0.5_wp*place(1)*(place(1) + 1.0_wp), &
        0.5_wp*place(2)*(place(2) - 1.0_wp), 1.0_wp - place(2)**2, 0.5_wp*place(2)*(place(2) + 1.0_wp), &
        0.5_wp*place(3)*(place(3) - 1.0_wp), 1.0_wp - place(3)**2, 0.5_wp*place(3)*(place(3) + 1.0_wp)], &
        [3, n_points])

    public :: add_full_inertia, full_kinetic_energy

contains

    !> Add the inertia force to the residual, and its tangent, in (p, E, S): a field is S + alpha p + gamma E
    !> with alpha = -bubble (1-s^2) and gamma = bubble (1-s^2)/2 + s length/4 on the parent interval.
    pure subroutine add_full_inertia(moments, bubble, quarter, factors, drag, u, v, a, k, c, ee, es, ss, r)
        real(wp), intent(in) :: moments(lanes, n_moments)   !! rho (A, I, I4) length/2
        real(wp), intent(in) :: bubble(lanes)               !! as gb_element_lanes' [L]
        real(wp), intent(in) :: quarter(lanes)              !! length/4 [L]
        real(wp), intent(in) :: factors(3)                  !! of d/du, d/dv, d/da in the tangent
        real(wp), intent(in) :: drag                        !! damping by the mass at rest [1/T]
        real(wp), intent(in), dimension(lanes, n_fields, 3) :: u, v
        real(wp), intent(in) :: a(lanes, n_fields, 3)       !! accelerations plus drag times velocities
        real(wp), intent(inout) :: k(lanes, n_triangle), c(lanes, n_fields, 2*n_fields + 1)
        real(wp), intent(inout), dimension(lanes, n_fields, n_fields) :: ee, es, ss
        real(wp), intent(inout) :: r(lanes, n_fields, 2)
        real(wp) :: f(lanes, n_fields), m(lanes, n_triangle), alpha(lanes), gamma(lanes)
        real(wp) :: one, a_m, g_m
        integer :: q, i, j, l

        do q = 1, n_points
            alpha = -shape(2, q)*bubble
            gamma = place(q)*quarter - 0.5_wp*alpha
            call point_inertia(weight(q)*moments, factors, drag, at_point(q, u), at_point(q, v), &
                at_point(q, a), f, m)
            !GCC$ unroll 5
            do i = 1, n_fields
                c(:, i, 11) = c(:, i, 11) + alpha*f(:, i)
                r(:, i, 1) = r(:, i, 1) + gamma*f(:, i)
                r(:, i, 2) = r(:, i, 2) + f(:, i)
            end do
            !GCC$ unroll 5
            do j = 1, n_fields
                !GCC$ unroll 5
                do i = 1, j
                    do l = 1, lanes
                        one = m(l, j*(j - 1)/2 + i)
                        a_m = alpha(l)*one
                        g_m = gamma(l)*one
                        k(l, j*(j - 1)/2 + i) = k(l, j*(j - 1)/2 + i) + alpha(l)*a_m
                        c(l, i, j) = c(l, i, j) + alpha(l)*g_m
                        c(l, i, n_fields + j) = c(l, i, n_fields + j) + a_m
                        ee(l, i, j) = ee(l, i, j) + gamma(l)*g_m
                        es(l, i, j) = es(l, i, j) + g_m
                        ss(l, i, j) = ss(l, i, j) + one
                        if (i == j) cycle
                        c(l, j, i) = c(l, j, i) + alpha(l)*g_m
                        c(l, j, n_fields + i) = c(l, j, n_fields + i) + a_m
                        es(l, j, i) = es(l, j, i) + g_m
                    end do
                end do
            end do
        end do
    end subroutine add_full_inertia

    !> A field at a point of the element, from those at its nodes.
    pure function at_point(q, nodal) result(field)
        integer, intent(in) :: q
        real(wp), intent(in) :: nodal(lanes, n_fields, 3)
        real(wp) :: field(lanes, n_fields)

        field = shape(1, q)*nodal(:, :, 1) + shape(2, q)*nodal(:, :, 2) + shape(3, q)*nodal(:, :, 3)
    end function at_point

    !> gb_inertia's point_inertia, and the symmetric half of its tangent (upper triangle by columns). The
    !> damping is that by the mass of the beam at rest, where w = (0, 1) and xi = 0.
    pure subroutine point_inertia(m, factors, drag, u, v, with_drag, f, k)
        real(wp), intent(in) :: m(lanes, n_moments), factors(3), drag
        real(wp), intent(in), dimension(lanes, n_fields) :: u, v, with_drag
        real(wp), intent(out) :: f(lanes, n_fields), k(lanes, n_triangle)
        real(wp) :: a(n_fields), d(n_fields), w1, w3, xi, b1, b3, carried1, carried3, s, t1, t3, to_a, to_d, &
            pull, spin
        integer :: l

        to_a = factors(3)
        to_d = factors(2)*drag
        do l = 1, lanes
            d = drag*v(l, :)
            a = with_drag(l, :) - d
            w1 = u(l, 3)
            w3 = 1.0_wp + u(l, 4)
            xi = u(l, 5)
            b1 = xi*a(3) + a(5)*w1 + 2.0_wp*v(l, 5)*v(l, 3)
            b3 = xi*a(4) + a(5)*w3 + 2.0_wp*v(l, 5)*v(l, 4)
            carried1 = m(l, 2)*a(1) + m(l, 3)*b1
            carried3 = m(l, 2)*a(2) + m(l, 3)*b3
            f(l, 1) = m(l, 1)*with_drag(l, 1) + m(l, 2)*b1
            f(l, 2) = m(l, 1)*with_drag(l, 2) + m(l, 2)*(b3 + d(5))
            f(l, 3) = m(l, 2)*with_drag(l, 3) + xi*carried1
            f(l, 4) = m(l, 2)*with_drag(l, 4) + xi*carried3
            f(l, 5) = w1*carried1 + w3*carried3 + m(l, 2)*d(2) + m(l, 3)*d(5)

            ! What velocities and accelerations add to dB/dy and dB/dxi, halved where it stands on one side.
            s = 2.0_wp*factors(2)*v(l, 5) + factors(1)*a(5)
            t1 = 2.0_wp*factors(2)*v(l, 3) + factors(1)*a(3)
            t3 = 2.0_wp*factors(2)*v(l, 4) + factors(1)*a(4)
            pull = m(l, 2)*(to_a*xi + 0.5_wp*s)
            spin = m(l, 2)*(to_a + to_d) + m(l, 3)*xi*(to_a*xi + s)
            k(l, 1) = m(l, 1)*(to_a + to_d)
            k(l, 2) = 0.0_wp
            k(l, 3) = k(l, 1)
            k(l, 4) = pull
            k(l, 5) = 0.0_wp
            k(l, 6) = spin
            k(l, 7) = 0.0_wp
            k(l, 8) = pull
            k(l, 9) = 0.0_wp
            k(l, 10) = spin
            k(l, 11) = m(l, 2)*(to_a*w1 + 0.5_wp*t1)
            k(l, 12) = m(l, 2)*(to_a*w3 + to_d + 0.5_wp*t3)
            k(l, 13) = factors(1)*carried1 + m(l, 3)*(to_a*xi*w1 + 0.5_wp*(xi*t1 + w1*s))
            k(l, 14) = factors(1)*carried3 + m(l, 3)*(to_a*xi*w3 + 0.5_wp*(xi*t3 + w3*s))
            k(l, 15) = m(l, 3)*(w1*(to_a*w1 + t1) + w3*(to_a*w3 + t3) + to_d)
        end do
    end subroutine point_inertia

    !> energy <- energy + the kinetic energy of every lane's element [F L].
    pure subroutine full_kinetic_energy(moments, u, v, energy)
        real(wp), intent(in) :: moments(lanes, n_moments)   !! rho (A, I, I4) length/2
        real(wp), intent(in), dimension(lanes, n_fields, 3) :: u, v
        real(wp), intent(inout) :: energy(lanes)
        real(wp), dimension(lanes, n_fields) :: up, vp
        real(wp) :: c1, c3
        integer :: q, l

        do q = 1, n_points
            up = at_point(q, u)
            vp = at_point(q, v)
            do l = 1, lanes
                ! x_dot = u_dot + X3 y_dot + X3^2 c with c = xi y_dot + xi_dot w.
                c1 = up(l, 5)*vp(l, 3) + vp(l, 5)*up(l, 3)
                c3 = up(l, 5)*vp(l, 4) + vp(l, 5)*(1.0_wp + up(l, 4))
                energy(l) = energy(l) + 0.5_wp*weight(q)*(moments(l, 1)*(vp(l, 1)**2 + vp(l, 2)**2) &
                    + moments(l, 2)*(vp(l, 3)**2 + vp(l, 4)**2 + 2.0_wp*(vp(l, 1)*c1 + vp(l, 2)*c3)) &
                    + moments(l, 3)*(c1**2 + c3**2))
            end do
        end do
    end subroutine full_kinetic_energy

end module gb_inertia_lanes
