!> One setting tried: the deck's problem with it, run to its end, and the courses of the probes that matter.
module gb_trial
    use gb_kinds, only: wp
    use gb_error, only: error_t, status_interrupted
    use gb_course, only: course_t
    use gb_fields, only: n_fields
    use gb_log, only: log_t
    use gb_mesh, only: build_mesh
    use gb_pieces, only: piece_t, mesh_pieces
    use gb_pilot, only: pilot_t, run_pilot
    use gb_problem, only: problem_t, task_t, task_static, quantity_displacement, quantity_velocity, &
        quantity_acceleration
    use gb_recorder, only: step_record_t
    use gb_section, only: rule_gauss, inertia_full
    use gb_sensor, only: sensor_t, place_sensor
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_tuning, only: setting_t
    implicit none
    private

    !> What one probe of one command has told.
    type, public :: channel_t
        integer :: task = 0, probe = 0              !! numbers in the problem's lists
        type(course_t) :: course
        real(wp) :: largest = 0.0_wp                !! of the probe's kind of rate, in any node [L/T, L/T^2]
    end type channel_t

    type, public :: trial_t
        type(channel_t), allocatable :: channels(:)
        integer :: steps = 0                        !! of the commands that are tuned
        real(wp) :: work = 0.0_wp                   !! elements times Newton iterations, weighed [-]
        real(wp) :: cpu_seconds = 0.0_wp
        character(:), allocatable :: failure        !! why it came to no end, or empty
    end type trial_t

    !> Follows the probes that matter.
    type, extends(pilot_t) :: follower_t
        type(channel_t), allocatable :: channels(:)
        type(sensor_t), allocatable :: values(:), rates(:)  !! of the channels
        logical, allocatable :: has_rate(:)         !! accelerations have none
        real(wp) :: iterations = 0.0_wp             !! of all commands; steps at rest count too
        type(log_t) :: log                          !! for its progress bar
        integer :: steps = 0                        !! of the commands that are tuned
        real(wp) :: start_energy = 0.0_wp, largest_energy = 0.0_wp, largest_drift = 0.0_wp  !! [F L]
        logical :: is_lost = .false.                !! the energy balance of some command does not hold
    contains
        procedure :: begin_task
        procedure :: record_step
        procedure :: end_task
    end type follower_t

    public :: try_setting, apply_setting, work_of_iteration

    !> Work of an iteration in an element, by its nodes, in units of the block solver's three-node element:
    !> measured (docs/choosing-a-model.md). The block solver takes three nodes.
    real(wp), parameter :: block_work = 1.0_wp, work_of_order(2:5) = [2.0_wp, 4.0_wp, 7.3_wp, 11.9_wp]
    real(wp), parameter :: point_work = 0.03_wp
    !> What full inertia multiplies it by.
    real(wp), parameter :: full_block = 1.3_wp, full_banded = 1.7_wp
    !> A step at rest, for which nothing is solved: what is recorded of it, in iterations.
    real(wp), parameter :: step_at_rest = 0.2_wp
    !> A step that must be halved more often is too long to tell anything.
    integer, parameter :: most_cuts = 3
    !> An energy balance that is off by this part of the largest energy: the scheme has lost its footing.
    real(wp), parameter :: lost_part = 0.5_wp

contains

    !> The deck's problem with a setting in place of its mesh, rules and steps.
    function apply_setting(problem, pieces, setting, tolerance) result(tuned)
        type(problem_t), intent(in) :: problem
        type(piece_t), intent(in) :: pieces(:)
        type(setting_t), intent(in) :: setting
        real(wp), intent(in) :: tolerance           !! of Newton's method in the commands that are tuned
        type(problem_t) :: tuned
        integer :: i

        tuned = problem
        tuned%model%lines = mesh_pieces(pieces, setting%elements, setting%nodes)
        tuned%model%mesh = build_mesh(tuned%model%lines)
        tuned%model%sections%rule = rule_gauss
        tuned%model%sections%is_auto = .false.
        tuned%model%sections%points = setting%points
        where (.not. tuned%model%sections%inertia_is_given) tuned%model%sections%inertia = setting%inertia
        do i = 1, size(tuned%tasks)
            associate (task => tuned%tasks(i))
                if (.not. task%is_auto) cycle
                task%tolerance = tolerance
                if (task%kind == task_static) then
                    task%steps = setting%steps(i)
                else
                    task%scheme = trim(setting%scheme)
                    task%rho = 0.0_wp               ! of bathe
                    task%accuracy = setting%local
                    task%step = 0.0_wp
                    if (setting%local <= 0.0_wp) task%step = task%end_time/real(setting%steps(i), wp)
                end if
            end associate
        end do
    end function apply_setting

    !> Run the problem, which a setting has been applied to. Only what somebody outside wants (to stop) is an
    !> error; a trial that fails says so.
    subroutine try_setting(problem, setting, has_block, deadline, log, trial, error)
        type(problem_t), intent(in) :: problem
        type(setting_t), intent(in) :: setting
        logical, intent(in) :: has_block            !! whether the block solver takes the scene at all
        real(wp), intent(in) :: deadline            !! CPU time at which to stop [s]; 0: none
        type(log_t), intent(in) :: log              !! shows progress
        type(trial_t), intent(out) :: trial
        type(error_t), allocatable, intent(out) :: error
        type(follower_t) :: follower
        type(system_t) :: system
        type(problem_t) :: hasty
        real(wp) :: start, finish
        integer :: i

        call cpu_time(start)
        hasty = problem
        where (hasty%tasks%is_auto) hasty%tasks%cuts = most_cuts
        follower%deadline = deadline
        follower%log = log
        call follower%log%start_bar()
        call open_channels(follower, problem)
        system = build_system(problem%model)
        call run_pilot(hasty, system, follower, error)
        call follower%log%clear_bar()
        call cpu_time(finish)
        trial%cpu_seconds = finish - start
        trial%work = work_of_iteration(setting, has_block)*follower%iterations
        trial%steps = follower%steps
        call move_alloc(follower%channels, trial%channels)
        do i = 1, size(trial%channels)
            call trial%channels(i)%course%close()
        end do
        trial%failure = ''
        if (.not. allocated(error)) then
            if (follower%is_lost) trial%failure = 'the energy balance does not hold'
            return
        end if
        if (error%status == status_interrupted) return
        trial%failure = error%message
        deallocate (error)
    end subroutine try_setting

    !> Work of a Newton iteration.
    pure real(wp) function work_of_iteration(setting, has_block) result(work)
        type(setting_t), intent(in) :: setting
        logical, intent(in) :: has_block            !! whether the block solver takes the scene at all

        real(wp) :: full

        work = work_of_order(setting%nodes)
        full = full_banded
        if (setting%nodes == 3 .and. has_block) then
            work = block_work
            full = full_block
        end if
        if (setting%inertia == inertia_full) work = full*work
        work = work*(1.0_wp + point_work*real(setting%points - 3, wp))*real(setting%n_elements(), wp)
    end function work_of_iteration

    subroutine open_channels(follower, problem)
        type(follower_t), intent(inout) :: follower
        type(problem_t), intent(in) :: problem
        integer :: i, k, n

        n = 0
        do i = 1, size(problem%tasks)
            if (problem%tasks(i)%is_auto) n = n + size(problem%tasks(i)%aim_probes)
        end do
        allocate (follower%channels(n), follower%values(n), follower%rates(n), follower%has_rate(n))
        n = 0
        do i = 1, size(problem%tasks)
            if (.not. problem%tasks(i)%is_auto) cycle
            do k = 1, size(problem%tasks(i)%aim_probes)
                n = n + 1
                associate (channel => follower%channels(n), probe => &
                    problem%probes(problem%tasks(i)%aim_probes(k)))
                    channel%task = i
                    channel%probe = problem%tasks(i)%aim_probes(k)
                    channel%course%is_static = problem%tasks(i)%kind == task_static
                    follower%values(n) = place_sensor(problem%model%mesh, probe)
                    follower%rates(n) = follower%values(n)
                    follower%has_rate(n) = probe%quantity /= quantity_acceleration
                    if (probe%quantity == quantity_displacement) then
                        follower%rates(n)%quantity = quantity_velocity
                    else
                        follower%rates(n)%quantity = quantity_acceleration
                    end if
                end associate
            end do
        end do
    end subroutine open_channels

    subroutine begin_task(self, task, error)
        class(follower_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        self%largest_energy = 0.0_wp
        self%largest_drift = 0.0_wp
    end subroutine begin_task

    subroutine record_step(self, step, state, error)
        class(follower_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: rate, energy
        integer :: i

        call self%check_stop(error)
        if (allocated(error)) return
        if (step%number > 0) self%iterations = self%iterations + max(step_at_rest, real(step%iterations, wp))
        if (step%number > 0 .and. any(self%channels%task == self%task)) self%steps = self%steps + 1
        call self%log%show_bar(step%progress)
        energy = step%kinetic + step%strain - step%external + step%dissipated
        if (step%number == 0) self%start_energy = step%kinetic + step%strain
        self%largest_energy = max(self%largest_energy, abs(step%kinetic), abs(step%strain), &
            abs(step%external))
        self%largest_drift = max(self%largest_drift, abs(energy - self%start_energy))
        do i = 1, size(self%channels)
            associate (channel => self%channels(i))
                if (channel%task /= self%task) cycle
                rate = 0.0_wp
                if (self%has_rate(i)) rate = self%rates(i)%reading(state)
                call channel%course%add(step%abscissa, self%values(i)%reading(state), rate)
                select case (self%values(i)%quantity)
                case (quantity_velocity)
                    channel%largest = max(channel%largest, largest_rate(state%v))
                case (quantity_acceleration)
                    channel%largest = max(channel%largest, largest_rate(state%a))
                end select
            end associate
        end do
    end subroutine record_step

    !> Of all nodes' u1 and u3.
    pure real(wp) function largest_rate(rates)
        real(wp), intent(in) :: rates(:)            !! (n)

        largest_rate = max(maxval(abs(rates(1::n_fields))), maxval(abs(rates(2::n_fields))))
    end function largest_rate

    subroutine end_task(self, failure, error)
        class(follower_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: failure
        type(error_t), allocatable, intent(out) :: error

        self%is_lost = self%is_lost .or. self%largest_drift > lost_part*self%largest_energy
    end subroutine end_task

end module gb_trial
