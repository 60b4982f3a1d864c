!> What richer models would change: one more point through the thickness, the full kinetic energy.
module gb_weigh
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
    use gb_findings, only: findings_t, has_transients
    use gb_ladder, only: ladder_t
    use gb_section, only: inertia_full
    use gb_tuning, only: setting_t, source_thickness, source_inertia, source_names
    implicit none
    private

    !> Part of the accuracy that the next better thickness rule may be left out for, and inertia at most (it
    !> costs so much that a finer mesh and step may be the better choice).
    real(wp), parameter :: thickness_part = 0.2_wp, inertia_part = 0.8_wp
    integer, parameter, public :: most_points = 10

    public :: look_at_thickness, look_at_inertia

contains

    !> Gauss points through the thickness: three, or as many as it takes until one more changes little.
    subroutine look_at_thickness(ladder, found, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        type(error_t), allocatable, intent(out) :: error
        type(setting_t) :: simpler, richer

        simpler = found%base
        richer = found%base
        do
            richer%points = simpler%points + 1
            call weigh(ladder, found, richer, simpler, source_thickness, thickness_part, found%thinner, &
                found%thicker, found%thickness, error)
            if (allocated(error)) return
            if (found%thickness <= thickness_part*ladder%accuracy .or. richer%points == most_points) exit
            simpler%points = richer%points
        end do
        found%points = simpler%points
        if (found%thickness > thickness_part*ladder%accuracy) call raise(error, status_solution, &
            'no rule for the thickness comes below accuracy=')
    end subroutine look_at_thickness

    !> What the full kinetic energy would change, unless the deck says which inertia is to be taken.
    subroutine look_at_inertia(ladder, found, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(inout) :: found
        type(error_t), allocatable, intent(out) :: error
        type(setting_t) :: setting

        if (.not. has_transients(ladder%problem) .or. found%keeps_inertia) return
        setting = found%base
        setting%inertia = inertia_full
        call weigh(ladder, found, setting, found%base, source_inertia, inertia_part, found%lighter, &
            found%fuller, found%inertia, error)
    end subroutine look_at_inertia

    !> What a richer model changes, compared with a simpler one on the same mesh with the same steps. What
    !> seems too much may be an error of coarse steps: when shorter ones do not shrink it, it is believed.
    subroutine weigh(ladder, found, richer, simpler, source, part, from, to, change, error)
        type(ladder_t), intent(inout) :: ladder
        type(findings_t), intent(in) :: found
        type(setting_t), intent(in) :: richer, simpler
        integer, intent(in) :: source
        real(wp), intent(in) :: part                !! of the accuracy that may be left out [-]
        integer, intent(out) :: from, to            !! the rungs compared
        real(wp), intent(out) :: change             !! [-]
        type(error_t), allocatable, intent(out) :: error
        real(wp), parameter :: shrinking = 0.6_wp
        real(wp) :: before
        integer :: level

        change = huge(change)
        do level = 1, size(found%time)
            before = change
            call climb_with_steps(simpler, 0, from)
            if (.not. allocated(error)) call climb_with_steps(richer, from, to)
            if (allocated(error)) return
            if (ladder%has_failed(from) .or. ladder%has_failed(to)) cycle
            change = ladder%change(from, to)
            if (change <= part*ladder%accuracy .or. change > shrinking*before) exit
        end do
        ! A richer model that never comes to its end cannot be compared with, nor chosen.
        if (ladder%has_failed(from) .or. ladder%has_failed(to)) then
            to = 0
            change = 0.0_wp
        end if

    contains

        subroutine climb_with_steps(setting, compared_with, number)
            type(setting_t), intent(in) :: setting
            integer, intent(in) :: compared_with
            integer, intent(out) :: number
            type(setting_t) :: stepped

            stepped = setting
            stepped%steps = found%base%steps*2**(level - 1)
            call ladder%climb(stepped, trim(source_names(source)), compared_with, number, error)
        end subroutine climb_with_steps

    end subroutine weigh

end module gb_weigh
