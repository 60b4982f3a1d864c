!> What the commands of a deck do to the problem: each is handed to whoever knows what it means.
module gb_build_command
    use gb_build_history, only: build_history
    use gb_build_loads, only: build_support, build_prescribed, build_point_load, build_distributed_load, &
        build_gravity, build_initial, build_damping
    use gb_build_model, only: build_units, build_material, build_section, build_line
    use gb_build_tasks, only: build_probe, build_output, build_checkpoint, build_task
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t
    use gb_draft, only: draft_t, resize, space_material, space_section, space_history, space_probe
    implicit none
    private

    public :: build_command

contains

    !> Hand a command to whoever knows what it means.
    subroutine build_command(command, name, draft, diagnostics)
        type(command_t), intent(inout) :: command
        character(*), intent(in) :: name
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics

        if (command%form == 0) then
            call remember_loss(command, name, draft, diagnostics)
            return
        end if
        select case (name)
        case ('UNITS')
            call build_units(command, draft)
        case ('MATERIAL')
            call build_material(command, draft, diagnostics)
        case ('SECTION')
            call build_section(command, draft, diagnostics)
        case ('LINE')
            call build_line(command, draft, diagnostics)
        case ('CLAMP', 'PIN', 'ROLLER', 'SLIDE', 'FIX')
            call build_support(command, draft)
        case ('PRESCRIBE')
            call build_prescribed(command, draft, diagnostics)
        case ('POINT')
            call build_point_load(command, draft, diagnostics)
        case ('DISTRIBUTED')
            call build_distributed_load(command, draft, diagnostics)
        case ('GRAVITY')
            call build_gravity(command, draft, diagnostics)
        case ('HISTORY')
            call build_history(command, draft, diagnostics)
        case ('INITIAL')
            call build_initial(command, draft, diagnostics)
        case ('DAMPING')
            call build_damping(command, draft)
        case ('PROBE')
            call build_probe(command, draft, diagnostics)
        case ('OUTPUT')
            call build_output(command, draft, diagnostics)
        case ('CHECKPOINT')
            call build_checkpoint(command, draft, diagnostics)
        case ('STATIC', 'MODAL', 'TRANSIENT')
            call build_task(command, draft, diagnostics)
        end select
    end subroutine build_command

    !> A command whose form is not known still defines its name, so that nobody is told that it is unknown.
    subroutine remember_loss(command, name, draft, diagnostics)
        type(command_t), intent(in) :: command
        character(*), intent(in) :: name
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        integer :: number

        select case (name)
        case ('MATERIAL')
            call draft%define(space_material, command, diagnostics, number)
            if (number > 0) call resize(draft%problem%model%materials, number)
        case ('SECTION')
            call draft%define(space_section, command, diagnostics, number)
            if (number > 0) call resize(draft%problem%model%sections, number)
        case ('HISTORY')
            call draft%define(space_history, command, diagnostics, number)
            if (number > 0) call resize(draft%problem%model%histories, number)
        case ('PROBE')
            call draft%define(space_probe, command, diagnostics, number)
            if (number > 0) call resize(draft%problem%probes, number)
        case ('PRESCRIBE')
            draft%supports_lost = .true.
        end select
    end subroutine remember_loss

end module gb_build_command
