!> The beam as `auto` meshes it: pieces between the places that must be nodes, each with its share of the
!> elements, so that any number of elements can be tried.
module gb_pieces
    use gb_kinds, only: wp
    use gb_mesh, only: line_t
    use gb_model, only: model_t
    use gb_sort, only: sorted
    implicit none
    private

    !> A stretch of one LINE.
    type, public :: piece_t
        type(line_t) :: line                        !! its elements and grading are chosen anew
        real(wp) :: share = 0.0_wp                  !! elements that the deck has on it [-]
        real(wp) :: growth = 1.0_wp                 !! element length at its end over that at its start [-]
    end type piece_t

    public :: cut_into_pieces, spread_elements, least_density, mesh_pieces

    !> Two places closer than this part of the beam's length are one (as the deck's reader takes it).
    real(wp), parameter :: same_place = 1.0e-9_wp
    !> Ends of distributed loads and places of probes become nodes too, unless that would leave a piece
    !> shorter than this part of the beam.
    real(wp), parameter :: shortest_part = 0.02_wp

contains

    !> Pieces from left to right. Their ends are those of the LINEs, the places of supports and point loads;
    !> the ends of distributed loads, since an element in which a load ends converges more slowly; and the
    !> probes that matter, since displacements are most accurate at nodes.
    function cut_into_pieces(model, probes) result(pieces)
        type(model_t), intent(in) :: model
        real(wp), intent(in) :: probes(:)           !! places of these [L]
        type(piece_t), allocatable :: pieces(:)
        real(wp), allocatable :: places(:), cuts(:)
        real(wp) :: length
        integer :: i, k

        length = model%mesh%length()
        places = [model%supports%x, model%prescribed%x, model%point_loads%x]
        do i = 1, size(model%distributed_loads)
            call add_end(model%distributed_loads(i)%from)
            call add_end(model%distributed_loads(i)%to)
        end do
        do i = 1, size(probes)
            call add_end(probes(i))
        end do
        places = sorted(places)
        allocate (pieces(0))
        do i = 1, size(model%lines)
            associate (line => model%lines(i))
                cuts = [line%from]
                do k = 1, size(places)
                    if (places(k) > cuts(size(cuts)) + same_place*length .and. &
                        places(k) < line%to - same_place*length) cuts = [cuts, places(k)]
                end do
                cuts = [cuts, line%to]
                do k = 2, size(cuts)
                    pieces = [pieces, piece_of(line, cuts(k - 1), cuts(k))]
                end do
            end associate
        end do

    contains

        subroutine add_end(x)
            real(wp), intent(in) :: x
            real(wp), allocatable :: others(:)

            others = [places, model%lines%from, model%lines%to]
            if (minval(abs(others - x)) > shortest_part*length) places = [places, x]
        end subroutine add_end

    end function cut_into_pieces

    !> The stretch from a to b of a line, with the share of the elements that its grading gives to it.
    pure type(piece_t) function piece_of(line, a, b) result(piece)
        type(line_t), intent(in) :: line
        real(wp), intent(in) :: a, b                !! [L]

        piece%line = line
        piece%line%from = a
        piece%line%to = b
        piece%share = elements_before(line, b) - elements_before(line, a)
        piece%growth = 1.0_wp
        if (line%elements > 1) piece%growth = line%grading**(piece%share/real(line%elements - 1, wp))
    end function piece_of

    !> Number of elements of a line that lie before x, as a real number.
    pure real(wp) function elements_before(line, x) result(number)
        type(line_t), intent(in) :: line
        real(wp), intent(in) :: x                   !! [L]
        real(wp) :: part, ratio

        part = (x - line%from)/(line%to - line%from)
        number = part*real(line%elements, wp)
        if (line%elements == 1) return
        ratio = line%grading**(1.0_wp/real(line%elements - 1, wp))
        if (abs(ratio - 1.0_wp) <= 1.0e-9_wp) return
        number = log(1.0_wp + part*(ratio**line%elements - 1.0_wp))/log(ratio)
    end function elements_before

    !> So many elements in all, given to the pieces by their shares; at least one to each.
    pure function spread_elements(pieces, number) result(elements)
        type(piece_t), intent(in) :: pieces(:)
        real(wp), intent(in) :: number
        integer :: elements(size(pieces))

        elements = max(1, nint(number*pieces%share/sum(pieces%share)))
    end function spread_elements

    !> Number of elements that a mesh would have if they were everywhere as long as in its coarsest piece.
    pure real(wp) function least_density(pieces, elements) result(number)
        type(piece_t), intent(in) :: pieces(:)
        integer, intent(in) :: elements(:)          !! of the pieces

        number = minval(real(elements, wp)/pieces%share)*sum(pieces%share)
    end function least_density

    !> Lines of a mesh with so many elements on every piece, of so many nodes each.
    pure function mesh_pieces(pieces, elements, nodes) result(lines)
        type(piece_t), intent(in) :: pieces(:)
        integer, intent(in) :: elements(:)
        integer, intent(in) :: nodes
        type(line_t) :: lines(size(pieces))

        lines = pieces%line
        lines%elements = elements
        lines%nodes = nodes
        lines%full_integration = .false.
        lines%grading = pieces%growth**(real(elements - 1, wp)/real(elements, wp))
    end function mesh_pieces

end module gb_pieces
