!> The head of the log: what the program has understood of the deck.
module gb_summary
    use gb_kinds, only: wp
    use gb_text, only: to_text
    use gb_fields, only: n_fields, field_names
    use gb_section, only: material_t, section_t, rule_gauss, unlimited_jm, inertia_names
    use gb_model, only: model_t
    use gb_problem, only: problem_t
    use gb_log, only: log_t
    use gb_version, only: program_version
    implicit none
    private

    public :: print_summary

contains

    subroutine print_summary(problem, log)
        type(problem_t), intent(in) :: problem
        type(log_t), intent(inout) :: log
        integer :: i

        associate (model => problem%model)
            call log%line('gentbeam ' // program_version)
            if (len(model%title) > 0) call log%line(model%title)
            call log%line('')
            do i = 1, size(model%materials)
                call log%line('  material ' // material_words(model%materials(i)))
            end do
            do i = 1, size(model%sections)
                call log%line('  section ' // section_words(model%sections(i)))
                if (model%sections(i)%rule == rule_gauss .and. model%sections(i)%points < 3) then
                    call log%line('  warning: with fewer than 3 points a pattern of u3 and xi costs no ' &
                        // 'energy; the answer may drift with the mesh')
                end if
            end do
            do i = 1, size(model%lines)
                associate (line => model%lines(i))
                    call log%line('  line from ' // to_text(line%from) // ' to ' // to_text(line%to) &
                        // ': ' // to_text(line%elements) // ' elements of ' // to_text(line%nodes) &
                        // ' nodes, ' // trim(merge('full   ', 'reduced', line%full_integration)) &
                        // ' integration, ' // model%materials(line%material)%name // ', ' &
                        // model%sections(line%section)%name)
                end associate
            end do
            call log%line('  ' // to_text(model%mesh%n_nodes()) // ' nodes, ' &
                // to_text(n_fields*model%mesh%n_nodes()) // ' unknowns, ' &
                // to_text(count(model%fixed_fields())) // ' of them held')
            call print_supports(model, log)
            call log%line('  loads: ' // listed(counted(size(model%point_loads), 'point') &
                // counted(size(model%distributed_loads), 'distributed') // counted(size(model%gravity), &
                'gravity') // counted(size(model%prescribed), 'prescribed') // counted(size(model%initial), &
                'initial')))
            if (model%damping%mass > 0.0_wp .or. model%damping%stiffness > 0.0_wp) then
                call log%line('  damping: mass ' // to_text(model%damping%mass) // ', stiffness ' &
                    // to_text(model%damping%stiffness))
            end if
            call log%line('  ' // number_of(size(problem%probes), 'probe') // ', ' &
                // number_of(size(problem%tasks), 'solution command'))
        end associate
    end subroutine print_summary

    !> "1 probe", "2 probes".
    pure function number_of(number, what) result(text)
        integer, intent(in) :: number
        character(*), intent(in) :: what
        character(:), allocatable :: text

        text = to_text(number) // ' ' // what
        if (number /= 1) text = text // 's'
    end function number_of

    !> What `counted` has put together, or "none".
    pure function listed(parts) result(text)
        character(*), intent(in) :: parts
        character(:), allocatable :: text

        text = 'none'
        if (len(parts) > 0) text = parts(3:)
    end function listed

    !> ", 2 point", or nothing where there are none.
    pure function counted(number, what) result(text)
        integer, intent(in) :: number
        character(*), intent(in) :: what
        character(:), allocatable :: text

        text = ''
        if (number > 0) text = ', ' // to_text(number) // ' ' // what
    end function counted

    function material_words(material) result(text)
        type(material_t), intent(in) :: material
        character(:), allocatable :: text

        text = material%name // ': mu ' // to_text(material%mu) // ', c ' // to_text(material%c) &
            // ', beta ' // to_text(material%beta) // ', jm '
        if (material%jm >= unlimited_jm) then
            text = text // 'infinite'
        else
            text = text // to_text(material%jm)
        end if
        text = text // ', rho ' // to_text(material%rho) // ' (small strain: E ' &
            // to_text(material%fibre_modulus()) // ', nu ' // to_text(material%poisson_ratio()) // ')'
    end function material_words

    function section_words(section) result(text)
        type(section_t), intent(in) :: section
        character(:), allocatable :: text

        text = section%name // ': b ' // to_text(section%b) // ', h ' // to_text(section%h) // ', rule '
        if (section%is_auto) then
            text = text // 'auto, tolerance ' // to_text(section%tolerance)
        else if (section%rule == rule_gauss) then
            text = text // 'gauss, ' // to_text(section%points) // ' points'
        else
            text = text // 'linear (does not conserve energy exactly)'
        end if
        text = text // ', inertia ' // trim(inertia_names(section%inertia))
    end function section_words

    subroutine print_supports(model, log)
        type(model_t), intent(in) :: model
        type(log_t), intent(inout) :: log
        character(:), allocatable :: text
        integer :: i, field

        do i = 1, size(model%supports)
            text = '  support at x = ' // to_text(model%supports(i)%x) // ':'
            do field = 1, n_fields
                if (model%supports(i)%fixed(field)) text = text // ' ' // field_names(field)
            end do
            call log%line(text)
        end do
    end subroutine print_supports

end module gb_summary
