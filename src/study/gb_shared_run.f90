!> Members of a study that run side by side, one a lane (gb_ensemble): how they are put together, and their
!> solution commands one after the other. What the lanes cannot do of a member's commands is done by itself;
!> a member with which anything goes wrong is given up, and whoever asked runs it from the start by itself.
module gb_shared_run
    use gb_ensemble, only: fits_ensemble, are_alike, run_ensemble
    use gb_error, only: error_t
    use gb_external, only: external_t, build_external
    use gb_initial, only: initial_state, initial_velocities
    use gb_lanes, only: lanes
    use gb_member, only: member_t
    use gb_member_recorder, only: member_recorder_t
    use gb_memory, only: memory_t
    use gb_problem, only: problem_t
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_task, only: run_task
    implicit none
    private

    type, public :: shared_run_t
        integer :: count = 0                            !! members
        integer :: numbers(lanes) = 0                   !! which they are in their batch
        logical :: is_running(lanes) = .false.          !! not given up
        type(member_recorder_t), allocatable :: recorders(:)
        type(system_t), allocatable, private :: systems(:)
        type(external_t), allocatable, private :: externals(:)
        type(state_t), allocatable, private :: states(:)
        logical, allocatable, private :: fits(:)        !! commands that the lanes can do
        logical, private :: has_velocities = .true.     !! whether the states' are those to go on with
    contains
        procedure :: begin
        procedure :: is_full
        procedure :: takes
        procedure :: solve
    end type shared_run_t

contains

    !> Begin with a member; where the lanes can do none of its commands, it stays the only one and does not
    !> run.
    subroutine begin(self, problem, number)
        class(shared_run_t), intent(out) :: self
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number

        allocate (self%systems(lanes), self%externals(lanes), self%states(lanes), self%recorders(lanes))
        self%systems(1) = build_system(problem%model)
        self%externals(1) = build_external(problem%model)
        self%fits = fitting_tasks(problem, self%systems(1), self%externals(1))
        self%count = 1
        self%numbers(1) = number
        self%is_running(1) = any(self%fits)
    end subroutine begin

    pure logical function is_full(self)
        class(shared_run_t), intent(in) :: self

        is_full = self%count == lanes .or. .not. self%is_running(1)
    end function is_full

    pure function fitting_tasks(problem, system, external) result(fits)
        type(problem_t), intent(in) :: problem
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        logical :: fits(size(problem%tasks))
        integer :: i

        do i = 1, size(problem%tasks)
            fits(i) = fits_ensemble(system, external, problem%tasks(i))
        end do
    end function fitting_tasks

    !> Take a further member along, if it is like the first one; there must be room.
    logical function takes(self, first, problem, number)
        class(shared_run_t), intent(inout) :: self
        type(problem_t), intent(in) :: first            !! the problem that it began with
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number
        integer :: i

        takes = size(problem%tasks) == size(self%fits) &
            .and. problem%model%mesh%n_elements() == self%systems(1)%n_elements
        if (.not. takes) return
        associate (system => self%systems(self%count + 1), external => self%externals(self%count + 1))
            system = build_system(problem%model)
            external = build_external(problem%model)
            takes = all(fitting_tasks(problem, system, external) .eqv. self%fits)
            do i = 1, size(self%fits)
                if (takes .and. self%fits(i)) takes = are_alike(self%systems(1), self%externals(1), &
                    first%tasks(i), system, external, problem%tasks(i))
            end do
        end associate
        if (.not. takes) return
        self%count = self%count + 1
        self%numbers(self%count) = number
        self%is_running(self%count) = .true.
    end function takes

    !> Run all commands. Members that are not running afterwards are to be run by themselves.
    subroutine solve(self, members)
        class(shared_run_t), intent(inout) :: self
        type(member_t), intent(in) :: members(:)        !! the batch
        type(error_t), allocatable :: error
        integer :: k, i

        if (.not. self%is_running(1)) return
        do k = 1, self%count
            associate (problem => members(self%numbers(k))%problem)
                call self%recorders(k)%open(problem)
                call initial_state(problem%model, self%systems(k), self%states(k), error)
                call check(self, k, error)
            end associate
        end do
        do i = 1, size(self%fits)
            if (self%fits(i)) then
                call solve_side_by_side(self, members, i)
            else
                call solve_one_by_one(self, members, i)
            end if
        end do
    end subroutine solve

    !> A member with an error is given up.
    subroutine check(self, k, error)
        class(shared_run_t), intent(inout) :: self
        integer, intent(in) :: k
        type(error_t), allocatable, intent(inout) :: error

        if (.not. allocated(error)) return
        self%is_running(k) = .false.
        deallocate (error)
    end subroutine check

    subroutine solve_side_by_side(self, members, number)
        class(shared_run_t), intent(inout) :: self
        type(member_t), intent(in) :: members(:)
        integer, intent(in) :: number                   !! of the command
        type(error_t), allocatable :: error, no_failure
        integer :: k

        do k = 1, self%count
            if (.not. self%is_running(k)) cycle
            associate (problem => members(self%numbers(k))%problem)
                call self%recorders(k)%begin_task(problem%tasks(number), error)
                call check(self, k, error)
                if (self%has_velocities) cycle
                call initial_velocities(problem%model, self%systems(k), self%states(k)%v, error)
                call check(self, k, error)
            end associate
        end do
        self%has_velocities = .true.
        call run_ensemble(self%systems(:self%count), self%externals(:self%count), &
            members(self%numbers(1))%problem%tasks(number), self%states(:self%count), &
            self%recorders(:self%count), self%is_running(:self%count))
        do k = 1, self%count
            if (.not. self%is_running(k)) cycle
            call self%recorders(k)%end_task(no_failure, error)
            call check(self, k, error)
        end do
    end subroutine solve_side_by_side

    subroutine solve_one_by_one(self, members, number)
        class(shared_run_t), intent(inout) :: self
        type(member_t), intent(in) :: members(:)
        integer, intent(in) :: number                   !! of the command
        type(memory_t) :: memory
        type(error_t), allocatable :: error
        logical :: has_velocities
        integer :: k

        has_velocities = self%has_velocities
        do k = 1, self%count
            if (.not. self%is_running(k)) cycle
            has_velocities = self%has_velocities
            call run_task(members(self%numbers(k))%problem, number, self%systems(k), self%externals(k), &
                .false., memory, has_velocities, self%states(k), self%recorders(k), error)
            call check(self, k, error)
        end do
        self%has_velocities = has_velocities
    end subroutine solve_one_by_one

end module gb_shared_run
