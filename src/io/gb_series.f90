!> A series of a results file: rows that gather in memory and go to the file in pieces, where they are not
!> seen before its next edition.
module gb_series
    use, intrinsic :: iso_c_binding, only: c_float, c_int8_t, c_int32_t, c_int64_t, c_loc, c_ptr
    use gb_kinds, only: wp, i8
    use gb_checksum, only: add_to_checksum
    use gb_error, only: error_t
    use gb_store, only: store_t
    use gb_tree, only: tree_t, stored_real32, stored_int32, stored_int64, stored_int8, stored_bytes
    implicit none
    private

    type, public :: series_t
        integer :: node = 0                         !! of the tree
        integer :: piece_rows = 1                   !! rows that the buffer holds
        integer(i8) :: rows = 0                     !! all that were added
        integer(i8) :: settled = 0                  !! of them, those that are in the file
        real(wp), allocatable :: buffer(:, :)       !! (numbers of a row, piece_rows)
    contains
        procedure :: begin
        procedure :: move_to
        procedure :: add
        procedure :: settle
    end type series_t

    !> Numbers and rows of a piece: bounds of what waits in memory.
    integer, parameter :: piece_numbers = 32768, most_piece_rows = 2048

contains

    !> An empty series for an array without numbers.
    subroutine begin(self, tree, node)
        class(series_t), intent(inout) :: self
        type(tree_t), intent(inout) :: tree
        integer, intent(in) :: node
        integer :: numbers

        associate (array => tree%nodes(node))
            numbers = int(product(array%row_shape))*array%records
            self%node = node
            self%piece_rows = max(1, min(most_piece_rows, piece_numbers/numbers))
            self%rows = 0
            self%settled = 0
            ! The place may have been that of a series which is over.
            if (allocated(self%buffer)) deallocate (self%buffer)
            allocate (self%buffer(numbers, self%piece_rows))
            array%piece_rows = self%piece_rows
        end associate
    end subroutine begin

    !> Hand a series over without copying what it holds.
    subroutine move_to(self, other)
        class(series_t), intent(inout) :: self
        type(series_t), intent(inout) :: other

        other%node = self%node
        other%piece_rows = self%piece_rows
        other%rows = self%rows
        other%settled = self%settled
        call move_alloc(self%buffer, other%buffer)
    end subroutine move_to

    !> Another row.
    subroutine add(self, row, tree, store, error)
        class(series_t), intent(inout) :: self
        real(wp), intent(in) :: row(:)
        type(tree_t), intent(inout) :: tree
        type(store_t), intent(inout) :: store
        type(error_t), allocatable, intent(out) :: error
        integer :: place

        place = int(modulo(self%rows, int(self%piece_rows, i8))) + 1
        self%buffer(:, place) = row
        self%rows = self%rows + 1
        if (place == self%piece_rows) call self%settle(tree, store, .true., error)
    end subroutine add

    !> Write the waiting rows into the file, where they are not seen yet. A series that still grows gets room
    !> for a whole piece.
    subroutine settle(self, tree, store, grows, error)
        class(series_t), intent(inout) :: self
        type(tree_t), intent(inout) :: tree
        type(store_t), intent(inout) :: store
        logical, intent(in) :: grows
        type(error_t), allocatable, intent(out) :: error
        integer(i8) :: row_bytes, room, within
        integer :: first, last

        if (self%settled == self%rows) return
        associate (array => tree%nodes(self%node))
            row_bytes = tree%row_bytes(self%node)
            if (array%n_pieces*int(self%piece_rows, i8) == self%settled) then
                room = self%piece_rows
                if (array%n_pieces == 0 .and. .not. grows) room = self%rows
                call tree%add_piece(self%node, store%allocate(room*row_bytes))
            end if
            within = self%settled - (array%n_pieces - 1)*int(self%piece_rows, i8)
            first = int(within) + 1
            last = int(within + self%rows - self%settled)
            call write_rows(store, array%pieces(array%n_pieces) + within*row_bytes, array%stored, &
                self%buffer(:, first:last), array%checksum, error)
        end associate
        if (.not. allocated(error)) self%settled = self%rows
    end subroutine settle

    subroutine write_rows(store, address, stored, rows, checksum, error)
        type(store_t), intent(inout) :: store
        integer(i8), intent(in) :: address
        integer, intent(in) :: stored
        real(wp), intent(in), target, contiguous :: rows(:, :)
        integer(i8), intent(inout) :: checksum          !! of all rows before, and then of these too
        type(error_t), allocatable, intent(out) :: error
        integer(c_int8_t), allocatable, target :: bytes(:, :)
        integer(c_int32_t), allocatable, target :: words(:, :)
        integer(c_int64_t), allocatable, target :: wide(:, :)
        real(c_float), allocatable, target :: short(:, :)
        type(c_ptr) :: from
        integer(i8) :: count

        select case (stored)
        case (stored_real32)
            short = real(rows, c_float)
            from = c_loc(short)
        case (stored_int8)
            bytes = int(nint(rows), c_int8_t)
            from = c_loc(bytes)
        case (stored_int32)
            words = nint(rows, c_int32_t)
            from = c_loc(words)
        case (stored_int64)
            wide = nint(rows, c_int64_t)
            from = c_loc(wide)
        case default
            from = c_loc(rows)
        end select
        count = stored_bytes(stored)*size(rows, kind=i8)
        call store%write(address, from, count, error)
        call add_to_checksum(checksum, from, count)
    end subroutine write_rows

end module gb_series
