!> The beam as a strip of columns that stand across it: one a node, two where neighbours differ in section or
!> material, so that a step in the thickness stays a step. Pictures and values at the nodes go by columns.
module gb_strip
    use gb_mesh, only: mesh_t
    use gb_kinds, only: wp
    use gb_section, only: section_t
    implicit none
    private

    !> Heights of a column's points, in parts of h from the mid-line: bottom, middle and top. The map X3 + xi
    !> X3^2 is quadratic, so three hold the shape.
    integer, parameter, public :: strip_heights = 3
    real(wp), parameter, public :: strip_levels(strip_heights) = [-0.5_wp, 0.0_wp, 0.5_wp]

    type, public :: strip_t
        integer :: columns = 0
        integer, allocatable :: node(:)             !! of a column (columns)
        integer, allocatable :: first_column(:)  !! of an element; its nodes' columns follow one another (ne)
        integer, allocatable :: element(:)          !! an element that a column belongs to (columns)
        real(wp), allocatable :: h(:)               !! thickness at a column [L] (columns)
        real(wp), allocatable :: share(:)           !! 1/2 where two elements meet in a column, else 1 [-]
    end type strip_t

    public :: build_strip

contains

    pure function build_strip(mesh, sections) result(strip)
        type(mesh_t), intent(in) :: mesh
        type(section_t), intent(in) :: sections(:)
        type(strip_t) :: strip
        integer :: e, i, c, most
        logical :: shared

        most = sum(mesh%nodes)
        allocate (strip%node(most), strip%element(most), strip%h(most), strip%share(most))
        allocate (strip%first_column(mesh%n_elements()))
        strip%share = 1.0_wp
        c = 0
        do e = 1, mesh%n_elements()
            shared = .false.
            if (e > 1) shared = mesh%section(e) == mesh%section(e - 1) &
                .and. mesh%material(e) == mesh%material(e - 1)
            if (shared) then
                strip%share(c) = 0.5_wp
                c = c - 1
            end if
            strip%first_column(e) = c + 1
            do i = 1, mesh%nodes(e)
                strip%node(c + i) = mesh%first_node(e) + i - 1
                strip%element(c + i) = e
                strip%h(c + i) = sections(mesh%section(e))%h
            end do
            c = c + mesh%nodes(e)
        end do
        strip%columns = c
    end function build_strip

end module gb_strip
