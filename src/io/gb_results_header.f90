!> What the results file says of the run itself: deck, version, units, mesh.
module gb_results_header
    use, intrinsic :: iso_c_binding, only: c_int8_t
    use, intrinsic :: iso_fortran_env, only: compiler_version
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_version, only: program_version, git_revision
    use gb_mesh, only: max_element_nodes
    use gb_model, only: model_t, units_t
    use gb_problem, only: problem_t
    use gb_scene, only: scene_lines
    use gb_hdf5, only: hid_t, create_group, close_group, put_attribute, put_array, put_text, close_dataset
    implicit none
    private

    public :: write_header, write_units, write_mesh

contains

    subroutine write_header(file, problem, error)
        integer(hid_t), intent(in) :: file
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: dataset

        call put_attribute(file, 'format', 'gentbeam', error)
        if (.not. allocated(error)) call put_attribute(file, 'format_version', 1, error)
        if (.not. allocated(error)) call put_attribute(file, 'program_version', program_version, error)
        if (.not. allocated(error)) call put_attribute(file, 'git_revision', git_revision, error)
        if (.not. allocated(error)) call put_attribute(file, 'compiler', compiler_version(), error)
        if (.not. allocated(error)) call put_attribute(file, 'title', problem%model%title, error)
        if (.not. allocated(error)) call put_attribute(file, 'created', now(), error)
        if (.not. allocated(error)) call put_attribute(file, 'status', 'running', error)
        if (.not. allocated(error)) call put_attribute(file, 'message', '', error)
        if (.not. allocated(error)) call put_attribute(file, 'wall_seconds', 0.0_wp, error)
        if (.not. allocated(error)) call put_attribute(file, 'cpu_seconds', 0.0_wp, error)
        if (allocated(error)) return
        call put_text(file, 'deck', problem%deck_text, dataset, error)
        if (.not. allocated(error)) call put_attribute(dataset, 'parameters', problem%parameters, error)
        if (.not. allocated(error)) call put_attribute(dataset, 'scene', scene_lines(problem%model), error)
        if (.not. allocated(error)) call put_attribute(dataset, 'unit', '', error)
        if (.not. allocated(error)) call put_attribute(dataset, 'description', 'the deck as read', error)
        if (.not. allocated(error)) call close_dataset(dataset)
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

    subroutine write_units(file, units, error)
        integer(hid_t), intent(in) :: file
        type(units_t), intent(in) :: units
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: group

        call create_group(file, 'units', group, error)
        if (.not. allocated(error)) call put_attribute(group, 'length', units%length, error)
        if (.not. allocated(error)) call put_attribute(group, 'force', units%force, error)
        if (.not. allocated(error)) call put_attribute(group, 'time', units%time, error)
        if (.not. allocated(error)) call close_group(group)
    end subroutine write_units

    subroutine write_mesh(file, model, error)
        integer(hid_t), intent(in) :: file
        type(model_t), intent(in) :: model
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: group
        integer, allocatable :: elements(:, :)
        integer(c_int8_t), allocatable :: fixed(:, :)
        integer :: e, i

        associate (mesh => model%mesh)
            allocate (elements(max_element_nodes, mesh%n_elements()))
            elements = -1
            do e = 1, mesh%n_elements()
                elements(:mesh%nodes(e), e) = [(mesh%first_node(e) + i - 2, i=1, mesh%nodes(e))]
            end do
            fixed = merge(1_c_int8_t, 0_c_int8_t, model%fixed_fields())
            call create_group(file, 'mesh', group, error)
            if (allocated(error)) return
            call put_array(group, 'x', mesh%x, model%units%length, 'reference X1 of every node', error)
            if (.not. allocated(error)) call put_array(group, 'elements', elements, '', &
                'nodes of every element, counted from 0, -1 where unused', error)
            if (.not. allocated(error)) call put_array(group, 'fixed', fixed, '', &
                '1 where a field (u1 u3 y1 y3 xi) is fixed', error)
            if (.not. allocated(error)) call put_array(group, 'thickness', model%sections(mesh%section)%h, &
                model%units%length, 'thickness h of every element', error)
            if (.not. allocated(error)) call close_group(group)
        end associate
    end subroutine write_mesh

end module gb_results_header
