!> What a member of a study has told: kept in memory until it goes to the results file, because members run
!> side by side and files are written by one thread at a time.
module gb_member
    use gb_kinds, only: wp
    use gb_problem, only: problem_t
    implicit none
    private

    !> What became of a member; the numbers stand in the results file.
    integer, parameter, public :: member_waiting = 0, member_complete = 1, member_failed = 2

    !> Largest and smallest values of a probe during a command, and when.
    type, public :: extremes_t
        real(wp) :: largest = -huge(1.0_wp), smallest = huge(1.0_wp)
        real(wp) :: when_largest = 0.0_wp, when_smallest = 0.0_wp   !! time [T]; statics: load factor [-]
    contains
        procedure :: widen
    end type extremes_t

    integer, parameter, public :: n_energies = 5    !! kinetic, strain, external, dissipated, balance
    integer, parameter, public :: n_solver = 4      !! iterations, cuts, step, residual

    !> What one solution command has told.
    type, public :: command_record_t
        integer :: rows = 0                         !! rows of the fields (OUTPUT every=)
        integer :: steps = 0                        !! steps, the start state included
        real(wp), allocatable :: row_abscissa(:)    !! time [T] or load factor [-] (at least rows)
        real(wp), allocatable :: u(:, :), v(:, :), a(:, :)  !! what OUTPUT asks for (5 nn, at least rows)
        real(wp), allocatable :: abscissa(:)        !! time [T] or load factor [-] (at least steps)
        real(wp), allocatable :: probes(:, :)       !! (at least steps, probes)
        real(wp), allocatable :: energies(:, :)     !! (at least steps, n_energies) [F L]
        real(wp), allocatable :: solver(:, :)       !! (at least steps, n_solver)
        real(wp), allocatable :: frequency(:)       !! of a MODAL command [cycles/T] (nm)
        real(wp), allocatable :: modes(:, :)        !! (5 nn, nm)
    end type command_record_t

    type, public :: member_t
        integer :: number = 0                       !! 1-based
        real(wp), allocatable :: values(:)          !! of the parameters that vary
        integer :: outcome = member_waiting
        character(:), allocatable :: message        !! why it failed, or empty
        type(problem_t), allocatable :: problem     !! unallocated where the deck is wrong for its values
        type(command_record_t), allocatable :: commands(:)  !! those that were begun
        type(extremes_t), allocatable :: extremes(:)    !! of every probe in the last command that has steps
    end type member_t

contains

    pure subroutine widen(self, value, when)
        class(extremes_t), intent(inout) :: self
        real(wp), intent(in) :: value, when

        if (value > self%largest) then
            self%largest = value
            self%when_largest = when
        end if
        if (value < self%smallest) then
            self%smallest = value
            self%when_smallest = when
        end if
    end subroutine widen

end module gb_member
