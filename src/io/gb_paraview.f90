!> The motion for ParaView, in VTK's own HDF5 format: /VTKHDF, a temporal unstructured grid. The beam is a
!> strip of quads, two across the thickness, whose points move; the topology is written once. All commands
!> that have a course follow one another on one clock (a STATIC's load factor counts as its time). Numbers are
!> stored with 32 bits: enough for a picture, and half the size.
module gb_paraview
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_fields, only: n_fields
    use gb_gauge, only: gauge_t
    use gb_memory, only: memory_t
    use gb_model, only: units_t
    use gb_strip, only: strip_t, strip_heights, strip_levels
    use gb_archive, only: archive_t, root, stored_real32, stored_real64, stored_int64, stored_uint8
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
        integer :: steps = 0                        !! group Steps, which knows the number of rows
        real(wp), allocatable :: x(:)               !! reference X1 of the columns [L]
        type(strip_t) :: strip
        real(wp) :: clock = 0.0_wp                  !! of the last row
        real(wp) :: last_abscissa = 0.0_wp          !! of the running command
        logical :: at_start = .true.                !! the next row is the first of a command
        !> Nodes of the series.
        integer :: values = 0, offsets = 0, zeros = 0, ones = 0, places = 0, displacement = 0, director = 0, &
            xi = 0, scalars(size(scalar_names)) = 0
    contains
        procedure :: open => open_paraview
        procedure :: begin_task
        procedure :: append
        procedure :: count_rows
        procedure :: pass_memory
    end type paraview_t

contains

    !> Create /VTKHDF with all that does not move. `has_strains` asks for director, xi and strains at the
    !> points too.
    subroutine open_paraview(self, archive, x, gauge, units, has_strains, error)
        class(paraview_t), intent(inout) :: self
        type(archive_t), intent(inout) :: archive
        real(wp), intent(in) :: x(:)                !! reference X1 of the nodes [L]
        class(gauge_t), intent(in) :: gauge
        type(units_t), intent(in) :: units
        logical, intent(in) :: has_strains
        type(error_t), allocatable, intent(out) :: error
        integer :: group

        self%strip = gauge%strip
        self%x = x(self%strip%node(:self%strip%columns))
        self%points = strip_heights*self%strip%columns
        self%has_strains = has_strains
        call archive%add_group(root, 'VTKHDF', group)
        call archive%set(group, 'Version', format_version)
        call archive%set_ascii(group, 'Type', 'UnstructuredGrid')
        call write_topology(self, archive, group, error)
        call add_steps(self, archive, group, units)
        call add_fields(self, archive, group, units)
        self%is_open = .not. allocated(error)
    end subroutine open_paraview

    !> The quads, by the points of their corners; those of a column are numbered from bottom to top.
    subroutine write_topology(self, archive, group, error)
        class(paraview_t), intent(in) :: self
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: group
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
        call archive%put(group, 'NumberOfPoints', [self%points], stored_int64, '', 'points of the strip', &
            error)
        if (.not. allocated(error)) call archive%put(group, 'NumberOfCells', [n/4], stored_int64, '', &
            'quads of the strip', error)
        if (.not. allocated(error)) call archive%put(group, 'NumberOfConnectivityIds', [n], stored_int64, &
            '', &
            'corners of all quads', error)
        if (.not. allocated(error)) call archive%put(group, 'Connectivity', corners(:n), stored_int64, '', &
            'points of the quads, four each, counted from 0', error)
        if (.not. allocated(error)) call archive%put(group, 'Offsets', [(4*i, i=0, n/4)], stored_int64, '', &
            'first corner of every quad, and the end', error)
        if (.not. allocated(error)) call archive%put(group, 'Types', [(vtk_quad, i=1, n/4)], stored_uint8, &
            '', &
            'kind of every cell in VTK''s numbers', error)
    end subroutine write_topology

    !> Group Steps: the clock, and where the numbers of each row begin.
    subroutine add_steps(self, archive, group, units)
        class(paraview_t), intent(inout) :: self
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: group
        type(units_t), intent(in) :: units

        call archive%add_group(group, 'Steps', self%steps)
        call archive%set(self%steps, 'NSteps', 0)
        call archive%add_series(self%steps, 'Values', [integer ::], stored_real64, units%time, &
            'time of every row; commands follow one another', self%values)
        call archive%add_series(self%steps, 'PointOffsets', [integer ::], stored_int64, '', &
            'first point of every row', self%offsets)
        call archive%add_series(self%steps, 'NumberOfParts', [integer ::], stored_int64, '', &
            'the strip is one part', self%ones)
        call archive%add_series(self%steps, 'PartOffsets', [integer ::], stored_int64, '', &
            'the topology is the same in every row', self%zeros)
        call archive%add_link(self%steps, 'CellOffsets', self%zeros)
        call archive%add_link(self%steps, 'ConnectivityIdOffsets', self%zeros)
    end subroutine add_steps

    subroutine add_fields(self, archive, group, units)
        class(paraview_t), intent(inout) :: self
        type(archive_t), intent(inout) :: archive
        integer, intent(in) :: group
        type(units_t), intent(in) :: units
        character(:), allocatable :: unit
        integer :: data, offsets, i

        call archive%add_series(group, 'Points', [3], stored_real32, units%length, &
            'deformed places of the points', self%places, self%points)
        call archive%add_group(group, 'PointData', data)
        call archive%add_group(self%steps, 'PointDataOffsets', offsets)
        call add('u', [3], units%length, 'displacement', self%displacement)
        if (.not. self%has_strains) return
        call add('director', [3], '1', 'director w, along which the section stands', self%director)
        unit = ''
        if (len(units%length) > 0) unit = '1/' // units%length
        call add('xi', [integer ::], unit, 'quadratic part of the thickness stretch', self%xi)
        do i = 1, size(scalar_names)
            unit = '1'
            if (i == size(scalar_names)) unit = ''
            if (i == size(scalar_names) .and. len(units%force) > 0 .and. len(units%length) > 0) then
                unit = units%force // '/' // units%length // '^2'
            end if
            call add(trim(scalar_names(i)), [integer ::], unit, trim(scalar_descriptions(i)), self%scalars(i))
        end do

    contains

        subroutine add(name, shape_of, unit, description, node)
            character(*), intent(in) :: name, unit, description
            integer, intent(in) :: shape_of(:)
            integer, intent(out) :: node

            call archive%add_series(data, name, shape_of, stored_real32, unit, description, node, self%points)
            call archive%add_link(offsets, name, self%offsets)
        end subroutine add

    end subroutine add_fields

    !> The next row starts another command.
    pure subroutine begin_task(self)
        class(paraview_t), intent(inout) :: self

        self%at_start = .true.
    end subroutine begin_task

    !> A row: the state u at `abscissa`, time or load factor of the running command. The first state of a
    !> later command is the last one of the command before, which is there already.
    subroutine append(self, archive, gauge, abscissa, u, error)
        class(paraview_t), intent(inout) :: self
        type(archive_t), intent(inout) :: archive
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
        call archive%append(self%values, [self%clock], error)
        if (.not. allocated(error)) call archive%append(self%offsets, [real(self%rows, &
            wp)*real(self%points, wp)], &
            error)
        if (.not. allocated(error)) call archive%append(self%ones, [1.0_wp], error)
        if (.not. allocated(error)) call archive%append(self%zeros, [0.0_wp], error)
        self%rows = self%rows + 1
        if (.not. allocated(error)) call append_places(self, archive, u, error)
        if (self%has_strains .and. .not. allocated(error)) call append_strains(self, archive, gauge, u, error)
    end subroutine append

    !> x = (X1 + u1, u3) + (X3 + xi X3^2) (y1, 1+y3), and x less the point's place at rest.
    subroutine append_places(self, archive, u, error)
        class(paraview_t), intent(in) :: self
        type(archive_t), intent(inout) :: archive
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
        call archive%append(self%places, reshape(place, [size(place)]), error)
        if (.not. allocated(error)) call archive%append(self%displacement, reshape(moved, [size(moved)]), &
            error)
    end subroutine append_places

    subroutine append_strains(self, archive, gauge, u, error)
        class(paraview_t), intent(in) :: self
        type(archive_t), intent(inout) :: archive
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
        call archive%append(self%director, reshape(w, [size(w)]), error)
        if (.not. allocated(error)) call archive%append(self%xi, reshape(xi, [size(xi)]), error)
        call gauge%read_columns(u, values(:, 1), values(:, 2), values(:, 3), values(:, 4), values(:, 5))
        do i = 1, size(scalar_names)
            if (.not. allocated(error)) call archive%append(self%scalars(i), values(:, i), error)
        end do
    end subroutine append_strains

    !> What the next row depends on.
    subroutine pass_memory(self, memory)
        class(paraview_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory

        if (.not. self%is_open) return
        call memory%pass('paraview.rows', self%rows)
        call memory%pass('paraview.clock', self%clock)
        call memory%pass('paraview.last_abscissa', self%last_abscissa)
        call memory%pass('paraview.at_start', self%at_start)
    end subroutine pass_memory

    !> Tell VTK how many rows there are, before they are made visible.
    subroutine count_rows(self, archive)
        class(paraview_t), intent(in) :: self
        type(archive_t), intent(inout) :: archive

        if (self%is_open) call archive%set(self%steps, 'NSteps', self%rows)
    end subroutine count_rows

end module gb_paraview
