!> The manual page and the completion for bash, written from the tables that the command line and the deck's
!> reader use.
module gb_manual
    use gb_version, only: program_version
    use gb_options, only: option_entry_t, option_table, exit_entry_t, exit_table
    use gb_keywords, only: print_keywords_roff, roff
    implicit none
    private

    public :: print_manual, print_completion

contains

    !> The page gentbeam(1) in man's macros.
    subroutine print_manual(unit)
        integer, intent(in) :: unit
        type(option_entry_t), allocatable :: options(:)
        type(exit_entry_t), allocatable :: exits(:)
        integer :: i

        write (unit, '(a)') '.TH GENTBEAM 1 "" "gentbeam ' // program_version // '" "User Commands"', &
            '.SH NAME', &
            'gentbeam \- large, fast motions of soft beams', '.SH SYNOPSIS', '.B gentbeam', &
            '.RI [ options ]', '.RI [ deck ]', '.SH DESCRIPTION', &
            '.B gentbeam', &
            'reads a deck, a text file (without one: standard input), solves what it asks for and', &
            'writes the results to an HDF5 file, which ParaView opens too.', &
            'The log goes to standard output, diagnostics to standard error.', &
            'Colours and a progress bar appear on terminals only; the variable', '.B NO_COLOR', &
            'turns colours off.', '.SH OPTIONS'
        options = option_table()
        do i = 1, size(options)
            write (unit, '(a)') '.TP', option_heading(options(i)), roff(trim(options(i)%meaning)) // '.'
        end do
        write (unit, '(a)') '.SH EXIT STATUS'
        exits = exit_table()
        do i = 1, size(exits)
            write (unit, '(a,/,a,i0,/,a)') '.TP', '.B ', exits(i)%status, roff(trim(exits(i)%meaning)) // '.'
        end do
        write (unit, '(a)') '.SH THE DECK', &
            'Every command is one line.', &
            'The first is GENTBEAM, the model ends with END, solution commands follow.', &
            'Keywords and keys may be in upper or lower case; keywords of more than four letters may be', &
            'cut to four or more; & continues a line, ! and # start a comment.', &
            'A key marked * is required, of those marked + one at least; defaults stand in parentheses.'
        call print_keywords_roff(unit)
        write (unit, '(a)') '.SH EXAMPLES', '.EX', 'gentbeam cantilever.inp', &
            'gentbeam \-\-set jm=0.5 \-o stiff cantilever.inp', 'gentbeam \-\-check my.inp', '.EE', &
            '.SH SEE ALSO', 'The documentation that comes with the program: deck.md, results.md, theory.md.'
    end subroutine print_manual

    pure function option_heading(option) result(line)
        type(option_entry_t), intent(in) :: option
        character(:), allocatable :: line

        line = '\fB' // roff(trim(option%name)) // '\fR'
        if (option%letter /= '') line = '\fB' // roff(option%letter) // '\fR, ' // line
        if (option%value /= '') line = line // ' \fI' // roff(trim(option%value)) // '\fR'
    end function option_heading

    !> A script for bash: options, decks, and behind --set the parameters of the deck that is on the line.
    subroutine print_completion(unit)
        integer, intent(in) :: unit
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
        write (unit, '(a)') '# Completion of gentbeam for bash; written by gentbeam --completion.', &
            '_gentbeam() {', &
            '    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} deck i', &
            '    COMPREPLY=()', &
            '    case $before in', &
            '    ' // files // ')', &
            '        COMPREPLY=($(compgen -f -- "$word"))', '        return', '        ;;'
        if (len(values) > 0) write (unit, '(a)') '    ' // values // ') return ;;'
        write (unit, '(a)') '    ' // names // ')', &
            '        for ((i = 1; i < ${#COMP_WORDS[@]}; i++)); do', &
            '            [[ -f ${COMP_WORDS[i]} ]] && deck=${COMP_WORDS[i]}', &
            '        done', &
            '        [[ -n $deck ]] || return', &
            '        COMPREPLY=($(compgen -S = -W "$(sed -nE \', &
            '            ''s/^[[:space:]]*PARA[A-Z]*[[:space:]]//Ip'' "$deck" |', &
            '            grep -oE ''[A-Za-z][A-Za-z0-9_]*[[:space:]]*='' | tr -d ''= '')" -- "$word"))', &
            '        compopt -o nospace 2>/dev/null', '        return', '        ;;', '    esac', &
            '    if [[ $word == -* ]]; then', &
            '        COMPREPLY=($(compgen -W "' // words(2:) // '" -- "$word"))', &
            '    else', &
            '        COMPREPLY=($(compgen -f -X ''!*.inp'' -- "$word") $(compgen -d -- "$word"))', &
            '        compopt -o filenames 2>/dev/null', &
            '    fi', '}', 'complete -F _gentbeam gentbeam'

    contains

        !> "-o | --output" as a pattern of case.
        subroutine add(pattern, option)
            character(:), allocatable, intent(inout) :: pattern
            type(option_entry_t), intent(in) :: option

            if (len(pattern) > 0) pattern = pattern // ' | '
            if (option%letter /= '') pattern = pattern // option%letter // ' | '
            pattern = pattern // trim(option%name)
        end subroutine add

    end subroutine print_completion

end module gb_manual
