!> What the results file says of the run itself: deck, version, units, mesh.
module gb_results_header
    use, intrinsic :: iso_fortran_env, only: compiler_version
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_version, only: program_version, git_revision
    use gb_mesh, only: max_element_nodes
    use gb_model, only: model_t, units_t
    use gb_problem, only: problem_t
    use gb_scene, only: scene_lines
    use gb_archive, only: archive_t, root, stored_int32, stored_int8
    implicit none
    private

    public :: write_header, write_units, write_mesh, now

contains

    subroutine write_header(archive, problem, created)
        type(archive_t), intent(inout) :: archive
        type(problem_t), intent(in) :: problem
        character(*), intent(in) :: created         !! ISO 8601
        integer :: node

        call archive%set(root, 'format', 'gentbeam')
        call archive%set(root, 'format_version', 1)
        call archive%set(root, 'program_version', program_version)
        call archive%set(root, 'git_revision', git_revision)
        call archive%set(root, 'compiler', compiler_version())
        call archive%set(root, 'title', problem%model%title)
        call archive%set(root, 'created', created)
        call archive%set(root, 'status', 'running')
        call archive%set(root, 'message', '')
        call archive%set(root, 'wall_seconds', 0.0_wp)
        call archive%set(root, 'cpu_seconds', 0.0_wp)
        call archive%put_text(root, 'deck', problem%deck_text, '', 'the deck as read', node)
        call archive%set(node, 'parameters', problem%parameters)
        call archive%set(node, 'scene', scene_lines(problem%model))
    end subroutine write_header

    !> ISO 8601 with the offset from UTC.
    function now() result(text)
        character(:), allocatable :: text
        character(8) :: date
        character(10) :: time
        character(5) :: zone

        call date_and_time(date, time, zone)
        text = date(1:4) // '-' // date(5:6) // '-' // date(7:8) // 'T' // time(1:2) // ':' // time(3:4) &
            // ':' // time(5:6) // zone(1:3) // ':' // zone(4:5)
    end function now

    subroutine write_units(archive, units)
        type(archive_t), intent(inout) :: archive
        type(units_t), intent(in) :: units
        integer :: group

        call archive%add_group(root, 'units', group)
        call archive%set(group, 'length', units%length)
        call archive%set(group, 'force', units%force)
        call archive%set(group, 'time', units%time)
    end subroutine write_units

    !> The group `mesh` of the file, or of a member of a study.
    subroutine write_mesh(archive, parent, model, group, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: parent
        type(model_t), intent(in) :: model
        integer, intent(out) :: group
        type(error_t), allocatable, intent(out) :: error
        integer, allocatable :: elements(:, :)
        integer :: e, i

        associate (mesh => model%mesh)
            allocate (elements(max_element_nodes, mesh%n_elements()))
            elements = -1
            do e = 1, mesh%n_elements()
                elements(:mesh%nodes(e), e) = [(mesh%first_node(e) + i - 2, i=1, mesh%nodes(e))]
            end do
            call archive%add_group(parent, 'mesh', group)
            call archive%put(group, 'x', mesh%x, model%units%length, 'reference X1 of every node', error)
            if (.not. allocated(error)) call archive%put(group, 'elements', elements, stored_int32, '', &
                'nodes of every element, counted from 0, -1 where unused', error)
            if (.not. allocated(error)) call archive%put(group, 'fixed', merge(1, 0, model%fixed_fields()), &
                stored_int8, '', '1 where a field (u1 u3 y1 y3 xi) is fixed', error)
            if (.not. allocated(error)) call archive%put(group, 'thickness', model%sections(mesh%section)%h, &
                model%units%length, 'thickness h of every element', error)
            if (model%points_are_chosen .and. .not. allocated(error)) call archive%put(group, 'points', &
                model%sections(mesh%section)%points, stored_int32, '', &
                'Gauss points through the thickness of every element, as chosen by rule=auto', error)
        end associate
    end subroutine write_mesh

end module gb_results_header
