!> Interfaces of the LAPACK and BLAS routines in use.
module gb_lapack
    implicit none
    private

    public :: dpbtrf, dpbtrs, dgbtrf, dgbtrs, dsbmv, dgbmv, dsygv, dsyev

    interface
        !> Cholesky factors of a symmetric positive definite band matrix; info > 0: leading minor not positive
        !> definite.
        pure subroutine dpbtrf(uplo, n, kd, ab, ldab, info)
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, kd, ldab
            double precision, intent(inout) :: ab(ldab, *)
            integer, intent(out) :: info
        end subroutine dpbtrf

        pure subroutine dpbtrs(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, kd, nrhs, ldab, ldb
            double precision, intent(in) :: ab(ldab, *)
            double precision, intent(inout) :: b(ldb, *)
            integer, intent(out) :: info
        end subroutine dpbtrs

        !> LU factors of a general band matrix with row interchanges; info > 0: that pivot is exactly zero.
        pure subroutine dgbtrf(m, n, kl, ku, ab, ldab, ipiv, info)
            integer, intent(in) :: m, n, kl, ku, ldab
            double precision, intent(inout) :: ab(ldab, *)
            integer, intent(out) :: ipiv(*), info
        end subroutine dgbtrf

        pure subroutine dgbtrs(trans, n, kl, ku, nrhs, ab, ldab, ipiv, b, ldb, info)
            character(1), intent(in) :: trans
            integer, intent(in) :: n, kl, ku, nrhs, ldab, ldb, ipiv(*)
            double precision, intent(in) :: ab(ldab, *)
            double precision, intent(inout) :: b(ldb, *)
            integer, intent(out) :: info
        end subroutine dgbtrs

        !> y <- alpha A x + beta y, A a symmetric band matrix.
        pure subroutine dsbmv(uplo, n, k, alpha, a, lda, x, incx, beta, y, incy)
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, k, lda, incx, incy
            double precision, intent(in) :: alpha, beta, a(lda, *), x(*)
            double precision, intent(inout) :: y(*)
        end subroutine dsbmv

        !> y <- alpha A x + beta y, A a general band matrix.
        pure subroutine dgbmv(trans, m, n, kl, ku, alpha, a, lda, x, incx, beta, y, incy)
            character(1), intent(in) :: trans
            integer, intent(in) :: m, n, kl, ku, lda, incx, incy
            double precision, intent(in) :: alpha, beta, a(lda, *), x(*)
            double precision, intent(inout) :: y(*)
        end subroutine dgbmv

        !> Eigenvalues and vectors of a dense symmetric-definite pencil A x = lambda B x (small, projected).
        pure subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
            integer, intent(in) :: itype, n, lda, ldb, lwork
            character(1), intent(in) :: jobz, uplo
            double precision, intent(inout) :: a(lda, *), b(ldb, *)
            double precision, intent(out) :: w(*), work(*)
            integer, intent(out) :: info
        end subroutine dsygv

        !> Eigenvalues, increasing, of a dense symmetric matrix (an element's).
        pure subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
            character(1), intent(in) :: jobz, uplo
            integer, intent(in) :: n, lda, lwork
            double precision, intent(inout) :: a(lda, *)
            double precision, intent(out) :: w(*), work(*)
            integer, intent(out) :: info
        end subroutine dsyev
    end interface

end module gb_lapack
