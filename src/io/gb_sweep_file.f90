!> The results file of a study (docs/results.md): parameters, what became of every member, a summary of its
!> probes and, where OUTPUT keeps fields, a group for every member.
!>
!> Rows of the summary gather in memory and go to the file together. A member counts as finished only once
!> all it has to tell is in the file: what a killed run has left can be trusted as far as /sweep/status says.
module gb_sweep_file
    use gb_kinds, only: wp, i8
    use gb_archive, only: archive_t
    use gb_claim, only: claim_file, explain_failure, set_environment_default
    use gb_error, only: error_t, raise, status_file
    use gb_fields, only: field_length_power
    use gb_hdf5_direct, only: hid_t, flush_file, close_file, create_group, close_group, put_attribute, &
        replace_attribute
    use gb_hdf5_input, only: get_attribute, get_deck
    use gb_hdf5_read, only: open_file, open_group, has_link, delete_link
    use gb_hdf5_table, only: table_t, text_table_t, put_text_list, store_real, store_integer, store_byte
    use gb_member, only: member_t, member_complete, member_waiting
    use gb_member_file, only: write_member, member_name
    use gb_mesh, only: mesh_t
    use gb_problem, only: problem_t, probe_t, task_static, task_modal
    use gb_results, only: derived_unit, probe_description
    use gb_results_header, only: write_header, write_units, write_mesh, now
    use gb_share, only: share_t
    use gb_version, only: program_version, git_revision
    implicit none
    private

    integer, parameter :: block = 1024              !! rows that wait at most
    real(wp), parameter :: flush_seconds = 2.0_wp   !! and for how long

    type, public :: sweep_file_t
        private
        character(:), allocatable, public :: path
        type(share_t), public :: share
        integer(hid_t) :: file = -1, sweep = -1, summary = -1, members = -1
        logical :: is_open = .false.
        logical :: has_members = .false.            !! every member has a group
        type(mesh_t) :: mesh                        !! the one that /mesh shows
        type(table_t) :: status
        type(text_table_t) :: message
        type(table_t), allocatable :: probes(:, :)  !! (3, probes): max, min, time_of_max
        type(table_t), allocatable :: modes(:)      !! a MODAL command each
        integer, allocatable :: modal_tasks(:)      !! their numbers
        real(wp), allocatable :: outcomes(:)        !! of the rows that wait (block)
        integer, allocatable :: positions(:)        !! of the rows that wait, increasing (block)
        real(wp), allocatable :: extremes(:, :)     !! (3 probes, block)
        real(wp), allocatable :: frequencies(:, :)  !! of all MODAL commands, one after the other (.., block)
        integer :: n = 0                            !! rows that wait
        integer(i8) :: last_flush = 0
    contains
        procedure :: create => create_sweep_file
        procedure :: reopen => reopen_sweep_file
        procedure :: read_outcomes
        procedure :: take
        procedure :: flush => flush_rows
        procedure :: close => close_sweep_file
    end type sweep_file_t

    character(11), parameter, public :: summary_names(3) = [character(11) :: 'max', 'min', 'time_of_max']

contains

    !> Create the file of a study's share and write all that is known beforehand.
    subroutine create_sweep_file(self, path, problem, share, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: path
        type(problem_t), intent(in) :: problem
        type(share_t), intent(in) :: share
        type(error_t), allocatable, intent(out) :: error

        self%path = path
        self%share = share
        self%has_members = keeps_members(problem)
        self%mesh = problem%model%mesh
        call write_beginning(path, problem, error)
        if (.not. allocated(error)) call claim(path, error)
        if (allocated(error)) return
        call open_file(path, .true., self%file, error)
        self%is_open = .not. allocated(error)
        if (.not. allocated(error)) call create_group(self%file, 'sweep', self%sweep, error)
        if (.not. allocated(error)) call put_attribute(self%sweep, 'members', share%members, error)
        if (.not. allocated(error)) call put_attribute(self%sweep, 'shard', share%shard, error)
        if (.not. allocated(error)) call put_attribute(self%sweep, 'shards', share%shards, error)
        if (.not. allocated(error)) call write_parameters(self, problem, error)
        if (.not. allocated(error)) call create_tables(self, problem, error)
        if (.not. allocated(error) .and. self%has_members) call create_group(self%sweep, 'members', &
            self%members, error)
        if (.not. allocated(error)) call flush_file(self%file, error)
        if (allocated(error)) then
            call explain_failure(path, error)
            return
        end if
        call make_room(self, problem)
    end subroutine create_sweep_file

    !> What every results file begins with; an older file is replaced.
    subroutine write_beginning(path, problem, error)
        character(*), intent(in) :: path
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: ignored
        type(archive_t) :: archive
        integer :: mesh

        ! HDF5 asks once, when it starts: others can read the file while it is being written.
        call set_environment_default('HDF5_USE_FILE_LOCKING', 'FALSE')
        call archive%open(path, error)
        if (allocated(error)) return
        call write_header(archive, problem, now())
        call write_units(archive, problem%model%units)
        call write_mesh(archive, problem%model, mesh, error)
        if (.not. allocated(error)) call archive%publish(.true., .false., error)
        if (allocated(error)) then
            call archive%close(ignored)
        else
            call archive%close(error)
        end if
    end subroutine write_beginning

    pure logical function keeps_members(problem)
        type(problem_t), intent(in) :: problem

        keeps_members = problem%output%u .or. problem%output%v .or. problem%output%a
    end function keeps_members

    subroutine claim(path, error)
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: reason

        reason = claim_file(path)
        if (len(reason) > 0) call raise(error, status_file, 'cannot write the results file ' // path // ': ' &
            // reason)
    end subroutine claim

    !> Numbers and parameters of the share's members.
    subroutine write_parameters(self, problem, error)
        class(sweep_file_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        type(table_t) :: number, parameters
        real(wp), allocatable :: rows(:, :), numbers(:, :)
        integer :: first, count, i, n

        n = self%share%n()
        call number%create(self%sweep, 'number', n, 0, store_integer, '', &
            'number of each member in the whole study, from 1', error)
        if (.not. allocated(error)) call parameters%create(self%sweep, 'parameters', n, &
            problem%sweep%n_parameters(), store_real, '', &
            'values of the parameters that vary, a row a member', &
            error)
        if (.not. allocated(error)) call put_text_list(parameters%dataset, 'names', problem%sweep%names(), &
            error)
        do first = 0, n - 1, block
            if (allocated(error)) return
            count = min(block, n - first)
            allocate (rows(problem%sweep%n_parameters(), count), numbers(1, count))
            do i = 1, count
                numbers(1, i) = real(self%share%number(first + i), wp)
                rows(:, i) = problem%sweep%values(self%share%number(first + i))
            end do
            call number%write(first, numbers, error)
            if (.not. allocated(error)) call parameters%write(first, rows, error)
            deallocate (rows, numbers)
        end do
        call number%close()
        call parameters%close()
    end subroutine write_parameters

    subroutine create_tables(self, problem, error)
        class(sweep_file_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        integer :: i, n

        n = self%share%n()
        call self%status%create(self%sweep, 'status', n, 0, store_byte, '', &
            'what became of each member: 0 not run yet, 1 complete, 2 failed', error)
        if (.not. allocated(error)) call self%message%create(self%sweep, 'message', n, &
            'why a member failed; else empty', error)
        if (.not. allocated(error)) call create_group(self%sweep, 'summary', self%summary, error)
        call list_tables(self, problem)
        if (has_steps(problem)) then
            do i = 1, size(problem%probes)
                if (.not. allocated(error)) call create_probe_tables(self, problem, i, error)
            end do
        end if
        do i = 1, size(self%modal_tasks)
            associate (task => problem%tasks(self%modal_tasks(i)))
                if (.not. allocated(error)) call self%modes(i)%create(self%summary, task%name // &
                    '_frequency', &
                    n, task%count, store_real, frequency_unit(problem), &
                    'natural frequencies, cycles a unit of time; 0 where the member failed', error)
            end associate
        end do
    end subroutine create_tables

    pure function frequency_unit(problem) result(unit)
        type(problem_t), intent(in) :: problem
        character(:), allocatable :: unit

        unit = ''
        if (len(problem%model%units%time) > 0) unit = '1/' // problem%model%units%time
    end function frequency_unit

    subroutine create_probe_tables(self, problem, number, error)
        class(sweep_file_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: unit, time_unit, words
        integer :: n

        n = self%share%n()
        associate (probe => problem%probes(number), task => problem%tasks(last_with_steps(problem)), &
            units => problem%model%units)
            unit = derived_unit(units, field_length_power(probe%field), probe%quantity)
            time_unit = units%time
            if (task%kind == task_static) time_unit = ''
            words = probe_description(probe) // ' during ' // task%name // '; 0 where the member failed'
            call self%probes(1, number)%create(self%summary, probe%name // '_max', n, 0, store_real, unit, &
                'largest ' // words, error)
            if (.not. allocated(error)) call self%probes(2, number)%create(self%summary, probe%name // &
                '_min', &
                n, 0, store_real, unit, 'smallest ' // words, error)
            words = 'time'
            if (task%kind == task_static) words = 'load factor'
            if (.not. allocated(error)) call self%probes(3, number)%create(self%summary, probe%name // &
                '_time_of_max', n, 0, store_real, time_unit, words // ' of the largest ' // &
                probe_description(probe) // ' during ' // task%name // '; 0 where the member failed', error)
        end associate
    end subroutine create_probe_tables

    !> Which summaries there are: of the probes if a command has steps, and of the MODAL commands.
    subroutine list_tables(self, problem)
        class(sweep_file_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        integer :: i

        self%modal_tasks = pack([(i, i=1, size(problem%tasks))], problem%tasks%kind == task_modal)
        if (allocated(self%modes)) deallocate (self%modes)
        allocate (self%modes(size(self%modal_tasks)))
        if (allocated(self%probes)) deallocate (self%probes)
        allocate (self%probes(3, merge(size(problem%probes), 0, has_steps(problem))))
    end subroutine list_tables

    pure logical function has_steps(problem)
        type(problem_t), intent(in) :: problem

        has_steps = any(problem%tasks%kind /= task_modal)
    end function has_steps

    !> The command that the probes' summary speaks of.
    pure integer function last_with_steps(problem) result(number)
        type(problem_t), intent(in) :: problem

        do number = size(problem%tasks), 1, -1
            if (problem%tasks(number)%kind /= task_modal) return
        end do
    end function last_with_steps

    subroutine make_room(self, problem)
        class(sweep_file_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem

        allocate (self%outcomes(block), self%positions(block))
        allocate (self%extremes(size(self%probes), block))
        allocate (self%frequencies(sum(problem%tasks(self%modal_tasks)%count), block))
        call system_clock(self%last_flush)
    end subroutine make_room

    !> Go on with the file of the same share of the same study. Where there is no such file, or one that
    !> cannot be read, `found` is false; a file of another deck is an error.
    subroutine reopen_sweep_file(self, path, problem, share, found, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: path
        type(problem_t), intent(in) :: problem
        type(share_t), intent(in) :: share
        logical, intent(out) :: found
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: unreadable
        integer :: i, k, rows

        found = .false.
        inquire (file=path, exist=found)
        if (.not. found) return
        self%path = path
        self%share = share
        ! To open a file for writing changes it: it is looked at before. Closing it would drop the claim.
        call open_file(path, .false., self%file, unreadable)
        if (allocated(unreadable)) then
            found = .false.
            return
        end if
        call open_group(self%file, 'sweep', self%sweep, unreadable)
        found = .not. allocated(unreadable)
        if (found) then
            call check_same(self, problem, error)
            call close_group(self%sweep)
        end if
        call close_file(self%file, unreadable)
        if (allocated(error) .or. .not. found) return
        call claim(path, error)
        if (allocated(error)) return
        call open_file(path, .true., self%file, error)
        if (.not. allocated(error)) call open_group(self%file, 'sweep', self%sweep, error)
        if (allocated(error)) then
            call explain_failure(path, error)
            return
        end if
        self%is_open = .true.
        self%has_members = keeps_members(problem)
        self%mesh = problem%model%mesh
        call list_tables(self, problem)
        call self%status%open(self%sweep, 'status', rows, error)
        if (.not. allocated(error)) call self%message%open(self%sweep, 'message', error)
        if (.not. allocated(error)) call open_group(self%sweep, 'summary', self%summary, error)
        do i = 1, size(self%probes, 2)
            do k = 1, 3
                if (.not. allocated(error)) call self%probes(k, i)%open(self%summary, problem%probes(i)%name &
                    // '_' // trim(summary_names(k)), rows, error)
            end do
        end do
        do i = 1, size(self%modes)
            if (.not. allocated(error)) call self%modes(i)%open(self%summary, &
                problem%tasks(self%modal_tasks(i))%name // '_frequency', rows, error)
        end do
        if (self%has_members .and. .not. allocated(error)) call open_group(self%sweep, 'members', &
            self%members, error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'status', 'running', error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'message', '', error)
        if (.not. allocated(error)) call flush_file(self%file, error)
        if (allocated(error)) then
            call explain_failure(path, error)
            return
        end if
        call make_room(self, problem)
    end subroutine reopen_sweep_file

    !> The file is of the same deck with the same parameters, and of the same share.
    subroutine check_same(self, problem, error)
        class(sweep_file_t), intent(inout) :: self
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: trouble
        character(:), allocatable :: text, parameters, version, revision
        integer :: members, shards

        call get_attribute(self%file, 'program_version', version, trouble)
        if (.not. allocated(trouble)) call get_attribute(self%file, 'git_revision', revision, trouble)
        if (.not. allocated(trouble) .and. (version /= program_version .or. revision /= git_revision)) then
            call raise(error, status_file, self%path // ' was begun by another version of the program (' // &
                version // ', ' // revision // '): delete it, or give another name by -o')
            return
        end if
        if (.not. allocated(trouble)) call get_deck(self%file, text, parameters, trouble)
        members = 0
        shards = 0
        if (.not. allocated(trouble)) call get_attribute(self%sweep, 'members', members, trouble)
        if (.not. allocated(trouble)) call get_attribute(self%sweep, 'shards', shards, trouble)
        if (.not. allocated(trouble) .and. text == problem%deck_text .and. parameters == problem%parameters &
            .and. members == self%share%members .and. shards == self%share%shards) return
        call raise(error, status_file, self%path // ' holds the results of another deck or of other ' // &
            'parameters: delete it, or give another name by -o')
    end subroutine check_same

    !> What became of the members so far (positions of the share).
    subroutine read_outcomes(self, outcomes, error)
        class(sweep_file_t), intent(in) :: self
        integer, allocatable, intent(out) :: outcomes(:)
        type(error_t), allocatable, intent(out) :: error
        real(wp), allocatable :: rows(:, :)

        allocate (rows(1, self%share%n()))
        call self%status%read(0, rows, error)
        outcomes = nint(rows(1, :))
    end subroutine read_outcomes

    !> Take a member that has run; members come in increasing order.
    subroutine take(self, member, error)
        class(sweep_file_t), intent(inout) :: self
        type(member_t), intent(in) :: member
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: name
        integer(i8) :: count, rate

        if (self%has_members) then
            name = member_name(member%number, self%share%members)
            ! A run that was killed may have left a group of a member that it had not finished.
            if (has_link(self%members, name)) call delete_link(self%members, name, error)
            if (.not. allocated(error)) call write_member(self%members, name, member, self%mesh, error)
        end if
        if (.not. allocated(error)) call keep_row(self, member, error)
        if (allocated(error)) then
            call explain_failure(self%path, error)
            return
        end if
        call system_clock(count, rate)
        if (self%n == block .or. real(count - self%last_flush, wp) > flush_seconds*real(rate, wp)) &
            call self%flush(error)
    end subroutine take

    subroutine keep_row(self, member, error)
        class(sweep_file_t), intent(inout) :: self
        type(member_t), intent(in) :: member
        type(error_t), allocatable, intent(out) :: error
        integer :: i, n, width

        self%n = self%n + 1
        self%positions(self%n) = self%share%position(member%number)
        self%outcomes(self%n) = real(member%outcome, wp)
        self%extremes(:, self%n) = 0.0_wp
        self%frequencies(:, self%n) = 0.0_wp
        if (member%outcome /= member_complete) then
            call self%message%write(self%positions(self%n) - 1, member%message, error)
            return
        end if
        do i = 1, size(self%probes, 2)
            self%extremes(3*i - 2:3*i, self%n) = [member%extremes(i)%largest, member%extremes(i)%smallest, &
                member%extremes(i)%when_largest]
        end do
        n = 0
        do i = 1, size(self%modes)
            width = self%modes(i)%columns
            associate (frequency => member%commands(self%modal_tasks(i))%frequency)
                self%frequencies(n + 1:n + min(width, size(frequency)), self%n) = frequency(:min(width, &
                    size(frequency)))
            end associate
            n = n + width
        end do
    end subroutine keep_row

    !> Hand the rows that wait to the file: first what they say, then that they are there.
    subroutine flush_rows(self, error)
        class(sweep_file_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error
        integer :: first, last

        first = 1
        do while (first <= self%n)
            last = end_of_run(self%positions(:self%n), first)
            if (.not. allocated(error)) call write_summary(self, first, last, error)
            first = last + 1
        end do
        if (.not. allocated(error)) call flush_file(self%file, error)
        first = 1
        do while (first <= self%n)
            last = end_of_run(self%positions(:self%n), first)
            if (.not. allocated(error)) call self%status%write(self%positions(first) - 1, &
                reshape(self%outcomes(first:last), [1, last - first + 1]), error)
            first = last + 1
        end do
        if (.not. allocated(error)) call flush_file(self%file, error)
        self%n = 0
        call system_clock(self%last_flush)
        if (allocated(error)) call explain_failure(self%path, error)
    end subroutine flush_rows

    !> The last of the positions that follow one another from `first` on.
    pure integer function end_of_run(positions, first) result(last)
        integer, intent(in) :: positions(:), first

        last = first
        do while (last < size(positions))
            if (positions(last + 1) /= positions(last) + 1) return
            last = last + 1
        end do
    end function end_of_run

    subroutine write_summary(self, first, last, error)
        class(sweep_file_t), intent(inout) :: self
        integer, intent(in) :: first, last          !! of the rows that wait
        type(error_t), allocatable, intent(out) :: error
        integer :: i, k, n, before

        before = self%positions(first) - 1
        do i = 1, size(self%probes, 2)
            do k = 1, 3
                if (.not. allocated(error)) call self%probes(k, i)%write(before, &
                    self%extremes(3*i - 3 + k:3*i - 3 + k, first:last), error)
            end do
        end do
        n = 0
        do i = 1, size(self%modes)
            if (.not. allocated(error)) call self%modes(i)%write(before, &
                self%frequencies(n + 1:n + self%modes(i)%columns, first:last), error)
            n = n + self%modes(i)%columns
        end do
    end subroutine write_summary

    !> Write how the study ended, and close.
    subroutine close_sweep_file(self, status, message, wall_seconds, cpu_seconds, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: status          !! complete, failed or interrupted
        character(*), intent(in) :: message
        real(wp), intent(in) :: wall_seconds, cpu_seconds
        type(error_t), allocatable, intent(out) :: error
        integer :: i, k

        if (.not. self%is_open) return
        if (self%n > 0) call self%flush(error)
        if (allocated(error)) return
        do i = 1, size(self%probes, 2)
            do k = 1, 3
                call self%probes(k, i)%close()
            end do
        end do
        do i = 1, size(self%modes)
            call self%modes(i)%close()
        end do
        call self%status%close()
        call self%message%close()
        if (self%has_members) call close_group(self%members)
        call close_group(self%summary)
        call close_group(self%sweep)
        call replace_attribute(self%file, 'status', status, error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'message', message, error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'wall_seconds', wall_seconds, error)
        if (.not. allocated(error)) call replace_attribute(self%file, 'cpu_seconds', cpu_seconds, error)
        if (.not. allocated(error)) call close_file(self%file, error)
        self%is_open = .false.
        if (allocated(error)) call explain_failure(self%path, error)
    end subroutine close_sweep_file

end module gb_sweep_file
