!> The manual page and the completion for bash, written from the tables that the command line and the deck's
!> reader use.
module gb_manual
    use gb_version, only: program_version
    use gb_options, only: option_entry_t, option_table, exit_entry_t, exit_table
    use gb_keywords, only: add_keywords_roff, roff
    use gb_page, only: page_t
    use gb_text, only: to_text
    implicit none
    private

    public :: manual_page, completion

    integer, parameter :: widest = 110      !! line of a page that is written as it stands

contains

    !> The page gentbeam(1) in man's macros.
    pure function manual_page() result(text)
        character(:), allocatable :: text
        type(page_t) :: page
        type(option_entry_t), allocatable :: options(:)
        type(exit_entry_t), allocatable :: exits(:)
        integer :: i

        call page%line('.TH GENTBEAM 1 "" "gentbeam ' // program_version // '" "User Commands"')
        call page%lines([character(widest) :: '.SH NAME', &
            'gentbeam \- large, fast motions of soft beams', '.SH SYNOPSIS', '.B gentbeam', &
            '.RI [ options ]', '.RI [ deck ]', '.SH DESCRIPTION', &
            '.B gentbeam', &
            'reads a deck, a text file (without one: standard input), solves what it asks for and', &
            'writes the results to an HDF5 file, which ParaView opens too.', &
            'The log goes to standard output, diagnostics to standard error.', &
            'Colours and a progress bar appear on terminals only; the variable', '.B NO_COLOR', &
            'turns colours off.', '.SH OPTIONS'])
        options = option_table()
        do i = 1, size(options)
            call page%line('.TP')
            call page%line(option_heading(options(i)))
            call page%line(roff(trim(options(i)%meaning)) // '.')
        end do
        call page%line('.SH EXIT STATUS')
        exits = exit_table()
        do i = 1, size(exits)
            call page%line('.TP')
            call page%line('.B ' // to_text(exits(i)%status))
            call page%line(roff(trim(exits(i)%meaning)) // '.')
        end do
        call page%lines([character(widest) :: '.SH THE DECK', &
            'Every command is one line.', &
            'The first is GENTBEAM, the model ends with END, solution commands follow.', &
            'Keywords and keys may be in upper or lower case; keywords of more than four letters may be', &
            'cut to four or more; & continues a line, ! and # start a comment.', &
            'A key marked * is required, of those marked + one at least; defaults stand in parentheses.'])
        call add_keywords_roff(page)
        call page%lines([character(widest) :: '.SH EXAMPLES', '.EX', 'gentbeam cantilever.inp', &
            'gentbeam \-\-set jm=0.5 \-o stiff cantilever.inp', 'gentbeam \-\-check my.inp', '.EE', &
            '.SH SEE ALSO', 'The documentation that comes with the program: deck.md, results.md, theory.md.'])
        text = page%text
    end function manual_page

    pure function option_heading(option) result(line)
        type(option_entry_t), intent(in) :: option
        character(:), allocatable :: line

        line = '\fB' // roff(trim(option%name)) // '\fR'
        if (option%letter /= '') line = '\fB' // roff(option%letter) // '\fR, ' // line
        if (option%value /= '') line = line // ' \fI' // roff(trim(option%value)) // '\fR'
    end function option_heading

    !> A script for bash: options, decks, and behind --set the parameters of the deck that is on the line.
    pure function completion() result(text)
        character(:), allocatable :: text
        type(page_t) :: page
        type(option_entry_t), allocatable :: options(:)
        character(:), allocatable :: words, files, names, values
        integer :: i

        options = option_table()
        words = ''
        files = ''
        names = ''
        values = ''
        do i = 1, size(options)
            words = words // ' ' // trim(options(i)%name)
            if (options(i)%letter /= '') words = words // ' ' // options(i)%letter
            if (options(i)%completes == 'file') call add(files, options(i))
            if (options(i)%completes == 'name') call add(names, options(i))
            if (options(i)%value /= '' .and. options(i)%completes == '') call add(values, options(i))
        end do
        call page%lines([character(widest) :: &
            '# Completion of gentbeam for bash; written by gentbeam --completion.', &
            '_gentbeam() {', &
            '    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} deck i', &
            '    COMPREPLY=()', &
            '    case $before in'])
        call page%line('    ' // files // ')')
        call page%lines([character(widest) :: &
            '        COMPREPLY=($(compgen -f -- "$word"))', '        return', '        ;;'])
        if (len(values) > 0) call page%line('    ' // values // ') return ;;')
        call page%line('    ' // names // ')')
        call page%lines([character(widest) :: &
            '        for ((i = 1; i < ${#COMP_WORDS[@]}; i++)); do', &
            '            [[ -f ${COMP_WORDS[i]} ]] && deck=${COMP_WORDS[i]}', &
            '        done', &
            '        [[ -n $deck ]] || return', &
            '        COMPREPLY=($(compgen -S = -W "$(sed -nE \', &
            '            ''s/^[[:space:]]*PARA[A-Z]*[[:space:]]//Ip'' "$deck" |', &
            '            grep -oE ''[A-Za-z][A-Za-z0-9_]*[[:space:]]*='' | tr -d ''= '')" -- "$word"))', &
            '        compopt -o nospace 2>/dev/null', '        return', '        ;;', '    esac', &
            '    if [[ $word == -* ]]; then'])
        call page%line('        COMPREPLY=($(compgen -W "' // words(2:) // '" -- "$word"))')
        call page%lines([character(widest) :: &
            '    else', &
            '        COMPREPLY=($(compgen -f -X ''!*.inp'' -- "$word") $(compgen -d -- "$word"))', &
            '        compopt -o filenames 2>/dev/null', &
            '    fi', '}', 'complete -F _gentbeam gentbeam'])
        text = page%text

    contains

        !> "-o | --output" as a pattern of case.
        pure subroutine add(pattern, option)
            character(:), allocatable, intent(inout) :: pattern
            type(option_entry_t), intent(in) :: option

            if (len(pattern) > 0) pattern = pattern // ' | '
            if (option%letter /= '') pattern = pattern // option%letter // ' | '
            pattern = pattern // trim(option%name)
        end subroutine add

    end function completion

end module gb_manual
