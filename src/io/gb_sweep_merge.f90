!> Joins the files of a study's shards into one, which holds the same as that of a run that was not divided;
!> or puts the members of one file into their order.
module gb_sweep_merge
    use gb_kinds, only: wp
    use gb_archive, only: archive_t, root, stored_real64, stored_int32, stored_int8
    use gb_error, only: error_t, raise, status_file, status_input
    use gb_files, only: is_file, is_same_file
    use gb_hdf5, only: start_hdf5
    use gb_hdf5_input, only: hid_t, text_t, max_link, open_file, close_file, open_group, has_link, &
        link_names, get_attribute, get_dataset_attribute, get_deck, get_table, get_texts, get_text_list, &
        verify
    use gb_member, only: member_waiting, member_failed
    use gb_member_file, only: member_name
    use gb_model, only: units_t
    use gb_names, only: max_name
    use gb_posix, only: raise_file_limit
    use gb_results_header, only: write_units
    use gb_share, only: share_t, study_end
    use gb_sweep_file, only: members_a_batch
    implicit none
    private

    !> A file to be joined.
    type :: shard_t
        character(:), allocatable :: path
        type(share_t) :: share
        integer(hid_t) :: file = -1, sweep = -1, summary = -1, members = -1
    end type shard_t

    !> Where a member's row is: in which shard, and at which place of it; nowhere: 0.
    type :: place_t
        integer :: shard = 0, row = 0
    end type place_t

    !> What became of the study.
    type, public :: merged_t
        integer :: members = 0, failed = 0
        integer, allocatable :: missing(:)          !! numbers of the members that no file has
    end type merged_t

    public :: merge_shards, sort_members

contains

    !> Join the shards into a new file at `path`. Members that are missing have no row in it.
    subroutine merge_shards(path, paths, merged, error)
        character(*), intent(in) :: path
        character(*), intent(in) :: paths(:)        !! of the shards, padded with blanks
        type(merged_t), intent(out) :: merged
        type(error_t), allocatable, intent(out) :: error
        type(shard_t), allocatable :: shards(:)
        type(place_t), allocatable :: places(:)     !! by number
        character(:), allocatable :: status, message
        integer :: i

        call raise_file_limit()
        call start_hdf5()
        if (is_shard(path)) then
            call raise(error, status_input, path // ' is to be written, and is the results of a shard: ' &
                // 'name the file for all of them first, --merge OUT.h5 FILE...')
            return
        end if
        allocate (shards(size(paths)))
        do i = 1, size(paths)
            shards(i)%path = trim(paths(i))
            if (is_same_file(shards(i)%path, path)) then
                call raise(error, status_file, path // ' is to be written, and cannot be joined with itself')
            else
                call open_shard(shards(i), error)
            end if
            if (allocated(error)) return
            call check_fit(shards(:i), error)
            if (allocated(error)) return
        end do
        allocate (places(shards(1)%share%members))
        do i = 1, size(shards)
            call find_members(shards(i), i, places, merged%failed, error)
            if (allocated(error)) return
        end do
        merged%members = size(places)
        merged%missing = pack([(i, i=1, size(places))], places%shard == 0)
        call study_end(merged%members, merged%failed, size(merged%missing), status, message)
        call write_joined(path, shards, places, share_t(members=size(places)), status, message, error)
    end subroutine merge_shards

    !> Put the members of a file into the order of their numbers. It is replaced when the new one is whole.
    subroutine sort_members(path, error)
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error
        type(shard_t) :: shard
        type(place_t), allocatable :: places(:)
        character(:), allocatable :: status, message
        integer :: failed

        shard%path = path
        failed = 0
        call open_shard(shard, error)
        if (allocated(error)) return
        allocate (places(shard%share%members))
        call find_members(shard, 1, places, failed, error)
        if (.not. allocated(error)) call get_attribute(shard%file, 'status', status, error)
        if (.not. allocated(error)) call get_attribute(shard%file, 'message', message, error)
        if (.not. allocated(error)) call write_joined(path, [shard], places, shard%share, status, &
            message, error)
    end subroutine sort_members

    !> A file with the rows of the shards' members, in the order of their numbers; the shards are closed.
    subroutine write_joined(path, shards, places, share, status, message, error)
        character(*), intent(in) :: path, status, message
        type(shard_t), intent(in) :: shards(:)
        type(place_t), intent(in) :: places(:)
        type(share_t), intent(in) :: share              !! what the file holds of the study
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: ignored
        type(archive_t) :: archive
        integer :: i

        call archive%open(path, error)
        if (allocated(error)) return
        call write_root(archive, shards, status, message, error)
        if (.not. allocated(error)) call write_sweep(archive, shards, places, share, error)
        if (.not. allocated(error)) call archive%publish(.true., .true., error)
        if (allocated(error)) then
            call archive%close(ignored)
        else
            call archive%close(error)
        end if
        do i = 1, size(shards)
            call close_file(shards(i)%file)
        end do
    end subroutine write_joined

    !> Whether a file is there that holds a shard of a study.
    logical function is_shard(path)
        character(*), intent(in) :: path
        type(error_t), allocatable :: error
        integer(hid_t) :: file, group
        integer :: shards

        is_shard = .false.
        if (.not. is_file(path)) return
        call open_file(path, file, error)
        if (allocated(error)) return
        if (has_link(file, 'sweep')) then
            call open_group(file, 'sweep', group, error)
            if (.not. allocated(error)) call get_attribute(group, 'shards', shards, error)
            is_shard = .not. allocated(error) .and. shards > 1
        end if
        call close_file(file)
    end function is_shard

    subroutine open_shard(shard, error)
        type(shard_t), intent(inout) :: shard
        type(error_t), allocatable, intent(out) :: error
        logical :: exists

        inquire (file=shard%path, exist=exists)
        if (.not. exists) then
            call raise(error, status_file, 'cannot read ' // shard%path // ': there is no such file')
            return
        end if
        call open_file(shard%path, shard%file, error)
        if (.not. allocated(error)) call verify(shard%file, error)
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

    !> Note where the members of a shard are that have run, and how many of them failed.
    subroutine find_members(shard, number, places, failed, error)
        type(shard_t), intent(in) :: shard
        integer, intent(in) :: number
        type(place_t), intent(inout) :: places(:)
        integer, intent(inout) :: failed
        type(error_t), allocatable, intent(out) :: error
        real(wp), allocatable :: numbers(:, :), outcomes(:, :)
        integer :: i

        call get_table(shard%sweep, 'number', numbers, error)
        if (.not. allocated(error)) call get_table(shard%sweep, 'status', outcomes, error)
        if (allocated(error)) then
            error%message = 'cannot read ' // shard%path // ': ' // error%message
            return
        end if
        if (any(numbers < 1.0_wp .or. numbers > real(size(places), wp)) &
            .or. size(outcomes) /= size(numbers)) then
            call raise(error, status_file, 'cannot read ' // shard%path // ': it is damaged')
            return
        end if
        do i = 1, size(numbers)
            if (nint(outcomes(1, i)) == member_waiting) cycle
            if (nint(outcomes(1, i)) == member_failed) failed = failed + 1
            places(nint(numbers(1, i))) = place_t(number, i)
        end do
    end subroutine find_members

    !> What the shards' files say alike of the run, the sums of what they do not, and how the study ended.
    subroutine write_root(archive, shards, status, message, error)
        type(archive_t), intent(inout) :: archive
        type(shard_t), intent(in) :: shards(:)
        character(*), intent(in) :: status, message
        type(error_t), allocatable, intent(out) :: error
        character(16), parameter :: texts(6) = [character(16) :: 'format', 'program_version', &
            'git_revision', 'compiler', 'title', 'created']
        type(units_t) :: units
        integer(hid_t) :: group
        character(:), allocatable :: text
        real(wp) :: wall, cpu, seconds
        integer :: i, version

        call get_attribute(shards(1)%file, 'format_version', version, error)
        call archive%set(root, 'format_version', version)
        do i = 1, size(texts)
            if (.not. allocated(error)) call get_attribute(shards(1)%file, trim(texts(i)), text, error)
            if (.not. allocated(error)) call archive%set(root, trim(texts(i)), text)
        end do
        wall = 0.0_wp
        cpu = 0.0_wp
        do i = 1, size(shards)
            if (.not. allocated(error)) call get_attribute(shards(i)%file, 'wall_seconds', seconds, error)
            wall = max(wall, seconds)
            if (.not. allocated(error)) call get_attribute(shards(i)%file, 'cpu_seconds', seconds, error)
            cpu = cpu + seconds
        end do
        if (allocated(error)) return
        call archive%set(root, 'status', status)
        call archive%set(root, 'message', message)
        call archive%set(root, 'wall_seconds', wall)
        call archive%set(root, 'cpu_seconds', cpu)
        call open_group(shards(1)%file, 'units', group, error)
        if (.not. allocated(error)) call get_attribute(group, 'length', units%length, error)
        if (.not. allocated(error)) call get_attribute(group, 'force', units%force, error)
        if (.not. allocated(error)) call get_attribute(group, 'time', units%time, error)
        if (allocated(error)) return
        call write_units(archive, units)
        call archive%keep_copies(root, spread(shards(1)%file, 1, 2), ['deck', 'mesh'], error)
    end subroutine write_root

    subroutine write_sweep(archive, shards, places, share, error)
        type(archive_t), intent(inout) :: archive
        type(shard_t), intent(in) :: shards(:)
        type(place_t), intent(in) :: places(:)
        type(share_t), intent(in) :: share
        type(error_t), allocatable, intent(out) :: error
        character(max_link), allocatable :: names(:)
        character(:), allocatable :: parameters
        integer :: sweep, summary, node, i

        call archive%add_group(root, 'sweep', sweep)
        call archive%set(sweep, 'members', share%members)
        call archive%set(sweep, 'shard', share%shard)
        call archive%set(sweep, 'shards', share%shards)
        call join(archive, sweep, shards%sweep, shards, 'number', stored_int32, places, node, error)
        if (.not. allocated(error)) call join(archive, sweep, shards%sweep, shards, 'parameters', &
            stored_real64, places, node, error)
        if (.not. allocated(error)) call get_text_list(shards(1)%sweep, 'parameters', 'names', &
            parameters, error)
        if (allocated(error)) return
        call archive%set_list(node, 'names', split(parameters))
        call join(archive, sweep, shards%sweep, shards, 'status', stored_int8, places, node, error)
        if (.not. allocated(error)) call join_messages(archive, sweep, shards, places, error)
        if (.not. allocated(error)) call link_names(shards(1)%summary, names, error)
        if (allocated(error)) return
        call archive%add_group(sweep, 'summary', summary)
        do i = 1, size(names)
            if (.not. allocated(error)) call join(archive, summary, shards%summary, shards, trim(names(i)), &
                stored_real64, places, node, error)
        end do
        if (shards(1)%members >= 0 .and. .not. allocated(error)) call join_members(archive, sweep, shards, &
            places, error)
    end subroutine write_sweep

    !> A dataset of one row a member, put together from the shards' rows.
    subroutine join(archive, into, groups, shards, name, stored, places, node, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: into
        integer(hid_t), intent(in) :: groups(:)         !! of the shards' files
        type(shard_t), intent(in) :: shards(:)
        character(*), intent(in) :: name
        integer, intent(in) :: stored
        type(place_t), intent(in) :: places(:)
        integer, intent(out) :: node                    !! of the series
        type(error_t), allocatable, intent(out) :: error
        type :: table_t
            real(wp), allocatable :: rows(:, :)
        end type table_t
        type(table_t), allocatable :: tables(:)
        character(:), allocatable :: unit, description
        integer :: i, number

        node = 0
        call get_dataset_attribute(groups(1), name, 'unit', unit, error)
        if (.not. allocated(error)) call get_dataset_attribute(groups(1), name, 'description', &
            description, error)
        allocate (tables(size(shards)))
        do i = 1, size(shards)
            if (.not. allocated(error)) call get_table(groups(i), name, tables(i)%rows, error)
            if (.not. allocated(error)) then
                if (size(tables(i)%rows, 2) < maxval(places%row, mask=places%shard == i) .or. &
                    size(tables(i)%rows, 1) /= size(tables(1)%rows, 1)) call raise(error, status_file, name &
                    // ' is damaged')
            end if
            if (allocated(error)) then
                error%message = 'cannot read ' // shards(i)%path // ': ' // error%message
                return
            end if
        end do
        if (size(tables(1)%rows, 1) == 1 .and. name /= 'parameters' .and. index(name, '_frequency') == 0) then
            call archive%add_series(into, name, [integer ::], stored, unit, description, node)
        else
            call archive%add_series(into, name, [size(tables(1)%rows, 1)], stored, unit, description, node)
        end if
        do number = 1, size(places)
            associate (place => places(number))
                if (place%shard == 0) cycle
                call archive%append(node, tables(place%shard)%rows(:, place%row), error)
                if (allocated(error)) return
            end associate
        end do
    end subroutine join

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

    subroutine join_messages(archive, sweep, shards, places, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: sweep
        type(shard_t), intent(in) :: shards(:)
        type(place_t), intent(in) :: places(:)
        type(error_t), allocatable, intent(out) :: error
        type :: messages_t
            type(text_t), allocatable :: texts(:)
        end type messages_t
        type(messages_t), allocatable :: messages(:)
        character(:), allocatable :: description
        integer :: i, number, node

        allocate (messages(size(shards)))
        do i = 1, size(shards)
            call get_texts(shards(i)%sweep, 'message', messages(i)%texts, error)
            if (.not. allocated(error)) then
                if (size(messages(i)%texts) < maxval(places%row, mask=places%shard == i)) call raise(error, &
                    status_file, 'message is damaged')
            end if
            if (allocated(error)) then
                error%message = 'cannot read ' // shards(i)%path // ': ' // error%message
                return
            end if
        end do
        call get_dataset_attribute(shards(1)%sweep, 'message', 'description', description, error)
        if (allocated(error)) return
        call archive%add_texts(sweep, 'message', description, node)
        do number = 1, size(places)
            associate (place => places(number))
                if (place%shard > 0) call archive%append_text(node, &
                    messages(place%shard)%texts(place%row)%text)
            end associate
        end do
    end subroutine join_messages

    subroutine join_members(archive, sweep, shards, places, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: sweep
        type(shard_t), intent(in) :: shards(:)
        type(place_t), intent(in) :: places(:)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: sources(members_a_batch)
        character(16) :: names(members_a_batch)
        integer :: members, number, n

        call archive%add_group(sweep, 'members', members)
        n = 0
        do number = 1, size(places)
            if (places(number)%shard > 0) then
                n = n + 1
                sources(n) = shards(places(number)%shard)%members
                names(n) = member_name(number, size(places))
            end if
            if (n < members_a_batch .and. number < size(places) .or. n == 0) cycle
            call archive%keep_copies(members, sources(:n), names(:n), error)
            if (allocated(error)) return
            n = 0
        end do
    end subroutine join_members

end module gb_sweep_merge
