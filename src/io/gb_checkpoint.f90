!> Checkpoints: what a run needs to go on as if it had never stopped, in a file of its own.
!>
!> A checkpoint is an HDF5 file with a seal at its end (gb_files): one damaged bit, or a missing end, and it
!> is refused before HDF5 sees it. It is written aside and takes its name only when it is whole and on the
!> disk, so that there is a good one at every instant. Layout (docs/checkpoints.md):
!>
!>     /               attributes: format, format_version, program_version, git_revision, compiler, created,
!>                     digest (of deck, parameters and tables), results, command, step, abscissa, ...
!>     /deck           the deck's text as read; attribute parameters
!>     /memory/<name>  one array of numbers each: what the methods, the log and the results file remember
module gb_checkpoint
    use, intrinsic :: iso_c_binding, only: c_int64_t
    use, intrinsic :: iso_fortran_env, only: compiler_version
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_file, status_input
    use gb_files, only: seal_file, check_seal, replace_file, remove_file, add_to_digest, empty_digest
    use gb_memory, only: memory_t, item_t
    use gb_problem, only: problem_t
    use gb_text, only: to_text, newline
    use gb_version, only: program_version, git_revision
    use gb_archive, only: archive_t, root, stored_int32
    use gb_hdf5, only: start_hdf5
    use gb_hdf5_input, only: hid_t, open_file, close_file, get_attribute, get_deck, get_numbers, &
        open_group, link_names, max_link
    use gb_results_header, only: now
    implicit none
    private

    integer, parameter :: format_version = 1
    character(*), parameter :: format_name = 'gentbeam checkpoint'
    character(*), parameter :: description = 'what a restart needs'

    !> What makes a run the same run: two with the same origin give the same numbers.
    type, public :: origin_t
        character(:), allocatable :: deck           !! its text
        character(:), allocatable :: parameters     !! "name=value" lines
        character(:), allocatable :: digest         !! of these and of the tables that the deck names
        character(:), allocatable :: program        !! version and revision of the program
    end type origin_t

    type, public :: checkpoint_t
        character(:), allocatable :: created        !! of the run's results file
        character(:), allocatable :: results        !! path of it
        character(:), allocatable :: command        !! name of the command reached
        integer :: step = 0                         !! and its step
        real(wp) :: abscissa = 0.0_wp               !! time or load factor
        real(wp) :: wall_seconds = 0.0_wp           !! of all parts of the run so far [s]
        real(wp) :: cpu_seconds = 0.0_wp
        type(memory_t) :: memory
    end type checkpoint_t

    public :: origin_of, write_checkpoint, read_checkpoint

contains

    pure function origin_of(problem) result(origin)
        type(problem_t), intent(in) :: problem
        type(origin_t) :: origin
        integer(c_int64_t) :: digest
        character(16) :: digits
        integer :: i

        origin%deck = problem%deck_text
        origin%parameters = problem%parameters
        origin%program = program_version // ' (' // git_revision // ')'
        digest = empty_digest
        call add_to_digest(digest, problem%deck_text // newline // problem%parameters)
        do i = 1, size(problem%model%histories)
            associate (history => problem%model%histories(i))
                if (allocated(history%t)) call add_to_digest(digest, history%t)
                if (allocated(history%f)) call add_to_digest(digest, history%f)
            end associate
        end do
        if (allocated(problem%sweep%factors)) then
            do i = 1, size(problem%sweep%factors)
                call add_to_digest(digest, pack(problem%sweep%factors(i)%values, .true.))
            end do
        end if
        write (digits, '(z16.16)') digest
        origin%digest = digits
    end function origin_of

    !> Write the checkpoint aside, and put it in the place of the last one when it is whole. Where that fails,
    !> the last one stays.
    subroutine write_checkpoint(path, origin, checkpoint, error)
        character(*), intent(in) :: path
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(in) :: checkpoint
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: aside, reason
        type(error_t), allocatable :: ignored
        type(archive_t) :: archive

        aside = path // '.new'
        call archive%open(aside, error)
        if (.not. allocated(error)) then
            call put_content(archive, origin, checkpoint)
            call put_memory(archive, checkpoint%memory, error)
            if (.not. allocated(error)) call archive%publish(.true., .true., error)
            if (allocated(error)) then
                call archive%close(ignored)
            else
                call archive%close(error)
            end if
        end if
        if (allocated(error)) then
            ! The archive speaks of a results file; the system's words come last.
            reason = error%message(index(error%message, aside // ': ') + len(aside) + 2:)
        else
            reason = seal_file(aside)
            if (len(reason) == 0) reason = replace_file(aside, path)
        end if
        if (len(reason) == 0) return
        call remove_file(aside)
        call raise(error, status_file, 'cannot write the checkpoint ' // path // ': ' // reason)
    end subroutine write_checkpoint

    subroutine put_content(archive, origin, checkpoint)
        type(archive_t), intent(inout) :: archive
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(in) :: checkpoint
        integer :: node

        call archive%set(root, 'format', format_name)
        call archive%set(root, 'format_version', format_version)
        call archive%set(root, 'program_version', program_version)
        call archive%set(root, 'git_revision', git_revision)
        call archive%set(root, 'compiler', compiler_version())
        call archive%set(root, 'created', now())
        call archive%set(root, 'digest', origin%digest)
        call archive%set(root, 'results', checkpoint%results)
        call archive%set(root, 'results_created', checkpoint%created)
        call archive%set(root, 'command', checkpoint%command)
        call archive%set(root, 'step', checkpoint%step)
        call archive%set(root, 'abscissa', checkpoint%abscissa)
        call archive%set(root, 'wall_seconds', checkpoint%wall_seconds)
        call archive%set(root, 'cpu_seconds', checkpoint%cpu_seconds)
        call archive%put_text(root, 'deck', origin%deck, '', 'the deck as read', node)
        call archive%set(node, 'parameters', origin%parameters)
    end subroutine put_content

    subroutine put_memory(archive, memory, error)
        type(archive_t), intent(inout) :: archive
        type(memory_t), intent(in) :: memory
        type(error_t), allocatable, intent(out) :: error
        integer :: group, i

        call archive%add_group(root, 'memory', group)
        do i = 1, memory%n
            associate (item => memory%items(i))
                if (allocated(item%reals)) then
                    call archive%put(group, item%name, item%reals, '', description, error)
                else
                    call archive%put(group, item%name, item%integers, stored_int32, '', description, error)
                end if
            end associate
            if (allocated(error)) return
        end do
    end subroutine put_memory

    !> Read a checkpoint and see that it is one, whole, by this program, and of this deck. Its memory is ready
    !> to be recalled. Errors: status_file where the file does not do, status_input where the deck does not
    !> fit.
    subroutine read_checkpoint(path, origin, checkpoint, error)
        character(*), intent(in) :: path
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(out) :: checkpoint
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: reason
        integer(hid_t) :: file
        logical :: is_whole

        call check_seal(path, is_whole, reason)
        if (len(reason) > 0) then
            call raise(error, status_file, 'cannot read the checkpoint ' // path // ': ' // reason)
        else if (.not. is_whole) then
            call raise(error, status_file, 'cannot restart from ' // path // ': it is no checkpoint of ' &
                // 'gentbeam, or it is damaged')
        end if
        if (allocated(error)) return
        call start_hdf5()
        call open_file(path, file, error)
        if (.not. allocated(error)) then
            call read_content(file, origin, checkpoint, error)
            call close_file(file)
        end if
        if (allocated(error)) error%message = 'cannot restart from ' // path // ': ' // error%message
    end subroutine read_checkpoint

    subroutine read_content(file, origin, checkpoint, error)
        integer(hid_t), intent(in) :: file
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(inout) :: checkpoint
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: format, version, revision
        integer :: number

        call get_attribute(file, 'format', format, error)
        if (.not. allocated(error)) call get_attribute(file, 'format_version', number, error)
        if (.not. allocated(error)) call get_attribute(file, 'program_version', version, error)
        if (.not. allocated(error)) call get_attribute(file, 'git_revision', revision, error)
        if (allocated(error)) return
        if (format /= format_name) then
            call raise(error, status_file, 'it is no checkpoint')
        else if (version // ' (' // revision // ')' /= origin%program) then
            call raise(error, status_file, 'it was written by gentbeam ' // version // ' (' // revision &
                // '), and this is ' // origin%program // '; only the same program goes on exactly')
        else if (number /= format_version) then
            call raise(error, status_file, 'its format has version ' // to_text(number) // ', and this ' &
                // 'program reads version ' // to_text(format_version))
        end if
        if (.not. allocated(error)) call check_origin(file, origin, error)
        if (.not. allocated(error)) call get_attribute(file, 'results', checkpoint%results, error)
        if (.not. allocated(error)) call get_attribute(file, 'results_created', checkpoint%created, error)
        if (.not. allocated(error)) call get_attribute(file, 'command', checkpoint%command, error)
        if (.not. allocated(error)) call get_attribute(file, 'step', checkpoint%step, error)
        if (.not. allocated(error)) call get_attribute(file, 'abscissa', checkpoint%abscissa, error)
        if (.not. allocated(error)) call get_attribute(file, 'wall_seconds', checkpoint%wall_seconds, error)
        if (.not. allocated(error)) call get_attribute(file, 'cpu_seconds', checkpoint%cpu_seconds, error)
        if (.not. allocated(error)) call read_memory(file, checkpoint%memory, error)
    end subroutine read_content

    !> Whether the checkpoint is of the same deck, with the same parameters and tables.
    subroutine check_origin(file, origin, error)
        integer(hid_t), intent(in) :: file
        type(origin_t), intent(in) :: origin
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: deck, parameters, digest

        call get_deck(file, deck, parameters, error)
        if (.not. allocated(error)) call get_attribute(file, 'digest', digest, error)
        if (allocated(error)) return
        if (deck /= origin%deck .or. len(deck) /= len(origin%deck)) then
            call raise(error, status_input, 'it belongs to another deck; the first line that differs is ' &
                // to_text(first_difference(deck, origin%deck)) // ': ' &
                // difference(deck, origin%deck))
        else if (parameters /= origin%parameters) then
            call raise(error, status_input, 'the parameters differ: ' &
                // difference(parameters, origin%parameters) // ' (--set)')
        else if (digest /= origin%digest) then
            call raise(error, status_input, 'a table that the deck reads from a file has changed')
        end if
    end subroutine check_origin

    !> Number of the first line in which two texts differ.
    pure integer function first_difference(first, second) result(number)
        character(*), intent(in) :: first, second
        integer :: i

        number = 1
        do i = 1, min(len(first), len(second))
            if (first(i:i) /= second(i:i)) return
            if (first(i:i) == newline) number = number + 1
        end do
    end function first_difference

    !> That line of both.
    pure function difference(then, now) result(text)
        character(*), intent(in) :: then, now
        character(:), allocatable :: text

        character(:), allocatable :: old, new
        integer :: number, column

        number = first_difference(then, now)
        old = line_of(then, number)
        new = line_of(now, number)
        if (bare(old) == bare(new) .and. len(bare(old)) == len(bare(new))) then
            text = 'it ends in another way (CR LF, LF), or has a byte-order mark'
            return
        end if
        column = 1
        do while (column < min(len(old), len(new)))
            if (old(column:column) /= new(column:column)) exit
            column = column + 1
        end do
        text = 'then ''' // excerpt(old, column) // ''', now ''' // excerpt(new, column) // ''''
    end function difference

    !> A line without what editors put around it: a byte-order mark before, a carriage return behind.
    pure function bare(line) result(text)
        character(*), intent(in) :: line
        character(:), allocatable :: text

        text = line
        if (index(text, char(239) // char(187) // char(191)) == 1) text = text(4:)
        if (len(text) > 0) then
            if (text(len(text):) == achar(13)) text = text(:len(text) - 1)
        end if
    end function bare

    !> The part of a long line that is around a column.
    pure function excerpt(line, column) result(text)
        character(*), intent(in) :: line
        integer, intent(in) :: column
        character(:), allocatable :: text
        integer, parameter :: longest = 80
        integer :: first, last

        first = 1
        if (len(line) > longest) first = max(1, column - longest/2)
        last = min(len(line), first + longest - 1)
        text = line(first:last)
        if (first > 1) text = '...' // text
        if (last < len(line)) text = text // '...'
    end function excerpt

    pure function line_of(text, number) result(line)
        character(*), intent(in) :: text
        integer, intent(in) :: number
        character(:), allocatable :: line
        integer :: first, last, i

        first = 1
        do i = 1, number - 1
            first = first + index(text(first:), newline)
        end do
        last = index(text(first:), newline)
        if (last == 0) last = len(text) - first + 2
        line = text(first:first + last - 2)
    end function line_of

    subroutine read_memory(file, memory, error)
        integer(hid_t), intent(in) :: file
        type(memory_t), intent(inout) :: memory
        type(error_t), allocatable, intent(out) :: error
        type(error_t), allocatable :: no_reals
        character(max_link), allocatable :: names(:)
        integer(hid_t) :: group
        type(item_t) :: item
        integer :: i

        call memory%clear()
        call open_group(file, 'memory', group, error)
        if (.not. allocated(error)) call link_names(group, names, error)
        if (allocated(error)) return
        do i = 1, size(names)
            if (allocated(error)) return
            item%name = trim(names(i))
            call get_numbers(file, 'memory/' // item%name, item%reals, no_reals)
            if (allocated(no_reals)) then
                if (allocated(item%reals)) deallocate (item%reals)
                call get_numbers(file, 'memory/' // item%name, item%integers, error)
            end if
            call memory%add(item)
            if (allocated(item%integers)) deallocate (item%integers)
        end do
        memory%is_recalling = .true.
    end subroutine read_memory

end module gb_checkpoint
