!> `auto`: the cheapest setting whose estimated error is below what was asked for. Cheap trials tell how the
!> probes' courses change with the mesh, the step, the thickness rule and the inertia; from these changes
!> and the orders they shrink with, the error of any setting is predicted (gb_convergence), and the
!> cheapest one that is good enough is chosen. docs/choosing-a-model.md shows how honest that is.
module gb_tune
    use gb_kinds, only: wp
    use gb_error, only: error_t, status_interrupted
    use gb_findings, only: findings_t, has_transients
    use gb_footing, only: find_footing
    use gb_ladder, only: ladder_t
    use gb_log, only: log_t
    use gb_mesh, only: line_t
    use gb_pieces, only: mesh_pieces
    use gb_problem, only: problem_t
    use gb_refine, only: refine, adaptive_effort
    use gb_section, only: inertia_full, inertia_names
    use gb_text, only: to_text, exact_text
    use gb_trial, only: apply_setting, work_of_iteration
    use gb_tuning, only: setting_t, error_bar_t, tuning_t, n_sources, source_names
    use gb_weigh, only: look_at_thickness, look_at_inertia, most_points
    implicit none
    private

    !> Schemes, the next where the one before comes to no end: the second damps what cannot be resolved.
    character(16), parameter :: schemes(2) = [character(16) :: 'newmark', 'bathe']

    public :: tune

contains

    !> Choose, and put the choice in place of the deck's mesh, rules and steps. The log is told what was tried
    !> and why. An error where no setting is good enough, or where somebody wants to stop.
    subroutine tune(problem, log, deadline, error)
        type(problem_t), intent(inout) :: problem
        type(log_t), intent(inout) :: log
        real(wp), intent(in) :: deadline            !! CPU time at which to stop [s]; 0: none
        type(error_t), allocatable, intent(out) :: error
        type(ladder_t) :: ladder
        type(findings_t) :: found
        type(setting_t) :: chosen
        type(tuning_t) :: tuning
        real(wp), allocatable :: errors(:)
        integer :: i

        call log%line('')
        call log%line('choosing mesh, rules and steps')
        call ladder%begin(problem, log, deadline)
        do i = 1, size(schemes)
            found = findings_t()
            found%base%scheme = schemes(i)
            call climb_all(ladder, found, chosen, tuning%parts, error)
            if (.not. allocated(error)) exit
            if (error%status == status_interrupted) return
            if (i == size(schemes) .or. .not. has_transients(problem)) then
                error%message = 'auto: ' // error%message
                return
            end if
            call log%line('  ' // trim(schemes(i)) // ' is given up for ' // trim(schemes(i + 1)) // ': ' &
                // error%message)
            deallocate (error)
        end do
        tuning%accuracy = ladder%accuracy
        errors = found%forecast%channels(tuning%parts)
        tuning%estimate = maxval(errors)
        tuning%chosen = chosen
        tuning%bars = error_bars(ladder, found%mesh(size(found%mesh)), errors)
        tuning%rungs = ladder%rungs
        call explain(ladder, found, tuning)
        problem = apply_setting(problem, ladder%pieces, chosen, ladder%tolerance)
        problem%tuning = tuning
    end subroutine tune

    !> All that is needed to choose, with one scheme.
    subroutine climb_all(ladder, found, chosen, parts, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        type(setting_t), intent(out) :: chosen
        real(wp), intent(out) :: parts(n_sources)
        type(error_t), allocatable, intent(out) :: error

        call find_footing(ladder, found, error)
        if (.not. allocated(error)) call look_at_thickness(ladder, found, error)
        if (.not. allocated(error)) call look_at_inertia(ladder, found, error)
        if (.not. allocated(error)) call refine(ladder, found, chosen, parts, error)
    end subroutine climb_all

    !> The estimates of all probes in all commands.
    function error_bars(ladder, finest, errors) result(bars)
        type(ladder_t), intent(in) :: ladder
        integer, intent(in) :: finest               !! rung
        real(wp), intent(in) :: errors(:)           !! of the channels, for the strictest accuracy [-]
        type(error_bar_t), allocatable :: bars(:)
        real(wp) :: relative
        integer :: i

        allocate (bars(size(errors)))
        do i = 1, size(bars)
            associate (channel => ladder%trials(finest)%channels(i))
                relative = errors(i)*ladder%problem%tasks(channel%task)%aim/ladder%accuracy
                bars(i) = error_bar_t(channel%task, channel%probe, relative, &
                    relative*max(channel%course%size_of(), ladder%least_size(i)))
            end associate
        end do
    end function error_bars

    !> Say what was chosen, what it is worth, and what was left out and why.
    subroutine explain(ladder, found, tuning)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(in) :: found
        type(tuning_t), intent(in) :: tuning
        type(setting_t) :: fuller
        character(:), allocatable :: text
        type(line_t), allocatable :: lines(:)
        logical, allocatable :: given(:)
        integer, allocatable :: inertias(:)
        integer :: i

        fuller = tuning%chosen
        fuller%inertia = inertia_full
        lines = mesh_pieces(ladder%pieces, tuning%chosen%elements, tuning%chosen%nodes)
        associate (sections => ladder%problem%model%sections(ladder%problem%model%mesh%section))
            given = sections%inertia_is_given
            inertias = sections%inertia
        end associate
        associate (chosen => tuning%chosen, log => ladder%log)
            text = '  chosen: ' // to_text(chosen%n_elements()) // ' elements of ' // to_text(chosen%nodes) &
                // ' nodes, rule gauss with ' // to_text(chosen%points) // ' points'
            if (has_transients(ladder%problem)) text = text // ', inertia ' &
                // trim(inertia_names(chosen%inertia)) // ', ' // trim(chosen%scheme)
            text = text // ', ' // to_text(chosen%n_steps()) &
                // trim(merge(' step ', ' steps', chosen%n_steps() == 1))
            if (chosen%local > 0.0_wp) text = text // ' about, adaptive with accuracy ' &
                // exact_text(chosen%local)
            call log%line(text)
            if (count(ladder%problem%tasks%is_auto) > 1) then
                text = ''
                do i = 1, size(chosen%steps)
                    if (ladder%problem%tasks(i)%is_auto) text = text // ', ' // to_text(chosen%steps(i)) &
                        // ' of ' // ladder%problem%tasks(i)%name
                end do
                call log%line('  steps ' // text(3:))
            end if
            if (size(chosen%elements) > 1 .or. any(abs(lines%grading - 1.0_wp) > 0.0_wp)) then
                text = ''
                do i = 1, size(lines)
                    text = text // ', ' // to_text(lines(i)%elements) // ' to x = ' // exact_text(lines(i)%to)
                    if (abs(lines(i)%grading - 1.0_wp) > 0.0_wp) text = text // ' with grading ' &
                        // exact_text(lines(i)%grading)
                end do
                call log%line('  elements ' // text(3:))
            end if
            if (has_transients(ladder%problem) .and. any(given) .and. .not. all(given .and. inertias &
                == chosen%inertia)) call log%line('  inertia as SECTION gives it, ' &
                // trim(inertia_names(chosen%inertia)) // ' where it is left open')
            text = '  estimated error ' // to_text(tuning%estimate, 2) // ' of ' &
                // to_text(tuning%accuracy, 2) // ' asked for'
            do i = 1, n_sources
                if (tuning%parts(i) > 0.0_wp) text = text // ', ' // trim(source_names(i)) // ' ' &
                    // to_text(tuning%parts(i), 2)
            end do
            call log%line(text)
            if (found%thicker > 0 .and. chosen%points < most_points) call log%line('  left out: more Gauss ' &
                // 'points through the thickness (one more changes the probes by ' &
                // to_text(found%thickness, 2) // ')')
            if (found%fuller > 0 .and. chosen%inertia /= inertia_full) call log%line('  left out: ' &
                // 'inertia=full (changes the probes by ' // to_text(found%inertia, 2) &
                // ', and costs ' // to_text(work_of(fuller)/work_of(chosen), 2) // ' times as much)')
            if (has_transients(ladder%problem) .and. chosen%local <= 0.0_wp) call log%line('  left out: ' &
                // 'adaptive steps (fixed ones are ' &
                // to_text(ladder%unevenness(found%time(1)), 2) // ' times as many at equal error, with ' &
                // to_text(ladder%effort(found%time(size(found%time))), 2) // ' iterations in place of ' &
                // to_text(adaptive_effort, 2) // ' each)')
            if (has_transients(ladder%problem) .and. found%fuller == 0 .and. .not. found%keeps_inertia) &
                call log%line('  inertia=full ' &
                // 'comes to no end in this scene: what it would change is not part of the estimate')
            associate (last => tuning%rungs(size(tuning%rungs)))
                call log%line('  tried ' // to_text(size(tuning%rungs)) // ' settings in ' &
                    // to_text(sum(tuning%rungs%cpu_seconds), 3) // ' s CPU; the run will take about ' &
                    // to_text(last%cpu_seconds*work_of(chosen)/last%work, 2) // ' s')
            end associate
        end associate

    contains

        pure real(wp) function work_of(setting)
            type(setting_t), intent(in) :: setting

            work_of = work_of_iteration(setting, ladder%has_block)*real(setting%n_steps(), wp) &
                *ladder%effort(found%time(size(found%time)))
        end function work_of

    end subroutine explain

end module gb_tune
