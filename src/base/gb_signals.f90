!> Signals that ask a run or a study to stop (SIGTERM, SIGINT, SIGUSR1): noted when they come, looked for
!> between steps.
module gb_signals
    use, intrinsic :: iso_c_binding, only: c_double, c_int
    use gb_kinds, only: wp
    implicit none
    private

    interface
        !> From now on the three signals are taken note of. A second SIGINT still ends the program at once.
        subroutine watch_signals() bind(c, name="gb_watch_signals")
        end subroutine watch_signals

        subroutine c_stop_after(seconds) bind(c, name="gb_stop_after")
            import :: c_double
            real(c_double), value, intent(in) :: seconds
        end subroutine c_stop_after

        function c_caught_signal() bind(c, name="gb_caught_signal") result(number)
            import :: c_int
            integer(c_int) :: number
        end function c_caught_signal
    end interface

    public :: watch_signals, stop_after, has_caught_signal, caught_signal

contains

    !> --max-time of a study: after so many seconds of wall time there will have been a signal.
    subroutine stop_after(seconds)
        real(wp), intent(in) :: seconds

        call c_stop_after(real(seconds, c_double))
    end subroutine stop_after

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
        case (4)
            name = '--max-time'
        case default
            name = ''
        end select
    end function caught_signal

end module gb_signals
