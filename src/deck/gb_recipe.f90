!> A deck that has been read and found right, kept in a form from which the members of its SWEEPs are read at
!> little cost: cut into statements, and parsed already where no parameter that varies plays a part.
module gb_recipe
    use gb_build_command, only: build_command
    use gb_check_model, only: close_model
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t, span_t
    use gb_draft, only: draft_t, resize, space_task
    use gb_expression, only: parameters_t
    use gb_kinds, only: wp
    use gb_lexer, only: statement_t, title_text
    use gb_names, only: name_table_t
    use gb_number, only: digits, letters
    use gb_parameters, only: override_t, parse_parameters
    use gb_parser, only: parse_command, is_key
    use gb_problem, only: problem_t
    use gb_schema, only: schema_t, max_keyword
    use gb_source, only: source_t
    use gb_sweep, only: sweep_t
    use gb_values, only: token_text
    implicit none
    private

    !> A statement of the deck.
    type :: line_t
        type(statement_t) :: statement
        integer :: form = 0                         !! of its command in the table
        character(max_keyword) :: name = ''         !! of its command
        logical :: varies = .false.                 !! a parameter that varies plays a part in it
        type(command_t) :: command                  !! as parsed, where nothing in it varies
    end type line_t

    type, public :: recipe_t
        private
        type(source_t) :: source
        type(override_t), allocatable :: overrides(:)
        type(schema_t) :: table
        type(draft_t) :: draft                      !! before the first statement
        type(parameters_t) :: start                 !! before the first statement
        type(parameters_t) :: parameters            !! with the deck's own values
        type(name_table_t) :: varying               !! parameters whose value differs from member to member
        type(line_t), allocatable :: lines(:)
        integer :: n = 0                            !! lines in use
    contains
        procedure :: begin
        procedure :: keep
        procedure :: finish
        procedure :: render
    end type recipe_t

    public :: read_member

contains

    subroutine begin(self, source, overrides, table, draft, parameters)
        class(recipe_t), intent(inout) :: self
        type(source_t), intent(in) :: source
        type(override_t), intent(in) :: overrides(:)
        type(schema_t), intent(in) :: table
        type(draft_t), intent(in) :: draft
        type(parameters_t), intent(in) :: parameters

        self%source = source
        self%overrides = overrides
        self%table = table
        self%draft = draft
        self%start = parameters
        allocate (self%lines(16))
    end subroutine begin

    !> Keep a statement for the members, unless it is a SWEEP: what that says is in the problem already.
    subroutine keep(self, statement)
        class(recipe_t), intent(inout) :: self
        type(statement_t), intent(in) :: statement
        type(line_t), allocatable :: grown(:)
        integer :: form

        form = self%table%find_command(token_text(self%source%text, statement%tokens(1)))
        if (form == 0) return
        if (self%table%forms(form)%command == 'SWEEP') return
        if (self%n == size(self%lines)) then
            allocate (grown(2*self%n))
            grown(:self%n) = self%lines
            call move_alloc(grown, self%lines)
        end if
        self%n = self%n + 1
        self%lines(self%n)%statement = statement
        self%lines(self%n)%form = form
        self%lines(self%n)%name = self%table%forms(form)%command
    end subroutine keep

    !> The deck has been found right: see which parameters vary, and parse what none of them plays a part in.
    subroutine finish(self, sweep, parameters)
        class(recipe_t), intent(inout) :: self
        type(sweep_t), intent(in) :: sweep
        type(parameters_t), intent(in) :: parameters
        type(diagnostics_t) :: none
        integer :: i

        if (sweep%members() == 0) return
        self%parameters = parameters
        call note_names(self%varying, sweep)
        do i = 1, self%n
            associate (line => self%lines(i))
                select case (line%name)
                case ('GENTBEAM', 'STOP')
                    cycle
                case ('PARAMETER')
                    call follow(self, line%statement)
                case default
                    line%varies = mentions(self, line%statement, 2, line%statement%n)
                    if (.not. line%varies) call parse_command(self%source%text, line%statement, self%table, &
                        line%form, parameters, none, line%command)
                end select
            end associate
        end do
    end subroutine finish

    subroutine note_names(table, sweep)
        type(name_table_t), intent(inout) :: table
        type(sweep_t), intent(in) :: sweep
        integer :: i, k

        do i = 1, size(sweep%factors)
            do k = 1, size(sweep%factors(i)%names)
                call table%define(trim(sweep%factors(i)%names(k)), span_t(), sound=.true.)
            end do
        end do
    end subroutine note_names

    !> Parameters that are computed from one that varies vary too.
    subroutine follow(self, statement)
        class(recipe_t), intent(inout) :: self
        type(statement_t), intent(in) :: statement
        character(:), allocatable :: name
        integer :: i

        do i = 2, statement%n - 2
            if (.not. is_key(statement, i)) cycle
            name = token_text(self%source%text, statement%tokens(i))
            if (self%varying%find(name) > 0) cycle
            if (mentions(self, statement, i + 2, i + 2)) call self%varying%define(name, span_t(), &
                sound=.true.)
        end do
    end subroutine follow

    !> Whether a word in tokens first to last is the name of a parameter that varies. A key of that name
    !> counts too: then the statement is parsed again in vain, which costs a little time.
    pure logical function mentions(self, statement, first, last)
        class(recipe_t), intent(in) :: self
        type(statement_t), intent(in) :: statement
        integer, intent(in) :: first, last
        integer :: i, start, length

        mentions = .true.
        do i = first, last
            associate (word => self%source%text(statement%tokens(i)%at%first:statement%tokens(i)%at%last))
                start = 1
                do
                    length = scan(word(start:), letters)
                    if (length == 0) exit
                    start = start + length - 1
                    length = verify(word(start:), letters // digits // '_') - 1
                    if (length < 0) length = len(word) - start + 1
                    if (self%varying%find(word(start:start + length - 1)) > 0) return
                    start = start + length
                    if (start > len(word)) exit
                end do
            end associate
        end do
        mentions = .false.
    end function mentions

    !> What is wrong with the deck for a member, as the user is told.
    function render(self, diagnostics) result(report)
        class(recipe_t), intent(in) :: self
        type(diagnostics_t), intent(in) :: diagnostics
        character(:), allocatable :: report

        report = diagnostics%render(self%source%name, self%source%text)
    end function render

    !> Read the deck for one member of its SWEEPs: `names` have `values`. Where `diagnostics` counts none,
    !> `problem` is complete but for the deck's text. Several threads may read from one recipe.
    subroutine read_member(recipe, names, values, problem, diagnostics)
        type(recipe_t), intent(in) :: recipe
        character(*), intent(in) :: names(:)
        real(wp), intent(in) :: values(:)
        type(problem_t), intent(out) :: problem
        type(diagnostics_t), intent(out) :: diagnostics
        type(override_t) :: overrides(size(recipe%overrides) + size(names))
        type(parameters_t) :: parameters
        type(draft_t) :: draft
        type(command_t) :: command
        integer :: i

        overrides(:size(recipe%overrides)) = recipe%overrides
        do i = 1, size(names)
            associate (override => overrides(size(recipe%overrides) + i))
                override%name = trim(names(i))
                override%text = ''
                override%is_swept = .true.
                override%value = values(i)
            end associate
        end do
        draft = recipe%draft
        parameters = recipe%start
        do i = 1, recipe%n
            associate (line => recipe%lines(i), text => recipe%source%text)
                select case (line%name)
                case ('STOP')
                    exit
                case ('GENTBEAM')
                    if (line%statement%n > 1) draft%problem%model%title = title_text(text, &
                        line%statement%tokens(2)%at)
                case ('PARAMETER')
                    call parse_parameters(text, line%statement, overrides, parameters, diagnostics, &
                        recipe%parameters, recipe%varying)
                case default
                    if (line%varies) then
                        call parse_command(text, line%statement, recipe%table, line%form, parameters, &
                            diagnostics, command)
                    else
                        command = line%command
                    end if
                    call build_command(command, trim(line%name), draft, diagnostics)
                    if (line%name == 'END') call close_model(draft, command%at, diagnostics)
                end select
            end associate
        end do
        call resize(draft%problem%tasks, draft%names(space_task)%n, exact=.true.)
        if (diagnostics%count() > 0) return
        problem = draft%problem
    end subroutine read_member

end module gb_recipe
