!> What the trials of a scene have shown so far, and how further ones are made from the base setting.
module gb_findings
    use gb_kinds, only: wp
    use gb_convergence, only: axis_t
    use gb_error, only: error_t
    use gb_forecast, only: forecast_t
    use gb_ladder, only: ladder_t
    use gb_pieces, only: spread_elements, least_density
    use gb_problem, only: problem_t, task_transient
    use gb_tuning, only: setting_t, n_sources, source_mesh, source_time, source_thickness, source_inertia, &
        source_names
    implicit none
    private

    !> The rungs that the choice rests on.
    type, public :: findings_t
        type(setting_t) :: base                     !! what mesh and step are refined from
        real(wp) :: n = 0.0_wp                      !! elements asked for at the base
        integer, allocatable :: mesh(:)             !! rungs, each with twice the elements of the one before
        integer, allocatable :: time(:)             !! rungs with growing steps
        real(wp), allocatable :: steps(:)           !! of these, over those of the base [-]
        real(wp), allocatable :: local(:)           !! their local errors where steps are adaptive [-]; or 0
        integer :: points = 3                       !! Gauss points through the thickness that are needed
        integer :: thinner = 0, thicker = 0         !! rungs with these points, and with one more
        logical :: keeps_inertia = .false.          !! the deck says which
        integer :: lighter = 0, fuller = 0          !! rungs with diagonal and with full inertia
        real(wp) :: thickness = 0.0_wp, inertia = 0.0_wp    !! errors where these are left out [-]
        type(axis_t) :: mesh_axis, time_axis
        type(forecast_t) :: forecast
    end type findings_t

    !> No scene is followed further.
    real(wp), parameter, public :: most_elements = 2.0e4_wp, most_steps = 5.0e6_wp

    public :: set_elements, climb_finer, climb_in_time, learn_axes, learn_forecast, has_transients

contains

    subroutine set_elements(ladder, number, setting)
        type(ladder_t), intent(in) :: ladder
        real(wp), intent(in) :: number
        type(setting_t), intent(inout) :: setting

        setting%elements = spread_elements(ladder%pieces, number)
    end subroutine set_elements

    !> The base setting with so many times the elements and the steps.
    subroutine climb_finer(ladder, found, elements, steps, compared_with, number, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(in) :: found
        integer, intent(in) :: elements
        real(wp), intent(in) :: steps
        integer, intent(in) :: compared_with
        integer, intent(out) :: number
        type(error_t), allocatable, intent(out) :: error
        type(setting_t) :: setting

        setting = found%base
        call set_elements(ladder, found%n*real(elements, wp), setting)
        setting%steps = nint(steps*found%base%steps)
        call ladder%climb(setting, trim(source_names(merge(source_mesh, source_time, elements > 1))), &
            compared_with, number, error)
    end subroutine climb_finer

    !> One more rung of the steps: so many times as many as the last one has. Adaptive steps are as many as
    !> their local error asks for, which goes with their third power.
    subroutine climb_in_time(ladder, found, growth, number, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        real(wp), intent(in) :: growth
        integer, intent(out) :: number
        type(error_t), allocatable, intent(out) :: error
        type(setting_t) :: setting
        real(wp) :: steps

        associate (last => size(found%time))
            setting = found%base
            setting%local = found%local(last)/growth**3
            steps = found%steps(last)*growth
            if (setting%local <= 0.0_wp) setting%steps = nint(steps*found%base%steps)
            call ladder%climb(setting, trim(source_names(source_time)), found%time(last), number, error)
        end associate
        if (allocated(error)) return
        if (setting%local > 0.0_wp) steps = real(ladder%trials(number)%steps, wp) &
            /real(found%base%n_steps(), wp)
        found%time = [found%time, number]
        found%steps = [found%steps, steps]
        found%local = [found%local, setting%local]
    end subroutine climb_in_time

    subroutine learn_axes(ladder, found)
        type(ladder_t), intent(in) :: ladder
        type(findings_t), intent(inout) :: found
        integer :: i

        found%mesh_axis%lowest_order = 1.0_wp
        found%mesh_axis%highest_order = 1.5_wp
        found%mesh_axis%first_order = 1.5_wp
        found%mesh_axis%reach = 1.3_wp
        call learn_axis(ladder, found%mesh, [(least_density(ladder%pieces, &
            ladder%rungs(found%mesh(i))%setting%elements), i=1, size(found%mesh))], found%mesh_axis)
        found%time_axis%lowest_order = 0.6_wp
        found%time_axis%highest_order = 2.0_wp
        found%time_axis%first_order = 0.6_wp
        found%time_axis%reach = 3.0_wp
        call learn_axis(ladder, found%time, found%steps*real(found%base%n_steps(), wp), found%time_axis)
    end subroutine learn_axes

    subroutine learn_axis(ladder, rungs, sizes, axis)
        type(ladder_t), intent(in) :: ladder
        integer, intent(in) :: rungs(:)
        real(wp), intent(in) :: sizes(:)            !! of the rungs
        type(axis_t), intent(inout) :: axis
        real(wp) :: differences(size(rungs) - 1), to_last(size(rungs))
        integer :: k

        associate (n => size(rungs))
            differences = [(ladder%change(rungs(k), rungs(k + 1)), k=1, n - 1)]
            to_last = [(ladder%change(rungs(k), rungs(n)), k=1, n)]
        end associate
        call axis%learn(sizes, differences, to_last)
    end subroutine learn_axis

    !> Shapes of the errors: from the finest pairs of rungs.
    subroutine learn_forecast(ladder, found)
        type(ladder_t), intent(in) :: ladder
        type(findings_t), intent(inout) :: found
        integer :: rungs(2, n_sources)

        associate (m => size(found%mesh), t => size(found%time))
            rungs(:, source_mesh) = found%mesh([m - 1, m])
            rungs(:, source_time) = found%time([t - 1, t])
        end associate
        rungs(:, source_thickness) = [found%thinner, found%thicker]
        rungs(:, source_inertia) = [found%lighter, found%fuller]
        call found%forecast%learn(ladder, rungs)
    end subroutine learn_forecast

    pure logical function has_transients(problem)
        type(problem_t), intent(in) :: problem

        has_transients = any(problem%tasks%is_auto .and. problem%tasks%kind == task_transient)
    end function has_transients

end module gb_findings
