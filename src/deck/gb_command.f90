!> A command of the deck after parsing: its form, its words and the values of its keys, defaults filled in.
module gb_command
    use gb_kinds, only: wp
    use gb_diagnostics, only: span_t
    use gb_names, only: max_name
    use gb_program, only: program_t
    use gb_schema, only: max_keyword
    implicit none
    private

    type, public :: value_t
        character(max_keyword) :: key = ''
        logical :: given = .false.
        logical :: is_guess = .false.               !! given by a word that went wrong: not to be missed
        type(span_t) :: key_at                      !! place of the key
        type(span_t) :: at                          !! place of the value
        real(wp) :: number = 0.0_wp                 !! real, integer
        character(:), allocatable :: text           !! text, choice, name
        real(wp), allocatable :: numbers(:)         !! reals
        character(max_name), allocatable :: words(:)    !! choices, names
        type(span_t), allocatable :: parts(:)       !! places of a list's members
        type(program_t) :: formula
    end type value_t

    type, public :: command_t
        integer :: form = 0                         !! in the schema; 0: not known
        logical :: sound = .true.                   !! everything in it is right
        type(span_t) :: at                          !! place of the keyword
        character(:), allocatable :: title          !! command and variant, for messages
        character(:), allocatable :: name           !! the name it defines, or empty
        type(span_t) :: name_at
        character(max_keyword), allocatable :: words(:)
        type(value_t), allocatable :: values(:)
    contains
        procedure :: value_of
        procedure :: given
        procedure :: number
        procedure :: whole
        procedure :: text
        procedure :: place
    end type command_t

contains

    !> Index of a key in the list of values; every key of the form is there.
    pure integer function value_of(self, key) result(i)
        class(command_t), intent(in) :: self
        character(*), intent(in) :: key

        do i = 1, size(self%values)
            if (self%values(i)%key == key) return
        end do
        i = 0
    end function value_of

    !> Whether the user gave the key.
    pure logical function given(self, key)
        class(command_t), intent(in) :: self
        character(*), intent(in) :: key

        given = self%values(self%value_of(key))%given
    end function given

    pure real(wp) function number(self, key)
        class(command_t), intent(in) :: self
        character(*), intent(in) :: key

        number = self%values(self%value_of(key))%number
    end function number

    pure integer function whole(self, key)
        class(command_t), intent(in) :: self
        character(*), intent(in) :: key

        whole = nint(self%values(self%value_of(key))%number)
    end function whole

    pure function text(self, key)
        class(command_t), intent(in) :: self
        character(*), intent(in) :: key
        character(:), allocatable :: text

        text = self%values(self%value_of(key))%text
    end function text

    !> Where the key's value stands, or the keyword where the key was not given.
    pure type(span_t) function place(self, key)
        class(command_t), intent(in) :: self
        character(*), intent(in) :: key

        place = self%at
        if (self%given(key)) place = self%values(self%value_of(key))%at
    end function place

end module gb_command
