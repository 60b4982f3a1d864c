!> Cost of an element and Newton iteration where members of a sweep go side by side, one a lane:
!> bench_ensemble ELEMENTS STEPS REPEATS [JM]. The members are example 1 with loads that differ a little.
!> Prints the least of the repeats.
program bench_ensemble
    use gb_kinds, only: wp
    use gb_lanes, only: lanes
    use gb_model, only: model_t
    use gb_problem, only: task_t
    use gb_solver_choice, only: solver_auto
    use gb_system, only: system_t, build_system
    use gb_external, only: external_t, build_external
    use gb_ensemble, only: run_ensemble
    use gb_state, only: state_t
    use gb_threads, only: use_one_blas_thread
    use bench_models, only: counter_t, example_1, transient_of, seconds
    implicit none
    type(model_t) :: model
    type(system_t) :: systems(lanes)
    type(external_t) :: externals(lanes)
    type(state_t) :: states(lanes)
    type(task_t) :: task
    type(counter_t) :: counters(lanes)
    logical :: is_done(lanes)
    character(16) :: word
    real(wp) :: jm, time, least, work
    integer :: elements, steps, repeats, i, l

    call get_command_argument(1, word)
    read (word, *) elements
    call get_command_argument(2, word)
    read (word, *) steps
    call get_command_argument(3, word)
    read (word, *) repeats
    jm = 1.0e20_wp
    if (command_argument_count() > 3) then
        call get_command_argument(4, word)
        read (word, *) jm
    end if
    call use_one_blas_thread()
    task = transient_of(steps, solver_auto)
    do l = 1, lanes
        model = example_1(elements, jm, 3)
        model%distributed_loads(1)%q(2) = model%distributed_loads(1)%q(2)*(1.0_wp - 0.01_wp*real(l - 1, wp))
        systems(l) = build_system(model)
        externals(l) = build_external(model)
        allocate (states(l)%u(systems(l)%n), states(l)%v(systems(l)%n), states(l)%a(systems(l)%n))
    end do
    least = huge(least)
    do i = 1, repeats
        do l = 1, lanes
            states(l)%u = 0.0_wp
            states(l)%v = 0.0_wp
            states(l)%a = 0.0_wp
        end do
        counters = counter_t()
        time = seconds()
        is_done = .true.
        call run_ensemble(systems, externals, task, states, counters, is_done)
        least = min(least, seconds() - time)
    end do
    work = real(sum(counters%iterations), wp)*real(elements, wp)
    print '(a,i8,a,i3,a,i3,a,i7,a,f9.1,a,f9.1,a)', 'elements', elements, '  lanes', lanes, '  done', &
        count(is_done), '  iterations', sum(counters%iterations), '  ns an element and iteration', &
        1.0e9_wp*least/work, '  runs a second', real(lanes, wp)/least, ''
end program bench_ensemble
