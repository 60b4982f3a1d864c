!> What `auto` chooses for a scene, and how it came to it: the settings it has tried and what they told.
module gb_tuning
    use gb_kinds, only: wp
    use gb_section, only: inertia_diagonal
    implicit none
    private

    !> One choice of mesh, element order, section rule, inertia, scheme and steps.
    type, public :: setting_t
        integer, allocatable :: elements(:)         !! of every piece of the beam (gb_pieces)
        integer :: nodes = 3                        !! of an element
        integer :: points = 3                       !! Gauss points through the thickness
        integer :: inertia = inertia_diagonal
        character(16) :: scheme = 'newmark'         !! of the transients that are tuned
        integer, allocatable :: steps(:)            !! of every command; 0 where the deck has the say
        real(wp) :: local = 0.0_wp                  !! local error of adaptive steps [-]; 0: steps are fixed
    contains
        procedure :: n_elements
        procedure :: n_steps
        procedure :: is_like
    end type setting_t

    !> A setting that has been tried.
    type, public :: rung_t
        type(setting_t) :: setting
        character(16) :: source = ''                !! of the error that it looks at: mesh, time, ...
        integer :: compared_with = 0                !! another rung; 0: none
        real(wp) :: change = 0.0_wp                 !! of the probes against it, relative [-]
        integer :: steps = 0                        !! that it has taken
        real(wp) :: work = 0.0_wp                   !! elements times Newton iterations, weighed [-]
        real(wp) :: cpu_seconds = 0.0_wp
        character(:), allocatable :: failure        !! why it came to no end, or empty
    end type rung_t

    !> Where errors come from.
    integer, parameter, public :: n_sources = 4
    integer, parameter, public :: source_mesh = 1, source_time = 2, source_thickness = 3, source_inertia = 4
    character(9), parameter, public :: source_names(n_sources) = [character(9) :: 'mesh', 'time', &
        'thickness', 'inertia']

    !> The error bar of a probe in a command.
    type, public :: error_bar_t
        integer :: task = 0, probe = 0              !! numbers in the problem's lists
        real(wp) :: relative = 0.0_wp               !! estimated error [-]
        real(wp) :: absolute = 0.0_wp               !! the same in the probe's unit
    end type error_bar_t

    type, public :: tuning_t
        real(wp) :: accuracy = 0.0_wp               !! the strictest asked for [-]
        real(wp) :: estimate = 0.0_wp               !! of the chosen setting's error, as `accuracy` [-]
        real(wp) :: parts(n_sources) = 0.0_wp       !! of the estimate, by source [-]
        type(setting_t) :: chosen
        type(rung_t), allocatable :: rungs(:)
        type(error_bar_t), allocatable :: bars(:)
    end type tuning_t

contains

    pure integer function n_elements(self)
        class(setting_t), intent(in) :: self

        n_elements = sum(self%elements)
    end function n_elements

    !> Steps of all commands that are tuned.
    pure integer function n_steps(self)
        class(setting_t), intent(in) :: self

        n_steps = sum(self%steps)
    end function n_steps

    !> Whether two settings give the same numbers.
    pure logical function is_like(self, other)
        class(setting_t), intent(in) :: self
        type(setting_t), intent(in) :: other

        is_like = all(self%elements == other%elements) .and. all(self%steps == other%steps) &
            .and. abs(self%local - other%local) <= 0.0_wp &
            .and. self%nodes == other%nodes .and. self%points == other%points &
            .and. self%inertia == other%inertia .and. self%scheme == other%scheme
    end function is_like

end module gb_tuning
