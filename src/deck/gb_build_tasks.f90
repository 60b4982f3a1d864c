!> What is asked about the model: probes, output and the solution commands of the deck.
module gb_build_tasks
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t, quoted
    use gb_draft, only: draft_t, resize, space_probe, space_task
    use gb_fields, only: n_fields, field_names
    use gb_kinds, only: wp
    use gb_names, only: is_name
    use gb_parser, only: name_rule
    use gb_problem, only: probe_t, task_t, safeguard_t, task_static, task_modal, task_transient, &
        quantity_displacement, quantity_velocity, quantity_acceleration
    use gb_solver_choice, only: solver_lapack, solver_block, block_obstacle
    use gb_section, only: rule_linear, inertia_diagonal, inertia_translational, inertia_full
    use gb_text, only: lower_case, to_text
    implicit none
    private

    public :: build_probe, build_output, build_checkpoint, build_task

    !> Groups of the results file that no command may take for its own.
    character(6), parameter :: reserved_names(6) = [character(6) :: 'deck', 'units', 'mesh', 'sweep', &
        'tuning', 'vtkhdf']
    real(wp), parameter :: most_steps = 1.0e9_wp

contains

    subroutine build_probe(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(probe_t) :: probe
        integer :: number, i

        if (lower_case(command%name) == 'time') then
            call diagnostics%add(command%name_at, quoted(command%name) // &
                                 ' is a name of the results file itself: choose another')
            return
        end if
        call draft%define(space_probe, command, diagnostics, number)
        if (number == 0) return
        probe%name = command%name
        if (command%sound) then
            probe%x = command%number('x')
            select case (command%words(1)(1:1))
            case ('v')
                probe%quantity = quantity_velocity
            case ('a')
                probe%quantity = quantity_acceleration
            case default
                probe%quantity = quantity_displacement
            end select
            do i = 1, n_fields
                if (command%words(1) == field_names(i)) probe%field = i
                ! v3 and a3 belong to u3.
                if (probe%quantity == quantity_displacement) cycle
                if ('u' // command%words(1)(2:2) == field_names(i)) probe%field = i
            end do
            call draft%add_place(command%place('x'), probe%x, at_node=.false.)
        end if
        call resize(draft%problem%probes, number)
        draft%problem%probes(number) = probe
    end subroutine build_probe

    subroutine build_output(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: file

        if (.not. command%sound) return
        associate (output => draft%problem%output)
            if (command%given('file')) then
                file = command%text('file')
                if (len(file) > 3) then
                    if (lower_case(file(len(file) - 2:)) == '.h5') file = file(:len(file) - 3)
                end if
                if (len_trim(file) == 0 .or. index(file, '/', back=.true.) == len(file)) then
                    call diagnostics%add(command%place('file'), 'the name of the results file is empty')
                    return
                end if
                output%file = file
            end if
            output%every = command%whole('every')
            associate (words => command%values(command%value_of('fields')))
                output%u = any(words%words == 'u')
                output%v = any(words%words == 'v')
                output%a = any(words%words == 'a')
                output%strain = any(words%words == 'strain')
                output%stress = any(words%words == 'stress')
                if (size(words%words) > 1 .and. any(words%words == 'none')) &
                    call diagnostics%add(words%at, "'none' stands alone")
            end associate
        end associate
    end subroutine build_output

    !> CHECKPOINT holds for the commands that follow, until the next one.
    subroutine build_checkpoint(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: file

        if (.not. command%sound) return
        draft%safeguard = safeguard_t()
        if (command%given('every')) draft%safeguard%every = command%whole('every')
        if (command%given('seconds')) draft%safeguard%seconds = command%number('seconds')
        if (.not. command%given('file')) return
        file = command%text('file')
        if (len_trim(file) == 0 .or. index(file, '/', back=.true.) == len(file)) then
            call diagnostics%add(command%place('file'), 'the name of the checkpoint file is empty')
        else
            draft%safeguard%file = file
        end if
    end subroutine build_checkpoint

    !> STATIC, MODAL and TRANSIENT.
    subroutine build_task(command, draft, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(task_t) :: task
        integer :: number

        task%safeguard = draft%safeguard
        call find_name(command, draft, diagnostics)
        if (command%sound) then
            select case (command%title)
            case ('STATIC', 'STATIC auto')
                call read_static(command, draft, task, diagnostics)
            case ('MODAL')
                call read_modal(command, draft, task, diagnostics)
            case default
                call read_transient(command, draft, task, diagnostics)
            end select
        end if
        call draft%define(space_task, command, diagnostics, number)
        if (number == 0) return
        call resize(draft%problem%tasks, number)
        task%name = command%name
        draft%problem%tasks(number) = task
    end subroutine build_task

    !> The name of the command's results: the given one, or the default with the first number that is free.
    subroutine find_name(command, draft, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: default
        integer :: kind

        command%name_at = command%place('name')
        if (command%given('name')) then
            command%name = command%text('name')
            if (len_trim(command%name) == 0) return
            if (.not. is_name(command%name, hyphens=.true.)) then
                call diagnostics%add(command%name_at, quoted(command%name) // ' is not a name', &
                    hint=name_rule)
                command%sound = .false.
            else if (any(reserved_names == lower_case(command%name))) then
                call diagnostics%add(command%name_at, quoted(command%name) // &
                                     ' is a name of the results file itself: choose another')
                command%sound = .false.
            end if
            return
        end if
        default = command%text('name')
        select case (default)
        case ('static')
            kind = task_static
        case ('modal')
            kind = task_modal
        case default
            kind = task_transient
        end select
        do
            draft%repeats(kind) = draft%repeats(kind) + 1
            command%name = default
            if (draft%repeats(kind) > 1) command%name = default // '_' // to_text(draft%repeats(kind))
            if (draft%names(space_task)%find(command%name) == 0) exit
        end do
    end subroutine find_name

    subroutine read_static(command, draft, task, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(in) :: draft
        type(task_t), intent(inout) :: task
        type(diagnostics_t), intent(inout) :: diagnostics

        task%kind = task_static
        task%load = command%number('load')
        if (command%title == 'STATIC auto') then
            call read_auto(command, draft, task, diagnostics)
        else
            task%steps = command%whole('steps')
            call read_newton(command, task)
            if (draft%has_mesh) call check_solver(command, draft, task, diagnostics)
        end if
        if (len(draft%loose) == 0) return
        call diagnostics%add(command%at, 'STATIC needs supports that hold the beam: ' // draft%loose)
        command%sound = .false.
    end subroutine read_static

    subroutine read_modal(command, draft, task, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(in) :: draft
        type(task_t), intent(inout) :: task
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: free

        task%kind = task_modal
        task%count = command%whole('count')
        if (.not. draft%has_mesh) return
        free = count_moving(draft)
        if (task%count <= free) return
        call diagnostics%add(command%place('count'), "'count' is " // to_text(task%count) // &
                             ', and the model has no more than ' // to_text(free) // ' modes')
        command%sound = .false.
    end subroutine read_modal

    !> Fields that are free and carry mass: so many modes there are.
    integer function count_moving(draft) result(n)
        type(draft_t), intent(in) :: draft
        logical, allocatable :: fixed(:, :), massive(:)
        integer :: e, first

        associate (model => draft%problem%model)
            allocate (fixed, source=model%fixed_fields())
            allocate (massive(model%mesh%n_nodes()))
            massive = .false.
            do e = 1, model%mesh%n_elements()
                if (model%sections(model%mesh%section(e))%inertia == inertia_translational) cycle
                first = model%mesh%first_node(e)
                massive(first:first + model%mesh%nodes(e) - 1) = .true.
            end do
        end associate
        n = count(.not. fixed(1:2, :)) + count(.not. fixed(3:5, :) .and. spread(massive, 1, 3))
    end function count_moving

    subroutine read_transient(command, draft, task, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(in) :: draft
        type(task_t), intent(inout) :: task
        type(diagnostics_t), intent(inout) :: diagnostics

        task%kind = task_transient
        task%scheme = trim(command%title(11:))
        task%end_time = command%number('end')
        if (task%scheme == 'auto') then
            task%scheme = 'newmark'
            task%step = task%end_time
            call read_auto(command, draft, task, diagnostics)
            return
        end if
        if (command%given('step')) task%step = command%number('step')
        if (command%given('accuracy')) task%accuracy = command%number('accuracy')
        call read_newton(command, task)
        select case (task%scheme)
        case ('newmark')
            task%beta = command%number('beta')
            task%gamma = command%number('gamma')
        case ('hht')
            task%alpha = command%number('alpha')
        case ('generalized', 'bathe')
            task%rho = command%number('rho')
        end select
        call check_step(command, task, diagnostics)
        if (draft%has_mesh) call check_scheme(command, draft, task, diagnostics)
        if (draft%has_mesh) call check_solver(command, draft, task, diagnostics)
    end subroutine read_transient

    !> What a command that leaves mesh and steps to the program asks for.
    subroutine read_auto(command, draft, task, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(in) :: draft
        type(task_t), intent(inout) :: task
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: i

        task%is_auto = .true.
        task%aim = command%number('accuracy')
        associate (probes => command%values(command%value_of('probe')))
            allocate (task%aim_probes(size(probes%words)))
            do i = 1, size(probes%words)
                call draft%resolve(space_probe, trim(probes%words(i)), probes%parts(i), diagnostics, &
                    task%aim_probes(i))
                if (task%aim_probes(i) == 0) command%sound = .false.
                if (task%aim_probes(i) == 0 .or. all(task%aim_probes(:i - 1) /= task%aim_probes(i))) cycle
                call diagnostics%add(probes%parts(i), 'probe ' // quoted(trim(probes%words(i))) &
                    // ' is named twice')
                command%sound = .false.
            end do
        end associate
        if (draft%problem%sweep%members() == 0) return
        call diagnostics%add(command%at, command%title // ' does not go with SWEEP', &
            hint='run one member with it, without SWEEP, and give the settings that it chooses to all')
        command%sound = .false.
    end subroutine read_auto

    !> The energy-momentum scheme needs a stored energy and a constant mass, the explicit one a mass in every
    !> field.
    subroutine check_scheme(command, draft, task, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(in) :: draft
        type(task_t), intent(in) :: task
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: trouble, remedy
        logical :: linear, full, other
        integer :: i

        ! By the mesh, which END has made: a LINE behind it has no section.
        linear = .false.
        full = .false.
        other = .false.
        associate (model => draft%problem%model)
            do i = 1, size(model%sections)
                if (all(model%mesh%section /= i)) cycle
                linear = linear .or. model%sections(i)%rule == rule_linear
                full = full .or. model%sections(i)%inertia == inertia_full
                other = other .or. model%sections(i)%inertia /= inertia_diagonal
            end do
        end associate
        trouble = ''
        remedy = ''
        select case (task%scheme)
        case ('energy')
            if (linear) then
                trouble = 'TRANSIENT energy needs a stored energy, and rule=linear has none'
                remedy = 'use rule=gauss'
            else if (full) then
                trouble = 'TRANSIENT energy needs a constant mass, and inertia=full has none'
                remedy = 'use inertia=diagonal or inertia=translational'
            end if
        case ('central')
            if (other) then
                trouble = 'TRANSIENT central needs a constant mass in every field'
                remedy = 'use inertia=diagonal'
            else if (command%given('accuracy')) then
                trouble = 'TRANSIENT central has fixed steps, kept below its limit of stability'
                remedy = 'give step='
            end if
        end select
        if (len(trouble) == 0) return
        call diagnostics%add(command%at, trouble, hint=remedy)
        command%sound = .false.
    end subroutine check_scheme

    !> The block solver, where it is asked for, must be able to do the model and the scheme.
    subroutine check_solver(command, draft, task, diagnostics)
        type(command_t), intent(inout) :: command
        type(draft_t), intent(in) :: draft
        type(task_t), intent(in) :: task
        type(diagnostics_t), intent(inout) :: diagnostics
        character(:), allocatable :: reason

        if (task%solver /= solver_block) return
        reason = trim(block_obstacle(draft%problem%model))
        if (task%kind == task_transient .and. len(reason) == 0) then
            if (task%scheme == 'energy') reason = 'the tangent of the scheme energy is not symmetric'
            if (task%scheme == 'central') reason = 'the scheme central solves no equations'
        end if
        if (len(reason) == 0) return
        call diagnostics%add(command%place('solver'), 'solver=block cannot do this: ' // reason, &
                             hint='leave solver= away: what fits is chosen then')
        command%sound = .false.
    end subroutine check_solver

    subroutine check_step(command, task, diagnostics)
        type(command_t), intent(inout) :: command
        type(task_t), intent(in) :: task
        type(diagnostics_t), intent(inout) :: diagnostics
        real(wp), parameter :: rounding = 1.0e-9_wp

        if (command%given('step') .and. command%given('accuracy')) then
            call diagnostics%add(command%values(command%value_of('accuracy'))%key_at, &
                                 "'step' and 'accuracy' exclude each other")
        else if (command%given('accuracy')) then
            return
        else if (task%step > task%end_time*(1.0_wp + rounding)) then
            call diagnostics%add(command%place('step'), "'step' is " // to_text(task%step, 12) // &
                ", beyond 'end', " // to_text(task%end_time, 12))
        else if (task%step < task%end_time/most_steps) then
            call diagnostics%add(command%place('step'), 'more than ' // to_text(most_steps) // &
                                 " steps from here to 'end'")
        else
            return
        end if
        command%sound = .false.
    end subroutine check_step

    subroutine read_newton(command, task)
        type(command_t), intent(in) :: command
        type(task_t), intent(inout) :: task

        task%tolerance = command%number('tolerance')
        task%iterations = command%whole('iterations')
        task%cuts = command%whole('cuts')
        if (.not. command%given('solver')) return
        if (command%text('solver') == 'lapack') task%solver = solver_lapack
        if (command%text('solver') == 'block') task%solver = solver_block
    end subroutine read_newton

end module gb_build_tasks
