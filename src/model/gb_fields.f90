!> The five fields of the beam's kinematics (eq. 1-8) and how degrees of freedom are numbered.
module gb_fields
    implicit none
    private

    integer, parameter, public :: n_fields = 5
    integer, parameter, public :: field_u1 = 1   !! displacement of the mid-line along X1 [L]
    integer, parameter, public :: field_u3 = 2   !! displacement of the mid-line along X3 [L]
    integer, parameter, public :: field_y1 = 3   !! difference of the director, component 1 [-]
    integer, parameter, public :: field_y3 = 4   !! difference of the director, component 3 [-]
    integer, parameter, public :: field_xi = 5   !! quadratic thickness stretch [1/L]

    character(2), parameter, public :: field_names(n_fields) = ['u1', 'u3', 'y1', 'y3', 'xi']
    !> Power of length in each field's unit.
    integer, parameter, public :: field_length_power(n_fields) = [1, 1, 0, 0, -1]

    public :: dof_index

contains

    !> Number of the degree of freedom of `field` at `node` (both 1-based): node by node, five fields each.
    pure integer function dof_index(field, node) result(dof)
        integer, intent(in) :: field, node

        dof = n_fields*(node - 1) + field
    end function dof_index

end module gb_fields
