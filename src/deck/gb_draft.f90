!> The problem while the deck is being read: lists that grow, names with the places of their definitions, and
!> what has to be looked at again once the model is closed.
module gb_draft
    use gb_command, only: command_t
    use gb_diagnostics, only: diagnostics_t, span_t, quoted
    use gb_history, only: history_t
    use gb_load, only: support_t, prescribed_t, point_load_t, distributed_load_t, gravity_t, initial_t
    use gb_mesh, only: line_t
    use gb_kinds, only: wp
    use gb_names, only: name_table_t, is_name
    use gb_problem, only: problem_t, probe_t, task_t, safeguard_t
    use gb_section, only: material_t, section_t
    use gb_values, only: suggestion
    implicit none
    private

    !> The kinds of names. Names and the model's lists are numbered alike.
    integer, parameter, public :: space_material = 1, space_section = 2, space_history = 3, space_probe = 4, &
        space_task = 5
    character(8), parameter, public :: space_names(5) = [character(8) :: 'material', 'section', 'history', &
        'probe', 'name']

    !> A place x of the deck that must be a node, or at least on the beam.
    type, public :: place_t
        type(span_t) :: at
        real(wp) :: x = 0.0_wp                  !! [L]
        logical :: at_node = .true.
    end type place_t

    !> Where the parts of a LINE stand in the text.
    type, public :: line_place_t
        type(span_t) :: at, from, to
        logical :: excused(2) = .false.         !! its material (section) was named, but wrongly
    end type line_place_t

    type, public :: draft_t
        type(problem_t) :: problem
        type(name_table_t) :: names(5)          !! by kind
        type(name_table_t) :: later(5)          !! every name the deck defines anywhere, by kind
        type(name_table_t) :: ghosts            !! names in commands that could not be understood
        character(:), allocatable :: folder     !! where files are looked for
        integer :: n_lines = 0, n_supports = 0, n_prescribed = 0, n_points = 0, n_distributed = 0, &
            n_gravity = 0, n_initial = 0, n_places = 0
        type(line_place_t), allocatable :: line_places(:)       !! (n_lines)
        type(span_t), allocatable :: support_places(:)          !! (n_supports)
        type(span_t), allocatable :: prescribed_places(:, :)    !! (5, n_prescribed) of the fields' values
        type(span_t), allocatable :: initial_places(:)          !! (n_initial)
        type(place_t), allocatable :: places(:)
        type(safeguard_t) :: safeguard          !! of the commands to come
        integer :: repeats(3) = 0               !! default names given so far, by kind of task
        logical :: names_lost(5) = .false.      !! a definition without a usable name: any name may be its
        logical :: incomplete = .false.         !! a command was lost: what is absent may be no mistake
        logical :: lines_lost = .false.         !! a LINE was wrong: there is no mesh to check against
        logical :: supports_lost = .false.      !! a support was wrong
        logical :: has_mesh = .false.
        character(:), allocatable :: loose      !! what rigid motion the supports leave, in words, or empty
    contains
        procedure :: define
        procedure :: resolve
        procedure :: add_place
        procedure :: close_lists
    end type draft_t

    interface resize
        module procedure resize_materials, resize_sections, resize_lines, resize_line_places, &
            resize_supports, resize_prescribed, resize_points, resize_distributed, resize_gravity, &
            resize_initial, resize_histories, resize_probes, resize_tasks, resize_places, resize_spans
    end interface resize

    public :: new_draft, resize

contains

    !> An empty draft; the history `step` is built in.
    pure subroutine new_draft(draft, folder)
        type(draft_t), intent(out) :: draft
        character(*), intent(in) :: folder

        draft%folder = folder
        draft%loose = ''
        associate (model => draft%problem%model)
            model%title = ''
            model%units%length = ''
            model%units%force = ''
            model%units%time = ''
            allocate (model%materials(0), model%sections(0), model%lines(0), model%supports(0), &
                model%prescribed(0))
            allocate (model%histories(1), model%point_loads(0), model%distributed_loads(0), model%gravity(0))
            allocate (model%initial(0))
            model%histories(1)%name = 'step'
        end associate
        call draft%names(space_history)%define('step', span_t(), sound=.true.)
        allocate (draft%problem%probes(0), draft%problem%tasks(0))
        allocate (draft%line_places(0), draft%support_places(0), draft%prescribed_places(5, 0))
        allocate (draft%initial_places(0), draft%places(0))
        draft%problem%parameters = ''
    end subroutine new_draft

    !> Enter the name a command defines, as sound as the command. `number` is its place in the model's list,
    !> or 0 where the name is taken or none, which has been reported.
    pure subroutine define(self, space, command, diagnostics, number)
        class(draft_t), intent(inout) :: self
        integer, intent(in) :: space
        type(command_t), intent(in) :: command
        type(diagnostics_t), intent(inout) :: diagnostics
        integer, intent(out) :: number
        integer :: first

        number = 0
        if (.not. is_name(command%name, hyphens=.true.)) then
            self%names_lost(space) = .true.
            return
        end if
        first = self%names(space)%find(command%name)
        if (first == 0) then
            call self%names(space)%define(command%name, command%name_at, command%sound)
            number = self%names(space)%n
        else
            call report_twice(self, space, command%name, command%name_at, first, diagnostics)
        end if
    end subroutine define

    pure subroutine report_twice(self, space, name, at, first, diagnostics)
        type(draft_t), intent(in) :: self
        integer, intent(in) :: space, first
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        type(diagnostics_t), intent(inout) :: diagnostics
        type(span_t) :: before

        before = self%names(space)%span(first)
        if (before%first > 0) then
            call diagnostics%add(at, trim(space_names(space)) // ' ' // quoted(name) // ' is defined twice', &
                                 other=before, note='first defined here')
        else
            call diagnostics%add(at, trim(space_names(space)) // ' ' // quoted(name) // ' is built in')
        end if
    end subroutine report_twice

    !> Number of a name that is used at `at`: 0 where it is unknown (which is reported) or its definition was
    !> wrong.
    pure subroutine resolve(self, space, name, at, diagnostics, number)
        class(draft_t), intent(in) :: self
        integer, intent(in) :: space
        character(*), intent(in) :: name
        type(span_t), intent(in) :: at
        type(diagnostics_t), intent(inout) :: diagnostics
        integer, intent(out) :: number
        character(:), allocatable :: what
        integer :: later

        number = self%names(space)%find(name)
        if (number > 0) then
            if (.not. self%names(space)%is_sound(number)) number = 0
            return
        end if
        if (self%ghosts%find(name) > 0 .or. self%names_lost(space)) return
        what = trim(space_names(space)) // ' ' // quoted(name)
        later = self%later(space)%find(name)
        if (later > 0) then
            call diagnostics%add(at, what // ' is used before it is defined', &
                                 other=self%later(space)%span(later), note='defined here')
        else
            call diagnostics%add(at, 'unknown ' // what, &
                                 hint=suggestion(name, self%names(space)%known(), diagnostics))
        end if
    end subroutine resolve

    !> Remember a place that is checked when the mesh is known.
    pure subroutine add_place(self, at, x, at_node)
        class(draft_t), intent(inout) :: self
        type(span_t), intent(in) :: at
        real(wp), intent(in) :: x
        logical, intent(in) :: at_node

        self%n_places = self%n_places + 1
        call resize(self%places, self%n_places)
        self%places(self%n_places) = place_t(at, x, at_node)
    end subroutine add_place

    !> Cut the model's lists to their lengths: nothing more comes.
    pure subroutine close_lists(self)
        class(draft_t), intent(inout) :: self

        associate (model => self%problem%model)
            call resize(model%materials, self%names(space_material)%n, exact=.true.)
            call resize(model%sections, self%names(space_section)%n, exact=.true.)
            call resize(model%histories, self%names(space_history)%n, exact=.true.)
            call resize(model%lines, self%n_lines, exact=.true.)
            call resize(model%supports, self%n_supports, exact=.true.)
            call resize(model%prescribed, self%n_prescribed, exact=.true.)
            call resize(model%point_loads, self%n_points, exact=.true.)
            call resize(model%distributed_loads, self%n_distributed, exact=.true.)
            call resize(model%gravity, self%n_gravity, exact=.true.)
            call resize(model%initial, self%n_initial, exact=.true.)
        end associate
        call resize(self%problem%probes, self%names(space_probe)%n, exact=.true.)
    end subroutine close_lists

    !> New length of a list that has `now` places and must hold n: doubled when it is full, or exact.
    pure integer function new_length(now, n, exact)
        integer, intent(in) :: now, n
        logical, intent(in), optional :: exact

        new_length = now
        if (n > now) new_length = max(4, 2*now, n)
        if (present(exact)) new_length = n
    end function new_length

    pure subroutine resize_materials(list, n, exact)
        type(material_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(material_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_materials

    pure subroutine resize_sections(list, n, exact)
        type(section_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(section_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_sections

    pure subroutine resize_lines(list, n, exact)
        type(line_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(line_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_lines

    pure subroutine resize_line_places(list, n, exact)
        type(line_place_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(line_place_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_line_places

    pure subroutine resize_supports(list, n, exact)
        type(support_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(support_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_supports

    pure subroutine resize_prescribed(list, n, exact)
        type(prescribed_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(prescribed_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_prescribed

    pure subroutine resize_points(list, n, exact)
        type(point_load_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(point_load_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_points

    pure subroutine resize_distributed(list, n, exact)
        type(distributed_load_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(distributed_load_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_distributed

    pure subroutine resize_gravity(list, n, exact)
        type(gravity_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(gravity_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_gravity

    pure subroutine resize_initial(list, n, exact)
        type(initial_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(initial_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_initial

    pure subroutine resize_histories(list, n, exact)
        type(history_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(history_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_histories

    pure subroutine resize_probes(list, n, exact)
        type(probe_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(probe_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_probes

    pure subroutine resize_tasks(list, n, exact)
        type(task_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(task_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_tasks

    pure subroutine resize_places(list, n, exact)
        type(place_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(place_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_places

    pure subroutine resize_spans(list, n, exact)
        type(span_t), allocatable, intent(inout) :: list(:)
        integer, intent(in) :: n
        logical, intent(in), optional :: exact
        type(span_t), allocatable :: resized(:)
        integer :: i

        if (new_length(size(list), n, exact) == size(list)) return
        allocate (resized(new_length(size(list), n, exact)))
        do i = 1, min(size(list), size(resized))
            resized(i) = list(i)
        end do
        call move_alloc(resized, list)
    end subroutine resize_spans

end module gb_draft
