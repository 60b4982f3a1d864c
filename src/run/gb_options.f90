!> The options and exit statuses as data: the help text, the man page and the shell's completion are written
!> from this table.
module gb_options
    use gb_text, only: newline, to_text
    implicit none
    private

    type, public :: option_entry_t
        character(12) :: name = ''              !! in full, with its dashes
        character(2) :: letter = ''             !! short form, or empty
        character(12) :: value = ''             !! what stands for its value, or empty
        character(8) :: completes = ''          !! file, deck or name: what the shell offers for the value
        character(96) :: meaning = ''
    end type option_entry_t

    type, public :: exit_entry_t
        integer :: status = 0
        character(96) :: meaning = ''
    end type exit_entry_t

    public :: option_table, exit_table, help_text

contains

    pure function option_table() result(table)
        type(option_entry_t), allocatable :: table(:)

        table = [ &
            option_entry_t('--output', '-o', 'NAME', 'file', &
            'results go to NAME.h5 (replaces OUTPUT file=)'), &
            option_entry_t('--set', '', 'name=value', 'name', 'replace a PARAMETER''s value (repeatable)'), &
            option_entry_t('--check', '', '', '', 'read and check the deck, draw the model, run nothing'), &
            option_entry_t('--restart', '', 'FILE', 'file', 'go on from a checkpoint of the same deck'), &
            option_entry_t('--max-time', '', 'SECONDS', '', &
            'write a checkpoint and stop before this much wall time has gone'), &
            option_entry_t('--threads', '', 'N', '', 'threads for SWEEP members'), &
            option_entry_t('--shard', '', 'I/N', '', &
            'run every N-th SWEEP member only, from the I-th on; auto: I and N from MPI or Slurm'), &
            option_entry_t('--merge', '', 'OUT', 'file', &
            'join the results of shards, named after OUT, into OUT.h5'), &
            option_entry_t('--quiet', '-q', '', '', 'no log, errors only'), &
            option_entry_t('--verbose', '-v', '', '', 'print every Newton iteration'), &
            option_entry_t('--keywords', '', '', '', 'print the deck reference'), &
            option_entry_t('--markdown', '', '', '', 'the same as Markdown'), &
            option_entry_t('--man', '', '', '', 'print the manual page, as man reads it'), &
            option_entry_t('--completion', '', '', '', 'print the completion of options for bash'), &
            option_entry_t('--version', '', '', '', 'print version and revision'), &
            option_entry_t('--help', '-h', '', '', 'print this')]
    end function option_table

    pure function exit_table() result(table)
        type(exit_entry_t), allocatable :: table(:)

        table = [exit_entry_t(0, 'done'), &
                 exit_entry_t(1, 'deck or command line wrong: nothing was run, no file touched'), &
                 exit_entry_t(2, 'solution failed: all earlier steps are in the results file'), &
                 exit_entry_t(3, 'a file could not be read or written'), &
                 exit_entry_t(4, 'stopped by a signal or --max-time, with a checkpoint')]
    end function exit_table

    !> What --help prints.
    pure function help_text() result(text)
        character(:), allocatable :: text
        integer, parameter :: column = 22
        type(option_entry_t), allocatable :: options(:)
        type(exit_entry_t), allocatable :: exits(:)
        character(:), allocatable :: label
        integer :: i

        text = 'usage: gentbeam [options] [deck]            without a deck: standard input' // newline &
            // newline
        options = option_table()
        do i = 1, size(options)
            label = '  ' // option_label(options(i))
            label = label // repeat(' ', max(1, column - len(label)))
            text = text // label // trim(options(i)%meaning) // newline
        end do
        text = text // newline // 'exit status:'
        exits = exit_table()
        do i = 1, size(exits)
            text = text // newline // '  ' // to_text(exits(i)%status) // '  ' // trim(exits(i)%meaning)
        end do
        text = text // newline
    end function help_text

    !> "-o, --output NAME".
    pure function option_label(option) result(label)
        type(option_entry_t), intent(in) :: option
        character(:), allocatable :: label

        label = trim(option%name)
        if (option%letter /= '') label = option%letter // ', ' // label
        if (option%value /= '') label = label // ' ' // trim(option%value)
    end function option_label

end module gb_options
