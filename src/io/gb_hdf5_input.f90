!> Reading with HDF5 what this program has written: files, attributes, whole arrays, and rows of series.
!> Whatever is not there, or is not of the kind asked for, is an error_t with exit status 3.
module gb_hdf5_input
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int64_t, c_loc, &
        c_null_char, c_ptr, c_size_t
    use hdf5, only: hid_t, hsize_t, h5aget_space_f, h5gget_info_f, h5gopen_f, h5lget_name_by_idx_f, &
        h5_index_crt_order_f, h5_iter_inc_f, h5t_string, h5t_cset_utf8_f, h5tcopy_f, h5tset_cset_f, &
        h5sget_simple_extent_npoints_f, h5aopen_f, h5aread_f, h5aclose_f, h5aget_type_f, &
        h5tget_class_f, h5tis_variable_str_f, h5tclose_f, h5t_string_f, h5t_float_f, h5t_integer_f, &
        h5t_native_double, h5t_native_integer, h5dopen_f, h5dread_f, h5dclose_f, h5dget_space_f, &
        h5dget_type_f, h5sclose_f, h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, &
        h5lexists_f, h5fclose_f, h5sselect_hyperslab_f, h5s_select_set_f, h5screate_simple_f
    use gb_kinds, only: wp, i8
    use gb_error, only: error_t, raise, status_file
    use gb_posix, only: to_fortran
    implicit none
    private

    public :: hid_t, open_file, close_file, open_group, has_link, link_names, get_attribute, get_text_list, &
        get_dataset_attribute, get_deck, get_numbers, get_rows, get_table, get_texts, count_rows, verify

    integer, parameter, public :: max_link = 256    !! bytes of the name of a group's member

    type, public :: text_t
        character(:), allocatable :: text
    end type text_t

    !> Read a scalar attribute: text, integer or real.
    interface get_attribute
        module procedure get_text_attribute, get_integer_attribute, get_real_attribute
    end interface get_attribute

    !> Read a dataset of one dimension.
    interface get_numbers
        module procedure get_reals, get_integers
    end interface get_numbers

    interface
        subroutine c_free(address) bind(c, name="free")
            import :: c_ptr
            type(c_ptr), value, intent(in) :: address
        end subroutine c_free

        function c_open_to_read(path) bind(c, name="gb_open_to_read") result(file)
            import :: c_char, c_int64_t
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int64_t) :: file
        end function c_open_to_read

        function c_verify(file, name, size) bind(c, name="gb_verify") result(failed)
            import :: c_char, c_int, c_int64_t, c_size_t
            integer(c_int64_t), value, intent(in) :: file
            character(kind=c_char), intent(inout) :: name(*)
            integer(c_size_t), value, intent(in) :: size
            integer(c_int) :: failed
        end function c_verify

        pure function c_length(text) bind(c, name="strlen") result(length)
            import :: c_ptr, c_size_t
            type(c_ptr), value, intent(in) :: text
            integer(c_size_t) :: length
        end function c_length
    end interface

    integer, parameter :: any_class = -1000

contains

    !> An error where HDF5's answer is one, unless there is one already.
    subroutine check(info, deed, error)
        integer, intent(in) :: info
        character(*), intent(in) :: deed
        type(error_t), allocatable, intent(inout) :: error

        if (info >= 0 .or. allocated(error)) return
        call raise(error, status_file, 'could not ' // deed)
    end subroutine check

    !> HDF5's type of a UTF-8 text of any length (its Fortran interface's H5T_STRING has variable length).
    subroutine text_type(type_id, info)
        integer(hid_t), intent(out) :: type_id
        integer, intent(out) :: info

        call h5tcopy_f(h5t_string, type_id, info)
        if (info >= 0) call h5tset_cset_f(type_id, h5t_cset_utf8_f, info)
    end subroutine text_type

    !> Open a file for reading. The library has been started.
    subroutine open_file(path, file, error)
        character(*), intent(in) :: path
        integer(hid_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error

        file = c_open_to_read(path // c_null_char)
        if (file < 0) call raise(error, status_file, 'it is no HDF5 file, or is damaged')
    end subroutine open_file

    !> Whether a type is of a class, and (for texts) of variable length.
    logical function is_class(type_id, class)
        integer(hid_t), intent(in) :: type_id
        integer, intent(in) :: class
        integer :: found, info

        call h5tget_class_f(type_id, found, info)
        is_class = info >= 0 .and. found == class
        if (is_class .and. class == h5t_string_f) call h5tis_variable_str_f(type_id, is_class, info)
    end function is_class

    !> Open an attribute, if it has the class.
    subroutine open_attribute(object, name, class, attribute, info)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        integer, intent(in) :: class
        integer(hid_t), intent(out) :: attribute
        integer, intent(out) :: info
        integer(hid_t) :: type_id
        integer :: ignored

        call h5aopen_f(object, name, attribute, info)
        if (info < 0) return
        call h5aget_type_f(attribute, type_id, info)
        if (info >= 0) then
            if (.not. is_class(type_id, class)) info = -1
            call h5tclose_f(type_id, ignored)
        end if
        if (info < 0) call h5aclose_f(attribute, ignored)
    end subroutine open_attribute

    subroutine get_integer_attribute(object, name, number, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        integer, intent(out) :: number
        type(error_t), allocatable, intent(out) :: error
        integer, target :: value
        type(c_ptr) :: place
        integer(hid_t) :: attribute
        integer :: info, ignored

        value = 0
        call open_attribute(object, name, h5t_integer_f, attribute, info)
        if (info >= 0) then
            place = c_loc(value)
            call h5aread_f(attribute, h5t_native_integer, place, info)
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
        type(c_ptr) :: place
        integer(hid_t) :: attribute
        integer :: info, ignored

        value = 0.0_wp
        call open_attribute(object, name, h5t_float_f, attribute, info)
        if (info >= 0) then
            place = c_loc(value)
            call h5aread_f(attribute, h5t_native_double, place, info)
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
        type(c_ptr), target :: address
        integer(hid_t) :: attribute, type_id
        type(c_ptr) :: place
        integer :: info, ignored

        text = ''
        call open_attribute(object, name, h5t_string_f, attribute, info)
        if (info >= 0) then
            call text_type(type_id, info)
            place = c_loc(address)
            if (info >= 0) call h5aread_f(attribute, type_id, place, info)
            if (info >= 0) call take_text(address, text)
            call h5tclose_f(type_id, ignored)
            call h5aclose_f(attribute, ignored)
        end if
        call check(info, 'read attribute ' // name, error)
    end subroutine get_text_attribute

    !> The text at an address that HDF5 has given, which is freed; empty for none.
    subroutine take_text(address, text)
        type(c_ptr), intent(in) :: address
        character(:), allocatable, intent(out) :: text
        character(kind=c_char), pointer :: characters(:)
        integer :: i, n

        text = ''
        if (.not. c_associated(address)) return
        n = int(c_length(address))
        call c_f_pointer(address, characters, [n])
        deallocate (text)
        allocate (character(n) :: text)
        do i = 1, n
            text(i:i) = characters(i)
        end do
        call c_free(address)
    end subroutine take_text

    !> Open a dataset of the class (or any_class) and number of dimensions; `extent` as Fortran orders it.
    subroutine open_dataset(parent, name, class, dataset, extent, info)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer, intent(in) :: class
        integer(hid_t), intent(out) :: dataset
        integer(hsize_t), intent(out) :: extent(:)
        integer, intent(out) :: info
        integer(hid_t) :: type_id, space
        integer(hsize_t) :: most(size(extent))
        integer :: rank, ignored
        logical :: exists

        call h5lexists_f(parent, name, exists, info)
        if (info >= 0 .and. .not. exists) info = -1
        if (info < 0) return
        call h5dopen_f(parent, name, dataset, info)
        if (info < 0) return
        call h5dget_type_f(dataset, type_id, info)
        if (info >= 0) then
            if (class /= any_class) then
                if (.not. is_class(type_id, class)) info = -1
            end if
            call h5tclose_f(type_id, ignored)
        end if
        if (info >= 0) then
            call h5dget_space_f(dataset, space, info)
            if (info >= 0) call h5sget_simple_extent_ndims_f(space, rank, info)
            if (info >= 0 .and. rank /= size(extent)) info = -1
            if (info >= 0 .and. rank > 0) call h5sget_simple_extent_dims_f(space, extent, most, info)
            call h5sclose_f(space, ignored)
        end if
        if (info < 0) call h5dclose_f(dataset, ignored)
    end subroutine open_dataset

    !> The deck a file is of, and the parameters that it was run with.
    subroutine get_deck(file, deck, parameters, error)
        integer(hid_t), intent(in) :: file
        character(:), allocatable, intent(out) :: deck, parameters
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), target :: address
        integer(hid_t) :: dataset, type_id
        type(c_ptr) :: place
        integer(hsize_t) :: none(0)
        integer :: info, ignored

        deck = ''
        call open_dataset(file, 'deck', h5t_string_f, dataset, none, info)
        if (info >= 0) then
            call text_type(type_id, info)
            place = c_loc(address)
            if (info >= 0) call h5dread_f(dataset, type_id, place, info)
            if (info >= 0) call take_text(address, deck)
            call h5tclose_f(type_id, ignored)
            if (info >= 0) call get_text_attribute(dataset, 'parameters', parameters, error)
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read deck', error)
    end subroutine get_deck

    subroutine get_reals(parent, name, values, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        real(wp), allocatable, target, intent(out) :: values(:)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: dataset
        integer(hsize_t) :: extent(1)
        type(c_ptr) :: place
        integer :: info, ignored

        call open_dataset(parent, name, h5t_float_f, dataset, extent, info)
        if (info >= 0) then
            allocate (values(extent(1)), stat=info)
            if (info > 0) info = -1
            if (info >= 0 .and. extent(1) > 0) then
                place = c_loc(values)
                call h5dread_f(dataset, h5t_native_double, place, info)
            end if
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read ' // name, error)
    end subroutine get_reals

    subroutine get_integers(parent, name, values, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer, allocatable, target, intent(out) :: values(:)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: dataset
        integer(hsize_t) :: extent(1)
        type(c_ptr) :: place
        integer :: info, ignored

        call open_dataset(parent, name, h5t_integer_f, dataset, extent, info)
        if (info >= 0) then
            allocate (values(extent(1)), stat=info)
            if (info > 0) info = -1
            if (info >= 0 .and. extent(1) > 0) then
                place = c_loc(values)
                call h5dread_f(dataset, h5t_native_integer, place, info)
            end if
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read ' // name, error)
    end subroutine get_integers

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

    subroutine open_group(parent, name, group, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer(hid_t), intent(out) :: group
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5gopen_f(parent, name, group, info)
        call check(info, 'read ' // name, error)
    end subroutine open_group

    !> Whether a group has a member of that name.
    logical function has_link(parent, name)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer :: info

        call h5lexists_f(parent, name, has_link, info)
        has_link = has_link .and. info >= 0
    end function has_link

    !> An attribute of a dataset that is a list of texts, each with a blank behind it.
    subroutine get_text_list(parent, dataset_name, name, texts, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: dataset_name, name
        character(:), allocatable, intent(out) :: texts
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), allocatable, target :: addresses(:)
        character(:), allocatable :: text
        type(c_ptr) :: buffer
        integer(hid_t) :: dataset, attribute, space, type_id
        integer(hsize_t) :: n
        integer :: info, ignored, i

        texts = ''
        call h5dopen_f(parent, dataset_name, dataset, info)
        if (info >= 0) call open_attribute(dataset, name, h5t_string_f, attribute, info)
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
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read attribute ' // name, error)
    end subroutine get_text_list

    !> A text attribute of a dataset.
    subroutine get_dataset_attribute(parent, dataset_name, name, text, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: dataset_name, name
        character(:), allocatable, intent(out) :: text
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: dataset
        integer :: info, ignored

        call h5dopen_f(parent, dataset_name, dataset, info)
        call check(info, 'read ' // dataset_name, error)
        if (allocated(error)) return
        call get_text_attribute(dataset, name, text, error)
        call h5dclose_f(dataset, ignored)
    end subroutine get_dataset_attribute

    !> All rows of a dataset of one or two dimensions, numbers of any kind: (numbers of a row, rows).
    subroutine get_table(parent, name, rows, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        real(wp), allocatable, target, intent(out) :: rows(:, :)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: dataset
        integer(hsize_t) :: extent(2)
        type(c_ptr) :: place
        integer :: info, ignored

        extent(1) = 1
        call open_dataset(parent, name, any_class, dataset, extent(2:), info)
        if (info < 0) call open_dataset(parent, name, any_class, dataset, extent, info)
        if (info >= 0) then
            allocate (rows(extent(1), extent(2)), stat=info)
            if (info > 0) info = -1
            place = c_loc(rows)
            if (info >= 0 .and. size(rows) > 0) call h5dread_f(dataset, h5t_native_double, place, info)
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read ' // name, error)
    end subroutine get_table

    !> Whether all that is in a file is what was once written there: else an error.
    subroutine verify(file, error)
        integer(hid_t), intent(in) :: file
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char) :: name(max_link)

        name = c_null_char
        if (c_verify(file, name, int(max_link, c_size_t)) == 0) return
        call raise(error, status_file, to_fortran(name) // ' is not what was written')
    end subroutine verify

    !> One text a row.
    subroutine get_texts(parent, name, texts, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        type(text_t), allocatable, intent(out) :: texts(:)
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), allocatable, target :: addresses(:)
        type(c_ptr) :: buffer
        integer(hid_t) :: dataset, type_id
        integer(hsize_t) :: extent(1)
        integer :: info, ignored, i

        call open_dataset(parent, name, h5t_string_f, dataset, extent, info)
        if (info >= 0) then
            allocate (addresses(extent(1)), texts(extent(1)))
            call text_type(type_id, info)
            buffer = c_loc(addresses)
            if (info >= 0 .and. extent(1) > 0) call h5dread_f(dataset, type_id, buffer, info)
            if (info >= 0) then
                do i = 1, int(extent(1))
                    call take_text(addresses(i), texts(i)%text)
                end do
            end if
            call h5tclose_f(type_id, ignored)
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read ' // name, error)
    end subroutine get_texts

    !> Rows first + 1, ..., first + size(rows, 2) of a dataset that has at least so many, numbers of any kind.
    subroutine get_rows(parent, name, row_shape, first, rows, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer(i8), intent(in) :: row_shape(:)         !! as Fortran orders it; its product is size(rows, 1)
        integer(i8), intent(in) :: first
        real(wp), intent(out), target, contiguous :: rows(:, :)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: dataset, file_space, memory_space
        integer(hsize_t) :: extent(size(row_shape) + 1), start(size(row_shape) + 1), part(size(row_shape) + 1)
        type(c_ptr) :: place
        integer :: info, ignored, n

        n = size(extent)
        if (size(rows) == 0) return
        call open_dataset(parent, name, any_class, dataset, extent, info)
        if (info >= 0) then
            start = 0
            start(n) = first
            part(:n - 1) = row_shape
            part(n) = size(rows, 2)
            if (any(extent(:n - 1) /= row_shape) .or. extent(n) < first + part(n)) info = -1
            if (info >= 0) then
                call h5dget_space_f(dataset, file_space, info)
                if (info >= 0) call h5sselect_hyperslab_f(file_space, h5s_select_set_f, start, part, info)
                call h5screate_simple_f(n, part, memory_space, ignored)
                place = c_loc(rows)
                if (info >= 0) call h5dread_f(dataset, h5t_native_double, place, info, memory_space, &
                    file_space)
                call h5sclose_f(memory_space, ignored)
                call h5sclose_f(file_space, ignored)
            end if
            call h5dclose_f(dataset, ignored)
        end if
        call check(info, 'read the ' // name // ' of the steps before the checkpoint', error)
    end subroutine get_rows

    !> How many rows a dataset has; -1 where there is none with rows of this shape.
    integer(i8) function count_rows(parent, name, row_shape) result(rows)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer(i8), intent(in) :: row_shape(:)
        integer(hid_t) :: dataset
        integer(hsize_t) :: extent(size(row_shape) + 1)
        integer :: info

        rows = -1
        call open_dataset(parent, name, any_class, dataset, extent, info)
        if (info < 0) return
        if (all(extent(:size(row_shape)) == row_shape)) rows = extent(size(extent))
        call h5dclose_f(dataset, info)
    end function count_rows

    subroutine close_file(file)
        integer(hid_t), intent(in) :: file
        integer :: info

        call h5fclose_f(file, info)
    end subroutine close_file

end module gb_hdf5_input
