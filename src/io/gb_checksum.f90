!> CRC-32, as zlib and many other programs and formats have it: what tells that stored bytes are no longer
!> those that were written.
module gb_checksum
    use, intrinsic :: iso_c_binding, only: c_char, c_loc, c_long, c_ptr, c_size_t
    use gb_kinds, only: i8
    implicit none
    private

    interface
        function c_crc32(before, bytes, count) bind(c, name="crc32_z") result(checksum)
            import :: c_long, c_ptr, c_size_t
            integer(c_long), value, intent(in) :: before
            type(c_ptr), value, intent(in) :: bytes
            integer(c_size_t), value, intent(in) :: count
            integer(c_long) :: checksum
        end function c_crc32
    end interface

    !> Go on with the checksum of what came before; that of nothing is 0.
    interface add_to_checksum
        module procedure add_bytes, add_text
    end interface add_to_checksum

    public :: add_to_checksum

contains

    subroutine add_bytes(checksum, from, count)
        integer(i8), intent(inout) :: checksum          !! 0 to 2**32 - 1
        type(c_ptr), intent(in) :: from
        integer(i8), intent(in) :: count

        if (count == 0) return
        checksum = iand(int(c_crc32(int(checksum, c_long), from, int(count, c_size_t)), i8), 4294967295_i8)
    end subroutine add_bytes

    subroutine add_text(checksum, text)
        integer(i8), intent(inout) :: checksum
        character(*), intent(in) :: text
        character(kind=c_char, len=:), allocatable, target :: copy

        copy = text
        call add_bytes(checksum, c_loc(copy), len(copy, kind=i8))
    end subroutine add_text

end module gb_checksum
