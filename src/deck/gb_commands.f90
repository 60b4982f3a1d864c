!> The keyword table: every command the deck knows, with its words and keys, as data. A new key is one line
!> here; parser, `--keywords` and docs/deck.md follow.
module gb_commands
    use gb_kinds, only: wp
    use gb_schema, only: schema_t, form_t, key_t, range_t, kind_real, kind_integer, kind_reals, &
        kind_text, kind_choice, kind_choices, kind_name, kind_names, kind_formula, part_solution, part_any, &
        above, at_least, between, inside, nonzero
    implicit none
    private

    public :: command_table

    character(*), parameter :: required = '*'       !! in place of a default
    character(*), parameter :: one_of = '+'         !! at least one of these must be given
    character(*), parameter :: fields = 'u1 u3 y1 y3 xi'

contains

    pure function command_table() result(table)
        type(schema_t) :: table

        call add_heading(table)
        call add_materials(table)
        call add_geometry(table)
        call add_supports(table)
        call add_loads(table)
        call add_histories(table)
        call add_start(table)
        call add_output(table)
        call add_solutions(table)
        call add_transients(table)
        call add_closing(table)
    end function command_table

    pure subroutine add_heading(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='GENTBEAM', &
            description='Title: the rest of the line. Opens every deck.'))
        call table%add_form(form_t(command='UNITS', once=.true., &
            description='Labels of the units, for results and plots; any consistent set.'))
        call text(table, 'length', '', 'label of lengths')
        call text(table, 'force', '', 'label of forces')
        call text(table, 'time', '', 'label of times')
        call table%add_form(form_t(command='PARAMETER', open=.true., &
            description='Named numbers, name=expression, for the expressions that follow.'))
    end subroutine add_heading

    pure subroutine add_materials(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='MATERIAL', variant='gent', named=.true., &
                                   description='Gent hyperelastic material.'))
        call real_number(table, 'mu', required, above(0.0_wp), 'shear modulus [force/length^2]')
        call real_number(table, 'c', required, at_least(0.0_wp), 'volumetric modulus [force/length^2]')
        call real_number(table, 'beta', '-2', nonzero(100.0_wp), 'exponent of the volumetric energy')
        call real_number(table, 'jm', required, above(0.0_wp, limit=huge(1.0_wp)), &
            'limit of I1-2: how far chains can stretch')
        call add_density(table)
        call table%add_form(form_t(command='MATERIAL', variant='neohookean', named=.true., &
                                   description='Compressible neo-Hookean material: gent with jm = infinity.'))
        call real_number(table, 'mu', required, above(0.0_wp), 'shear modulus [force/length^2]')
        call real_number(table, 'c', required, at_least(0.0_wp), 'volumetric modulus [force/length^2]')
        call real_number(table, 'beta', '-2', nonzero(100.0_wp), 'exponent of the volumetric energy')
        call add_density(table)
        call table%add_form(form_t(command='MATERIAL', variant='elastic', named=.true., description= &
            'gent from the small-strain constants: mu=e/(2(1+nu)), c=e nu/(1-nu^2)-2 mu/jm.'))
        call real_number(table, 'e', required, above(0.0_wp), &
            "Young's modulus at small strain [force/length^2]")
        call real_number(table, 'nu', required, inside(-1.0_wp, 0.5_wp), &
            "Poisson's ratio at small strain; where it makes c <= 0 use gent")
        call real_number(table, 'beta', '-2', nonzero(100.0_wp), 'exponent of the volumetric energy')
        call real_number(table, 'jm', 'infinity', above(0.0_wp, limit=huge(1.0_wp)), &
            'limit of I1-2: how far chains can stretch')
        call add_density(table)
    end subroutine add_materials

    pure subroutine add_density(table)
        type(schema_t), intent(inout) :: table

        call real_number(table, 'rho', required, above(0.0_wp), 'mass density [force time^2/length^4]')
    end subroutine add_density

    pure subroutine add_geometry(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='SECTION', variant='rectangle', named=.true., &
            description='Rectangular cross-section, and how its thickness is integrated.'))
        call real_number(table, 'b', required, above(0.0_wp), 'width [length]')
        call real_number(table, 'h', required, above(0.0_wp), 'thickness [length]')
        call choice(table, 'rule', 'gauss', 'gauss linear auto', &
                    'thickness rule: Gauss points, linear resultants, or Gauss points chosen by the program')
        call whole_number(table, 'points', '3', between(1.0_wp, 10.0_wp), &
                          'Gauss points through the thickness (rule=gauss)')
        call real_number(table, 'tolerance', '1e-3', inside(0.0_wp, 1.0_wp), 'error aimed at (rule=auto)')
        call choice(table, 'inertia', 'diagonal', 'full diagonal translational', &
                    'terms of the kinetic energy that are kept')
        call table%add_form(form_t(command='LINE', description= &
                                   'A stretch of beam along X1, cut into elements. LINEs join end to end.'))
        call real_number(table, 'from', required, range_t(), 'left end [length]')
        call real_number(table, 'to', required, range_t(), 'right end [length]')
        call whole_number(table, 'elements', required, between(1.0_wp, 1.0e7_wp), 'number of elements')
        call whole_number(table, 'nodes', '3', between(2.0_wp, 5.0_wp), 'nodes of an element')
        call choice(table, 'integration', 'reduced', 'reduced full', &
                    'Gauss points along an element: one fewer than nodes, or as many')
        call reference(table, 'material', 'the only one', 'name of a MATERIAL')
        call reference(table, 'section', 'the only one', 'name of a SECTION')
        call real_number(table, 'grading', '1', above(0.0_wp), &
                         "length of the last element over that of the first")
    end subroutine add_geometry

    pure subroutine add_supports(table)
        type(schema_t), intent(inout) :: table

        call add_support(table, 'CLAMP', 'Fixes u1 u3 y1 y3 xi at a node.')
        call add_support(table, 'PIN', 'Fixes u1 u3 at a node.')
        call add_support(table, 'ROLLER', 'Fixes u3 at a node.')
        call add_support(table, 'SLIDE', 'Fixes u1 y1 y3 at a node.')
        call table%add_form(form_t(command='FIX', words=fields, most_words=5, &
                                   description='Fixes the fields named at a node.'))
        call add_place(table)
        call table%add_form(form_t(command='PRESCRIBE', &
                                   description='Drives fields at a node: value times history.'))
        call add_place(table)
        call real_number(table, 'u1', one_of, range_t(), 'displacement along X1 [length]')
        call real_number(table, 'u3', one_of, range_t(), 'displacement along X3 [length]')
        call real_number(table, 'y1', one_of, range_t(), 'director difference, component 1')
        call real_number(table, 'y3', one_of, range_t(), 'director difference, component 3')
        call real_number(table, 'xi', one_of, range_t(), 'quadratic thickness stretch [1/length]')
        call add_history(table)
    end subroutine add_supports

    pure subroutine add_support(table, command, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: command, description

        call table%add_form(form_t(command=command, description=description))
        call add_place(table)
    end subroutine add_support

    pure subroutine add_place(table)
        type(schema_t), intent(inout) :: table

        call real_number(table, 'x', required, range_t(), 'place: a node [length]')
    end subroutine add_place

    pure subroutine add_history(table)
        type(schema_t), intent(inout) :: table

        call reference(table, 'history', 'step', 'name of a HISTORY')
    end subroutine add_history

    pure subroutine add_stage(table)
        type(schema_t), intent(inout) :: table

        call add_history(table)
        call choice(table, 'stage', 'all', 'static transient all', 'the solution commands it acts in')
    end subroutine add_stage

    pure subroutine add_loads(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='POINT', description='Dead forces and couples at a node.'))
        call add_place(table)
        call real_number(table, 'f1', one_of, range_t(), 'force along X1 [force]')
        call real_number(table, 'f3', one_of, range_t(), 'force along X3 [force]')
        call real_number(table, 'm1', one_of, range_t(), 'couple on y1 [force length]')
        call real_number(table, 'm3', one_of, range_t(), 'couple on y3 [force length]')
        call add_stage(table)
        call table%add_form(form_t(command='DISTRIBUTED', &
                                   description='Dead load along a stretch that may start and end anywhere.'))
        call real_number(table, 'from', required, range_t(), 'where it starts [length]')
        call real_number(table, 'to', required, range_t(), 'where it ends [length]')
        call real_number(table, 'q1', one_of, range_t(), 'load along X1 [force/length]')
        call real_number(table, 'q3', one_of, range_t(), 'load along X3 [force/length]')
        call add_stage(table)
        call table%add_form(form_t(command='GRAVITY', description='Acceleration that acts on all mass.'))
        call real_number(table, 'g1', one_of, range_t(), 'along X1 [length/time^2]')
        call real_number(table, 'g3', one_of, range_t(), 'along X3 [length/time^2]')
        call add_stage(table)
    end subroutine add_loads

    pure subroutine add_histories(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='HISTORY', variant='step', named=.true., &
                                   description='Factor 0 before the start, 1 from then on.'))
        call real_number(table, 'start', '0', range_t(), 'first instant at 1 [time]')
        call table%add_form(form_t(command='HISTORY', variant='ramp', named=.true., &
                                   description='Linear from 0 to 1, then 1.'))
        call real_number(table, 'rise', required, above(0.0_wp), 'time from 0 to 1 [time]')
        call real_number(table, 'start', '0', range_t(), 'where the rise starts [time]')
        call table%add_form(form_t(command='HISTORY', variant='pulse', named=.true., &
                                   description='1 from start to stop, else 0.'))
        call real_number(table, 'start', '0', range_t(), 'first instant at 1 [time]')
        call real_number(table, 'stop', required, range_t(), 'last instant at 1 [time]')
        call table%add_form(form_t(command='HISTORY', variant='sine', named=.true., &
                                   description='sin(2 pi frequency t + phase).'))
        call real_number(table, 'frequency', required, above(0.0_wp), 'cycles per time [1/time]')
        call real_number(table, 'phase', '0', range_t(), 'phase at t = 0 [rad]')
        call table%add_form(form_t(command='HISTORY', variant='table', named=.true., &
            description='Linear between given points, held outside: t= and f=, or file=.'))
        call reals(table, 't', 'increasing times [time]')
        call reals(table, 'f', 'factors at these times')
        call text(table, 'file', '', 'text file of two columns, t and f')
        call table%add_form(form_t(command='HISTORY', variant='formula', named=.true., &
                                   description='Any function of time.'))
        call formula(table, 'f', 't', required, 'factor, an expression of t')
    end subroutine add_histories

    pure subroutine add_start(table)
        type(schema_t), intent(inout) :: table

        call add_initial(table, 'displacement', 'Displacements at the start, as functions of x.', '[length]')
        call add_initial(table, 'velocity', 'Velocities at the start, as functions of x.', '[length/time]')
        call table%add_form(form_t(command='DAMPING', once=.true., &
                                   description='Rayleigh damping, C = mass M + stiffness K(initial).'))
        call real_number(table, 'mass', '0', at_least(0.0_wp), 'factor of the mass [1/time]')
        call real_number(table, 'stiffness', '0', at_least(0.0_wp), 'factor of the initial stiffness [time]')
    end subroutine add_start

    pure subroutine add_initial(table, variant, description, unit)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: variant, description, unit

        call table%add_form(form_t(command='INITIAL', variant=variant, &
            description=description))
        call formula(table, 'u1', 'x', one_of, 'of u1 ' // unit)
        call formula(table, 'u3', 'x', one_of, 'of u3 ' // unit)
        call formula(table, 'y1', 'x', one_of, 'of y1')
        call formula(table, 'y3', 'x', one_of, 'of y3')
        call formula(table, 'xi', 'x', one_of, 'of xi')
    end subroutine add_initial

    pure subroutine add_output(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='PROBE', named=.true., words=fields // ' v1 v3 a1 a3', &
            most_words=1, description='A value to follow: a field, or velocity v or acceleration a.'))
        call real_number(table, 'x', required, range_t(), 'place: anywhere on the beam [length]')
        call table%add_form(form_t(command='OUTPUT', once=.true., &
            description='What goes to the results file.'))
        call text(table, 'file', "the deck's name", 'results file, without its ending .h5')
        call whole_number(table, 'every', '1', between(1.0_wp, 1.0e9_wp), 'steps from one row to the next')
        call table%add_key(key_t(name='fields', kind=kind_choices, default='u', &
            choices='u v a strain stress none', description='histories of the whole beam that are kept'))
        call table%add_form(form_t(command='SWEEP', open=.true., description= &
            'Runs the deck for every value of a parameter, parameter=[list]; several SWEEPs cross.'))
        call text(table, 'file', '', 'table with a header line of parameter names')
        call table%add_form(form_t(command='END', part=part_any, once=.true., &
            description='Closes the model.'))
    end subroutine add_output

    pure subroutine add_solutions(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='STATIC', part=part_solution, &
                                   description='Equilibrium, the loads raised in steps to the factor load.'))
        call whole_number(table, 'steps', '10', between(1.0_wp, 1.0e6_wp), 'load steps')
        call real_number(table, 'load', '1', range_t(), 'load factor reached')
        call add_newton(table, 'static')
        call table%add_form(form_t(command='STATIC', variant='auto', part=part_solution, &
                                   description='Static, with mesh and rules chosen by the program.'))
        call add_accuracy(table)
        call real_number(table, 'load', '1', range_t(), 'load factor reached')
        call reference(table, 'name', 'static', 'name of its results')
        call table%add_form(form_t(command='MODAL', part=part_solution, &
                                   description='Natural frequencies and modes about the current state.'))
        call whole_number(table, 'count', '6', between(1.0_wp, 1.0e4_wp), 'number of modes')
        call reference(table, 'name', 'modal', 'name of its results')
    end subroutine add_solutions

    pure subroutine add_accuracy(table)
        type(schema_t), intent(inout) :: table

        call real_number(table, 'accuracy', required, inside(0.0_wp, 1.0_wp), 'relative error aimed at')
        call table%add_key(key_t(name='probe', kind=kind_names, required=.true., &
                                 description='the PROBE or [list] of them that must be so accurate'))
    end subroutine add_accuracy

    pure subroutine add_newton(table, name)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name

        call choice(table, 'solver', 'chosen by itself', 'lapack block', 'linear solver')
        call real_number(table, 'tolerance', '1e-10', between(1.0e-15_wp, 0.1_wp), &
                         "relative size of Newton's last increment")
        call whole_number(table, 'iterations', '25', between(1.0_wp, 1000.0_wp), &
            'Newton iterations a step at most')
        call whole_number(table, 'cuts', '10', between(0.0_wp, 40.0_wp), 'halvings of a step at most')
        call reference(table, 'name', name, 'name of its results')
    end subroutine add_newton

    pure subroutine add_transients(table)
        type(schema_t), intent(inout) :: table

        call open_transient(table, 'newmark', "Newmark's scheme.")
        call real_number(table, 'beta', '0.25', between(0.0_wp, 1.0_wp, low_open=.true.), &
            'of the displacements')
        call real_number(table, 'gamma', '0.5', between(0.0_wp, 1.0_wp), 'of the velocities')
        call add_steps(table)
        call open_transient(table, 'hht', 'Hilber, Hughes and Taylor.')
        call real_number(table, 'alpha', '-0.05', between(-1.0_wp/3.0_wp, 0.0_wp), &
            'damping, from -1/3 to 0 (none)')
        call add_steps(table)
        call open_transient(table, 'generalized', 'Generalized alpha (Chung and Hulbert).')
        call real_number(table, 'rho', '0.8', between(0.0_wp, 1.0_wp), &
            'spectral radius at infinite frequency')
        call add_steps(table)
        call open_transient(table, 'bathe', 'Two sub-steps: trapezoidal, then backward.')
        call real_number(table, 'rho', '0', between(0.0_wp, 1.0_wp), 'spectral radius at infinite frequency')
        call add_steps(table)
        call open_transient(table, 'energy', 'Conserves energy and momentum.')
        call add_steps(table)
        call open_transient(table, 'central', 'Explicit central difference.')
        call add_steps(table)
        call open_transient(table, 'auto', 'Mesh, rules, scheme and step chosen by the program.')
        call add_accuracy(table)
        call real_number(table, 'end', required, above(0.0_wp), 'time from the start of this command [time]')
        call reference(table, 'name', 'transient', 'name of its results')
    end subroutine add_transients

    pure subroutine open_transient(table, scheme, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: scheme, description

        call table%add_form(form_t(command='TRANSIENT', variant=scheme, part=part_solution, &
            description='Motion in time. ' // description))
    end subroutine open_transient

    pure subroutine add_steps(table)
        type(schema_t), intent(inout) :: table

        call real_number(table, 'end', required, above(0.0_wp), 'time from the start of this command [time]')
        call real_number(table, 'step', one_of, above(0.0_wp), 'time step [time]')
        call table%add_key(key_t(name='accuracy', one_of=.true., range=inside(0.0_wp, 1.0_wp), &
            description='relative local error of adaptive steps'))
        call add_newton(table, 'transient')
    end subroutine add_steps

    pure subroutine add_closing(table)
        type(schema_t), intent(inout) :: table

        call table%add_form(form_t(command='CHECKPOINT', part=part_solution, description= &
            'Writes checkpoints while the commands that follow run; --restart goes on from the last one.'))
        call table%add_key(key_t(name='every', kind=kind_integer, one_of=.true., range=between(1.0_wp, &
            1.0e9_wp), description='steps from one to the next'))
        call real_number(table, 'seconds', one_of, above(0.0_wp), 'wall time from one to the next [s]')
        call text(table, 'file', 'results name .chk.h5', 'checkpoint file')
        call table%add_form(form_t(command='STOP', part=part_any, &
                                   description='Ends the deck; what follows is ignored.'))
    end subroutine add_closing

    pure subroutine real_number(table, name, default, range, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name, default, description
        type(range_t), intent(in) :: range

        call table%add_key(with_default(key_t(name=name, kind=kind_real, range=range, &
            description=description), default))
    end subroutine real_number

    pure subroutine whole_number(table, name, default, range, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name, default, description
        type(range_t), intent(in) :: range

        call table%add_key(with_default(key_t(name=name, kind=kind_integer, range=range, &
            description=description), default))
    end subroutine whole_number

    pure subroutine reals(table, name, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name, description

        call table%add_key(key_t(name=name, kind=kind_reals, description=description))
    end subroutine reals

    pure subroutine text(table, name, default, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name, default, description

        call table%add_key(key_t(name=name, kind=kind_text, default=default, description=description))
    end subroutine text

    pure subroutine choice(table, name, default, choices, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name, default, choices, description
        call table%add_key(key_t(name=name, kind=kind_choice, default=default, choices=choices, &
            description=description))
    end subroutine choice

    pure subroutine reference(table, name, default, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name, default, description

        call table%add_key(key_t(name=name, kind=kind_name, default=default, description=description))
    end subroutine reference

    pure subroutine formula(table, name, variable, default, description)
        type(schema_t), intent(inout) :: table
        character(*), intent(in) :: name, variable, default, description

        call table%add_key(with_default(key_t(name=name, kind=kind_formula, variable=variable, &
                                              description=description), default))
    end subroutine formula

    pure type(key_t) function with_default(key, default) result(full)
        type(key_t), intent(in) :: key
        character(*), intent(in) :: default

        full = key
        select case (default)
        case (required)
            full%required = .true.
        case (one_of)
            full%one_of = .true.
        case default
            full%default = default
        end select
    end function with_default

end module gb_commands
