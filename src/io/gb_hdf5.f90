!> A thin layer over HDF5: groups, attributes, whole arrays, and series that grow row by row. Every call
!> checks HDF5's answer; the first one that fails is reported as an error_t with exit status 3.
module gb_hdf5
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int8_t, c_loc, c_null_char, c_ptr
    use, intrinsic :: iso_fortran_env, only: real32, int32, int64
    use hdf5, only: hid_t, hsize_t, h5open_f, h5eset_auto_f, h5fcreate_f, h5fflush_f, h5fclose_f, &
        h5gcreate_f, h5gclose_f, h5screate_f, h5screate_simple_f, h5sclose_f, h5sselect_hyperslab_f, &
        h5tcopy_f, h5tset_cset_f, h5tclose_f, h5acreate_f, h5aopen_f, h5awrite_f, h5aclose_f, h5dcreate_f, &
        h5dwrite_f, h5dclose_f, h5dset_extent_f, h5dget_space_f, h5pcreate_f, h5pset_chunk_f, h5pclose_f, &
        h5f_acc_trunc_f, h5f_scope_global_f, h5s_scalar_f, h5s_select_set_f, h5s_unlimited_f, h5t_string, &
        h5t_cset_utf8_f, h5t_native_double, h5t_native_integer, h5t_std_i8le, h5p_dataset_create_f, &
        h5p_group_create_f, h5pset_link_creation_order_f, h5p_crt_order_tracked_f, h5p_crt_order_indexed_f, &
        h5t_std_i32le, h5t_ieee_f64le, h5t_ieee_f32le, h5t_std_i64le, h5t_native_real, h5kind_to_type, &
        h5_integer_kind
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_file
    use gb_posix, only: set_environment_default
    implicit none
    private

    public :: hid_t, create_file, flush_file, close_file, create_group, close_group, close_dataset
    public :: put_attribute, put_array, put_text, replace_attribute
    public :: check, c_text, put_scalar, put_any, describe

    !> How the numbers of a series are stored.
    integer, parameter, public :: stored_real64 = 1, stored_real32 = 2, stored_int32 = 3, stored_int64 = 4

    !> Write a scalar attribute: text (UTF-8, variable length), integer or real.
    interface put_attribute
        module procedure put_text_attribute, put_integer_attribute, put_real_attribute
    end interface put_attribute

    !> Give an existing attribute another value.
    interface replace_attribute
        module procedure replace_text_attribute, replace_real_attribute, replace_integer_attribute
    end interface replace_attribute

    !> Write a whole dataset with its unit and description.
    interface put_array
        module procedure put_reals, put_real_table, put_real_blocks, put_integers, put_integer_table, &
            put_byte_table
    end interface put_array

    !> A dataset that grows by rows. Rows gather in a buffer and are written when it is full or on `flush`.
    type, public :: series_t
        integer(hid_t) :: dataset = -1
        integer(hsize_t) :: written = 0                 !! rows in the file
        integer :: pending = 0                          !! rows in the buffer
        integer(hsize_t), allocatable :: row_shape(:)   !! as Fortran orders it
        integer :: stored = 1                           !! as stored_... says
        integer(hsize_t) :: records = 1                 !! places of the growing dimension that a row takes
        real(wp), allocatable :: buffer(:, :)           !! (row size, rows)
    contains
        procedure :: create => create_series
        procedure :: create_records
        procedure :: append
        procedure :: flush => flush_series
        procedure :: close => close_series
    end type series_t

    interface
        !> Keep HDF5 from tidying up at the end of the program: after a disk has run full it would crash
        !> there. Whatever went well has been closed by then.
        function h5_dont_atexit() bind(c, name="H5dont_atexit") result(info)
            import :: c_int
            integer(c_int) :: info
        end function h5_dont_atexit
    end interface

    integer, parameter :: buffer_reals = 32768          !! numbers a series holds back at most
    integer, parameter :: record_chunk = 8192           !! numbers of a chunk of records, if a row has no more

contains

    !> Start the library (quietly: its own error stack is not for users) and create the file, replacing an
    !> older one.
    subroutine create_file(path, file, error)
        character(*), intent(in) :: path
        integer(hid_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        file = -1
        ! Without a lock, others can read the file while it is being written.
        call set_environment_default('HDF5_USE_FILE_LOCKING', 'FALSE')
        info = int(h5_dont_atexit())
        call h5open_f(info)
        call h5eset_auto_f(0, info)
        call h5fcreate_f(path, h5f_acc_trunc_f, file, info)
        if (info < 0) call raise(error, status_file, &
            'HDF5 cannot create the file (is another program using it?)')
    end subroutine create_file

    subroutine flush_file(file, error)
        integer(hid_t), intent(in) :: file
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5fflush_f(file, h5f_scope_global_f, info)
        call check(info, 'flush the file', error)
    end subroutine flush_file

    subroutine close_file(file, error)
        integer(hid_t), intent(in) :: file
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5fclose_f(file, info)
        call check(info, 'close the file', error)
    end subroutine close_file

    !> A group that remembers in which order its members were made: probes come back as the deck has them.
    subroutine create_group(parent, name, group, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        integer(hid_t), intent(out) :: group
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: properties
        integer :: info, ignored

        call h5pcreate_f(h5p_group_create_f, properties, info)
        if (info >= 0) call h5pset_link_creation_order_f(properties, &
            ior(h5p_crt_order_tracked_f, h5p_crt_order_indexed_f), info)
        if (info >= 0) call h5gcreate_f(parent, name, group, info, gcpl_id=properties)
        if (info >= 0) call h5pclose_f(properties, ignored)
        call check(info, 'create ' // name, error)
    end subroutine create_group

    subroutine close_group(group)
        integer(hid_t), intent(in) :: group
        integer :: info

        call h5gclose_f(group, info)
    end subroutine close_group

    subroutine close_dataset(dataset)
        integer(hid_t), intent(in) :: dataset
        integer :: info

        call h5dclose_f(dataset, info)
    end subroutine close_dataset

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

    !> The text with a closing NUL, one character an element, as C wants it.
    pure function c_text(text) result(characters)
        character(*), intent(in) :: text
        character(kind=c_char) :: characters(len(text) + 1)
        integer :: i

        do i = 1, len(text)
            characters(i) = text(i:i)
        end do
        characters(len(text) + 1) = c_null_char
    end function c_text

    subroutine put_text_attribute(object, name, text, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name, text
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char), target :: characters(len(text) + 1)
        type(c_ptr), target :: address
        integer(hid_t) :: type_id, space, attribute
        integer :: info, ignored

        characters = c_text(text)
        address = c_loc(characters)
        call text_type(type_id, info)
        if (info >= 0) call h5screate_f(h5s_scalar_f, space, info)
        if (info >= 0) call h5acreate_f(object, name, type_id, space, attribute, info)
        if (info >= 0) then
            call h5awrite_f(attribute, type_id, c_loc(address), info)
            call h5aclose_f(attribute, ignored)
            call h5sclose_f(space, ignored)
            call h5tclose_f(type_id, ignored)
        end if
        call check(info, 'write attribute ' // name, error)
    end subroutine put_text_attribute

    !> Give an existing text attribute another text.
    subroutine replace_text_attribute(object, name, text, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name, text
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char), target :: characters(len(text) + 1)
        type(c_ptr), target :: address
        integer(hid_t) :: type_id, attribute
        integer :: info, ignored

        characters = c_text(text)
        address = c_loc(characters)
        call text_type(type_id, info)
        if (info >= 0) call h5aopen_f(object, name, attribute, info)
        if (info >= 0) then
            call h5awrite_f(attribute, type_id, c_loc(address), info)
            call h5aclose_f(attribute, ignored)
            call h5tclose_f(type_id, ignored)
        end if
        call check(info, 'write attribute ' // name, error)
    end subroutine replace_text_attribute

    !> Give an existing integer attribute another value.
    subroutine replace_integer_attribute(object, name, number, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        integer, intent(in) :: number
        type(error_t), allocatable, intent(out) :: error
        integer, target :: value
        integer(hid_t) :: attribute
        integer :: info, ignored

        value = number
        call h5aopen_f(object, name, attribute, info)
        if (info >= 0) then
            call h5awrite_f(attribute, h5t_native_integer, c_loc(value), info)
            call h5aclose_f(attribute, ignored)
        end if
        call check(info, 'write attribute ' // name, error)
    end subroutine replace_integer_attribute

    !> Give an existing real attribute another value.
    subroutine replace_real_attribute(object, name, number, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        real(wp), intent(in) :: number
        type(error_t), allocatable, intent(out) :: error
        real(wp), target :: value
        integer(hid_t) :: attribute
        integer :: info, ignored

        value = number
        call h5aopen_f(object, name, attribute, info)
        if (info >= 0) then
            call h5awrite_f(attribute, h5t_native_double, c_loc(value), info)
            call h5aclose_f(attribute, ignored)
        end if
        call check(info, 'write attribute ' // name, error)
    end subroutine replace_real_attribute

    subroutine put_integer_attribute(object, name, number, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        integer, intent(in) :: number
        type(error_t), allocatable, intent(out) :: error
        integer, target :: value

        value = number
        call put_scalar(object, name, h5t_native_integer, c_loc(value), error)
    end subroutine put_integer_attribute

    subroutine put_real_attribute(object, name, number, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        real(wp), intent(in) :: number
        type(error_t), allocatable, intent(out) :: error
        real(wp), target :: value

        value = number
        call put_scalar(object, name, h5t_native_double, c_loc(value), error)
    end subroutine put_real_attribute

    subroutine put_scalar(object, name, type_id, address, error)
        integer(hid_t), intent(in) :: object, type_id
        character(*), intent(in) :: name
        type(c_ptr), intent(in) :: address
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: space, attribute
        integer :: info, ignored

        call h5screate_f(h5s_scalar_f, space, info)
        if (info >= 0) call h5acreate_f(object, name, type_id, space, attribute, info)
        if (info >= 0) then
            call h5awrite_f(attribute, type_id, address, info)
            call h5aclose_f(attribute, ignored)
            call h5sclose_f(space, ignored)
        end if
        call check(info, 'write attribute ' // name, error)
    end subroutine put_scalar

    !> A scalar text dataset; the dataset's handle is left open for attributes.
    subroutine put_text(parent, name, text, dataset, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, text
        integer(hid_t), intent(out) :: dataset
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char), allocatable, target :: characters(:)
        type(c_ptr), target :: address
        integer(hid_t) :: type_id, space
        integer :: info, ignored

        allocate (characters(len(text) + 1))
        characters = c_text(text)
        address = c_loc(characters)
        call text_type(type_id, info)
        if (info >= 0) call h5screate_f(h5s_scalar_f, space, info)
        if (info >= 0) call h5dcreate_f(parent, name, type_id, space, dataset, info)
        if (info >= 0) then
            call h5dwrite_f(dataset, type_id, c_loc(address), info)
            call h5sclose_f(space, ignored)
            call h5tclose_f(type_id, ignored)
        end if
        call check(info, 'write ' // name, error)
    end subroutine put_text

    subroutine put_reals(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        real(wp), intent(in), target, contiguous :: values(:)
        type(error_t), allocatable, intent(out) :: error

        call put_any(parent, name, h5t_ieee_f64le, h5t_native_double, int(shape(values), hsize_t), &
            c_loc(values), unit, description, error)
    end subroutine put_reals

    subroutine put_real_table(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        real(wp), intent(in), target, contiguous :: values(:, :)
        type(error_t), allocatable, intent(out) :: error

        call put_any(parent, name, h5t_ieee_f64le, h5t_native_double, int(shape(values), hsize_t), &
            c_loc(values), unit, description, error)
    end subroutine put_real_table

    subroutine put_real_blocks(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        real(wp), intent(in), target, contiguous :: values(:, :, :)
        type(error_t), allocatable, intent(out) :: error

        call put_any(parent, name, h5t_ieee_f64le, h5t_native_double, int(shape(values), hsize_t), &
            c_loc(values), unit, description, error)
    end subroutine put_real_blocks

    subroutine put_integers(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in), target, contiguous :: values(:)
        type(error_t), allocatable, intent(out) :: error

        call put_any(parent, name, h5t_std_i32le, h5t_native_integer, int(shape(values), hsize_t), &
            c_loc(values), unit, description, error)
    end subroutine put_integers

    subroutine put_integer_table(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in), target, contiguous :: values(:, :)
        type(error_t), allocatable, intent(out) :: error

        call put_any(parent, name, h5t_std_i32le, h5t_native_integer, int(shape(values), hsize_t), &
            c_loc(values), unit, description, error)
    end subroutine put_integer_table

    subroutine put_byte_table(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer(c_int8_t), intent(in), target, contiguous :: values(:, :)
        type(error_t), allocatable, intent(out) :: error

        call put_any(parent, name, h5t_std_i8le, h5t_std_i8le, int(shape(values), hsize_t), c_loc(values), &
            unit, description, error)
    end subroutine put_byte_table

    subroutine put_any(parent, name, file_type, memory_type, extent, address, unit, description, error)
        integer(hid_t), intent(in) :: parent, file_type, memory_type
        character(*), intent(in) :: name, unit, description
        integer(hsize_t), intent(in) :: extent(:)
        type(c_ptr), intent(in) :: address
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: space, dataset
        integer :: info, ignored

        call h5screate_simple_f(size(extent), extent, space, info)
        if (info >= 0) call h5dcreate_f(parent, name, file_type, space, dataset, info)
        if (info >= 0) then
            call h5dwrite_f(dataset, memory_type, address, info)
            call describe(dataset, unit, description, error)
            call h5dclose_f(dataset, ignored)
            call h5sclose_f(space, ignored)
        end if
        call check(info, 'write ' // name, error)
    end subroutine put_any

    subroutine describe(dataset, unit, description, error)
        integer(hid_t), intent(in) :: dataset
        character(*), intent(in) :: unit, description
        type(error_t), allocatable, intent(out) :: error

        call put_attribute(dataset, 'unit', unit, error)
        if (allocated(error)) return
        call put_attribute(dataset, 'description', description, error)
    end subroutine describe

    !> An empty series. Rows have the given shape; `whole` stores them as 32-bit integers.
    subroutine create_series(self, parent, name, row_shape, whole, unit, description, error)
        class(series_t), intent(inout) :: self
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: row_shape(:)             !! empty for scalars
        logical, intent(in) :: whole
        type(error_t), allocatable, intent(out) :: error

        call self%create_records(parent, name, row_shape, 1, merge(stored_int32, stored_real64, whole), &
            unit, &
            description, error)
    end subroutine create_series

    !> An empty series whose rows are `records` records of the given shape each, one behind the other in the
    !> growing dimension, stored as `stored_...` says.
    subroutine create_records(self, parent, name, row_shape, records, stored, unit, description, error)
        class(series_t), intent(inout) :: self
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: row_shape(:)             !! of a record; empty for scalars
        integer, intent(in) :: records, stored
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: space, properties
        integer(hsize_t) :: none(size(row_shape) + 1), limit(size(row_shape) + 1), chunk(size(row_shape) + 1)
        integer :: info, ignored, row_size, rows

        row_size = product(row_shape)*records
        rows = max(1, min(512, buffer_reals/row_size))
        self%row_shape = int(row_shape, hsize_t)
        self%records = records
        self%stored = stored
        self%written = 0
        self%pending = 0
        if (allocated(self%buffer)) deallocate (self%buffer)
        allocate (self%buffer(row_size, rows))
        none = [int(row_shape, hsize_t), 0_hsize_t]
        limit = [int(row_shape, hsize_t), h5s_unlimited_f]
        chunk = [int(row_shape, hsize_t), int(rows, hsize_t)*records]
        ! A chunk takes its whole place in the file, however few its rows.
        if (records > 1) chunk(size(chunk)) = records*max(1, min(rows, record_chunk/row_size))
        call h5pcreate_f(h5p_dataset_create_f, properties, info)
        if (info >= 0) call h5pset_chunk_f(properties, size(chunk), chunk, info)
        if (info >= 0) call h5screate_simple_f(size(none), none, space, info, limit)
        if (info >= 0) call h5dcreate_f(parent, name, file_type(stored), space, self%dataset, info, &
            properties)
        if (info >= 0) then
            call describe(self%dataset, unit, description, error)
            call h5sclose_f(space, ignored)
            call h5pclose_f(properties, ignored)
        end if
        call check(info, 'create ' // name, error)
    end subroutine create_records

    integer(hid_t) function file_type(stored)
        integer, intent(in) :: stored

        select case (stored)
        case (stored_real32)
            file_type = h5t_ieee_f32le
        case (stored_int32)
            file_type = h5t_std_i32le
        case (stored_int64)
            file_type = h5t_std_i64le
        case default
            file_type = h5t_ieee_f64le
        end select
    end function file_type

    subroutine append(self, row, error)
        class(series_t), intent(inout) :: self
        real(wp), intent(in) :: row(:)
        type(error_t), allocatable, intent(out) :: error

        self%pending = self%pending + 1
        self%buffer(:, self%pending) = row
        if (self%pending == size(self%buffer, 2)) call self%flush(error)
    end subroutine append

    !> Hand the buffered rows of a created series to HDF5.
    subroutine flush_series(self, error)
        class(series_t), intent(inout), target :: self
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: file_space, memory_space
        integer(hsize_t) :: extent(size(self%row_shape) + 1), start(size(self%row_shape) + 1), &
            rows(size(self%row_shape) + 1)
        integer :: info, ignored

        if (self%pending == 0) return
        extent = [self%row_shape, (self%written + self%pending)*self%records]
        start = 0
        start(size(start)) = self%written*self%records
        rows = [self%row_shape, self%pending*self%records]
        call h5dset_extent_f(self%dataset, extent, info)
        if (info >= 0) call h5dget_space_f(self%dataset, file_space, info)
        if (info >= 0) call h5sselect_hyperslab_f(file_space, h5s_select_set_f, start, rows, info)
        if (info >= 0) call h5screate_simple_f(size(rows), rows, memory_space, info)
        if (info >= 0) then
            call write_buffer(self, memory_space, file_space, info)
            call h5sclose_f(memory_space, ignored)
            call h5sclose_f(file_space, ignored)
        end if
        call check(info, 'write rows', error)
        if (allocated(error)) return
        self%written = self%written + self%pending
        self%pending = 0
    end subroutine flush_series

    !> The buffer as it is stored: HDF5's own conversion of numbers costs more to set up than a short run
    !> takes.
    subroutine write_buffer(self, memory_space, file_space, info)
        class(series_t), intent(in), target :: self
        integer(hid_t), intent(in) :: memory_space, file_space
        integer, intent(out) :: info
        real(real32), allocatable, target :: short(:, :)
        integer(int32), allocatable, target :: whole(:, :)
        integer(int64), allocatable, target :: long(:, :)

        select case (self%stored)
        case (stored_real32)
            short = real(self%buffer(:, :self%pending), real32)
            call h5dwrite_f(self%dataset, h5t_native_real, c_loc(short), info, memory_space, file_space)
        case (stored_int32)
            whole = nint(self%buffer(:, :self%pending), int32)
            call h5dwrite_f(self%dataset, h5t_native_integer, c_loc(whole), info, memory_space, file_space)
        case (stored_int64)
            long = nint(self%buffer(:, :self%pending), int64)
            call h5dwrite_f(self%dataset, h5kind_to_type(int64, h5_integer_kind), c_loc(long), info, &
                memory_space, file_space)
        case default
            call h5dwrite_f(self%dataset, h5t_native_double, c_loc(self%buffer), info, memory_space, &
                file_space)
        end select
    end subroutine write_buffer

    subroutine close_series(self, error)
        class(series_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        if (self%dataset < 0) return
        call self%flush(error)
        call h5dclose_f(self%dataset, info)
        call check(info, 'close a dataset', error)
        self%dataset = -1
    end subroutine close_series

end module gb_hdf5
