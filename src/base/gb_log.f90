!> The log on standard output and the progress bar on standard error.
module gb_log
    use, intrinsic :: iso_fortran_env, only: error_unit
    use gb_kinds, only: wp, i8
    use gb_posix, only: standard_error_is_terminal, write_output
    use gb_colour, only: has_colours, colour_line, standard_output
    use gb_text, only: to_text, newline
    implicit none
    private

    integer, parameter, public :: log_quiet = 0, log_normal = 1, log_verbose = 2

    type, public :: log_t
        integer :: level = log_normal
        logical :: has_failed = .false.             !! standard output took no more
        logical :: knows_colours = .false., coloured = .false.
        logical :: has_bar = .false.                !! a progress bar stands on the terminal
        integer(i8) :: bar_start = 0, bar_last = 0  !! clock counts
    contains
        procedure :: line
        procedure :: detail
        procedure :: start_bar
        procedure :: show_bar
        procedure :: clear_bar
    end type log_t

    integer, parameter :: bar_width = 40
    real(wp), parameter :: bar_seconds = 0.1_wp     !! between two pictures of the bar

contains

    !> A line of the log, unless --quiet.
    subroutine line(self, text)
        class(log_t), intent(inout) :: self
        character(*), intent(in) :: text
        logical :: failed

        if (self%level < log_normal) return
        call self%clear_bar()
        if (.not. self%knows_colours) then
            self%knows_colours = .true.
            self%coloured = has_colours(standard_output)
        end if
        if (self%coloured) then
            call write_output(colour_line(text) // newline, failed)
        else
            call write_output(text // newline, failed)
        end if
        self%has_failed = self%has_failed .or. failed
    end subroutine line

    !> A line for --verbose only.
    subroutine detail(self, text)
        class(log_t), intent(inout) :: self
        character(*), intent(in) :: text

        if (self%level >= log_verbose) call self%line(text)
    end subroutine detail

    !> From now on `show_bar` measures the time left from here.
    subroutine start_bar(self)
        class(log_t), intent(inout) :: self

        call system_clock(self%bar_start)
        self%bar_last = self%bar_start
    end subroutine start_bar

    !> Draw the progress bar, if standard error is a terminal.
    subroutine show_bar(self, done)
        class(log_t), intent(inout) :: self
        real(wp), intent(in) :: done            !! 0 to 1
        integer(i8) :: count, rate
        integer :: filled, info

        if (self%level /= log_normal) return
        call system_clock(count, rate)
        if (real(count - self%bar_last, wp) < bar_seconds*real(rate, wp)) return
        self%bar_last = count
        if (.not. standard_error_is_terminal()) return
        filled = nint(done*real(bar_width, wp))
        write (error_unit, '(a)', advance='no', iostat=info) achar(13) // '  [' // repeat('#', filled) // &
            repeat('.', bar_width - filled) // '] ' // to_text(nint(100.0_wp*done)) // ' %, ' // &
            duration((1.0_wp - done)/max(done, 1.0e-9_wp)*real(count - self%bar_start, wp)/real(rate, wp)) &
            // ' left     '
        flush (error_unit, iostat=info)
        self%has_bar = .true.
    end subroutine show_bar

    !> "12 s", "3 min 20 s", "2 h 5 min": what is left of a run, rounded up to seconds, then to minutes.
    pure function duration(seconds) result(text)
        real(wp), intent(in) :: seconds
        character(:), allocatable :: text
        integer(i8) :: whole

        whole = ceiling(min(seconds, 1.0e12_wp), i8)
        if (whole < 60) then
            text = to_text(int(whole)) // ' s'
        else if (whole < 3600) then
            text = to_text(int(whole/60)) // ' min ' // to_text(int(modulo(whole, 60_i8))) // ' s'
        else if (whole < 86400000) then
            text = to_text(int(whole/3600)) // ' h ' // to_text(int(modulo(whole, 3600_i8)/60)) // ' min'
        else
            text = 'very long'
        end if
    end function duration

    !> Wipe the bar off the terminal.
    subroutine clear_bar(self)
        class(log_t), intent(inout) :: self
        integer :: info

        if (.not. self%has_bar) return
        write (error_unit, '(a)', advance='no', iostat=info) achar(13) // repeat(' ', bar_width + 30) &
            // achar(13)
        flush (error_unit, iostat=info)
        self%has_bar = .false.
    end subroutine clear_bar

end module gb_log
