!> How much memory a run will take: measured (tests/reliability/test_memory.py holds it to that), not counted.
module gb_needs
    use gb_kinds, only: i8, wp
    use gb_problem, only: problem_t, task_modal
    use gb_section, only: inertia_full
    use gb_solver_choice, only: solver_lapack, block_obstacle
    implicit none
    private

    public :: memory_needed

    !> Bytes a node: a part of its own, and for every node of an element its place in the band of the
    !> equations. Some methods keep a general matrix beside the symmetric one; the explicit scheme and the
    !> block solver have no band.
    integer(i8), parameter :: explicit_own = 1200_i8, block_own = 1650_i8
    !> Beside the block solver: the mass at the start, where inertia is full, and the damping.
    integer(i8), parameter :: full_band = 650_i8, damping_band = 800_i8
    integer(i8), parameter :: symmetric_own = 1400_i8, symmetric_band = 650_i8
    integer(i8), parameter :: general_own = 2300_i8, general_band = 1000_i8
    integer(i8), parameter :: picture_bytes = 150_i8        !! the motion for ParaView
    integer(i8), parameter :: strain_bytes = 300_i8, stress_bytes = 300_i8  !! where they are kept
    integer(i8), parameter :: mode_bytes = 160_i8          !! of every natural mode that is looked for
    integer(i8), parameter :: program_bytes = 16000000_i8  !! without any model

contains

    !> Bytes that the commands of a problem need at most, about.
    pure integer(i8) function memory_needed(problem) result(bytes)
        type(problem_t), intent(in) :: problem
        integer(i8) :: a_node, most
        integer :: i, width

        most = 0
        width = maxval(problem%model%mesh%nodes)
        do i = 1, size(problem%tasks)
            a_node = symmetric_own + symmetric_band*width
            if (is_explicit(problem, i)) then
                a_node = explicit_own
            else if (has_block(problem, i)) then
                a_node = block_own + bands_beside_block(problem)
            else if (problem%tasks(i)%kind == task_modal) then
                a_node = general_own + general_band*width + mode_bytes*problem%tasks(i)%count
            else if (is_general(problem, i)) then
                a_node = general_own + general_band*width
            end if
            most = max(most, a_node)
        end do
        if (problem%output%u) most = most + picture_bytes
        if (problem%output%strain) most = most + strain_bytes
        if (problem%output%stress) most = most + stress_bytes
        bytes = program_bytes + most*problem%model%mesh%n_nodes()
    end function memory_needed

    !> Bytes a node for matrices that the block solver itself has no use for.
    pure integer(i8) function bands_beside_block(problem) result(bytes)
        type(problem_t), intent(in) :: problem

        bytes = 0
        if (any(problem%model%sections%inertia == inertia_full)) bytes = bytes + full_band
        if (problem%model%damping%mass > 0.0_wp) bytes = bytes + damping_band
    end function bands_beside_block

    pure logical function is_explicit(problem, number)
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number

        is_explicit = .false.
        if (allocated(problem%tasks(number)%scheme)) is_explicit = problem%tasks(number)%scheme == 'central'
    end function is_explicit

    !> Whether the block solver does a command. (Where it fails, LAPACK's takes its memory then.)
    pure logical function has_block(problem, number)
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number

        has_block = .false.
        if (problem%tasks(number)%kind == task_modal .or. is_general(problem, number)) return
        if (problem%tasks(number)%solver == solver_lapack) return
        has_block = block_obstacle(problem%model) == ''
    end function has_block

    !> Whether a command's tangent is not symmetric.
    pure logical function is_general(problem, number)
        type(problem_t), intent(in) :: problem
        integer, intent(in) :: number

        is_general = .false.
        if (allocated(problem%tasks(number)%scheme)) is_general = problem%tasks(number)%scheme == 'energy'
    end function is_general

end module gb_needs
