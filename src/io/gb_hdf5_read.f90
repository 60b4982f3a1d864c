!> Existing HDF5 files that are gone on with or joined: open them, look for what is in them, copy parts from
!> one to the other.
module gb_hdf5_read
    use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
    use hdf5, only: hid_t, hsize_t, h5aclose_f, h5aget_space_f, h5aopen_f, h5aread_f, h5f_acc_rdonly_f, &
        h5f_acc_rdwr_f, h5fopen_f, h5gget_info_f, h5gopen_f, h5ldelete_f, h5lexists_f, &
        h5lget_name_by_idx_f, h5ocopy_f, h5sclose_f, h5_index_crt_order_f, h5_iter_inc_f, &
        h5sget_simple_extent_npoints_f, h5tclose_f
    use gb_error, only: error_t, raise, status_file
    use gb_hdf5_direct, only: check, text_type
    use gb_hdf5_input, only: take_text
    use gb_claim, only: set_environment_default
    use gb_hdf5, only: start_hdf5
    implicit none
    private

    public :: open_file, open_group, has_link, delete_link, copy_object, link_names
    public :: get_text_list

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

    !> An attribute that is a list of texts, joined by blanks.
    subroutine get_text_list(object, name, texts, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        character(:), allocatable, intent(out) :: texts
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), allocatable, target :: addresses(:)
        character(:), allocatable :: text
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
                    call take_text(addresses(i), text)
                    texts = texts // text // ' '
                end do
            end if
            call h5sclose_f(space, ignored)
            call h5tclose_f(type_id, ignored)
            call h5aclose_f(attribute, ignored)
        end if
        call check(info, 'read attribute ' // name, error)
    end subroutine get_text_list

end module gb_hdf5_read
