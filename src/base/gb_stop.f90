!> Requests to stop: SIGTERM, SIGINT and SIGUSR1, as batch systems and people send them.
module gb_stop
    use, intrinsic :: iso_c_binding, only: c_int
    implicit none
    private

    interface
        !> From now on these signals ask the program to stop in place of ending it.
        subroutine listen_for_stop() bind(c, name="gb_listen_for_stop")
        end subroutine listen_for_stop

        function c_stop_signal() bind(c, name="gb_stop_signal") result(number)
            import :: c_int
            integer(c_int) :: number
        end function c_stop_signal
    end interface

    public :: listen_for_stop, stop_is_asked

contains

    !> Whether a signal has asked the program to stop.
    logical function stop_is_asked()
        stop_is_asked = c_stop_signal() /= 0
    end function stop_is_asked

end module gb_stop
