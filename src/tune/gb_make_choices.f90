!> What a deck leaves to the program is decided before anything is run: mesh and steps of `auto` commands, and
!> the points of sections with rule=auto. The choice depends on the deck alone, so that a run that goes on
!> from a checkpoint makes the same one.
module gb_make_choices
    use gb_kinds, only: wp
    use gb_error, only: error_t, status_interrupted
    use gb_choose_points, only: choose_points
    use gb_log, only: log_t
    use gb_problem, only: problem_t
    use gb_signals, only: caught_signal
    use gb_text, only: to_text
    use gb_tune, only: tune
    implicit none
    private

    public :: make_choices

contains

    !> Decide, and put the decisions into the problem. Without open questions nothing happens.
    subroutine make_choices(problem, log, deadline, error)
        type(problem_t), intent(inout) :: problem
        type(log_t), intent(inout) :: log
        real(wp), intent(in) :: deadline            !! CPU time at which to stop [s]; 0: none
        type(error_t), allocatable, intent(out) :: error

        if (problem%has_auto()) then
            call tune(problem, log, deadline, error)
        else if (any(problem%model%sections%is_auto)) then
            call choose_points(problem, deadline, error)
            if (.not. allocated(error)) call tell_points()
        end if
        if (.not. allocated(error)) return
        if (error%status /= status_interrupted) return
        error%message = caught_signal()
        if (len(error%message) == 0) error%message = '--max-time'
        error%message = error%message // ': stopped while choosing a model: nothing has been computed yet'

    contains

        subroutine tell_points()
            associate (points => problem%model%sections(problem%model%mesh%section)%points)
                if (minval(points) == maxval(points)) then
                    call log%line('  rule=auto: ' // to_text(points(1)) &
                        // ' points through the thickness of every element')
                else
                    call log%line('  rule=auto: ' // to_text(minval(points)) // ' to ' &
                        // to_text(maxval(points)) // ' points through the thickness, ' &
                        // to_text(real(sum(points), wp)/real(size(points), wp), 3) // ' on average')
                end if
            end associate
        end subroutine tell_points

    end subroutine make_choices

end module gb_make_choices
