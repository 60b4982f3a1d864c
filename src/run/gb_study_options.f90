!> What the command line and the environment say about a study: which share of it to run, on how many threads.
module gb_study_options
    use gb_command_line, only: options_t
    use gb_error, only: error_t, raise, status_input
    use gb_problem, only: problem_t
    use gb_share, only: share_t
    implicit none
    private

    !> Where Open MPI, MPICH and its kin, and Slurm tell a process its rank (from 0) and their number, in the
    !> order in which they are asked.
    character(24), parameter :: ranks(3) = [character(24) :: 'OMPI_COMM_WORLD_RANK', 'PMI_RANK', &
        'SLURM_PROCID']
    character(24), parameter :: sizes(3) = [character(24) :: 'OMPI_COMM_WORLD_SIZE', 'PMI_SIZE', &
        'SLURM_STEP_NUM_TASKS']
    integer, parameter :: most_shards = 1000000, most_threads = 1024

    public :: choose_share, choose_threads

contains

    !> The members to be run; none where the deck has no SWEEP, and then --shard is an error.
    subroutine choose_share(options, problem, share, error)
        type(options_t), intent(in) :: options
        type(problem_t), intent(in) :: problem
        type(share_t), intent(out) :: share
        type(error_t), allocatable, intent(out) :: error

        share%members = int(problem%sweep%members())
        if (share%members == 0) then
            if (options%shards > 0 .or. options%shard_from_environment) call raise(error, status_input, &
                '--shard divides the members of a SWEEP, and the deck has none')
        else if (options%shard_from_environment) then
            call ask_environment(share, error)
        else if (options%shards > 0) then
            share%shard = options%shard
            share%shards = options%shards
        end if
    end subroutine choose_share

    !> Rank and size of the process among those started together, times those of the job array's tasks.
    subroutine ask_environment(share, error)
        type(share_t), intent(inout) :: share
        type(error_t), allocatable, intent(out) :: error
        integer :: i, rank, number, task, tasks
        logical :: has_rank, has_size, has_array

        do i = 1, size(ranks)
            call whole_number(trim(ranks(i)), rank, has_rank)
            call whole_number(trim(sizes(i)), number, has_size)
            has_rank = has_rank .and. has_size
            if (has_rank) exit
        end do
        if (.not. has_rank) then
            rank = 0
            number = 1
        end if
        call ask_array(task, tasks, has_array, error)
        if (allocated(error)) return
        if (.not. (has_rank .or. has_array)) then
            call raise(error, status_input, &
                '--shard auto finds no rank and size in the environment of Open ' &
                // 'MPI, MPICH or Slurm: start it by mpirun, srun or sbatch --array, or give --shard I/N')
        else if (rank >= number .or. number > most_shards/tasks) then
            call raise(error, status_input, '--shard auto: ' // trim(ranks(i)) // ' and ' // trim(sizes(i)) &
                // &
                ' do not go together')
        else
            share%shard = task*number + rank + 1
            share%shards = tasks*number
        end if
    end subroutine ask_environment

    !> The place of a task in Slurm's job array, from 0, and how many there are; 0 of 1 outside of an array.
    subroutine ask_array(task, tasks, found, error)
        integer, intent(out) :: task, tasks
        logical, intent(out) :: found
        type(error_t), allocatable, intent(out) :: error
        integer :: id, first, last, step
        logical :: has(5)

        call whole_number('SLURM_ARRAY_TASK_ID', id, has(1))
        call whole_number('SLURM_ARRAY_TASK_COUNT', tasks, has(2))
        call whole_number('SLURM_ARRAY_TASK_MIN', first, has(3))
        call whole_number('SLURM_ARRAY_TASK_MAX', last, has(4))
        call whole_number('SLURM_ARRAY_TASK_STEP', step, has(5))
        found = all(has)
        task = 0
        if (.not. found) then
            tasks = 1
        else if (step < 1 .or. tasks < 1 .or. tasks > most_shards .or. (last - first)/max(1, step) + 1 /= &
            tasks &
            .or. id < first .or. id > last) then
            call raise(error, status_input, '--shard auto cannot tell the shards of a job array with gaps ' &
                // &
                'apart: give --shard I/N')
        else
            task = (id - first)/step
        end if
    end subroutine ask_array

    !> --threads, else OMP_NUM_THREADS (its first number), else 1.
    subroutine choose_threads(options, threads, error)
        type(options_t), intent(in) :: options
        integer, intent(out) :: threads
        type(error_t), allocatable, intent(out) :: error
        logical :: found

        threads = options%threads
        if (threads == 0) then
            call whole_number('OMP_NUM_THREADS', threads, found)
            if (.not. found .or. threads < 1) threads = 1
        end if
        if (threads > most_threads) call raise(error, status_input, 'more than 1024 threads are a mistake')
    end subroutine choose_threads

    !> The whole number that an environment variable begins with.
    subroutine whole_number(name, number, found)
        character(*), intent(in) :: name
        integer, intent(out) :: number
        logical, intent(out) :: found
        character(32) :: value
        integer :: status, last

        number = 0
        call get_environment_variable(name, value, status=status)
        found = status == 0
        if (.not. found) return
        last = verify(value, '0123456789') - 1
        found = last >= 1 .and. last <= 9
        if (found) read (value(:last), *) number
    end subroutine whole_number

end module gb_study_options
