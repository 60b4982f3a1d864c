!> The results file of a study (docs/results.md): a row for every member that has run, with its parameters,
!> what became of it and a summary of its probes, and, where OUTPUT keeps fields, a group for each.
!>
!> What is visible in the file at any instant, also after a kill, is whole: so many members with all they
!> have to tell. They stand in the order of their numbers, but for those that a study lacked when it was
!> stopped and has run later.
module gb_sweep_file
    use gb_kinds, only: wp, i8
    use gb_archive, only: archive_t, root, stored_real64, stored_int32, stored_int8, step_seconds
    use gb_checkpoint, only: origin_t
    use gb_error, only: error_t, raise, status_file, status_input
    use gb_fields, only: field_length_power
    use gb_files, only: begin_rehearsal, end_rehearsal, rehearsal_went_well, remove_file
    use gb_hdf5, only: start_hdf5
    use gb_hdf5_input, only: hid_t, text_t, open_file, close_file, open_group, get_attribute, get_deck, &
        get_rows, get_texts, count_rows, verify
    use gb_member, only: member_t, member_complete, member_failed
    use gb_member_file, only: write_member, member_name
    use gb_mesh, only: mesh_t
    use gb_problem, only: problem_t, task_static, task_modal
    use gb_results_header, only: write_header, write_units, write_mesh, now
    use gb_results_task, only: derived_unit, probe_description
    use gb_share, only: share_t
    use gb_sweep, only: sweep_t
    implicit none
    private

    type, public :: sweep_file_t
        private
        character(:), allocatable, public :: path
        character(:), allocatable, public :: created    !! when the study began, ISO 8601
        type(share_t), public :: share
        logical, allocatable, public :: has_run(:)  !! which members of the share have run (n)
        logical, public :: is_sorted = .true.       !! whether they stand in the order of their numbers
        integer :: latest = 0                       !! number of the last one
        integer, public :: finished = 0             !! members that have run, also in earlier runs
        integer, public :: failed = 0               !! of them
        real(wp), public :: wall_before = 0.0_wp, cpu_before = 0.0_wp   !! seconds of earlier runs
        type(archive_t) :: archive
        type(mesh_t) :: mesh                        !! the one that /mesh shows
        !> Nodes of the file.
        integer :: number = 0, parameters = 0, status = 0, message = 0
        integer :: members = 0                      !! 0 where OUTPUT keeps no fields
        integer, allocatable :: probes(:, :)        !! (3, probes): max, min, time_of_max
        integer, allocatable :: modes(:)            !! a MODAL command each
        integer, allocatable :: modal_tasks(:)      !! their numbers
        integer, allocatable :: counts(:)           !! and how many frequencies they ask for
        integer :: loose = 0                        !! members whose groups are still in memory
    contains
        procedure :: create => create_sweep_file
        procedure :: resume => resume_sweep_file
        procedure :: take
        procedure :: close => close_sweep_file
        procedure, private :: fail
    end type sweep_file_t

    !> Groups of members that are written together, and copied from one file to another together.
    integer, parameter, public :: members_a_batch = 64
    !> A restart that has not read its old results by then meets a loop in them [s].
    integer, parameter :: rehearsal_seconds = 3600

    integer(i8), parameter :: scalar(0) = [integer(i8) ::]
    character(11), parameter, public :: summary_names(3) = [character(11) :: 'max', 'min', 'time_of_max']

contains

    !> Create the file of a study's share, without members.
    subroutine create_sweep_file(self, path, problem, share, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: path
        type(problem_t), intent(in) :: problem
        type(share_t), intent(in) :: share
        type(error_t), allocatable, intent(out) :: error

        self%created = now()
        call begin_file(self, path, problem, share, error)
        if (.not. self%archive%is_open()) return
        if (.not. allocated(error)) call self%archive%publish(.false., .false., error)
        if (allocated(error)) call self%fail(error)
    end subroutine create_sweep_file

    !> All that is known beforehand, in a file that nobody sees yet.
    subroutine begin_file(self, path, problem, share, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: path
        type(problem_t), intent(in) :: problem
        type(share_t), intent(in) :: share
        type(error_t), allocatable, intent(out) :: error
        integer :: sweep, summary, group

        self%path = path
        self%share = share
        allocate (self%has_run(share%n()), source=.false.)
        self%mesh = problem%model%mesh
        call self%archive%open(path, error)
        if (allocated(error)) return
        call write_header(self%archive, problem, self%created)
        call write_units(self%archive, problem%model%units)
        call write_mesh(self%archive, root, problem%model, group, error)
        if (allocated(error)) return
        associate (archive => self%archive)
            call archive%add_group(root, 'sweep', sweep)
            call archive%set(sweep, 'members', share%members)
            call archive%set(sweep, 'shard', share%shard)
            call archive%set(sweep, 'shards', share%shards)
            call archive%add_series(sweep, 'number', [integer ::], stored_int32, '', &
                'number of each member in the whole study, from 1', self%number)
            call archive%add_series(sweep, 'parameters', [problem%sweep%n_parameters()], stored_real64, '', &
                'values of the parameters that vary, a row a member', self%parameters)
            call archive%set_list(self%parameters, 'names', problem%sweep%names())
            call archive%add_series(sweep, 'status', [integer ::], stored_int8, '', &
                'what became of each member: 1 complete, 2 failed', self%status)
            call archive%add_texts(sweep, 'message', 'why a member failed; else empty', self%message)
            call archive%add_group(sweep, 'summary', summary)
            call add_summary(self, summary, problem)
            if (problem%output%u .or. problem%output%v .or. problem%output%a) call archive%add_group(sweep, &
                'members', self%members)
        end associate
    end subroutine begin_file

    !> A column for every number that the summary tells of a member: of the probes, if a command has steps,
    !> and of the MODAL commands.
    subroutine add_summary(self, summary, problem)
        class(sweep_file_t), intent(inout) :: self
        integer, intent(in) :: summary              !! the group
        type(problem_t), intent(in) :: problem
        character(:), allocatable :: unit
        integer :: i

        self%modal_tasks = pack([(i, i=1, size(problem%tasks))], problem%tasks%kind == task_modal)
        self%counts = problem%tasks(self%modal_tasks)%count
        if (allocated(self%modes)) deallocate (self%modes)
        allocate (self%modes(size(self%modal_tasks)))
        if (allocated(self%probes)) deallocate (self%probes)
        allocate (self%probes(3, merge(size(problem%probes), 0, any(problem%tasks%kind /= task_modal))))
        do i = 1, size(self%probes, 2)
            call add_probe_columns(self%archive, summary, problem, i, self%probes(:, i))
        end do
        unit = ''
        if (len(problem%model%units%time) > 0) unit = '1/' // problem%model%units%time
        do i = 1, size(self%modes)
            call self%archive%add_series(summary, problem%tasks(self%modal_tasks(i))%name // '_frequency', &
                [self%counts(i)], stored_real64, unit, &
                'natural frequencies, cycles a unit of time; 0 where the member failed', self%modes(i))
        end do
    end subroutine add_summary

    subroutine add_probe_columns(archive, summary, problem, number, columns)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: summary
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number
        integer, intent(out) :: columns(3)
        character(:), allocatable :: unit, time_unit, words
        character(9), parameter :: kinds(2) = [character(9) :: 'largest', 'smallest']
        integer :: i

        associate (probe => problem%probes(number), task => problem%tasks(last_with_steps(problem)), &
            units => problem%model%units)
            unit = derived_unit(units, field_length_power(probe%field), probe%quantity)
            words = probe_description(probe) // ' during ' // task%name // '; 0 where the member failed'
            do i = 1, 2
                call archive%add_series(summary, probe%name // '_' // trim(summary_names(i)), [integer ::], &
                    stored_real64, unit, trim(kinds(i)) // ' ' // words, columns(i))
            end do
            time_unit = units%time
            if (task%kind == task_static) time_unit = ''
            words = 'time of the largest ' // words
            if (task%kind == task_static) words = 'load factor' // words(5:)
            call archive%add_series(summary, probe%name // '_' // trim(summary_names(3)), [integer ::], &
                stored_real64, time_unit, words, columns(3))
        end associate
    end subroutine add_probe_columns

    !> The command that the probes' summary speaks of.
    pure integer function last_with_steps(problem) result(number)
        type(problem_t), intent(in) :: problem

        do number = size(problem%tasks), 1, -1
            if (problem%tasks(number)%kind /= task_modal) return
        end do
    end function last_with_steps

    !> Go on with the results of the same share of the same study in the file `source`: the members that it
    !> has are taken over into a new file, which then takes the place of `path`. `is_damaged` says that an
    !> error came from a file that is not what it was when it was written.
    subroutine resume_sweep_file(self, path, source, problem, origin, share, is_damaged, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: path, source
        type(problem_t), intent(in) :: problem
        type(origin_t), intent(in) :: origin
        type(share_t), intent(in) :: share
        logical, intent(out) :: is_damaged
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: ignored
        integer :: process
        logical :: is_safe

        ! HDF5 may crash on a file that is damaged, so the reading is rehearsed by another process.
        process = begin_rehearsal(rehearsal_seconds)
        is_safe = .true.
        if (process /= 0) is_safe = rehearsal_went_well(process)
        is_damaged = .not. is_safe
        if (is_safe) then
            call start_hdf5()
            call take_over(self, path, source, problem, origin, share, is_damaged, error)
        else
            call raise(error, status_file, 'reading it ends in a crash of HDF5, or never')
        end if
        if (process == 0) call end_rehearsal()
        if (allocated(error)) then
            if (is_damaged) error%message = 'cannot go on with ' // source // ': ' // error%message
            if (self%archive%is_open()) call self%archive%close(ignored)
            if (.not. is_safe) call remove_file(path // '.part')
            return
        end if
        call self%archive%publish(.false., .true., error)
        if (allocated(error)) call self%fail(error)
    end subroutine resume_sweep_file

    subroutine take_over(self, path, source, problem, origin, share, is_damaged, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: path, source
        type(problem_t), intent(in) :: problem
        type(origin_t), intent(in) :: origin
        type(share_t), intent(in) :: share
        logical, intent(out) :: is_damaged
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: file, sweep

        is_damaged = .true.
        call open_file(source, file, error)
        if (allocated(error)) return
        call verify(file, error)
        if (.not. allocated(error)) call open_group(file, 'sweep', sweep, error)
        if (.not. allocated(error)) call check_same(file, sweep, source, origin, share, is_damaged, error)
        if (.not. allocated(error)) call get_attribute(file, 'created', self%created, error)
        if (.not. allocated(error)) call get_attribute(file, 'wall_seconds', self%wall_before, error)
        if (.not. allocated(error)) call get_attribute(file, 'cpu_seconds', self%cpu_before, error)
        if (.not. allocated(error)) then
            call begin_file(self, path, problem, share, error)
            if (allocated(error)) is_damaged = .false.
        end if
        if (.not. allocated(error)) call self%archive%replay(file, error)
        if (.not. allocated(error)) call take_over_messages(self, file, error)
        if (.not. allocated(error)) call check_members(self, file, problem%sweep, is_damaged, error)
        if (.not. allocated(error) .and. self%members > 0) call take_over_members(self, sweep, file, error)
        call close_file(file)
    end subroutine take_over

    !> The file is of the same deck with the same parameters, of the same program, and of the same share.
    subroutine check_same(file, sweep, path, origin, share, is_damaged, error)
        integer(hid_t), intent(in) :: file, sweep
        character(*), intent(in) :: path
        type(origin_t), intent(in) :: origin
        type(share_t), intent(in) :: share
        logical, intent(out) :: is_damaged
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: text, parameters, version, revision
        integer :: members, shard, shards

        is_damaged = .true.
        call get_attribute(file, 'program_version', version, error)
        if (.not. allocated(error)) call get_attribute(file, 'git_revision', revision, error)
        if (.not. allocated(error)) call get_deck(file, text, parameters, error)
        if (.not. allocated(error)) call get_attribute(sweep, 'members', members, error)
        if (.not. allocated(error)) call get_attribute(sweep, 'shard', shard, error)
        if (.not. allocated(error)) call get_attribute(sweep, 'shards', shards, error)
        if (allocated(error)) return
        is_damaged = .false.
        if (version // ' (' // revision // ')' /= origin%program) then
            call raise(error, status_file, path // ' was begun by another version of the program (' // &
                version // ', ' // revision // '): delete it, or give another name by -o')
        else if (text /= origin%deck .or. parameters /= origin%parameters .or. members /= share%members &
            .or. shards /= share%shards .or. shard /= share%shard) then
            call raise(error, status_file, path // ' holds the results of another deck or of other ' // &
                'parameters: delete it, or give another name by -o')
        end if
    end subroutine check_same

    subroutine take_over_messages(self, file, error)
        class(sweep_file_t), intent(inout) :: self
        integer(hid_t), intent(in) :: file
        type(error_t), allocatable, intent(out) :: error
        type(text_t), allocatable :: texts(:)
        integer :: i

        call get_texts(file, 'sweep/message', texts, error)
        if (allocated(error)) return
        do i = 1, size(texts)
            call self%archive%append_text(self%message, texts(i)%text)
        end do
    end subroutine take_over_messages

    !> Note which members have run. They are of this share, and have the values that the deck gives them.
    subroutine check_members(self, file, sweep, is_damaged, error)
        class(sweep_file_t), intent(inout) :: self
        integer(hid_t), intent(in) :: file
        type(sweep_t), intent(in) :: sweep
        logical, intent(out) :: is_damaged
        type(error_t), allocatable, intent(out) :: error
        integer, parameter :: rows_a_turn = 4096
        real(wp), allocatable :: numbers(:, :), outcomes(:, :), values(:, :)
        integer :: first, n, i

        is_damaged = .true.
        self%finished = int(count_rows(file, 'sweep/number', scalar))
        self%failed = 0
        do first = 0, self%finished - 1, rows_a_turn
            n = min(rows_a_turn, self%finished - first)
            allocate (numbers(1, n), outcomes(1, n), values(sweep%n_parameters(), n))
            call get_rows(file, 'sweep/number', scalar, int(first, i8), numbers, error)
            if (.not. allocated(error)) call get_rows(file, 'sweep/status', scalar, int(first, i8), &
                outcomes, error)
            if (.not. allocated(error)) call get_rows(file, 'sweep/parameters', [size(values, 1, i8)], &
                int(first, i8), values, error)
            if (allocated(error)) return
            self%failed = self%failed + count(nint(outcomes) == member_failed)
            do i = 1, n
                call note_member(self, nint(numbers(1, i)), error)
                if (allocated(error)) return
                if (any(abs(values(:, i) - sweep%values(nint(numbers(1, i)))) > 0.0_wp)) then
                    is_damaged = .false.
                    call raise(error, status_input, self%path // ': a table that the deck reads from a ' &
                        // 'file has changed since it was begun')
                    return
                end if
            end do
            deallocate (numbers, outcomes, values)
        end do
        is_damaged = .false.
    end subroutine check_members

    subroutine note_member(self, number, error)
        class(sweep_file_t), intent(inout) :: self
        integer, intent(in) :: number
        type(error_t), allocatable, intent(out) :: error
        integer :: position
        logical :: fits

        position = self%share%position(number)
        fits = number >= self%share%shard .and. position <= size(self%has_run)
        if (fits) fits = self%share%number(position) == number .and. .not. self%has_run(position)
        if (.not. fits) then
            call raise(error, status_file, 'a member is there twice, or does not belong there')
            return
        end if
        self%has_run(position) = .true.
        self%is_sorted = self%is_sorted .and. number > self%latest
        self%latest = number
    end subroutine note_member

    !> The groups of the members, in the order of their rows.
    subroutine take_over_members(self, sweep, file, error)
        class(sweep_file_t), intent(inout) :: self
        integer(hid_t), intent(in) :: sweep, file
        type(error_t), allocatable, intent(out) :: error
        character(16), allocatable :: names(:)
        real(wp) :: numbers(1, members_a_batch)
        integer(hid_t) :: members
        integer :: first, n, i

        call open_group(sweep, 'members', members, error)
        do first = 0, self%finished - 1, members_a_batch
            n = min(members_a_batch, self%finished - first)
            if (.not. allocated(error)) call get_rows(file, 'sweep/number', scalar, int(first, i8), &
                numbers(:, :n), error)
            if (allocated(error)) return
            allocate (names(n))
            do i = 1, n
                names(i) = member_name(nint(numbers(1, i)), self%share%members)
            end do
            call self%archive%keep_copies(self%members, spread(members, 1, size(names)), names, error)
            deallocate (names)
        end do
    end subroutine take_over_members

    !> Take a member that has run.
    subroutine take(self, member, error)
        class(sweep_file_t), intent(inout) :: self
        type(member_t), intent(in) :: member
        type(error_t), allocatable, intent(out) :: error

        if (self%members > 0) then
            call write_member(self%archive, self%members, member_name(member%number, self%share%members), &
                member, self%mesh, error)
            self%loose = self%loose + 1
        end if
        if (.not. allocated(error)) call note_member(self, member%number, error)
        if (.not. allocated(error)) call write_row(self, member, error)
        if (.not. allocated(error) .and. self%loose >= members_a_batch) call keep_members(self, error)
        self%finished = self%finished + 1
        if (member%outcome == member_failed) self%failed = self%failed + 1
        if (.not. allocated(error)) then
            if (self%archive%is_due(step_seconds)) call publish(self, .false., error)
        end if
        if (allocated(error)) call self%fail(error)
    end subroutine take

    subroutine keep_members(self, error)
        class(sweep_file_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        self%loose = 0
        if (self%members > 0) call self%archive%keep(self%members, error)
    end subroutine keep_members

    subroutine publish(self, is_last, error)
        class(sweep_file_t), intent(inout) :: self
        logical, intent(in) :: is_last
        type(error_t), allocatable, intent(out) :: error

        call keep_members(self, error)
        if (.not. allocated(error)) call self%archive%publish(is_last, self%archive%age() > step_seconds, &
            error)
    end subroutine publish

    subroutine write_row(self, member, error)
        class(sweep_file_t), intent(inout) :: self
        type(member_t), intent(in) :: member
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: summary(3)
        real(wp), allocatable :: frequencies(:)
        integer :: i, k

        associate (archive => self%archive)
            call archive%append(self%number, [real(member%number, wp)], error)
            if (.not. allocated(error)) call archive%append(self%parameters, member%values, error)
            if (.not. allocated(error)) call archive%append(self%status, [real(member%outcome, wp)], error)
            if (member%outcome == member_complete) then
                call archive%append_text(self%message, '')
            else
                call archive%append_text(self%message, member%message)
            end if
            do i = 1, size(self%probes, 2)
                summary = 0.0_wp
                if (member%outcome == member_complete) summary = [member%extremes(i)%largest, &
                    member%extremes(i)%smallest, member%extremes(i)%when_largest]
                do k = 1, 3
                    if (.not. allocated(error)) call archive%append(self%probes(k, i), summary(k:k), error)
                end do
            end do
            do i = 1, size(self%modes)
                allocate (frequencies(self%counts(i)), source=0.0_wp)
                if (member%outcome == member_complete) then
                    associate (found => member%commands(self%modal_tasks(i))%frequency)
                        k = min(size(found), size(frequencies))
                        frequencies(:k) = found(:k)
                    end associate
                end if
                if (.not. allocated(error)) call archive%append(self%modes(i), frequencies, error)
                deallocate (frequencies)
            end do
        end associate
    end subroutine write_row

    !> Write how the study ended, and close.
    subroutine close_sweep_file(self, status, message, wall_seconds, cpu_seconds, error)
        class(sweep_file_t), intent(inout) :: self
        character(*), intent(in) :: status          !! complete, failed or interrupted
        character(*), intent(in) :: message
        real(wp), intent(in) :: wall_seconds, cpu_seconds   !! of this run
        type(error_t), allocatable, intent(out) :: error

        if (.not. self%archive%is_open()) return
        call self%archive%set(root, 'status', status)
        call self%archive%set(root, 'message', message)
        call self%archive%set(root, 'wall_seconds', self%wall_before + wall_seconds)
        call self%archive%set(root, 'cpu_seconds', self%cpu_before + cpu_seconds)
        call publish(self, .true., error)
        if (allocated(error)) then
            call self%fail(error)
        else
            call self%archive%close(error)
        end if
    end subroutine close_sweep_file

    subroutine fail(self, error)
        class(sweep_file_t), intent(inout) :: self
        type(error_t), intent(in) :: error

        call self%archive%give_up(error%message)
    end subroutine fail

end module gb_sweep_file
