!> Symmetric band systems whose unknowns come element by element, K x = b, solved by static condensation. The
!> unknowns between an element's end nodes (i) couple with those of its ends (e) and with nothing else, so
!> that they are eliminated element by element, K_ii = L D L':
!>
!>     (K_ee - C' D^-1 C) x_e = b_e - C' D^-1 y,   C = L^-1 K_ie,   y = L^-1 b_i,
!>     D L' x_i = y - C x_e.
!>
!> The first of these is summed over the elements and left to LAPACK. Its half width is 9 whatever the
!> elements; ten three-node elements have 55 unknowns there, where K has 105 and half width 14.
module gb_condensed
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    use gb_band, only: band_t, set_zero
    implicit none
    private

    integer, parameter :: n_ends = 2*n_fields           !! unknowns of an element's ends, left before right
    !> In a column of `factors`: C' in the rows to n_ends, y in row at_y, L D in the rows after at_ld.
    integer, parameter :: at_y = n_ends + 1, at_ld = n_ends + 1

    type, public :: condensed_t
        private
        integer, allocatable :: first(:)                !! unknowns before an element's first (ne)
        integer, allocatable :: interior(:)             !! unknowns between its end nodes (ne)
        integer, allocatable :: before(:)               !! interior unknowns of the elements before it (ne)
        real(wp), allocatable :: factors(:, :)          !! a column for each interior unknown: C', y, L D
                                                        !! with D^-1 for its diagonal
        type(band_t) :: band                            !! of the end nodes, left to LAPACK
        real(wp), allocatable :: x_ends(:)              !! (5 (ne + 1))
    contains
        procedure :: set_up
        procedure :: solve
    end type condensed_t

contains

    !> For elements that follow one another, each with the last node of the one before as its first.
    pure subroutine set_up(self, first, nodes)
        class(condensed_t), intent(inout) :: self
        integer, intent(in) :: first(:)                 !! unknowns before an element's first (ne)
        integer, intent(in) :: nodes(:)                 !! (ne)
        integer :: e

        self%first = first
        self%interior = n_fields*(nodes - 2)
        self%before = [(first(e) - n_fields*(e - 1), e=1, size(first))]
        allocate (self%factors(at_ld + maxval(self%interior), sum(self%interior)))
        call self%band%set_up(n_fields*(size(nodes) + 1), n_ends - 1, symmetric=.true.)
        allocate (self%x_ends(self%band%n))
    end subroutine set_up

    !> x <- k^-1 x. Not solved, and x as it was: some K_ii is not positive definite (nor is k then), or what
    !> is left of k is singular.
    pure subroutine solve(self, k, x, is_solved)
        class(condensed_t), intent(inout) :: self
        type(band_t), intent(in) :: k                   !! symmetric
        real(wp), intent(inout) :: x(k%n)               !! right-hand side in, solution out
        logical, intent(out) :: is_solved
        integer :: singular

        call condense(self, k, x, is_solved)
        if (.not. is_solved) return
        call self%band%factorise(singular)
        is_solved = singular == 0
        if (.not. is_solved) return
        call self%band%solve(1, self%x_ends)
        call recover(self, k%n, x)
    end subroutine solve

    !> Eliminate the interior unknowns element by element, from left to right; sum up what they leave at the
    !> end nodes.
    pure subroutine condense(self, k, b, is_definite)
        class(condensed_t), intent(inout) :: self
        type(band_t), intent(in) :: k
        real(wp), intent(in) :: b(k%n)
        logical, intent(out) :: is_definite
        real(wp) :: ends(n_ends, n_ends + 1)        !! K_ee, lower triangle, and b_e of an element
        integer :: e

        is_definite = .true.
        ends = 0.0_wp
        do e = 1, size(self%first)
            associate (first => self%first(e), n => self%interior(e), rows => size(self%factors, 1), &
                factors => self%factors(:, self%before(e) + 1:self%before(e) + self%interior(e)))
                call pass_on(ends)
                call take_columns(k%kd, n, k%a(:, first + 1:first + n_fields + n), &
                    b(first + 1:first + n_fields + n), rows, factors, ends)
                call eliminate(n, rows, factors, is_definite)
                if (.not. is_definite) return
                call subtract_interior(n, rows, factors, ends)
                call put_node(self, e, ends)
            end associate
        end do
        call pass_on(ends)
        call add_node(k%kd, k%a(:, k%n - n_fields + 1:), b(k%n - n_fields + 1:), ends)
        call put_node(self, e, ends)
    end subroutine condense

    !> From an element to the next one: what stands at the right node stands at the left one then.
    pure subroutine pass_on(ends)
        real(wp), intent(inout) :: ends(n_ends, n_ends + 1)

        ends(:n_fields, :n_fields) = ends(n_fields + 1:, n_fields + 1:n_ends)
        ends(:n_fields, n_ends + 1) = ends(n_fields + 1:, n_ends + 1)
        ends(n_fields + 1:, :) = 0.0_wp
        ends(:n_fields, n_fields + 1:n_ends) = 0.0_wp
    end subroutine pass_on

    !> Add the block and right-hand side of a node, out of its columns a of K, to those of the left node.
    pure subroutine add_node(kd, a, b, ends)
        integer, intent(in) :: kd
        real(wp), intent(in) :: a(0:kd, n_fields)       !! as in gb_band
        real(wp), intent(in) :: b(n_fields)
        real(wp), intent(inout) :: ends(n_ends, n_ends + 1)
        integer :: j

        do j = 1, n_fields
            ends(j:n_fields, j) = ends(j:n_fields, j) + a(0:n_fields - j, j)
        end do
        ends(:n_fields, n_ends + 1) = ends(:n_fields, n_ends + 1) + b
    end subroutine add_node

    !> The left node of an element is complete: its columns into the band, and its right-hand side.
    pure subroutine put_node(self, e, ends)
        class(condensed_t), intent(inout) :: self
        integer, intent(in) :: e
        real(wp), intent(in) :: ends(n_ends, n_ends + 1)
        integer :: j

        associate (before => n_fields*(e - 1))
            do j = 1, n_fields
                self%band%a(:n_ends - j, before + j) = ends(j:n_ends, j)
            end do
            self%x_ends(before + 1:before + n_fields) = ends(:n_fields, n_ends + 1)
        end associate
    end subroutine put_node

    !> Out of the columns a of K that belong to an element's left node and interior, and of the right-hand
    !> side b there: K_ei, b_i and the lower triangle of K_ii by columns; K_ee and b_e. The right node's own
    !> block and right-hand side are the next element's.
    pure subroutine take_columns(kd, n, a, b, rows, columns, ends)
        integer, intent(in) :: kd, n, rows
        real(wp), intent(in) :: a(0:kd, n_fields + n)   !! as in gb_band
        real(wp), intent(in) :: b(n_fields + n)
        real(wp), intent(out) :: columns(rows, n)
        real(wp), intent(inout) :: ends(n_ends, n_ends + 1)
        integer :: i, j

        call set_zero(rows*n, columns)
        do j = 1, n
            do i = 1, n_fields
                columns(i, j) = a(n_fields + j - i, i)
                columns(n_fields + i, j) = a(n - j + i, n_fields + j)
            end do
            columns(at_y, j) = b(n_fields + j)
            columns(at_ld + j:at_ld + n, j) = a(0:n - j, n_fields + j)
        end do
        call add_node(kd, a, b, ends)
        do j = 1, n_fields
            ends(n_fields + 1:, j) = a(n_fields + n + 1 - j:n_ends + n - j, j)
        end do
    end subroutine take_columns

    !> From columns of K_ei, b_i and K_ii to those of C', y and L D, with D^-1 for the diagonal. Whole columns
    !> are subtracted, K_ii's upper triangle and all, because long vectors cost less than exact ones.
    pure subroutine eliminate(n, rows, columns, is_definite)
        integer, intent(in) :: n, rows
        real(wp), intent(inout) :: columns(rows, n)
        logical, intent(out) :: is_definite             !! all pivots are positive
        real(wp) :: inverse
        integer :: i, j

        is_definite = .true.
        do j = 1, n
            is_definite = columns(at_ld + j, j) > 0.0_wp
            if (.not. is_definite) return
            inverse = 1.0_wp/columns(at_ld + j, j)
            do i = j + 1, n
                columns(:, i) = columns(:, i) - (columns(at_ld + i, j)*inverse)*columns(:, j)
            end do
            columns(at_ld + j, j) = inverse
        end do
    end subroutine eliminate

    !> K_ee <- K_ee - C' D^-1 C, and in the last column b_e <- b_e - C' D^-1 y.
    pure subroutine subtract_interior(n, rows, factors, ends)
        integer, intent(in) :: n, rows
        real(wp), intent(in) :: factors(rows, n)
        real(wp), intent(inout) :: ends(n_ends, n_ends + 1)
        integer :: i, j

        do i = 1, n
            do j = 1, n_ends + 1
                ends(:, j) = ends(:, j) - (factors(at_ld + i, i)*factors(j, i))*factors(:n_ends, i)
            end do
        end do
    end subroutine subtract_interior

    !> All unknowns from those of the end nodes.
    pure subroutine recover(self, n_unknowns, x)
        class(condensed_t), intent(in) :: self
        integer, intent(in) :: n_unknowns
        real(wp), intent(inout) :: x(n_unknowns)
        integer :: e

        do e = 1, size(self%first)
            associate (first => self%first(e), n => self%interior(e), at => n_fields*(e - 1))
                x(first + 1:first + n_fields) = self%x_ends(at + 1:at + n_fields)
                call recover_interior(n, size(self%factors, 1), &
                    self%factors(:, self%before(e) + 1:self%before(e) + n), &
                    self%x_ends(at + 1:at + n_ends), x(first + n_fields + 1:first + n_fields + n))
            end associate
        end do
        x(n_unknowns - n_fields + 1:) = self%x_ends(self%band%n - n_fields + 1:)
    end subroutine recover

    !> x_i from D L' x_i = y - C x_e, the last one first.
    pure subroutine recover_interior(n, rows, factors, x_ends, x)
        integer, intent(in) :: n, rows
        real(wp), intent(in) :: factors(rows, n)
        real(wp), intent(in) :: x_ends(n_ends)
        real(wp), intent(out) :: x(n)
        integer :: i

        do i = n, 1, -1
            x(i) = factors(at_y, i) - dot_product(factors(:n_fields, i), x_ends(:n_fields)) &
                - dot_product(factors(n_fields + 1:n_ends, i), x_ends(n_fields + 1:)) &
                - dot_product(factors(at_ld + i + 1:at_ld + n, i), x(i + 1:))
            x(i) = factors(at_ld + i, i)*x(i)
        end do
    end subroutine recover_interior

end module gb_condensed
