!> The scene a deck describes: materials, sections, lines, supports, loads. Nothing in it changes while it is
!> solved.
module gb_model
    use gb_section, only: material_t, section_t, rule_linear
    use gb_mesh, only: line_t, mesh_t
    use gb_history, only: history_t
    use gb_load, only: support_t, prescribed_t, point_load_t, distributed_load_t, gravity_t, initial_t, &
        damping_t
    implicit none
    private

    !> Labels of the units, for results and plots only.
    type, public :: units_t
        character(:), allocatable :: length, force, time
    end type units_t

    type, public :: model_t
        character(:), allocatable :: title
        type(units_t) :: units
        type(material_t), allocatable :: materials(:)
        type(section_t), allocatable :: sections(:)
        type(line_t), allocatable :: lines(:)
        type(mesh_t) :: mesh                                !! of the lines
        logical :: points_are_chosen = .false.              !! those through the thickness, by the program
        type(support_t), allocatable :: supports(:)
        type(prescribed_t), allocatable :: prescribed(:)
        type(history_t), allocatable :: histories(:)        !! the first is the built-in `step`
        type(point_load_t), allocatable :: point_loads(:)
        type(distributed_load_t), allocatable :: distributed_loads(:)
        type(gravity_t), allocatable :: gravity(:)
        type(initial_t), allocatable :: initial(:)
        type(damping_t) :: damping
    contains
        procedure :: fixed_fields
        procedure :: has_no_potential
        procedure :: has_potential_somewhere
    end type model_t

contains

    !> Which fields are held or driven at each node (5, nn).
    pure function fixed_fields(self) result(fixed)
        class(model_t), intent(in) :: self
        logical, allocatable :: fixed(:, :)
        integer :: i, node

        allocate (fixed(5, self%mesh%n_nodes()))
        fixed = .false.
        do i = 1, size(self%supports)
            node = self%mesh%node_at(self%supports(i)%x)
            fixed(:, node) = fixed(:, node) .or. self%supports(i)%fixed
        end do
        do i = 1, size(self%prescribed)
            node = self%mesh%node_at(self%prescribed(i)%x)
            fixed(:, node) = fixed(:, node) .or. self%prescribed(i)%driven
        end do
    end function fixed_fields

    !> Whether some element's internal force is not the gradient of an energy (rule `linear`): its tangent is
    !> unsymmetric.
    pure logical function has_no_potential(self)
        class(model_t), intent(in) :: self

        has_no_potential = any(self%sections(self%mesh%section)%rule == rule_linear)
    end function has_no_potential

    !> Whether some element's internal force is the gradient of an energy.
    pure logical function has_potential_somewhere(self)
        class(model_t), intent(in) :: self

        has_potential_somewhere = any(self%sections(self%mesh%section)%rule /= rule_linear)
    end function has_potential_somewhere

end module gb_model
