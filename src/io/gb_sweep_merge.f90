!> Joins the files of a study's shards into one, which holds the same as that of a run that was not divided.
module gb_sweep_merge
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_file
    use gb_hdf5_direct, only: hid_t, create_file, flush_file, close_file, create_group, close_group, &
        put_attribute, replace_attribute
    use gb_hdf5_input, only: get_attribute, get_deck
    use gb_hdf5_read, only: open_file, open_group, has_link, copy_object, link_names, max_link, &
        get_text_list
    use gb_hdf5_table, only: table_t, text_table_t, put_text_list
    use gb_member, only: member_waiting, member_failed
    use gb_member_file, only: member_name
    use gb_names, only: max_name
    use gb_claim, only: claim_file, explain_failure
    use gb_posix, only: raise_file_limit
    use gb_share, only: share_t, study_end
    implicit none
    private

    !> A file to be joined.
    type :: shard_t
        character(:), allocatable :: path
        type(share_t) :: share
        integer(hid_t) :: file = -1, sweep = -1, summary = -1, members = -1
    end type shard_t

    !> What became of the study.
    type, public :: merged_t
        integer :: members = 0, failed = 0
        integer, allocatable :: missing(:)          !! numbers of the members that no file has
    end type merged_t

    !> Numbers of members that are carried over at once.
    integer, parameter :: block = 65536

    public :: merge_shards

contains

    !> Join the shards into a new file at `path`. Members that are missing have no row in it.
    subroutine merge_shards(path, paths, merged, error)
        character(*), intent(in) :: path
        character(*), intent(in) :: paths(:)        !! of the shards, padded with blanks
        type(merged_t), intent(out) :: merged
        type(error_t), allocatable, intent(out) :: error
        type(shard_t), allocatable :: shards(:)
        integer, allocatable :: outcomes(:)         !! by number
        integer(hid_t) :: file
        character(:), allocatable :: reason
        integer :: i

        call raise_file_limit()
        allocate (shards(size(paths)))
        do i = 1, size(paths)
            shards(i)%path = trim(paths(i))
            if (shards(i)%path == path) then
                call raise(error, status_file, path // ' is to be written, and cannot be joined with itself')
            else
                call open_shard(shards(i), error)
            end if
            if (allocated(error)) return
            call check_fit(shards(:i), error)
            if (allocated(error)) return
        end do
        allocate (outcomes(shards(1)%share%members), source=member_waiting)
        do i = 1, size(shards)
            call read_outcomes(shards(i), outcomes, error)
            if (allocated(error)) return
        end do
        merged%members = size(outcomes)
        merged%failed = count(outcomes == member_failed)
        merged%missing = pack([(i, i=1, size(outcomes))], outcomes == member_waiting)
        reason = claim_file(path)
        if (len(reason) > 0) then
            call raise(error, status_file, 'cannot write the results file ' // path // ': ' // reason)
            return
        end if
        call create_file(path, file, error)
        if (.not. allocated(error)) call write_root(file, shards, error)
        if (.not. allocated(error)) call write_sweep(file, shards, outcomes, error)
        if (.not. allocated(error)) call say_end(file, merged, error)
        if (.not. allocated(error)) call close_file(file, error)
        if (allocated(error)) call explain_failure(path, error)
    end subroutine merge_shards

    subroutine open_shard(shard, error)
        type(shard_t), intent(inout) :: shard
        type(error_t), allocatable, intent(out) :: error
        logical :: exists

        inquire (file=shard%path, exist=exists)
        if (.not. exists) then
            call raise(error, status_file, 'cannot read ' // shard%path // ': there is no such file')
            return
        end if
        call open_file(shard%path, .false., shard%file, error)
        if (.not. allocated(error)) call open_group(shard%file, 'sweep', shard%sweep, error)
        if (.not. allocated(error)) call get_attribute(shard%sweep, 'members', shard%share%members, &
            error)
        if (.not. allocated(error)) call get_attribute(shard%sweep, 'shard', shard%share%shard, error)
        if (.not. allocated(error)) call get_attribute(shard%sweep, 'shards', shard%share%shards, &
            error)
        if (.not. allocated(error)) call open_group(shard%sweep, 'summary', shard%summary, error)
        if (.not. allocated(error)) then
            if (has_link(shard%sweep, 'members')) call open_group(shard%sweep, 'members', shard%members, &
                error)
        end if
        if (allocated(error)) error%message = 'cannot read ' // shard%path // ' as the results of a SWEEP: ' &
            // error%message
    end subroutine open_shard

    !> The last of the shards belongs to the same study as the first, and is none of those before.
    subroutine check_fit(shards, error)
        type(shard_t), intent(in) :: shards(:)
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: deck, parameters, other_deck, other_parameters, revision, other_revision
        integer :: i

        associate (first => shards(1), last => shards(size(shards)))
            call get_deck(first%file, deck, parameters, error)
            if (.not. allocated(error)) call get_deck(last%file, other_deck, other_parameters, error)
            if (.not. allocated(error)) call get_attribute(first%file, 'git_revision', revision, error)
            if (.not. allocated(error)) call get_attribute(last%file, 'git_revision', other_revision, &
                error)
            if (allocated(error)) then
                error%message = 'cannot read ' // last%path // ': ' // error%message
                return
            end if
            if (deck /= other_deck .or. parameters /= other_parameters .or. first%share%members /= &
                last%share%members .or. first%share%shards /= last%share%shards) then
                call raise(error, status_file, last%path // ' and ' // first%path // &
                    ' are not of the same study: deck, parameters or number of shards differ')
                return
            end if
            if (revision /= other_revision) then
                call raise(error, status_file, last%path // ' and ' // first%path // &
                    ' were written by different versions of the program')
                return
            end if
            do i = 1, size(shards) - 1
                if (shards(i)%share%shard == last%share%shard) call raise(error, status_file, last%path // &
                    ' and ' // shards(i)%path // ' hold the same shard')
            end do
        end associate
    end subroutine check_fit

    subroutine read_outcomes(shard, outcomes, error)
        type(shard_t), intent(in) :: shard
        integer, intent(inout) :: outcomes(:)
        type(error_t), allocatable, intent(out) :: error
        type(table_t) :: status
        real(wp), allocatable :: rows(:, :)
        integer :: n, i

        call status%open(shard%sweep, 'status', n, error)
        if (allocated(error)) return
        allocate (rows(1, n))
        call status%read(0, rows, error)
        do i = 1, n
            outcomes(shard%share%number(i)) = nint(rows(1, i))
        end do
        call status%close()
    end subroutine read_outcomes

    !> What the shards' files say alike of the run, and the sums of what they do not.
    subroutine write_root(file, shards, error)
        integer(hid_t), intent(in) :: file
        type(shard_t), intent(in) :: shards(:)
        type(error_t), allocatable, intent(out) :: error
        character(16), parameter :: texts(8) = [character(16) :: 'format', 'program_version', &
            'git_revision', &
            'compiler', 'title', 'created', 'status', 'message']
        character(:), allocatable :: text
        real(wp) :: wall, cpu, seconds
        integer :: i, version

        call get_attribute(shards(1)%file, 'format_version', version, error)
        if (.not. allocated(error)) call put_attribute(file, 'format_version', version, error)
        do i = 1, size(texts)
            if (.not. allocated(error)) call get_attribute(shards(1)%file, trim(texts(i)), text, error)
            if (.not. allocated(error)) call put_attribute(file, trim(texts(i)), text, error)
        end do
        wall = 0.0_wp
        cpu = 0.0_wp
        do i = 1, size(shards)
            if (.not. allocated(error)) call get_attribute(shards(i)%file, 'wall_seconds', seconds, &
                error)
            wall = max(wall, seconds)
            if (.not. allocated(error)) call get_attribute(shards(i)%file, 'cpu_seconds', seconds, error)
            cpu = cpu + seconds
        end do
        if (.not. allocated(error)) call put_attribute(file, 'wall_seconds', wall, error)
        if (.not. allocated(error)) call put_attribute(file, 'cpu_seconds', cpu, error)
        if (.not. allocated(error)) call copy_object(shards(1)%file, 'deck', file, error)
        if (.not. allocated(error)) call copy_object(shards(1)%file, 'units', file, error)
        if (.not. allocated(error)) call copy_object(shards(1)%file, 'mesh', file, error)
    end subroutine write_root

    subroutine write_sweep(file, shards, outcomes, error)
        integer(hid_t), intent(in) :: file
        type(shard_t), intent(in) :: shards(:)
        integer, intent(in) :: outcomes(:)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: sweep, summary
        character(max_link), allocatable :: names(:)
        integer(hid_t), allocatable :: groups(:)
        integer :: i

        call create_group(file, 'sweep', sweep, error)
        if (.not. allocated(error)) call put_attribute(sweep, 'members', size(outcomes), error)
        if (.not. allocated(error)) call put_attribute(sweep, 'shard', 1, error)
        if (.not. allocated(error)) call put_attribute(sweep, 'shards', 1, error)
        groups = shards%sweep
        if (.not. allocated(error)) call join_table(sweep, groups, shards%share, 'number', outcomes, error)
        if (.not. allocated(error)) call join_table(sweep, groups, shards%share, 'parameters', outcomes, &
            error)
        if (.not. allocated(error)) call join_table(sweep, groups, shards%share, 'status', outcomes, error)
        if (.not. allocated(error)) call join_messages(sweep, shards, outcomes, error)
        if (.not. allocated(error)) call create_group(sweep, 'summary', summary, error)
        if (.not. allocated(error)) call link_names(shards(1)%summary, names, error)
        if (allocated(error)) return
        groups = shards%summary
        do i = 1, size(names)
            if (.not. allocated(error)) call join_table(summary, groups, shards%share, trim(names(i)), &
                outcomes, error)
        end do
        if (allocated(error)) return
        call close_group(summary)
        if (shards(1)%members >= 0) call join_members(sweep, shards, outcomes, error)
        if (.not. allocated(error)) call close_group(sweep)
    end subroutine write_sweep

    !> A dataset of one row a member, put together from the shards' rows.
    subroutine join_table(into, groups, shares, name, outcomes, error)
        integer(hid_t), intent(in) :: into, groups(:)
        type(share_t), intent(in) :: shares(:)
        character(*), intent(in) :: name
        integer, intent(in) :: outcomes(:)
        type(error_t), allocatable, intent(out) :: error
        type(table_t) :: joined, part
        real(wp), allocatable :: rows(:, :), mine(:, :)
        character(:), allocatable :: words
        integer :: before, count_, written, i, k, n, first, last, columns

        call part%open(groups(1), name, n, error)
        if (allocated(error)) return
        call joined%create_like(into, name, count(outcomes /= member_waiting), part, error)
        if (name == 'parameters' .and. .not. allocated(error)) then
            call get_text_list(part%dataset, 'names', words, error)
            if (.not. allocated(error)) call put_text_list(joined%dataset, 'names', split(words), error)
        end if
        columns = max(1, part%columns)
        call part%close()
        written = 0
        do before = 0, size(outcomes) - 1, block
            count_ = min(block, size(outcomes) - before)
            allocate (rows(columns, count_))
            do i = 1, size(groups)
                if (allocated(error)) return
                call positions_between(shares(i), before + 1, before + count_, first, last)
                if (last < first) cycle
                allocate (mine(columns, last - first + 1))
                call part%open(groups(i), name, n, error)
                if (.not. allocated(error)) call part%read(first - 1, mine, error)
                call part%close()
                do k = first, last
                    rows(:, shares(i)%number(k) - before) = mine(:, k - first + 1)
                end do
                deallocate (mine)
            end do
            ! The rows of members that are there move together.
            n = 0
            do k = 1, count_
                if (outcomes(before + k) == member_waiting) cycle
                n = n + 1
                if (n < k) rows(:, n) = rows(:, k)
            end do
            if (n > 0) then
                mine = rows(:, :n)
                if (.not. allocated(error)) call joined%write(written, mine, error)
                deallocate (mine)
            end if
            written = written + n
            deallocate (rows)
        end do
        call joined%close()
    end subroutine join_table

    !> Positions of a share whose members have numbers from `low` to `high`.
    pure subroutine positions_between(share, low, high, first, last)
        type(share_t), intent(in) :: share
        integer, intent(in) :: low, high
        integer, intent(out) :: first, last

        first = 1
        if (low > share%shard) first = (low - share%shard + share%shards - 1)/share%shards + 1
        last = 0
        if (high >= share%shard) last = min(share%n(), (high - share%shard)/share%shards + 1)
    end subroutine positions_between

    pure function split(words) result(names)
        character(*), intent(in) :: words           !! each with a blank behind it
        character(max_name), allocatable :: names(:)
        integer :: first, last

        allocate (names(0))
        first = 1
        do while (first <= len(words))
            last = first + index(words(first:), ' ') - 2
            names = [character(max_name) :: names, words(first:last)]
            first = last + 2
        end do
    end function split

    subroutine join_messages(sweep, shards, outcomes, error)
        integer(hid_t), intent(in) :: sweep
        type(shard_t), intent(in) :: shards(:)
        integer, intent(in) :: outcomes(:)
        type(error_t), allocatable, intent(out) :: error
        type(text_table_t) :: joined
        type(text_table_t), allocatable :: parts(:)
        character(:), allocatable :: text
        integer, allocatable :: holder(:)
        integer :: i, number, written

        call find_holders(shards, holder)
        allocate (parts(size(shards)))
        do i = 1, size(shards)
            if (.not. allocated(error)) call parts(i)%open(shards(i)%sweep, 'message', error)
        end do
        if (.not. allocated(error)) call joined%create(sweep, 'message', count(outcomes /= member_waiting), &
            'why a member failed; else empty', error)
        written = 0
        do number = 1, size(outcomes)
            if (allocated(error)) return
            if (outcomes(number) == member_waiting) cycle
            written = written + 1
            if (outcomes(number) /= member_failed) cycle
            i = holder(modulo(number - 1, size(holder)) + 1)
            call parts(i)%read(shards(i)%share%position(number) - 1, text, error)
            if (.not. allocated(error)) call joined%write(written - 1, text, error)
        end do
        do i = 1, size(shards)
            call parts(i)%close()
        end do
        call joined%close()
    end subroutine join_messages

    !> By shard's number: which of the files holds it, 0 for none.
    pure subroutine find_holders(shards, holder)
        type(shard_t), intent(in) :: shards(:)
        integer, allocatable, intent(out) :: holder(:)
        integer :: i

        allocate (holder(shards(1)%share%shards), source=0)
        do i = 1, size(shards)
            holder(shards(i)%share%shard) = i
        end do
    end subroutine find_holders

    subroutine join_members(sweep, shards, outcomes, error)
        integer(hid_t), intent(in) :: sweep
        type(shard_t), intent(in) :: shards(:)
        integer, intent(in) :: outcomes(:)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: members
        integer, allocatable :: holder(:)
        integer :: number

        call find_holders(shards, holder)
        call create_group(sweep, 'members', members, error)
        do number = 1, size(outcomes)
            if (allocated(error)) return
            if (outcomes(number) == member_waiting) cycle
            call copy_object(shards(holder(modulo(number - 1, size(holder)) + 1))%members, &
                member_name(number, size(outcomes)), members, error)
        end do
        if (.not. allocated(error)) call close_group(members)
    end subroutine join_members

    !> How the study ended, in the words that an undivided run uses.
    subroutine say_end(file, merged, error)
        integer(hid_t), intent(in) :: file
        type(merged_t), intent(in) :: merged
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: status, message

        call study_end(merged%members, merged%failed, size(merged%missing), status, message)
        call replace_attribute(file, 'status', status, error)
        if (.not. allocated(error)) call replace_attribute(file, 'message', message, error)
        if (.not. allocated(error)) call flush_file(file, error)
    end subroutine say_end

end module gb_sweep_merge
