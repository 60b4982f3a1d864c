!> Largest values of the five fields in a vector of unknowns.
module gb_norms
    use gb_kinds, only: wp
    use gb_fields, only: n_fields
    implicit none
    private

    public :: largest_values

    !> Unknowns of the nodes that are looked at side by side: the loop over them fills vector registers.
    integer, parameter :: group = 4*n_fields

contains

    !> Largest absolute value of each field; huge where a value of any field is not finite.
    pure function largest_values(u) result(largest)
        real(wp), intent(in), contiguous :: u(:)    !! (5 nn)
        real(wp) :: largest(n_fields)
        real(wp) :: most(group), check(group)       !! check: made NaN by infinities and NaNs
        integer :: i, k, first

        most = 0.0_wp
        check = 0.0_wp
        if (size(u) < group) then
            do k = 1, size(u)
                most(k) = abs(u(k))
                check(k) = 0.0_wp*u(k)
            end do
        else
            do i = 0, size(u) - 1, group
                ! The last group has some of those before it once more: fields repeat with the nodes.
                first = min(i, size(u) - group)
                do k = 1, group
                    most(k) = max(most(k), abs(u(first + k)))
                    check(k) = check(k) + 0.0_wp*u(first + k)
                end do
            end do
        end if
        do k = 1, n_fields
            largest(k) = max(most(k), most(k + n_fields), most(k + 2*n_fields), most(k + 3*n_fields))
        end do
        if (.not. all(check >= 0.0_wp)) largest = huge(largest)
    end function largest_values

end module gb_norms
