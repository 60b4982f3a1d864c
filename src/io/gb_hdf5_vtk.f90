!> What VTK's format asks of HDF5 beyond our own files: attributes and integers of certain types, series of
!> one number, second names.
module gb_hdf5_vtk
    use, intrinsic :: iso_c_binding, only: c_char, c_int8_t, c_loc, c_size_t
    use, intrinsic :: iso_fortran_env, only: int64
    use hdf5, only: hsize_t, h5screate_simple_f, h5sclose_f, h5tcopy_f, h5tset_size_f, h5tset_strpad_f, &
        h5tclose_f, h5acreate_f, h5awrite_f, h5aclose_f, h5dcreate_f, h5dset_extent_f, h5pcreate_f, &
        h5pset_chunk_f, h5pset_fill_value_f, h5pclose_f, h5lcreate_hard_f, h5kind_to_type, h5_integer_kind, &
        h5p_dataset_create_f, h5s_unlimited_f, h5t_c_s1, h5t_str_nullpad_f, h5t_native_integer, &
        h5t_std_i32le, h5t_std_i64le, h5t_std_u8le
    use gb_error, only: error_t
    use gb_hdf5, only: hid_t, check, c_text, put_scalar, put_any, describe
    implicit none
    private

    public :: put_ascii_attribute, put_pair_attribute, put_wide_integers, put_bytes, link_object
    public :: create_constant, extend

contains

    !> A text attribute of fixed length in ASCII, as VTK asks for.
    subroutine put_ascii_attribute(object, name, text, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name, text
        type(error_t), allocatable, intent(out) :: error
        character(kind=c_char), target :: characters(len(text) + 1)
        integer(hid_t) :: type_id
        integer :: info, ignored

        characters = c_text(text)
        call h5tcopy_f(h5t_c_s1, type_id, info)
        if (info >= 0) call h5tset_size_f(type_id, int(len(text), c_size_t), info)
        if (info >= 0) call h5tset_strpad_f(type_id, h5t_str_nullpad_f, info)
        if (info >= 0) call put_scalar(object, name, type_id, c_loc(characters), error)
        if (info >= 0) call h5tclose_f(type_id, ignored)
        call check(info, 'write attribute ' // name, error)
    end subroutine put_ascii_attribute

    !> An attribute of two integers.
    subroutine put_pair_attribute(object, name, pair, error)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        integer, intent(in) :: pair(2)
        type(error_t), allocatable, intent(out) :: error
        integer, target :: values(2)
        integer(hid_t) :: space, attribute
        integer :: info, ignored

        values = pair
        call h5screate_simple_f(1, [2_hsize_t], space, info)
        if (info >= 0) call h5acreate_f(object, name, h5t_std_i64le, space, attribute, info)
        if (info >= 0) then
            call h5awrite_f(attribute, h5t_native_integer, c_loc(values), info)
            call h5aclose_f(attribute, ignored)
            call h5sclose_f(space, ignored)
        end if
        call check(info, 'write attribute ' // name, error)
    end subroutine put_pair_attribute

    !> A series of one number, which takes no place in the file: only its length grows, by `extend`.
    subroutine create_constant(parent, name, number, unit, description, dataset, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: number
        integer(hid_t), intent(out) :: dataset
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: space, properties
        integer :: info, ignored

        call h5pcreate_f(h5p_dataset_create_f, properties, info)
        if (info >= 0) call h5pset_chunk_f(properties, 1, [1024_hsize_t], info)
        if (info >= 0) call h5pset_fill_value_f(properties, h5t_native_integer, number, info)
        if (info >= 0) call h5screate_simple_f(1, [0_hsize_t], space, info, [h5s_unlimited_f])
        if (info >= 0) call h5dcreate_f(parent, name, h5t_std_i32le, space, dataset, info, properties)
        if (info >= 0) then
            call describe(dataset, unit, description, error)
            call h5sclose_f(space, ignored)
            call h5pclose_f(properties, ignored)
        end if
        call check(info, 'create ' // name, error)
    end subroutine create_constant

    !> Another length of a series of one number.
    subroutine extend(dataset, length, error)
        integer(hid_t), intent(in) :: dataset
        integer, intent(in) :: length
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5dset_extent_f(dataset, [int(length, hsize_t)], info)
        call check(info, 'extend a dataset', error)
    end subroutine extend

    !> Another name, `path` from the group `parent`, for an object that is there under `name`.
    subroutine link_object(parent, name, path, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, path
        type(error_t), allocatable, intent(out) :: error
        integer :: info

        call h5lcreate_hard_f(parent, name, parent, path, info)
        call check(info, 'create ' // path, error)
    end subroutine link_object

    !> Integers stored with 64 bits.
    subroutine put_wide_integers(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: values(:)
        type(error_t), allocatable, intent(out) :: error
        integer(int64), target :: wide(size(values))

        wide = int(values, int64)
        call put_any(parent, name, h5t_std_i64le, h5kind_to_type(int64, h5_integer_kind), &
            int(shape(values), hsize_t), c_loc(wide), unit, description, error)
    end subroutine put_wide_integers

    !> Integers from 0 to 127 stored as bytes.
    subroutine put_bytes(parent, name, values, unit, description, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: values(:)
        type(error_t), allocatable, intent(out) :: error
        integer(c_int8_t), target :: bytes(size(values))

        bytes = int(values, c_int8_t)
        call put_any(parent, name, h5t_std_u8le, h5t_std_u8le, int(shape(values), hsize_t), c_loc(bytes), &
            unit, &
            description, error)
    end subroutine put_bytes

end module gb_hdf5_vtk
