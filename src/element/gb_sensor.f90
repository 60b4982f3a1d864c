!> Where a probe stands on the mesh, what it reads from a state, and the largest and smallest it has read.
module gb_sensor
    use gb_kinds, only: wp
    use gb_fields, only: dof_index
    use gb_mesh, only: mesh_t, max_element_nodes
    use gb_problem, only: probe_t, quantity_displacement, quantity_velocity
    use gb_state, only: state_t
    use gb_shape, only: lagrange
    implicit none
    private

    !> The unknowns a probe depends on and their weights.
    type, public :: sensor_t
        integer :: quantity = quantity_displacement
        integer :: nodes = 0
        integer :: unknown(max_element_nodes) = 0
        real(wp) :: weight(max_element_nodes) = 0.0_wp
    contains
        procedure :: reading
    end type sensor_t

    public :: place_sensor

contains

    !> Interpolate a probe in the element that holds it.
    pure function place_sensor(mesh, probe) result(sensor)
        type(mesh_t), intent(in) :: mesh
        type(probe_t), intent(in) :: probe
        type(sensor_t) :: sensor
        real(wp) :: slopes(max_element_nodes), s
        integer :: e, i

        e = mesh%element_at(probe%x)
        sensor%quantity = probe%quantity
        sensor%nodes = mesh%nodes(e)
        s = 2.0_wp*(probe%x - mesh%x(mesh%first_node(e)))/mesh%element_length(e) - 1.0_wp
        call lagrange(min(1.0_wp, max(-1.0_wp, s)), sensor%weight(:sensor%nodes), slopes(:sensor%nodes))
        sensor%unknown(:sensor%nodes) = [(dof_index(probe%field, mesh%first_node(e) + i - 1), i=1, &
            sensor%nodes)]
    end function place_sensor

    pure real(wp) function reading(self, state)
        class(sensor_t), intent(in) :: self
        type(state_t), intent(in) :: state

        associate (unknown => self%unknown(:self%nodes), weight => self%weight(:self%nodes))
            select case (self%quantity)
            case (quantity_displacement)
                reading = dot_product(weight, state%u(unknown))
            case (quantity_velocity)
                reading = dot_product(weight, state%v(unknown))
            case default
                reading = dot_product(weight, state%a(unknown))
            end select
        end associate
    end function reading

end module gb_sensor
