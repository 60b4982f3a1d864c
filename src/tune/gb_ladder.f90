!> Trials of one scene, remembered: what was tried is not tried again, and any two can be compared.
module gb_ladder
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_course, only: distance
    use gb_fields, only: field_length_power
    use gb_log, only: log_t
    use gb_pieces, only: piece_t, cut_into_pieces
    use gb_problem, only: problem_t, task_static
    use gb_section, only: inertia_names
    use gb_text, only: to_text
    use gb_trial, only: trial_t, try_setting, apply_setting, work_of_iteration
    use gb_tuning, only: setting_t, rung_t
    implicit none
    private

    type, public :: ladder_t
        type(problem_t) :: problem                  !! as the deck has it
        type(piece_t), allocatable :: pieces(:)
        real(wp) :: accuracy = 0.0_wp               !! the strictest asked for [-]
        real(wp) :: tolerance = 0.0_wp              !! of Newton's method in the commands that are tuned [-]
        real(wp) :: deadline = 0.0_wp               !! CPU time at which to stop [s]; 0: none
        logical :: has_block = .true.               !! whether the block solver takes the scene at all
        type(log_t) :: log
        type(rung_t), allocatable :: rungs(:)
        type(trial_t), allocatable :: trials(:)     !! of the rungs (at least as many)
        real(wp), allocatable :: least_size(:)      !! of the channels: what is smaller is nothing
    contains
        procedure :: begin
        procedure :: climb
        procedure :: has_failed
        procedure :: change
        procedure :: changes
        procedure :: unevenness
        procedure :: effort
        procedure, private :: report
    end type ladder_t

    !> Probes whose values stay below this part of the fields' natural size rest; for velocities and
    !> accelerations, also those below this part of what other nodes have.
    real(wp), parameter :: resting_part = 1.0e-9_wp
    !> Trials that there is room for to begin with; it doubles.
    integer, parameter :: first_room = 32
    !> Newton's method needs no more than this part of the accuracy: what it leaves adds up over the steps,
    !> but its last increment is mostly far above that.
    real(wp), parameter :: newton_part = 1.0e-4_wp, loosest_tolerance = 1.0e-6_wp, &
        tightest_tolerance = 1.0e-10_wp

contains

    subroutine begin(self, problem, log, deadline)
        class(ladder_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        type(log_t), intent(in) :: log
        real(wp), intent(in) :: deadline            !! CPU time at which to stop [s]; 0: none

        self%problem = problem
        self%pieces = cut_into_pieces(problem%model, places_of_probes(problem))
        self%accuracy = minval(problem%tasks%aim, mask=problem%tasks%is_auto)
        self%tolerance = max(tightest_tolerance, min(loosest_tolerance, newton_part*self%accuracy))
        self%deadline = deadline
        self%has_block = problem%model%damping%stiffness <= 0.0_wp
        self%log = log
        allocate (self%rungs(0), self%trials(first_room))
        call self%log%line('    rung  elements   steps  points  inertia           change')
    end subroutine begin

    !> Where the probes stand that must be accurate [L].
    pure function places_of_probes(problem) result(places)
        type(problem_t), intent(in) :: problem
        real(wp), allocatable :: places(:)
        integer :: i

        allocate (places(0))
        do i = 1, size(problem%tasks)
            if (problem%tasks(i)%is_auto) places = [places, problem%probes(problem%tasks(i)%aim_probes)%x]
        end do
    end function places_of_probes

    !> Try a setting, or find it among those that have been tried; `number` is its rung. The reason and the
    !> rung that it is compared with are for the record.
    subroutine climb(self, setting, source, compared_with, number, error)
        class(ladder_t), intent(inout) :: self
        type(setting_t), intent(in) :: setting
        character(*), intent(in) :: source
        integer, intent(in) :: compared_with        !! 0: none
        integer, intent(out) :: number
        type(error_t), allocatable, intent(out) :: error
        type(rung_t) :: rung
        type(trial_t) :: trial

        do number = 1, size(self%rungs)
            if (self%rungs(number)%setting%is_like(setting)) return
        end do
        rung%setting = setting
        rung%source = source
        rung%compared_with = compared_with
        call try_setting(apply_setting(self%problem, self%pieces, setting, self%tolerance), setting, &
            self%has_block, self%deadline, self%log, trial, error)
        if (allocated(error)) return
        rung%steps = trial%steps
        rung%work = trial%work
        rung%cpu_seconds = trial%cpu_seconds
        rung%failure = trial%failure
        self%rungs = [self%rungs, rung]
        if (number > size(self%trials)) self%trials = [self%trials, self%trials]
        self%trials(number) = trial
        if (.not. allocated(self%least_size)) self%least_size = smallest_sizes(self%problem, trial)
        if (compared_with > 0 .and. len(rung%failure) == 0) then
            if (.not. self%has_failed(compared_with)) self%rungs(number)%change = self%change(compared_with, &
                number)
        end if
        call self%report(number)
    end subroutine climb

    !> What the channels' values are at rest below [their units].
    pure function smallest_sizes(problem, trial) result(sizes)
        type(problem_t), intent(in) :: problem
        type(trial_t), intent(in) :: trial
        real(wp), allocatable :: sizes(:)
        integer :: i

        allocate (sizes(size(trial%channels)))
        do i = 1, size(sizes)
            associate (probe => problem%probes(trial%channels(i)%probe), &
                task => problem%tasks(trial%channels(i)%task))
                sizes(i) = resting_part*problem%model%mesh%length()**field_length_power(probe%field)
                if (task%kind == task_static) cycle
                sizes(i) = max(sizes(i)/task%end_time**probe%quantity, &
                    resting_part*trial%channels(i)%largest &
                    *problem%model%mesh%length()**(field_length_power(probe%field) - 1))
            end associate
        end do
    end function smallest_sizes

    pure logical function has_failed(self, number)
        class(ladder_t), intent(in) :: self
        integer, intent(in) :: number

        has_failed = len(self%rungs(number)%failure) > 0
    end function has_failed

    !> The largest change from one rung to another, relative to the second; a command that asks for less
    !> accuracy counts for less.
    pure real(wp) function change(self, from, to)
        class(ladder_t), intent(in) :: self
        integer, intent(in) :: from, to

        change = maxval(self%changes(from, to))
    end function change

    !> The same of every channel.
    pure function changes(self, from, to)
        class(ladder_t), intent(in) :: self
        integer, intent(in) :: from, to
        real(wp), allocatable :: changes(:)
        integer :: i

        allocate (changes(size(self%least_size)))
        do i = 1, size(changes)
            associate (first => self%trials(from)%channels(i), second => self%trials(to)%channels(i))
                changes(i) = distance(first%course, second%course)/max(second%course%size_of(), &
                    self%least_size(i))*self%accuracy/self%problem%tasks(first%task)%aim
            end associate
        end do
    end function changes

    !> How much fewer steps an adaptive size might take, by the course that has most of it (gb_course) [-].
    pure real(wp) function unevenness(self, number)
        class(ladder_t), intent(in) :: self
        integer, intent(in) :: number
        integer :: i

        unevenness = 1.0_wp
        do i = 1, size(self%trials(number)%channels)
            associate (course => self%trials(number)%channels(i)%course)
                if (.not. course%is_static) unevenness = max(unevenness, course%unevenness())
            end associate
        end do
    end function unevenness

    !> Newton iterations that a rung has taken for each of its steps.
    pure real(wp) function effort(self, number)
        class(ladder_t), intent(in) :: self
        integer, intent(in) :: number

        associate (rung => self%rungs(number))
            effort = rung%work/(work_of_iteration(rung%setting, self%has_block)*real(rung%steps, wp))
        end associate
    end function effort

    subroutine report(self, number)
        class(ladder_t), intent(inout) :: self
        integer, intent(in) :: number
        character(:), allocatable :: text

        associate (rung => self%rungs(number))
            text = column(to_text(number), 8) // column(to_text(rung%setting%n_elements()), 10) &
                // column(to_text(rung%steps), 8) // column(to_text(rung%setting%points), 8) &
                // '  ' // inertia_names(rung%setting%inertia)
            if (len(rung%failure) > 0) then
                text = text // '  failed (' // trim(rung%setting%scheme) // '): ' // rung%failure
            else if (rung%compared_with > 0) then
                text = text // column(to_text(rung%change, 3), 11) // '  ' // trim(rung%source) &
                    // ', from rung ' // to_text(rung%compared_with)
            end if
        end associate
        call self%log%line(text)
    end subroutine report

    !> Right-aligned.
    pure function column(text, width) result(field)
        character(*), intent(in) :: text
        integer, intent(in) :: width
        character(:), allocatable :: field

        field = repeat(' ', max(1, width - len(text))) // text
    end function column

end module gb_ladder
