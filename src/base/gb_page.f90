!> A text of many lines, put together before it is printed.
module gb_page
    use gb_text, only: newline
    implicit none
    private

    type, public :: page_t
        character(:), allocatable :: text
    contains
        procedure :: line
        procedure :: lines
    end type page_t

contains

    pure subroutine line(self, words)
        class(page_t), intent(inout) :: self
        character(*), intent(in) :: words

        if (.not. allocated(self%text)) self%text = ''
        self%text = self%text // words // newline
    end subroutine line

    !> Several lines, without the blanks at their ends.
    pure subroutine lines(self, words)
        class(page_t), intent(inout) :: self
        character(*), intent(in) :: words(:)
        integer :: i

        do i = 1, size(words)
            call self%line(trim(words(i)))
        end do
    end subroutine lines

end module gb_page
