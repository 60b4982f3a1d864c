!> The mesh: straight LINEs along X1 that join end to end, cut into Lagrange elements of 2 to 5 nodes.
module gb_mesh
    use gb_kinds, only: wp
    implicit none
    private

    integer, parameter, public :: max_element_nodes = 5

    !> One LINE of the deck: a stretch of beam of one material and one section.
    type, public :: line_t
        real(wp) :: from = 0.0_wp, to = 0.0_wp      !! ends [L]
        integer :: elements = 1
        integer :: nodes = 3                        !! nodes an element, 2 to 5
        logical :: full_integration = .false.       !! as many Gauss points as nodes, in place of one fewer
        real(wp) :: grading = 1.0_wp                !! length of the last element over that of the first
        integer :: material = 1, section = 1        !! index in the model's lists
    end type line_t

    !> Nodes are numbered along the beam, and those of an element follow one another: element e holds the
    !> nodes first_node(e) ... first_node(e) + nodes(e) - 1, its ends first and last.
    type, public :: mesh_t
        real(wp), allocatable :: x(:)               !! reference X1 of every node [L] (nn), increasing
        integer, allocatable :: first_node(:)       !! (ne)
        integer, allocatable :: nodes(:)            !! nodes an element (ne)
        logical, allocatable :: full_integration(:) !! (ne)
        integer, allocatable :: material(:)         !! (ne)
        integer, allocatable :: section(:)          !! (ne)
    contains
        procedure :: n_nodes
        procedure :: n_elements
        procedure :: element_at
        procedure :: node_at
        procedure :: length
        procedure :: element_length
    end type mesh_t

    public :: build_mesh

contains

    !> Cut the lines into elements. The lines join end to end in increasing X1 (the deck's reader has seen to
    !> it); the nodes of an element are equidistant; element lengths of a line form a geometric progression.
    pure function build_mesh(lines) result(mesh)
        type(line_t), intent(in) :: lines(:)
        type(mesh_t) :: mesh
        integer :: n_elements, n_nodes, i, k, e, node, inner
        real(wp) :: left, right

        n_elements = sum(lines%elements)
        n_nodes = 1 + sum(lines%elements*(lines%nodes - 1))
        allocate (mesh%x(n_nodes), mesh%first_node(n_elements), mesh%nodes(n_elements))
        allocate (mesh%full_integration(n_elements), mesh%material(n_elements), mesh%section(n_elements))
        e = 0
        node = 1
        mesh%x(1) = lines(1)%from
        do i = 1, size(lines)
            left = mesh%x(node)
            do k = 1, lines(i)%elements
                e = e + 1
                right = element_end(lines(i), k)
                mesh%first_node(e) = node
                mesh%nodes(e) = lines(i)%nodes
                mesh%full_integration(e) = lines(i)%full_integration
                mesh%material(e) = lines(i)%material
                mesh%section(e) = lines(i)%section
                do inner = 1, lines(i)%nodes - 1
                    mesh%x(node + inner) = left + (right - left)*real(inner, wp)/real(lines(i)%nodes - 1, wp)
                end do
                node = node + lines(i)%nodes - 1
                mesh%x(node) = right
                left = right
            end do
        end do
    end function build_mesh

    !> X1 of the far end of the line's k-th element.
    pure real(wp) function element_end(line, k) result(x)
        type(line_t), intent(in) :: line
        integer, intent(in) :: k
        real(wp) :: ratio, part

        if (k == line%elements) then
            x = line%to
            return
        end if
        part = real(k, wp)/real(line%elements, wp)
        if (line%elements > 1 .and. abs(line%grading - 1.0_wp) > epsilon(1.0_wp)) then
            ratio = line%grading**(1.0_wp/real(line%elements - 1, wp))
            if (abs(ratio - 1.0_wp) > 1.0e-9_wp) part = (ratio**k - 1.0_wp)/(ratio**line%elements - 1.0_wp)
        end if
        x = line%from + (line%to - line%from)*part
    end function element_end

    pure integer function n_nodes(self)
        class(mesh_t), intent(in) :: self

        n_nodes = size(self%x)
    end function n_nodes

    pure integer function n_elements(self)
        class(mesh_t), intent(in) :: self

        n_elements = size(self%first_node)
    end function n_elements

    !> Total reference length [L].
    pure real(wp) function length(self)
        class(mesh_t), intent(in) :: self

        length = self%x(size(self%x)) - self%x(1)
    end function length

    !> Reference length of an element [L].
    pure real(wp) function element_length(self, element)
        class(mesh_t), intent(in) :: self
        integer, intent(in) :: element

        associate (first => self%first_node(element))
            element_length = self%x(first + self%nodes(element) - 1) - self%x(first)
        end associate
    end function element_length

    !> The element that holds the point x (the last one whose left end is not beyond it), by bisection.
    pure integer function element_at(self, x) result(element)
        class(mesh_t), intent(in) :: self
        real(wp), intent(in) :: x
        integer :: low, high, middle

        low = 1
        high = self%n_elements()
        do while (low < high)
            middle = (low + high + 1)/2
            if (self%x(self%first_node(middle)) <= x) then
                low = middle
            else
                high = middle - 1
            end if
        end do
        element = low
    end function element_at

    !> The node nearest to x, by bisection: 0 if it is farther away than 1e-9 of the total length.
    pure integer function node_at(self, x) result(node)
        class(mesh_t), intent(in) :: self
        real(wp), intent(in) :: x
        integer :: low, high, middle

        low = 1
        high = size(self%x)
        do while (high - low > 1)
            middle = (low + high)/2
            if (self%x(middle) <= x) then
                low = middle
            else
                high = middle
            end if
        end do
        node = merge(low, high, abs(x - self%x(low)) <= abs(x - self%x(high)))
        if (abs(x - self%x(node)) > 1.0e-9_wp*self%length()) node = 0
    end function node_at

end module gb_mesh
