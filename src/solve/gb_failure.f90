!> Sentences for a step that could not be solved: when, where, why, and what to try.
module gb_failure
    use gb_kinds, only: wp
    use gb_text, only: to_text
    use gb_fields, only: n_fields, field_names
    use gb_section, only: unlimited_jm
    use gb_newton, only: newton_report_t, newton_inadmissible, newton_singular, newton_slow, newton_diverged
    use gb_system, only: system_t, worst_point_t
    implicit none
    private

    public :: failure_reason, place_of_worst

    integer, parameter :: max_place = 250, max_reason = 400     !! characters

contains

    !> Why Newton's method gave up, at the state u it had reached; padded with blanks.
    function failure_reason(system, report, u, x) result(text)
        type(system_t), intent(in) :: system
        type(newton_report_t), intent(in) :: report
        real(wp), intent(in) :: u(:)
        real(wp), intent(in) :: x(:)            !! X1 of the nodes [L]
        character(max_reason) :: text
        integer :: node

        select case (report%outcome)
        case (newton_inadmissible)
            text = 'no admissible state along the search direction; ' // place_of_worst(system, &
                report%rejected)
        case (newton_singular)
            node = 1 + (report%singular_unknown - 1)/n_fields
            text = 'the tangent is singular: ' &
                   // field_names(1 + modulo(report%singular_unknown - 1, n_fields)) // ' at x = ' &
                   // to_text(x(node)) // ' (node ' // to_text(node) &
                   // ') has no stiffness; a support is missing there, or the load is critical'
        case (newton_slow)
            text = 'Newton''s method did not converge in ' // to_text(size(report%increments)) &
                   // ' iterations (last increment ' // to_text(last_increment(report), 3) // '); ' &
                   // place_of_worst(system, u)
        case (newton_diverged)
            text = 'Newton''s method diverged (increments beyond all measure); ' // place_of_worst(system, u)
        case default
            text = 'the line search found no decrease; ' // place_of_worst(system, u)
        end select
    end function failure_reason

    pure real(wp) function last_increment(report)
        type(newton_report_t), intent(in) :: report

        last_increment = 0.0_wp
        if (size(report%increments) > 0) last_increment = report%increments(size(report%increments))
    end function last_increment

    !> "worst at element 3, integration point 2, X3 = 0.4: J = 0.02, I1-2 = 1.9 of Jm = 2".
    function place_of_worst(system, u) result(text)
        type(system_t), intent(in) :: system
        real(wp), intent(in) :: u(:)
        character(max_place) :: text
        type(worst_point_t) :: worst

        worst = system%worst_point(u)
        text = 'worst at element ' // to_text(worst%element) // ', integration point ' &
            // to_text(worst%point) // ', X3 = ' // to_text(worst%height) // ': J = ' // to_text(worst%j) &
            // ', I1-2 = ' // to_text(worst%i1_minus_2)
        if (worst%jm < unlimited_jm) text = trim(text) // ' of Jm = ' // to_text(worst%jm)
    end function place_of_worst

end module gb_failure
