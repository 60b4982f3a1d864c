!> What a keyword table is made of: commands in their forms, words, keys, kinds, ranges and defaults. The
!> table itself stands in gb_commands; parser, reference and documentation all read it.
module gb_schema
    use gb_kinds, only: wp
    use gb_text, only: lower_case, to_text
    implicit none
    private

    !> Kinds of values.
    integer, parameter, public :: kind_real = 1     !! a number
    integer, parameter, public :: kind_integer = 2  !! a whole number
    integer, parameter, public :: kind_reals = 3    !! a list of numbers
    integer, parameter, public :: kind_text = 4     !! a text, quoted where it has blanks
    integer, parameter, public :: kind_choice = 5   !! one of the choices
    integer, parameter, public :: kind_choices = 6  !! a list of choices
    integer, parameter, public :: kind_name = 7     !! a name
    integer, parameter, public :: kind_names = 8    !! a name or a list of names
    integer, parameter, public :: kind_formula = 9  !! an expression that may use x or t

    !> Where a command stands.
    integer, parameter, public :: part_model = 1, part_solution = 2, part_any = 3

    integer, parameter, public :: max_keyword = 16

    !> The numbers a key takes.
    type, public :: range_t
        real(wp) :: low = -huge(1.0_wp), high = huge(1.0_wp)
        logical :: low_open = .false., high_open = .false.      !! the end itself is excluded
        logical :: zero_excluded = .false.
        real(wp) :: limit = 1.0e60_wp           !! beyond this size sums and products would overflow
    contains
        procedure :: holds
        procedure :: words => range_words
    end type range_t

    type, public :: key_t
        character(max_keyword) :: name = ''
        integer :: kind = kind_real
        logical :: required = .false.
        logical :: one_of = .false.             !! at least one of the form's keys marked so must be given
        character(24) :: default = ''           !! as the user would write it, or in words
        real(wp) :: default_number = 0.0_wp     !! what a number's default says; 0 where it is in words
        type(range_t) :: range
        character(48) :: choices = ''           !! separated by blanks
        character(1) :: variable = ''           !! of a formula
        character(100) :: description = ''
    end type key_t

    !> A command, in one of its forms: MATERIAL rubber gent ...
    type, public :: form_t
        character(max_keyword) :: command = ''
        character(max_keyword) :: variant = ''  !! the word that chooses the form, if there is one
        logical :: named = .false.              !! a name comes first
        character(48) :: words = ''             !! further words: choices separated by blanks
        integer :: most_words = 0
        integer :: part = part_model
        logical :: once = .false.               !! a second one is an error
        logical :: open = .false.               !! keys are names of the user's own
        character(120) :: description = ''
        integer :: first_key = 1, last_key = 0  !! in the schema's list of keys
    end type form_t

    type, public :: schema_t
        type(form_t), allocatable :: forms(:)
        type(key_t), allocatable :: keys(:)
        integer :: n_forms = 0, n_keys = 0
    contains
        procedure :: add_form
        procedure :: add_key
        procedure :: find_command
        procedure :: find_form
        procedure :: find_key
        procedure :: variants
        procedure :: command_names
        procedure :: title => form_title
    end type schema_t

    public :: above, at_least, between, inside, nonzero, split_words

contains

    pure type(range_t) function above(low, limit)
        real(wp), intent(in) :: low
        real(wp), intent(in), optional :: limit

        above%low = low
        above%low_open = .true.
        if (present(limit)) above%limit = limit
    end function above

    pure type(range_t) function at_least(low)
        real(wp), intent(in) :: low

        at_least%low = low
    end function at_least

    pure type(range_t) function between(low, high, low_open)
        real(wp), intent(in) :: low, high
        logical, intent(in), optional :: low_open

        between%low = low
        between%high = high
        if (present(low_open)) between%low_open = low_open
    end function between

    !> Between two numbers, neither of them included.
    pure type(range_t) function inside(low, high)
        real(wp), intent(in) :: low, high

        inside%low = low
        inside%high = high
        inside%low_open = .true.
        inside%high_open = .true.
    end function inside

    !> Up to `size` in absolute value, but not zero.
    pure type(range_t) function nonzero(size)
        real(wp), intent(in) :: size

        nonzero%low = -size
        nonzero%high = size
        nonzero%zero_excluded = .true.
    end function nonzero

    pure logical function holds(self, value)
        class(range_t), intent(in) :: self
        real(wp), intent(in) :: value

        holds = value >= self%low .and. value <= self%high
        if (self%low_open) holds = holds .and. value > self%low
        if (self%high_open) holds = holds .and. value < self%high
        if (self%zero_excluded) holds = holds .and. abs(value) > 0.0_wp
    end function holds

    !> The range in words, to follow "must be"; empty where every number will do.
    pure function range_words(self) result(words)
        class(range_t), intent(in) :: self
        character(:), allocatable :: words
        logical :: has_low, has_high

        has_low = self%low > -huge(1.0_wp)
        has_high = self%high < huge(1.0_wp)
        if (has_low .and. has_high) then
            if (self%low_open .and. self%high_open) then
                words = 'above ' // to_text(self%low, 9) // ' and below ' // to_text(self%high, 9)
            else if (self%low_open) then
                words = 'above ' // to_text(self%low, 9) // ', up to ' // to_text(self%high, 9)
            else
                words = 'from ' // to_text(self%low, 9) // ' to ' // to_text(self%high, 9)
            end if
        else if (has_low) then
            words = 'at least '
            if (self%low_open) words = 'above '
            words = words // to_text(self%low, 9)
        else
            words = ''
        end if
        if (self%zero_excluded) words = words // ' and not 0'
    end function range_words

    !> Start a new form; the keys that are added next belong to it.
    pure subroutine add_form(self, form)
        class(schema_t), intent(inout) :: self
        type(form_t), intent(in) :: form
        type(form_t), allocatable :: grown(:)

        if (.not. allocated(self%forms)) allocate (self%forms(64))
        if (self%n_forms == size(self%forms)) then
            allocate (grown(2*self%n_forms))
            grown(:self%n_forms) = self%forms
            call move_alloc(grown, self%forms)
        end if
        self%n_forms = self%n_forms + 1
        self%forms(self%n_forms) = form
        self%forms(self%n_forms)%first_key = self%n_keys + 1
        self%forms(self%n_forms)%last_key = self%n_keys
    end subroutine add_form

    !> Add a key to the newest form.
    pure subroutine add_key(self, key)
        class(schema_t), intent(inout) :: self
        type(key_t), intent(in) :: key
        type(key_t), allocatable :: grown(:)
        integer :: status

        if (.not. allocated(self%keys)) allocate (self%keys(256))
        if (self%n_keys == size(self%keys)) then
            allocate (grown(2*self%n_keys))
            grown(:self%n_keys) = self%keys
            call move_alloc(grown, self%keys)
        end if
        self%n_keys = self%n_keys + 1
        self%keys(self%n_keys) = key
        associate (new => self%keys(self%n_keys))
            if (any(new%kind == [kind_real, kind_integer]) .and. new%default /= '') then
                read (new%default, *, iostat=status) new%default_number
                if (status /= 0) new%default_number = 0.0_wp
            end if
        end associate
        self%forms(self%n_forms)%last_key = self%n_keys
    end subroutine add_key

    !> The first form of the command a word stands for, written in full or cut to four letters or more; else
    !> 0.
    pure integer function find_command(self, word) result(form)
        class(schema_t), intent(in) :: self
        character(*), intent(in) :: word
        character(max_keyword) :: wanted
        integer :: i, found

        form = 0
        if (len(word) > max_keyword .or. len(word) == 0) return
        wanted = lower_case(word)
        found = 0
        do i = 1, self%n_forms
            if (i > 1) then
                if (self%forms(i)%command == self%forms(i - 1)%command) cycle
            end if
            if (lower_case(self%forms(i)%command) == wanted) then
                form = i
                return
            end if
            if (len(word) < 4) cycle
            if (index(lower_case(self%forms(i)%command), lower_case(word)) == 1) then
                found = found + 1
                form = i
            end if
        end do
        if (found > 1) form = 0
    end function find_command

    !> The form of a command with the given variant, 0 if there is none.
    pure integer function find_form(self, command, variant) result(form)
        class(schema_t), intent(in) :: self
        character(*), intent(in) :: command, variant

        do form = 1, self%n_forms
            if (self%forms(form)%command == command .and. self%forms(form)%variant == lower_case(variant)) &
                return
        end do
        form = 0
    end function find_form

    !> Number of a form's key in the list of keys, 0 if there is none.
    pure integer function find_key(self, form, name) result(key)
        class(schema_t), intent(in) :: self
        integer, intent(in) :: form
        character(*), intent(in) :: name

        do key = self%forms(form)%first_key, self%forms(form)%last_key
            if (self%keys(key)%name == lower_case(name)) return
        end do
        key = 0
    end function find_key

    !> The variants of a command; a form without one is not among them.
    pure function variants(self, command) result(names)
        class(schema_t), intent(in) :: self
        character(*), intent(in) :: command
        character(max_keyword), allocatable :: names(:)
        character(max_keyword) :: found(self%n_forms)
        integer :: i, n

        n = 0
        do i = 1, self%n_forms
            if (self%forms(i)%command /= command .or. self%forms(i)%variant == '') cycle
            n = n + 1
            found(n) = self%forms(i)%variant
        end do
        names = found(:n)
    end function variants

    !> Every command, once.
    pure function command_names(self) result(names)
        class(schema_t), intent(in) :: self
        character(max_keyword), allocatable :: names(:)
        character(max_keyword) :: found(self%n_forms)
        integer :: i, n

        n = 0
        do i = 1, self%n_forms
            if (n > 0) then
                if (found(n) == self%forms(i)%command) cycle
            end if
            n = n + 1
            found(n) = self%forms(i)%command
        end do
        names = found(:n)
    end function command_names

    !> Command and variant, as messages name the form.
    pure function form_title(self, form) result(title)
        class(schema_t), intent(in) :: self
        integer, intent(in) :: form
        character(:), allocatable :: title

        title = trim(self%forms(form)%command)
        if (self%forms(form)%variant /= '') title = title // ' ' // trim(self%forms(form)%variant)
    end function form_title

    !> The words of a text that blanks separate.
    pure function split_words(text) result(words)
        character(*), intent(in) :: text
        character(max_keyword), allocatable :: words(:)
        integer :: first, last, n

        allocate (words(len(text)))
        n = 0
        first = 1
        do
            last = verify(text(first:), ' ')
            if (last == 0) exit
            first = first + last - 1
            last = index(text(first:) // ' ', ' ') + first - 2
            n = n + 1
            words(n) = text(first:last)
            first = last + 1
            if (first > len(text)) exit
        end do
        words = words(:n)
    end function split_words

end module gb_schema
