!> Consistent mass that does not depend on the configuration, eq. (28-32) corrected: element by element
!> density(field) times the integral of N_I N_J, never assembled.
module gb_mass
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_mesh, only: mesh_t
    use gb_shape, only: shape_table_t, shape_table, max_nodes
    use gb_beam, only: element_mass
    use gb_band, only: band_t
    implicit none
    private

    type, public :: mass_t
        integer :: n = 0                                !! unknowns
        integer, allocatable :: first(:)                !! unknowns before an element's first (ne)
        integer, allocatable :: nodes(:)                !! (ne)
        integer, allocatable :: kind(:)                 !! column of `density` (ne)
        real(wp), allocatable :: half_length(:)         !! dX1/ds [L] (ne)
        real(wp), allocatable :: density(:, :)          !! mass a unit length of each field (5, kinds)
        real(wp) :: product(max_nodes, max_nodes, max_nodes) = 0.0_wp  !! integral of N_I N_J ds (I, J, nodes)
    contains
        procedure :: set_up
        procedure :: multiply
        procedure :: energy
        procedure :: add_to
        procedure :: solve
    end type mass_t

contains

    !> kind and density as in the type.
    pure subroutine set_up(self, mesh, kind, density)
        class(mass_t), intent(inout) :: self
        type(mesh_t), intent(in) :: mesh
        integer, intent(in) :: kind(:)
        real(wp), intent(in) :: density(:, :)
        type(shape_table_t) :: table
        real(wp) :: m(n_fields, max_nodes, n_fields, max_nodes)
        integer :: e, nodes, field

        self%n = n_fields*mesh%n_nodes()
        self%first = n_fields*(mesh%first_node - 1)
        self%nodes = mesh%nodes
        self%kind = kind
        self%density = density
        self%half_length = [(0.5_wp*mesh%element_length(e), e=1, mesh%n_elements())]
        do nodes = 2, max_nodes
            table = shape_table(nodes, nodes)
            call element_mass(nodes, nodes, table%n, table%w, [(1.0_wp, field=1, n_fields)], m(:, :nodes, &
                :, :nodes))
            self%product(:nodes, :nodes, nodes) = m(1, :nodes, 1, :nodes)
        end do
    end subroutine set_up

    !> y <- M x.
    pure subroutine multiply(self, x, y)
        class(mass_t), intent(in) :: self
        real(wp), intent(in) :: x(self%n)
        real(wp), intent(out) :: y(self%n)
        integer :: e, i, j, row, column

        y = 0.0_wp
        do e = 1, size(self%first)
            associate (density => self%half_length(e)*self%density(:, self%kind(e)), nodes => self%nodes(e))
                do j = 1, nodes
                    column = self%first(e) + n_fields*(j - 1)
                    do i = 1, nodes
                        row = self%first(e) + n_fields*(i - 1)
                        y(row + 1:row + n_fields) = y(row + 1:row + n_fields) + self%product(i, j, nodes) &
                            *density*x(column + 1:column + n_fields)
                    end do
                end do
            end associate
        end do
    end subroutine multiply

    !> Kinetic energy x' M x/2 of velocities x [F L].
    pure real(wp) function energy(self, x)
        class(mass_t), intent(in) :: self
        real(wp), intent(in) :: x(self%n)
        real(wp) :: part(n_fields), carried(n_fields)
        integer :: e, i, j, row, column

        energy = 0.0_wp
        do e = 1, size(self%first)
            associate (nodes => self%nodes(e))
                part = 0.0_wp
                do j = 1, nodes
                    column = self%first(e) + n_fields*(j - 1)
                    carried = (0.5_wp*self%product(j, j, nodes))*x(column + 1:column + n_fields)
                    do i = 1, j - 1
                        row = self%first(e) + n_fields*(i - 1)
                        carried = carried + self%product(i, j, nodes)*x(row + 1:row + n_fields)
                    end do
                    part = part + carried*x(column + 1:column + n_fields)
                end do
                energy = energy + self%half_length(e)*dot_product(self%density(:, self%kind(e)), part)
            end associate
        end do
    end function energy

    !> k <- k + factor M.
    pure subroutine add_to(self, factor, k)
        class(mass_t), intent(in) :: self
        real(wp), intent(in) :: factor
        type(band_t), intent(inout) :: k
        integer :: e, i, j, field, row, column
        real(wp) :: part

        do e = 1, size(self%first)
            associate (nodes => self%nodes(e))
                do j = 1, nodes
                    do i = 1, nodes
                        if (k%symmetric .and. i < j) cycle
                        part = factor*self%half_length(e)*self%product(i, j, nodes)
                        do field = 1, n_fields
                            row = self%first(e) + n_fields*(i - 1) + field
                            column = self%first(e) + n_fields*(j - 1) + field
                            k%a(row - column, column) = k%a(row - column, column) &
                                                        + part*self%density(field, self%kind(e))
                        end do
                    end do
                end do
            end associate
        end do
    end subroutine add_to

    !> a <- M^-1 r, where the unknowns in `without` have a = 0. Fields do not mix: five narrow bands in turn.
    pure subroutine solve(self, without, r, a)
        class(mass_t), intent(in) :: self
        logical, intent(in) :: without(self%n)
        real(wp), intent(in) :: r(self%n)
        real(wp), intent(out) :: a(self%n)
        type(band_t) :: band
        real(wp), allocatable :: x(:)
        integer :: field, e, i, j, row, column, singular

        call band%set_up(self%n/n_fields, maxval(self%nodes) - 1, symmetric=.true.)
        do field = 1, n_fields
            call band%clear()
            do e = 1, size(self%first)
                associate (nodes => self%nodes(e), density => self%density(field, self%kind(e)))
                    do j = 1, nodes
                        column = self%first(e)/n_fields + j
                        do i = j, nodes
                            row = self%first(e)/n_fields + i
                            band%a(row - column, column) = band%a(row - column, column) &
                                + self%half_length(e)*self%product(i, j, nodes)*density
                        end do
                    end do
                end associate
            end do
            call band%constrain(pack([(i, i=1, band%n)], without(field::n_fields)))
            x = merge(0.0_wp, r(field::n_fields), without(field::n_fields))
            call band%factorise(singular)
            call band%solve(1, x)
            a(field::n_fields) = x
        end do
    end subroutine solve

end module gb_mass
