!> Small models for the tests, and a recorder that keeps all it is told. Models are built as the deck's reader
!> would build them: a straight beam of one material and one section, then supports and loads one by one.
module small_models
    use gb_kinds, only: wp
    use gb_error, only: error_t
    use gb_memory, only: memory_t
    use gb_section, only: material_t, section_t
    use gb_mesh, only: line_t, build_mesh
    use gb_history, only: history_t
    use gb_load, only: support_t, point_load_t, distributed_load_t, gravity_t
    use gb_model, only: model_t
    use gb_problem, only: task_t, task_static, task_modal, task_transient
    use gb_state, only: state_t
    use gb_system, only: system_t, build_system
    use gb_external, only: external_t, build_external
    use gb_recorder, only: recorder_t, step_record_t
    use gb_static, only: run_static
    use gb_modal, only: run_modal
    use gb_transient, only: run_transient
    implicit none
    private

    !> What is held by the deck's CLAMP, PIN, ROLLER and SLIDE (u1 u3 y1 y3 xi).
    logical, parameter, public :: clamped(5) = .true.
    logical, parameter, public :: pinned(5) = [.true., .true., .false., .false., .false.]
    logical, parameter, public :: rolling(5) = [.false., .true., .false., .false., .false.]
    logical, parameter, public :: sliding(5) = [.true., .false., .true., .true., .false.]
    !> The clamp of beam theory: the thickness stretches y3 and xi are left free.
    logical, parameter, public :: held(5) = [.true., .true., .true., .false., .false.]

    !> A model ready to be solved, with its state.
    type, public :: bench_t
        type(model_t) :: model
        type(system_t) :: system
        type(external_t) :: external
        type(state_t) :: state
    contains
        procedure :: prepare
        procedure :: solve
        procedure :: value_at
    end type bench_t

    !> All that a solution command has told. Row i of the histories is record i - 1: row 1 is the start state.
    type, extends(recorder_t), public :: recording_t
        type(step_record_t), allocatable :: steps(:)    !! (rows)
        real(wp), allocatable :: u(:, :)                !! (n, rows)
        real(wp), allocatable :: v(:, :)                !! (n, rows)
        real(wp), allocatable :: a(:, :)                !! (n, rows)
        real(wp), allocatable :: frequency(:)           !! [cycles/T] (nm)
        real(wp), allocatable :: modes(:, :)            !! (n, nm)
        character(:), allocatable :: notes              !! joined by '; '
    contains
        procedure :: begin_task
        procedure :: record_step
        procedure :: record_modes
        procedure :: end_task
        procedure :: note
    end type recording_t

    public :: rubber, rectangle, beam, add_support, add_point, add_distributed, add_gravity, add_step_history
    public :: static_task, modal_task, transient_task
    public :: example_cantilever, example_two_span, example_sliding

contains

    !> Gent material with the small-strain constants of the paper: mu = e/(2(1+nu)), c = e nu/(1-nu^2), beta =
    !> -2.
    pure function rubber(e, nu, jm, rho) result(material)
        real(wp), intent(in) :: e, nu, jm, rho
        type(material_t) :: material

        material%name = 'rubber'
        material%mu = e/(2.0_wp*(1.0_wp + nu))
        material%c = e*nu/(1.0_wp - nu**2)
        material%beta = -2.0_wp
        material%jm = jm
        material%rho = rho
    end function rubber

    pure function rectangle(b, h, rule, points, inertia) result(section)
        real(wp), intent(in) :: b, h
        integer, intent(in), optional :: rule, points, inertia
        type(section_t) :: section

        section%name = 'section'
        section%b = b
        section%h = h
        if (present(rule)) section%rule = rule
        if (present(points)) section%points = points
        if (present(inertia)) section%inertia = inertia
    end function rectangle

    !> A straight beam from 0 to `length`, without supports and loads.
    pure function beam(material, section, length, elements, nodes, full_integration) result(model)
        type(material_t), intent(in) :: material
        type(section_t), intent(in) :: section
        real(wp), intent(in) :: length
        integer, intent(in) :: elements
        integer, intent(in), optional :: nodes                  !! nodes an element (3)
        logical, intent(in), optional :: full_integration
        type(model_t) :: model
        type(line_t) :: line

        line%from = 0.0_wp
        line%to = length
        line%elements = elements
        if (present(nodes)) line%nodes = nodes
        if (present(full_integration)) line%full_integration = full_integration
        model%title = ''
        model%units%length = ''
        model%units%force = ''
        model%units%time = ''
        model%materials = [material]
        model%sections = [section]
        model%lines = [line]
        model%mesh = build_mesh(model%lines)
        allocate (model%supports(0), model%prescribed(0), model%histories(1), model%point_loads(0))
        allocate (model%distributed_loads(0), model%gravity(0), model%initial(0))
        model%histories(1)%name = 'step'
    end function beam

    pure subroutine add_support(model, x, fixed)
        type(model_t), intent(inout) :: model
        real(wp), intent(in) :: x
        logical, intent(in) :: fixed(5)
        type(support_t) :: support

        support%x = x
        support%fixed = fixed
        model%supports = [model%supports, support]
    end subroutine add_support

    pure subroutine add_point(model, x, f1, f3, history, stage)
        type(model_t), intent(inout) :: model
        real(wp), intent(in) :: x, f1, f3
        integer, intent(in), optional :: history, stage
        type(point_load_t) :: load

        load%x = x
        load%value(1:2) = [f1, f3]
        if (present(history)) load%history = history
        if (present(stage)) load%stage = stage
        model%point_loads = [model%point_loads, load]
    end subroutine add_point

    pure subroutine add_distributed(model, from, to, q1, q3, history, stage)
        type(model_t), intent(inout) :: model
        real(wp), intent(in) :: from, to, q1, q3
        integer, intent(in), optional :: history, stage
        type(distributed_load_t) :: load

        load%from = from
        load%to = to
        load%q = [q1, q3]
        if (present(history)) load%history = history
        if (present(stage)) load%stage = stage
        model%distributed_loads = [model%distributed_loads, load]
    end subroutine add_distributed

    pure subroutine add_gravity(model, g1, g3)
        type(model_t), intent(inout) :: model
        real(wp), intent(in) :: g1, g3
        type(gravity_t) :: load

        load%g = [g1, g3]
        model%gravity = [model%gravity, load]
    end subroutine add_gravity

    !> A load history that jumps from 0 to 1 at `start`; its number is the size of the list then.
    pure subroutine add_step_history(model, start)
        type(model_t), intent(inout) :: model
        real(wp), intent(in) :: start
        type(history_t) :: history

        history%name = 'late'
        history%start = start
        model%histories = [model%histories, history]
    end subroutine add_step_history

    !> Example 1: cantilever under a sudden uniform load.
    pure function example_cantilever(jm, rule, elements) result(model)
        real(wp), intent(in) :: jm
        integer, intent(in) :: rule
        integer, intent(in), optional :: elements
        type(model_t) :: model
        integer :: n

        n = 10
        if (present(elements)) n = elements
        model = beam(rubber(12000.0_wp, 0.2_wp, jm, 1.0e-6_wp), rectangle(1.0_wp, 1.0_wp, rule, 4), &
            10.0_wp, n)
        call add_support(model, 0.0_wp, clamped)
        call add_distributed(model, 0.0_wp, 10.0_wp, 0.0_wp, 2.85_wp)
    end function example_cantilever

    !> Example 2: beam on two pins and a clamp.
    pure function example_two_span(jm, rule) result(model)
        real(wp), intent(in) :: jm
        integer, intent(in) :: rule
        type(model_t) :: model

        model = beam(rubber(14000.0_wp, 0.3_wp, jm, 1.0e-4_wp), rectangle(1.0_wp, 1.0_wp, rule), 12.0_wp, 24)
        call add_support(model, 0.0_wp, pinned)
        call add_support(model, 6.0_wp, pinned)
        call add_support(model, 12.0_wp, clamped)
        call add_distributed(model, 0.0_wp, 4.0_wp, 0.0_wp, -20.0_wp)
        call add_point(model, 9.0_wp, 0.0_wp, -6.67_wp)
    end function example_two_span

    !> Example 3: beam with a sliding end, three supports, three loads.
    pure function example_sliding(jm, rule) result(model)
        real(wp), intent(in) :: jm
        integer, intent(in) :: rule
        type(model_t) :: model

        model = beam(rubber(14000.0_wp, 0.3_wp, jm, 4.0e-4_wp), rectangle(1.0_wp, 1.0_wp, rule), 12.0_wp, 24)
        call add_support(model, 0.0_wp, clamped)
        call add_support(model, 4.0_wp, pinned)
        call add_support(model, 8.0_wp, rolling)
        call add_support(model, 12.0_wp, sliding)
        call add_distributed(model, 0.0_wp, 4.0_wp, 0.0_wp, -50.0_wp)
        call add_point(model, 6.0_wp, 0.0_wp, -50.0_wp)
        call add_point(model, 12.0_wp, 0.0_wp, -16.67_wp)
    end function example_sliding

    pure function static_task(steps, load) result(task)
        integer, intent(in) :: steps
        real(wp), intent(in), optional :: load
        type(task_t) :: task

        task%kind = task_static
        task%name = 'static'
        task%steps = steps
        if (present(load)) task%load = load
    end function static_task

    pure function modal_task(count) result(task)
        integer, intent(in) :: count
        type(task_t) :: task

        task%kind = task_modal
        task%name = 'modal'
        task%count = count
    end function modal_task

    pure function transient_task(step, end_time) result(task)
        real(wp), intent(in) :: step, end_time
        type(task_t) :: task

        task%kind = task_transient
        task%name = 'transient'
        task%scheme = 'newmark'
        task%step = step
        task%end_time = end_time
    end function transient_task

    !> Make the model ready, at rest in its reference state.
    subroutine prepare(self, model)
        class(bench_t), intent(inout) :: self
        type(model_t), intent(in) :: model

        self%model = model
        self%system = build_system(model)
        self%external = build_external(model)
        self%state = state_t()
        allocate (self%state%u(self%system%n), self%state%v(self%system%n), self%state%a(self%system%n))
        self%state%u = 0.0_wp
        self%state%v = 0.0_wp
        self%state%a = 0.0_wp
    end subroutine prepare

    !> Run one solution command from the state the last one left.
    subroutine solve(self, task, recording, error)
        class(bench_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(recording_t), intent(out) :: recording
        type(error_t), allocatable, intent(out) :: error
        type(memory_t) :: memory

        call recording%begin_task(task, error)
        select case (task%kind)
        case (task_static)
            call run_static(self%system, self%external, self%model%mesh, task, memory, self%state, &
                recording, error)
        case (task_modal)
            call run_modal(self%system, self%model, task, self%state, recording, error)
        case default
            call run_transient(self%system, self%external, self%model%mesh, task, memory, self%state, &
                recording, error)
        end select
    end subroutine solve

    !> A field's displacement at the node x.
    pure real(wp) function value_at(self, field, x) result(value)
        class(bench_t), intent(in) :: self
        integer, intent(in) :: field
        real(wp), intent(in) :: x

        value = self%state%u(5*(self%model%mesh%node_at(x) - 1) + field)
    end function value_at

    subroutine begin_task(self, task, error)
        class(recording_t), intent(inout) :: self
        type(task_t), intent(in) :: task
        type(error_t), allocatable, intent(out) :: error

        allocate (self%steps(0))
        self%notes = ''
    end subroutine begin_task

    subroutine record_step(self, step, state, error)
        class(recording_t), intent(inout) :: self
        type(step_record_t), intent(in) :: step
        type(state_t), intent(in) :: state
        type(error_t), allocatable, intent(out) :: error
        type(step_record_t), allocatable :: steps(:)
        integer :: rows

        rows = size(self%steps)
        allocate (steps(rows + 1))
        steps(:rows) = self%steps
        steps(rows + 1) = step
        call move_alloc(steps, self%steps)
        if (rows == 0) allocate (self%u(size(state%u), 0), self%v(size(state%u), 0), self%a(size(state%u), 0))
        call append(self%u, state%u)
        call append(self%v, state%v)
        call append(self%a, state%a)
    end subroutine record_step

    !> One more column.
    pure subroutine append(table, column)
        real(wp), allocatable, intent(inout) :: table(:, :)
        real(wp), intent(in) :: column(:)
        real(wp), allocatable :: grown(:, :)
        integer :: columns

        columns = size(table, 2)
        allocate (grown(size(column), columns + 1))
        grown(:, :columns) = table
        grown(:, columns + 1) = column
        call move_alloc(grown, table)
    end subroutine append

    subroutine record_modes(self, frequency, modes, error)
        class(recording_t), intent(inout) :: self
        real(wp), intent(in) :: frequency(:)
        real(wp), intent(in) :: modes(:, :)
        type(error_t), allocatable, intent(out) :: error

        self%frequency = frequency
        self%modes = modes
    end subroutine record_modes

    subroutine end_task(self, failure, error)
        class(recording_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: failure
        type(error_t), allocatable, intent(out) :: error
    end subroutine end_task

    subroutine note(self, text)
        class(recording_t), intent(inout) :: self
        character(*), intent(in) :: text

        if (len(self%notes) > 0) self%notes = self%notes // '; '
        self%notes = self%notes // text
    end subroutine note

end module small_models
