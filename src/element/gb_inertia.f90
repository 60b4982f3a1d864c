!> Inertia `full`: the kinetic energy of the whole kinematics, x_dot = u_dot + zeta y_dot + X3^2 xi_dot w with
!> zeta = X3 + xi X3^2 and w = (y1, 1+y3), eq. (28-32) corrected. Mass depends on the configuration. The
!> inertia force is the integral of rho dx . x_ddot; with m = rho (A, I, I4) and B = xi y_ddot + xi_ddot w + 2
!> xi_dot y_dot:
!>     on u:  m0 u_ddot + m2 B
!>     on y:  xi m2 u_ddot + m2 y_ddot + xi m4 B
!>     on xi: w . (m2 u_ddot + m4 B)
module gb_inertia
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_shape, only: max_nodes, max_points
    implicit none
    private

    public :: element_inertia, element_kinetic_energy

contains

    !> Inertia force f of an element, and k = factors(1) df/du + factors(2) df/dv + factors(3) df/da.
    pure subroutine element_inertia(nodes, points, n, weights, m, u, v, a, factors, f, k)
        integer, intent(in) :: nodes, points
        real(wp), intent(in) :: n(max_nodes, max_points)        !! N_I at the points
        real(wp), intent(in) :: weights(max_points)             !! [L]
        real(wp), intent(in) :: m(3)                            !! rho A, rho I, rho I4
        real(wp), intent(in) :: u(n_fields, nodes), v(n_fields, nodes), a(n_fields, nodes)
        real(wp), intent(in) :: factors(3)
        real(wp), intent(out) :: f(n_fields, nodes)
        real(wp), intent(out) :: k(n_fields, nodes, n_fields, nodes)
        real(wp) :: fp(n_fields), kp(n_fields, n_fields), shape_i
        integer :: q, i, j

        f = 0.0_wp
        k = 0.0_wp
        do q = 1, points
            call point_inertia(m, matmul(u, n(:nodes, q)), matmul(v, n(:nodes, q)), matmul(a, n(:nodes, &
                q)), factors, fp, kp)
            do i = 1, nodes
                shape_i = weights(q)*n(i, q)
                f(:, i) = f(:, i) + shape_i*fp
                do j = 1, nodes
                    k(:, i, :, j) = k(:, i, :, j) + (shape_i*n(j, q))*kp
                end do
            end do
        end do
    end subroutine element_inertia

    !> The same at one point of the mid-line, a unit length.
    pure subroutine point_inertia(m, u, v, a, factors, f, k)
        real(wp), intent(in) :: m(3), u(n_fields), v(n_fields), a(n_fields), factors(3)
        real(wp), intent(out) :: f(n_fields), k(n_fields, n_fields)
        real(wp) :: w(2), b(2), db(2, n_fields), carried(2), xi
        integer :: i

        w = [u(3), 1.0_wp + u(4)]
        xi = u(5)
        b = xi*a(3:4) + a(5)*w + 2.0_wp*v(5)*v(3:4)
        carried = m(2)*a(1:2) + m(3)*b
        f(1:2) = m(1)*a(1:2) + m(2)*b
        f(3:4) = m(2)*a(3:4) + xi*carried
        f(5) = dot_product(w, carried)

        db = 0.0_wp
        do i = 1, 2
            db(i, 2 + i) = factors(3)*xi + 2.0_wp*factors(2)*v(5) + factors(1)*a(5)
        end do
        db(:, 5) = factors(3)*w + 2.0_wp*factors(2)*v(3:4) + factors(1)*a(3:4)
        k(1:2, :) = m(2)*db
        k(3:4, :) = xi*m(3)*db
        k(5, :) = m(3)*matmul(w, db)
        do i = 1, 2
            k(i, i) = k(i, i) + factors(3)*m(1)
            k(2 + i, i) = k(2 + i, i) + factors(3)*xi*m(2)
            k(2 + i, 2 + i) = k(2 + i, 2 + i) + factors(3)*m(2)
            k(2 + i, 5) = k(2 + i, 5) + factors(1)*carried(i)
            k(5, i) = k(5, i) + factors(3)*m(2)*w(i)
            k(5, 2 + i) = k(5, 2 + i) + factors(1)*carried(i)
        end do
    end subroutine point_inertia

    !> Kinetic energy of an element [F L].
    pure function element_kinetic_energy(nodes, points, n, weights, m, u, v) result(energy)
        integer, intent(in) :: nodes, points
        real(wp), intent(in) :: n(max_nodes, max_points), weights(max_points), m(3)
        real(wp), intent(in) :: u(n_fields, nodes), v(n_fields, nodes)
        real(wp) :: energy
        real(wp) :: up(n_fields), vp(n_fields), c(2)
        integer :: q

        energy = 0.0_wp
        do q = 1, points
            up = matmul(u, n(:nodes, q))
            vp = matmul(v, n(:nodes, q))
            ! x_dot = u_dot + X3 y_dot + X3^2 c with c = xi y_dot + xi_dot w.
            c = up(5)*vp(3:4) + vp(5)*[up(3), 1.0_wp + up(4)]
            energy = energy + 0.5_wp*weights(q)*(m(1)*sum(vp(1:2)**2) + m(2)*(sum(vp(3:4)**2) &
                                                 + 2.0_wp*dot_product(vp(1:2), c)) + m(3)*sum(c**2))
        end do
    end function element_kinetic_energy

end module gb_inertia
