!> The deck, from its text to the problem it describes: the one way in for the rest of the program.
module gb_deck
    use gb_build_command, only: build_command
    use gb_check_model, only: close_model
    use gb_command, only: command_t
    use gb_commands, only: command_table
    use gb_diagnostics, only: diagnostics_t, span_t, utf8_mark
    use gb_draft, only: draft_t, new_draft, resize, space_material, space_section, space_history, &
        space_probe, space_task
    use gb_expression, only: parameters_t
    use gb_lexer, only: statement_t, next_statement, title_text, token_word, token_quoted
    use gb_names, only: is_name
    use gb_parameters, only: override_t, parse_parameters, parameter_lines, check_overrides
    use gb_parser, only: find_form, parse_command, is_key
    use gb_problem, only: problem_t
    use gb_recipe, only: recipe_t, read_member
    use gb_schema, only: schema_t, part_model, part_solution
    use gb_source, only: source_t, read_source, source_from_text, find_control_byte
    use gb_sweep_command, only: parse_sweep
    use gb_text, only: hexadecimal
    use gb_values, only: token_text
    implicit none
    private

    public :: read_deck, read_member, read_source, source_from_text, source_t, override_t, recipe_t, &
        diagnostics_t

    !> What a first look at the deck tells.
    type :: survey_t
        integer :: first = 1                    !! where the text begins, behind a byte-order mark
        integer :: limit = 0                    !! bytes of text before the first byte that is none
        logical :: has_end = .false.
        logical :: misplaced = .false.          !! a model command after END, or a solution command before it
    end type survey_t

    !> How far the reading has come.
    type :: progress_t
        type(span_t), allocatable :: first_place(:)     !! by form: where a command was first given
        type(span_t) :: last_command            !! the latest keyword
        type(span_t) :: end_place               !! of END
        logical :: titled = .false.
        logical :: closed = .false.             !! END has been, or is known to be missing
        logical :: stopped = .false.
        logical :: any_task = .false.           !! a solution command has been, right or wrong
    end type progress_t

contains

    !> Read a deck. Where `diagnostics` counts none, `problem` is complete and consistent; else it is of no
    !> use. `overrides` replace the values of parameters (--set). Who wants to read members of a SWEEP asks
    !> for the recipe.
    subroutine read_deck(source, overrides, problem, diagnostics, recipe)
        type(source_t), intent(in) :: source
        type(override_t), intent(in) :: overrides(:)
        type(problem_t), intent(out) :: problem
        type(diagnostics_t), intent(out) :: diagnostics
        type(recipe_t), intent(out), optional :: recipe
        type(progress_t) :: progress
        type(schema_t) :: table
        type(parameters_t) :: parameters
        type(statement_t) :: statement
        type(survey_t) :: survey
        type(draft_t) :: draft
        integer :: position, byte

        table = command_table()
        allocate (progress%first_place(table%n_forms))
        call new_draft(draft, source%folder)
        call look_ahead(source%text, table, draft, parameters, survey)
        draft%incomplete = survey%misplaced
        if (present(recipe)) call recipe%begin(source, overrides, table, draft, parameters)
        call check_overrides(overrides, parameters, diagnostics)
        position = survey%first
        do while (.not. progress%stopped)
            call next_statement(source%text, survey%limit, position, statement, diagnostics)
            if (statement%n > 0) then
                if (present(recipe)) call recipe%keep(statement)
                call read_statement(source%text, statement, overrides, table, survey, progress, parameters, &
                    draft, diagnostics)
            else if (statement%sound) then
                exit
            else
                draft%incomplete = .true.
            end if
        end do
        if (survey%limit < len(source%text) .and. .not. progress%stopped) then
            call diagnostics%clear()
            byte = survey%limit + 1
            call diagnostics%add(span_t(byte, byte), 'this is no plain text: it holds the byte ' // &
                                 hexadecimal(source%text(byte:byte)), hint='a deck is UTF-8 text')
            return
        end if
        call check_close(progress, draft, diagnostics)
        if (diagnostics%count() > 0) return
        problem = draft%problem
        if (.not. allocated(problem%output%file)) problem%output%file = source%stem
        problem%deck_text = source%text
        problem%deck_name = source%name
        problem%parameters = parameter_lines(parameters)
        if (present(recipe)) call recipe%finish(problem%sweep, parameters)
    end subroutine read_deck

    !> Look through the whole deck for the names it defines and the order of its commands: with that, later
    !> messages can tell what is missing from what is only in the wrong place.
    subroutine look_ahead(text, table, draft, parameters, survey)
        character(*), intent(in) :: text
        type(schema_t), intent(in) :: table
        type(draft_t), intent(inout) :: draft
        type(parameters_t), intent(inout) :: parameters
        type(survey_t), intent(out) :: survey
        type(diagnostics_t) :: unused
        type(statement_t) :: statement
        logical :: solution_seen, model_after
        integer :: position, form

        survey%limit = find_control_byte(text) - 1
        if (survey%limit < 0) survey%limit = len(text)
        if (index(text(:min(3, len(text))), utf8_mark) == 1) survey%first = 4
        position = survey%first
        solution_seen = .false.
        model_after = .false.
        do
            call next_statement(text, survey%limit, position, statement, unused)
            if (statement%n == 0 .and. statement%sound) exit
            if (statement%n == 0) cycle
            if (statement%tokens(1)%kind /= token_word) cycle
            form = table%find_command(token_text(text, statement%tokens(1)))
            if (form == 0) cycle
            select case (table%forms(form)%command)
            case ('STOP')
                exit
            case ('END')
                survey%has_end = .true.
                survey%misplaced = solution_seen
            case default
                if (table%forms(form)%part == part_solution) solution_seen = .true.
                if (table%forms(form)%part == part_model .and. survey%has_end) model_after = .true.
                call note_names(text, statement, table, form, draft, parameters)
            end select
        end do
        survey%misplaced = survey%misplaced .or. model_after
    end subroutine look_ahead

    !> Remember the names a statement defines.
    subroutine note_names(text, statement, table, form, draft, parameters)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        integer, intent(in) :: form
        type(draft_t), intent(inout) :: draft
        type(parameters_t), intent(inout) :: parameters
        integer :: i, space

        if (table%forms(form)%command == 'PARAMETER') then
            do i = 2, statement%n
                if (is_key(statement, i)) call note(parameters%later, i)
            end do
        else if (table%forms(form)%named .and. statement%n >= 2) then
            space = space_of(table%forms(form)%command)
            if (.not. is_key(statement, 2)) call note(draft%later(space), 2)
        end if

    contains

        subroutine note(names, number)
            use gb_names, only: name_table_t
            type(name_table_t), intent(inout) :: names
            integer, intent(in) :: number
            character(:), allocatable :: name

            name = token_text(text, statement%tokens(number))
            if (.not. is_name(name, hyphens=.true.)) return
            if (names%find(name) == 0) call names%define(name, statement%tokens(number)%at, sound=.true.)
        end subroutine note

    end subroutine note_names

    pure integer function space_of(command) result(space)
        character(*), intent(in) :: command

        select case (command)
        case ('MATERIAL')
            space = space_material
        case ('SECTION')
            space = space_section
        case ('HISTORY')
            space = space_history
        case ('PROBE')
            space = space_probe
        case default
            space = space_task
        end select
    end function space_of

    !> One statement: find its command, see that it stands in its place, parse it and build what it describes.
    subroutine read_statement(text, statement, overrides, table, survey, progress, parameters, draft, &
        diagnostics)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(override_t), intent(in) :: overrides(:)
        type(schema_t), intent(in) :: table
        type(survey_t), intent(in) :: survey
        type(progress_t), intent(inout) :: progress
        type(parameters_t), intent(inout) :: parameters
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        type(command_t) :: command
        character(:), allocatable :: meant
        integer :: form
        logical :: in_place

        call find_form(text, statement, table, diagnostics, form, meant)
        call check_title(statement, table, progress, form, meant, diagnostics)
        progress%last_command = statement%tokens(1)%at
        if (form == 0) then
            call forgive(text, statement, draft, parameters)
            if (progress%closed) progress%any_task = .true.
            if (meant == 'END' .and. .not. progress%closed) then
                progress%closed = .true.
                progress%end_place = statement%tokens(1)%at
            end if
            return
        end if
        call check_order(statement, table, survey, form, progress, draft, diagnostics, in_place)
        select case (table%forms(form)%command)
        case ('STOP')
            progress%stopped = .true.
            return
        case ('GENTBEAM')
            if (in_place .and. statement%n > 1) draft%problem%model%title = title_text(text, &
                statement%tokens(2)%at)
            return
        case ('PARAMETER')
            call parse_parameters(text, statement, overrides, parameters, diagnostics)
            return
        case ('SWEEP')
            if (in_place) call parse_sweep(text, statement, overrides, parameters, draft%folder, &
                draft%problem%sweep, diagnostics)
            return
        end select
        call parse_command(text, statement, table, form, parameters, diagnostics, command)
        if (.not. statement%sound) draft%incomplete = draft%incomplete .or. .not. progress%closed
        if (.not. in_place) command%sound = .false.
        call build_command(command, trim(table%forms(form)%command), draft, diagnostics)
        if (table%forms(form)%command /= 'END' .or. .not. in_place) return
        call close_model(draft, command%at, diagnostics)
        progress%closed = .true.
        progress%end_place = command%at
    end subroutine read_statement

    !> The first command is GENTBEAM, and no other is.
    subroutine check_title(statement, table, progress, form, meant, diagnostics)
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        type(progress_t), intent(inout) :: progress
        integer, intent(in) :: form
        character(*), intent(in) :: meant
        type(diagnostics_t), intent(inout) :: diagnostics
        logical :: is_title

        is_title = meant == 'GENTBEAM'
        if (form > 0) is_title = table%forms(form)%command == 'GENTBEAM'
        if (.not. progress%titled .and. .not. is_title) then
            call diagnostics%add(statement%tokens(1)%at, 'a deck begins with GENTBEAM and a title')
        end if
        progress%titled = .true.
    end subroutine check_title

    !> A command that cannot be understood may have been anything: what it may have defined is not reported as
    !> unknown, nor is what it may have been reported as absent.
    subroutine forgive(text, statement, draft, parameters)
        character(*), intent(in) :: text
        type(statement_t), intent(in) :: statement
        type(draft_t), intent(inout) :: draft
        type(parameters_t), intent(inout) :: parameters
        character(:), allocatable :: word
        integer :: i

        draft%incomplete = .true.
        do i = 1, statement%n
            if (all(statement%tokens(i)%kind /= [token_word, token_quoted])) cycle
            if (i /= 2 .and. .not. is_key(statement, i)) cycle
            word = token_text(text, statement%tokens(i))
            if (.not. is_name(word, hyphens=.true.)) cycle
            if (is_key(statement, i)) then
                if (parameters%ghosts%find(word) == 0) &
                    call parameters%ghosts%define(word, statement%tokens(i)%at, sound=.false.)
            else if (draft%ghosts%find(word) == 0) then
                call draft%ghosts%define(word, statement%tokens(i)%at, sound=.false.)
            end if
        end do
    end subroutine forgive

    !> Model commands stand before END, solution commands after it; some commands stand only once.
    subroutine check_order(statement, table, survey, form, progress, draft, diagnostics, in_place)
        type(statement_t), intent(in) :: statement
        type(schema_t), intent(in) :: table
        type(survey_t), intent(in) :: survey
        integer, intent(in) :: form
        type(progress_t), intent(inout) :: progress
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics
        logical, intent(out) :: in_place
        character(:), allocatable :: name

        in_place = .true.
        name = trim(table%forms(form)%command)
        associate (at => statement%tokens(1)%at, first => progress%first_place(form))
            if (first%first > 0 .and. (table%forms(form)%once .or. name == 'GENTBEAM')) then
                call diagnostics%add(at, name // ' is given twice', other=first, note='first given here')
                in_place = .false.
                return
            end if
            if (first%first == 0) first = at
            select case (table%forms(form)%part)
            case (part_model)
                in_place = progress%end_place%first == 0
                if (.not. in_place) call diagnostics%add(at, name // &
                    ' belongs to the model: it stands before END', &
                                                         other=progress%end_place, note='END is here')
                if (name == 'GENTBEAM' .and. progress%last_command%first > at%first) in_place = .false.
            case (part_solution)
                ! A checkpoint alone solves nothing.
                progress%any_task = progress%any_task .or. name /= 'CHECKPOINT'
                if (progress%closed) return
                in_place = .not. survey%has_end
                if (in_place) then
                    call diagnostics%add(at, &
                        'END is missing: it closes the model before the first solution command')
                    call close_model(draft, at, diagnostics)
                    progress%closed = .true.
                else
                    call diagnostics%add(at, name // ' is a solution command: it stands after END')
                end if
            end select
        end associate
    end subroutine check_order

    !> The deck has ended: was it all there?
    subroutine check_close(progress, draft, diagnostics)
        type(progress_t), intent(in) :: progress
        type(draft_t), intent(inout) :: draft
        type(diagnostics_t), intent(inout) :: diagnostics

        if (.not. progress%titled) then
            if (diagnostics%count() == 0) call diagnostics%add(span_t(1, 1), &
                'the deck is empty: it holds no command', hint="a deck begins with GENTBEAM and a title")
        else if (.not. progress%closed) then
            if (.not. draft%incomplete) call diagnostics%add(progress%last_command, &
                'the deck ends without END', hint='END closes the model; solution commands follow')
        else if (.not. progress%any_task) then
            call diagnostics%add(progress%end_place, 'no solution command follows END', &
                                 hint='add STATIC, MODAL or TRANSIENT')
        end if
        call resize(draft%problem%tasks, draft%names(space_task)%n, exact=.true.)
    end subroutine check_close

end module gb_deck
