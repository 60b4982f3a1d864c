!> The command line: options as docs/results.md lists them.
module gb_command_line
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_input
    use gb_text, only: nearest_name, newline
    use gb_log, only: log_quiet, log_normal, log_verbose
    use gb_deck, only: override_t
    use gb_options, only: option_entry_t, option_table
    implicit none
    private

    integer, parameter :: max_path = 4096           !! bytes of a file's path

    type, public :: options_t
        character(:), allocatable :: deck           !! path; empty for standard input
        character(:), allocatable :: output         !! replaces OUTPUT file=; empty where not given
        type(override_t), allocatable :: overrides(:)
        logical :: check_only = .false.
        logical :: show_keywords = .false., as_markdown = .false.
        logical :: show_version = .false.
        logical :: show_help = .false.
        logical :: show_manual = .false.
        logical :: show_completion = .false.
        character(:), allocatable :: restart        !! checkpoint to go on from; empty where not given
        real(wp) :: max_seconds = 0.0_wp            !! of --max-time [s]; 0: no limit
        integer :: threads = 0                      !! 0: not given
        integer :: shard = 1, shards = 0            !! shards = 0: not given
        logical :: shard_from_environment = .false. !! --shard auto
        character(:), allocatable :: merge_into     !! --merge: the file to write; empty where not given
        character(max_path), allocatable :: merge_from(:)   !! --merge: the shards' files
        integer :: log_level = log_normal
    end type options_t

    real(wp), parameter :: most_seconds = 1.0e9_wp

    public :: read_command_line

contains

    !> Read the program's arguments.
    subroutine read_command_line(options, error)
        type(options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: word, name, value
        logical :: has_value
        integer :: i, mark

        options%deck = ''
        options%output = ''
        options%restart = ''
        options%merge_into = ''
        allocate (options%merge_from(0))
        allocate (options%overrides(0))
        i = 1
        do while (i <= command_argument_count())
            word = argument(i)
            name = word
            value = ''
            has_value = .false.
            mark = index(word, '=')
            if (len(word) > 2 .and. mark > 0) then
                if (word(1:2) == '--') then
                    name = word(:mark - 1)
                    value = word(mark + 1:)
                    has_value = .true.
                end if
            end if
            select case (name)
            case ('-o', '--output', '--set', '--threads', '--shard', '--merge', '--restart', '--max-time')
                if (.not. has_value) then
                    i = i + 1
                    if (i > command_argument_count()) then
                        call raise(error, status_input, 'option ' // name // ' needs a value')
                        return
                    end if
                    value = argument(i)
                end if
                call take_value(options, name, value, error)
            case ('--check', '--keywords', '--markdown', '--version', '--help', '--quiet', '--verbose', &
                  '--man', '--completion')
                if (has_value) then
                    call raise(error, status_input, 'option ' // name // ' takes no value')
                else
                    call take_switch(options, name)
                end if
            case ('-h')
                call take_switch(options, '--help')
            case ('-q')
                call take_switch(options, '--quiet')
            case ('-v')
                call take_switch(options, '--verbose')
            case default
                call take_deck(options, word, error)
            end select
            if (allocated(error)) return
            i = i + 1
        end do
        if (len(options%merge_into) > 0 .and. size(options%merge_from) == 0) call raise(error, status_input, &
            'option --merge needs the file to write and then the files to join: --merge OUT.h5 FILE...')
    end subroutine read_command_line

    pure subroutine take_switch(options, name)
        type(options_t), intent(inout) :: options
        character(*), intent(in) :: name

        select case (name)
        case ('--check')
            options%check_only = .true.
        case ('--keywords')
            options%show_keywords = .true.
        case ('--markdown')
            options%show_keywords = .true.
            options%as_markdown = .true.
        case ('--version')
            options%show_version = .true.
        case ('--help')
            options%show_help = .true.
        case ('--man')
            options%show_manual = .true.
        case ('--completion')
            options%show_completion = .true.
        case ('--quiet')
            options%log_level = log_quiet
        case ('--verbose')
            options%log_level = log_verbose
        end select
    end subroutine take_switch

    function argument(number) result(word)
        integer, intent(in) :: number
        character(:), allocatable :: word
        integer :: length

        call get_command_argument(number, length=length)
        allocate (character(length) :: word)
        call get_command_argument(number, word)
    end function argument

    subroutine take_value(options, name, value, error)
        type(options_t), intent(inout) :: options
        character(*), intent(in) :: name, value
        type(error_t), allocatable, intent(out) :: error
        integer :: mark, info, i

        select case (name)
        case ('-o', '--output')
            options%output = without_ending(value)
            if (len(options%output) == 0 .or. names_folder(value)) then
                call raise(error, status_input, 'option ' // name // ' needs a file name')
            else if (any([(iachar(value(i:i)) < 32 .or. iachar(value(i:i)) == 127, i=1, len(value))])) then
                call raise(error, status_input, 'option ' // name // ' needs a file name without line ' &
                    // 'ends and other control characters')
            end if
        case ('--set')
            mark = index(value, '=')
            if (mark < 2 .or. mark == len(value)) then
                call raise(error, status_input, 'option --set needs name=value, not ''' // value // '''')
                return
            end if
            call add_override(options, trim(adjustl(value(:mark - 1))), value(mark + 1:))
        case ('--restart')
            options%restart = value
            if (len_trim(value) == 0) call raise(error, status_input, &
                'option --restart needs the name of a checkpoint')
        case ('--max-time')
            read (value, *, iostat=info) options%max_seconds
            if (info /= 0 .or. verify(value, '0123456789.eE+-') > 0 &
                .or. .not. (options%max_seconds > 0.0_wp .and. options%max_seconds <= most_seconds)) then
                call raise(error, status_input, 'option --max-time needs a number of seconds above 0, ' &
                    // 'not ''' // value // '''')
            end if
        case ('--threads')
            read (value, *, iostat=info) options%threads
            if (info /= 0 .or. verify(value, '0123456789') > 0 .or. options%threads < 1) then
                call raise(error, status_input, &
                    'option --threads needs a whole number of at least 1, not ''' // value // '''')
            end if
        case ('--merge')
            options%merge_into = without_ending(value) // '.h5'
            if (names_folder(value)) call raise(error, status_input, 'option --merge needs a file name')
        case ('--shard')
            call take_shard(options, value, error)
        end select
    end subroutine take_value

    !> I/N, or auto.
    subroutine take_shard(options, value, error)
        type(options_t), intent(inout) :: options
        character(*), intent(in) :: value
        type(error_t), allocatable, intent(out) :: error
        integer :: mark, info

        options%shard_from_environment = value == 'auto'
        if (options%shard_from_environment) return
        mark = index(value, '/')
        info = 1
        if (mark > 1 .and. mark < len(value) .and. len(value) < 20) then
            if (verify(value(:mark - 1) // value(mark + 1:), '0123456789') == 0) then
                read (value(:mark - 1), *, iostat=info) options%shard
                if (info == 0) read (value(mark + 1:), *, iostat=info) options%shards
            end if
        end if
        if (info == 0 .and. options%shard >= 1 .and. options%shard <= options%shards) return
        call raise(error, status_input, 'option --shard needs I/N with 1 <= I <= N, or auto, not ''' // &
            value &
            // '''')
    end subroutine take_shard

    !> One --set more. (An array constructor of a type with allocatable texts leaks them: gfortran.)
    subroutine add_override(options, name, value)
        type(options_t), intent(inout) :: options
        character(*), intent(in) :: name, value
        type(override_t), allocatable :: grown(:)
        integer :: n

        n = size(options%overrides)
        allocate (grown(n + 1))
        grown(:n) = options%overrides
        grown(n + 1)%name = name
        grown(n + 1)%text = value
        call move_alloc(grown, options%overrides)
    end subroutine add_override

    !> Whether a name can be none but a folder's.
    pure logical function names_folder(value)
        character(*), intent(in) :: value
        character(:), allocatable :: last

        last = value(index(value, '/', back=.true.) + 1:)
        names_folder = any(last == [character(2) :: '', '.', '..'])
    end function names_folder

    !> Results go to NAME.h5; who writes the ending means the same.
    pure function without_ending(value) result(name)
        character(*), intent(in) :: value
        character(:), allocatable :: name

        name = value
        if (len(value) > 3) then
            if (value(len(value) - 2:) == '.h5') name = value(:len(value) - 3)
        end if
    end function without_ending

    subroutine take_deck(options, word, error)
        type(options_t), intent(inout) :: options
        character(*), intent(in) :: word
        type(error_t), allocatable, intent(out) :: error
        type(option_entry_t), allocatable :: known(:)
        character(:), allocatable :: hint

        if (len(word) == 0) then
            call raise(error, status_input, 'the name of the deck is empty')
        else if (word(1:1) == '-' .and. len(word) > 1) then
            known = option_table()
            hint = nearest_name(word, known%name)
            if (len(hint) > 0) hint = newline // '    did you mean ''' // hint // '''?'
            call raise(error, status_input, 'unknown option ''' // word // '''' // hint)
        else if (len(options%merge_into) > 0) then
            options%merge_from = [character(max_path) :: options%merge_from, word]
        else if (len(options%deck) > 0) then
            call raise(error, status_input, 'one deck at a time, not ''' // options%deck // ''' and ''' &
                // word // '''')
        else if (word /= '-') then
            options%deck = word
        end if
    end subroutine take_deck

end module gb_command_line
