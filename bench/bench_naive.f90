!> The yardstick: example 1 by the textbook's way. Strain-displacement matrices at every point of length and
!> thickness, products by matmul, a general band matrix and LAPACK's dgbtrf: bench_naive ELEMENTS STEPS
!> REPEATS.
program bench_naive
    use gb_kinds, only: wp
    use gb_lapack, only: dgbtrf, dgbtrs
    use gb_threads, only: use_one_blas_thread
    use bench_models, only: seconds
    implicit none
    integer, parameter :: kd = 14, middle = 2*kd + 1
    real(wp), parameter :: mu = 5000.0_wp, c = 2500.0_wp, jm = 1.0e20_wp, rho = 1.0e-6_wp, q3 = 2.85_wp
    real(wp), parameter :: dt = 1.35e-4_wp, length = 10.0_wp, tolerance = 1.0e-10_wp
    real(wp), parameter :: root = sqrt(0.6_wp), z(3) = [-0.5_wp, 0.0_wp, 0.5_wp]*root
    real(wp), parameter :: wz(3) = [5.0_wp, 8.0_wp, 5.0_wp]/18.0_wp
    real(wp), allocatable :: u(:), v(:), a(:), u_p(:), load(:), mass(:, :), k(:, :), r(:)
    integer, allocatable :: pivots(:)
    character(16) :: word
    real(wp) :: least, start, h
    integer :: n, ne, steps, repeats, iterations, repeat, step

    call get_command_argument(1, word)
    read (word, *) ne
    call get_command_argument(2, word)
    read (word, *) steps
    call get_command_argument(3, word)
    read (word, *) repeats
    call use_one_blas_thread()
    n = 5*(2*ne + 1)
    h = length/real(ne, wp)
    allocate (u(n), v(n), a(n), u_p(n), load(n), mass(3*kd + 1, n), k(3*kd + 1, n), r(n), pivots(n))
    least = huge(least)
    do repeat = 1, repeats
        start = seconds()
        iterations = 0
        u = 0.0_wp
        v = 0.0_wp
        call assemble_constants()
        call first_acceleration()
        do step = 1, steps
            call take_step()
        end do
        least = min(least, seconds() - start)
    end do
    print '(a,i8,a,i7,a,f10.4,a,f9.1,a,es22.14)', 'elements', ne, '  iterations', iterations, '  ms', &
        1.0e3_wp*least, '  ns an element and iteration', &
        1.0e9_wp*least/real(iterations, wp)/real(ne, wp), '  tip', u(n - 3)

contains

    !> Consistent mass and the nodal forces of the load.
    subroutine assemble_constants()
        real(wp), parameter :: product(3, 3) = reshape([4.0_wp, 2.0_wp, -1.0_wp, 2.0_wp, 16.0_wp, 2.0_wp, &
            -1.0_wp, &
            2.0_wp, 4.0_wp], [3, 3])/30.0_wp
        real(wp), parameter :: moments(5) = [1.0_wp, 1.0_wp, 1.0_wp/12.0_wp, 1.0_wp/12.0_wp, 1.0_wp/80.0_wp]
        real(wp) :: block(15, 15)
        integer :: e, i, j, f

        mass = 0.0_wp
        load = 0.0_wp
        block = 0.0_wp
        do i = 1, 3
            do j = 1, 3
                do f = 1, 5
                    block(5*(i - 1) + f, 5*(j - 1) + f) = rho*moments(f)*h*product(i, j)
                end do
            end do
        end do
        do e = 1, ne
            call add(10*(e - 1), block, mass)
            load(10*e - 8:10*e + 2:5) = load(10*e - 8:10*e + 2:5) + q3*h*[1.0_wp, 4.0_wp, 1.0_wp]/6.0_wp
        end do
        load(1:5) = 0.0_wp
    end subroutine assemble_constants

    subroutine first_acceleration()
        integer :: info

        k = mass
        call clamp(k)
        a = load
        call dgbtrf(n, n, kd, kd, k, 3*kd + 1, pivots, info)
        call dgbtrs('N', n, kd, kd, 1, k, 3*kd + 1, pivots, a, n, info)
    end subroutine first_acceleration

    !> One step of the trapezoidal rule by Newton's method.
    subroutine take_step()
        real(wp) :: first_guess(n), factor, force(15), block(15, 15), largest(5), norm
        integer :: e, iteration, field, info, j

        factor = 4.0_wp/dt**2
        u_p = u + dt*v + 0.25_wp*dt**2*a
        first_guess = u + dt*v
        v = -v - (2.0_wp/dt)*u          ! what is known of the new velocity, (2/dt) (u_1 - u_0) - v_0
        u = first_guess
        do iteration = 1, 25
            k = factor*mass
            r = -load
            do j = 1, n
                r(max(1, j - kd):min(n, j + kd)) = r(max(1, j - kd):min(n, j + kd)) &
                    + mass(middle + max(1, j - kd) - j:middle + min(n, j + kd) - j, j)*(factor*(u(j) &
                        - u_p(j)))
            end do
            do e = 1, ne
                call element(u(10*e - 9:10*e + 5), force, block)
                r(10*e - 9:10*e + 5) = r(10*e - 9:10*e + 5) + force
                call add(10*(e - 1), block, k)
            end do
            r(1:5) = 0.0_wp
            call clamp(k)
            call dgbtrf(n, n, kd, kd, k, 3*kd + 1, pivots, info)
            call dgbtrs('N', n, kd, kd, 1, k, 3*kd + 1, pivots, r, n, info)
            u = u - r
            iterations = iterations + 1
            norm = 0.0_wp
            do field = 1, 5
                largest(field) = max(1.0e-3_wp, maxval(abs(u(field::5))))
                norm = max(norm, maxval(abs(r(field::5)))/largest(field))
            end do
            if (norm <= tolerance) exit
        end do
        a = factor*(u - u_p)
        v = v + (2.0_wp/dt)*u
    end subroutine take_step

    !> Internal force and tangent of an element: two points along it, three through its thickness.
    subroutine element(u, force, block)
        real(wp), intent(in) :: u(5, 3)
        real(wp), intent(out) :: force(15), block(15, 15)
        real(wp) :: s, shape(3), slope(3), f(4), b(4, 15), p(4), moduli(4, 4), w, y1, y3, xi, dy1, dy3, &
            dxi, zeta
        integer :: i, j, m

        force = 0.0_wp
        block = 0.0_wp
        do i = 1, 2
            s = real(2*i - 3, wp)/sqrt(3.0_wp)
            shape = [0.5_wp*s*(s - 1.0_wp), 1.0_wp - s*s, 0.5_wp*s*(s + 1.0_wp)]
            slope = [s - 0.5_wp, -2.0_wp*s, s + 0.5_wp]*2.0_wp/h
            y1 = dot_product(shape, u(3, :))
            y3 = 1.0_wp + dot_product(shape, u(4, :))
            xi = dot_product(shape, u(5, :))
            dy1 = dot_product(slope, u(3, :))
            dy3 = dot_product(slope, u(4, :))
            dxi = dot_product(slope, u(5, :))
            do j = 1, 3
                w = 0.5_wp*h*wz(j)
                zeta = z(j) + xi*z(j)**2
                f = [1.0_wp + dot_product(slope, u(1, :)) + zeta*dy1 + z(j)**2*dxi*y1, &
                     dot_product(slope, u(2, :)) + zeta*dy3 + z(j)**2*dxi*y3, &
                     (1.0_wp + 2.0_wp*xi*z(j))*y1, (1.0_wp + 2.0_wp*xi*z(j))*y3]      ! F11, F31, F13, F33
                b = 0.0_wp
                do m = 1, 3
                    b(1, 5*m - 4) = slope(m)
                    b(2, 5*m - 3) = slope(m)
                    b(1, 5*m - 2) = zeta*slope(m) + z(j)**2*dxi*shape(m)
                    b(3, 5*m - 2) = (1.0_wp + 2.0_wp*xi*z(j))*shape(m)
                    b(2, 5*m - 1) = zeta*slope(m) + z(j)**2*dxi*shape(m)
                    b(4, 5*m - 1) = (1.0_wp + 2.0_wp*xi*z(j))*shape(m)
                    b(1, 5*m) = z(j)**2*(dy1*shape(m) + y1*slope(m))
                    b(2, 5*m) = z(j)**2*(dy3*shape(m) + y3*slope(m))
                    b(3, 5*m) = 2.0_wp*z(j)*y1*shape(m)
                    b(4, 5*m) = 2.0_wp*z(j)*y3*shape(m)
                end do
                call gent(f, p, moduli)
                force = force + w*matmul(p, b)
                block = block + w*matmul(transpose(b), matmul(moduli, b))
                call add_geometric(w, z(j), shape, slope, p, block)
            end do
        end do
    end subroutine element

    !> First Piola-Kirchhoff stress and its derivative, in (11, 31, 13, 33).
    pure subroutine gent(f, p, moduli)
        real(wp), intent(in) :: f(4)
        real(wp), intent(out) :: p(4), moduli(4, 4)
        real(wp) :: j, i1, slope, curvature, dj(4), psi_1, psi_2
        integer :: i

        i1 = dot_product(f, f)
        j = f(1)*f(4) - f(2)*f(3)
        slope = mu*jm/(jm - i1 + 2.0_wp)
        curvature = mu*jm/(jm - i1 + 2.0_wp)**2
        dj = [f(4), -f(3), -f(2), f(1)]
        psi_1 = (-mu - 0.5_wp*c*(1.0_wp - j**2))/j
        psi_2 = 0.5_wp*c + (mu + 0.5_wp*c)/j**2
        p = slope*f + psi_1*dj
        moduli = 2.0_wp*curvature*spread(f, 2, 4)*spread(f, 1, 4) + psi_2*spread(dj, 2, 4)*spread(dj, 1, 4)
        do i = 1, 4
            moduli(i, i) = moduli(i, i) + slope
        end do
        moduli(1, 4) = moduli(1, 4) + psi_1
        moduli(4, 1) = moduli(4, 1) + psi_1
        moduli(2, 3) = moduli(2, 3) - psi_1
        moduli(3, 2) = moduli(3, 2) - psi_1
    end subroutine gent

    !> Second derivatives of F: xi with y1', y3', y1, y3, and xi' with y1, y3.
    subroutine add_geometric(w, z, shape, slope, p, block)
        real(wp), intent(in) :: w, z, shape(3), slope(3), p(4)
        real(wp), intent(inout) :: block(15, 15)
        real(wp) :: y1, y3
        integer :: m, k

        do m = 1, 3
            do k = 1, 3
                y1 = w*(z**2*p(1)*(shape(m)*slope(k) + slope(m)*shape(k)) + 2.0_wp*z*p(3)*shape(m)*shape(k))
                y3 = w*(z**2*p(2)*(shape(m)*slope(k) + slope(m)*shape(k)) + 2.0_wp*z*p(4)*shape(m)*shape(k))
                block(5*m, 5*k - 2) = block(5*m, 5*k - 2) + y1
                block(5*k - 2, 5*m) = block(5*k - 2, 5*m) + y1
                block(5*m, 5*k - 1) = block(5*m, 5*k - 1) + y3
                block(5*k - 1, 5*m) = block(5*k - 1, 5*m) + y3
            end do
        end do
    end subroutine add_geometric

    !> band <- band + block, in dgbtrf's layout.
    pure subroutine add(first, block, band)
        integer, intent(in) :: first
        real(wp), intent(in) :: block(15, 15)
        real(wp), intent(inout) :: band(:, :)
        integer :: i, j

        do j = 1, 15
            do i = 1, 15
                band(middle + i - j, first + j) = band(middle + i - j, first + j) + block(i, j)
            end do
        end do
    end subroutine add

    !> The first node is held.
    pure subroutine clamp(band)
        real(wp), intent(inout) :: band(:, :)
        integer :: i, j

        do j = 1, 5
            band(:, j) = 0.0_wp
            do i = 1, n
                if (abs(i - j) <= kd) band(middle + j - i, i) = 0.0_wp
            end do
            band(middle, j) = 1.0_wp
        end do
    end subroutine clamp

end program bench_naive
