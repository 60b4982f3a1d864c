!> Largest values of the five fields in a vector of unknowns.
module gb_norms
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    implicit none
    private

    public :: largest_values

    !> Nodes that are looked at side by side: the loop over their fields fills vector registers.
    integer, parameter :: group = 4

contains

    !> Largest absolute value of each field; huge where a value of any field is not finite.
    pure function largest_values(u) result(largest)
        real(wp), intent(in), contiguous :: u(:)    !! (5 nn)
        real(wp) :: largest(n_fields)
        real(wp) :: most(n_fields*group), not_finite(n_fields*group)
        integer :: i, k, whole

        most = 0.0_wp
        not_finite = 0.0_wp
        whole = size(u) - modulo(size(u), n_fields*group)
        do i = 0, whole - 1, n_fields*group
            do k = 1, n_fields*group
                most(k) = max(most(k), abs(u(i + k)))
                not_finite(k) = not_finite(k) + (u(i + k) - u(i + k))      ! a NaN for infinities and NaNs
            end do
        end do
        do k = 1, size(u) - whole
            most(k) = max(most(k), abs(u(whole + k)))
            not_finite(k) = not_finite(k) + (u(whole + k) - u(whole + k))
        end do
        do k = 1, n_fields
            largest(k) = maxval(most(k::n_fields))
        end do
        if (.not. all(not_finite >= 0.0_wp)) largest = huge(largest)
    end function largest_values

end module gb_norms
