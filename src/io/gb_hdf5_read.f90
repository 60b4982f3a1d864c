!> Reading existing HDF5 files: open them, look for what is in them, copy parts from one to the other.
module gb_hdf5_read
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_loc, c_null_char, c_ptr
    use hdf5, only: hid_t, hsize_t, h5aclose_f, h5aget_space_f, h5aopen_f, h5aread_f, h5dclose_f, &
        h5dget_space_f, h5dopen_f, h5dread_f, h5dvlen_reclaim_f, h5f_acc_rdonly_f, &
        h5f_acc_rdwr_f, h5fopen_f, h5gget_info_f, h5gopen_f, h5ldelete_f, h5lexists_f, &
        h5lget_name_by_idx_f, h5ocopy_f, h5sclose_f, h5_index_crt_order_f, h5_iter_inc_f, &
        h5p_default_f, h5sget_simple_extent_npoints_f, h5t_native_double, h5t_native_integer, h5tclose_f
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_file
    use gb_hdf5_direct, only: check, text_type
    use gb_claim, only: set_environment_default
    use gb_hdf5, only: start_hdf5
    implicit none
    private

    public :: open_file, open_group, has_link, delete_link, copy_object, link_names
    public :: get_text_attribute, get_text_list, get_integer_attribute, get_real_attribute, get_text, text_at

    integer, parameter :: longest = 100000000       !! bytes of a text
    integer, parameter, public :: max_link = 96     !! bytes of a name

contains

    !> Open an existing file, `writable` or only to read.
    subroutine open_file(path, writable, file, error)
        character(*), intent(in) :: path
        logical, intent(in) :: writable
        integer(hid_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        file = -1
        call set_environment_default('HDF5_USE_FILE_LOCKING', 'FALSE')
        call start_hdf5()
        call h5fopen_f(path, merge(h5f_acc_rdwr_f, h5f_acc_rdonly_f, writable), file, info)
        if (info < 0) call raise(error, status_file, 'it is no HDF5 file, or it is broken')
    end subroutine open_file

    subroutine open_group(parent, name, group, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer(hid_t), intent(out) :: group
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5gopen_f(parent, name, group, info)
        call check(info, 'read ' // name, error)
    end subroutine open_group

    logical function has_link(parent, name)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer :: info

        call h5lexists_f(parent, name, has_link, info)
        has_link = has_link .and. info >= 0
    end function has_link

    !> Names of a group's members, in the order in which they were made.
    subroutine link_names(group, names, error)
        integer(hid_t), intent(in) :: group
        character(max_link), allocatable, intent(out) :: names(:)
        type(error_t), allocatable, intent(out) :: error
        integer :: info, storage, n, last_order
        integer(hsize_t) :: i

        call h5gget_info_f(group, storage, n, last_order, info)
        call check(info, 'list a group', error)
        if (allocated(error)) return
        allocate (names(n))
        do i = 1, n
            call h5lget_name_by_idx_f(group, '.', h5_index_crt_order_f, h5_iter_inc_f, i - 1, names(i), info)
            if (info < 0) call check(info, 'list a group', error)
        end do
    end subroutine link_names

    subroutine delete_link(parent, name, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5ldelete_f(parent, name, info)
        call check(info, 'delete ' // name, error)
    end subroutine delete_link

    !> Copy a group or dataset with all that is in it.
    subroutine copy_object(from, name, into, error)
        integer(hid_t), intent(in) :: from, into
        character(*), intent(in) :: name
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5ocopy_f(from, name, into, name, info)
        call check(info, 'copy ' // name, error)
    end subroutine copy_object

    subroutine get_integer_attribute(object, name, number, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        integer, intent(out) :: number
        type(error_t), allocatable, intent(out) :: error
        integer, target :: value
        type(c_ptr) :: buffer
        integer(hid_t) :: attribute
        integer :: info, ignored

        value = 0
        call h5aopen_f(object, name, attribute, info)
        if (info >= 0) then
            buffer = c_loc(value)
            call h5aread_f(attribute, h5t_native_integer, buffer, info)
            call h5aclose_f(attribute, ignored)
        end if
        number = value
        call check(info, 'read attribute ' // name, error)
    end subroutine get_integer_attribute

    subroutine get_real_attribute(object, name, number, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        real(wp), intent(out) :: number
        type(error_t), allocatable, intent(out) :: error
        real(wp), target :: value
        type(c_ptr) :: buffer
        integer(hid_t) :: attribute
        integer :: info, ignored

        value = 0.0_wp
        call h5aopen_f(object, name, attribute, info)
        if (info >= 0) then
            buffer = c_loc(value)
            call h5aread_f(attribute, h5t_native_double, buffer, info)
            call h5aclose_f(attribute, ignored)
        end if
        number = value
        call check(info, 'read attribute ' // name, error)
    end subroutine get_real_attribute

    subroutine get_text_attribute(object, name, text, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        character(:), allocatable, intent(out) :: text
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), target :: address(1)
        type(c_ptr) :: buffer
        integer(hid_t) :: attribute, space, type_id
        integer :: info, ignored

        text = ''
        call h5aopen_f(object, name, attribute, info)
        if (info >= 0) then
            call text_type(type_id, info)
            call h5aget_space_f(attribute, space, info)
            buffer = c_loc(address)
            call h5aread_f(attribute, type_id, buffer, info)
            if (info >= 0) then
                text = text_at(address(1))
                call h5dvlen_reclaim_f(type_id, space, h5p_default_f, buffer, ignored)
            end if
            call h5sclose_f(space, ignored)
            call h5tclose_f(type_id, ignored)
            call h5aclose_f(attribute, ignored)
        end if
        call check(info, 'read attribute ' // name, error)
    end subroutine get_text_attribute

    !> An attribute that is a list of texts, joined by blanks.
    subroutine get_text_list(object, name, texts, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        character(:), allocatable, intent(out) :: texts
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), allocatable, target :: addresses(:)
        type(c_ptr) :: buffer
        integer(hid_t) :: attribute, space, type_id
        integer(hsize_t) :: n
        integer :: info, ignored, i

        texts = ''
        call h5aopen_f(object, name, attribute, info)
        if (info >= 0) then
            call text_type(type_id, info)
            call h5aget_space_f(attribute, space, info)
            call h5sget_simple_extent_npoints_f(space, n, info)
            allocate (addresses(n))
            buffer = c_loc(addresses)
            call h5aread_f(attribute, type_id, buffer, info)
            if (info >= 0) then
                do i = 1, int(n)
                    texts = texts // text_at(addresses(i)) // ' '
                end do
                call h5dvlen_reclaim_f(type_id, space, h5p_default_f, buffer, ignored)
            end if
            call h5sclose_f(space, ignored)
            call h5tclose_f(type_id, ignored)
            call h5aclose_f(attribute, ignored)
        end if
        call check(info, 'read attribute ' // name, error)
    end subroutine get_text_list

    !> A scalar text dataset, and its attribute `parameters`.
    subroutine get_text(parent, name, text, parameters, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        character(:), allocatable, intent(out) :: text, parameters
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), target :: address(1)
        type(c_ptr) :: buffer
        integer(hid_t) :: dataset, space, type_id
        integer :: info, ignored

        text = ''
        call h5dopen_f(parent, name, dataset, info)
        if (info >= 0) then
            call text_type(type_id, info)
            call h5dget_space_f(dataset, space, info)
            buffer = c_loc(address)
            call h5dread_f(dataset, type_id, buffer, info)
            if (info >= 0) then
                text = text_at(address(1))
                call h5dvlen_reclaim_f(type_id, space, h5p_default_f, buffer, ignored)
            end if
            call h5sclose_f(space, ignored)
            call h5tclose_f(type_id, ignored)
            call get_text_attribute(dataset, 'parameters', parameters, error)
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read ' // name, error)
    end subroutine get_text

    !> The text at an address that HDF5 has given, up to its closing NUL; empty for none.
    function text_at(address) result(text)
        type(c_ptr), intent(in) :: address
        character(:), allocatable :: text
        character(kind=c_char), pointer :: characters(:)
        integer :: n, i

        text = ''
        if (.not. c_associated(address)) return
        call c_f_pointer(address, characters, [longest])
        n = 0
        do while (n < longest)
            if (characters(n + 1) == c_null_char) exit
            n = n + 1
        end do
        deallocate (text)
        allocate (character(n) :: text)
        do i = 1, n
            text(i:i) = characters(i)
        end do
    end function text_at

end module gb_hdf5_read
