!> MODAL: natural frequencies and modes about the current state, K x = omega^2 M x with banded matrices, by
!> subspace iteration on (K - shift M)^-1 M with a shift below the spectrum. A Sturm count checks that none
!> was missed.
module gb_modal
    use gb_kinds, only: wp, pi
    use gb_error, only: error_t, raise, status_solution
    use gb_text, only: to_text
    use gb_lapack, only: dsygv
    use gb_band, only: band_t
    use gb_fields, only: n_fields, field_xi
    use gb_model, only: model_t
    use gb_problem, only: task_t
    use gb_state, only: state_t
    use gb_recorder, only: recorder_t
    use gb_system, only: system_t
    implicit none
    private

    integer, parameter :: max_rounds = 200
    real(wp), parameter :: wanted_change = 1.0e-12_wp      !! of omega^2 between two rounds, relative

    public :: run_modal

contains

    subroutine run_modal(system, model, task, state, recorder, error)
        type(system_t), intent(in) :: system
        type(model_t), intent(in) :: model
        type(task_t), intent(in) :: task
        type(state_t), intent(in) :: state
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(band_t) :: k, m
        real(wp), allocatable :: force(:), lambda(:), modes(:, :)
        real(wp) :: shift
        integer :: count, massive, i
        logical :: admissible

        allocate (force(system%n))
        call k%set_up(system%n, system%kd, system%symmetric)
        call system%tangent(state%u, force, k, admissible)
        if (.not. admissible) then
            call raise(error, status_solution, &
                'MODAL: the current state is not admissible (J <= 0 or I1-2 >= jm somewhere)')
            return
        end if
        if (.not. system%symmetric) call take_symmetric_part(k)
        call k%constrain(system%fixed_list)
        call system%mass_at(state%u, m)
        call m%constrain(system%fixed_list)
        m%a(0, system%fixed_list) = 0.0_wp
        massive = size(pack(system%fixed, .not. system%fixed))
        if (system%has_massless) massive = size(pack(system%fixed, .not. (system%fixed .or. system%massless)))
        count = min(task%count, massive)
        if (count < task%count) call recorder%note('MODAL: the model has only ' // to_text(count) // ' modes')
        if (.not. (model%has_potential_somewhere() .or. any(model%mesh%full_integration) &
            .or. any(system%fixed(field_xi::n_fields)))) then
            call recorder%note('MODAL: rule linear leaves one pattern of xi without stiffness where no ' &
                // 'node holds xi: a mode of zero frequency that is none of the beam')
        end if
        call find_shift(k, m, frequency_scale(model), shift, error)
        if (allocated(error)) return
        call iterate_subspace(k, m, shift, count, massive, lambda, modes, error)
        if (allocated(error)) return
        i = count_below(k, m, lambda(count) + 1.0e-8_wp*abs(lambda(count) - shift))
        if (i > count) call recorder%note('MODAL: ' // to_text(i) &
            // ' modes lie at or below the last of the ' // to_text(count) // ' found; ask for count=' &
            // to_text(i))
        if (any(lambda < 0.0_wp)) then
            call recorder%note('MODAL: the state is unstable; modes that grow have a negative frequency')
        end if
        call recorder%record_modes(sign(sqrt(abs(lambda))/(2.0_wp*pi), lambda), modes, error)
    end subroutine run_modal

    !> k <- (k + k')/2 in symmetric storage. The skew part of rule `linear`'s tangent changes eigenvalues in
    !> second order only.
    pure subroutine take_symmetric_part(k)
        type(band_t), intent(inout) :: k
        real(wp), allocatable :: lower(:, :)
        integer :: i, j

        allocate (lower(0:k%kd, k%n))
        lower = 0.0_wp
        do j = 1, k%n
            do i = j, min(k%n, j + k%kd)
                lower(i - j, j) = 0.5_wp*(k%a(i - j, j) + k%a(j - i, i))
            end do
        end do
        call move_alloc(lower, k%a)
        k%symmetric = .true.
    end subroutine take_symmetric_part

    !> E I/(rho A L^4): the square of a bending frequency, up to a factor [1/T^2].
    pure real(wp) function frequency_scale(model)
        type(model_t), intent(in) :: model
        real(wp) :: stiffness, mass
        integer :: i

        stiffness = 0.0_wp
        mass = 0.0_wp
        do i = 1, size(model%lines)
            associate (material => model%materials(model%lines(i)%material), &
                section => model%sections(model%lines(i)%section))
                stiffness = max(stiffness, material%fibre_modulus()*section%second_moment())
                mass = max(mass, material%rho*section%area())
            end associate
        end do
        frequency_scale = stiffness/(mass*model%mesh%length()**4)
    end function frequency_scale

    !> A shift below every eigenvalue: then K - shift M is positive definite and has a Cholesky factor. A
    !> support-free beam or a buckled state needs a negative one.
    subroutine find_shift(k, m, scale, shift, error)
        type(band_t), intent(in) :: k, m
        real(wp), intent(in) :: scale                   !! [1/T^2]
        real(wp), intent(out) :: shift
        type(error_t), allocatable, intent(out) :: error
        integer :: trial

        shift = -scale
        do trial = 1, 60
            if (count_below(k, m, shift) == 0) return
            shift = 4.0_wp*shift
        end do
        call raise(error, status_solution, &
            'MODAL: the stiffness of the fields without inertia is not positive definite; ' &
            // 'use inertia=diagonal, or support them')
    end subroutine find_shift

    !> Number of eigenvalues below sigma: negative pivots of K - sigma M = L D L' (Sylvester's law of
    !> inertia).
    pure integer function count_below(k, m, sigma) result(count)
        type(band_t), intent(in) :: k, m
        real(wp), intent(in) :: sigma
        real(wp), allocatable :: a(:, :)
        real(wp) :: factor
        integer :: i, j, last

        allocate (a(0:k%kd, k%n))
        a = k%a - sigma*m%a
        count = 0
        do j = 1, k%n
            if (a(0, j) < 0.0_wp) count = count + 1
            if (abs(a(0, j)) <= 0.0_wp) a(0, j) = tiny(1.0_wp)
            last = min(k%kd, k%n - j)
            do i = 1, last
                factor = a(i, j)/a(0, j)
                a(0:last - i, j + i) = a(0:last - i, j + i) - factor*a(i:last, j)
            end do
        end do
    end function count_below

    !> The lowest `count` eigenpairs, modes scaled to a largest displacement of 1.
    subroutine iterate_subspace(k, m, shift, count, massive, lambda, modes, error)
        type(band_t), intent(in) :: k, m
        real(wp), intent(in) :: shift
        integer, intent(in) :: count
        integer, intent(in) :: massive                      !! rank of m
        real(wp), allocatable, intent(out) :: lambda(:)     !! omega^2 [1/T^2] (count)
        real(wp), allocatable, intent(out) :: modes(:, :)   !! (n, count)
        type(error_t), allocatable, intent(out) :: error
        type(band_t) :: shifted
        real(wp), allocatable :: x(:, :), mx(:, :), values(:), before(:)
        real(wp), allocatable :: blur(:)                    !! of each eigenvalue, by rounding alone, relative
        integer :: q, round, singular, i

        call shifted%set_up(k%n, k%kd, symmetric=.true.)
        shifted%a = k%a - shift*m%a
        call shifted%factorise(singular)
        q = min(max(2*count, count + 8), massive)
        allocate (x(k%n, q), mx(k%n, q), values(q), before(q))
        call start_vectors(x)
        before = 0.0_wp
        do round = 1, max_rounds
            do i = 1, q
                call m%multiply(x(:, i), mx(:, i))
            end do
            x = mx
            call shifted%solve(q, x)
            call orthonormalise(shifted, m, x, mx, values, q)
            if (q < count) exit
            blur = [(round_off(shifted, x(:, i), values(i)/values(1)), i=1, count)]
            if (all(abs(values(:count) - before(:count)) <= max(wanted_change, blur)*values(:count))) exit
            before(:q) = values(:q)
        end do
        if (q < count .or. round > max_rounds) then
            call raise(error, status_solution, 'MODAL: ' // to_text(count) // ' modes did not converge in ' &
                // to_text(max_rounds) // ' rounds; ask for fewer with count=')
            return
        end if
        lambda = values(:count) + shift
        where (abs(lambda) <= blur*values(:count)) lambda = 0.0_wp      ! a rigid motion
        modes = x(:, :count)
        do i = 1, count
            modes(:, i) = modes(:, i)/scale_of(modes(:, i))
        end do
    end subroutine iterate_subspace

    !> What rounding alone changes in an eigenvalue, relative: in x' K x = 1, unit round-off times the sum of
    !> |K_ij| |x_i| |x_j|, far above the unit round-off for the lowest modes of a slender beam, since K holds
    !> the stiffness of the thickness too; in the projected problem, what the lowest eigenvalue imposes on
    !> all.
    pure real(wp) function round_off(k, x, over_lowest)
        type(band_t), intent(in) :: k
        real(wp), intent(in) :: x(:)
        real(wp), intent(in) :: over_lowest         !! the eigenvalue over the lowest one
        real(wp) :: bound(size(x))

        call k%row_bound(abs(x), bound)
        round_off = epsilon(1.0_wp)*(dot_product(abs(x), bound) + 8.0_wp*over_lowest)
    end function round_off

    !> The displacement component of largest size, with its sign (any field where no displacement moves).
    pure real(wp) function scale_of(mode) result(scale)
        real(wp), intent(in) :: mode(:)
        real(wp) :: largest(2)

        largest = [maxval(abs(mode(1::n_fields))), maxval(abs(mode(2::n_fields)))]
        if (maxval(largest) > 0.0_wp) then
            associate (field => merge(1, 2, largest(1) > largest(2)))
                scale = mode(field + n_fields*(maxloc(abs(mode(field::n_fields)), 1) - 1))
            end associate
        else
            scale = maxval(abs(mode))
        end if
    end function scale_of

    !> Start vectors from a fixed congruential sequence: the same run gives the same bits.
    pure subroutine start_vectors(x)
        real(wp), intent(out) :: x(:, :)
        integer :: i, j, seed

        seed = 12345
        do j = 1, size(x, 2)
            do i = 1, size(x, 1)
                seed = modulo(1103*seed + 12345, 65536)
                x(i, j) = real(seed, wp)/32768.0_wp - 1.0_wp
            end do
        end do
    end subroutine start_vectors

    !> Rayleigh-Ritz: rotate x so that it diagonalises the projected pencil. On return the first q columns are
    !> Ritz vectors with x' (K - shift M) x = 1, values their eigenvalues of the shifted pencil, increasing; q
    !> shrinks where vectors are dependent.
    subroutine orthonormalise(shifted, m, x, mx, values, q)
        type(band_t), intent(in) :: shifted, m
        real(wp), intent(inout) :: x(:, :)
        real(wp), intent(inout) :: mx(:, :)         !! in: right-hand sides the x were solved for; workspace
        real(wp), intent(out) :: values(:)
        integer, intent(inout) :: q
        real(wp), allocatable :: a(:, :), b(:, :), work(:), inverse(:)
        integer :: i, info

        allocate (a(q, q), b(q, q), work(64*q), inverse(q))
        b = matmul(transpose(x(:, :q)), mx(:, :q))      ! x' (K - shift M) x, since mx = (K - shift M) x
        do i = 1, q
            call m%multiply(x(:, i), mx(:, i))
        end do
        a = matmul(transpose(x(:, :q)), mx(:, :q))      ! x' M x
        ! M x = (1/value) (K - shift M) x: the largest 1/value, the lowest modes, come out last.
        call dsygv(1, 'V', 'U', q, a, q, b, q, inverse, work, size(work), info)
        if (info > q) then
            q = info - q - 1
            return
        end if
        a = a(:, q:1:-1)
        x(:, :q) = matmul(x(:, :q), a)
        values(:q) = 1.0_wp/max(inverse(q:1:-1), tiny(1.0_wp)*1.0e10_wp)
    end subroutine orthonormalise

end module gb_modal
