!> Supports, driven fields, loads, initial conditions and damping of the deck.
module gb_build_loads
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t, span_t
    use gb_draft, only: draft_t, resize, space_history
    use gb_fields, only: n_fields, field_names, field_u1, field_u3, field_y1, field_y3
    use gb_load, only: support_t, prescribed_t, point_load_t, distributed_load_t, gravity_t, initial_t, &
        stage_all, stage_static, stage_transient
    use gb_text, only: to_text
    implicit none
    private

    public :: build_support, build_prescribed, build_point_load, build_distributed_load, build_gravity, &
        build_initial, build_damping

contains

    !> CLAMP, PIN, ROLLER, SLIDE and FIX.
    subroutine build_support(command, draft)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(support_t) :: support
        integer :: i

        if (.not. command%sound) then
            draft%supports_lost = .true.
            return
        end if
        support%x = command%number('x')
        select case (command%title)
        case ('CLAMP')
            support%fixed = .true.
        case ('PIN')
            support%fixed([field_u1, field_u3]) = .true.
        case ('ROLLER')
            support%fixed(field_u3) = .true.
        case ('SLIDE')
            support%fixed([field_u1, field_y1, field_y3]) = .true.
        case default
            do i = 1, n_fields
                support%fixed(i) = any(command%words == field_names(i))
            end do
        end select
        draft%n_supports = draft%n_supports + 1
        call resize(draft%problem%model%supports, draft%n_supports)
        call resize(draft%support_places, draft%n_supports)
        draft%problem%model%supports(draft%n_supports) = support
        draft%support_places(draft%n_supports) = command%at
        call draft%add_place(command%place('x'), support%x, at_node=.true.)
    end subroutine build_support

    subroutine build_prescribed(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(prescribed_t) :: prescribed
        type(span_t), allocatable :: grown(:, :)
        integer :: i, number

        call find_history(command, draft, diagnostics, prescribed%history)
        if (.not. command%sound) then
            draft%supports_lost = .true.
            return
        end if
        prescribed%x = command%number('x')
        draft%n_prescribed = draft%n_prescribed + 1
        call resize(draft%problem%model%prescribed, draft%n_prescribed)
        if (draft%n_prescribed > size(draft%prescribed_places, 2)) then
            allocate (grown(n_fields, 2*draft%n_prescribed))
            grown(:, :draft%n_prescribed - 1) = draft%prescribed_places(:, :draft%n_prescribed - 1)
            call move_alloc(grown, draft%prescribed_places)
        end if
        do i = 1, n_fields
            prescribed%driven(i) = command%given(field_names(i))
            prescribed%value(i) = command%number(field_names(i))
            number = command%value_of(field_names(i))
            draft%prescribed_places(i, draft%n_prescribed) = command%values(number)%key_at
        end do
        draft%problem%model%prescribed(draft%n_prescribed) = prescribed
        call draft%add_place(command%place('x'), prescribed%x, at_node=.true.)
    end subroutine build_prescribed

    subroutine build_point_load(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(point_load_t) :: load

        call find_history(command, draft, diagnostics, load%history)
        if (.not. command%sound) return
        load%x = command%number('x')
        load%value = [command%number('f1'), command%number('f3'), command%number('m1'), command%number('m3')]
        load%stage = stage_of(command)
        draft%n_points = draft%n_points + 1
        call resize(draft%problem%model%point_loads, draft%n_points)
        draft%problem%model%point_loads(draft%n_points) = load
        call draft%add_place(command%place('x'), load%x, at_node=.true.)
    end subroutine build_point_load

    subroutine build_distributed_load(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(distributed_load_t) :: load

        call find_history(command, draft, diagnostics, load%history)
        if (.not. command%sound) return
        load%from = command%number('from')
        load%to = command%number('to')
        load%q = [command%number('q1'), command%number('q3')]
        load%stage = stage_of(command)
        if (load%to <= load%from) then
            call diagnostics%add(command%place('to'), "'to' must be beyond 'from', and " // &
                                 to_text(load%to, 12) // ' is not beyond ' // to_text(load%from, 12))
            return
        end if
        draft%n_distributed = draft%n_distributed + 1
        call resize(draft%problem%model%distributed_loads, draft%n_distributed)
        draft%problem%model%distributed_loads(draft%n_distributed) = load
        call draft%add_place(command%place('from'), load%from, at_node=.false.)
        call draft%add_place(command%place('to'), load%to, at_node=.false.)
    end subroutine build_distributed_load

    subroutine build_gravity(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(gravity_t) :: gravity

        call find_history(command, draft, diagnostics, gravity%history)
        if (.not. command%sound) return
        gravity%g = [command%number('g1'), command%number('g3')]
        gravity%stage = stage_of(command)
        draft%n_gravity = draft%n_gravity + 1
        call resize(draft%problem%model%gravity, draft%n_gravity)
        draft%problem%model%gravity(draft%n_gravity) = gravity
    end subroutine build_gravity

    !> INITIAL: a field may be given once as a displacement and once as a velocity.
    subroutine build_initial(command, draft, diagnostics)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(initial_t) :: initial
        integer :: i, before

        if (.not. command%sound) return
        initial%is_velocity = command%title == 'INITIAL velocity'
        do i = 1, n_fields
            if (.not. command%given(field_names(i))) cycle
            initial%field = i
            associate (value => command%values(command%value_of(field_names(i))), &
                list => draft%problem%model%initial)
                initial%formula = value%formula
                do before = 1, draft%n_initial
                    if (list(before)%field == i .and. (list(before)%is_velocity .eqv. initial%is_velocity)) &
                        exit
                end do
                if (before <= draft%n_initial) then
                    call diagnostics%add(value%key_at, command%title // ' of ' // field_names(i) // &
                                         ' is given twice', other=draft%initial_places(before), &
                                         note='first given here')
                    cycle
                end if
                draft%n_initial = draft%n_initial + 1
                call resize(draft%problem%model%initial, draft%n_initial)
                call resize(draft%initial_places, draft%n_initial)
                draft%problem%model%initial(draft%n_initial) = initial
                draft%initial_places(draft%n_initial) = value%at
            end associate
        end do
    end subroutine build_initial

    pure subroutine build_damping(command, draft)
        type(command_t), intent(in) :: command
        type(draft_t), intent(inout) :: draft

        if (.not. command%sound) return
        draft%problem%model%damping%mass = command%number('mass')
        draft%problem%model%damping%stiffness = command%number('stiffness')
    end subroutine build_damping

    !> Number of the history a load follows; 1, the built-in step, where it cannot be found.
    subroutine find_history(command, draft, diagnostics, number)
        type(command_t), intent(in) :: command
        type(draft_t), intent(in) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        integer, intent(out) :: number

        number = 1
        if (.not. command%given('history')) return
        if (len(command%text('history')) == 0) return
        call draft%resolve(space_history, command%text('history'), command%place('history'), diagnostics, &
            number)
        number = max(1, number)
    end subroutine find_history

    pure integer function stage_of(command) result(stage)
        type(command_t), intent(in) :: command

        select case (command%text('stage'))
        case ('static')
            stage = stage_static
        case ('transient')
            stage = stage_transient
        case default
            stage = stage_all
        end select
    end function stage_of

end module gb_build_loads
