!> A whole job: the model, what is asked about it (probes, output), and the solution commands in their order.
module gb_problem
    use gb_kinds, only: wp
    use gb_model, only: model_t
    use gb_solver_choice, only: solver_auto
    use gb_sweep, only: sweep_t
    use gb_tuning, only: tuning_t
    implicit none
    private

    integer, parameter, public :: task_static = 1, task_modal = 2, task_transient = 3

    !> How often a command writes a checkpoint, and where.
    type, public :: safeguard_t
        integer :: every = 0                        !! steps from one to the next; 0: does not count
        real(wp) :: seconds = 0.0_wp                !! wall time from one to the next [s]; 0: does not count
        character(:), allocatable :: file           !! path; not allocated: beside the results
    end type safeguard_t

    !> One solution command.
    type, public :: task_t
        integer :: kind = task_static
        character(:), allocatable :: name           !! group of its results
        character(:), allocatable :: scheme         !! transient: newmark, ...
        integer :: steps = 10                       !! static: load steps
        real(wp) :: load = 1.0_wp                   !! static: load factor reached [-]
        integer :: count = 6                        !! modal: number of modes
        real(wp) :: end_time = 0.0_wp               !! transient: duration [T]
        real(wp) :: step = 0.0_wp                   !! transient: time step [T]; 0 where `accuracy` rules
        real(wp) :: accuracy = 0.0_wp  !! transient: relative local error of adaptive steps; 0: fixed steps
        real(wp) :: beta = 0.25_wp, gamma = 0.5_wp  !! newmark [-]
        real(wp) :: alpha = -0.05_wp                !! hht [-]
        real(wp) :: rho = 0.8_wp  !! generalized, bathe: spectral radius at infinite frequency [-]
        real(wp) :: tolerance = 1.0e-10_wp          !! of a Newton iteration's increments, relative [-]
        integer :: iterations = 25                  !! Newton iterations a step at most
        integer :: cuts = 10                        !! halvings of a step at most
        integer :: solver = solver_auto             !! static, transient
        logical :: is_auto = .false.                !! steps (and the mesh) are the program's choice
        real(wp) :: aim = 0.0_wp                    !! auto: relative error aimed at [-]
        integer, allocatable :: aim_probes(:)       !! auto: of these probes
        type(safeguard_t) :: safeguard
    end type task_t

    integer, parameter, public :: quantity_displacement = 0, quantity_velocity = 1, quantity_acceleration = 2

    !> A field (or its time derivative) followed at a place.
    type, public :: probe_t
        character(:), allocatable :: name
        integer :: quantity = quantity_displacement
        integer :: field = 1
        real(wp) :: x = 0.0_wp                      !! [L]
    end type probe_t

    type, public :: output_t
        character(:), allocatable :: file           !! results file, without its ending .h5
        integer :: every = 1                        !! steps between two rows
        logical :: u = .true., v = .false., a = .false., strain = .false., stress = .false.
    end type output_t

    type, public :: problem_t
        type(model_t) :: model
        type(probe_t), allocatable :: probes(:)
        type(output_t) :: output
        type(task_t), allocatable :: tasks(:)
        type(sweep_t) :: sweep                      !! members of a study, if the deck has SWEEPs
        character(:), allocatable :: deck_text      !! as read
        character(:), allocatable :: deck_name      !! path of the deck, or what stands for it (<stdin>)
        character(:), allocatable :: parameters     !! "name=value" lines, after --set
        type(tuning_t), allocatable :: tuning       !! what `auto` has chosen, once it has
    contains
        procedure :: has_auto
    end type problem_t

contains

    !> Whether a command leaves its mesh and steps to the program.
    pure logical function has_auto(self)
        class(problem_t), intent(in) :: self

        has_auto = any(self%tasks%is_auto)
    end function has_auto

end module gb_problem
