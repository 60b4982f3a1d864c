!> Checks of the whole model, made where END closes it: lines that join, places that are nodes, supports
!> that hold.
module gb_check_model
    use gb_capacity, only: lacks_memory
    use gb_diagnostics, only: diagnostics_t, span_t
    use gb_draft, only: draft_t, line_place_t, place_t, space_material, space_section, space_names
    use gb_fields, only: n_fields, field_names, field_u1, field_u3, field_y1, field_xi
    use gb_kinds, only: wp, i8
    use gb_mesh, only: line_t, build_mesh
    use gb_text, only: to_text, upper_case
    use gb_values, only: join_words
    implicit none
    private

    public :: close_model

    integer(i8), parameter :: most_nodes = 20000000_i8
    integer(i8), parameter :: node_bytes = 60_i8        !! of the mesh alone, while it is being built
    real(wp), parameter :: same_place = 1.0e-9_wp       !! of the total length

contains

    !> Build the mesh and check everything that hangs on it. `at` is the place of END.
    subroutine close_model(draft, at, diagnostics)
        type(draft_t), intent(inout) :: draft
        type(span_t), intent(in) :: at
        type(diagnostics_t), intent(inout) :: diagnostics

        call draft%close_lists()
        if (draft%n_lines == 0) then
            if (.not. draft%incomplete) call diagnostics%add(at, 'the model has no LINE')
            return
        end if
        call fill_in(draft, space_material, diagnostics)
        call fill_in(draft, space_section, diagnostics)
        if (draft%lines_lost) return
        call join_lines(draft, diagnostics)
        if (draft%lines_lost) return
        ! What was not understood may have been a support, and a line beyond the ends, but none in between.
        draft%supports_lost = draft%supports_lost .or. draft%incomplete
        call check_places(draft, diagnostics)
        call check_driven(draft, diagnostics)
        call check_initial(draft, diagnostics)
        if (.not. draft%supports_lost) draft%loose = free_motion(draft)
        draft%has_mesh = .not. draft%supports_lost
    end subroutine close_model

    !> Lines that name no material (section) take the only one.
    subroutine fill_in(draft, space, diagnostics)
        type(draft_t), intent(inout) :: draft
        integer, intent(in) :: space
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: what
        integer :: i, number
        logical :: reported

        what = trim(space_names(space))
        reported = .false.
        do i = 1, draft%n_lines
            associate (line => draft%problem%model%lines(i))
                number = line%material
                if (space == space_section) number = line%section
                if (number > 0) cycle
                if (draft%names(space)%n == 1) then
                    if (space == space_material) line%material = 1
                    if (space == space_section) line%section = 1
                    if (.not. draft%names(space)%is_sound(1)) draft%lines_lost = .true.
                    cycle
                end if
            end associate
            draft%lines_lost = .true.
            ! A line whose own reference was wrong has been reported.
            if (draft%line_places(i)%excused(space) .or. reported .or. draft%incomplete .or. &
                draft%names_lost(space)) cycle
            if (draft%names(space)%n == 0) then
                call diagnostics%add(draft%line_places(i)%at, 'LINE has no ' // what // &
                    ': the deck defines none', hint='define one with ' // upper_case(what))
                reported = .true.
            else
                call diagnostics%add(draft%line_places(i)%at, 'LINE must name its ' // what // &
                    ': the deck defines ' // to_text(draft%names(space)%n))
            end if
        end do
    end subroutine fill_in

    !> Sort the lines along X1, see that they join end to end, and cut them into elements.
    subroutine join_lines(draft, diagnostics)
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        real(wp) :: total
        character(:), allocatable :: reason
        integer :: i
        integer(i8) :: nodes

        associate (n => draft%n_lines, lines => draft%problem%model%lines)
            call sort_lines(lines(:n), draft%line_places(:n))
            total = maxval(lines(:n)%to) - lines(1)%from
            nodes = 1 + sum(int(lines(:n)%elements, i8)*(lines(:n)%nodes - 1))
            do i = 2, n
                if (abs(lines(i)%from - lines(i - 1)%to) <= same_place*total) cycle
                if (.not. draft%incomplete) call report_joint(lines(i - 1), lines(i), &
                    draft%line_places(i - 1), draft%line_places(i), diagnostics)
                draft%lines_lost = .true.
            end do
            if (draft%lines_lost) return
            if (nodes > most_nodes) then
                call diagnostics%add(draft%line_places(n)%at, 'the model has more than ' // &
                                     to_text(int(most_nodes)) // ' nodes')
                draft%lines_lost = .true.
                return
            end if
            reason = lacks_memory(node_bytes*nodes)
            if (len(reason) > 0) then
                call diagnostics%add(draft%line_places(n)%at, 'the mesh of ' // to_text(int(nodes)) &
                                     // ' nodes is too large for this machine: ' // reason)
                draft%lines_lost = .true.
                return
            end if
            draft%problem%model%mesh = build_mesh(lines(:n))
        end associate
        call check_elements(draft, diagnostics)
    end subroutine join_lines

    !> Nodes that fall together: the elements are too short for the numbers they stand at.
    subroutine check_elements(draft, diagnostics)
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: i, node, nodes

        node = 1
        do i = 1, draft%n_lines
            nodes = draft%problem%model%lines(i)%elements*(draft%problem%model%lines(i)%nodes - 1)
            associate (x => draft%problem%model%mesh%x(node:node + nodes))
                if (.not. all(x(2:) > x(:nodes))) then
                    call diagnostics%add(draft%line_places(i)%at, &
                        'the elements of this LINE are so short that nodes coincide')
                    draft%lines_lost = .true.
                end if
            end associate
            node = node + nodes
        end do
    end subroutine check_elements

    !> Merge sort by `from`, stable; lines that are in order already cost no copying.
    recursive subroutine sort_lines(lines, places)
        type(line_t), intent(inout) :: lines(:)
        type(line_place_t), intent(inout) :: places(:)
        type(line_t), allocatable :: left(:)
        type(line_place_t), allocatable :: left_places(:)
        integer :: half, i, j, k

        half = size(lines)/2
        if (half == 0) return
        call sort_lines(lines(:half), places(:half))
        call sort_lines(lines(half + 1:), places(half + 1:))
        if (lines(half)%from <= lines(half + 1)%from) return
        allocate (left(half), left_places(half))
        left = lines(:half)
        left_places = places(:half)
        i = 1
        j = half + 1
        do k = 1, size(lines)
            if (i > half) exit
            if (j > size(lines)) then
                lines(k) = left(i)
                places(k) = left_places(i)
                i = i + 1
            else if (left(i)%from <= lines(j)%from) then
                lines(k) = left(i)
                places(k) = left_places(i)
                i = i + 1
            else
                lines(k) = lines(j)
                places(k) = places(j)
                j = j + 1
            end if
        end do
    end subroutine sort_lines

    subroutine report_joint(left, right, left_place, right_place, diagnostics)
        type(line_t), intent(in) :: left, right
        type(line_place_t), intent(in) :: left_place, right_place
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: what

        what = 'a gap'
        if (right%from < left%to) what = 'an overlap'
        call diagnostics%add(right_place%from, 'LINEs must join end to end: this one starts at x = ' // &
                             to_text(right%from, 12) // ', the one before it ends at x = ' // &
                             to_text(left%to, 12) // &
                             ' (' // what // ')', other=left_place%to, note='the one before it ends here')
    end subroutine report_joint

    !> Places that must be nodes, or on the beam.
    subroutine check_places(draft, diagnostics)
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: i, low

        associate (mesh => draft%problem%model%mesh)
            do i = 1, draft%n_places
                associate (place => draft%places(i), first => mesh%x(1), last => mesh%x(mesh%n_nodes()))
                    if (place%x < first - same_place*mesh%length() .or. &
                        place%x > last + same_place*mesh%length()) then
                        if (draft%incomplete) cycle
                        call diagnostics%add(place%at, 'x = ' // to_text(place%x, 12) // &
                                             ' is not on the beam, which goes from ' // &
                                             to_text(first, 12) // ' to ' // to_text(last, 12), &
                                             hint=nearest_pair(draft, place))
                    else if (place%at_node) then
                        if (mesh%node_at(place%x) > 0) cycle
                        low = node_below(mesh%x, place%x)
                        call diagnostics%add(place%at, 'x = ' // to_text(place%x, 12) // &
                                             ' is not a node: the nearest nodes are at ' // &
                                             to_text(mesh%x(low), 12) // ' and ' // &
                                             to_text(mesh%x(low + 1), 12))
                    else
                        cycle
                    end if
                    if (place%at_node) draft%supports_lost = .true.
                end associate
            end do
        end associate
    end subroutine check_places

    !> For a place off the beam that should be a node: the two nodes at that end.
    pure function nearest_pair(draft, place) result(hint)
        type(draft_t), intent(in) :: draft
        type(place_t), intent(in) :: place
        character(:), allocatable :: hint
        integer :: low

        hint = ''
        if (.not. place%at_node) return
        associate (x => draft%problem%model%mesh%x)
            low = node_below(x, place%x)
            hint = 'the nearest nodes are at ' // to_text(x(low), 12) // ' and ' // to_text(x(low + 1), 12)
        end associate
    end function nearest_pair

    !> The last node that is not beyond `at`, but never the very last.
    pure integer function node_below(x, at) result(low)
        real(wp), intent(in) :: x(:), at
        integer :: high, middle

        low = 1
        high = size(x)
        do while (high - low > 1)
            middle = (low + high)/2
            if (x(middle) <= at) then
                low = middle
            else
                high = middle
            end if
        end do
    end function node_below

    !> A field is fixed or driven, and driven by one command only.
    subroutine check_driven(draft, diagnostics)
        type(draft_t), intent(in) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(span_t), allocatable :: taken(:, :)
        logical, allocatable :: driven(:, :)
        integer :: i, node, field

        if (draft%n_prescribed == 0 .or. draft%supports_lost) return
        associate (model => draft%problem%model)
            allocate (taken(n_fields, model%mesh%n_nodes()), driven(n_fields, model%mesh%n_nodes()))
            driven = .false.
            do i = 1, draft%n_supports
                node = model%mesh%node_at(model%supports(i)%x)
                where (model%supports(i)%fixed) taken(:, node)%first = draft%support_places(i)%first
                where (model%supports(i)%fixed) taken(:, node)%last = draft%support_places(i)%last
            end do
            do i = 1, draft%n_prescribed
                node = model%mesh%node_at(model%prescribed(i)%x)
                do field = 1, n_fields
                    if (.not. model%prescribed(i)%driven(field)) cycle
                    if (taken(field, node)%first > 0) then
                        call diagnostics%add(draft%prescribed_places(field, i), field_names(field) // &
                                             ' is already ' // &
                                             trim(merge('driven', 'fixed ', driven(field, node))) // &
                                             ' at this node', other=taken(field, node), note='here')
                    end if
                    taken(field, node) = draft%prescribed_places(field, i)
                    driven(field, node) = .true.
                end do
            end do
        end associate
    end subroutine check_driven

    !> Initial values must be finite at every node.
    subroutine check_initial(draft, diagnostics)
        type(draft_t), intent(in) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        real(wp) :: value
        logical :: defined
        integer :: i, node

        associate (x => draft%problem%model%mesh%x)
            do i = 1, draft%n_initial
                do node = 1, size(x)
                    call draft%problem%model%initial(i)%formula%evaluate(x(node), value, defined)
                    if (defined) cycle
                    call diagnostics%add(draft%initial_places(i), &
                        'this is not a finite number at the node x = ' // to_text(x(node), 12))
                    exit
                end do
            end do
        end associate
    end subroutine check_initial

    !> The rigid motion that supports and driven fields leave free, in words; empty where there is none. A
    !> small rotation about the origin moves u3 = x and y1 = -1, so that u3 held at two places, or u3 and y1
    !> held, stop it.
    pure function free_motion(draft) result(words)
        type(draft_t), intent(in) :: draft
        character(:), allocatable :: words
        logical :: held(n_fields), two_places
        real(wp) :: u3_at, x
        character(60) :: motions(4)
        logical :: fixed(n_fields)
        integer :: i

        held = .false.
        two_places = .false.
        u3_at = 0.0_wp
        do i = 1, draft%n_supports + draft%n_prescribed
            if (i <= draft%n_supports) then
                fixed = draft%problem%model%supports(i)%fixed
                x = draft%problem%model%supports(i)%x
            else
                fixed = draft%problem%model%prescribed(i - draft%n_supports)%driven
                x = draft%problem%model%prescribed(i - draft%n_supports)%x
            end if
            if (fixed(field_u3)) then
                if (held(field_u3)) two_places = two_places .or. &
                    abs(x - u3_at) > same_place*draft%problem%model%mesh%length()
                u3_at = x
            end if
            held = held .or. fixed
        end do
        words = ''
        motions = ''
        if (.not. held(field_u1)) motions(1) = 'move along X1'
        if (.not. held(field_u3)) motions(2) = 'move along X3'
        if (.not. (held(field_y1) .or. two_places)) then
            motions(3) = 'turn'
            if (held(field_u3)) motions(3) = 'turn about x = ' // to_text(u3_at, 12)
        end if
        if (has_free_xi(draft, held)) motions(4) = 'let xi alternate (rule=linear: hold it by FIX xi)'
        if (any(motions /= '')) words = 'it can still ' // join_words(pack(motions, motions /= ''), 'and')
    end function free_motion

    !> Rule `linear` has no term of xi', and with reduced integration one pattern of xi vanishes at all
    !> points: it has no stiffness unless xi is held somewhere, or an element has another rule or full
    !> integration.
    pure logical function has_free_xi(draft, held)
        type(draft_t), intent(in) :: draft
        logical, intent(in) :: held(n_fields)

        associate (model => draft%problem%model)
            has_free_xi = .not. (held(field_xi) .or. any(model%mesh%full_integration))
            if (has_free_xi) has_free_xi = .not. model%has_potential_somewhere()
        end associate
    end function has_free_xi

end module gb_check_model
