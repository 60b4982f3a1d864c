!> The model as a drawing of characters, for --check: loads above, the beam with its nodes to scale, supports
!> below, and a ruler.
module gb_sketch
    use gb_kinds, only: wp
    use gb_text, only: to_text
    use gb_fields, only: n_fields, field_names, field_u1, field_u3, field_y1
    use gb_log, only: log_t
    use gb_model, only: model_t
    use gb_scene, only: point_names, distributed_names, gravity_names
    implicit none
    private

    public :: draw_model

    integer, parameter :: margin = 14               !! columns before the beam, for the names of loads
    integer, parameter :: width = 61                !! columns of the beam, its ends included
    integer, parameter :: beyond = 10               !! columns behind it
    integer, parameter :: line_length = margin + width + beyond

contains

    subroutine draw_model(model, log)
        type(model_t), intent(in) :: model
        type(log_t), intent(inout) :: log
        character(:), allocatable :: legend
        logical :: is_thin, is_crowded

        call log%line('')
        call draw_loads(model, log)
        call draw_beam(model, log, is_thin, is_crowded)
        call draw_supports(model, log)
        call draw_ruler(model, log)
        legend = '  + ends of elements, o nodes inside; X clamped, A pinned, O roller, I sliding'
        if (is_crowded) legend = legend // '; # several nodes'
        if (is_thin) legend = legend // '; - thinner'
        call log%line(legend)
    end subroutine draw_model

    !> Column of a place on the beam.
    pure integer function column(model, x)
        type(model_t), intent(in) :: model
        real(wp), intent(in) :: x

        associate (mesh => model%mesh)
            column = margin + 1 + nint((x - mesh%x(1))/mesh%length()*real(width - 1, wp))
        end associate
    end function column

    !> A line for every component of every load: arrows where it acts, its value in front.
    subroutine draw_loads(model, log)
        type(model_t), intent(in) :: model
        type(log_t), intent(inout) :: log
        integer :: i, k

        do i = 1, size(model%gravity)
            do k = 1, 2
                call draw_one(gravity_names(k), model%gravity(i)%g(k), k, margin + 1, margin + width)
            end do
        end do
        do i = 1, size(model%distributed_loads)
            associate (load => model%distributed_loads(i))
                do k = 1, 2
                    call draw_one(distributed_names(k), load%q(k), k, column(model, load%from), &
                        column(model, load%to))
                end do
            end associate
        end do
        do i = 1, size(model%point_loads)
            associate (load => model%point_loads(i))
                do k = 1, 4
                    call draw_one(point_names(k), load%value(k), k, column(model, load%x), &
                        column(model, load%x))
                end do
            end associate
        end do
        do i = 1, size(model%prescribed)
            associate (driven => model%prescribed(i))
                do k = 1, n_fields
                    if (.not. driven%driven(k)) cycle
                    call draw_mark(field_names(k) // ' = ' // to_text(driven%value(k), 4), '*', &
                        column(model, driven%x), column(model, driven%x))
                end do
            end associate
        end do

    contains

        !> Component 1 points along the beam, 2 across; 3 and 4 are couples.
        subroutine draw_one(name, value, component, first, last)
            character(*), intent(in) :: name
            real(wp), intent(in) :: value
            integer, intent(in) :: component, first, last
            character(4), parameter :: up = '>^@@', down = '<v@@'

            if (abs(value) <= 0.0_wp) return
            if (value > 0.0_wp) then
                call draw_mark(name // ' ' // to_text(value, 4), up(component:component), first, last)
            else
                call draw_mark(name // ' ' // to_text(value, 4), down(component:component), first, last)
            end if
        end subroutine draw_one

        subroutine draw_mark(label, mark, first, last)
            character(*), intent(in) :: label
            character(1), intent(in) :: mark
            integer, intent(in) :: first, last
            character(line_length) :: line

            line = ''
            line(3:) = label
            line(max(first, 4 + len(label)):last) = repeat(mark, max(1, last - max(first, &
                4 + len(label)) + 1))
            call log%line(trim(line))
        end subroutine draw_mark

    end subroutine draw_loads

    !> Ends of elements `+`, nodes inside them `o`, between them `=`, or `-` where the beam is thinner than
    !> three quarters of its thickest part. Where nodes are closer than columns, `#` stands for several.
    subroutine draw_beam(model, log, is_thin, is_crowded)
        type(model_t), intent(in) :: model
        type(log_t), intent(inout) :: log
        logical, intent(out) :: is_thin             !! somewhere it is drawn thin
        logical, intent(out) :: is_crowded          !! somewhere a column stands for several nodes
        character(line_length) :: line
        integer :: e, i, place, nodes(line_length)
        real(wp), parameter :: clearly = 0.75_wp
        real(wp) :: thickest
        logical :: thin

        line = ''
        nodes = 0
        is_thin = .false.
        thickest = maxval(model%sections(model%mesh%section)%h)
        associate (mesh => model%mesh)
            do e = 1, mesh%n_elements()
                thin = model%sections(mesh%section(e))%h < clearly*thickest
                is_thin = is_thin .or. thin
                do place = column(model, mesh%x(mesh%first_node(e))), &
                    column(model, mesh%x(mesh%first_node(e) + mesh%nodes(e) - 1))
                    line(place:place) = merge('-', '=', thin)
                end do
            end do
            do i = 1, mesh%n_nodes()
                place = column(model, mesh%x(i))
                nodes(place) = nodes(place) + 1
                line(place:place) = 'o'
            end do
            do e = 1, mesh%n_elements()
                do i = 0, 1
                    place = column(model, mesh%x(mesh%first_node(e) + i*(mesh%nodes(e) - 1)))
                    line(place:place) = '+'
                end do
            end do
        end associate
        is_crowded = any(nodes > 1)
        do place = 1, line_length
            if (nodes(place) > 1) line(place:place) = '#'
        end do
        call log%line(trim(line))
    end subroutine draw_beam

    !> A mark below the beam for every support.
    subroutine draw_supports(model, log)
        type(model_t), intent(in) :: model
        type(log_t), intent(inout) :: log
        character(line_length) :: line
        integer :: i, place

        if (size(model%supports) == 0) return
        line = ''
        do i = 1, size(model%supports)
            place = column(model, model%supports(i)%x)
            line(place:place) = mark_of(model%supports(i)%fixed)
        end do
        call log%line(trim(line))
    end subroutine draw_supports

    !> One character for what a support holds: X clamped, A pinned, O on rollers, I sliding across, else ?.
    !> The section turns by y1, whatever becomes of y3, the thickness.
    pure character(1) function mark_of(fixed) result(mark)
        logical, intent(in) :: fixed(n_fields)
        logical :: turns

        turns = .not. fixed(field_y1)
        mark = '?'
        if (fixed(field_u1) .and. fixed(field_u3)) mark = merge('A', 'X', turns)
        if (.not. fixed(field_u1) .and. fixed(field_u3) .and. turns) mark = 'O'
        if (fixed(field_u1) .and. .not. (fixed(field_u3) .or. turns)) mark = 'I'
    end function mark_of

    !> X1 of the ends, and of the supports and joints of lines between them as far as there is room.
    subroutine draw_ruler(model, log)
        type(model_t), intent(in) :: model
        type(log_t), intent(inout) :: log
        character(line_length) :: line
        integer :: i

        line = ''
        associate (mesh => model%mesh)
            call label(mesh%x(1))
            call label(mesh%x(size(mesh%x)))
            do i = 1, size(model%supports)
                call label(model%supports(i)%x)
            end do
            do i = 2, size(model%lines)
                call label(model%lines(i)%from)
            end do
        end associate
        call log%line(trim(line))

    contains

        !> The number centred under its place, where that is free.
        subroutine label(x)
            real(wp), intent(in) :: x
            character(:), allocatable :: text
            integer :: first, last

            text = to_text(x, 5)
            first = min(max(2, column(model, x) - len(text)/2), line_length - len(text))
            last = first + len(text) - 1
            if (line(first - 1:last + 1) == '') line(first:last) = text
        end subroutine label

    end subroutine draw_ruler

end module gb_sketch
