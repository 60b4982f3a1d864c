!> What a results file holds, as a tree in memory: groups, attributes, and where in the file each dataset's
!> numbers lie. It is small, whatever the number of rows, and knows nothing of HDF5.
module gb_tree
    use gb_kinds, only: wp, i8
    implicit none
    private

    !> How numbers are stored.
    integer, parameter, public :: stored_real64 = 1, stored_real32 = 2, stored_int32 = 3, stored_int64 = 4, &
        stored_int8 = 5, stored_uint8 = 6
    !> Bytes of a number of each kind.
    integer, parameter, public :: stored_bytes(6) = [8, 4, 4, 8, 1, 1]

    !> Kinds of attributes: texts are UTF-8 of any length, or ASCII of fixed length; a list has one text a
    !> line.
    integer, parameter, public :: attribute_text = 1, attribute_ascii = 2, attribute_integer = 3, &
        attribute_real = 4, attribute_pair = 5, attribute_list = 6

    type, public :: attribute_t
        character(:), allocatable :: name
        integer :: kind = attribute_text
        character(:), allocatable :: text
        integer :: integers(2) = 0
        real(wp) :: number = 0.0_wp
    end type attribute_t

    !> Kinds of nodes. A link is another name for the node `target`.
    integer, parameter, public :: node_group = 1, node_array = 2, node_text = 3, node_link = 4, &
        node_texts = 5

    !> A text with a number: a row of an array of texts that is not empty (from 1), or the name of an object
    !> that lies in the file already, with all that is below it, and its address.
    type, public :: entry_t
        integer(i8) :: number = 0
        character(:), allocatable :: text
    end type entry_t

    type, public :: node_t
        character(:), allocatable :: name
        integer :: kind = node_group
        integer :: parent = 0                       !! index of the group that holds it; 0 for the root
        integer :: n_attributes = 0
        type(attribute_t), allocatable :: attributes(:)
        integer :: target = 0
        character(:), allocatable :: text
        integer :: stored = stored_real64
        integer(i8), allocatable :: row_shape(:)    !! of a record, as Fortran orders it
        integer :: records = 1                      !! places of the last dimension that a row takes
        integer(i8) :: rows = 0
        integer(i8) :: piece_rows = 1               !! rows of a piece, where there is more than one
        integer :: n_pieces = 0
        integer(i8), allocatable :: pieces(:)       !! addresses of the pieces in the file
        integer(i8) :: checksum = 0                 !! CRC-32 of the numbers in the file
        integer :: n_lines = 0
        type(entry_t), allocatable :: lines(:)      !! of an array of texts
        integer :: n_kept = 0
        type(entry_t), allocatable :: kept(:)       !! members of a group besides the nodes
    end type node_t

    !> Nodes in the order of their making; a parent stands before its members.
    type, public :: tree_t
        integer :: n = 0
        type(node_t), allocatable :: nodes(:)
    contains
        procedure :: add_node
        procedure :: drop_nodes
        procedure :: add_piece
        procedure :: add_line
        procedure :: add_kept
        procedure :: set_attribute
        procedure :: row_bytes
        procedure :: path
        procedure :: holds
    end type tree_t

    !> The node of the file itself.
    integer, parameter, public :: root = 1

contains

    !> A new member of the group `parent`: its index.
    subroutine add_node(self, parent, name, kind, node)
        class(tree_t), intent(inout) :: self
        integer, intent(in) :: parent, kind
        character(*), intent(in) :: name
        integer, intent(out) :: node
        type(node_t), allocatable :: grown(:)
        integer :: i

        if (.not. allocated(self%nodes)) allocate (self%nodes(64))
        if (self%n == size(self%nodes)) then
            allocate (grown(2*self%n))
            do i = 1, self%n
                call move_node(self%nodes(i), grown(i))
            end do
            call move_alloc(grown, self%nodes)
        end if
        self%n = self%n + 1
        node = self%n
        self%nodes(node)%name = name
        self%nodes(node)%kind = kind
        self%nodes(node)%parent = parent
        allocate (self%nodes(node)%attributes(4))
    end subroutine add_node

    !> Hand a node over without copying what it holds.
    subroutine move_node(from, to)
        type(node_t), intent(inout) :: from, to

        to%kind = from%kind
        to%parent = from%parent
        to%n_attributes = from%n_attributes
        to%target = from%target
        to%stored = from%stored
        to%records = from%records
        to%rows = from%rows
        to%piece_rows = from%piece_rows
        to%n_pieces = from%n_pieces
        to%checksum = from%checksum
        to%n_lines = from%n_lines
        to%n_kept = from%n_kept
        call move_alloc(from%name, to%name)
        call move_alloc(from%attributes, to%attributes)
        call move_alloc(from%text, to%text)
        call move_alloc(from%row_shape, to%row_shape)
        call move_alloc(from%pieces, to%pieces)
        call move_alloc(from%lines, to%lines)
        call move_alloc(from%kept, to%kept)
    end subroutine move_node

    !> Forget all nodes from number `first` on.
    pure subroutine drop_nodes(self, first)
        class(tree_t), intent(inout) :: self
        integer, intent(in) :: first
        integer :: i

        do i = first, self%n
            self%nodes(i) = node_t()
        end do
        self%n = min(self%n, first - 1)
    end subroutine drop_nodes

    !> Another piece of an array lies at `address`.
    pure subroutine add_piece(self, node, address)
        class(tree_t), intent(inout) :: self
        integer, intent(in) :: node
        integer(i8), intent(in) :: address
        integer(i8), allocatable :: grown(:)

        associate (array => self%nodes(node))
            if (.not. allocated(array%pieces)) allocate (array%pieces(1))
            if (array%n_pieces == size(array%pieces)) then
                allocate (grown(2*array%n_pieces))
                grown(:array%n_pieces) = array%pieces
                call move_alloc(grown, array%pieces)
            end if
            array%n_pieces = array%n_pieces + 1
            array%pieces(array%n_pieces) = address
        end associate
    end subroutine add_piece

    !> An array of texts has one more row.
    pure subroutine add_line(self, node, text)
        class(tree_t), intent(inout) :: self
        integer, intent(in) :: node
        character(*), intent(in) :: text

        associate (array => self%nodes(node))
            array%rows = array%rows + 1
            if (len(text) > 0) call add_entry(array%lines, array%n_lines, array%rows, text)
        end associate
    end subroutine add_line

    !> A group has one more member, which lies in the file.
    pure subroutine add_kept(self, group, name, address)
        class(tree_t), intent(inout) :: self
        integer, intent(in) :: group
        character(*), intent(in) :: name
        integer(i8), intent(in) :: address

        call add_entry(self%nodes(group)%kept, self%nodes(group)%n_kept, address, name)
    end subroutine add_kept

    pure subroutine add_entry(entries, n, number, text)
        type(entry_t), allocatable, intent(inout) :: entries(:)
        integer, intent(inout) :: n                 !! of them, those in use
        integer(i8), intent(in) :: number
        character(*), intent(in) :: text
        type(entry_t), allocatable :: grown(:)
        integer :: i

        if (.not. allocated(entries)) allocate (entries(1))
        if (n == size(entries)) then
            allocate (grown(2*n))
            do i = 1, n
                grown(i)%number = entries(i)%number
                call move_alloc(entries(i)%text, grown(i)%text)
            end do
            call move_alloc(grown, entries)
        end if
        n = n + 1
        entries(n)%number = number
        entries(n)%text = text
    end subroutine add_entry

    !> Give a node an attribute, or the attribute another value.
    pure subroutine set_attribute(self, node, attribute)
        class(tree_t), intent(inout) :: self
        integer, intent(in) :: node
        type(attribute_t), intent(in) :: attribute
        type(attribute_t), allocatable :: grown(:)
        integer :: i

        associate (owner => self%nodes(node))
            do i = 1, owner%n_attributes
                if (owner%attributes(i)%name == attribute%name) exit
            end do
            if (i > size(owner%attributes)) then
                allocate (grown(2*size(owner%attributes)))
                grown(:owner%n_attributes) = owner%attributes
                call move_alloc(grown, owner%attributes)
            end if
            owner%attributes(i) = attribute
            owner%n_attributes = max(owner%n_attributes, i)
        end associate
    end subroutine set_attribute

    !> Bytes of a row of an array.
    pure integer(i8) function row_bytes(self, node)
        class(tree_t), intent(in) :: self
        integer, intent(in) :: node

        row_bytes = product(self%nodes(node)%row_shape)*self%nodes(node)%records &
            *stored_bytes(self%nodes(node)%stored)
    end function row_bytes

    !> Names from the root down to a node, which is not the root: "transient/probes/tip".
    pure function path(self, node)
        class(tree_t), intent(in) :: self
        integer, intent(in) :: node
        character(:), allocatable :: path
        integer :: above

        path = self%nodes(node)%name
        above = self%nodes(node)%parent
        do while (above > root)
            path = self%nodes(above)%name // '/' // path
            above = self%nodes(above)%parent
        end do
    end function path

    !> Whether a node stands below a group.
    pure logical function holds(self, group, node)
        class(tree_t), intent(in) :: self
        integer, intent(in) :: group, node
        integer :: above

        above = node
        do while (above > group)
            above = self%nodes(above)%parent
        end do
        holds = above == group
    end function holds

end module gb_tree
