!> Refines whichever of mesh and step holds a prediction up, until a setting can be chosen that is good
!> enough.
module gb_refine
    use gb_kinds, only: wp
    use gb_convergence, only: axis_t
    use gb_error, only: error_t, raise, status_solution
    use gb_findings, only: findings_t, set_elements, climb_finer, climb_in_time, learn_axes, &
        learn_forecast, has_transients, most_elements, most_steps
    use gb_ladder, only: ladder_t
    use gb_pieces, only: least_density
    use gb_section, only: inertia_full
    use gb_text, only: to_text
    use gb_trial, only: work_of_iteration
    use gb_tuning, only: setting_t, n_sources, source_mesh, source_time, source_thickness, source_inertia
    implicit none
    private

    !> Part of the accuracy that is used: predictions may be a little off.
    real(wp), parameter :: used_part = 0.9_wp
    !> Numbers of steps that are looked at grow by this factor.
    real(wp), parameter :: step_growth = 1.08_wp
    !> From one trial of the steps to the next they grow by these factors: no more than twofold, since orders
    !> show best in even steps, and the last trial should not go far beyond what is needed.
    real(wp), parameter :: least_growth = 1.4_wp, most_growth = 2.0_wp, surplus = 1.1_wp
    !> A further trial is worthwhile if the work with it seems to be this part of that without it.
    real(wp), parameter :: worthwhile_part = 0.7_wp
    !> Part of the mesh's error that a further trial is hoped to leave at the last level: three-node elements
    !> mostly converge faster than is believed of them.
    real(wp), parameter :: hoped_part = 0.5_wp
    !> Iterations of an adaptive step: three solutions, and some are repeated. Three trials are needed to
    !> weigh them, about as dear as the run that they lead to on its finer mesh: they must promise that much.
    real(wp), parameter :: adaptive_effort = 7.0_wp, promising_ratio = 2.0_wp, first_local = 1.0e-3_wp

    public :: refine, adaptive_effort

contains

    !> Refine whichever of mesh and step holds the prediction up, until a setting is good enough; choose the
    !> cheapest.
    subroutine refine(ladder, found, chosen, parts, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        type(setting_t), intent(out) :: chosen
        real(wp), intent(out) :: parts(n_sources)
        type(error_t), allocatable, intent(out) :: error
        integer :: number
        real(wp) :: growth
        logical :: is_chosen

        if (has_transients(ladder%problem)) call weigh_adaptive_steps(ladder, found, error)
        if (allocated(error)) return
        call learn_axes(ladder, found)
        do
            call choose(ladder, found, chosen, parts, growth, is_chosen)
            if (is_chosen) return
            if (growth > 0.0_wp) then
                if (growth*found%steps(size(found%steps))*real(found%base%n_steps(), wp) > most_steps) exit
                call climb_in_time(ladder, found, growth, number, error)
            else
                associate (levels => size(found%mesh))
                    if (found%n*2.0_wp**levels > most_elements) exit
                    call climb_finer(ladder, found, 2**levels, 1.0_wp, found%mesh(levels), number, error)
                    found%mesh = [found%mesh, number]
                end associate
            end if
            if (allocated(error)) return
            if (ladder%has_failed(number)) then
                call raise(error, status_solution, 'a finer trial failed: ' // ladder%rungs(number)%failure)
                return
            end if
            call learn_axes(ladder, found)
        end do
        call raise(error, status_solution, 'accuracy=' // to_text(ladder%accuracy) &
            // ' is out of reach: with ' // to_text(ladder%rungs(found%mesh(size(found%mesh)))% &
            setting%n_elements()) // ' elements and ' &
            // to_text(ladder%rungs(found%time(size(found%time)))%setting%n_steps()) &
            // ' steps the estimates are ' // to_text(found%mesh_axis%error(size(found%mesh)), 3) &
            // ' for the mesh and ' // to_text(found%time_axis%error(size(found%time)), 3) &
            // ' for the steps')
    end subroutine refine

    !> Adaptive steps in place of fixed ones, where the motion is so uneven that they seem to pay: three rungs
    !> of them tell.
    subroutine weigh_adaptive_steps(ladder, found, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        type(error_t), allocatable, intent(out) :: error
        type(findings_t) :: other
        real(wp) :: aim
        integer :: number, last, i

        last = found%time(size(found%time))
        if (ladder%unevenness(found%time(1))*ladder%effort(last) < promising_ratio*adaptive_effort) return
        other = found
        other%base%local = first_local
        call ladder%climb(other%base, 'adaptive', last, number, error)
        if (allocated(error)) return
        other%base%local = 0.0_wp
        other%time = [number]
        other%steps = [real(ladder%trials(number)%steps, wp)/real(found%base%n_steps(), wp)]
        other%local = [first_local]
        do i = 1, 2
            if (ladder%has_failed(number)) return
            call climb_in_time(ladder, other, 2.0_wp, number, error)
            if (allocated(error)) return
        end do
        if (ladder%has_failed(number) .or. any(other%steps(2:) <= other%steps(:2))) return
        call learn_axes(ladder, other)
        ! At an error that both ladders know something about.
        aim = min(other%time_axis%error(3), found%time_axis%error(size(found%time)))
        if (work_for(other) < work_for(found)) found = other

    contains

        !> Iterations for that error, if every step takes as many as in a ladder's finest trial.
        real(wp) function work_for(findings)
            type(findings_t), intent(in) :: findings

            work_for = steps_for(findings%time_axis, aim)*ladder%effort(findings%time(size(findings%time)))
        end function work_for

    end subroutine weigh_adaptive_steps

    !> Steps for an error, by the order reckoned with.
    pure real(wp) function steps_for(axis, error) result(steps)
        type(axis_t), intent(in) :: axis
        real(wp), intent(in) :: error

        associate (n => size(axis%size))
            steps = axis%size(n)*(axis%error(n)/error)**(1.0_wp/axis%order)
        end associate
    end function steps_for

    !> The cheapest setting that is good enough. Where none is within reach, or a cheaper one seems to lie
    !> beyond it that is worth a further trial: by how much the steps are to grow for that; 0 where the mesh
    !> is to.
    subroutine choose(ladder, found, chosen, parts, growth, is_chosen)
        type(ladder_t), intent(in) :: ladder
        type(findings_t), intent(inout) :: found
        type(setting_t), intent(out) :: chosen
        real(wp), intent(out) :: parts(n_sources)   !! errors of the choice, by source [-]
        real(wp), intent(out) :: growth
        logical, intent(out) :: is_chosen
        type(setting_t) :: finer, longer
        type(findings_t) :: hoped
        real(wp) :: other_parts(n_sources), work, work_finer, work_longer, reach
        logical :: has_order

        call learn_forecast(ladder, found)
        growth = 0.0_wp
        associate (n => found%mesh_axis%largest_size(), steps => found%time_axis%largest_size())
            reach = steps
            call choose_within(ladder, found, n, steps, chosen, parts, work)
            hoped = found
            hoped%mesh_axis%error = hoped%mesh_axis%error &
                - (1.0_wp - hoped_part)*hoped%mesh_axis%error(size(found%mesh))
            call choose_within(ladder, hoped, 2.0_wp*n, most_steps, finer, other_parts, work_finer)
            call choose_within(ladder, found, n, most_steps, longer, other_parts, work_longer)
        end associate
        if (work_finer < huge(work_finer)) work_finer = work_finer + work_of_longer_rung(finer) &
            + work_of_rung(2.0_wp**size(found%mesh), 1.0_wp, found%mesh(1))
        if (work_longer < huge(work_longer)) then
            growth = growth_for(longer)
            work_longer = work_longer + work_of_longer_rung(longer)
        end if
        is_chosen = work < huge(work) .and. work <= min(work_finer, work_longer)/worthwhile_part
        ! A mesh is weighed when the steps that it would be run with are known, by an order that was seen.
        has_order = size(found%time) > 2 .or. work_longer >= huge(work_longer)
        if (work_finer < work_longer .and. has_order .or. .not. has_transients(ladder%problem)) &
            growth = 0.0_wp

    contains

        !> By how much the steps are to grow to bring a setting into reach.
        real(wp) function growth_for(setting)
            type(setting_t), intent(in) :: setting

            growth_for = min(most_growth, max(least_growth, surplus*real(setting%n_steps(), wp)/reach))
        end function growth_for

        !> Work of the trial that brings a setting into reach, if it is not.
        real(wp) function work_of_longer_rung(setting)
            type(setting_t), intent(in) :: setting

            work_of_longer_rung = 0.0_wp
            if (real(setting%n_steps(), wp) > reach) work_of_longer_rung &
                = work_of_rung(1.0_wp, growth_for(setting)*found%steps(size(found%steps)), &
                found%time(size(found%time)))
        end function work_of_longer_rung

        !> Work of a further trial: so many times the elements and steps of the base, with another's effort.
        real(wp) function work_of_rung(elements, steps, other)
            real(wp), intent(in) :: elements, steps
            integer, intent(in) :: other            !! rung

            work_of_rung = elements*work_of_iteration(found%base, ladder%has_block)*steps &
                *real(found%base%n_steps(), wp)*ladder%effort(other)
        end function work_of_rung

    end subroutine choose

    !> The cheapest setting of so many elements and steps at most whose forecast is below the accuracy.
    subroutine choose_within(ladder, found, most_n, most, chosen, parts, work)
        type(ladder_t), intent(in) :: ladder
        type(findings_t), intent(in) :: found
        real(wp), intent(in) :: most_n              !! elements, as their density has it
        real(wp), intent(in) :: most                !! steps
        type(setting_t), intent(out) :: chosen
        real(wp), intent(out) :: parts(n_sources)   !! errors of the choice, by source [-]
        real(wp), intent(out) :: work               !! in iterations; huge where there is none
        type(setting_t) :: setting
        real(wp) :: n, density

        parts = 0.0_wp
        work = huge(work)
        setting = found%base
        setting%points = found%points
        n = found%n
        do
            call set_elements(ladder, n, setting)
            density = least_density(ladder%pieces, setting%elements)
            if (density > most_n) exit
            setting%inertia = found%base%inertia
            call choose_steps(ladder, found, density, setting, most, work, chosen, parts)
            if (found%fuller > 0) then
                setting%inertia = inertia_full
                call choose_steps(ladder, found, density, setting, most, work, chosen, parts)
            end if
            n = max(n + 1.0_wp, step_growth*n)
        end do
    end subroutine choose_within

    !> The fewest steps with which a mesh and an inertia are good enough, if that is the cheapest so far.
    subroutine choose_steps(ladder, found, n, setting, most, least_cost, chosen, parts)
        type(ladder_t), intent(in) :: ladder
        type(findings_t), intent(in) :: found
        real(wp), intent(in) :: n                   !! elements, as their density has it
        type(setting_t), intent(in) :: setting
        real(wp), intent(in) :: most                !! steps
        real(wp), intent(inout) :: least_cost
        type(setting_t), intent(inout) :: chosen
        real(wp), intent(inout) :: parts(n_sources)
        real(wp) :: sizes(n_sources), first, steps, cost, effort

        effort = ladder%effort(found%time(size(found%time)))
        sizes(source_mesh) = found%mesh_axis%error_at(n)
        sizes(source_thickness) = found%thickness
        sizes(source_inertia) = merge(found%inertia, 0.0_wp, setting%inertia /= inertia_full)
        sizes(source_time) = 0.0_wp
        first = real(found%base%n_steps(), wp)
        steps = first
        if (has_transients(ladder%problem)) steps = found%time_axis%size(1)
        do while (steps <= most)
            cost = work_of_iteration(setting, ladder%has_block)*steps*effort
            if (cost >= least_cost) return
            if (has_transients(ladder%problem)) sizes(source_time) = found%time_axis%error_at(steps)
            if (found%forecast%largest(sizes) <= used_part*ladder%accuracy) then
                least_cost = cost
                chosen = setting
                chosen%steps = ceiling(found%base%steps*(steps/first))
                chosen%local = local_error_for(found, steps)
                parts = sizes
                return
            end if
            steps = step_growth*steps
        end do
    end subroutine choose_steps

    !> The local error that makes adaptive steps so many; 0 where steps are fixed. Between trials it is a
    !> power of their steps (the finer ones may see small vibrations that the others do not, so that it is not
    !> the third one throughout); beyond the last trial the third power.
    pure real(wp) function local_error_for(found, steps) result(local)
        type(findings_t), intent(in) :: found
        real(wp), intent(in) :: steps
        integer :: k

        associate (n => size(found%local), size_of => found%time_axis%size)
            local = found%local(n)*(size_of(n)/steps)**3
            if (found%local(n) <= 0.0_wp .or. steps >= size_of(n)) return
            k = 1
            do while (steps > size_of(k + 1))
                k = k + 1
            end do
            local = found%local(k)*(found%local(k + 1)/found%local(k))**(log(steps/size_of(k)) &
                /log(size_of(k + 1)/size_of(k)))
        end associate
    end function local_error_for

end module gb_refine
