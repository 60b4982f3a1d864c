!> Signals that ask a run or a study to stop (SIGTERM, SIGINT, SIGUSR1): noted when they come, looked for
!> between steps.
module gb_signals
    use, intrinsic :: iso_c_binding, only: c_int
    implicit none
    private

    interface
        !> From now on the three signals are taken note of. A second SIGINT still ends the program at once.
        subroutine watch_signals() bind(c, name="gb_watch_signals")
        end subroutine watch_signals

        function c_caught_signal() bind(c, name="gb_caught_signal") result(number)
            import :: c_int
            integer(c_int) :: number
        end function c_caught_signal
    end interface

    public :: watch_signals, has_caught_signal, caught_signal

contains

    logical function has_caught_signal()
        has_caught_signal = c_caught_signal() /= 0
    end function has_caught_signal

    !> Name of the signal that has come, or an empty text.
    function caught_signal() result(name)
        character(:), allocatable :: name

        select case (c_caught_signal())
        case (1)
            name = 'SIGTERM'
        case (2)
            name = 'SIGINT'
        case (3)
            name = 'SIGUSR1'
        case default
            name = ''
        end select
    end function caught_signal

end module gb_signals
