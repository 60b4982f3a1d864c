!> Which models the block solver can do: a chain of three-node elements. All others are LAPACK's.
module gb_solver_choice
    use gb_kinds, only: wp
    use gb_text, only: to_text
    use gb_fields, only: n_fields
    use gb_section, only: rule_gauss
    use gb_model, only: model_t
    implicit none
    private

    !> `solver=` of STATIC and TRANSIENT.
    integer, parameter, public :: solver_auto = 0, solver_lapack = 1, solver_block = 2

    public :: block_obstacle

contains

    !> Why the block solver cannot do this model, padded with blanks; empty where it can. (Its length is
    !> known: see gb_text on threads.)
    pure function block_obstacle(model) result(reason)
        type(model_t), intent(in) :: model
        character(100) :: reason
        logical :: fixed(n_fields, model%mesh%n_nodes())
        integer :: i

        reason = ''
        associate (mesh => model%mesh)
            if (any(mesh%nodes /= 3)) then
                reason = 'an element has ' // to_text(mesh%nodes(findloc(mesh%nodes /= 3, .true., 1))) &
                         // ' nodes, not 3'
            else if (any(mesh%full_integration)) then
                reason = 'an element has full integration'
            else if (any(model%sections(mesh%section)%rule /= rule_gauss)) then
                reason = 'a section has another rule than gauss'
            else if (any(model%sections(mesh%section)%points /= model%sections(mesh%section(1))%points)) then
                reason = 'sections differ in points='
            else if (model%damping%stiffness > 0.0_wp) then
                reason = 'there is DAMPING stiffness='
            end if
            if (reason /= '') return
            fixed = model%fixed_fields()
            do i = 2, mesh%n_nodes(), 2
                if (any(fixed(:, i))) reason = 'the support at x = ' // to_text(mesh%x(i)) &
                    // ' holds the middle node of an element'
            end do
        end associate
    end function block_obstacle

end module gb_solver_choice
