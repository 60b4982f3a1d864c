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
    use gb_element_columns, only: n_element, n_condensed, n_kept, at_slope, at_bubble, at_mass_moment, &
        n_mass_moments, at_ll, at_rr, at_lr, n_full, on_pp, on_pe, on_ps, on_ll, on_rr, on_lr
    use gb_blocks_lanes, only: n_triangle
    implicit none
    private

    !> What the inertia of a stage asks of the elements, besides accelerations.
    type, public :: inertia_t
        real(wp) :: mass_factor = 0.0_wp            !! as the stage's; 0 in statics [1/T^2]
        real(wp) :: damping_factor = 0.0_wp         !! as the stage's [1/T]
        real(wp) :: drag = 0.0_wp                   !! damping by the mass at rest over that mass [1/T]
        logical :: is_full = .false.                !! whether some element has inertia=full
    end type inertia_t

    integer, parameter :: n_points = 3
    real(wp), parameter :: place(n_points) = [-0.774596669241483377_wp, 0.0_wp, 0.774596669241483377_wp]
    real(wp), parameter :: weight(n_points) = [5.0_wp, 8.0_wp, 5.0_wp]/9.0_wp
    !> N_I at the points: left, middle and right node, one after the other.
    real(wp), parameter :: shape(3, n_points) = reshape([ &
        0.5_wp*place(1)*(place(1) - 1.0_wp), 1.0_wp - place(1)**2, 0.5_wp*place(1)*(place(1) + 1.0_wp), &
        0.5_wp*place(2)*(place(2) - 1.0_wp), 1.0_wp - place(2)**2, 0.5_wp*place(2)*(place(2) + 1.0_wp), &
        0.5_wp*place(3)*(place(3) - 1.0_wp), 1.0_wp - place(3)**2, 0.5_wp*place(3)*(place(3) + 1.0_wp)], &
        [3, n_points])

    public :: full_inertia, eliminate_full, add_to_ends, full_kinetic_energy

contains

    !> The inertia force in p (index 0), E (1) and S (2), and what it adds to the tangent: a field is S +
    !> alpha p + gamma E with alpha = -bubble (1-s^2) and gamma = bubble (1-s^2)/2 + s length/4 on the parent
    !> interval, or 1/2 - gamma slope times its left end, 1/2 + gamma slope times its right one and alpha p.
    pure subroutine full_inertia(con, inertia, u, v, a, force, full)
        real(wp), intent(in) :: con(lanes, n_element)
        type(inertia_t), intent(in) :: inertia
        real(wp), intent(in), dimension(lanes, n_fields, 3) :: u, v
        real(wp), intent(in) :: a(lanes, n_fields, 3)       !! accelerations plus drag times velocities
        real(wp), intent(out) :: force(lanes, n_fields, 0:2)
        real(wp), intent(out) :: full(lanes, n_triangle, n_full)
        real(wp) :: f(lanes, n_fields, n_points), m(lanes, n_triangle, n_points)
        real(wp) :: to_force(lanes, n_points, 0:1), to_tangent(lanes, n_points, n_full)
        real(wp), dimension(lanes) :: alpha, gamma, left, right
        integer :: q, i, n

        do q = 1, n_points
            alpha = -shape(2, q)*con(:, at_bubble)
            gamma = (0.5_wp*place(q))/con(:, at_slope) - 0.5_wp*alpha
            left = 0.5_wp - gamma*con(:, at_slope)
            right = 0.5_wp + gamma*con(:, at_slope)
            to_force(:, q, 0) = alpha
            to_force(:, q, 1) = gamma
            to_tangent(:, q, on_pp) = alpha*alpha
            to_tangent(:, q, on_pe) = alpha*gamma
            to_tangent(:, q, on_ps) = alpha
            to_tangent(:, q, on_ll) = left*left
            to_tangent(:, q, on_rr) = right*right
            to_tangent(:, q, on_lr) = left*right
            call point_inertia(weight(q)*con(:, at_mass_moment + 1:at_mass_moment + n_mass_moments), &
                inertia, at_point(q, u), at_point(q, v), at_point(q, a), f(:, :, q), m(:, :, q))
        end do
        do i = 1, n_fields
            do n = 0, 1
                force(:, i, n) = to_force(:, 1, n)*f(:, i, 1) + to_force(:, 2, n)*f(:, i, 2) &
                    + to_force(:, 3, n)*f(:, i, 3)
            end do
            force(:, i, 2) = f(:, i, 1) + f(:, i, 2) + f(:, i, 3)
        end do
        do n = 1, n_full
            do i = 1, n_triangle
                full(:, i, n) = to_tangent(:, 1, n)*m(:, i, 1) + to_tangent(:, 2, n)*m(:, i, 2) &
                    + to_tangent(:, 3, n)*m(:, i, 3)
            end do
        end do
    end subroutine full_inertia

    !> Forward elimination of what full inertia adds to the columns of E and S, into c and `kept` as
    !> gb_middle_lanes' eliminate_middle leaves them. It comes after that, as one branch: added to each column
    !> there, it would cost elements without full inertia 4 %.
    pure subroutine eliminate_full(full, inverse, c, kept)
        real(wp), intent(in) :: full(lanes, n_triangle, n_full), inverse(lanes, n_fields)
        real(wp), intent(inout) :: c(lanes, n_fields, 2*n_fields + 1)
        real(wp), intent(inout) :: kept(lanes, n_kept)
        integer, parameter :: on(2) = [on_pe, on_ps]
        real(wp) :: y(lanes, n_fields)
        integer :: n, i, j, k, column

        do n = 1, 2
            do j = 1, n_fields
                column = n_fields*(n - 1) + j
                !GCC$ unroll 5
                do i = 1, n_fields
                    y(:, i) = full(:, max(i, j)*(max(i, j) - 1)/2 + min(i, j), on(n))
                    !GCC$ unroll 4
                    do k = 1, i - 1
                        y(:, i) = y(:, i) - kept(:, (i - 1)*(i - 2)/2 + k)*y(:, k)
                    end do
                    c(:, i, column) = c(:, i, column) + y(:, i)
                    kept(:, 5*column + 5 + i) = kept(:, 5*column + 5 + i) + inverse(:, i)*y(:, i)
                end do
            end do
        end do
    end subroutine eliminate_full

    !> part <- part + what full inertia adds at the end nodes, which the elimination of the middle one leaves
    !> as it is.
    pure subroutine add_to_ends(full, part)
        real(wp), intent(in) :: full(lanes, n_triangle, n_full)
        real(wp), intent(inout) :: part(lanes, n_condensed)
        integer :: n, i, j

        !GCC$ unroll 5
        do j = 1, n_fields
            !GCC$ unroll 5
            do i = 1, j
                n = j*(j - 1)/2 + i
                part(:, at_ll + n) = part(:, at_ll + n) + full(:, n, on_ll)
                part(:, at_rr + n) = part(:, at_rr + n) + full(:, n, on_rr)
                part(:, at_lr + 5*(j - 1) + i) = part(:, at_lr + 5*(j - 1) + i) + full(:, n, on_lr)
                if (i < j) part(:, at_lr + 5*(i - 1) + j) = part(:, at_lr + 5*(i - 1) + j) + full(:, n, on_lr)
            end do
        end do
    end subroutine add_to_ends

    !> A field at a point of the element, from those at its nodes.
    pure function at_point(q, nodal) result(field)
        integer, intent(in) :: q
        real(wp), intent(in) :: nodal(lanes, n_fields, 3)
        real(wp) :: field(lanes, n_fields)

        field = shape(1, q)*nodal(:, :, 1) + shape(2, q)*nodal(:, :, 2) + shape(3, q)*nodal(:, :, 3)
    end function at_point

    !> gb_inertia's point_inertia, and the symmetric half of its tangent (upper triangle by columns). The
    !> damping is that by the mass of the beam at rest, where w = (0, 1) and xi = 0.
    pure subroutine point_inertia(m, inertia, u, v, with_drag, f, k)
        real(wp), intent(in) :: m(lanes, n_mass_moments)
        type(inertia_t), intent(in) :: inertia
        real(wp), intent(in), dimension(lanes, n_fields) :: u, v, with_drag
        real(wp), intent(out) :: f(lanes, n_fields), k(lanes, n_triangle)
        real(wp), dimension(lanes, n_fields) :: a, d        !! accelerations, and drag times velocities
        real(wp) :: w1, w3, xi, b1, b3, carried1, carried3, s, t1, t3, to_a, to_v, to_d, pull, spin
        integer :: l

        to_a = inertia%mass_factor
        to_v = inertia%damping_factor
        to_d = inertia%drag*to_v
        d = inertia%drag*v
        a = with_drag - d
        do l = 1, lanes
            w1 = u(l, 3)
            w3 = 1.0_wp + u(l, 4)
            xi = u(l, 5)
            b1 = xi*a(l, 3) + a(l, 5)*w1 + 2.0_wp*v(l, 5)*v(l, 3)
            b3 = xi*a(l, 4) + a(l, 5)*w3 + 2.0_wp*v(l, 5)*v(l, 4)
            carried1 = m(l, 2)*a(l, 1) + m(l, 3)*b1
            carried3 = m(l, 2)*a(l, 2) + m(l, 3)*b3
            f(l, 1) = m(l, 1)*with_drag(l, 1) + m(l, 2)*b1
            f(l, 2) = m(l, 1)*with_drag(l, 2) + m(l, 2)*(b3 + d(l, 5))
            f(l, 3) = m(l, 2)*with_drag(l, 3) + xi*carried1
            f(l, 4) = m(l, 2)*with_drag(l, 4) + xi*carried3
            f(l, 5) = w1*carried1 + w3*carried3 + m(l, 2)*d(l, 2) + m(l, 3)*d(l, 5)

            ! What velocities and accelerations add to dB/dy and dB/dxi, halved where it stands on one side.
            s = 2.0_wp*to_v*v(l, 5) + a(l, 5)
            t1 = 2.0_wp*to_v*v(l, 3) + a(l, 3)
            t3 = 2.0_wp*to_v*v(l, 4) + a(l, 4)
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
            k(l, 13) = carried1 + m(l, 3)*(to_a*xi*w1 + 0.5_wp*(xi*t1 + w1*s))
            k(l, 14) = carried3 + m(l, 3)*(to_a*xi*w3 + 0.5_wp*(xi*t3 + w3*s))
            k(l, 15) = m(l, 3)*(w1*(to_a*w1 + t1) + w3*(to_a*w3 + t3) + to_d)
        end do
    end subroutine point_inertia

    !> energy <- energy + the kinetic energy of every lane's element [F L].
    pure subroutine full_kinetic_energy(con, u, v, energy)
        real(wp), intent(in) :: con(lanes, n_element)
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
                energy(l) = energy(l) + 0.5_wp*weight(q) &
                    *(con(l, at_mass_moment + 1)*(vp(l, 1)**2 + vp(l, 2)**2) + con(l, at_mass_moment + 2) &
                    *(vp(l, 3)**2 + vp(l, 4)**2 + 2.0_wp*(vp(l, 1)*c1 + vp(l, 2)*c3)) &
                    + con(l, at_mass_moment + 3)*(c1**2 + c3**2))
            end do
        end do
    end subroutine full_kinetic_energy

end module gb_inertia_lanes
