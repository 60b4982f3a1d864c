!> Strains and stresses of a command in the results file, where OUTPUT fields= asks for them: one row a stored
!> state, at the stations along the beam and the heights of each.
module gb_results_recovery
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_gauge, only: gauge_t
    use gb_model, only: units_t
    use gb_problem, only: output_t
    use gb_hdf5, only: hid_t, series_t, create_group, close_group, put_array
    implicit none
    private

    integer, parameter :: n_series = 8
    integer, parameter :: strain_e = 1, strain_i1 = 2, strain_j = 3, stress_axial = 4, stress_shear = 5, &
        stress_moment = 6, stress_s = 7, stress_cauchy = 8

    type, public :: recovery_series_t
        private
        logical :: has_strain = .false., has_stress = .false.
        integer, public :: beyond = 0       !! faces without a stress in the rows of the running command
        type(series_t), public :: series(n_series)
    contains
        procedure :: create => create_series
        procedure :: append => append_row
    end type recovery_series_t

    public :: write_stations

contains

    !> /mesh/stations: where along and across the beam strains and stresses are given.
    subroutine write_stations(file, gauge, units, error)
        integer(hid_t), intent(in) :: file
        class(gauge_t), intent(in) :: gauge
        type(units_t), intent(in) :: units
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: group

        call create_group(file, 'mesh/stations', group, error)
        if (.not. allocated(error)) call put_array(group, 'x', gauge%x, units%length, &
            'reference X1 of every station, an integration point of an element', error)
        if (.not. allocated(error)) call put_array(group, 'element', gauge%element - 1, '', &
            'element of every station, counted from 0', error)
        if (.not. allocated(error)) call put_array(group, 'x3', gauge%x3, units%length, &
            'reference X3 of the heights of every station: faces and Gauss points', error)
        if (.not. allocated(error)) call close_group(group)
    end subroutine write_stations

    !> The groups strain and stress of a command, as far as they are asked for.
    subroutine create_series(self, command, gauge, output, units, error)
        class(recovery_series_t), intent(inout) :: self
        integer(hid_t), intent(in) :: command
        class(gauge_t), intent(in) :: gauge
        type(output_t), intent(in) :: output
        type(units_t), intent(in) :: units
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: pressure, couple
        integer(hid_t) :: group

        self%has_strain = output%strain
        self%has_stress = output%stress
        self%beyond = 0
        associate (nz => gauge%heights, ns => gauge%stations, s => self%series)
            if (self%has_strain) then
                call create_group(command, 'strain', group, error)
                if (allocated(error)) return
                call s(strain_e)%create(group, 'E', [3, nz, ns], .false., '1', &
                    'Green-Lagrange strains E11 E33 E13', error)
                if (.not. allocated(error)) call s(strain_i1)%create(group, 'I1-2', [nz, ns], .false., '1', &
                    'I1 - 2, which stays below jm', error)
                if (.not. allocated(error)) call s(strain_j)%create(group, 'J', [nz, ns], .false., '1', &
                    'area ratio det F', error)
                if (.not. allocated(error)) call close_group(group)
            end if
            if (.not. self%has_stress .or. allocated(error)) return
            pressure = ''
            couple = ''
            if (len(units%force) > 0 .and. len(units%length) > 0) then
                pressure = units%force // '/' // units%length // '^2'
                couple = units%force // '*' // units%length
            end if
            call create_group(command, 'stress', group, error)
            if (.not. allocated(error)) call s(stress_axial)%create(group, 'axial', [ns], .false., &
                units%force, 'force normal to the deformed section, positive in tension', error)
            if (.not. allocated(error)) call s(stress_shear)%create(group, 'shear', [ns], .false., &
                units%force, 'force along the deformed section, positive towards positive X3', error)
            if (.not. allocated(error)) call s(stress_moment)%create(group, 'moment', [ns], .false., couple, &
                'bending moment, positive where it stretches the side of positive X3', error)
            if (.not. allocated(error)) call s(stress_s)%create(group, 'S', [3, nz, ns], .false., pressure, &
                'second Piola-Kirchhoff stresses S11 S33 S13', error)
            if (.not. allocated(error)) call s(stress_cauchy)%create(group, 'cauchy', [3, nz, ns], .false., &
                pressure, 'Cauchy stresses 11 33 13 along the axes of space', error)
            if (.not. allocated(error)) call close_group(group)
        end associate
    end subroutine create_series

    !> One row of the state u.
    subroutine append_row(self, gauge, u, error)
        class(recovery_series_t), intent(inout) :: self
        class(gauge_t), intent(in) :: gauge
        real(wp), intent(in) :: u(:)
        type(error_t), allocatable, intent(out) :: error
        real(wp), allocatable :: tensor(:), other(:), first(:), second(:), third(:)
        integer :: beyond

        associate (nz => gauge%heights, ns => gauge%stations, s => self%series)
            allocate (tensor(3*nz*ns), other(3*nz*ns))
            if (self%has_strain) then
                allocate (first(nz*ns), second(nz*ns))
                call gauge%read_strains(u, tensor, first, second)
                call s(strain_e)%append(tensor, error)
                if (.not. allocated(error)) call s(strain_i1)%append(first, error)
                if (.not. allocated(error)) call s(strain_j)%append(second, error)
                deallocate (first, second)
            end if
            if (.not. self%has_stress .or. allocated(error)) return
            allocate (first(ns), second(ns), third(ns))
            call gauge%read_resultants(u, first, second, third)
            call s(stress_axial)%append(first, error)
            if (.not. allocated(error)) call s(stress_shear)%append(second, error)
            if (.not. allocated(error)) call s(stress_moment)%append(third, error)
            call gauge%read_stresses(u, tensor, other, beyond)
            self%beyond = self%beyond + beyond
            if (.not. allocated(error)) call s(stress_s)%append(tensor, error)
            if (.not. allocated(error)) call s(stress_cauchy)%append(other, error)
        end associate
    end subroutine append_row

end module gb_results_recovery
