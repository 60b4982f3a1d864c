!> Names a deck defines, found again by hashing: case-insensitive, each with the place of its definition.
module gb_names
    use gb_kinds, only: i8
    use gb_text, only: lower_case
    use gb_diagnostics, only: span_t
    implicit none
    private

    integer, parameter, public :: max_name = 32     !! characters a name may have

    type, public :: name_table_t
        private
        integer, public :: n = 0                            !! names held
        character(max_name), allocatable, public :: names(:)    !! as the user wrote them
        type(span_t), allocatable :: spans(:)
        logical, allocatable :: sound(:)
        integer, allocatable :: slots(:)                    !! open addressing: 0 or the number of a name
    contains
        procedure :: find
        procedure :: define
        procedure :: span
        procedure :: is_sound
        procedure :: known
    end type name_table_t

    public :: is_name

contains

    !> Whether the text is a name: a letter, then letters, digits, `_` and (where allowed) `-`; at most 32
    !> characters.
    pure logical function is_name(text, hyphens)
        character(*), intent(in) :: text
        logical, intent(in) :: hyphens
        character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
        character(*), parameter :: others = letters // '0123456789_'

        is_name = len(text) >= 1 .and. len(text) <= max_name
        if (.not. is_name) return
        if (hyphens) then
            is_name = verify(text, others // '-') == 0
        else
            is_name = verify(text, others) == 0
        end if
        if (is_name) is_name = verify(text(1:1), letters) == 0
    end function is_name

    !> Number of a name, 0 where there is none.
    pure integer function find(self, name) result(number)
        class(name_table_t), intent(in) :: self
        character(*), intent(in) :: name
        integer :: slot

        number = 0
        if (self%n == 0 .or. len_trim(name) > max_name) return
        slot = first_slot(name, size(self%slots))
        do while (self%slots(slot) > 0)
            if (lower_case(self%names(self%slots(slot))) == lower_case(name)) then
                number = self%slots(slot)
                return
            end if
            slot = modulo(slot, size(self%slots)) + 1
        end do
    end function find

    !> Enter a name that is not in the table yet; a name that is `sound` has a usable definition.
    pure subroutine define(self, name, at, sound)
        class(name_table_t), intent(inout) :: self
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        logical, intent(in) :: sound

        if (.not. allocated(self%names)) then
            allocate (self%names(8), self%spans(8), self%sound(8))
            call rehash(self, 16)
        else if (self%n == size(self%names)) then
            call grow(self, 2*self%n)
            call rehash(self, 4*self%n)
        end if
        self%n = self%n + 1
        self%names(self%n) = name
        self%spans(self%n) = at
        self%sound(self%n) = sound
        call enter(self, self%n)
    end subroutine define

    !> Where a name was defined.
    pure function span(self, number) result(at)
        class(name_table_t), intent(in) :: self
        integer, intent(in) :: number
        type(span_t) :: at

        at = self%spans(number)
    end function span

    !> Whether the definition was right: what refers to a wrong one has been reported there.
    pure logical function is_sound(self, number)
        class(name_table_t), intent(in) :: self
        integer, intent(in) :: number

        is_sound = self%sound(number)
    end function is_sound

    !> The names to choose a suggestion from; of very many, the first hundreds do.
    pure function known(self) result(names)
        class(name_table_t), intent(in) :: self
        character(max_name), allocatable :: names(:)
        integer, parameter :: enough = 500

        if (self%n == 0) then
            allocate (names(0))
        else
            names = self%names(:min(self%n, enough))
        end if
    end function known

    pure subroutine grow(self, capacity)
        class(name_table_t), intent(inout) :: self
        integer, intent(in) :: capacity
        character(max_name), allocatable :: names(:)
        type(span_t), allocatable :: spans(:)
        logical, allocatable :: sound(:)

        allocate (names(capacity), spans(capacity), sound(capacity))
        names(:self%n) = self%names(:self%n)
        spans(:self%n) = self%spans(:self%n)
        sound(:self%n) = self%sound(:self%n)
        call move_alloc(names, self%names)
        call move_alloc(spans, self%spans)
        call move_alloc(sound, self%sound)
    end subroutine grow

    pure subroutine rehash(self, capacity)
        class(name_table_t), intent(inout) :: self
        integer, intent(in) :: capacity
        integer :: i

        if (allocated(self%slots)) deallocate (self%slots)
        allocate (self%slots(capacity))
        self%slots = 0
        do i = 1, self%n
            call enter(self, i)
        end do
    end subroutine rehash

    pure subroutine enter(self, number)
        class(name_table_t), intent(inout) :: self
        integer, intent(in) :: number
        integer :: slot

        slot = first_slot(self%names(number), size(self%slots))
        do while (self%slots(slot) > 0)
            slot = modulo(slot, size(self%slots)) + 1
        end do
        self%slots(slot) = number
    end subroutine enter

    !> FNV-1a, kept within 32 bits.
    pure integer function first_slot(name, capacity)
        character(*), intent(in) :: name
        integer, intent(in) :: capacity
        character(max_name) :: key
        integer(i8) :: hash
        integer :: i

        key = lower_case(name)
        hash = 2166136261_i8
        do i = 1, len_trim(key)
            hash = ieor(hash, int(ichar(key(i:i)), i8))
            hash = iand(hash*16777619_i8, 4294967295_i8)
        end do
        first_slot = int(modulo(hash, int(capacity, i8))) + 1
    end function first_slot

end module gb_names
