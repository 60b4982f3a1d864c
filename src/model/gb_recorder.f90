!> What a solution method tells the world: an abstract observer that results files, logs and tests extend, so
!> that the methods know nothing of files.
module gb_recorder
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_memory, only: memory_t
    use gb_problem, only: task_t
    use gb_state, only: state_t
    implicit none
    private

    !> One accepted step (row 0 of a command is its start state).
    type, public :: step_record_t
        integer :: number = 0                   !! 0 for the start state
        logical :: on_grid = .true.             !! false for a part of a step that was split or cut
        real(wp) :: abscissa = 0.0_wp           !! time [T]; statics: load factor [-]
        real(wp) :: progress = 0.0_wp           !! done part of the command, 0 to 1
        real(wp) :: step = 0.0_wp               !! its size, as abscissa
        integer :: iterations = 0               !! Newton iterations, those of rejected attempts included
        integer :: cuts = 0                     !! rejected attempts
        real(wp) :: residual = 0.0_wp           !! norm of the last residual over that of the forces [-]
        real(wp) :: kinetic = 0.0_wp            !! energies [F L]
        real(wp) :: strain = 0.0_wp
        real(wp) :: external = 0.0_wp           !! work of the loads since the command began
        real(wp) :: dissipated = 0.0_wp         !! by damping since the command began
        real(wp), allocatable :: increments(:)  !! largest relative increment of each iteration of the last
                                                !! solution [-]
    contains
        procedure :: pass_memory
    end type step_record_t

    type, abstract, public :: recorder_t
    contains
        procedure(begin_task_i), deferred :: begin_task
        procedure(record_step_i), deferred :: record_step
        procedure(record_modes_i), deferred :: record_modes
        procedure(end_task_i), deferred :: end_task
        procedure(note_i), deferred :: note
        procedure :: wants_memory
        procedure :: keep_memory
    end type recorder_t

    abstract interface
        subroutine begin_task_i(self, task, error)
            import :: recorder_t, task_t, error_t
            class(recorder_t), intent(inout) :: self
            type(task_t), intent(in) :: task
            type(error_t), allocatable, intent(out) :: error
        end subroutine begin_task_i

        subroutine record_step_i(self, step, state, error)
            import :: recorder_t, step_record_t, state_t, error_t
            class(recorder_t), intent(inout) :: self
            type(step_record_t), intent(in) :: step
            type(state_t), intent(in) :: state
            type(error_t), allocatable, intent(out) :: error
        end subroutine record_step_i

        !> Natural frequencies [cycles/T] (nm), negative for an unstable mode (see docs/results.md), and modes
        !> (5 nn, nm).
        subroutine record_modes_i(self, frequency, modes, error)
            import :: recorder_t, wp, error_t
            class(recorder_t), intent(inout) :: self
            real(wp), intent(in) :: frequency(:)
            real(wp), intent(in) :: modes(:, :)
            type(error_t), allocatable, intent(out) :: error
        end subroutine record_modes_i

        !> The command is over; `failure` is unallocated where it succeeded.
        subroutine end_task_i(self, failure, error)
            import :: recorder_t, error_t
            class(recorder_t), intent(inout) :: self
            type(error_t), allocatable, intent(in) :: failure
            type(error_t), allocatable, intent(out) :: error
        end subroutine end_task_i

        !> Something the user should know that is no error: a line of the log.
        subroutine note_i(self, text)
            import :: recorder_t
            class(recorder_t), intent(inout) :: self
            character(*), intent(in) :: text
        end subroutine note_i
    end interface

contains

    !> Whether the recorder wants to keep what the run needs to go on from the step just recorded. A method
    !> asks after every step, so this must cost nothing.
    logical function wants_memory(self)
        class(recorder_t), intent(inout) :: self

        wants_memory = .false.
    end function wants_memory

    !> Keep a method's memory, to which the recorder may add its own. An error ends the run there; its status
    !> is status_interrupted where that is what somebody outside asked for.
    subroutine keep_memory(self, memory, error)
        class(recorder_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory
        type(error_t), allocatable, intent(out) :: error
    end subroutine keep_memory

    !> What the next step's record is made from.
    subroutine pass_memory(self, memory, prefix)
        class(step_record_t), intent(inout) :: self
        type(memory_t), intent(inout) :: memory
        character(*), intent(in) :: prefix

        call memory%pass(prefix // '.number', self%number)
        call memory%pass(prefix // '.abscissa', self%abscissa)
        call memory%pass(prefix // '.kinetic', self%kinetic)
        call memory%pass(prefix // '.strain', self%strain)
        call memory%pass(prefix // '.external', self%external)
        call memory%pass(prefix // '.dissipated', self%dissipated)
    end subroutine pass_memory

end module gb_recorder
