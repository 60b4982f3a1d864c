!> What the results file says of how `auto` came to its choice: /tuning.
module gb_results_tuning
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_archive, only: archive_t, root, stored_int32
    use gb_problem, only: problem_t
    use gb_section, only: inertia_names
    use gb_tuning, only: tuning_t, n_sources, source_names
    implicit none
    private

    public :: write_tuning

contains

    subroutine write_tuning(archive, problem, error)
        type(archive_t), intent(inout) :: archive
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        integer :: group, i

        associate (tuning => problem%tuning)
            call archive%add_group(root, 'tuning', group)
            call archive%set(group, 'accuracy', tuning%accuracy)
            call archive%set(group, 'estimate', tuning%estimate)
            do i = 1, n_sources
                call archive%set(group, 'error_' // trim(source_names(i)), tuning%parts(i))
            end do
            call archive%set(group, 'elements', tuning%chosen%n_elements())
            call archive%set(group, 'nodes', tuning%chosen%nodes)
            call archive%set(group, 'points', tuning%chosen%points)
            call archive%set(group, 'inertia', trim(inertia_names(tuning%chosen%inertia)))
            call archive%set(group, 'scheme', trim(tuning%chosen%scheme))
            call archive%set(group, 'steps', tuning%chosen%n_steps())
            if (tuning%chosen%local > 0.0_wp) call archive%set(group, 'local_accuracy', tuning%chosen%local)
        end associate
        call write_rungs(archive, group, problem%tuning, error)
        if (.not. allocated(error)) call write_bars(archive, group, problem, error)
    end subroutine write_tuning

    !> Every setting that was tried, in order.
    subroutine write_rungs(archive, parent, tuning, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: parent
        type(tuning_t), intent(in) :: tuning
        type(error_t), allocatable, intent(out) :: error
        integer :: group, i, node
        character(:), allocatable :: words

        call archive%add_group(parent, 'rungs', group)
        associate (rungs => tuning%rungs)
            call put_whole('elements', [(rungs(i)%setting%n_elements(), i=1, size(rungs))], &
                'elements of the mesh')
            call put_whole('nodes', rungs%setting%nodes, 'nodes of an element')
            call put_whole('points', rungs%setting%points, 'Gauss points through the thickness')
            call put_whole('inertia', rungs%setting%inertia, '1 diagonal, 2 translational, 3 full')
            call put_whole('steps', rungs%steps, 'steps of the commands that are tuned')
            call put_whole('compared_with', rungs%compared_with, 'another rung, counted from 1; 0: none')
            call put_whole('failed', [(merge(1, 0, len(rungs(i)%failure) > 0), i=1, size(rungs))], &
                '1 where it came to no end')
            call put_number('change', rungs%change, '', 'largest relative change of a probe against it')
            call put_number('work', rungs%work, '', &
                'elements times Newton iterations, by what they cost in the block solver')
            call put_number('cpu_seconds', rungs%cpu_seconds, 's', 'CPU time')
            words = ''
            do i = 1, size(rungs)
                if (i > 1) words = words // ' '
                words = words // trim(rungs(i)%source)
            end do
            if (.not. allocated(error)) call archive%put_text(group, 'source', words, '', &
                'what every rung looks at: footing, mesh, time, thickness or inertia', node)
        end associate

    contains

        subroutine put_whole(name, values, description)
            character(*), intent(in) :: name, description
            integer, intent(in) :: values(:)

            if (.not. allocated(error)) call archive%put(group, name, values, stored_int32, '', description, &
                error)
        end subroutine put_whole

        subroutine put_number(name, values, unit, description)
            character(*), intent(in) :: name, unit, description
            real(wp), intent(in) :: values(:)

            if (.not. allocated(error)) call archive%put(group, name, values, unit, description, error)
        end subroutine put_number

    end subroutine write_rungs

    !> The estimate as error bars: of every probe that was named, in every command.
    subroutine write_bars(archive, parent, problem, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: parent
        type(problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error
        integer :: group, i

        call archive%add_group(parent, 'error_bars', group)
        do i = 1, size(problem%tuning%bars)
            associate (bar => problem%tuning%bars(i))
                call archive%put(group, problem%tasks(bar%task)%name // '.' &
                    // problem%probes(bar%probe)%name, [bar%absolute, bar%relative], '', &
                    'estimated error of the probe, root mean square: in its unit, and relative', error)
                if (allocated(error)) return
            end associate
        end do
    end subroutine write_bars

end module gb_results_tuning
