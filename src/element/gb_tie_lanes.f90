!> A chain of nodes that is tied to the node A before its first one: each node that is eliminated
!> (gb_blocks_lanes) hands its coupling with A on to the next node.
module gb_tie_lanes
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_fields, only: n_fields
    use gb_blocks_lanes, only: n_triangle, n_block, n_kept_node
    implicit none
    private

    public :: hold_tie, pass_on_tie, follow_tie

contains

    !> Held fields of a node: A is not coupled to them.
    pure subroutine hold_tie(free, c)
        real(wp), intent(in) :: free(lanes, n_fields)           !! 0 where a field is held, else 1
        real(wp), intent(inout) :: c(lanes, n_fields, n_fields) !! as pass_on_tie's
        integer :: i, j

        do j = 1, n_fields
            do i = 1, n_fields
                c(:, i, j) = c(:, i, j)*free(:, j)
            end do
        end do
    end subroutine hold_tie

    !> A node has been eliminated, K = L D L'. Let c be its coupling to A (rows of A, its own columns), n that
    !> to the next node, and Y = L^-1 c'. Then A's block loses Y' D^-1 Y, and its residual Y' D^-1 L^-1 r; and
    !> c becomes -Y' D^-1 L^-1 n, which couples A to the next node.
    pure subroutine pass_on_tie(kept, inverse, c, k, r, tie)
        real(wp), intent(in) :: kept(lanes, n_kept_node)        !! as eliminate_node's
        real(wp), intent(in) :: inverse(lanes, n_fields)        !! 1/D
        real(wp), intent(inout) :: c(lanes, n_fields, n_fields)
        real(wp), intent(inout) :: k(lanes, n_triangle), r(lanes, n_fields)     !! of A
        real(wp), intent(out) :: tie(lanes, n_block)            !! D^-1 Y, column by column of A
        real(wp) :: y(lanes, n_fields, n_fields), y1, y2, y3, y4, y5
        integer :: l, i, j

        !GCC$ unroll 5
        do i = 1, n_fields
            do l = 1, lanes
                y1 = c(l, i, 1)
                y2 = c(l, i, 2) - kept(l, 1)*y1
                y3 = c(l, i, 3) - kept(l, 2)*y1 - kept(l, 3)*y2
                y4 = c(l, i, 4) - kept(l, 4)*y1 - kept(l, 5)*y2 - kept(l, 6)*y3
                y5 = c(l, i, 5) - kept(l, 7)*y1 - kept(l, 8)*y2 - kept(l, 9)*y3 - kept(l, 10)*y4
                y(l, 1, i) = y1
                y(l, 2, i) = y2
                y(l, 3, i) = y3
                y(l, 4, i) = y4
                y(l, 5, i) = y5
                tie(l, 5*i - 4) = inverse(l, 1)*y1
                tie(l, 5*i - 3) = inverse(l, 2)*y2
                tie(l, 5*i - 2) = inverse(l, 3)*y3
                tie(l, 5*i - 1) = inverse(l, 4)*y4
                tie(l, 5*i) = inverse(l, 5)*y5
                r(l, i) = r(l, i) - y1*kept(l, 36) - y2*kept(l, 37) - y3*kept(l, 38) - y4*kept(l, 39) &
                    - y5*kept(l, 40)
            end do
        end do
        !GCC$ unroll 5
        do j = 1, n_fields
            !GCC$ unroll 5
            do i = 1, n_fields
                do l = 1, lanes
                    c(l, i, j) = -y(l, 1, i)*kept(l, 5*j + 6) - y(l, 2, i)*kept(l, 5*j + 7) &
                        - y(l, 3, i)*kept(l, 5*j + 8) - y(l, 4, i)*kept(l, 5*j + 9) &
                        - y(l, 5, i)*kept(l, 5*j + 10)
                end do
            end do
        end do
        !GCC$ unroll 5
        do j = 1, n_fields
            !GCC$ unroll 5
            do i = 1, j
                do l = 1, lanes
                    k(l, j*(j - 1)/2 + i) = k(l, j*(j - 1)/2 + i) - y(l, 1, i)*tie(l, 5*j - 4) &
                        - y(l, 2, i)*tie(l, 5*j - 3) - y(l, 3, i)*tie(l, 5*j - 2) &
                        - y(l, 4, i)*tie(l, 5*j - 1) - y(l, 5, i)*tie(l, 5*j)
                end do
            end do
        end do
    end subroutine pass_on_tie

    !> Put the increment x of A into what is kept of an eliminated node: D^-1 L^-1 r <- D^-1 (L^-1 r + Y x).
    pure subroutine follow_tie(tie, x, kept)
        real(wp), intent(in) :: tie(lanes, n_block), x(lanes, n_fields)
        real(wp), intent(inout) :: kept(lanes, n_kept_node)
        integer :: i

        !GCC$ unroll 5
        do i = 1, n_fields
            kept(:, 35 + i) = kept(:, 35 + i) + tie(:, i)*x(:, 1) + tie(:, i + 5)*x(:, 2) &
                + tie(:, i + 10)*x(:, 3) + tie(:, i + 15)*x(:, 4) + tie(:, i + 20)*x(:, 5)
        end do
    end subroutine follow_tie

end module gb_tie_lanes
