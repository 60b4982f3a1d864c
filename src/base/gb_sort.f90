!> Sorting of short and long lists of numbers.
module gb_sort
    use gb_kinds, only: wp
    implicit none
    private

    public :: sorted

contains

    !> The values in increasing order, by merging halves: n log n, equal values kept.
    pure recursive function sorted(values) result(ordered)
        real(wp), intent(in) :: values(:)
        real(wp), allocatable :: ordered(:)
        real(wp), allocatable :: low(:), high(:)
        integer :: half, i, j, k

        ordered = values
        if (size(values) < 2) return
        half = size(values)/2
        low = sorted(values(:half))
        high = sorted(values(half + 1:))
        i = 1
        j = 1
        do k = 1, size(values)
            if (j > size(high)) then
                ordered(k) = low(i)
                i = i + 1
            else if (i > size(low)) then
                ordered(k) = high(j)
                j = j + 1
            else if (low(i) <= high(j)) then
                ordered(k) = low(i)
                i = i + 1
            else
                ordered(k) = high(j)
                j = j + 1
            end if
        end do
    end function sorted

end module gb_sort
