!> What the results file says of a solution command, in a run of its own or as a member of a study: its
!> attributes, modes, and the names, units and descriptions of its series.
module gb_results_task
    use gb_kinds, only: wp
    use gb_archive, only: archive_t
    use gb_error, only: error_t
    use gb_fields, only: n_fields, field_names, field_length_power
    use gb_model, only: units_t
    use gb_problem, only: task_t, probe_t, task_static, task_modal, task_transient, &
        quantity_displacement, quantity_velocity
    use gb_text, only: to_text
    implicit none
    private

    integer, parameter, public :: n_energies = 5, n_solver = 4
    character(10), parameter, public :: energy_names(n_energies) = [character(10) :: 'kinetic', 'strain', &
        'external', 'dissipated', 'balance']
    character(64), parameter, public :: energy_descriptions(n_energies) = [character(64) :: &
        'kinetic energy', 'strain energy', 'work of the loads since the command began', &
        'energy taken by damping since the command began', &
        'kinetic + strain - external + dissipated, from its start value']
    character(10), parameter, public :: solver_names(n_solver) = [character(10) :: 'iterations', 'cuts', &
        'step', &
        'residual']
    character(64), parameter, public :: solver_descriptions(n_solver) = [character(64) :: &
        'Newton iterations, those of rejected attempts included', 'times the step was halved', &
        'size of the step', 'last residual over the forces that balance in it']
    character(1), parameter, public :: set_names(3) = ['u', 'v', 'a']
    character(40), &
        parameter, public :: set_descriptions(3) = [character(40) :: 'fields u1 u3 y1 y3 xi at every node', &
        'their velocities', 'their accelerations']

    public :: write_task_attributes, write_mode_shapes
    public :: abscissa_name, abscissa_unit, probe_description, product_unit, derived_unit, field_units

contains

    subroutine write_task_attributes(archive, group, task, order)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: group
        type(task_t), intent(in) :: task
        integer, intent(in) :: order

        call archive%set(group, 'order', order)
        select case (task%kind)
        case (task_static)
            call archive%set(group, 'kind', 'static')
            call archive%set(group, 'scheme', 'newton')
            call archive%set(group, 'steps', task%steps)
            call archive%set(group, 'load', task%load)
        case (task_modal)
            call archive%set(group, 'kind', 'modal')
            call archive%set(group, 'scheme', 'subspace iteration')
        case (task_transient)
            call archive%set(group, 'kind', 'transient')
            call archive%set(group, 'scheme', task%scheme)
            call archive%set(group, 'dt', task%step)
            if (task%accuracy > 0.0_wp) call archive%set(group, 'accuracy', task%accuracy)
            call archive%set(group, 'end', task%end_time)
            call write_scheme_numbers(archive, group, task)
        end select
        if (task%kind /= task_modal) call archive%set(group, 'tolerance', task%tolerance)
    end subroutine write_task_attributes

    subroutine write_scheme_numbers(archive, group, task)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: group
        type(task_t), intent(in) :: task

        select case (task%scheme)
        case ('newmark')
            call archive%set(group, 'beta', task%beta)
            call archive%set(group, 'gamma', task%gamma)
        case ('hht')
            call archive%set(group, 'alpha', task%alpha)
        case ('generalized', 'bathe')
            call archive%set(group, 'rho', task%rho)
        end select
    end subroutine write_scheme_numbers

    !> Natural frequencies and modes of a MODAL command.
    subroutine write_mode_shapes(archive, group, units, frequency, modes, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: group                !! of the MODAL command
        type(units_t), intent(in) :: units
        real(wp), intent(in) :: frequency(:)        !! [cycles/T]
        real(wp), intent(in) :: modes(:, :)         !! (5 nn, nm)
        type(error_t), allocatable, intent(out) :: error
        real(wp), allocatable :: shaped(:, :, :)
        character(:), allocatable :: unit

        unit = ''
        if (len(units%time) > 0) unit = '1/' // units%time
        shaped = reshape(modes, [n_fields, size(modes, 1)/n_fields, size(frequency)])
        call archive%put(group, 'frequency', frequency, unit, &
                       'natural frequencies, cycles a unit of time; negative for a mode that grows', error)
        if (.not. allocated(error)) call archive%put(group, 'modes', shaped, &
            field_units(units, 1), 'fields u1 u3 y1 y3 xi of every mode, largest displacement 1', error)
    end subroutine write_mode_shapes

    !> What the rows of a command run over.
    pure function abscissa_name(task) result(words)
        type(task_t), intent(in) :: task
        character(:), allocatable :: words

        words = 'time since the command began'
        if (task%kind == task_static) words = 'load factor'
    end function abscissa_name

    pure function abscissa_unit(task, units) result(unit)
        type(task_t), intent(in) :: task
        type(units_t), intent(in) :: units
        character(:), allocatable :: unit

        unit = ''
        if (task%kind /= task_static) unit = units%time
    end function abscissa_unit

    !> "u3 at x = 10", "velocity of u3 at x = 10".
    pure function probe_description(probe) result(text)
        type(probe_t), intent(in) :: probe
        character(:), allocatable :: text

        text = field_names(probe%field) // ' at x = ' // to_text(probe%x)
        if (probe%quantity == quantity_velocity) then
            text = 'velocity of ' // text
        else if (probe%quantity > quantity_displacement) then
            text = 'acceleration of ' // text
        end if
    end function probe_description

    !> "lbf*in", or nothing where the deck names no units.
    pure function product_unit(first, second) result(text)
        character(*), intent(in) :: first, second
        character(:), allocatable :: text

        text = ''
        if (len(first) > 0 .and. len(second) > 0) text = first // '*' // second
    end function product_unit

    !> Unit of a field's time derivative of the given order: "in/s^2".
    pure function derived_unit(units, length_power, order) result(text)
        type(units_t), intent(in) :: units
        integer, intent(in) :: length_power, order
        character(:), allocatable :: text

        text = ''
        if (len(units%length) == 0 .or. (order > 0 .and. len(units%time) == 0)) return
        select case (length_power)
        case (1)
            text = units%length
        case (-1)
            text = '1/' // units%length
        case default
            text = '1'
        end select
        if (order >= 1) text = text // '/' // units%time
        if (order == 2) text = text // '^2'
    end function derived_unit

    !> Units of the five fields of u, v or a (set = 1, 2, 3).
    pure function field_units(units, set) result(text)
        type(units_t), intent(in) :: units
        integer, intent(in) :: set
        character(:), allocatable :: text
        integer :: i

        text = derived_unit(units, field_length_power(1), set - 1)
        if (len(text) == 0) return
        do i = 2, n_fields
            text = text // ', ' // derived_unit(units, field_length_power(i), set - 1)
        end do
    end function field_units

end module gb_results_task
