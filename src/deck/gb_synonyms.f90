!> Words that people bring along from other programs, and what they are called here.
module gb_synonyms
    use gb_diagnostics, only: quoted
    use gb_text, only: lower_case
    implicit none
    private

    public :: command_for, key_for, plane_hint

    type :: synonym_t
        character(12) :: foreign = ''
        character(40) :: own = ''
    end type synonym_t

    type(synonym_t), parameter :: commands(*) = [ &
        synonym_t('title', 'GENTBEAM'), synonym_t('dynamic', 'TRANSIENT'), &
        synonym_t('dynamics', 'TRANSIENT'), synonym_t('frequency', 'MODAL'), &
        synonym_t('eigen', 'MODAL'), synonym_t('modes', 'MODAL'), &
        synonym_t('load', 'POINT or DISTRIBUTED'), synonym_t('loads', 'POINT or DISTRIBUTED'), &
        synonym_t('force', 'POINT'), synonym_t('moment', 'POINT'), synonym_t('pressure', 'DISTRIBUTED'), &
        synonym_t('amplitude', 'HISTORY'), synonym_t('curve', 'HISTORY'), synonym_t('beam', 'LINE'), &
        synonym_t('mesh', 'LINE'), synonym_t('elements', 'LINE'), synonym_t('set', 'PARAMETER'), &
        synonym_t('support', 'CLAMP, PIN, ROLLER, SLIDE or FIX'), &
        synonym_t('boundary', 'CLAMP, PIN, ROLLER, SLIDE or FIX'), synonym_t('fixed', 'CLAMP or FIX'), &
        synonym_t('results', 'OUTPUT'), synonym_t('exit', 'STOP'), synonym_t('quit', 'STOP')]

    type(synonym_t), parameter :: keys(*) = [ &
        synonym_t('dt', 'step'), synonym_t('tend', 'end'), synonym_t('t_end', 'end'), &
        synonym_t('tmax', 'end'), synonym_t('duration', 'end'), synonym_t('tol', 'tolerance'), &
        synonym_t('increments', 'steps'), synonym_t('modes', 'count'), synonym_t('density', 'rho'), &
        synonym_t('young', 'e'), synonym_t('poisson', 'nu'), synonym_t('width', 'b'), &
        synonym_t('height', 'h'), synonym_t('thickness', 'h'), synonym_t('start', 'from'), &
        synonym_t('x1', 'from'), synonym_t('x2', 'to'), synonym_t('at', 'x'), &
        synonym_t('amplitude', 'history'), synonym_t('curve', 'history'), synonym_t('freq', 'frequency')]

contains

    !> The commands here for what another program calls `word`; empty where nothing is known.
    pure function command_for(word) result(own)
        character(*), intent(in) :: word
        character(:), allocatable :: own
        integer :: i

        own = ''
        do i = 1, size(commands)
            if (commands(i)%foreign == lower_case(word)) own = trim(commands(i)%own)
        end do
    end function command_for

    !> The key among `known` for what another program calls `word`; empty where there is none.
    pure function key_for(word, known) result(own)
        character(*), intent(in) :: word
        character(*), intent(in) :: known(:)
        character(:), allocatable :: own
        integer :: i

        own = ''
        do i = 1, size(keys)
            if (keys(i)%foreign /= lower_case(word) .or. .not. any(known == keys(i)%own)) cycle
            own = trim(keys(i)%own)
            return
        end do
    end function key_for

    !> Advice for a component out of the plane, such as f2, where `known` has f1 or f3; else empty.
    pure function plane_hint(word, known) result(hint)
        character(*), intent(in) :: word
        character(*), intent(in) :: known(:)
        character(:), allocatable :: hint
        character(2) :: first, third

        hint = ''
        if (len(word) /= 2) return
        if (word(2:2) /= '2') return
        first = lower_case(word(1:1)) // '1'
        third = lower_case(word(1:1)) // '3'
        if (any(known == first) .or. any(known == third)) hint = &
            'the beam moves in the plane of X1 and X3: ' // quoted(first) // ' or ' // quoted(third)
    end function plane_hint

end module gb_synonyms
