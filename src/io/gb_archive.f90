!> A results file while it is being written: groups, attributes, whole arrays, and series that grow row by
!> row. What is put in gathers in memory; `publish` makes all of it visible at once, so that who reads the
!> file, also after a kill, finds what was there at one such moment and nothing in between.
module gb_archive
    use, intrinsic :: iso_c_binding, only: c_int8_t, c_int32_t, c_int64_t, c_loc, c_ptr
    use gb_kinds, only: wp, i8
    use gb_checksum, only: add_to_checksum
    use gb_error, only: error_t, raise, status_file
    use gb_series, only: series_t
    use gb_store, only: store_t, commit_again
    use gb_text, only: newline
    use gb_tree, only: tree_t, attribute_t, root, node_group, node_array, node_text, node_texts, node_link, &
        attribute_text, attribute_ascii, attribute_integer, attribute_real, attribute_pair, attribute_list, &
        stored_real64, stored_real32, stored_int32, stored_int64, stored_int8, stored_uint8
    use gb_hdf5, only: start_hdf5, write_tree, write_kept_nodes, copy_kept_objects
    use gb_hdf5_input, only: hid_t, get_rows, count_rows
    implicit none
    private

    public :: root, stored_real64, stored_real32, stored_int32, stored_int64, stored_int8, stored_uint8

    type, public :: archive_t
        private
        type(tree_t) :: tree
        type(tree_t) :: published                   !! the tree of the valid edition
        type(store_t) :: store
        integer :: n_series = 0
        type(series_t), allocatable :: series(:)    !! those that still grow
        real(wp) :: opened_at = 0.0_wp              !! by the wall clock [s]
        real(wp) :: published_at = 0.0_wp           !! the last time
        real(wp) :: publish_seconds = 0.0_wp        !! how long that took
    contains
        procedure :: open => open_archive
        procedure :: is_open
        procedure :: is_published
        procedure :: is_due
        procedure :: age
        procedure :: add_group
        procedure :: put_text
        procedure :: add_link
        procedure :: add_series
        procedure :: append
        procedure :: add_texts
        procedure :: append_text
        procedure :: row_counts
        procedure :: replay
        procedure :: finish
        procedure :: keep
        procedure :: keep_copies
        procedure :: publish
        procedure :: give_up
        procedure :: close => close_archive
        procedure, private :: set_text, set_integer, set_real, set_pair
        procedure :: set_ascii
        procedure :: set_list
        !> Give a node an attribute, or the attribute another value.
        generic :: set => set_text, set_integer, set_real, set_pair
        procedure, private :: put_reals, put_real_table, put_real_blocks, put_integers, put_integer_table
        !> A whole array with its unit and description, stored as `stored_...` says.
        generic :: put => put_reals, put_real_table, put_real_blocks, put_integers, put_integer_table
        procedure, private :: put_bytes
        procedure, private :: add_array
    end type archive_t

    !> Wall seconds between two moments at which all that is there is made visible: within a command or a
    !> study, and (also before the first of them) between commands. Where that takes long, it is done less
    !> often, to take this part of the time at most.
    real(wp), parameter, public :: step_seconds = 2.0_wp, command_seconds = 0.1_wp
    real(wp), parameter :: largest_part = 0.05_wp
    integer, parameter :: all_rows = -1

contains

    !> Open the file that is to become `path`, in place of what is there. Nothing is seen of it before the
    !> first `publish`.
    subroutine open_archive(self, path, error)
        class(archive_t), intent(inout) :: self
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error
        integer :: node

        call self%store%open(path, error)
        if (allocated(error)) return
        call start_hdf5()
        allocate (self%series(0))
        call self%tree%add_node(0, '/', node_group, node)
        self%opened_at = wall_clock()
        self%published_at = self%opened_at
    end subroutine open_archive

    !> Seconds of some clock that goes on evenly.
    real(wp) function wall_clock()
        integer(i8) :: count, rate

        call system_clock(count, rate)
        wall_clock = real(count, wp)/real(rate, wp)
    end function wall_clock

    logical function is_open(self)
        class(archive_t), intent(in) :: self

        is_open = self%store%is_open()
    end function is_open

    !> Whether something is visible.
    pure logical function is_published(self)
        class(archive_t), intent(in) :: self

        is_published = self%published%n > 0
    end function is_published

    !> Whether it is time to publish, if that is to be done every so many seconds; the first time comes soon.
    logical function is_due(self, seconds)
        class(archive_t), intent(in) :: self
        real(wp), intent(in) :: seconds
        real(wp) :: pause

        pause = max(seconds, self%publish_seconds/largest_part)
        if (.not. self%is_published()) pause = command_seconds
        is_due = wall_clock() - self%published_at >= pause
    end function is_due

    !> Wall seconds since the file was opened.
    real(wp) function age(self)
        class(archive_t), intent(in) :: self

        age = wall_clock() - self%opened_at
    end function age

    subroutine add_group(self, parent, name, group)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent
        character(*), intent(in) :: name
        integer, intent(out) :: group

        call self%tree%add_node(parent, name, node_group, group)
    end subroutine add_group

    !> Another name for a node.
    subroutine add_link(self, parent, name, target)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent, target
        character(*), intent(in) :: name
        integer :: node

        call self%tree%add_node(parent, name, node_link, node)
        self%tree%nodes(node)%target = target
    end subroutine add_link

    subroutine set_text(self, node, name, text)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: name, text

        call self%tree%set_attribute(node, attribute_t(name, attribute_text, text=text))
    end subroutine set_text

    !> A text of fixed length in ASCII.
    subroutine set_ascii(self, node, name, text)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: name, text

        call self%tree%set_attribute(node, attribute_t(name, attribute_ascii, text=text))
    end subroutine set_ascii

    !> A list of texts, none of which has a line's end in it.
    subroutine set_list(self, node, name, texts)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: name
        character(*), intent(in) :: texts(:)            !! padded with blanks; at least one
        character(:), allocatable :: text
        integer :: i

        text = trim(texts(1))
        do i = 2, size(texts)
            text = text // newline // trim(texts(i))
        end do
        call self%tree%set_attribute(node, attribute_t(name, attribute_list, text=text))
    end subroutine set_list

    subroutine set_integer(self, node, name, number)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: name
        integer, intent(in) :: number

        call self%tree%set_attribute(node, attribute_t(name, attribute_integer, integers=[number, 0]))
    end subroutine set_integer

    subroutine set_real(self, node, name, number)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: name
        real(wp), intent(in) :: number

        call self%tree%set_attribute(node, attribute_t(name, attribute_real, number=number))
    end subroutine set_real

    subroutine set_pair(self, node, name, pair)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: name
        integer, intent(in) :: pair(2)

        call self%tree%set_attribute(node, attribute_t(name, attribute_pair, integers=pair))
    end subroutine set_pair

    !> A scalar text.
    subroutine put_text(self, parent, name, text, unit, description, node)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent
        character(*), intent(in) :: name, text, unit, description
        integer, intent(out) :: node

        call self%tree%add_node(parent, name, node_text, node)
        self%tree%nodes(node)%text = text
        call add_to_checksum(self%tree%nodes(node)%checksum, text)
        call self%set(node, 'unit', unit)
        call self%set(node, 'description', description)
    end subroutine put_text

    !> A new array without numbers.
    subroutine add_array(self, parent, name, row_shape, stored, unit, description, node)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent, stored
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: row_shape(:)
        integer, intent(out) :: node

        call self%tree%add_node(parent, name, node_array, node)
        self%tree%nodes(node)%row_shape = int(row_shape, i8)
        self%tree%nodes(node)%stored = stored
        call self%set(node, 'unit', unit)
        call self%set(node, 'description', description)
    end subroutine add_array

    subroutine put_reals(self, parent, name, values, unit, description, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        real(wp), intent(in), target, contiguous :: values(:)
        type(error_t), allocatable, intent(out) :: error

        call self%put_bytes(parent, name, shape(values), stored_real64, c_loc(values), unit, description, &
            error)
    end subroutine put_reals

    subroutine put_real_table(self, parent, name, values, unit, description, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        real(wp), intent(in), target, contiguous :: values(:, :)
        type(error_t), allocatable, intent(out) :: error

        call self%put_bytes(parent, name, shape(values), stored_real64, c_loc(values), unit, description, &
            error)
    end subroutine put_real_table

    subroutine put_real_blocks(self, parent, name, values, unit, description, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent
        character(*), intent(in) :: name, unit, description
        real(wp), intent(in), target, contiguous :: values(:, :, :)
        type(error_t), allocatable, intent(out) :: error

        call self%put_bytes(parent, name, shape(values), stored_real64, c_loc(values), unit, description, &
            error)
    end subroutine put_real_blocks

    subroutine put_integers(self, parent, name, values, stored, unit, description, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent, stored
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: values(:)
        type(error_t), allocatable, intent(out) :: error

        call put_shaped(self, parent, name, values, shape(values), stored, unit, description, error)
    end subroutine put_integers

    subroutine put_integer_table(self, parent, name, values, stored, unit, description, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent, stored
        character(*), intent(in) :: name, unit, description
        integer, intent(in), contiguous :: values(:, :)
        type(error_t), allocatable, intent(out) :: error

        call put_shaped(self, parent, name, values, shape(values), stored, unit, description, error)
    end subroutine put_integer_table

    subroutine put_shaped(self, parent, name, values, extent, stored, unit, description, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent, stored
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: extent(:)
        integer, intent(in) :: values(product(extent))
        type(error_t), allocatable, intent(out) :: error
        integer(c_int8_t), allocatable, target :: bytes(:)
        integer(c_int32_t), allocatable, target :: words(:)
        integer(c_int64_t), allocatable, target :: wide(:)
        type(c_ptr) :: from

        select case (stored)
        case (stored_int8, stored_uint8)
            bytes = int(values, c_int8_t)
            from = c_loc(bytes)
        case (stored_int64)
            wide = int(values, c_int64_t)
            from = c_loc(wide)
        case default
            words = int(values, c_int32_t)
            from = c_loc(words)
        end select
        call self%put_bytes(parent, name, extent, stored, from, unit, description, error)
    end subroutine put_shaped

    subroutine put_bytes(self, parent, name, extent, stored, from, unit, description, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent, stored
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: extent(:)
        type(c_ptr), intent(in) :: from
        type(error_t), allocatable, intent(out) :: error
        integer :: node, rank
        integer(i8) :: bytes, address

        rank = size(extent)
        call self%add_array(parent, name, extent(:rank - 1), stored, unit, description, node)
        bytes = extent(rank)*self%tree%row_bytes(node)
        if (bytes == 0) return
        address = self%store%allocate(bytes)
        call self%store%write(address, from, bytes, error)
        call self%tree%add_piece(node, address)
        call add_to_checksum(self%tree%nodes(node)%checksum, from, bytes)
        self%tree%nodes(node)%rows = extent(rank)
        self%tree%nodes(node)%piece_rows = extent(rank)
    end subroutine put_bytes

    !> An empty series, to be known by the number of its node.
    subroutine add_series(self, parent, name, row_shape, stored, unit, description, node, records)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent, stored
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: row_shape(:)             !! empty for scalars
        integer, intent(out) :: node
        !> A row is so many records of that shape, one behind the other in the dimension that grows.
        integer, intent(in), optional :: records
        type(series_t), allocatable :: grown(:)
        integer :: i

        call self%add_array(parent, name, row_shape, stored, unit, description, node)
        if (self%n_series == size(self%series)) then
            allocate (grown(2*self%n_series + 16))
            do i = 1, self%n_series
                call self%series(i)%move_to(grown(i))
            end do
            call move_alloc(grown, self%series)
        end if
        self%n_series = self%n_series + 1
        if (present(records)) self%tree%nodes(node)%records = records
        call self%series(self%n_series)%begin(self%tree, node)
    end subroutine add_series

    !> Another row of a series.
    subroutine append(self, node, row, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        real(wp), intent(in) :: row(:)
        type(error_t), allocatable, intent(out) :: error

        call self%series(place_of(self, node))%add(row, self%tree, self%store, error)
    end subroutine append

    !> An empty array of texts that is to get a text a row, most of them empty.
    subroutine add_texts(self, parent, name, description, node)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: parent
        character(*), intent(in) :: name, description
        integer, intent(out) :: node

        call self%tree%add_node(parent, name, node_texts, node)
        call self%set(node, 'unit', '')
        call self%set(node, 'description', description)
    end subroutine add_texts

    !> Another row of an array of texts.
    subroutine append_text(self, node, text)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: text

        call self%tree%add_line(node, text)
        call add_to_checksum(self%tree%nodes(node)%checksum, text // newline)
    end subroutine append_text

    !> Rows of each series that still grows.
    pure function row_counts(self) result(counts)
        class(archive_t), intent(in) :: self
        integer :: counts(self%n_series)

        counts = int(self%series(:self%n_series)%rows)
    end function row_counts

    !> Take the rows of every series that still grows (of those in `group`, where that is given) over from an
    !> older file, as many as `counts` says, or all of them.
    subroutine replay(self, file, error, counts, group)
        class(archive_t), intent(inout) :: self
        integer(hid_t), intent(in) :: file
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: counts(:)      !! (n_series)
        integer, intent(in), optional :: group
        integer :: i, wanted

        do i = 1, self%n_series
            if (present(group)) then
                if (.not. self%tree%holds(group, self%series(i)%node)) cycle
            end if
            wanted = all_rows
            if (present(counts)) wanted = counts(i)
            call replay_series(self, i, file, wanted, error)
            if (allocated(error)) return
        end do
    end subroutine replay

    subroutine replay_series(self, place, file, wanted, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: place
        integer(hid_t), intent(in) :: file
        integer, intent(in) :: wanted                   !! rows, or all_rows
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: path
        real(wp), allocatable :: records(:, :)
        integer(i8) :: row, last, rows
        integer :: k, node, a_row

        node = self%series(place)%node
        path = self%tree%path(node)
        a_row = self%tree%nodes(node)%records
        associate (row_shape => self%tree%nodes(node)%row_shape)
            last = count_rows(file, path, row_shape)
            if (last < 0) then
                call raise(error, status_file, 'could not read ' // path)
                return
            end if
            last = last/a_row
            if (wanted /= all_rows) last = wanted
            row = 0
            do while (row < last)
                rows = min(last - row, int(self%series(place)%piece_rows, i8))
                allocate (records(size(self%series(place)%buffer, 1)/a_row, rows*a_row))
                call get_rows(file, path, row_shape, row*a_row, records, error)
                if (allocated(error)) return
                do k = 1, int(rows)
                    call self%append(node, [records(:, (k - 1)*a_row + 1:k*a_row)], error)
                    if (allocated(error)) return
                end do
                row = row + rows
                deallocate (records)
            end do
        end associate
    end subroutine replay_series

    !> Index of a growing series; they stand in the order of their nodes.
    pure integer function place_of(self, node) result(low)
        class(archive_t), intent(in) :: self
        integer, intent(in) :: node
        integer :: high, middle

        low = 1
        high = self%n_series
        do while (low < high)
            middle = (low + high)/2
            if (self%series(middle)%node < node) then
                low = middle + 1
            else
                high = middle
            end if
        end do
    end function place_of

    !> The series below a group grow no more.
    subroutine finish(self, group, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: group
        type(error_t), allocatable, intent(out) :: error
        integer :: i, kept

        kept = 0
        do i = 1, self%n_series
            if (self%tree%holds(group, self%series(i)%node)) then
                call self%series(i)%settle(self%tree, self%store, .false., error)
                if (allocated(error)) return
                self%tree%nodes(self%series(i)%node)%rows = self%series(i)%rows
            else
                kept = kept + 1
                if (kept < i) call self%series(i)%move_to(self%series(kept))
            end if
        end do
        self%n_series = kept
    end subroutine finish

    !> What was put into the group since it was made, or since the last time, stays as it is: it is written
    !> into the file with all that describes it, and takes next to no memory from now on. Nothing else has
    !> been added since; it has no series.
    subroutine keep(self, group, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: group
        type(error_t), allocatable, intent(out) :: error
        integer(c_int64_t) :: file
        integer(i8), allocatable :: addresses(:)
        integer :: first, i

        first = self%tree%n + 1
        do while (first > group + 1)
            if (.not. self%tree%holds(group, first - 1)) exit
            first = first - 1
        end do
        if (first > self%tree%n) return
        call self%store%begin(.true., file, error)
        if (allocated(error)) return
        allocate (addresses(first:self%tree%n))
        call write_kept_nodes(file, self%tree, group, first, self%store, addresses, error)
        if (.not. allocated(error)) call self%store%keep(error)
        if (allocated(error)) return
        do i = first, self%tree%n
            if (self%tree%nodes(i)%parent == group) call self%tree%add_kept(group, self%tree%nodes(i)%name, &
                addresses(i))
        end do
        call self%tree%drop_nodes(first)
    end subroutine keep

    !> Copy objects of other files into a group, each with all that is below it.
    subroutine keep_copies(self, group, sources, names, error)
        class(archive_t), intent(inout) :: self
        integer, intent(in) :: group
        integer(hid_t), intent(in) :: sources(:)        !! the group of the other file that each is in
        character(*), intent(in) :: names(:)            !! padded with blanks
        type(error_t), allocatable, intent(out) :: error
        integer(c_int64_t) :: file
        integer(i8) :: addresses(size(names))
        integer :: i

        call self%store%begin(.true., file, error)
        if (.not. allocated(error)) call copy_kept_objects(file, sources, names, self%store, addresses, error)
        if (.not. allocated(error)) call self%store%keep(error)
        if (allocated(error)) return
        do i = 1, size(names)
            call self%tree%add_kept(group, trim(names(i)), addresses(i))
        end do
    end subroutine keep_copies

    !> Make all that was put in visible at once. `is_last` says that nothing follows; `durable` lets it
    !> reach the disk first, so that it survives the machine too.
    subroutine publish(self, is_last, durable, error)
        class(archive_t), intent(inout) :: self
        logical, intent(in) :: is_last, durable
        type(error_t), allocatable, intent(out) :: error
        integer(c_int64_t) :: file
        real(wp) :: start
        integer :: i, answer

        start = wall_clock()
        do i = 1, self%n_series
            call self%series(i)%settle(self%tree, self%store, .not. is_last, error)
            if (allocated(error)) return
            self%tree%nodes(self%series(i)%node)%rows = self%series(i)%rows
        end do
        do
            call self%store%begin(.false., file, error)
            if (.not. allocated(error)) call write_tree(file, self%tree, self%store, error)
            if (.not. allocated(error)) call self%store%commit(.not. is_last, durable, answer, error)
            if (allocated(error)) return
            if (answer /= commit_again) exit
        end do
        if (.not. is_last) self%published = self%tree
        self%published_at = wall_clock()
        self%publish_seconds = self%published_at - start
    end subroutine publish

    !> The file takes no more: leave what was visible, say in it that the run has failed, and why, if that can
    !> be done, and close. Where nothing was, there shall be no file.
    subroutine give_up(self, message)
        class(archive_t), intent(inout) :: self
        character(*), intent(in) :: message
        type(error_t), allocatable :: ignored

        if (self%is_published()) then
            self%tree = self%published
            self%n_series = 0
            call self%set(root, 'status', 'failed')
            call self%set(root, 'message', message)
            call self%publish(.true., .false., ignored)
        end if
        call self%close(ignored)
    end subroutine give_up

    !> Close the file; what is not published is lost.
    subroutine close_archive(self, error)
        class(archive_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        call self%store%close(error)
    end subroutine close_archive

end module gb_archive
