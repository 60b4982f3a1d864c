!> What a run must remember to go on as if it had never stopped: named arrays of numbers.
!>
!> Whoever owns hidden state has one procedure that passes each piece of it in one line, and that serves both
!> ways: a memory that is being made takes a copy of what it is passed, one that is being recalled gives it
!> back. Files write and read a memory without knowing what it holds.
module gb_memory
    use gb_kinds, only: wp
    use gb_error, only: error_t, raise, status_file
    implicit none
    private

    !> One piece: either reals or integers.
    type, public :: item_t
        character(:), allocatable :: name
        real(wp), allocatable :: reals(:)
        integer, allocatable :: integers(:)
    end type item_t

    type, public :: memory_t
        logical :: is_recalling = .false.           !! whether passing gives back
        integer :: n = 0
        type(item_t), allocatable :: items(:)       !! the first n are in use
        character(:), allocatable :: misfit         !! name of the first piece that was not there as asked for
    contains
        procedure :: clear
        procedure :: add
        procedure :: check
        procedure, private :: pass_real
        procedure, private :: pass_reals
        procedure, private :: pass_integer
        procedure, private :: pass_integers
        procedure, private :: pass_logical
        generic :: pass => pass_real, pass_reals, pass_integer, pass_integers, pass_logical
    end type memory_t

contains

    !> Forget everything, and begin to take copies.
    subroutine clear(self)
        class(memory_t), intent(inout) :: self

        self%is_recalling = .false.
        self%n = 0
        if (allocated(self%items)) deallocate (self%items)
        if (allocated(self%misfit)) deallocate (self%misfit)
    end subroutine clear

    !> Put in a piece as it is.
    subroutine add(self, item)
        class(memory_t), intent(inout) :: self
        type(item_t), intent(in) :: item
        type(item_t), allocatable :: grown(:)

        if (.not. allocated(self%items)) allocate (self%items(64))
        if (self%n == size(self%items)) then
            allocate (grown(2*self%n))
            grown(:self%n) = self%items
            call move_alloc(grown, self%items)
        end if
        self%n = self%n + 1
        self%items(self%n) = item
    end subroutine add

    !> After recalling: an error (status_file) where some piece was absent or of another size or kind.
    subroutine check(self, error)
        class(memory_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        if (.not. allocated(self%misfit)) return
        call raise(error, status_file, 'the checkpoint does not fit this model: ''' // self%misfit &
            // ''' is missing in it, or has another size')
    end subroutine check

    !> The piece of that name, 0 where there is none.
    pure integer function find(self, name) result(i)
        class(memory_t), intent(in) :: self
        character(*), intent(in) :: name

        do i = 1, self%n
            if (self%items(i)%name == name) return
        end do
        i = 0
    end function find

    subroutine pass_reals(self, name, values)
        class(memory_t), intent(inout) :: self
        character(*), intent(in) :: name
        real(wp), intent(inout) :: values(:)
        type(item_t) :: item
        integer :: i

        if (self%is_recalling) then
            i = find(self, name)
            if (i > 0) then
                if (allocated(self%items(i)%reals)) then
                    if (size(self%items(i)%reals) == size(values)) then
                        values = self%items(i)%reals
                        return
                    end if
                end if
            end if
            if (.not. allocated(self%misfit)) self%misfit = name
        else
            item%name = name
            item%reals = values
            call self%add(item)
        end if
    end subroutine pass_reals

    subroutine pass_integers(self, name, values)
        class(memory_t), intent(inout) :: self
        character(*), intent(in) :: name
        integer, intent(inout) :: values(:)
        type(item_t) :: item
        integer :: i

        if (self%is_recalling) then
            i = find(self, name)
            if (i > 0) then
                if (allocated(self%items(i)%integers)) then
                    if (size(self%items(i)%integers) == size(values)) then
                        values = self%items(i)%integers
                        return
                    end if
                end if
            end if
            if (.not. allocated(self%misfit)) self%misfit = name
        else
            item%name = name
            item%integers = values
            call self%add(item)
        end if
    end subroutine pass_integers

    subroutine pass_real(self, name, number)
        class(memory_t), intent(inout) :: self
        character(*), intent(in) :: name
        real(wp), intent(inout) :: number
        real(wp) :: values(1)

        values = number
        call self%pass_reals(name, values)
        number = values(1)
    end subroutine pass_real

    subroutine pass_integer(self, name, number)
        class(memory_t), intent(inout) :: self
        character(*), intent(in) :: name
        integer, intent(inout) :: number
        integer :: values(1)

        values = number
        call self%pass_integers(name, values)
        number = values(1)
    end subroutine pass_integer

    subroutine pass_logical(self, name, flag)
        class(memory_t), intent(inout) :: self
        character(*), intent(in) :: name
        logical, intent(inout) :: flag
        integer :: values(1)

        values = merge(1, 0, flag)
        call self%pass_integers(name, values)
        flag = values(1) /= 0
    end subroutine pass_logical

end module gb_memory
