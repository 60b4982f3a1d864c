!> Which names the files of a run may have: what it writes replaces older files of the same kind, and nothing
!> that it reads.
module gb_places
    use gb_error, only: error_t, raise, status_input
    use gb_files, only: is_same_file, is_same_place, is_free_or_hdf5
    use gb_problem, only: problem_t
    implicit none
    private

    public :: check_places, check_restart_place

contains

    !> Neither the checkpoints nor the results of a run take the place of another of its files. Errors:
    !> status_input.
    subroutine check_places(problem, results, error)
        type(problem_t), intent(in) :: problem
        character(*), intent(in) :: results         !! path of the results file
        type(error_t), allocatable, intent(out) :: error

        call check_checkpoints(problem, results, error)
        if (.not. allocated(error)) call check_results(problem, results, error)
    end subroutine check_places

    !> A checkpoint must not take the name of the results, nor that of a file which cannot be an older one:
    !> the deck itself, say.
    subroutine check_checkpoints(problem, results, error)
        type(problem_t), intent(in) :: problem
        character(*), intent(in) :: results
        type(error_t), allocatable, intent(out) :: error
        logical :: is_taken
        integer :: i

        do i = 1, size(problem%tasks)
            if (.not. allocated(problem%tasks(i)%safeguard%file)) cycle
            associate (file => problem%tasks(i)%safeguard%file)
                is_taken = is_same_place(file, results)
                if (.not. is_taken) is_taken = is_same_place(file, results // '.part')
                if (is_taken) then
                    call raise(error, status_input, 'CHECKPOINT file=: ' // file // ' is the results file, ' &
                               // 'give checkpoints another name')
                else if (.not. is_free_or_hdf5(file)) then
                    call raise(error, status_input, 'CHECKPOINT file=: ' // file // ' is there, and is no ' &
                               // 'checkpoint: give checkpoints another name')
                end if
            end associate
            if (allocated(error)) return
        end do
    end subroutine check_checkpoints

    !> Results replace neither the deck nor a table that it names.
    subroutine check_results(problem, results, error)
        type(problem_t), intent(in) :: problem
        character(*), intent(in) :: results
        type(error_t), allocatable, intent(out) :: error
        logical :: is_read
        integer :: i

        is_read = is_same_file(results, problem%deck_name)
        do i = 1, size(problem%model%histories)
            associate (history => problem%model%histories(i))
                if (.not. allocated(history%file)) cycle
                if (is_same_file(results, history%file)) is_read = .true.
            end associate
        end do
        if (allocated(problem%sweep%factors)) then
            do i = 1, size(problem%sweep%factors)
                associate (factor => problem%sweep%factors(i))
                    if (.not. allocated(factor%file)) cycle
                    if (is_same_file(results, factor%file)) is_read = .true.
                end associate
            end do
        end if
        if (is_read) call raise(error, status_input, results // ' is the deck, or a table that it reads: ' &
            // 'give the results another name (-o, OUTPUT file=)')
    end subroutine check_results

    !> Results do not replace the checkpoint that leads to them.
    subroutine check_restart_place(results, checkpoint, error)
        character(*), intent(in) :: results, checkpoint     !! paths
        type(error_t), allocatable, intent(out) :: error

        if (is_same_place(results, checkpoint)) call raise(error, status_input, results // ' is the ' &
            // 'checkpoint that the run goes on from: give the results another name (-o, OUTPUT file=)')
    end subroutine check_restart_place

end module gb_places
