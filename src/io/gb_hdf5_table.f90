!> Datasets of a known number of rows, one row a member, written and read in stretches of rows. They are
!> allocated when they are made, so that to fill them changes nothing in the file but their own numbers.
module gb_hdf5_table
    use, intrinsic :: iso_c_binding, only: c_char, c_loc, c_null_char, c_ptr
    use hdf5, only: hid_t, hsize_t, h5aclose_f, h5acreate_f, h5awrite_f, h5dclose_f, h5dcreate_f, &
        h5dget_space_f, h5dget_type_f, h5dopen_f, h5dread_f, h5dwrite_f, h5pclose_f, &
        h5pcreate_f, h5pset_alloc_time_f, h5pset_chunk_f, h5sclose_f, h5screate_simple_f, &
        h5sget_simple_extent_dims_f, h5sselect_hyperslab_f, h5tclose_f, h5tequal_f, &
        h5d_alloc_time_early_f, h5p_dataset_create_f, h5s_select_set_f, h5t_ieee_f64le, &
        h5t_native_double, h5t_std_i32le, h5t_std_i8le
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_hdf5_direct, only: describe, text_type, check
    use gb_hdf5_input, only: get_attribute, take_text
    implicit none
    private

    !> How the numbers are stored.
    integer, parameter, public :: store_real = 1, store_integer = 2, store_byte = 3

    !> Numbers: `columns` a row, or one where the dataset has one dimension.
    type, public :: table_t
        integer(hid_t) :: dataset = -1
        integer :: columns = 0                      !! 0: a dataset of one dimension
    contains
        procedure :: create => create_table
        procedure :: create_like
        procedure :: open => open_table
        procedure :: write => write_rows
        procedure :: read => read_rows
        procedure :: close => close_table
    end type table_t

    !> Texts, one a row; those that have not been written are empty.
    type, public :: text_table_t
        integer(hid_t) :: dataset = -1
    contains
        procedure :: create => create_texts
        procedure :: open => open_texts
        procedure :: write => write_one_text
        procedure :: read => read_one_text
        procedure :: close => close_texts
    end type text_table_t

    public :: put_text_list

contains

    subroutine create_table(self, parent, name, rows, columns, storage, unit, description, error)
        class(table_t), intent(inout) :: self
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: rows
        integer, intent(in) :: columns              !! 0: one dimension
        integer, intent(in) :: storage
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: space, properties, type_id
        integer :: info, ignored

        self%columns = columns
        type_id = h5t_ieee_f64le
        if (storage == store_integer) type_id = h5t_std_i32le
        if (storage == store_byte) type_id = h5t_std_i8le
        call h5pcreate_f(h5p_dataset_create_f, properties, info)
        if (info >= 0) call h5pset_alloc_time_f(properties, h5d_alloc_time_early_f, info)
        if (info >= 0) call make_space(self%columns, rows, space, info)
        if (info >= 0) call h5dcreate_f(parent, name, type_id, space, self%dataset, info, properties)
        if (info >= 0) then
            call describe(self%dataset, unit, description, error)
            call h5sclose_f(space, ignored)
            call h5pclose_f(properties, ignored)
        end if
        call check(info, 'create ' // name, error)
    end subroutine create_table

    subroutine make_space(columns, rows, space, info)
        integer, intent(in) :: columns, rows
        integer(hid_t), intent(out) :: space
        integer, intent(out) :: info

        if (columns == 0) then
            call h5screate_simple_f(1, [int(rows, hsize_t)], space, info)
        else
            call h5screate_simple_f(2, [int(columns, hsize_t), int(rows, hsize_t)], space, info)
        end if
    end subroutine make_space

    !> A table of another number of rows, which stores the same kind of numbers and says the same of them.
    subroutine create_like(self, parent, name, rows, model, error)
        class(table_t), intent(inout) :: self
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer, intent(in) :: rows
        type(table_t), intent(in) :: model
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: unit, description
        integer(hid_t) :: type_id
        integer :: info, storage, ignored
        logical :: same

        call get_attribute(model%dataset, 'unit', unit, error)
        if (.not. allocated(error)) call get_attribute(model%dataset, 'description', description, error)
        if (allocated(error)) return
        call h5dget_type_f(model%dataset, type_id, info)
        storage = store_real
        call h5tequal_f(type_id, h5t_std_i32le, same, info)
        if (same) storage = store_integer
        call h5tequal_f(type_id, h5t_std_i8le, same, info)
        if (same) storage = store_byte
        call h5tclose_f(type_id, ignored)
        call self%create(parent, name, rows, model%columns, storage, unit, description, error)
    end subroutine create_like

    !> A table of an existing file and its number of rows.
    subroutine open_table(self, parent, name, rows, error)
        class(table_t), intent(inout) :: self
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer, intent(out) :: rows
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: space
        integer(hsize_t) :: extent(2), limit(2)
        integer :: info, rank, ignored

        rows = 0
        call h5dopen_f(parent, name, self%dataset, info)
        if (info >= 0) call h5dget_space_f(self%dataset, space, info)
        if (info >= 0) then
            extent = 0
            call h5sget_simple_extent_dims_f(space, extent, limit, rank)
            call h5sclose_f(space, ignored)
            if (rank < 1) info = -1
        end if
        call check(info, 'read ' // name, error)
        if (allocated(error)) return
        self%columns = 0
        if (rank == 2) self%columns = int(extent(1))
        rows = int(extent(rank))
    end subroutine open_table

    !> Open the file's and the memory's spaces for `count` rows behind the first `before`.
    subroutine select_rows(dataset, columns, before, count, file_space, memory_space, info)
        integer(hid_t), intent(in) :: dataset
        integer, intent(in) :: columns, before, count
        integer(hid_t), intent(out) :: file_space, memory_space
        integer, intent(out) :: info

        call h5dget_space_f(dataset, file_space, info)
        if (info >= 0) then
            if (columns == 0) then
                call h5sselect_hyperslab_f(file_space, h5s_select_set_f, [int(before, hsize_t)], &
                    [int(count, hsize_t)], info)
            else
                call h5sselect_hyperslab_f(file_space, h5s_select_set_f, [0_hsize_t, int(before, hsize_t)], &
                    [int(columns, hsize_t), int(count, hsize_t)], info)
            end if
        end if
        if (info >= 0) call make_space(columns, count, memory_space, info)
    end subroutine select_rows

    !> Write rows behind the first `before`.
    subroutine write_rows(self, before, rows, error)
        class(table_t), intent(in) :: self
        integer, intent(in) :: before
        real(wp), intent(in), target, contiguous :: rows(:, :)      !! (columns, count)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: file_space, memory_space
        integer :: info, ignored

        call select_rows(self%dataset, self%columns, before, size(rows, 2), file_space, memory_space, info)
        if (info >= 0) then
            call h5dwrite_f(self%dataset, h5t_native_double, c_loc(rows), info, memory_space, file_space)
            call h5sclose_f(memory_space, ignored)
            call h5sclose_f(file_space, ignored)
        end if
        call check(info, 'write rows', error)
    end subroutine write_rows

    !> Read rows behind the first `before`.
    subroutine read_rows(self, before, rows, error)
        class(table_t), intent(in) :: self
        integer, intent(in) :: before
        real(wp), intent(inout), target, contiguous :: rows(:, :)   !! (columns, count)
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr) :: buffer
        integer(hid_t) :: file_space, memory_space
        integer :: info, ignored

        call select_rows(self%dataset, self%columns, before, size(rows, 2), file_space, memory_space, info)
        if (info >= 0) then
            buffer = c_loc(rows)
            call h5dread_f(self%dataset, h5t_native_double, buffer, info, memory_space, file_space)
            call h5sclose_f(memory_space, ignored)
            call h5sclose_f(file_space, ignored)
        end if
        call check(info, 'read rows', error)
    end subroutine read_rows

    subroutine close_table(self)
        class(table_t), intent(inout) :: self
        integer :: info

        if (self%dataset >= 0) call h5dclose_f(self%dataset, info)
        self%dataset = -1
    end subroutine close_table

    !> Chunks come into being only where a text is written.
    subroutine create_texts(self, parent, name, rows, description, error)
        class(text_table_t), intent(inout) :: self
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, description
        integer, intent(in) :: rows
        type(error_t), allocatable, intent(out) :: error
        integer, parameter :: chunk = 256
        integer(hid_t) :: space, properties, type_id
        integer :: info, ignored

        call text_type(type_id, info)
        if (info >= 0) call h5pcreate_f(h5p_dataset_create_f, properties, info)
        if (info >= 0) call h5pset_chunk_f(properties, 1, [int(max(1, min(chunk, rows)), hsize_t)], info)
        if (info >= 0) call make_space(0, rows, space, info)
        if (info >= 0) call h5dcreate_f(parent, name, type_id, space, self%dataset, info, properties)
        if (info >= 0) then
            call describe(self%dataset, '', description, error)
            call h5sclose_f(space, ignored)
            call h5pclose_f(properties, ignored)
            call h5tclose_f(type_id, ignored)
        end if
        call check(info, 'create ' // name, error)
    end subroutine create_texts

    subroutine open_texts(self, parent, name, error)
        class(text_table_t), intent(inout) :: self
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5dopen_f(parent, name, self%dataset, info)
        call check(info, 'read ' // name, error)
    end subroutine open_texts

    !> Write the text of the row behind the first `before`.
    subroutine write_one_text(self, before, text, error)
        class(text_table_t), intent(in) :: self
        integer, intent(in) :: before
        character(*), intent(in) :: text
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char), allocatable, target :: characters(:)
        type(c_ptr), target :: address
        integer(hid_t) :: file_space, memory_space, type_id
        integer :: info, ignored, i

        allocate (characters(len(text) + 1))
        do i = 1, len(text)
            characters(i) = text(i:i)
        end do
        characters(len(text) + 1) = c_null_char
        address = c_loc(characters)
        call text_type(type_id, info)
        if (info >= 0) call select_rows(self%dataset, 0, before, 1, file_space, memory_space, info)
        if (info >= 0) then
            call h5dwrite_f(self%dataset, type_id, c_loc(address), info, memory_space, file_space)
            call h5sclose_f(memory_space, ignored)
            call h5sclose_f(file_space, ignored)
            call h5tclose_f(type_id, ignored)
        end if
        call check(info, 'write a text', error)
    end subroutine write_one_text

    !> Read the text of the row behind the first `before`.
    subroutine read_one_text(self, before, text, error)
        class(text_table_t), intent(in) :: self
        integer, intent(in) :: before
        character(:), allocatable, intent(out) :: text
        type(error_t), allocatable, intent(out) :: error
        type(c_ptr), target :: address
        type(c_ptr) :: buffer
        integer(hid_t) :: file_space, memory_space, type_id
        integer :: info, ignored

        text = ''
        call text_type(type_id, info)
        if (info >= 0) call select_rows(self%dataset, 0, before, 1, file_space, memory_space, info)
        buffer = c_loc(address)
        if (info >= 0) call h5dread_f(self%dataset, type_id, buffer, info, memory_space, file_space)
        call check(info, 'read a text', error)
        if (allocated(error)) return
        call take_text(address, text)
        call h5sclose_f(memory_space, ignored)
        call h5sclose_f(file_space, ignored)
        call h5tclose_f(type_id, ignored)
    end subroutine read_one_text

    subroutine close_texts(self)
        class(text_table_t), intent(inout) :: self
        integer :: info

        if (self%dataset >= 0) call h5dclose_f(self%dataset, info)
        self%dataset = -1
    end subroutine close_texts

    !> An attribute that is a list of texts.
    subroutine put_text_list(object, name, texts, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        character(*), intent(in) :: texts(:)
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char), allocatable, target :: characters(:, :)
        type(c_ptr), allocatable, target :: addresses(:)
        integer(hid_t) :: type_id, space, attribute
        integer :: info, ignored, i, k

        allocate (characters(len(texts) + 1, size(texts)), addresses(size(texts)))
        characters = c_null_char
        do i = 1, size(texts)
            do k = 1, len_trim(texts(i))
                characters(k, i) = texts(i)(k:k)
            end do
            addresses(i) = c_loc(characters(1, i))
        end do
        call text_type(type_id, info)
        if (info >= 0) call make_space(0, size(texts), space, info)
        if (info >= 0) call h5acreate_f(object, name, type_id, space, attribute, info)
        if (info >= 0) then
            call h5awrite_f(attribute, type_id, c_loc(addresses), info)
            call h5aclose_f(attribute, ignored)
            call h5sclose_f(space, ignored)
            call h5tclose_f(type_id, ignored)
        end if
        call check(info, 'write attribute ' // name, error)
    end subroutine put_text_list

end module gb_hdf5_table
