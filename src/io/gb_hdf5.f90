!> Writes a tree as HDF5. The numbers are in the file already: HDF5 is told where, and makes what describes
!> them. Every call checks HDF5's answer; the first one that fails is reported with exit status 3.
module gb_hdf5
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int32_t, c_loc, c_null_char, c_ptr, c_size_t
    use hdf5, only: hid_t, hsize_t, size_t, h5open_f, h5eset_auto_f, h5fclose_f, h5gcreate_f, h5screate_f, &
        h5screate_simple_f, h5sclose_f, h5tcopy_f, h5tset_cset_f, h5tset_size_f, h5tset_strpad_f, &
        h5tclose_f, h5acreate_f, h5awrite_f, h5aclose_f, h5dcreate_f, h5dwrite_f, h5pcreate_f, &
        h5pset_chunk_f, h5pclose_f, h5pset_alloc_time_f, h5pset_fill_time_f, h5pset_obj_track_times_f, &
        h5pset_attr_phase_change_f, h5pset_link_phase_change_f, h5pset_link_creation_order_f, &
        h5pset_buffer_f, h5lcreate_hard_f, h5s_scalar_f, h5t_string, h5t_cset_utf8_f, h5t_c_s1, &
        h5t_str_nullpad_f, h5t_native_double, h5t_native_integer, h5t_native_real, h5t_std_i8le, &
        h5t_std_u8le, h5t_std_u32le, h5t_std_i64le, h5kind_to_type, h5_integer_kind, h5p_dataset_create_f, &
        h5p_dataset_xfer_f, h5p_group_create_f, h5p_crt_order_tracked_f, h5p_crt_order_indexed_f, &
        h5d_alloc_time_early_f, h5d_fill_time_never_f, h5ocopy_f, h5oopen_f, h5oclose_f, &
        h5sselect_elements_f, h5s_select_set_f
    use gb_checksum, only: add_to_checksum
    use gb_kinds, only: i8
    use gb_error, only: error_t, raise, status_file
    use gb_store, only: store_t, object_address, link_object
    use gb_text, only: newline
    use gb_tree, only: tree_t, node_t, attribute_t, node_group, node_array, node_text, node_texts, &
        node_link, stored_real32, stored_int32, stored_int64, stored_int8, stored_uint8, attribute_text, &
        attribute_ascii, attribute_integer, attribute_real, attribute_pair, attribute_list, root
    implicit none
    private

    public :: start_hdf5, write_tree, write_kept_nodes, copy_kept_objects

    !> Members and attributes of an object up to which HDF5 keeps them in its header; more get an index.
    integer, parameter :: most_in_header = 64
    !> HDF5 converts texts in a buffer of a megabyte, which it clears first; ours are short.
    integer(hsize_t), parameter :: conversion_bytes = 4096
    integer(hsize_t), parameter :: lines_a_chunk = 256      !! of an array of texts

    !> What is made once an edition.
    type :: kit_t
        integer(hid_t) :: text = -1, scalar = -1            !! type, dataspace
        integer(hid_t) :: group = -1, array = -1, transfer = -1     !! property lists
    end type kit_t

    interface
        !> Keep HDF5 from tidying up at the end of the program. Whatever went well has been closed by then.
        function h5_dont_atexit() bind(c, name="H5dont_atexit") result(info)
            import :: c_int
            integer(c_int) :: info
        end function h5_dont_atexit

        function c_setenv(name, value, overwrite) bind(c, name="setenv") result(failed)
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: name(*), value(*)
            integer(c_int), value, intent(in) :: overwrite
            integer(c_int) :: failed
        end function c_setenv

        !> How many bytes HDF5 keeps for itself of what it has freed; -1: all. (Lists of all kinds together
        !> and one by one, for objects, arrays and blocks.)
        function h5_set_free_list_limits(objects, object_list, arrays, array_list, blocks, block_list) &
            bind(c, name="H5set_free_list_limits") result(info)
            import :: c_int
            integer(c_int), value, intent(in) :: objects, object_list, arrays, array_list, blocks, block_list
            integer(c_int) :: info
        end function h5_set_free_list_limits
    end interface

contains

    !> Start the library, quietly: its own error stack is not for users. More than once does no harm.
    subroutine start_hdf5()
        integer :: info

        info = int(h5_dont_atexit())
        ! Some network file systems know no locks, and HDF5 would not open files there.
        info = int(c_setenv('HDF5_USE_FILE_LOCKING' // c_null_char, 'FALSE' // c_null_char, 0_c_int))
        call h5open_f(info)
        call h5eset_auto_f(0, info)
        ! Every edition needs half a megabyte for its cache: new memory each time costs more than the edition.
        info = int(h5_set_free_list_limits(-1_c_int, -1_c_int, -1_c_int, -1_c_int, -1_c_int, -1_c_int))
    end subroutine start_hdf5

    !> Write the whole tree into the empty HDF5 file and close that.
    subroutine write_tree(file, tree, store, error)
        integer(hid_t), intent(in) :: file
        type(tree_t), intent(in) :: tree
        type(store_t), intent(inout) :: store
        type(error_t), allocatable, intent(out) :: error
        type(kit_t) :: kit
        integer(hid_t), allocatable :: objects(:)
        integer(i8) :: of_texts
        logical :: has_texts
        integer :: info, i

        allocate (objects(tree%n))
        objects(root) = file
        call make_kit(kit, info)
        call write_attributes(file, tree%nodes(root), kit, info)
        of_texts = 0
        call add_texts(tree%nodes(root), of_texts, has_texts)
        do i = root + 1, tree%n
            if (is_units(tree%nodes(i))) call add_texts(tree%nodes(i), of_texts, has_texts)
        end do
        if (info >= 0) call write_checksum(file, 'text_checksum', of_texts, kit, info)
        if (info >= 0) call link_kept(file, tree%nodes(root), info)
        call write_nodes(tree, root + 1, store, kit, objects, info, error)
        call drop_kit(kit)
        call close_edition(file, store, info, error)
    end subroutine write_tree

    !> Write the nodes from number `first` on, all of them below `group`, into an empty HDF5 file whose root
    !> stands for the group, and close that. The addresses are of those that are members of the group itself.
    subroutine write_kept_nodes(file, tree, group, first, store, addresses, error)
        integer(hid_t), intent(in) :: file
        type(tree_t), intent(in) :: tree
        integer, intent(in) :: group, first
        type(store_t), intent(inout) :: store
        integer(i8), intent(out) :: addresses(first:)   !! (first:tree%n)
        type(error_t), allocatable, intent(out) :: error
        type(kit_t) :: kit
        integer(hid_t), allocatable :: objects(:)
        integer :: info, i

        allocate (objects(tree%n))
        objects(group) = file
        call make_kit(kit, info)
        call write_nodes(tree, first, store, kit, objects, info, error)
        addresses = -1
        do i = first, tree%n
            if (info < 0 .or. tree%nodes(i)%parent /= group) cycle
            addresses(i) = object_address(objects(i))
            if (addresses(i) < 0) info = -1
        end do
        call drop_kit(kit)
        call close_edition(file, store, info, error)
    end subroutine write_kept_nodes

    !> Copy objects of another file, with all that is below them, into the empty HDF5 file, and close that.
    subroutine copy_kept_objects(file, sources, names, store, addresses, error)
        integer(hid_t), intent(in) :: file
        integer(hid_t), intent(in) :: sources(:)        !! the group that each is in
        character(*), intent(in) :: names(:)            !! padded with blanks
        type(store_t), intent(inout) :: store
        integer(i8), intent(out) :: addresses(:)
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: copy
        integer :: info, ignored, i

        addresses = -1
        info = 0
        do i = 1, size(names)
            if (info >= 0) call h5ocopy_f(sources(i), trim(names(i)), file, trim(names(i)), info)
            if (info >= 0) call h5oopen_f(file, trim(names(i)), copy, info)
            if (info < 0) exit
            addresses(i) = object_address(copy)
            if (addresses(i) < 0) info = -1
            call h5oclose_f(copy, ignored)
        end do
        call close_edition(file, store, info, error)
    end subroutine copy_kept_objects

    !> The nodes from number `first` on; `objects` knows those above them.
    subroutine write_nodes(tree, first, store, kit, objects, info, error)
        type(tree_t), intent(in) :: tree
        integer, intent(in) :: first
        type(store_t), intent(inout) :: store
        type(kit_t), intent(in) :: kit
        integer(hid_t), intent(inout) :: objects(:)
        integer, intent(inout) :: info
        type(error_t), allocatable, intent(inout) :: error
        integer :: i

        do i = first, tree%n
            if (info < 0) exit
            select case (tree%nodes(i)%kind)
            case (node_group)
                call h5gcreate_f(objects(tree%nodes(i)%parent), tree%nodes(i)%name, objects(i), info, &
                                 gcpl_id=kit%group)
                if (info >= 0) call link_kept(objects(i), tree%nodes(i), info)
            case (node_array)
                call write_array(objects(tree%nodes(i)%parent), tree, i, store, kit, objects(i), info)
            case (node_text)
                call write_text(objects(tree%nodes(i)%parent), tree%nodes(i), kit, objects(i), info)
            case (node_texts)
                call write_texts(objects(tree%nodes(i)%parent), tree%nodes(i), kit, objects(i), info)
            case default
                associate (target => tree%nodes(tree%nodes(i)%target))
                    call h5lcreate_hard_f(objects(target%parent), target%name, &
                        objects(tree%nodes(i)%parent), tree%nodes(i)%name, info)
                end associate
            end select
            if (info >= 0) call write_attributes(objects(i), tree%nodes(i), kit, info)
            if (info >= 0) call write_checksums(objects(i), tree%nodes(i), kit, info)
            if (info < 0) call raise(error, status_file, 'cannot write the results file ' &
                // store%path // ': HDF5 cannot describe ' // tree%nodes(i)%name)
        end do
    end subroutine write_nodes

    subroutine link_kept(group, node, info)
        integer(hid_t), intent(in) :: group
        type(node_t), intent(in) :: node
        integer, intent(out) :: info
        integer :: i

        info = 0
        do i = 1, node%n_kept
            if (.not. link_object(group, node%kept(i)%text, node%kept(i)%number)) info = -1
        end do
    end subroutine link_kept

    subroutine close_edition(file, store, info, error)
        integer(hid_t), intent(in) :: file
        type(store_t), intent(in) :: store
        integer, intent(inout) :: info
        type(error_t), allocatable, intent(inout) :: error
        integer :: closed

        ! Closing the file closes what is open in it.
        call h5fclose_f(file, closed)
        if (min(info, closed) < 0 .and. .not. allocated(error)) call raise(error, status_file, &
            'cannot write the results file ' // store%path // ': HDF5 cannot complete what describes it')
    end subroutine close_edition

    subroutine make_kit(kit, info)
        type(kit_t), intent(out) :: kit
        integer, intent(out) :: info

        ! The Fortran interface's H5T_STRING is a text of any length.
        call h5tcopy_f(h5t_string, kit%text, info)
        if (info >= 0) call h5tset_cset_f(kit%text, h5t_cset_utf8_f, info)
        if (info >= 0) call h5screate_f(h5s_scalar_f, kit%scalar, info)
        if (info >= 0) call h5pcreate_f(h5p_dataset_xfer_f, kit%transfer, info)
        if (info >= 0) call h5pset_buffer_f(kit%transfer, conversion_bytes, info)
        ! Probes come back in the order in which the deck has them.
        if (info >= 0) call h5pcreate_f(h5p_group_create_f, kit%group, info)
        if (info >= 0) call h5pset_link_creation_order_f(kit%group, &
            ior(h5p_crt_order_tracked_f, h5p_crt_order_indexed_f), info)
        if (info >= 0) call h5pset_link_phase_change_f(kit%group, most_in_header, most_in_header/2, info)
        if (info >= 0) call h5pset_attr_phase_change_f(kit%group, most_in_header, most_in_header/2, info)
        if (info >= 0) call make_array_properties(kit%array, info)
    end subroutine make_kit

    !> All room at once, and nothing written into it.
    subroutine make_array_properties(properties, info)
        integer(hid_t), intent(out) :: properties
        integer, intent(out) :: info

        call h5pcreate_f(h5p_dataset_create_f, properties, info)
        if (info >= 0) call h5pset_alloc_time_f(properties, h5d_alloc_time_early_f, info)
        if (info >= 0) call h5pset_fill_time_f(properties, h5d_fill_time_never_f, info)
        if (info >= 0) call h5pset_obj_track_times_f(properties, .false., info)
    end subroutine make_array_properties

    subroutine drop_kit(kit)
        type(kit_t), intent(in) :: kit
        integer :: ignored

        call h5tclose_f(kit%text, ignored)
        call h5sclose_f(kit%scalar, ignored)
        call h5pclose_f(kit%group, ignored)
        call h5pclose_f(kit%array, ignored)
        call h5pclose_f(kit%transfer, ignored)
    end subroutine drop_kit

    !> The dataset of an array whose numbers lie in one piece, or in chunks.
    subroutine write_array(parent, tree, number, store, kit, dataset, info)
        integer(hid_t), intent(in) :: parent
        type(tree_t), intent(in) :: tree
        integer, intent(in) :: number
        type(store_t), intent(inout) :: store
        type(kit_t), intent(in) :: kit
        integer(hid_t), intent(out) :: dataset
        integer, intent(out) :: info
        integer(hid_t) :: space, properties
        integer :: ignored, pieces

        associate (node => tree%nodes(number))
            pieces = node%n_pieces
            if (pieces > 1) pieces = int((node%rows + node%piece_rows - 1)/node%piece_rows)
            call h5screate_simple_f(size(node%row_shape) + 1, [int(node%row_shape, hsize_t), &
                int(node%rows*node%records, hsize_t)], space, info)
            properties = kit%array
            if (pieces > 1) then
                call make_array_properties(properties, info)
                call h5pset_chunk_f(properties, size(node%row_shape) + 1, [int(node%row_shape, hsize_t), &
                    int(node%piece_rows*node%records, hsize_t)], info)
                call store%offer(node%pieces(:pieces), node%piece_rows*tree%row_bytes(number))
            else if (node%rows > 0) then
                call store%offer(node%pieces(:1), node%rows*tree%row_bytes(number))
            end if
            if (info >= 0) call h5dcreate_f(parent, node%name, file_type(node%stored), space, dataset, info, &
                properties)
            if (store%offers_left()) info = -1
            if (pieces > 1) call h5pclose_f(properties, ignored)
            call h5sclose_f(space, ignored)
        end associate
    end subroutine write_array

    !> Numbers are in the file as the machine has them.
    integer(hid_t) function file_type(stored)
        integer, intent(in) :: stored

        select case (stored)
        case (stored_real32)
            file_type = h5t_native_real
        case (stored_int32)
            file_type = h5t_native_integer
        case (stored_int64)
            file_type = h5kind_to_type(i8, h5_integer_kind)
        case (stored_int8)
            file_type = h5t_std_i8le
        case (stored_uint8)
            file_type = h5t_std_u8le
        case default
            file_type = h5t_native_double
        end select
    end function file_type

    !> A scalar text.
    subroutine write_text(parent, node, kit, dataset, info)
        integer(hid_t), intent(in) :: parent
        type(node_t), intent(in) :: node
        type(kit_t), intent(in) :: kit
        integer(hid_t), intent(out) :: dataset
        integer, intent(out) :: info
        character(kind=c_char, len=:), allocatable, target :: text
        type(c_ptr), target :: address

        text = node%text // c_null_char
        address = c_loc(text)
        call h5dcreate_f(parent, node%name, kit%text, kit%scalar, dataset, info)
        if (info >= 0) call h5dwrite_f(dataset, kit%text, c_loc(address), info, xfer_prp=kit%transfer)
    end subroutine write_text

    !> One text a row, most of them empty: only the chunks that have some are made.
    subroutine write_texts(parent, node, kit, dataset, info)
        integer(hid_t), intent(in) :: parent
        type(node_t), intent(in) :: node
        type(kit_t), intent(in) :: kit
        integer(hid_t), intent(out) :: dataset
        integer, intent(out) :: info
        integer(hid_t) :: space, properties
        integer :: ignored, first, last

        call h5screate_simple_f(1, [int(node%rows, hsize_t)], space, info)
        if (info >= 0) call h5pcreate_f(h5p_dataset_create_f, properties, info)
        if (info >= 0) call h5pset_obj_track_times_f(properties, .false., info)
        if (info >= 0 .and. node%rows > 0) call h5pset_chunk_f(properties, 1, [min(lines_a_chunk, &
            int(node%rows, hsize_t))], info)
        if (info >= 0) call h5dcreate_f(parent, node%name, kit%text, space, dataset, info, properties)
        call h5pclose_f(properties, ignored)
        first = 1
        do while (first <= node%n_lines .and. info >= 0)
            last = first
            do while (last < node%n_lines)
                if (chunk_of(node%lines(last + 1)%number) /= chunk_of(node%lines(first)%number)) exit
                last = last + 1
            end do
            call write_lines(dataset, space, node, first, last, kit, info)
            first = last + 1
        end do
        call h5sclose_f(space, ignored)

    contains

        pure integer(hsize_t) function chunk_of(row)
            integer(i8), intent(in) :: row

            chunk_of = int(row - 1, hsize_t)/lines_a_chunk
        end function chunk_of

    end subroutine write_texts

    !> Lines first, ..., last of an array of texts, all of one chunk.
    subroutine write_lines(dataset, space, node, first, last, kit, info)
        integer(hid_t), intent(in) :: dataset, space
        type(node_t), intent(in) :: node
        integer, intent(in) :: first, last
        type(kit_t), intent(in) :: kit
        integer, intent(out) :: info
        character(kind=c_char, len=:), allocatable, target :: text
        type(c_ptr), target :: addresses(last - first + 1)
        integer(hsize_t) :: rows(1, last - first + 1)
        integer(hid_t) :: memory_space
        integer :: starts(last - first + 1), ignored, i

        text = ''
        do i = first, last
            starts(i - first + 1) = len(text) + 1
            text = text // node%lines(i)%text // c_null_char
            rows(1, i - first + 1) = int(node%lines(i)%number, hsize_t)
        end do
        addresses = [(c_loc(text(starts(i):starts(i))), i=1, size(starts))]
        call h5sselect_elements_f(space, h5s_select_set_f, 1, size(starts, kind=size_t), rows, info)
        if (info >= 0) call h5screate_simple_f(1, [size(starts, kind=hsize_t)], memory_space, info)
        if (info < 0) return
        call h5dwrite_f(dataset, kit%text, c_loc(addresses), info, memory_space, space, kit%transfer)
        call h5sclose_f(memory_space, ignored)
    end subroutine write_lines

    !> What tells damage that HDF5 itself does not: the CRC-32 of a dataset's bytes, and that of all
    !> attributes that are texts (they lie in a heap that HDF5 does not protect).
    subroutine write_checksums(object, node, kit, info)
        integer(hid_t), intent(in) :: object
        type(node_t), intent(in) :: node
        type(kit_t), intent(in) :: kit
        integer, intent(out) :: info
        integer(i8) :: of_texts
        logical :: has_texts

        info = 0
        if (node%kind == node_link .or. is_units(node)) return
        if (node%kind /= node_group) call write_checksum(object, 'checksum', node%checksum, kit, info)
        of_texts = 0
        call add_texts(node, of_texts, has_texts)
        if (has_texts .and. info >= 0) call write_checksum(object, 'text_checksum', of_texts, kit, info)
    end subroutine write_checksums

    !> Whether this is /units, whose only attributes are the units: the root's checksum goes on with them.
    pure logical function is_units(node)
        type(node_t), intent(in) :: node

        is_units = node%name == 'units' .and. node%kind == node_group .and. node%parent == root
    end function is_units

    !> Go on with the checksum of an object's attributes that are texts.
    subroutine add_texts(node, checksum, has_texts)
        type(node_t), intent(in) :: node
        integer(i8), intent(inout) :: checksum
        logical, intent(out) :: has_texts
        integer :: last, i

        last = 0
        do
            i = next_text(node, last)
            if (i == 0) exit
            call add_to_checksum(checksum, node%attributes(i)%text // newline)
            last = i
        end do
        has_texts = last > 0
    end subroutine add_texts

    !> The attribute that is a text, or a list of them, and follows another one by name (0: the first one); 0
    !> where there is none.
    pure integer function next_text(node, last) result(next)
        type(node_t), intent(in) :: node
        integer, intent(in) :: last
        integer :: i

        next = 0
        do i = 1, node%n_attributes
            if (all(node%attributes(i)%kind /= [attribute_text, attribute_list])) cycle
            if (last > 0) then
                if (.not. llt(node%attributes(last)%name, node%attributes(i)%name)) cycle
            end if
            if (next > 0) then
                if (llt(node%attributes(next)%name, node%attributes(i)%name)) cycle
            end if
            next = i
        end do
    end function next_text

    !> An attribute of 32 bits without a sign.
    subroutine write_checksum(object, name, checksum, kit, info)
        integer(hid_t), intent(in) :: object
        character(*), intent(in) :: name
        integer(i8), intent(in) :: checksum
        type(kit_t), intent(in) :: kit
        integer, intent(out) :: info
        integer(c_int32_t), target :: bits
        integer(hid_t) :: made
        integer :: ignored

        bits = int(ibits(checksum, 0, 31), c_int32_t)
        if (btest(checksum, 31)) bits = ibset(bits, 31)
        call h5acreate_f(object, name, h5t_std_u32le, kit%scalar, made, info)
        if (info >= 0) call h5awrite_f(made, h5t_std_u32le, c_loc(bits), info)
        if (info >= 0) call h5aclose_f(made, ignored)
    end subroutine write_checksum

    subroutine write_attributes(object, node, kit, info)
        integer(hid_t), intent(in) :: object
        type(node_t), intent(in) :: node
        type(kit_t), intent(in) :: kit
        integer, intent(inout) :: info
        integer :: i

        do i = 1, node%n_attributes
            if (info < 0) return
            call write_attribute(object, node%attributes(i), kit, info)
        end do
    end subroutine write_attributes

    subroutine write_attribute(object, attribute, kit, info)
        integer(hid_t), intent(in) :: object
        type(attribute_t), intent(in), target :: attribute
        type(kit_t), intent(in) :: kit
        integer, intent(out) :: info
        character(kind=c_char, len=:), allocatable, target :: text
        type(c_ptr), target :: address
        integer(hid_t) :: made, ascii
        integer :: ignored

        select case (attribute%kind)
        case (attribute_integer)
            call h5acreate_f(object, attribute%name, h5t_native_integer, kit%scalar, made, info)
            if (info >= 0) call h5awrite_f(made, h5t_native_integer, c_loc(attribute%integers), info)
        case (attribute_pair)
            call write_pair(object, attribute, made, info)
        case (attribute_list)
            call write_list(object, attribute, kit, made, info)
        case (attribute_real)
            call h5acreate_f(object, attribute%name, h5t_native_double, kit%scalar, made, info)
            if (info >= 0) call h5awrite_f(made, h5t_native_double, c_loc(attribute%number), info)
        case (attribute_ascii)
            text = attribute%text
            call h5tcopy_f(h5t_c_s1, ascii, info)
            call h5tset_size_f(ascii, int(len(text), c_size_t), info)
            call h5tset_strpad_f(ascii, h5t_str_nullpad_f, info)
            if (info >= 0) call h5acreate_f(object, attribute%name, ascii, kit%scalar, made, info)
            if (info >= 0) call h5awrite_f(made, ascii, c_loc(text), info)
            call h5tclose_f(ascii, ignored)
        case default
            text = attribute%text // c_null_char
            address = c_loc(text)
            call h5acreate_f(object, attribute%name, kit%text, kit%scalar, made, info)
            if (info >= 0) call h5awrite_f(made, kit%text, c_loc(address), info)
        end select
        if (info >= 0) call h5aclose_f(made, ignored)
    end subroutine write_attribute

    !> An attribute of as many texts as there are lines.
    subroutine write_list(object, attribute, kit, made, info)
        integer(hid_t), intent(in) :: object
        type(attribute_t), intent(in) :: attribute
        type(kit_t), intent(in) :: kit
        integer(hid_t), intent(out) :: made
        integer, intent(out) :: info
        character(kind=c_char, len=:), allocatable, target :: text
        type(c_ptr), allocatable, target :: addresses(:)
        integer(hid_t) :: space
        integer :: ignored, i, start

        text = attribute%text // newline
        allocate (addresses(0))
        start = 1
        do i = 1, len(text)
            if (text(i:i) /= newline) cycle
            text(i:i) = c_null_char
            addresses = [addresses, c_loc(text(start:start))]
            start = i + 1
        end do
        call h5screate_simple_f(1, [size(addresses, kind=hsize_t)], space, info)
        if (info >= 0) call h5acreate_f(object, attribute%name, kit%text, space, made, info)
        if (info >= 0) call h5awrite_f(made, kit%text, c_loc(addresses), info)
        if (info >= 0) call h5sclose_f(space, ignored)
    end subroutine write_list

    !> An attribute of two integers of 64 bits.
    subroutine write_pair(object, attribute, made, info)
        integer(hid_t), intent(in) :: object
        type(attribute_t), intent(in), target :: attribute
        integer(hid_t), intent(out) :: made
        integer, intent(out) :: info
        integer(hid_t) :: space
        integer :: ignored

        call h5screate_simple_f(1, [2_hsize_t], space, info)
        if (info >= 0) call h5acreate_f(object, attribute%name, h5t_std_i64le, space, made, info)
        if (info >= 0) call h5awrite_f(made, h5t_native_integer, c_loc(attribute%integers), info)
        if (info >= 0) call h5sclose_f(space, ignored)
    end subroutine write_pair

end module gb_hdf5
