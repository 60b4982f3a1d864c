!> When a run is to keep a checkpoint, and when it is to stop: CHECKPOINT's every= and seconds=, --max-time,
!> and signals.
module gb_watch
    use gb_kinds, only: wp, i8
    use gb_problem, only: safeguard_t
    use gb_signals, only: watch_signals, has_caught_signal, caught_signal
    use gb_text, only: to_text
    implicit none
    private

    type, public :: watch_t
        real(wp) :: max_seconds = 0.0_wp            !! of --max-time [s]; 0: no limit
        integer :: every = 0                        !! steps between two checkpoints; 0: no matter
        real(wp) :: seconds = 0.0_wp                !! wall time between two checkpoints [s]; 0: no matter
        integer(i8) :: start = 0, last = 0          !! clock counts: of the run, of the last checkpoint
        integer(i8) :: step_start = 0               !! of the running step
        integer(i8) :: longest = 0                  !! step, or writing of a checkpoint, so far, in counts
        integer(i8) :: rate = 1
        logical :: is_timed = .false.               !! whether the clock decides anything
        logical :: is_out_of_time = .false.
    contains
        procedure :: begin
        procedure :: begin_task
        procedure :: is_due
        procedure :: must_stop
        procedure :: note_checkpoint
        procedure :: elapsed
        procedure :: reason
    end type watch_t

    !> Time that is left for closing the results file and for what the machine does besides [s], at most this
    !> part of the whole.
    real(wp), parameter :: reserve_seconds = 2.0_wp, reserve_part = 0.1_wp

contains

    !> The run begins: look out for signals, and note the time.
    subroutine begin(self, max_seconds, spent_seconds)
        class(watch_t), intent(inout) :: self
        real(wp), intent(in) :: max_seconds         !! 0: no limit [s]
        real(wp), intent(in) :: spent_seconds       !! of them, before [s]

        self%max_seconds = max_seconds
        call system_clock(self%start, self%rate)
        self%start = self%start - nint(spent_seconds*real(self%rate, wp), i8)
        self%last = self%start
        self%step_start = self%start
        call watch_signals()
    end subroutine begin

    !> A command begins, with what CHECKPOINT says of it.
    subroutine begin_task(self, safeguard)
        class(watch_t), intent(inout) :: self
        type(safeguard_t), intent(in) :: safeguard

        self%every = safeguard%every
        self%seconds = safeguard%seconds
        self%is_timed = self%max_seconds > 0.0_wp .or. self%seconds > 0.0_wp
        if (self%is_timed) call system_clock(self%step_start)
    end subroutine begin_task

    !> Whether a checkpoint is due after step `number` of the running command. Asked after every step.
    logical function is_due(self, number)
        class(watch_t), intent(inout) :: self
        integer, intent(in) :: number
        integer(i8) :: count

        is_due = has_caught_signal()
        if (self%every > 0) is_due = is_due .or. modulo(number, self%every) == 0
        if (.not. self%is_timed) return
        call system_clock(count)
        self%longest = max(self%longest, count - self%step_start)
        self%step_start = count
        if (self%seconds > 0.0_wp) is_due = is_due .or. in_seconds(self, count - self%last) >= self%seconds
        if (self%max_seconds <= 0.0_wp) return
        ! Another step and the checkpoint after it must still fit in.
        self%is_out_of_time = in_seconds(self, count - self%start + 2*self%longest) &
            + min(reserve_seconds, reserve_part*self%max_seconds) >= self%max_seconds
        is_due = is_due .or. self%is_out_of_time
    end function is_due

    pure real(wp) function in_seconds(self, counts)
        class(watch_t), intent(in) :: self
        integer(i8), intent(in) :: counts

        in_seconds = real(counts, wp)/real(self%rate, wp)
    end function in_seconds

    !> Whether the run is to end with the checkpoint that is being written.
    logical function must_stop(self)
        class(watch_t), intent(in) :: self

        must_stop = has_caught_signal()
        if (self%is_out_of_time) must_stop = .true.
    end function must_stop

    !> A checkpoint has been written: the next one is counted from here.
    subroutine note_checkpoint(self)
        class(watch_t), intent(inout) :: self
        integer(i8) :: count

        call system_clock(count)
        self%last = count
        self%longest = max(self%longest, count - self%step_start)
        self%step_start = count
    end subroutine note_checkpoint

    !> Wall time since the run began [s].
    real(wp) function elapsed(self)
        class(watch_t), intent(in) :: self
        integer(i8) :: count

        call system_clock(count)
        elapsed = in_seconds(self, count - self%start)
    end function elapsed

    !> Who asked the run to stop: "SIGTERM", "--max-time 3600".
    function reason(self) result(text)
        class(watch_t), intent(in) :: self
        character(:), allocatable :: text

        text = caught_signal()
        if (len(text) == 0) text = '--max-time ' // to_text(self%max_seconds)
    end function reason

end module gb_watch
