!> SECTION rule=auto: Gauss points through the thickness, element by element, as many as the strains need that
!> the scene brings. A pilot run with three points tells the strains: the deck's commands with longer steps.
!> The error of a rule in an element is the difference of its stress resultants to those of the largest rule
!> in the same state, in the norm of the energy, over the largest resultants of the beam.
module gb_choose_points
    use gb_kinds, only: wp
    use gb_error, only: error_t, status_interrupted
    use gb_beam, only: section_data_t, element_strains
    use gb_fields, only: n_fields
    use gb_model, only: model_t
    use gb_pilot, only: pilot_t, run_pilot
    use gb_problem, only: problem_t, task_t
    use gb_quadrature, only: gauss_legendre
    use gb_recorder, only: step_record_t
    use gb_section, only: section_t
    use gb_section_gauss, only: n_strains, gauss_stress, gauss_tangent
    use gb_solver_choice, only: block_obstacle
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    implicit none
    private

    !> Two points see shear only together with the thickness stretch, and have no limit under refinement
    !> (docs/model-error.md): three are the least.
    integer, parameter :: least = 3, most = 10
    !> The pilot's steps are longer than the deck's, but no fewer than this.
    real(wp), parameter :: pilot_factor = 4.0_wp
    integer, parameter :: pilot_steps = 32
    real(wp), parameter :: pilot_tolerance = 1.0e-5_wp
    !> Strains are looked at so often in a command.
    integer, parameter :: looks = 200
    !> A rule whose error is this much below the tolerance needs no richer one to be looked at.
    real(wp), parameter :: clear_part = 1.0e-2_wp

    !> Follows the pilot run, and keeps the largest errors.
    type, extends(pilot_t) :: observer_t
        type(system_t) :: system
        type(section_data_t), allocatable :: rules(:, :)    !! (least:most, kinds)
        real(wp), allocatable :: weight(:, :)       !! 1/stiffness of the strains at rest (strains, kinds)
        real(wp), allocatable :: error(:, :)        !! squared, in the norm of the energy (least:most, ne)
        real(wp), allocatable :: tolerance(:)       !! of the elements (ne)
        real(wp) :: largest = 0.0_wp                !! stress resultants so far, squared, as error
        real(wp) :: next_look = 0.0_wp              !! progress of the command
    contains
        procedure :: begin_task
        procedure :: record_step
    end type observer_t

    public :: choose_points

contains

    !> Give every element of a section with rule=auto its points. Where the block solver takes the model, all
    !> get the largest number: it takes one rule for all, and a point costs far less than that solver saves.
    !> Other sections keep what the deck gives them: that number is then taken for all if it is enough.
    !> An error only where somebody wants to stop: a pilot that fails has told the strains up to there.
    subroutine choose_points(problem, deadline, error)
        type(problem_t), intent(inout) :: problem
        real(wp), intent(in) :: deadline            !! CPU time at which to stop [s]; 0: none
        type(error_t), allocatable, intent(out) :: error
        type(observer_t) :: observer
        integer, allocatable :: points(:), one_rule(:)
        logical, allocatable :: is_open(:)
        type(model_t) :: uniform
        integer :: e, n

        call observe(problem, deadline, observer, error)
        if (allocated(error)) return
        associate (mesh => problem%model%mesh, sections => problem%model%sections)
            points = sections(mesh%section)%points
            is_open = sections(mesh%section)%is_auto
            do e = 1, size(points)
                if (.not. is_open(e)) cycle
                do n = least, most
                    points(e) = n
                    if (observer%error(n, e) <= observer%tolerance(e)**2*observer%largest) exit
                end do
            end do
        end associate
        one_rule = points
        where (is_open) one_rule = maxval(points)
        uniform = problem%model
        uniform%sections%points = maxval(points)
        if (all(one_rule == maxval(points)) .and. block_obstacle(uniform) == '') points = one_rule
        call split_sections(problem%model, points)
    end subroutine choose_points

    !> Sections by number of points, in place of those that left it open.
    subroutine split_sections(model, points)
        type(model_t), intent(inout) :: model
        integer, intent(in) :: points(:)            !! (ne)
        type(section_t), allocatable :: sections(:)
        integer, allocatable :: section_of(:)
        integer :: s, n

        allocate (sections(0))
        section_of = model%mesh%section
        do s = 1, size(model%sections)
            do n = 1, most
                if (.not. any(model%mesh%section == s .and. points == n)) cycle
                sections = [sections, model%sections(s)]
                associate (last => sections(size(sections)))
                    last%points = n
                    last%is_auto = .false.
                end associate
                where (model%mesh%section == s .and. points == n) section_of = size(sections)
            end do
        end do
        model%sections = sections
        model%mesh%section = section_of
        n = 1
        do s = 1, size(model%lines)
            model%lines(s)%section = section_of(n)
            n = n + model%lines(s)%elements
        end do
        model%points_are_chosen = .true.
    end subroutine split_sections

    subroutine observe(problem, deadline, observer, error)
        type(problem_t), intent(in) :: problem
        real(wp), intent(in) :: deadline            !! CPU time at which to stop [s]; 0: none
        type(observer_t), intent(inout) :: observer
        type(error_t), allocatable, intent(out) :: error
        type(problem_t) :: pilot

        pilot = problem
        where (pilot%model%sections%is_auto) pilot%model%sections%points = least
        pilot%tasks%tolerance = max(pilot%tasks%tolerance, pilot_tolerance)
        where (pilot%tasks%step > 0.0_wp) pilot%tasks%step = max(pilot%tasks%step, &
            min(pilot_factor*pilot%tasks%step, pilot%tasks%end_time/real(pilot_steps, wp)))
        call prepare(observer, pilot)
        observer%deadline = deadline
        call run_pilot(pilot, observer%system, observer, error)
        if (.not. allocated(error)) return
        if (error%status /= status_interrupted) deallocate (error)
    end subroutine observe

    !> All rules for every pair of material and section, and the stiffness of the strains at rest.
    subroutine prepare(observer, pilot)
        type(observer_t), intent(inout) :: observer
        type(problem_t), intent(in) :: pilot
        real(wp) :: rest(n_strains), s(n_strains), t(n_strains, n_strains), height
        logical :: admissible
        integer :: k, n, i

        observer%system = build_system(pilot%model)
        associate (sections => observer%system%sections, ne => observer%system%n_elements)
            allocate (observer%rules(least:most, size(sections)), observer%weight(n_strains, size(sections)))
            allocate (observer%error(least:most, ne))
            observer%error = 0.0_wp
            observer%tolerance = pilot%model%sections(pilot%model%mesh%section)%tolerance
            rest = 0.0_wp
            do k = 1, size(sections)
                height = pilot%model%sections(1 + (k - 1)/size(pilot%model%materials))%h
                do n = least, most
                    associate (rule => observer%rules(n, k))
                        rule = sections(k)
                        rule%nz = n
                        call gauss_legendre(rule%z(:n), rule%wz(:n))
                        rule%z(:n) = 0.5_wp*height*rule%z(:n)
                        rule%wz(:n) = 0.5_wp*rule%area*rule%wz(:n)
                    end associate
                end do
                associate (rule => observer%rules(most, k))
                    call gauss_tangent(rule%nz, rule%z, rule%wz, rule%p, rest, s, t, admissible)
                end associate
                observer%weight(:, k) = [(1.0_wp/t(i, i), i=1, n_strains)]
            end do
        end associate
    end subroutine prepare

    subroutine begin_task(self, task, error)
        class(observer_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        self%next_look = 0.0_wp
    end subroutine begin_task

    subroutine record_step(self, step, state, error)
        class(observer_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error

        call self%check_stop(error)
        if (allocated(error) .or. step%progress < self%next_look) return
        self%next_look = step%progress + 1.0_wp/real(looks, wp)
        call look(self, state%u)
    end subroutine record_step

    !> Errors of the rules in the state u.
    pure subroutine look(self, u)
        class(observer_t), intent(inout) :: self
        real(wp), intent(in) :: u(:)
        real(wp) :: g(n_strains), exact(n_strains), s(n_strains), misfit
        logical :: admissible
        integer :: e, i, n, m

        do e = 1, self%system%n_elements
            associate (t => self%system%tables(self%system%table(e)), first => self%system%first(e), &
                k => self%system%kind(e), half => self%system%half_length(e))
                m = n_fields*t%nodes
                do i = 1, t%points
                    g = element_strains(t%nodes, t%n(:t%nodes, i), t%d(:t%nodes, i)/half, &
                        reshape(u(first + 1:first + m), [n_fields, t%nodes]))
                    call stress(self%rules(most, k), g, exact, admissible)
                    ! The faces are beyond the material's limits: points near them are what is needed.
                    if (.not. admissible) then
                        self%error(:most - 1, e) = huge(1.0_wp)
                        cycle
                    end if
                    self%largest = max(self%largest, sum(self%weight(:, k)*exact**2))
                    do n = least, most - 1
                        call stress(self%rules(n, k), g, s, admissible)
                        misfit = sum(self%weight(:, k)*(s - exact)**2)
                        self%error(n, e) = max(self%error(n, e), misfit)
                        if (misfit <= (clear_part*self%tolerance(e))**2*self%largest) exit
                    end do
                end do
            end associate
        end do
    end subroutine look

    pure subroutine stress(rule, g, s, admissible)
        type(section_data_t), intent(in) :: rule
        real(wp), intent(in) :: g(n_strains)
        real(wp), intent(out) :: s(n_strains)
        logical, intent(out) :: admissible

        call gauss_stress(rule%nz, rule%z, rule%wz, rule%p, g, s, admissible)
    end subroutine stress

end module gb_choose_points
