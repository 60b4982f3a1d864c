!> Materials, sections and lines of the deck.
module gb_build_model
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t
    use gb_draft, only: draft_t, line_place_t, resize, space_material, space_section
    use gb_kinds, only: wp
    use gb_mesh, only: line_t
    use gb_section, only: material_t, section_t, rule_gauss, rule_linear, inertia_diagonal, &
        inertia_translational, inertia_full, unlimited_jm
    use gb_text, only: to_text
    implicit none
    private

    public :: build_units, build_material, build_section, build_line

contains

    pure subroutine build_units(command, draft)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft

        if (.not. command%sound) return
        draft%problem%model%units%length = command%text('length')
        draft%problem%model%units%force = command%text('force')
        draft%problem%model%units%time = command%text('time')
    end subroutine build_units

    subroutine build_material(command, draft, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(material_t) :: material
        integer :: number

        if (command%sound) call read_material(command, material, diagnostics)
        call draft%define(space_material, command, diagnostics, number)
        if (number == 0) return
        call resize(draft%problem%model%materials, number)
        material%name = command%name
        draft%problem%model%materials(number) = material
    end subroutine build_material

    subroutine read_material(command, material, diagnostics)
        type(command_t), intent(inout) :: command
        type(material_t), intent(inout) :: material
        type(diagnostics_t), intent(inout) :: diagnostics

        material%beta = command%number('beta')
        material%rho = command%number('rho')
        select case (command%title)
        case ('MATERIAL elastic')
            call read_elastic(command, material, diagnostics)
        case ('MATERIAL gent')
            material%mu = command%number('mu')
            material%c = command%number('c')
            material%jm = command%number('jm')
        case default
            material%mu = command%number('mu')
            material%c = command%number('c')
        end select
    end subroutine read_material

    !> mu and c from Young's modulus and Poisson's ratio (plane stress), so that these hold at small strain
    !> whatever jm is: the first Lame modulus is c + 2 mu/jm.
    subroutine read_elastic(command, material, diagnostics)
        type(command_t), intent(inout) :: command
        type(material_t), intent(inout) :: material
        type(diagnostics_t), intent(inout) :: diagnostics
        real(wp) :: e, nu

        e = command%number('e')
        nu = command%number('nu')
        material%jm = unlimited_jm
        if (command%given('jm')) material%jm = command%number('jm')
        material%mu = e/(2.0_wp*(1.0_wp + nu))
        material%c = -1.0_wp
        ! Below this limit mu/jm would overflow; c is far below zero there.
        if (material%jm > 1.0e-300_wp*material%mu) &
            material%c = e*nu/(1.0_wp - nu**2) - 2.0_wp*(material%mu/material%jm)
        if (material%c > 0.0_wp) return
        if (nu > 0.0_wp) then
            call diagnostics%add(command%place('jm'), &
                'with this jm, c = e nu/(1-nu^2) - 2 mu/jm is not above 0', &
                                 hint='use MATERIAL gent, which takes mu and c; or jm above ' // &
                                 to_text((1.0_wp - nu)/nu, 4))
        else
            call diagnostics%add(command%place('nu'), &
                'with this nu, c = e nu/(1-nu^2) - 2 mu/jm is not above 0', &
                                 hint='use MATERIAL gent, which takes mu and c')
        end if
        command%sound = .false.
    end subroutine read_elastic

    subroutine build_section(command, draft, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(section_t) :: section
        integer :: number

        if (command%sound) call read_section(command, section, diagnostics)
        call draft%define(space_section, command, diagnostics, number)
        if (number == 0) return
        call resize(draft%problem%model%sections, number)
        section%name = command%name
        draft%problem%model%sections(number) = section
    end subroutine build_section

    subroutine read_section(command, section, diagnostics)
        type(command_t), intent(inout) :: command
        type(section_t), intent(inout) :: section
        type(diagnostics_t), intent(inout) :: diagnostics

        section%b = command%number('b')
        section%h = command%number('h')
        section%points = command%whole('points')
        section%rule = rule_gauss
        if (command%text('rule') == 'linear') section%rule = rule_linear
        section%inertia = inertia_diagonal
        section%inertia_is_given = command%given('inertia')
        if (command%text('inertia') == 'translational') section%inertia = inertia_translational
        if (command%text('inertia') == 'full') section%inertia = inertia_full
        if (command%given('points') .and. command%text('rule') /= 'gauss') then
            call diagnostics%add(command%values(command%value_of('points'))%key_at, &
                "'points' goes with rule=gauss")
            command%sound = .false.
        end if
        section%is_auto = command%text('rule') == 'auto'
        section%tolerance = command%number('tolerance')
        if (command%given('tolerance') .and. .not. section%is_auto) then
            call diagnostics%add(command%values(command%value_of('tolerance'))%key_at, &
                "'tolerance' goes with rule=auto")
            command%sound = .false.
        end if
    end subroutine read_section

    !> A line joins the model whatever became of its neighbours; how they join is looked at when the model is
    !> closed.
    subroutine build_line(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(line_t) :: line
        logical :: sound, excused(2)

        excused = .false.
        call find_part(command, 'material', space_material, draft, diagnostics, line%material, excused(1))
        call find_part(command, 'section', space_section, draft, diagnostics, line%section, excused(2))
        sound = command%sound .and. .not. any(excused)
        if (command%sound) then
            line%from = command%number('from')
            line%to = command%number('to')
            line%elements = command%whole('elements')
            line%nodes = command%whole('nodes')
            line%full_integration = command%text('integration') == 'full'
            line%grading = command%number('grading')
            if (line%to <= line%from) then
                call diagnostics%add(command%place('to'), "'to' must be beyond 'from', and " // &
                                     to_text(line%to, 12) // ' is not beyond ' // to_text(line%from, 12))
                sound = .false.
            end if
        end if
        if (.not. sound) draft%lines_lost = .true.
        draft%n_lines = draft%n_lines + 1
        call resize(draft%problem%model%lines, draft%n_lines)
        call resize(draft%line_places, draft%n_lines)
        draft%problem%model%lines(draft%n_lines) = line
        draft%line_places(draft%n_lines) = line_place_t(command%at, command%place('from'), &
            command%place('to'), excused)
    end subroutine build_line

    !> Number of the material or section a line names; 0 where it names none.
    subroutine find_part(command, key, space, draft, diagnostics, number, excused)
        type(command_t), intent(in) :: command
        character(*), intent(in) :: key
        integer, intent(in) :: space
        type(draft_t), intent(in) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        integer, intent(out) :: number
        logical, intent(out) :: excused         !! it names one, but in vain

        number = 0
        excused = .false.
        if (.not. command%given(key)) return
        if (len(command%text(key)) > 0) call draft%resolve(space, command%text(key), command%place(key), &
            diagnostics, number)
        excused = number == 0
    end subroutine find_part

end module gb_build_model
