!> Where `auto` begins: a mesh and steps as coarse as can be for the courses of the probes to be recognisable.
module gb_footing
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
    use gb_findings, only: findings_t, set_elements, climb_finer, learn_axes, has_transients, most_elements, &
        most_steps
    use gb_ladder, only: ladder_t
    use gb_problem, only: problem_t, task_static, task_transient
    use gb_sight, only: steps_to_see, elements_to_see
    use gb_text, only: to_text
    implicit none
    private

    !> The first steps, before anything is known, and the phase that a step may cover once the motion's own
    !> frequency is.
    integer, parameter :: first_steps = 64, load_steps = 4
    real(wp), parameter :: first_phase = 0.25_wp
    !> First steps that lack no more than this factor are kept: another trial would cost more than they err.
    real(wp), parameter :: tolerable = 1.25_wp
    real(wp), parameter :: first_elements_a_piece = 1.5_wp
    integer, parameter :: least_elements = 3
    !> Steps are held against so many times as many. Load steps must find the equilibrium that many of them
    !> find, and not one that is unstable: two long ones may leap to the same.
    integer, parameter :: growth_in_motion = 2, growth_at_rest = 10
    !> Changes up to this one are taken to grow with the error: beyond it, courses are merely different.
    real(wp), parameter :: largest_change = 0.3_wp
    integer, parameter :: most_failures = 6
    !> Doublings of the mesh or the steps, all told: courses that cannot be recognised then never will be.
    integer, parameter :: most_doublings = 10
    !> From a trial that failed to the next one, steps grow by this factor at most, whatever its motion tells.
    integer, parameter :: longest_leap = 8

    public :: find_footing

contains

    !> A coarse mesh and step at which the courses are recognisable: twice the elements, and twice the steps,
    !> change them by no more than largest_change.
    subroutine find_footing(ladder, found, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        type(error_t), allocatable, intent(out) :: error
        integer :: base, finer_mesh, finer_steps, failures, doublings
        logical :: is_adapted
        real(wp) :: mesh_change, time_change, growth

        growth = real(merge(growth_in_motion, growth_at_rest, has_transients(ladder%problem)), wp)
        call keep_given_inertia(ladder%problem, found)
        allocate (found%base%steps(size(ladder%problem%tasks)))
        found%n = elements_to_see(ladder%problem%model, &
            max(real(least_elements, wp), first_elements_a_piece*real(size(ladder%pieces), wp)))
        call set_elements(ladder, found%n, found%base)
        found%base%steps = first_step_counts(ladder%problem)
        doublings = 0
        if (exceeds_limits(found, doublings, error)) return
        failures = 0
        is_adapted = .false.
        do
            call climb_somehow(ladder, found, failures, base, error)
            if (allocated(error)) return
            if (.not. is_adapted) then
                is_adapted = .true.
                call adapt_first_steps(ladder, base, found%base%steps)
                call climb_somehow(ladder, found, failures, base, error)
                if (allocated(error)) return
            end if
            call climb_finer(ladder, found, 1, growth, base, finer_steps, error)
            if (allocated(error)) return
            if (ladder%has_failed(finer_steps)) then
                call give_way(ladder, found, failures, finer_steps, error)
                if (allocated(error)) return
                cycle
            end if
            time_change = ladder%change(base, finer_steps)
            if (time_change > largest_change) then
                found%base%steps = 2*found%base%steps
                doublings = doublings + 1
                if (exceeds_limits(found, doublings, error)) return
                cycle
            end if
            call climb_finer(ladder, found, 2, 1.0_wp, base, finer_mesh, error)
            if (allocated(error)) return
            if (ladder%has_failed(finer_mesh)) then
                call give_way(ladder, found, failures, finer_mesh, error)
                if (allocated(error)) return
                cycle
            end if
            mesh_change = ladder%change(base, finer_mesh)
            if (mesh_change <= largest_change) exit
            found%n = 2.0_wp*found%n
            call set_elements(ladder, found%n, found%base)
            doublings = doublings + 1
            if (exceeds_limits(found, doublings, error)) return
        end do
        found%mesh = [base, finer_mesh]
        found%time = [base, finer_steps]
        found%steps = [1.0_wp, growth]
        found%local = [0.0_wp, 0.0_wp]
        call learn_axes(ladder, found)
    end subroutine find_footing

    !> Where all sections of the beam name their inertia, nothing is left to choose.
    pure subroutine keep_given_inertia(problem, found)
        type(problem_t), intent(in) :: problem
        type(findings_t), intent(inout) :: found

        associate (sections => problem%model%sections(problem%model%mesh%section))
            found%keeps_inertia = all(sections%inertia_is_given)
            if (found%keeps_inertia) found%base%inertia = sections(1)%inertia
        end associate
    end subroutine keep_given_inertia

    !> Try the base setting; where it fails, another one.
    subroutine climb_somehow(ladder, found, failures, base, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        integer, intent(inout) :: failures
        integer, intent(out) :: base
        type(error_t), allocatable, intent(out) :: error
        integer, allocatable :: failed(:)           !! steps of the trial that has

        do
            call ladder%climb(found%base, 'footing', 0, base, error)
            if (allocated(error)) return
            if (.not. ladder%has_failed(base)) return
            failed = found%base%steps
            call give_way(ladder, found, failures, base, error)
            if (allocated(error)) return
            call adapt_first_steps(ladder, base, found%base%steps)
            found%base%steps = min(found%base%steps, longest_leap*failed)
        end do
    end subroutine climb_somehow

    !> After a trial that failed: twice the steps, some times.
    subroutine give_way(ladder, found, failures, number, error)
        type(ladder_t), intent(in) :: ladder
        type(findings_t), intent(inout) :: found
        integer, intent(inout) :: failures
        integer, intent(in) :: number               !! of the rung that failed
        type(error_t), allocatable, intent(out) :: error

        failures = failures + 1
        if (failures >= most_failures) then
            call raise(error, status_solution, 'no trial comes to its end, the last: ' &
                // ladder%rungs(number)%failure)
            return
        end if
        found%base%steps = 2*found%base%steps
    end subroutine give_way

    logical function exceeds_limits(found, doublings, error)
        type(findings_t), intent(in) :: found
        integer, intent(in) :: doublings            !! so far, of mesh and steps
        type(error_t), allocatable, intent(inout) :: error

        exceeds_limits = found%n > most_elements .or. any(real(found%base%steps, wp) >= most_steps) &
            .or. doublings > most_doublings
        if (exceeds_limits) call raise(error, status_solution, 'with ' &
            // to_text(found%base%n_elements()) // ' elements and ' // to_text(found%base%n_steps()) &
            // ' steps a finer mesh or step still changes the probes beyond recognition; ' &
            // 'give end= and probes that the scene determines')
    end function exceeds_limits

    !> Load steps where only statics is tuned: one, if two give the same. Transients must see their histories.
    pure function first_step_counts(problem) result(steps)
        type(problem_t), intent(in) :: problem
        integer :: steps(size(problem%tasks)), i

        steps = 0
        where (problem%tasks%is_auto) steps = first_steps
        where (problem%tasks%is_auto .and. problem%tasks%kind == task_static) steps = 1
        if (has_transients(problem)) where (steps == 1) steps = load_steps
        do i = 1, size(steps)
            if (problem%tasks(i)%is_auto .and. problem%tasks(i)%kind == task_transient) steps(i) &
                = ceiling(min(steps_to_see(problem%model, problem%tasks(i)%end_time, steps(i)), most_steps))
        end do
    end function first_step_counts

    !> Steps that are short enough for the frequency at which the probes move. A trial that is of no other use
    !> tells it, too, where it has come to the end of the command.
    subroutine adapt_first_steps(ladder, base, steps)
        type(ladder_t), intent(in) :: ladder
        integer, intent(in) :: base
        integer, intent(inout) :: steps(:)
        real(wp) :: needed
        integer :: i

        do i = 1, size(ladder%trials(base)%channels)
            associate (channel => ladder%trials(base)%channels(i))
                if (channel%course%is_static .or. .not. channel%course%reaches( &
                    ladder%problem%tasks(channel%task)%end_time)) cycle
                ! What rests has rates of rounding errors.
                if (channel%course%size_of() <= ladder%least_size(i)) cycle
                needed = channel%course%angular_frequency()*ladder%problem%tasks(channel%task)%end_time &
                    /first_phase
                if (needed > tolerable*real(steps(channel%task), wp)) steps(channel%task) &
                    = nint(min(needed, most_steps))
            end associate
        end do
    end subroutine adapt_first_steps

end module gb_footing
