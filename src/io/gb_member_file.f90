!> The group of one member of a study in the results file: what a run of that member alone would hold.
module gb_member_file
    use gb_kinds, only: wp
    use gb_archive, only: archive_t, stored_int32
    use gb_error, only: error_t
    use gb_fields, only: n_fields, field_length_power
    use gb_member, only: member_t, command_record_t, member_complete
    use gb_mesh, only: mesh_t
    use gb_problem, only: problem_t, task_t, task_modal
    use gb_results_header, only: write_mesh
    use gb_results_task, only: write_task_attributes, write_mode_shapes, n_energies, n_solver, energy_names, &
        energy_descriptions, solver_names, solver_descriptions, set_names, set_descriptions, abscissa_name, &
        abscissa_unit, probe_description, product_unit, derived_unit, field_units
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
    subroutine write_member(archive, parent, name, member, mesh, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: parent
        character(*), intent(in) :: name
        type(member_t), intent(in) :: member
        type(mesh_t), intent(in) :: mesh
        type(error_t), allocatable, intent(out) :: error
        integer :: group, mesh_group, i

        call archive%add_group(parent, name, group)
        call archive%set(group, 'status', trim(merge('complete', 'failed  ', &
            member%outcome == member_complete)))
        call archive%set(group, 'message', member%message)
        if (.not. allocated(member%problem)) return
        if (.not. same_mesh(member%problem%model%mesh, mesh)) call write_mesh(archive, group, &
            member%problem%model, mesh_group, error)
        do i = 1, size(member%commands)
            if (.not. allocated(error)) call write_command(archive, group, member%problem, i, &
                member%commands(i), error)
        end do
    end subroutine write_member

    pure logical function same_mesh(one, other)
        type(mesh_t), intent(in) :: one, other

        same_mesh = .false.
        if (size(one%x) /= size(other%x) .or. size(one%nodes) /= size(other%nodes)) return
        same_mesh = all(one%nodes == other%nodes) .and. .not. any(abs(one%x - other%x) > 0.0_wp)
    end function same_mesh

    subroutine write_command(archive, parent, problem, number, record, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: parent
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number
        type(command_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error
        integer :: group

        associate (task => problem%tasks(number))
            call archive%add_group(parent, task%name, group)
            call write_task_attributes(archive, group, task, number)
            if (task%kind == task_modal) then
                if (allocated(record%frequency)) call write_mode_shapes(archive, group, problem%model%units, &
                    record%frequency, record%modes, error)
            else
                call write_rows(archive, group, problem, task, record, error)
                if (.not. allocated(error)) call write_series(archive, group, problem, task, record, error)
            end if
        end associate
    end subroutine write_command

    !> The rows that OUTPUT every= keeps.
    subroutine write_rows(archive, group, problem, task, record, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: group
        type(problem_t), intent(in) :: problem
        type(task_t), intent(in) :: task
        type(command_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error

        if (record%rows == 0) return
        call archive%put(group, 'time', record%row_abscissa(:record%rows), &
            abscissa_unit(task, problem%model%units), abscissa_name(task) // ' of every row', error)
        if (allocated(record%u) .and. .not. allocated(error)) call put_fields(1, record%u)
        if (allocated(record%v) .and. .not. allocated(error)) call put_fields(2, record%v)
        if (allocated(record%a) .and. .not. allocated(error)) call put_fields(3, record%a)

    contains

        !> u, v or a (set = 1, 2, 3).
        subroutine put_fields(set, values)
            integer, intent(in) :: set
            real(wp), intent(in) :: values(n_fields, problem%model%mesh%n_nodes(), record%rows)

            call archive%put(group, set_names(set), values, field_units(problem%model%units, set), &
                trim(set_descriptions(set)), error)
        end subroutine put_fields

    end subroutine write_rows

    !> What is kept of every step.
    subroutine write_series(archive, parent, problem, task, record, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: parent
        type(problem_t), intent(in) :: problem
        type(task_t), intent(in) :: task
        type(command_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: unit, time_unit
        integer :: group, i

        if (record%steps == 0) return
        associate (n => record%steps, units => problem%model%units)
            time_unit = abscissa_unit(task, units)
            call archive%add_group(parent, 'probes', group)
            call archive%put(group, 'time', record%abscissa(:n), time_unit, abscissa_name(task) &
                // ' of every step', error)
            do i = 1, size(problem%probes)
                if (allocated(error)) return
                associate (probe => problem%probes(i))
                    unit = derived_unit(units, field_length_power(probe%field), probe%quantity)
                    call archive%put(group, probe%name, record%probes(:n, i), unit, &
                        probe_description(probe), error)
                end associate
            end do
            unit = product_unit(units%force, units%length)
            call archive%add_group(parent, 'energy', group)
            do i = 1, n_energies
                if (.not. allocated(error)) call archive%put(group, trim(energy_names(i)), &
                    record%energies(:n, i), unit, trim(energy_descriptions(i)), error)
            end do
            call archive%add_group(parent, 'solver', group)
            do i = 1, n_solver
                unit = ''
                if (i == 3) unit = time_unit
                if (allocated(error)) return
                if (i <= 2) then
                    call archive%put(group, trim(solver_names(i)), nint(record%solver(:n, i)), stored_int32, &
                        unit, trim(solver_descriptions(i)), error)
                else
                    call archive%put(group, trim(solver_names(i)), record%solver(:n, i), unit, &
                        trim(solver_descriptions(i)), error)
                end if
            end do
        end associate
    end subroutine write_series

end module gb_member_file
