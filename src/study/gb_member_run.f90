!> Runs members of a study, each from its problem to what it has to tell.
module gb_member_run
    use gb_error, only: error_t, status_interrupted
    use gb_external, only: external_t, build_external
    use gb_initial, only: initial_state
    use gb_member, only: member_t, command_record_t, member_waiting, member_complete, member_failed
    use gb_member_recorder, only: member_recorder_t
    use gb_shared_run, only: shared_run_t
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_memory, only: memory_t
    use gb_task, only: run_task
    implicit none
    private

    public :: run_members

contains

    !> Run a batch of members. Those without a problem have failed before and stay as they are; those that a
    !> signal stops are left waiting. No member depends on which others are in its batch, nor does the way
    !> that it is run: where the lanes can do a command of a member, it goes there, alone if need be.
    subroutine run_members(members)
        type(member_t), intent(inout) :: members(:)
        type(shared_run_t) :: run
        logical :: waits(size(members))
        integer :: i, j

        do i = 1, size(members)
            waits(i) = allocated(members(i)%problem)
        end do
        do i = 1, size(members)
            if (.not. waits(i)) cycle
            call run%begin(members(i)%problem, i)
            waits(i) = .false.
            do j = i + 1, size(members)
                if (run%is_full()) exit
                if (waits(j)) waits(j) = .not. run%takes(members(i)%problem, members(j)%problem, j)
            end do
            call finish_run(run, members)
        end do
    end subroutine run_members

    !> Run the members that were put together, and those that the lanes cannot do one by one.
    subroutine finish_run(run, members)
        type(shared_run_t), intent(inout) :: run
        type(member_t), intent(inout) :: members(:)
        integer :: k

        call run%solve(members)
        do k = 1, run%count
            associate (member => members(run%numbers(k)))
                if (run%is_running(k)) then
                    member%message = ''
                    member%outcome = member_complete
                    call take_records(member, run%recorders(k))
                else
                    call run_one(member)
                end if
            end associate
        end do
    end subroutine finish_run

    subroutine run_one(member)
        type(member_t), intent(inout) :: member
        type(member_recorder_t) :: recorder
        type(system_t) :: system
        type(external_t) :: external
        type(state_t) :: state
        type(memory_t) :: memory
        type(error_t), allocatable :: error
        logical :: has_velocities
        integer :: i

        associate (problem => member%problem)
            call recorder%open(problem)
            system = build_system(problem%model)
            external = build_external(problem%model)
            call initial_state(problem%model, system, state, error)
            has_velocities = .true.
            do i = 1, size(problem%tasks)
                if (allocated(error)) exit
                call run_task(problem, i, system, external, .false., memory, has_velocities, state, &
                    recorder, error)
            end do
        end associate
        member%message = ''
        member%outcome = member_complete
        if (allocated(error)) then
            member%outcome = member_failed
            if (error%status == status_interrupted) member%outcome = member_waiting
            member%message = error%message
        end if
        call take_records(member, recorder)
    end subroutine run_one

    subroutine take_records(member, recorder)
        type(member_t), intent(inout) :: member
        type(member_recorder_t), intent(inout) :: recorder
        type(command_record_t), allocatable :: begun(:)

        if (recorder%n < size(recorder%commands)) then
            begun = recorder%commands(:recorder%n)
            call move_alloc(begun, recorder%commands)
        end if
        call move_alloc(recorder%commands, member%commands)
        call move_alloc(recorder%extremes, member%extremes)
        ! What only the solution needed shall not wait for the file.
        if (.not. recorder%has_histories) deallocate (member%problem)
    end subroutine take_records

end module gb_member_run
