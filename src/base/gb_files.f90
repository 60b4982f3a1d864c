!> Files that must be whole or not there: sealing them with a digest, and putting one in the place of another
!> in one instant.
module gb_files
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int64_t, c_null_char, c_size_t
    use gb_kinds, only: wp
    implicit none
    private

    integer, parameter :: reason_size = 256
    integer(c_int), parameter :: damaged = 2_c_int

    interface
        pure function c_digest(bytes, count, start) bind(c, name="gb_digest") result(digest)
            import :: c_char, c_int64_t, c_size_t
            character(kind=c_char), intent(in) :: bytes(*)
            integer(c_size_t), value, intent(in) :: count
            integer(c_int64_t), value, intent(in) :: start
            integer(c_int64_t) :: digest
        end function c_digest

        function c_seal_file(path, reason, size) bind(c, name="gb_seal_file") result(failed)
            import :: c_char, c_int, c_size_t
            character(kind=c_char), intent(in) :: path(*)
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_size_t), value, intent(in) :: size
            integer(c_int) :: failed
        end function c_seal_file

        function c_check_seal(path, reason, size) bind(c, name="gb_check_seal") result(failed)
            import :: c_char, c_int, c_size_t
            character(kind=c_char), intent(in) :: path(*)
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_size_t), value, intent(in) :: size
            integer(c_int) :: failed
        end function c_check_seal

        function c_replace_file(from, to, reason, size) bind(c, name="gb_replace_file") result(failed)
            import :: c_char, c_int, c_size_t
            character(kind=c_char), intent(in) :: from(*), to(*)
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_size_t), value, intent(in) :: size
            integer(c_int) :: failed
        end function c_replace_file

        function c_is_same_file(first, second) bind(c, name="gb_is_same_file") result(answer)
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: first(*), second(*)
            integer(c_int) :: answer
        end function c_is_same_file

        function c_is_same_place(first, second) bind(c, name="gb_is_same_place") result(answer)
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: first(*), second(*)
            integer(c_int) :: answer
        end function c_is_same_place

        function c_is_free_or_hdf5(path) bind(c, name="gb_is_free_or_hdf5") result(answer)
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int) :: answer
        end function c_is_free_or_hdf5

        function c_begin_rehearsal(seconds) bind(c, name="gb_begin_rehearsal") result(process)
            import :: c_int
            integer(c_int), value, intent(in) :: seconds
            integer(c_int) :: process
        end function c_begin_rehearsal

        function c_rehearsal_went_well(process) bind(c, name="gb_rehearsal_went_well") result(answer)
            import :: c_int
            integer(c_int), value, intent(in) :: process
            integer(c_int) :: answer
        end function c_rehearsal_went_well

        !> The end of the copy of the process.
        subroutine end_rehearsal() bind(c, name="gb_end_rehearsal")
        end subroutine end_rehearsal

        subroutine c_remove_file(path) bind(c, name="gb_remove_file")
            import :: c_char
            character(kind=c_char), intent(in) :: path(*)
        end subroutine c_remove_file

        function c_is_file(path) bind(c, name="gb_is_file") result(answer)
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int) :: answer
        end function c_is_file
    end interface

    !> Go on with the digest of what came before.
    interface add_to_digest
        module procedure add_text, add_reals
    end interface add_to_digest

    public :: begin_rehearsal, end_rehearsal, rehearsal_went_well
    public :: leaves_folder, is_same_file, is_same_place, is_free_or_hdf5, add_to_digest, seal_file, &
        check_seal, replace_file, remove_file, is_file

    !> Where a digest starts.
    integer(c_int64_t), parameter, public :: empty_digest = -3750763034362895579_c_int64_t

contains

    pure subroutine add_text(digest, text)
        integer(c_int64_t), intent(inout) :: digest
        character(*), intent(in) :: text

        digest = c_digest(text, int(len(text), c_size_t), digest)
    end subroutine add_text

    pure subroutine add_reals(digest, values)
        integer(c_int64_t), intent(inout) :: digest
        real(wp), intent(in) :: values(:)
        character(8) :: bytes
        integer :: i

        do i = 1, size(values)
            bytes = transfer(values(i), bytes)
            digest = c_digest(bytes, 8_c_size_t, digest)
        end do
    end subroutine add_reals

    !> Add the seal to the end of a file, and see to it that all of it is on the disk. The
    !> system's words for why not, or an empty text.
    function seal_file(path) result(reason)
        character(*), intent(in) :: path
        character(:), allocatable :: reason
        character(kind=c_char) :: buffer(reason_size)

        buffer = c_null_char
        reason = told(c_seal_file(path // c_null_char, buffer, int(reason_size, c_size_t)), buffer)
    end function seal_file

    !> Whether a file is what was sealed, to the last bit. `reason` has the system's words where it cannot be
    !> read, and is empty where it can.
    subroutine check_seal(path, is_whole, reason)
        character(*), intent(in) :: path
        logical, intent(out) :: is_whole
        character(:), allocatable, intent(out) :: reason
        character(kind=c_char) :: buffer(reason_size)
        integer(c_int) :: failed

        buffer = c_null_char
        failed = c_check_seal(path // c_null_char, buffer, int(reason_size, c_size_t))
        is_whole = failed == 0
        reason = told(merge(0_c_int, failed, failed == damaged), buffer)
    end subroutine check_seal

    !> `from` takes the name `to`, and the place of what had it, in one instant.
    function replace_file(from, to) result(reason)
        character(*), intent(in) :: from, to
        character(:), allocatable :: reason
        character(kind=c_char) :: buffer(reason_size)

        buffer = c_null_char
        reason = told(c_replace_file(from // c_null_char, to // c_null_char, buffer, &
                                     int(reason_size, c_size_t)), buffer)
    end function replace_file

    subroutine remove_file(path)
        character(*), intent(in) :: path

        call c_remove_file(path // c_null_char)
    end subroutine remove_file

    logical function is_file(path)
        character(*), intent(in) :: path

        is_file = c_is_file(path // c_null_char) /= 0
    end function is_file

    !> Whether two names lead to one file that is there.
    logical function is_same_file(first, second)
        character(*), intent(in) :: first, second

        is_same_file = c_is_same_file(first // c_null_char, second // c_null_char) /= 0
    end function is_same_file

    !> The same for names of files that need not be there yet.
    logical function is_same_place(first, second)
        character(*), intent(in) :: first, second

        is_same_place = c_is_same_place(first // c_null_char, second // c_null_char) /= 0
    end function is_same_place

    !> Whether a name is free, or that of an empty file or one that HDF5 wrote.
    logical function is_free_or_hdf5(path)
        character(*), intent(in) :: path

        is_free_or_hdf5 = c_is_free_or_hdf5(path // c_null_char) /= 0
    end function is_free_or_hdf5

    !> Whether a path leads out of the folder that the program runs in.
    pure logical function leaves_folder(path)
        character(*), intent(in) :: path

        leaves_folder = index(path, '/') == 1 .or. index('/' // path, '/../') > 0
    end function leaves_folder

    !> Let a copy of this process try out, for so many seconds at most, what may crash it: 0 in the copy,
    !> which ends with `end_rehearsal`; another number in the original.
    integer function begin_rehearsal(seconds) result(process)
        integer, intent(in) :: seconds

        process = int(c_begin_rehearsal(int(seconds, c_int)))
    end function begin_rehearsal

    !> Wait for the copy: whether it came to its end. Where none could be made, nothing speaks against going
    !> on.
    logical function rehearsal_went_well(process)
        integer, intent(in) :: process

        rehearsal_went_well = .true.
        if (process > 0) rehearsal_went_well = c_rehearsal_went_well(int(process, c_int)) /= 0
    end function rehearsal_went_well

    pure function told(failed, buffer) result(reason)
        integer(c_int), intent(in) :: failed
        character(kind=c_char), intent(in) :: buffer(reason_size)
        character(:), allocatable :: reason
        integer :: i

        reason = ''
        if (failed == 0) return
        do i = 1, reason_size
            if (buffer(i) == c_null_char) exit
            reason = reason // buffer(i)
        end do
        if (len(reason) == 0) reason = 'the system gives no reason'
    end function told

end module gb_files
