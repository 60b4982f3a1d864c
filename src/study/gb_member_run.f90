!> Runs members of a study, each from its problem to what it has to tell.
module gb_member_run
    use gb_error, only: error_t, status_interrupted
    use gb_external, only: external_t, build_external
    use gb_initial, only: initial_state
    use gb_member, only: member_t, command_record_t, member_waiting, member_complete, member_failed
    use gb_member_recorder, only: member_recorder_t
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_memory, only: memory_t
    use gb_task, only: run_task
    implicit none
    private

    public :: run_members

contains

    !> Run a batch of members. Those without a problem have failed before and stay as they are; those that a
    !> signal stops are left waiting. No member depends on which others are in its batch.
    subroutine run_members(members)
        type(member_t), intent(inout) :: members(:)
        integer :: i

        do i = 1, size(members)
            if (allocated(members(i)%problem)) call run_one(members(i))
        end do
    end subroutine run_members

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
