!> TRANSIENT: steps of fixed size, or of a size that keeps the local error below `accuracy`. Both end on every
!> jump or corner of a history; a step that fails is repeated in smaller parts.
module gb_transient
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
    use gb_memory, only: memory_t
    use gb_text, only: to_text
    use gb_fields, only: n_fields
    use gb_mesh, only: mesh_t
    use gb_problem, only: task_t
    use gb_state, only: state_t
    use gb_recorder, only: recorder_t, step_record_t
    use gb_system, only: system_t
    use gb_external, only: external_t, events_t, same_instant
    use gb_substeps, only: substeps_t
    use gb_stepper, only: stepper_t
    use gb_failure, only: failure_reason
    implicit none
    private

    public :: run_transient, next_instant

    !> Adaptive steps: first step and smallest step as parts of the duration, and how a step may change at
    !> once.
    real(wp), parameter :: first_part = 1.0e-4_wp, smallest_part = 1.0e-12_wp
    real(wp), parameter :: safety = 0.9_wp, least_growth = 0.2_wp, most_growth = 3.0_wp

    !> What the loop over the steps carries from one to the next.
    type :: pace_t
        integer :: grid = 0                     !! fixed steps: multiples of the step behind
        type(substeps_t) :: parts               !! fixed steps: halvings in force
        real(wp) :: dt = 0.0_wp                 !! adaptive: the next step [T]
        real(wp) :: last_misfit = 1.0_wp        !! adaptive: error of the last step over the accuracy [-]
        real(wp) :: largest = 0.0_wp            !! adaptive: largest displacement so far [L]
    contains
        procedure :: pass_memory => pass_pace
    end type pace_t

contains

    !> Integrate from rest or from the state's velocities over task%end_time; every step is told to the
    !> recorder. A memory that is being recalled takes the place of the start: the command goes on from there.
    !> On failure the state is that of the last step solved.
    subroutine run_transient(system, external, mesh, task, memory, state, recorder, error)
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        type(task_t), intent(in) :: task
        type(memory_t), intent(inout) :: memory
        type(state_t), intent(inout) :: state
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(stepper_t) :: stepper
        type(step_record_t) :: step
        type(pace_t) :: pace
        type(events_t) :: events
        real(wp) :: span

        span = merge(task%step, first_part*task%end_time, task%step > 0.0_wp)
        pace%parts%max_level = task%cuts
        pace%dt = first_part*task%end_time
        pace%largest = 1.0e-3_wp*system%field_scale(1)
        events = external%events(task%end_time, span)
        if (memory%is_recalling) then
            call state%pass_memory(memory, 'state')
            call step%pass_memory(memory, 'step')
            call pace%pass_memory(memory)
            call stepper%resume(system, external, task, span, memory, state)
            call memory%check(error)
        else
            call stepper%start(system, external, task, span, state, error, events%start)
            if (allocated(error)) return
            call report(stepper, system, task, 0.0_wp, state, step, recorder, error)
        end if
        if (allocated(error)) return
        if (task%step > 0.0_wp) then
            call take_fixed_steps(stepper, system, external, mesh, task, events, pace, state, step, &
                recorder, error)
        else
            call take_adaptive_steps(stepper, system, external, mesh, task, events, pace, state, step, &
                recorder, error)
        end if
    end subroutine run_transient

    subroutine pass_pace(self, memory)
        class(pace_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory

        call memory%pass('pace.grid', self%grid)
        call memory%pass('pace.dt', self%dt)
        call memory%pass('pace.last_misfit', self%last_misfit)
        call memory%pass('pace.largest', self%largest)
        call self%parts%pass_memory(memory)
    end subroutine pass_pace

    !> After a step: where the recorder asks for it, hand it all that the next step depends on.
    subroutine offer_memory(stepper, pace, state, step, recorder, error)
        type(stepper_t), intent(inout) :: stepper
        type(pace_t), intent(inout) :: pace
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        type(memory_t) :: memory

        if (.not. recorder%wants_memory()) return
        call state%pass_memory(memory, 'state')
        call step%pass_memory(memory, 'step')
        call pace%pass_memory(memory)
        call stepper%pass_memory(memory)
        call recorder%keep_memory(memory, error)
    end subroutine offer_memory

    !> Tell the recorder of the state that has been reached in a step of the given size.
    subroutine report(stepper, system, task, size, state, step, recorder, error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(task_t), intent(in) :: task
        real(wp), intent(in) :: size                    !! [T]
        type(state_t), intent(in) :: state
        type(step_record_t), intent(inout) :: step
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error

        step%abscissa = state%time
        step%step = size
        step%progress = state%time/task%end_time
        step%iterations = stepper%take_iterations()
        step%residual = stepper%report%residual
        if (allocated(stepper%report%increments)) step%increments = stepper%report%increments
        step%kinetic = stepper%kinetic(system, state)
        step%strain = stepper%strain
        step%external = stepper%external
        step%dissipated = stepper%dissipated
        call recorder%record_step(step, state, error)
    end subroutine report

    subroutine take_fixed_steps(stepper, system, external, mesh, task, events, pace, state, step, recorder, &
        error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        type(task_t), intent(in) :: task
        type(events_t), intent(in) :: events
        type(pace_t), intent(inout) :: pace
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: from, target, after
        logical :: at_event

        do while (state%time < events%end_time)
            from = state%time
            call next_instant(task, events, from, pace%grid, target, after, step%on_grid, at_event)
            call walk(stepper, system, external, mesh, from, target, after, at_event, pace%parts, state, &
                step, error)
            if (allocated(error)) then
                error%message = 'TRANSIENT: step ' // to_text(step%number + 1) // error%message
                return
            end if
            step%number = step%number + 1
            call report(stepper, system, task, target - from, state, step, recorder, error)
            if (.not. allocated(error)) call offer_memory(stepper, pace, state, step, recorder, error)
            if (allocated(error)) return
        end do
    end subroutine take_fixed_steps

    !> Where the step that starts at `from` ends: on the next multiple of the step, on an event, or at the
    !> end.
    pure subroutine next_instant(task, events, from, grid, target, after, on_grid, at_event)
        type(task_t), intent(in) :: task
        type(events_t), intent(in) :: events
        real(wp), intent(in) :: from                !! [T]
        integer, intent(inout) :: grid              !! multiples of the step behind
        real(wp), intent(out) :: target             !! [T]
        real(wp), intent(out) :: after              !! from when on all of the event has happened [T]
        logical, intent(out) :: on_grid             !! whether it is a multiple of the step, or the end
        logical, intent(out) :: at_event
        real(wp) :: slack, multiple
        integer :: i

        multiple = real(grid + 1, wp)*task%step
        slack = min(same_instant*multiple, 0.1_wp*task%step)
        if (multiple > events%end_time - slack) multiple = events%end_time
        target = multiple
        after = target
        on_grid = .true.
        at_event = .false.
        i = first_after(events%first, from + slack)
        if (i <= size(events%first)) then
            if (events%first(i) <= multiple + slack) then
                at_event = .true.
                on_grid = events%first(i) >= multiple - slack
                target = events%first(i)
                after = events%last(i)
            end if
        end if
        if (on_grid) grid = grid + 1
    end subroutine next_instant

    !> Number of the first event after an instant, by bisection; size + 1 where there is none.
    pure integer function first_after(events, instant) result(first)
        real(wp), intent(in) :: events(:), instant
        integer :: low, high, middle

        low = 0
        high = size(events) + 1
        do while (high - low > 1)
            middle = (low + high)/2
            if (events(middle) > instant) then
                high = middle
            else
                low = middle
            end if
        end do
        first = high
    end function first_after

    !> Go from one instant to the next, in as many halvings as it takes.
    subroutine walk(stepper, system, external, mesh, from, target, after, at_event, parts, state, step, error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        real(wp), intent(in) :: from, target, after     !! as next_instant's [T]
        logical, intent(in) :: at_event
        type(substeps_t), intent(inout) :: parts
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: until, part
        logical :: exhausted, is_solved

        step%cuts = 0
        call parts%begin_interval()
        do while (.not. parts%is_finished())
            if (stepper%scheme%is_explicit) call parts%refine((target &
                - from)/stepper%explicit_limit(system, state))
            part = parts%next_end()
            until = merge(target, from + (target - from)*part, part >= 1.0_wp)
            if (parts%level > parts%max_level) then
                call raise(error, status_solution, ': the explicit scheme is stable up to a step of ' &
                    // to_text(stepper%explicit_limit(system, state)) // ' here, more than ' &
                    // to_text(parts%max_level) // ' halvings (cuts=) below step=')
                return
            end if
            call stepper%propose(system, external, state, until, is_solved, error)
            if (allocated(error)) then
                error%message = ': ' // error%message
                return
            end if
            if (.not. is_solved) then
                step%cuts = step%cuts + 1
                call parts%reject(exhausted)
                if (.not. exhausted) cycle
                call raise(error, status_solution, ' failed from t = ' // to_text(state%time) // ' to ' &
                    // to_text(until) // ' after ' // to_text(parts%max_level) // ' cuts: ' &
                    // trim(failure_reason(system, stepper%report, stepper%trial%u, mesh%x)) &
                    // trim(advice(system, stepper)))
                return
            end if
            call stepper%commit(system, external, at_event .and. part >= 1.0_wp, state, error, after)
            if (allocated(error)) return
            call parts%accept()
        end do
    end subroutine walk

    !> What to try after a failure; padded with blanks.
    function advice(system, stepper) result(text)
        type(system_t), intent(in) :: system
        type(stepper_t), intent(in) :: stepper
        character(100) :: text

        text = '. Try a smaller step='
        if (stepper%scheme%is_explicit .or. stepper%scheme%stages > 1) return
        if (.not. stepper%scheme%has_symmetric_tangent) return
        text = trim(text) // ', or a scheme that damps (bathe)'
        if (system%symmetric) text = trim(text) // ' or conserves (energy)'
    end function advice

    !> Steps whose local error, relative to the largest displacement so far, stays below task%accuracy. The
    !> error of two half steps is estimated from the difference to one whole step (a third of it, for schemes
    !> of second order), and a proportional-integral controller chooses the next step. The half steps are what
    !> is kept.
    subroutine take_adaptive_steps(stepper, system, external, mesh, task, events, pace, state, step, &
        recorder, error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(mesh_t), intent(in) :: mesh
        type(task_t), intent(in) :: task
        type(events_t), intent(in) :: events
        type(pace_t), intent(inout) :: pace
        type(state_t), intent(inout) :: state
        type(step_record_t), intent(inout) :: step
        class(recorder_t), intent(inout) :: recorder
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: size, target, after, misfit
        logical :: is_solved, at_event
        integer :: i

        do while (state%time < events%end_time)
            step%cuts = 0
            do
                i = first_after(events%first, state%time*(1.0_wp + epsilon(1.0_wp)))
                target = events%end_time
                after = target
                at_event = i <= ubound(events%first, 1)
                if (at_event) then
                    target = events%first(i)
                    after = events%last(i)
                end if
                ! A step that would leave a sliver behind takes it along, or shares the way with the next.
                size = target - state%time
                if (pace%dt < 0.999_wp*size) then
                    size = min(pace%dt, 0.5_wp*size)
                    target = state%time + size
                    at_event = .false.
                end if
                call stepper%remember(state)
                call try_step(stepper, system, external, size, target, after, at_event, state, pace%largest, &
                    misfit, is_solved, error)
                if (allocated(error)) return
                misfit = misfit/task%accuracy
                if (is_solved .and. misfit <= 1.0_wp) exit
                call stepper%go_back(state)
                step%cuts = step%cuts + 1
                if (is_solved) then
                    pace%dt = size*max(least_growth, safety*misfit**(-1.0_wp/3.0_wp))
                else
                    pace%dt = 0.25_wp*size
                end if
                if (pace%dt < smallest_part*task%end_time) then
                    call raise(error, status_solution, 'TRANSIENT: step ' // to_text(step%number + 1) // &
                               ': no step from t = ' // to_text(state%time) // ' keeps accuracy=' &
                               // to_text(task%accuracy) // '; ' // trim(failure_reason(system, &
                               stepper%report, stepper%trial%u, mesh%x)))
                    return
                end if
            end do
            misfit = max(misfit, 1.0e-4_wp)
            pace%dt = size*min(most_growth, max(least_growth, &
                safety*misfit**(-0.7_wp/3.0_wp)*pace%last_misfit**(0.4_wp/3.0_wp)))
            pace%last_misfit = misfit
            step%number = step%number + 1
            call report(stepper, system, task, size, state, step, recorder, error)
            if (.not. allocated(error)) call offer_memory(stepper, pace, state, step, recorder, error)
            if (allocated(error)) return
        end do
    end subroutine take_adaptive_steps

    !> One whole step for comparison, then two half steps that are committed. misfit is the estimated error of
    !> the half steps' displacements over `largest`, the largest displacement so far.
    subroutine try_step(stepper, system, external, size, target, after, at_event, state, largest, misfit, &
        is_solved, error)
        type(stepper_t), intent(inout) :: stepper
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        real(wp), intent(in) :: size, target            !! [T]
        real(wp), intent(in) :: after                   !! from when on all of the event has happened [T]
        logical, intent(in) :: at_event
        type(state_t), intent(inout) :: state
        real(wp), intent(inout) :: largest              !! [L]
        real(wp), intent(out) :: misfit
        logical, intent(out) :: is_solved
        type(error_t), allocatable, intent(out) :: error
        real(wp), allocatable :: coarse(:)

        misfit = huge(misfit)
        call stepper%propose(system, external, state, target, is_solved, error)
        if (allocated(error) .or. .not. is_solved) return
        coarse = stepper%trial%u
        call stepper%propose(system, external, state, state%time + 0.5_wp*size, is_solved, error)
        if (allocated(error) .or. .not. is_solved) return
        call stepper%commit(system, external, .false., state, error)
        if (allocated(error)) return
        call stepper%propose(system, external, state, target, is_solved, error)
        if (allocated(error) .or. .not. is_solved) return
        call stepper%commit(system, external, at_event, state, error, after)
        if (allocated(error)) return
        largest = max(largest, largest_displacement(state%u))
        misfit = largest_displacement(state%u - coarse)/(3.0_wp*largest)
    end subroutine try_step

    !> Largest length of (u1, u3) over the nodes [L].
    pure real(wp) function largest_displacement(u)
        real(wp), intent(in) :: u(:)

        largest_displacement = sqrt(maxval(u(1::n_fields)**2 + u(2::n_fields)**2))
    end function largest_displacement

end module gb_transient
