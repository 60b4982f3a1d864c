!> The file under a results file. Numbers are appended to it; what describes them is written anew, whole, for
!> every edition, and one small write makes an edition the valid one (docs/reliability.md).
module gb_store
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_int, c_int32_t, c_int64_t, &
        c_loc, c_null_char, c_null_ptr, c_ptr, c_size_t
    use gb_kinds, only: i8
    use gb_error, only: error_t, raise, status_file
    use gb_posix, only: reason_size, to_fortran
    implicit none
    private

    type, public :: store_t
        private
        character(:), allocatable, public :: path   !! as the user knows it
        type(c_ptr) :: handle = c_null_ptr
    contains
        procedure :: open => open_store
        procedure :: is_open
        procedure :: allocate => allocate_room
        procedure :: write => write_bytes
        procedure :: begin
        procedure :: offer
        procedure :: offers_left
        procedure :: commit
        procedure :: keep
        procedure :: close => close_store
        procedure, private :: fail
    end type store_t

    !> Answers of `commit`.
    integer, parameter, public :: commit_done = 0, commit_failed = 1, commit_again = 2

    public :: object_address, link_object

    interface
        function c_open(path, reason, size) bind(c, name="gb_store_open") result(handle)
            import :: c_ptr, c_char, c_size_t
            character(kind=c_char), intent(in) :: path(*)
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_size_t), value, intent(in) :: size
            type(c_ptr) :: handle
        end function c_open

        function c_allocate(handle, bytes) bind(c, name="gb_store_allocate") result(address)
            import :: c_ptr, c_int64_t
            type(c_ptr), value, intent(in) :: handle
            integer(c_int64_t), value, intent(in) :: bytes
            integer(c_int64_t) :: address
        end function c_allocate

        function c_write(handle, address, bytes, count) bind(c, name="gb_store_write") result(failed)
            import :: c_ptr, c_int64_t, c_int
            type(c_ptr), value, intent(in) :: handle, bytes
            integer(c_int64_t), value, intent(in) :: address, count
            integer(c_int) :: failed
        end function c_write

        function c_begin(handle, to_be_kept) bind(c, name="gb_store_begin") result(file)
            import :: c_ptr, c_int, c_int64_t
            type(c_ptr), value, intent(in) :: handle
            integer(c_int), value, intent(in) :: to_be_kept
            integer(c_int64_t) :: file
        end function c_begin

        function c_keep(handle) bind(c, name="gb_store_keep") result(failed)
            import :: c_ptr, c_int
            type(c_ptr), value, intent(in) :: handle
            integer(c_int) :: failed
        end function c_keep

        function c_address(object) bind(c, name="gb_store_address") result(address)
            import :: c_int64_t
            integer(c_int64_t), value, intent(in) :: object
            integer(c_int64_t) :: address
        end function c_address

        function c_link(group, name, address) bind(c, name="gb_store_link") result(failed)
            import :: c_char, c_int, c_int64_t
            integer(c_int64_t), value, intent(in) :: group, address
            character(kind=c_char), intent(in) :: name(*)
            integer(c_int) :: failed
        end function c_link

        subroutine c_offer(handle, addresses, count, bytes) bind(c, name="gb_store_offer")
            import :: c_ptr, c_int64_t
            type(c_ptr), value, intent(in) :: handle, addresses
            integer(c_int64_t), value, intent(in) :: count, bytes
        end subroutine c_offer

        function c_offers_left(handle) bind(c, name="gb_store_offers_left") result(count)
            import :: c_ptr, c_int64_t
            type(c_ptr), value, intent(in) :: handle
            integer(c_int64_t) :: count
        end function c_offers_left

        function c_commit(handle, reserve, durable) bind(c, name="gb_store_commit") result(answer)
            import :: c_ptr, c_int
            type(c_ptr), value, intent(in) :: handle
            integer(c_int), value, intent(in) :: reserve, durable
            integer(c_int) :: answer
        end function c_commit

        function c_close(handle, reason, size) bind(c, name="gb_store_close") result(failed)
            import :: c_ptr, c_char, c_size_t, c_int
            type(c_ptr), value, intent(in) :: handle
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_size_t), value, intent(in) :: size
            integer(c_int) :: failed
        end function c_close

        subroutine c_reason(handle, reason, size) bind(c, name="gb_store_reason")
            import :: c_ptr, c_char, c_size_t
            type(c_ptr), value, intent(in) :: handle
            character(kind=c_char), intent(inout) :: reason(*)
            integer(c_size_t), value, intent(in) :: size
        end subroutine c_reason
    end interface

contains

    !> Open the file that is to become `path`; what is there already stays until the first edition. A file
    !> that cannot be written is reported with the system's reason.
    subroutine open_store(self, path, error)
        class(store_t), intent(inout) :: self
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char) :: reason(reason_size)

        self%path = path
        reason = c_null_char
        self%handle = c_open(path // c_null_char, reason, int(reason_size, c_size_t))
        if (.not. self%is_open()) call self%fail(to_fortran(reason), error)
    end subroutine open_store

    logical function is_open(self)
        class(store_t), intent(in) :: self

        is_open = c_associated(self%handle)
    end function is_open

    !> Address of room for so many bytes.
    integer(i8) function allocate_room(self, bytes) result(address)
        class(store_t), intent(inout) :: self
        integer(i8), intent(in) :: bytes

        address = int(c_allocate(self%handle, int(bytes, c_int64_t)), i8)
    end function allocate_room

    subroutine write_bytes(self, address, from, bytes, error)
        class(store_t), intent(inout) :: self
        integer(i8), intent(in) :: address
        type(c_ptr), intent(in) :: from
        integer(i8), intent(in) :: bytes
        type(error_t), allocatable, intent(out) :: error

        if (c_write(self%handle, int(address, c_int64_t), from, int(bytes, c_int64_t)) /= 0) &
            call self%fail(reason_of(self), error)
    end subroutine write_bytes

    !> Begin an edition: HDF5's identifier of an empty file that is made in memory. From here to `commit` (or
    !> `keep`, where it is to be kept) no room may be allocated.
    subroutine begin(self, to_be_kept, file, error)
        class(store_t), intent(inout) :: self
        logical, intent(in) :: to_be_kept
        integer(c_int64_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error

        file = c_begin(self%handle, merge(1_c_int, 0_c_int, to_be_kept))
        if (file < 0) call self%fail('HDF5 cannot begin a file in memory', error)
    end subroutine begin

    !> The next rooms of `bytes` bytes that HDF5 asks for lie at these addresses, which must stay as they are
    !> until it has asked.
    subroutine offer(self, addresses, bytes)
        class(store_t), intent(inout) :: self
        integer(i8), intent(in), target, contiguous :: addresses(:)
        integer(i8), intent(in) :: bytes

        call c_offer(self%handle, c_loc(addresses), size(addresses, kind=c_int64_t), int(bytes, c_int64_t))
    end subroutine offer

    logical function offers_left(self)
        class(store_t), intent(in) :: self

        offers_left = c_offers_left(self%handle) > 0
    end function offers_left

    !> Make the edition that HDF5 has closed the valid one: commit_done, commit_again where it must be made
    !> once more, or commit_failed with `error`.
    subroutine commit(self, reserve, durable, answer, error)
        class(store_t), intent(inout) :: self
        logical, intent(in) :: reserve      !! leave room for more of the kind
        logical, intent(in) :: durable      !! let the numbers reach the disk first
        integer, intent(out) :: answer
        type(error_t), allocatable, intent(out) :: error

        answer = int(c_commit(self%handle, merge(1_c_int, 0_c_int, reserve), merge(1_c_int, 0_c_int, &
            durable)))
        if (answer == commit_failed) call self%fail(reason_of(self), error)
    end subroutine commit

    !> What the edition holds that HDF5 has closed stays where it is, for later ones to link to.
    subroutine keep(self, error)
        class(store_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (c_keep(self%handle) /= 0) call self%fail(reason_of(self), error)
    end subroutine keep

    !> Where an open object of an edition that is to be kept will lie; negative where HDF5 does not tell.
    integer(i8) function object_address(object) result(address)
        integer(c_int64_t), intent(in) :: object

        address = int(c_address(object), i8)
    end function object_address

    !> Give an object that was kept a name in a group of this edition.
    logical function link_object(group, name, address) result(went_well)
        integer(c_int64_t), intent(in) :: group
        character(*), intent(in) :: name
        integer(i8), intent(in) :: address

        went_well = c_link(group, name // c_null_char, int(address, c_int64_t)) == 0
    end function link_object

    !> Close the file; one that has no edition yet is removed.
    subroutine close_store(self, error)
        class(store_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char) :: reason(reason_size)
        integer(c_int) :: failed

        if (.not. self%is_open()) return
        reason = c_null_char
        failed = c_close(self%handle, reason, int(reason_size, c_size_t))
        self%handle = c_null_ptr
        if (failed /= 0) call self%fail(to_fortran(reason), error)
    end subroutine close_store

    function reason_of(self) result(reason)
        class(store_t), intent(in) :: self
        character(:), allocatable :: reason
        character(kind=c_char) :: buffer(reason_size)

        buffer = c_null_char
        call c_reason(self%handle, buffer, int(reason_size, c_size_t))
        reason = to_fortran(buffer)
    end function reason_of

    subroutine fail(self, reason, error)
        class(store_t), intent(in) :: self
        character(*), intent(in) :: reason
        type(error_t), allocatable, intent(out) :: error

        call raise(error, status_file, 'cannot write the results file ' // self%path // ': ' // reason)
    end subroutine fail

end module gb_store
