!> What the benchmarks run: example 1 with any number of elements, and a recorder that only counts.
module bench_models
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_mesh, only: line_t, build_mesh
    use gb_load, only: support_t, distributed_load_t
    use gb_model, only: model_t
    use gb_problem, only: task_t, task_transient
    use gb_state, only: state_t
    use gb_recorder, only: recorder_t, step_record_t
    use gb_system, only: system_t, build_system
    use gb_external, only: external_t, build_external
    use gb_transient, only: run_transient
    use gb_memory, only: memory_t
    implicit none
    private

    !> Counts steps and Newton iterations and forgets the rest.
    type, extends(recorder_t), public :: counter_t
        integer :: steps = 0, iterations = 0, cuts = 0
        real(wp) :: tip = 0.0_wp
    contains
        procedure :: begin_task
        procedure :: record_step
        procedure :: record_modes
        procedure :: end_task
        procedure :: note
    end type counter_t

    public :: example_1, transient_of, run_counted, seconds

contains

    !> Example 1: cantilever under a sudden uniform load, Gauss rule with three points.
    function example_1(elements, jm, points) result(model)
        integer, intent(in) :: elements, points
        real(wp), intent(in) :: jm
        type(model_t) :: model
        type(line_t) :: line
        type(support_t) :: clamp
        type(distributed_load_t) :: load

        line%to = 10.0_wp
        line%elements = elements
        model%title = ''
        model%units%length = ''
        model%units%force = ''
        model%units%time = ''
        allocate (model%materials(1), model%sections(1))
        model%materials(1)%name = 'rubber'
        model%materials(1)%mu = 5000.0_wp
        model%materials(1)%c = 2500.0_wp
        model%materials(1)%jm = jm
        model%materials(1)%rho = 1.0e-6_wp
        model%sections(1)%name = 'square'
        model%sections(1)%b = 1.0_wp
        model%sections(1)%h = 1.0_wp
        model%sections(1)%points = points
        model%lines = [line]
        model%mesh = build_mesh(model%lines)
        clamp%fixed = .true.
        load%to = 10.0_wp
        load%q = [0.0_wp, 2.85_wp]
        model%supports = [clamp]
        model%distributed_loads = [load]
        allocate (model%prescribed(0), model%histories(1), model%point_loads(0), model%gravity(0))
        allocate (model%initial(0))
        model%histories(1)%name = 'step'
    end function example_1

    !> Newmark's rule as in example 1, over so many steps.
    function transient_of(steps, solver) result(task)
        integer, intent(in) :: steps, solver
        type(task_t) :: task

        task%kind = task_transient
        task%name = 'transient'
        task%scheme = 'newmark'
        task%step = 1.35e-4_wp
        task%end_time = real(steps, wp)*task%step
        task%solver = solver
    end function transient_of

    !> Run from rest; the time is that of the solution alone, without building the model.
    subroutine run_counted(system, external, model, task, counter, time)
        type(system_t), intent(in) :: system
        type(external_t), intent(in) :: external
        type(model_t), intent(in) :: model
        type(task_t), intent(in) :: task
        type(counter_t), intent(out) :: counter
        real(wp), intent(out) :: time               !! [s]
        type(state_t) :: state
        type(memory_t) :: memory
        type(error_t), allocatable :: error
        real(wp) :: start

        allocate (state%u(system%n), state%v(system%n), state%a(system%n))
        state%u = 0.0_wp
        state%v = 0.0_wp
        state%a = 0.0_wp
        start = seconds()
        call run_transient(system, external, model%mesh, task, memory, state, counter, error)
        time = seconds() - start
        if (allocated(error)) time = huge(time)
    end subroutine run_counted

    !> CPU time of this process [s].
    real(wp) function seconds()
        call cpu_time(seconds)
    end function seconds

    subroutine begin_task(self, task, error)
        class(counter_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        self%steps = 0
    end subroutine begin_task

    subroutine record_step(self, step, state, error)
        class(counter_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error

        self%steps = self%steps + 1
        self%iterations = self%iterations + step%iterations
        self%cuts = self%cuts + step%cuts
        self%tip = state%u(size(state%u) - 3)
    end subroutine record_step

    subroutine record_modes(self, frequency, modes, error)
        class(counter_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:), modes(:, :)
        type(error_t), allocatable, intent(out) :: error

        self%steps = self%steps + size(frequency)
    end subroutine record_modes

    subroutine end_task(self, failure, error)
        class(counter_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: failure
        type(error_t), allocatable, intent(out) :: error

        self%steps = self%steps
    end subroutine end_task

    subroutine note(self, text)
        class(counter_t), intent(inout) :: self
        character(*), intent(in) :: text

        self%steps = self%steps
    end subroutine note

end module bench_models
