!> Strains and stresses of a command in the results file, where OUTPUT fields= asks for them: one row a stored
!> state, at the stations along the beam and the heights of each.
module gb_results_recovery
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_gauge, only: gauge_t
    use gb_model, only: units_t
    use gb_problem, only: output_t
    use gb_archive, only: archive_t, stored_real64, stored_int32
    implicit none
    private

    integer, parameter :: n_series = 8
    integer, parameter :: strain_e = 1, strain_i1 = 2, strain_j = 3, stress_axial = 4, stress_shear = 5, &
        stress_moment = 6, stress_s = 7, stress_cauchy = 8

    type, public :: recovery_series_t
        private
        logical :: has_strain = .false., has_stress = .false.
        integer, public :: beyond = 0       !! faces without a stress in the rows of the running command
        integer :: series(n_series) = 0     !! nodes of the running command's
    contains
        procedure :: create => create_series
        procedure :: append => append_row
    end type recovery_series_t

    public :: write_stations

contains

    !> /mesh/stations: where along and across the beam strains and stresses are given.
    subroutine write_stations(archive, mesh, gauge, units, error)
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: mesh             !! the group
        class(gauge_t), intent(in) :: gauge
        type(units_t), intent(in) :: units
        type(error_t), allocatable, intent(out) :: error
        integer :: group

        call archive%add_group(mesh, 'stations', group)
        call archive%put(group, 'x', gauge%x, units%length, &
            'reference X1 of every station, an integration point of an element', error)
        if (.not. allocated(error)) call archive%put(group, 'element', gauge%element - 1, stored_int32, '', &
            'element of every station, counted from 0', error)
        if (.not. allocated(error)) call archive%put(group, 'x3', gauge%x3, units%length, &
            'reference X3 of the heights of every station: faces and Gauss points', error)
    end subroutine write_stations

    !> The groups strain and stress of a command, as far as they are asked for.
    subroutine create_series(self, archive, command, gauge, output, units)
        class(recovery_series_t), intent(inout) :: self
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: command          !! the group
        class(gauge_t), intent(in) :: gauge
        type(output_t), intent(in) :: output
        type(units_t), intent(in) :: units
        character(:), allocatable :: pressure, couple
        integer :: group

        self%has_strain = output%strain
        self%has_stress = output%stress
        self%beyond = 0
        associate (nz => gauge%heights, ns => gauge%stations)
            if (self%has_strain) then
                call archive%add_group(command, 'strain', group)
                call add(strain_e, 'E', [3, nz, ns], '1', 'Green-Lagrange strains E11 E33 E13')
                call add(strain_i1, 'I1-2', [nz, ns], '1', 'I1 - 2, which stays below jm')
                call add(strain_j, 'J', [nz, ns], '1', 'area ratio det F')
            end if
            if (.not. self%has_stress) return
            pressure = ''
            couple = ''
            if (len(units%force) > 0 .and. len(units%length) > 0) then
                pressure = units%force // '/' // units%length // '^2'
                couple = units%force // '*' // units%length
            end if
            call archive%add_group(command, 'stress', group)
            call add(stress_axial, 'axial', [ns], units%force, &
                'force normal to the deformed section, positive in tension')
            call add(stress_shear, 'shear', [ns], units%force, &
                'force along the deformed section, positive towards positive X3')
            call add(stress_moment, 'moment', [ns], couple, &
                'bending moment, positive where it stretches the side of positive X3')
            call add(stress_s, 'S', [3, nz, ns], pressure, 'second Piola-Kirchhoff stresses S11 S33 S13')
            call add(stress_cauchy, 'cauchy', [3, nz, ns], pressure, &
                'Cauchy stresses 11 33 13 along the axes of space')
        end associate

    contains

        subroutine add(which, name, row_shape, unit, description)
            integer, intent(in) :: which, row_shape(:)
            character(*), intent(in) :: name, unit, description

            call archive%add_series(group, name, row_shape, stored_real64, unit, description, &
                self%series(which))
        end subroutine add

    end subroutine create_series

    !> One row of the state u.
    subroutine append_row(self, archive, gauge, u, error)
        class(recovery_series_t), intent(inout) :: self
        type(archive_t), intent(inout) :: archive
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
                call archive%append(s(strain_e), tensor, error)
                if (.not. allocated(error)) call archive%append(s(strain_i1), first, error)
                if (.not. allocated(error)) call archive%append(s(strain_j), second, error)
                deallocate (first, second)
            end if
            if (.not. self%has_stress .or. allocated(error)) return
            allocate (first(ns), second(ns), third(ns))
            call gauge%read_resultants(u, first, second, third)
            call archive%append(s(stress_axial), first, error)
            if (.not. allocated(error)) call archive%append(s(stress_shear), second, error)
            if (.not. allocated(error)) call archive%append(s(stress_moment), third, error)
            call gauge%read_stresses(u, tensor, other, beyond)
            self%beyond = self%beyond + beyond
            if (.not. allocated(error)) call archive%append(s(stress_s), tensor, error)
            if (.not. allocated(error)) call archive%append(s(stress_cauchy), other, error)
        end associate
    end subroutine append_row

end module gb_results_recovery
