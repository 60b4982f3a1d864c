!> Band matrices: assembly of element blocks, products, and solution by LAPACK.
!>
!> Storage, n = 6, kd = 2 (row index i-j, column j; * unused):
!>
!>     symmetric, a(0:kd, n)             general, a(-kd:kd, n)
!>      0  a11 a22 a33 a44 a55 a66       -2   *   *  a13 a24 a35 a46
!>      1  a21 a32 a43 a54 a65  *        -1   *  a12 a23 a34 a45 a56
!>      2  a31 a42 a53 a64  *   *         0  a11 a22 a33 a44 a55 a66
!>                                        1  a21 a32 a43 a54 a65  *
!>                                        2  a31 a42 a53 a64  *   *
!>
!> Symmetric matrices are factorised by Cholesky (dpbtrf) and, where they are not positive definite, by LU
!> with row interchanges (dgbtrf) like general ones.
module gb_band
    use gb_kinds, only: wp
    use gb_lapack, only: dpbtrf, dpbtrs, dgbtrf, dgbtrs, dsbmv, dgbmv
    implicit none
    private

    type, public :: band_t
        integer :: n = 0                            !! order
        integer :: kd = 0                           !! half band width
        logical :: symmetric = .true.
        real(wp), allocatable :: a(:, :)            !! see above
        logical :: is_cholesky = .false.            !! which factors are current
        real(wp), allocatable :: cholesky(:, :)     !! (0:kd, n)
        real(wp), allocatable :: lu(:, :)           !! (3 kd + 1, n)
        integer, allocatable :: pivots(:)
    contains
        procedure :: set_up
        procedure :: clear
        procedure :: add_block
        procedure :: add_symmetric
        procedure :: constrain
        procedure :: multiply
        procedure :: row_bound
        procedure :: factorise
        procedure :: solve
        procedure :: weakest_pivot
    end type band_t

    public :: set_zero

contains

    pure subroutine set_up(self, n, kd, symmetric)
        class(band_t), intent(inout) :: self
        integer, intent(in) :: n, kd
        logical, intent(in) :: symmetric

        self%n = n
        self%kd = min(kd, n - 1)
        self%symmetric = symmetric
        if (symmetric) then
            allocate (self%a(0:self%kd, n))
        else
            allocate (self%a(-self%kd:self%kd, n))
        end if
        self%a = 0.0_wp
    end subroutine set_up

    pure subroutine clear(self)
        class(band_t), intent(inout) :: self

        call set_zero(size(self%a), self%a)
    end subroutine clear

    !> Add a dense block of consecutive rows and columns, the first of them first+1.
    pure subroutine add_block(self, first, m, block)
        class(band_t), intent(inout) :: self
        integer, intent(in) :: first, m
        real(wp), intent(in) :: block(m, m)
        integer :: j

        if (self%symmetric) then
            do j = 1, m
                self%a(0:m - j, first + j) = self%a(0:m - j, first + j) + block(j:m, j)
            end do
        else
            do j = 1, m
                self%a(1 - j:m - j, first + j) = self%a(1 - j:m - j, first + j) + block(:, j)
            end do
        end if
    end subroutine add_block

    !> a <- a + factor * other, where other is symmetric and no wider.
    pure subroutine add_symmetric(self, factor, other)
        class(band_t), intent(inout) :: self
        real(wp), intent(in) :: factor
        class(band_t), intent(in) :: other
        integer :: i, j

        do j = 1, self%n
            self%a(0:other%kd, j) = self%a(0:other%kd, j) + factor*other%a(:, j)
        end do
        if (self%symmetric) return
        do j = 1, self%n
            do i = j + 1, min(self%n, j + other%kd)
                self%a(j - i, i) = self%a(j - i, i) + factor*other%a(i - j, j)
            end do
        end do
    end subroutine add_symmetric

    !> Turn the rows and columns of the listed unknowns into those of the identity.
    pure subroutine constrain(self, list)
        class(band_t), intent(inout) :: self
        integer, intent(in) :: list(:)
        integer :: i, j, k

        do k = 1, size(list)
            j = list(k)
            self%a(:, j) = 0.0_wp
            do i = max(1, j - self%kd), j - 1
                self%a(j - i, i) = 0.0_wp
            end do
            if (.not. self%symmetric) then
                do i = j + 1, min(self%n, j + self%kd)
                    self%a(j - i, i) = 0.0_wp
                end do
            end if
            self%a(0, j) = 1.0_wp
        end do
    end subroutine constrain

    !> y <- a x.
    pure subroutine multiply(self, x, y)
        class(band_t), intent(in) :: self
        real(wp), intent(in) :: x(self%n)
        real(wp), intent(inout) :: y(self%n)

        y = 0.0_wp
        if (self%symmetric) then
            call dsbmv('L', self%n, self%kd, 1.0_wp, self%a, self%kd + 1, x, 1, 0.0_wp, y, 1)
        else
            call dgbmv('N', self%n, self%n, self%kd, self%kd, 1.0_wp, self%a, 2*self%kd + 1, x, 1, 0.0_wp, &
                y, 1)
        end if
    end subroutine multiply

    !> Row sums of |a| scaled by the size of each unknown, bound(i) = sum_j |a_ij| x_j: times the unit
    !> round-off, the rounding error that a residual a*x cannot get below.
    pure subroutine row_bound(self, x, bound)
        class(band_t), intent(in) :: self
        real(wp), intent(in) :: x(self%n)
        real(wp), intent(out) :: bound(self%n)
        integer :: i, j

        bound = 0.0_wp
        do j = 1, self%n
            do i = max(1, j + lbound(self%a, 1)), min(self%n, j + self%kd)
                bound(i) = bound(i) + abs(self%a(i - j, j))*x(j)
            end do
            if (self%symmetric) then
                do i = j + 1, min(self%n, j + self%kd)
                    bound(j) = bound(j) + abs(self%a(i - j, j))*x(i)
                end do
            end if
        end do
    end subroutine row_bound

    !> Factorise. singular = 0: all went well; else the number of the unknown whose pivot vanishes.
    pure subroutine factorise(self, singular)
        class(band_t), intent(inout) :: self
        integer, intent(out) :: singular
        integer :: info

        self%is_cholesky = .false.
        singular = 0
        if (self%symmetric) then
            if (.not. allocated(self%cholesky)) allocate (self%cholesky(0:self%kd, self%n))
            call copy(size(self%a), self%a, self%cholesky)
            call dpbtrf('L', self%n, self%kd, self%cholesky, self%kd + 1, info)
            self%is_cholesky = info == 0
            if (self%is_cholesky) return
        end if
        if (.not. allocated(self%lu)) allocate (self%lu(3*self%kd + 1, self%n), self%pivots(self%n))
        call copy_to_general(self)
        call dgbtrf(self%n, self%n, self%kd, self%kd, self%lu, 3*self%kd + 1, self%pivots, info)
        singular = max(0, info)
    end subroutine factorise

    !> Into dgbtrf's layout: a_ij stands in row 2 kd + 1 + i - j of column j; the first kd rows are room for
    !> fill-in.
    pure subroutine copy_to_general(self)
        class(band_t), intent(inout) :: self
        integer :: i, j, middle

        middle = 2*self%kd + 1
        call set_zero(size(self%lu), self%lu)
        do j = 1, self%n
            do i = max(1, j + lbound(self%a, 1)), min(self%n, j + self%kd)
                self%lu(middle + i - j, j) = self%a(i - j, j)
                if (self%symmetric) self%lu(middle + j - i, i) = self%a(i - j, j)
            end do
        end do
    end subroutine copy_to_general

    !> x <- a^-1 x with the current factors, column by column.
    pure subroutine solve(self, count, x)
        class(band_t), intent(in) :: self
        integer, intent(in) :: count
        real(wp), intent(inout) :: x(self%n, count)     !! right-hand sides in, solutions out
        integer :: info

        if (self%is_cholesky) then
            call dpbtrs('L', self%n, self%kd, count, self%cholesky, self%kd + 1, x, self%n, info)
        else
            call dgbtrs('N', self%n, self%kd, self%kd, count, self%lu, 3*self%kd + 1, self%pivots, x, &
                self%n, info)
        end if
    end subroutine solve

    !> The unknown whose pivot is smallest beside its diagonal element, and that ratio: near round-off where a
    !> mechanism has passed the factorisation.
    pure subroutine weakest_pivot(self, unknown, ratio)
        class(band_t), intent(in) :: self
        integer, intent(out) :: unknown
        real(wp), intent(out) :: ratio
        real(wp) :: pivot, part
        integer :: j

        ratio = huge(ratio)
        unknown = 0
        do j = 1, self%n
            if (self%is_cholesky) then
                pivot = self%cholesky(0, j)**2
            else
                pivot = abs(self%lu(2*self%kd + 1, j))
            end if
            part = pivot/max(abs(self%a(0, j)), tiny(1.0_wp))
            if (part < ratio) then
                ratio = part
                unknown = j
            end if
        end do
    end subroutine weakest_pivot

    !> a <- 0. Of an array in one dimension the compiler makes one call, of a band one for every column.
    pure subroutine set_zero(n, a)
        integer, intent(in) :: n
        real(wp), intent(out) :: a(n)

        a = 0.0_wp
    end subroutine set_zero

    !> to <- from, in one call too.
    pure subroutine copy(n, from, to)
        integer, intent(in) :: n
        real(wp), intent(in) :: from(n)
        real(wp), intent(out) :: to(n)

        to = from
    end subroutine copy

end module gb_band
