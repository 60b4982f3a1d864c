!> A module that tests share without being part of what is tested.
module runner_helper
    implicit none
    private

    public :: count_of

contains

    !> How often a value occurs in a list.
    pure integer function count_of(value, list)
        integer, intent(in) :: value, list(:)
        count_of = count(list == value)
    end function count_of

end module runner_helper
