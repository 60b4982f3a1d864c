!> INITIAL: displacements and velocities at the start, as functions of the place.
module gb_initial
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_solution
    use gb_text, only: to_text
    use gb_fields, only: field_names, dof_index
    use gb_model, only: model_t
    use gb_state, only: state_t
    use gb_system, only: system_t
    implicit none
    private

    public :: initial_state, initial_velocities

contains

    !> The state a run starts from: INITIAL displacements and velocities, or rest. Held fields stay where they
    !> are.
    subroutine initial_state(model, system, state, error)
        type(model_t), intent(in) :: model
        type(system_t), intent(in) :: system
        type(state_t), intent(out) :: state
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: energy
        logical :: admissible

        allocate (state%u(system%n), state%v(system%n), state%a(system%n))
        state%a = 0.0_wp
        call initial_values(model, system, .false., state%u, error)
        if (.not. allocated(error)) call initial_velocities(model, system, state%v, error)
        if (allocated(error)) return
        call system%strain_energy(state%u, energy, admissible)
        if (.not. admissible) call raise(error, status_solution, &
            'the INITIAL displacements are not admissible ' // '(J <= 0 or I1-2 >= jm somewhere)')
    end subroutine initial_state

    !> Velocities of a transient that does not follow another one.
    subroutine initial_velocities(model, system, v, error)
        type(model_t), intent(in) :: model
        type(system_t), intent(in) :: system
        real(wp), intent(out) :: v(:)                   !! (n)
        type(error_t), allocatable, intent(out) :: error

        call initial_values(model, system, .true., v, error)
    end subroutine initial_velocities

    subroutine initial_values(model, system, velocities, values, error)
        type(model_t), intent(in) :: model
        type(system_t), intent(in) :: system
        logical, intent(in) :: velocities
        real(wp), intent(out) :: values(:)
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: value
        logical :: defined
        integer :: i, node

        values = 0.0_wp
        do i = 1, size(model%initial)
            associate (initial => model%initial(i))
                if (initial%is_velocity .neqv. velocities) cycle
                do node = 1, model%mesh%n_nodes()
                    call initial%formula%evaluate(model%mesh%x(node), value, defined)
                    if (.not. defined) then
                        call raise(error, status_solution, 'INITIAL ' // field_names(initial%field) // &
                                   ' has no finite value at x = ' // to_text(model%mesh%x(node)))
                        return
                    end if
                    values(dof_index(initial%field, node)) = value
                end do
            end associate
        end do
        where (system%fixed) values = 0.0_wp
    end subroutine initial_values

end module gb_initial
