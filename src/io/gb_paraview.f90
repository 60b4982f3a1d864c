!> The motion for ParaView, in VTK's own HDF5 format: /VTKHDF, a temporal unstructured grid. The beam is a
!> strip of quads, two across the thickness, whose points move; the topology is written once. All commands
!> that have a course follow one another on one clock (a STATIC's load factor counts as its time). Numbers are
!> stored with 32 bits: enough for a picture, and half the size.
module gb_paraview
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_fields, only: n_fields
    use gb_gauge, only: gauge_t
    use gb_model, only: units_t
    use gb_strip, only: strip_t, strip_heights, strip_levels
    use gb_hdf5, only: hid_t, series_t, create_group, close_group, close_dataset, put_attribute, &
        replace_attribute, stored_real32, stored_real64, stored_int64
    use gb_hdf5_vtk, only: put_ascii_attribute, put_pair_attribute, put_wide_integers, put_bytes, &
        link_object, &
        create_constant, extend
    implicit none
    private

    integer, parameter :: vtk_quad = 9              !! VTK's number of a quadrilateral
    integer, parameter :: format_version(2) = [2, 0]
    !> Values at the points that come with OUTPUT fields=strain, after director and xi.
    character(16), parameter :: scalar_names(5) = [character(16) :: 'E11', 'E33', 'I1-2', 'J', &
        'energy_density']
    character(48), parameter :: scalar_descriptions(5) = [character(48) :: &
        'Green-Lagrange strain along the beam', 'Green-Lagrange strain across the beam', &
        'I1 - 2, which stays below jm', 'area ratio det F', 'strain energy a unit volume']

    type, public :: paraview_t
        private
        logical :: is_open = .false.
        logical :: has_strains = .false.
        integer :: points = 0                       !! of the strip
        integer :: rows = 0
        integer(hid_t) :: steps = -1                !! group Steps, which knows the number of rows
        real(wp), allocatable :: x(:)               !! reference X1 of the columns [L]
        type(strip_t) :: strip
        real(wp) :: clock = 0.0_wp                  !! of the last row
        real(wp) :: last_abscissa = 0.0_wp          !! of the running command
        logical :: at_start = .true.                !! the next row is the first of a command
        integer(hid_t) :: zeros = -1, ones = -1     !! series of the same number in every row
        type(series_t) :: values, offsets, places, displacement, director, xi, scalars(5)
    contains
        procedure :: open => open_paraview
        procedure :: begin_task
        procedure :: append
        procedure :: flush
        procedure :: close => close_paraview
    end type paraview_t

contains

    !> Create /VTKHDF with all that does not move. `has_strains` asks for director, xi and strains at the
    !> points too.
    subroutine open_paraview(self, file, x, gauge, units, has_strains, error)
        class(paraview_t), intent(inout) :: self
        integer(hid_t), intent(in) :: file
        real(wp), intent(in) :: x(:)                !! reference X1 of the nodes [L]
        class(gauge_t), intent(in) :: gauge
        type(units_t), intent(in) :: units
        logical, intent(in) :: has_strains
        type(error_t), allocatable, intent(out) :: error
        integer(hid_t) :: group

        self%strip = gauge%strip
        self%x = x(self%strip%node(:self%strip%columns))
        self%points = strip_heights*self%strip%columns
        self%has_strains = has_strains
        call create_group(file, 'VTKHDF', group, error)
        if (.not. allocated(error)) call put_pair_attribute(group, 'Version', format_version, error)
        if (.not. allocated(error)) call put_ascii_attribute(group, 'Type', 'UnstructuredGrid', error)
        if (.not. allocated(error)) call write_topology(self, group, error)
        if (.not. allocated(error)) call create_steps(self, group, units, error)
        if (.not. allocated(error)) call create_fields(self, group, units, error)
        if (.not. allocated(error)) call close_group(group)
        self%is_open = .not. allocated(error)
    end subroutine open_paraview

    !> The quads, by the points of their corners; those of a column are numbered from bottom to top.
    subroutine write_topology(self, group, error)
        class(paraview_t), intent(in) :: self
        integer(hid_t), intent(in) :: group
        type(error_t), allocatable, intent(out) :: error
        integer, allocatable :: corners(:)
        integer :: c, k, n, first, i

        allocate (corners(4*(strip_heights - 1)*(self%strip%columns - 1)))
        n = 0
        do c = 1, self%strip%columns - 1
            ! Two columns at one node are the ends of two lines: nothing spans the step between them.
            if (self%strip%node(c + 1) == self%strip%node(c)) cycle
            do k = 1, strip_heights - 1
                first = strip_heights*(c - 1) + k - 1
                corners(n + 1:n + 4) = [first, first + strip_heights, first + strip_heights + 1, first + 1]
                n = n + 4
            end do
        end do
        call put_wide_integers(group, 'NumberOfPoints', [self%points], '', 'points of the strip', error)
        if (.not. allocated(error)) call put_wide_integers(group, 'NumberOfCells', [n/4], '', &
            'quads of the strip', error)
        if (.not. allocated(error)) call put_wide_integers(group, 'NumberOfConnectivityIds', [n], '', &
            'corners of all quads', error)
        if (.not. allocated(error)) call put_wide_integers(group, 'Connectivity', corners(:n), '', &
            'points of the quads, four each, counted from 0', error)
        if (.not. allocated(error)) call put_wide_integers(group, 'Offsets', [(4*i, i=0, n/4)], '', &
            'first corner of every quad, and the end', error)
        if (.not. allocated(error)) call put_bytes(group, 'Types', [(vtk_quad, i=1, n/4)], '', &
            'kind of every cell in VTK''s numbers', error)
    end subroutine write_topology

    !> Group Steps: the clock, and where the numbers of each row begin.
    subroutine create_steps(self, group, units, error)
        class(paraview_t), intent(inout) :: self
        integer(hid_t), intent(in) :: group
        type(units_t), intent(in) :: units
        type(error_t), allocatable, intent(out) :: error

        call create_group(group, 'Steps', self%steps, error)
        if (.not. allocated(error)) call put_attribute(self%steps, 'NSteps', 0, error)
        if (.not. allocated(error)) call self%values%create_records(self%steps, 'Values', [integer ::], 1, &
            stored_real64, units%time, 'time of every row; commands follow one another', error)
        if (.not. allocated(error)) call self%offsets%create_records(self%steps, 'PointOffsets', &
            [integer ::], 1, &
            stored_int64, '', 'first point of every row', error)
        if (.not. allocated(error)) call create_constant(self%steps, 'NumberOfParts', 1, '', &
            'the strip is one part', self%ones, error)
        if (.not. allocated(error)) call create_constant(self%steps, 'PartOffsets', 0, '', &
            'the topology is the same in every row', self%zeros, error)
        if (.not. allocated(error)) call link_object(self%steps, 'PartOffsets', 'CellOffsets', error)
        if (.not. allocated(error)) call link_object(self%steps, 'PartOffsets', 'ConnectivityIdOffsets', &
            error)
    end subroutine create_steps

    subroutine create_fields(self, group, units, error)
        class(paraview_t), intent(inout) :: self
        integer(hid_t), intent(in) :: group
        type(units_t), intent(in) :: units
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: unit
        integer(hid_t) :: data, offsets
        integer :: i

        call self%places%create_records(group, 'Points', [3], self%points, stored_real32, units%length, &
            'deformed places of the points', error)
        if (.not. allocated(error)) call create_group(group, 'PointData', data, error)
        if (.not. allocated(error)) call create_group(self%steps, 'PointDataOffsets', offsets, error)
        if (.not. allocated(error)) call add(self%displacement, 'u', [3], units%length, 'displacement')
        if (self%has_strains) then
            if (.not. allocated(error)) call add(self%director, 'director', [3], '1', &
                'director w, along which the section stands')
            unit = ''
            if (len(units%length) > 0) unit = '1/' // units%length
            if (.not. allocated(error)) call add(self%xi, 'xi', [integer ::], unit, &
                'quadratic part of the thickness stretch')
            do i = 1, size(scalar_names)
                unit = '1'
                if (i == size(scalar_names)) unit = ''
                if (i == size(scalar_names) .and. len(units%force) > 0 .and. len(units%length) > 0) then
                    unit = units%force // '/' // units%length // '^2'
                end if
                if (.not. allocated(error)) call add(self%scalars(i), trim(scalar_names(i)), [integer ::], &
                    unit, &
                    trim(scalar_descriptions(i)))
            end do
        end if
        if (.not. allocated(error)) call close_group(offsets)
        if (.not. allocated(error)) call close_group(data)

    contains

        subroutine add(series, name, shape_of, unit, description)
            type(series_t), intent(inout) :: series
            character(*), intent(in) :: name, unit, description
            integer, intent(in) :: shape_of(:)

            call series%create_records(data, name, shape_of, self%points, stored_real32, unit, &
                description, error)
            if (.not. allocated(error)) call link_object(self%steps, 'PointOffsets', &
                'PointDataOffsets/' // name, &
                error)
        end subroutine add

    end subroutine create_fields

    !> The next row starts another command.
    pure subroutine begin_task(self)
        class(paraview_t), intent(inout) :: self

        self%at_start = .true.
    end subroutine begin_task

    !> A row: the state u at `abscissa`, time or load factor of the running command. The first state of a
    !> later command is the last one of the command before, which is there already.
    subroutine append(self, gauge, abscissa, u, error)
        class(paraview_t), intent(inout) :: self
        class(gauge_t), intent(in) :: gauge
        real(wp), intent(in) :: abscissa
        real(wp), intent(in) :: u(:)                !! (5 nn)
        type(error_t), allocatable, intent(out) :: error
        logical :: is_repeated

        if (.not. self%is_open) return
        is_repeated = self%at_start .and. self%rows > 0
        if (.not. self%at_start) self%clock = self%clock + abs(abscissa - self%last_abscissa)
        self%at_start = .false.
        self%last_abscissa = abscissa
        if (is_repeated) return
        call self%values%append([self%clock], error)
        if (.not. allocated(error)) call self%offsets%append([real(self%rows, wp)*real(self%points, wp)], &
            error)
        self%rows = self%rows + 1
        if (.not. allocated(error)) call append_places(self, u, error)
        if (self%has_strains .and. .not. allocated(error)) call append_strains(self, gauge, u, error)
    end subroutine append

    !> x = (X1 + u1, u3) + (X3 + xi X3^2) (y1, 1+y3), and x less the point's place at rest.
    subroutine append_places(self, u, error)
        class(paraview_t), intent(inout) :: self
        real(wp), intent(in) :: u(:)
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: place(3*self%points), moved(3*self%points), x3, zeta, along, across
        integer :: c, k, first, n

        n = 0
        do c = 1, self%strip%columns
            first = n_fields*(self%strip%node(c) - 1)
            do k = 1, strip_heights
                x3 = strip_levels(k)*self%strip%h(c)
                zeta = x3 + u(first + 5)*x3**2
                along = u(first + 1) + zeta*u(first + 3)
                across = u(first + 2) + u(first + 5)*x3**2 + zeta*u(first + 4)
                moved(n + 1) = along
                moved(n + 2) = 0.0_wp
                moved(n + 3) = across
                place(n + 1) = self%x(c) + along
                place(n + 2) = 0.0_wp
                place(n + 3) = x3 + across
                n = n + 3
            end do
        end do
        call self%places%append(place, error)
        if (.not. allocated(error)) call self%displacement%append(moved, error)
    end subroutine append_places

    subroutine append_strains(self, gauge, u, error)
        class(paraview_t), intent(inout) :: self
        class(gauge_t), intent(in) :: gauge
        real(wp), intent(in) :: u(:)
        type(error_t), allocatable, intent(out) :: error
        real(wp) :: values(self%points, size(scalar_names))
        real(wp) :: w(3, strip_heights, self%strip%columns), xi(strip_heights, self%strip%columns)
        integer :: c, i

        do c = 1, self%strip%columns
            associate (q => u(n_fields*(self%strip%node(c) - 1) + 1:n_fields*self%strip%node(c)))
                w(:, :, c) = spread([q(3), 0.0_wp, 1.0_wp + q(4)], 2, strip_heights)
                xi(:, c) = q(5)
            end associate
        end do
        call self%director%append(reshape(w, [size(w)]), error)
        if (.not. allocated(error)) call self%xi%append(reshape(xi, [size(xi)]), error)
        call gauge%read_columns(u, values(:, 1), values(:, 2), values(:, 3), values(:, 4), values(:, 5))
        do i = 1, size(scalar_names)
            if (.not. allocated(error)) call self%scalars(i)%append(values(:, i), error)
        end do
    end subroutine append_strains

    !> Hand all rows to the file; the number of rows last, so that no row is counted that is not there.
    subroutine flush(self, error)
        class(paraview_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (.not. self%is_open) return
        call for_every_series(self, .false., error)
        if (.not. allocated(error)) call extend(self%ones, self%rows, error)
        if (.not. allocated(error)) call extend(self%zeros, self%rows, error)
        if (.not. allocated(error)) call replace_attribute(self%steps, 'NSteps', self%rows, error)
    end subroutine flush

    subroutine close_paraview(self, error)
        class(paraview_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (.not. self%is_open) return
        call self%flush(error)
        if (.not. allocated(error)) call for_every_series(self, .true., error)
        if (.not. allocated(error)) then
            call close_dataset(self%ones)
            call close_dataset(self%zeros)
            call close_group(self%steps)
        end if
        self%is_open = .false.
    end subroutine close_paraview

    subroutine for_every_series(self, closing, error)
        class(paraview_t), intent(inout) :: self
        logical, intent(in) :: closing
        type(error_t), allocatable, intent(out) :: error
        integer :: i

        call one(self%places)
        call one(self%displacement)
        call one(self%director)
        call one(self%xi)
        do i = 1, size(self%scalars)
            call one(self%scalars(i))
        end do
        call one(self%values)
        call one(self%offsets)

    contains

        subroutine one(series)
            type(series_t), intent(inout) :: series

            if (allocated(error) .or. series%dataset < 0) return
            if (closing) then
                call series%close(error)
            else
                call series%flush(error)
            end if
        end subroutine one

    end subroutine for_every_series

end module gb_paraview
