!> The group of one member of a study in the results file: what a run of that member alone would hold.
module gb_member_file
    use, intrinsic :: iso_c_binding, only: c_int8_t
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_fields, only: n_fields, field_length_power
    use gb_hdf5_direct, only: hid_t, create_group, close_group, put_attribute, put_array
    use gb_member, only: member_t, command_record_t, n_energies, n_solver, member_complete
    use gb_mesh, only: mesh_t, max_element_nodes
    use gb_problem, only: problem_t, task_t, task_static, task_modal, task_transient
    use gb_model, only: model_t
    use gb_results, only: probe_description, product_unit, derived_unit, field_units, energy_names, &
        energy_descriptions, solver_names, solver_descriptions, set_names, set_descriptions
    use gb_text, only: to_text
    implicit none
    private

    public :: write_member, member_name

contains

    !> Name of a member's group: its number with leading zeros, six digits or as many as the last one has.
    pure function member_name(number, members) result(name)
        integer, intent(in) :: number, members
        character(:), allocatable :: name
        integer :: width

        width = max(6, len(to_text(members)))
        name = to_text(number)
        name = repeat('0', width - len(name)) // name
    end function member_name

    !> Write a member into the group `parent`. Its mesh is written where it differs from `mesh`, the one that
    !> the file's own /mesh shows.
    subroutine write_member(parent, name, member, mesh, error)
        integer(hid_t), intent(in) :: parent
        character(*), intent(in) :: name
        type(member_t), intent(in) :: member
        type(mesh_t), intent(in) :: mesh
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: group
        integer :: i

        call create_group(parent, name, group, error)
        if (.not. allocated(error)) call put_attribute(group, 'status', trim(merge('complete', 'failed  ', &
            member%outcome == member_complete)), error)
        if (.not. allocated(error)) call put_attribute(group, 'message', member%message, error)
        if (allocated(error)) return
        if (allocated(member%problem)) then
            if (.not. same_mesh(member%problem%model%mesh, mesh)) call write_mesh(group, &
                member%problem%model, &
                error)
            do i = 1, size(member%commands)
                if (.not. allocated(error)) call write_command(group, member%problem, i, member%commands(i), &
                    error)
            end do
        end if
        call close_group(group)
    end subroutine write_member

    pure logical function same_mesh(one, other)
        type(mesh_t), intent(in) :: one, other

        same_mesh = .false.
        if (size(one%x) /= size(other%x) .or. size(one%nodes) /= size(other%nodes)) return
        same_mesh = all(one%nodes == other%nodes) .and. .not. any(abs(one%x - other%x) > 0.0_wp)
    end function same_mesh

    !> As gb_results_header writes it for the file.
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

    subroutine write_command(parent, problem, number, record, error)
        integer(hid_t), intent(in) :: parent
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number
        type(command_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: group

        associate (task => problem%tasks(number))
            call create_group(parent, task%name, group, error)
            if (.not. allocated(error)) call write_task_attributes(group, task, number, error)
            if (allocated(error)) return
            if (task%kind == task_modal) then
                call write_modes(group, problem, record, error)
            else
                call write_rows(group, problem, task, record, error)
                if (.not. allocated(error)) call write_series(group, problem, task, record, error)
            end if
        end associate
        call close_group(group)
    end subroutine write_command

    !> As gb_results writes them for a single run.
    subroutine write_task_attributes(group, task, order, error)
        integer(hid_t), intent(in) :: group
        type(task_t), intent(in) :: task
        integer, intent(in) :: order
        type(error_t), allocatable, intent(out) :: error

        call put_attribute(group, 'order', order, error)
        if (allocated(error)) return
        select case (task%kind)
        case (task_static)
            call put_attribute(group, 'kind', 'static', error)
            if (.not. allocated(error)) call put_attribute(group, 'scheme', 'newton', error)
            if (.not. allocated(error)) call put_attribute(group, 'steps', task%steps, error)
            if (.not. allocated(error)) call put_attribute(group, 'load', task%load, error)
        case (task_modal)
            call put_attribute(group, 'kind', 'modal', error)
            if (.not. allocated(error)) call put_attribute(group, 'scheme', 'subspace iteration', error)
        case (task_transient)
            call put_attribute(group, 'kind', 'transient', error)
            if (.not. allocated(error)) call put_attribute(group, 'scheme', task%scheme, error)
            if (.not. allocated(error)) call put_attribute(group, 'dt', task%step, error)
            if (.not. allocated(error) .and. task%accuracy > 0.0_wp) then
                call put_attribute(group, 'accuracy', task%accuracy, error)
            end if
            if (.not. allocated(error)) call put_attribute(group, 'end', task%end_time, error)
            if (.not. allocated(error)) call write_scheme_numbers(group, task, error)
        end select
        if (.not. allocated(error) .and. task%kind /= task_modal) call put_attribute(group, 'tolerance', &
            task%tolerance, error)
    end subroutine write_task_attributes

    subroutine write_scheme_numbers(group, task, error)
        integer(hid_t), intent(in) :: group
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        select case (task%scheme)
        case ('newmark')
            call put_attribute(group, 'beta', task%beta, error)
            if (.not. allocated(error)) call put_attribute(group, 'gamma', task%gamma, error)
        case ('hht')
            call put_attribute(group, 'alpha', task%alpha, error)
        case ('generalized', 'bathe')
            call put_attribute(group, 'rho', task%rho, error)
        end select
    end subroutine write_scheme_numbers

    subroutine write_modes(group, problem, record, error)
        integer(hid_t), intent(in) :: group
        type(problem_t), intent(in) :: problem
        type(command_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: unit

        if (.not. allocated(record%frequency)) return
        unit = ''
        if (len(problem%model%units%time) > 0) unit = '1/' // problem%model%units%time
        call put_array(group, 'frequency', record%frequency, unit, &
                       'natural frequencies, cycles a unit of time; negative for a mode that grows', error)
        if (allocated(error)) return
        call put_fields(group, 'modes', problem%model%mesh%n_nodes(), size(record%frequency), record%modes, &
            field_units(problem%model%units, 1), &
            'fields u1 u3 y1 y3 xi of every mode, largest displacement 1', error)
    end subroutine write_modes

    !> The rows that OUTPUT every= keeps.
    subroutine write_rows(group, problem, task, record, error)
        integer(hid_t), intent(in) :: group
        type(problem_t), intent(in) :: problem
        type(task_t), intent(in) :: task
        type(command_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error

        if (record%rows == 0) return
        associate (nodes => problem%model%mesh%n_nodes(), units => problem%model%units)
            call put_array(group, 'time', record%row_abscissa(:record%rows), time_unit(problem, task), &
                abscissa(task) // ' of every row', error)
            if (allocated(record%u) .and. .not. allocated(error)) call put_fields(group, set_names(1), &
                nodes, &
                record%rows, record%u, field_units(units, 1), trim(set_descriptions(1)), error)
            if (allocated(record%v) .and. .not. allocated(error)) call put_fields(group, set_names(2), &
                nodes, &
                record%rows, record%v, field_units(units, 2), trim(set_descriptions(2)), error)
            if (allocated(record%a) .and. .not. allocated(error)) call put_fields(group, set_names(3), &
                nodes, &
                record%rows, record%a, field_units(units, 3), trim(set_descriptions(3)), error)
        end associate
    end subroutine write_rows

    !> The first `rows` columns of a table, as (5, nodes, rows).
    subroutine put_fields(group, name, nodes, rows, values, unit, description, error)
        integer(hid_t), intent(in) :: group
        character(*), intent(in) :: name, unit, description
        integer, intent(in) :: nodes, rows
        real(wp), intent(in) :: values(n_fields, nodes, rows)
        type(error_t), allocatable, intent(out) :: error

        call put_array(group, name, values, unit, description, error)
    end subroutine put_fields

    !> What is kept of every step.
    subroutine write_series(parent, problem, task, record, error)
        integer(hid_t), intent(in) :: parent
        type(problem_t), intent(in) :: problem
        type(task_t), intent(in) :: task
        type(command_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: group
        character(:), allocatable :: energy_unit, unit
        integer :: i

        if (record%steps == 0) return
        associate (n => record%steps, units => problem%model%units)
            call create_group(parent, 'probes', group, error)
            if (.not. allocated(error)) call put_array(group, 'time', record%abscissa(:n), &
                time_unit(problem, task), abscissa(task) // ' of every step', error)
            do i = 1, size(problem%probes)
                associate (probe => problem%probes(i))
                    unit = derived_unit(units, field_length_power(probe%field), probe%quantity)
                    if (.not. allocated(error)) call put_array(group, probe%name, record%probes(:n, i), &
                        unit, &
                        probe_description(probe), error)
                end associate
            end do
            if (allocated(error)) return
            call close_group(group)
            energy_unit = product_unit(units%force, units%length)
            call create_group(parent, 'energy', group, error)
            do i = 1, n_energies
                if (.not. allocated(error)) call put_array(group, trim(energy_names(i)), &
                    record%energies(:n, i), energy_unit, trim(energy_descriptions(i)), error)
            end do
            if (allocated(error)) return
            call close_group(group)
            call create_group(parent, 'solver', group, error)
            do i = 1, n_solver
                unit = ''
                if (i == 3) unit = time_unit(problem, task)
                if (allocated(error)) return
                if (i <= 2) then
                    call put_array(group, trim(solver_names(i)), nint(record%solver(:n, i)), unit, &
                        trim(solver_descriptions(i)), error)
                else
                    call put_array(group, trim(solver_names(i)), record%solver(:n, i), unit, &
                        trim(solver_descriptions(i)), error)
                end if
            end do
            call close_group(group)
        end associate
    end subroutine write_series

    pure function time_unit(problem, task) result(unit)
        type(problem_t), intent(in) :: problem
        type(task_t), intent(in) :: task
        character(:), allocatable :: unit

        unit = ''
        if (task%kind /= task_static) unit = problem%model%units%time
    end function time_unit

    pure function abscissa(task) result(words)
        type(task_t), intent(in) :: task
        character(:), allocatable :: words

        words = 'time since the command began'
        if (task%kind == task_static) words = 'load factor'
    end function abscissa

end module gb_member_file
