!> gentbeam --merge OUT.h5 FILE...: one results file from those of a study's shards.
module gb_merge_run
    use gb_command_line, only: options_t
    use gb_error, only: error_t, raise, status_file, status_solution
    use gb_log, only: log_t
    use gb_share, only: study_end
    use gb_sweep_merge, only: merge_shards, merged_t
    use gb_text, only: to_text
    implicit none
    private

    public :: run_merge

    integer, parameter :: shown_ranges = 20

contains

    !> Join the shards and say what became of the study. Members that are missing are an error, told after the
    !> file has been written with all that there are.
    subroutine run_merge(options, error)
        type(options_t), intent(in) :: options
        type(error_t), allocatable, intent(out) :: error
        type(merged_t) :: merged
        type(log_t) :: log
        character(:), allocatable :: status, counts

        log%level = options%log_level
        call merge_shards(options%merge_into, options%merge_from, merged, error)
        if (allocated(error)) return
        call study_end(merged%members, merged%failed, size(merged%missing), status, counts)
        call log%line('merged ' // to_text(size(options%merge_from)) // ' files into ' // options%merge_into &
            // ': ' // counts)
        if (size(merged%missing) > 0) then
            call raise(error, status_solution, 'members missing in ' // options%merge_into // ': ' &
                // ranges(merged%missing))
        else if (log%has_failed) then
            call raise(error, status_file, &
                'the log could not be written to standard output (the results file is complete)')
        end if
    end subroutine run_merge

    !> 3, 7-9, 12
    pure function ranges(numbers) result(text)
        integer, intent(in) :: numbers(:)           !! increasing
        character(:), allocatable :: text
        integer :: i, last, n

        text = ''
        n = 0
        i = 1
        do while (i <= size(numbers))
            last = i
            do while (last < size(numbers))
                if (numbers(last + 1) /= numbers(last) + 1) exit
                last = last + 1
            end do
            n = n + 1
            if (n > shown_ranges) then
                text = text // ' and ' // to_text(size(numbers) - i + 1) // ' more'
                return
            end if
            if (n > 1) text = text // ', '
            text = text // to_text(numbers(i))
            if (last > i) text = text // '-' // to_text(numbers(last))
            i = last + 1
        end do
    end function ranges

end module gb_merge_run
