!> A study: many members on several threads. Members are handed out in batches, solved side by side, and
!> handed on in their order, by one thread at a time: what comes out does not depend on the threads.
module gb_study
    use gb_error, only: error_t
    use gb_member, only: member_t
    use gb_member_run, only: run_members
    use gb_posix, only: pause_briefly
    implicit none
    private

    !> Makes members. Several threads ask at once.
    type, abstract, public :: member_source_t
    contains
        procedure(make_i), deferred :: make
    end type member_source_t

    !> Takes members that have run, in their order. One thread at a time calls.
    type, abstract, public :: member_sink_t
    contains
        procedure(take_i), deferred :: take
        procedure(wants_stop_i), deferred :: wants_stop
    end type member_sink_t

    abstract interface
        !> Give member `number` its values and its problem; or, where the deck is wrong for them, an outcome
        !> and a message.
        subroutine make_i(self, number, member)
            import :: member_source_t, member_t
            class(member_source_t), intent(in) :: self
            integer, intent(in) :: number
            type(member_t), intent(inout) :: member
        end subroutine make_i

        subroutine take_i(self, member, error)
            import :: member_sink_t, member_t, error_t
            class(member_sink_t), intent(inout) :: self
            type(member_t), intent(inout) :: member
            type(error_t), allocatable, intent(out) :: error
        end subroutine take_i

        !> Whether no further members shall begin; those that have begun are still taken.
        logical function wants_stop_i(self)
            import :: member_sink_t
            class(member_sink_t), intent(inout) :: self
        end function wants_stop_i
    end interface

    type :: batch_t
        type(member_t), allocatable :: members(:)
    end type batch_t

    !> Which batches are to be run, have run and have been taken. Only one thread at a time touches it.
    type :: queue_t
        integer :: batches = 0                      !! all there are
        integer :: begun = 0                        !! handed out to threads
        integer :: taken = 0                        !! gone to the sink
        logical :: is_draining = .false.            !! a thread is at the sink
        logical :: is_over = .false.                !! no further batch begins
        type(batch_t), allocatable :: ring(:)       !! batches that have run and wait for their turn
        type(error_t), allocatable :: error
    end type queue_t

    integer, parameter :: got_batch = 1, must_wait = 2, all_begun = 3

    public :: run_study

contains

    !> Run the numbered members. `members_a_batch` and `batches_ahead` bound what waits in memory: the product
    !> of both, whatever the number of members. An error of the sink ends the study.
    subroutine run_study(source, sink, numbers, threads, members_a_batch, batches_ahead, error)
        class(member_source_t), intent(in) :: source
        class(member_sink_t), intent(inout) :: sink
        integer, intent(in) :: numbers(:)           !! increasing
        integer, intent(in) :: threads
        integer, intent(in) :: members_a_batch
        integer, intent(in) :: batches_ahead        !! of the sink; at least 1
        type(error_t), allocatable, intent(out) :: error
        type(queue_t) :: queue

        queue%batches = (size(numbers) + members_a_batch - 1)/members_a_batch
        allocate (queue%ring(0:max(1, batches_ahead) - 1))
        !$omp parallel num_threads(threads) default(none) &
        !$omp shared(source, sink, numbers, members_a_batch, queue)
        call work(source, sink, numbers, members_a_batch, queue)
        !$omp end parallel
        call move_alloc(queue%error, error)
    end subroutine run_study

    !> What one thread does.
    subroutine work(source, sink, numbers, members_a_batch, queue)
        class(member_source_t), intent(in) :: source
        class(member_sink_t), intent(inout) :: sink
        integer, intent(in) :: numbers(:), members_a_batch
        type(queue_t), intent(inout) :: queue
        type(member_t), allocatable :: members(:)
        integer :: answer, batch, first, i

        do
            !$omp critical (gb_study_queue)
            call claim(queue, sink, answer, batch)
            !$omp end critical (gb_study_queue)
            if (answer == all_begun) exit
            if (answer == must_wait) then
                call pause_briefly()
                cycle
            end if
            first = (batch - 1)*members_a_batch + 1
            allocate (members(min(members_a_batch, size(numbers) - first + 1)))
            do i = 1, size(members)
                call source%make(numbers(first + i - 1), members(i))
            end do
            call run_members(members)
            call hand_over(queue, batch, members, sink)
        end do
    end subroutine work

    !> The next batch, if there is one and room for what it will have to tell.
    subroutine claim(queue, sink, answer, batch)
        type(queue_t), intent(inout) :: queue
        class(member_sink_t), intent(inout) :: sink
        integer, intent(out) :: answer, batch

        batch = 0
        answer = all_begun
        if (.not. queue%is_over) queue%is_over = sink%wants_stop()
        queue%is_over = queue%is_over .or. queue%begun == queue%batches
        if (queue%is_over) return
        answer = must_wait
        if (queue%begun - queue%taken >= size(queue%ring)) return
        answer = got_batch
        queue%begun = queue%begun + 1
        batch = queue%begun
    end subroutine claim

    !> Put a batch into its place; who finds the next batch in turn there, takes it to the sink, and those
    !> behind it.
    subroutine hand_over(queue, batch, members, sink)
        type(queue_t), intent(inout) :: queue
        integer, intent(in) :: batch
        type(member_t), allocatable, intent(inout) :: members(:)
        class(member_sink_t), intent(inout) :: sink
        type(member_t), allocatable :: turn(:)
        type(error_t), allocatable :: error
        integer :: i

        !$omp critical (gb_study_queue)
        call move_alloc(members, queue%ring(modulo(batch, size(queue%ring)))%members)
        call take_turn(queue, turn)
        !$omp end critical (gb_study_queue)
        do while (allocated(turn))
            do i = 1, size(turn)
                if (.not. allocated(error)) call sink%take(turn(i), error)
            end do
            deallocate (turn)
            !$omp critical (gb_study_queue)
            queue%is_draining = .false.
            queue%taken = queue%taken + 1
            if (allocated(error)) then
                queue%is_over = .true.
                call move_alloc(error, queue%error)
            else
                call take_turn(queue, turn)
            end if
            !$omp end critical (gb_study_queue)
        end do
    end subroutine hand_over

    !> The batch whose turn it is, unless it has not run yet or another thread is at the sink.
    subroutine take_turn(queue, turn)
        type(queue_t), intent(inout) :: queue
        type(member_t), allocatable, intent(inout) :: turn(:)

        if (queue%is_draining .or. allocated(queue%error)) return
        associate (place => queue%ring(modulo(queue%taken + 1, size(queue%ring))))
            if (.not. allocated(place%members)) return
            call move_alloc(place%members, turn)
        end associate
        queue%is_draining = .true.
    end subroutine take_turn

end module gb_study
