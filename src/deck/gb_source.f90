!> The text of a deck, whole, as the user wrote it, from a file or from standard input.
module gb_source
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_ptr, c_size_t, c_associated
    use gb_diagnostics, only: printable
    use gb_error, only: error_t, raise, status_file, status_input
    use gb_text, only: to_text
    implicit none
    private

    type, public :: source_t
        character(:), allocatable :: name           !! as diagnostics show it: the path, or <stdin>
        character(:), allocatable :: text           !! UTF-8; bytes that are not are taken for Latin-1
        character(:), allocatable :: stem           !! default name of the results: no folder, no ending
        character(:), allocatable :: folder         !! of the files a deck names; ends with / or is empty
    end type source_t

    public :: read_source, source_from_text, find_control_byte, read_text

    integer, parameter :: largest = 64*1024*1024    !! bytes a deck may have
    integer, parameter :: chunk = 65536
    integer(c_int), parameter :: standard_input = 0_c_int

    interface
        function c_open(path, mode) bind(c, name="fopen") result(file)
            import :: c_char, c_ptr
            character(kind=c_char), intent(in) :: path(*), mode(*)
            type(c_ptr) :: file
        end function c_open
        function c_open_descriptor(descriptor, mode) bind(c, name="fdopen") result(file)
            import :: c_char, c_int, c_ptr
            integer(c_int), value, intent(in) :: descriptor
            character(kind=c_char), intent(in) :: mode(*)
            type(c_ptr) :: file
        end function c_open_descriptor
        function c_read(buffer, length, count, file) bind(c, name="fread") result(n)
            import :: c_char, c_size_t, c_ptr
            character(kind=c_char), intent(out) :: buffer(*)
            integer(c_size_t), value, intent(in) :: length, count
            type(c_ptr), value, intent(in) :: file
            integer(c_size_t) :: n
        end function c_read
        function c_failed(file) bind(c, name="ferror") result(failed)
            import :: c_int, c_ptr
            type(c_ptr), value, intent(in) :: file
            integer(c_int) :: failed
        end function c_failed
        function c_close(file) bind(c, name="fclose") result(status)
            import :: c_int, c_ptr
            type(c_ptr), value, intent(in) :: file
            integer(c_int) :: status
        end function c_close
    end interface

contains

    !> Read a deck; an empty path or `-` is standard input. Errors: status_file where it cannot be read,
    !> status_input where it is too large to be a deck.
    subroutine read_source(path, source, error)
        character(*), intent(in) :: path
        type(source_t), intent(out) :: source
        type(error_t), allocatable, intent(out) :: error
        integer :: slash, dot

        if (path == '' .or. path == '-') then
            source%name = '<stdin>'
            source%stem = 'gentbeam'
            source%folder = ''
        else
            source%name = path
            slash = index(path, '/', back=.true.)
            source%folder = path(:slash)
            source%stem = path(slash + 1:)
            dot = index(source%stem, '.', back=.true.)
            if (dot > 1) source%stem = source%stem(:dot - 1)
        end if
        call read_text(path, source%text, error)
    end subroutine read_source

    !> A source made of a text, for what does not come from a file.
    pure function source_from_text(name, text) result(source)
        character(*), intent(in) :: name, text
        type(source_t) :: source

        source%name = name
        source%stem = 'gentbeam'
        source%folder = ''
        source%text = valid_utf8(text)
    end function source_from_text

    !> The whole text of a file, or of standard input where the path is empty or `-`.
    subroutine read_text(path, text, error)
        character(*), intent(in) :: path
        character(:), allocatable, intent(out) :: text
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr) :: file
        logical :: failed

        if (path == '' .or. path == '-') then
            file = c_open_descriptor(standard_input, 'r' // c_null_char)
        else
            file = c_open(path // c_null_char, 'r' // c_null_char)
        end if
        text = ''
        failed = .not. c_associated(file)
        if (.not. failed) then
            call read_stream(file, text, failed)
            failed = c_close(file) /= 0 .or. failed
        end if
        if (failed) then
            call raise(error, status_file, reason_for(path))
        else if (len(text) > largest) then
            call raise(error, status_input, shown_name(path) // ' is larger than ' // &
                       to_text(largest/1024**2) // ' MB: that is no deck')
        else
            text = valid_utf8(text)
        end if
    end subroutine read_text

    !> All bytes of an open file, but no more than what tells that it is too large.
    subroutine read_stream(file, text, failed)
        type(c_ptr), intent(in) :: file
        character(:), allocatable, intent(out) :: text
        logical, intent(out) :: failed
        character(kind=c_char) :: buffer(chunk)
        character(:), allocatable :: grown
        integer :: n, length, i

        allocate (character(chunk) :: text)
        length = 0
        do
            n = int(c_read(buffer, 1_c_size_t, int(chunk, c_size_t), file))
            if (n <= 0) exit
            if (length + n > len(text)) then
                allocate (character(2*len(text)) :: grown)
                grown(:length) = text(:length)
                call move_alloc(grown, text)
            end if
            do i = 1, n
                text(length + i:length + i) = buffer(i)
            end do
            length = length + n
            if (length > largest) exit
        end do
        failed = c_failed(file) /= 0
        text = text(:length)
    end subroutine read_stream

    !> Why a file cannot be read, in the words of the runtime library, which alone knows.
    function reason_for(path) result(sentence)
        character(*), intent(in) :: path
        character(:), allocatable :: sentence
        character(512) :: message
        character(1) :: byte
        integer :: unit, status, mark

        sentence = 'cannot read ' // shown_name(path)
        if (path == '' .or. path == '-') return
        open (newunit=unit, file=path, status='old', action='read', access='stream', iostat=status, &
              iomsg=message)
        if (status == 0) then
            read (unit, iostat=status, iomsg=message) byte
            close (unit)
        end if
        if (status <= 0) return
        mark = index(message, ''': ', back=.true.)
        if (mark > 0) message = message(mark + 3:)
        sentence = sentence // ': ' // trim(message)
    end function reason_for

    pure function shown_name(path) result(name)
        character(*), intent(in) :: path
        character(:), allocatable :: name

        name = 'standard input'
        if (path /= '' .and. path /= '-') name = printable(path)
    end function shown_name

    !> First byte no text holds (a control character other than tab and line ends), 0 if there is none.
    pure integer function find_control_byte(text) result(place)
        character(*), intent(in) :: text
        integer :: i, code, returns

        place = 0
        returns = 0
        do i = 1, len(text)
            code = ichar(text(i:i))
            ! Carriage returns belong to the line end that follows.
            if (code == 13) then
                if (returns == 0) returns = i
            else if (code == 10) then
                returns = 0
            else if (returns > 0) then
                place = returns
                return
            else if ((code < 32 .and. code /= 9) .or. code == 127) then
                place = i
                return
            end if
        end do
    end function find_control_byte

    !> The text itself where it is UTF-8; else every byte that is not part of it becomes a character: Latin-1
    !> where it prints, the replacement character otherwise.
    pure function valid_utf8(text) result(valid)
        character(*), intent(in) :: text
        character(:), allocatable :: valid
        integer :: i, n, length, wrong, code

        wrong = 0
        i = 1
        do while (i <= len(text))
            length = sequence_length(text, i)
            if (length == 0) wrong = wrong + 1
            i = i + max(1, length)
        end do
        if (wrong == 0) then
            valid = text
            return
        end if
        allocate (character(len(text) + 2*wrong) :: valid)
        n = 0
        i = 1
        do while (i <= len(text))
            length = sequence_length(text, i)
            if (length > 0) then
                valid(n + 1:n + length) = text(i:i + length - 1)
                n = n + length
                i = i + length
            else
                code = ichar(text(i:i))
                if (code >= 160) then
                    valid(n + 1:n + 2) = char(192 + code/64) // char(128 + modulo(code, 64))
                    n = n + 2
                else
                    valid(n + 1:n + 3) = char(239) // char(191) // char(189)
                    n = n + 3
                end if
                i = i + 1
            end if
        end do
        valid = valid(:n)
    end function valid_utf8

    !> Bytes of the UTF-8 character at `place`, 0 where there is none.
    pure integer function sequence_length(text, place) result(length)
        character(*), intent(in) :: text
        integer, intent(in) :: place
        integer :: lead, second, i

        lead = ichar(text(place:place))
        select case (lead)
        case (0:127)
            length = 1
            return
        case (194:223)
            length = 2
        case (224:239)
            length = 3
        case (240:244)
            length = 4
        case default
            length = 0
            return
        end select
        if (place + length - 1 > len(text)) then
            length = 0
            return
        end if
        do i = place + 1, place + length - 1
            if (iand(ichar(text(i:i)), 192) /= 128) then
                length = 0
                return
            end if
        end do
        ! Overlong forms, surrogates and numbers beyond Unicode are no characters.
        second = ichar(text(place + 1:place + 1))
        if ((lead == 224 .and. second < 160) .or. (lead == 237 .and. second > 159) .or. &
            (lead == 240 .and. second < 144) .or. (lead == 244 .and. second > 143)) length = 0
    end function sequence_length

end module gb_source
