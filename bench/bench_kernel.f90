!> Cost of an element and Newton iteration, for one beam of n elements: bench_kernel SOLVER ELEMENTS STEPS
!> REPEATS [JM]. Prints the least of the repeats.
program bench_kernel
    use gb_kinds, only: wp
    use gb_model, only: model_t
    use gb_problem, only: task_t
    use gb_solver_choice, only: solver_lapack, solver_block
    use gb_system, only: system_t, build_system
    use gb_external, only: external_t, build_external
    use gb_threads, only: use_one_blas_thread
    use bench_models, only: counter_t, example_1, transient_of, run_counted
    implicit none
    type(model_t) :: model
    type(system_t) :: system
    type(external_t) :: external
    type(task_t) :: task
    type(counter_t) :: counter
    character(16) :: word
    real(wp) :: jm, time, least
    integer :: elements, steps, repeats, solver, i

    call get_command_argument(1, word)
    solver = merge(solver_block, solver_lapack, word == 'block')
    call get_command_argument(2, word)
    read (word, *) elements
    call get_command_argument(3, word)
    read (word, *) steps
    call get_command_argument(4, word)
    read (word, *) repeats
    call use_one_blas_thread()
    jm = 1.0e20_wp
    if (command_argument_count() > 4) then
        call get_command_argument(5, word)
        read (word, *) jm
    end if
    model = example_1(elements, jm, 3)
    system = build_system(model)
    external = build_external(model)
    task = transient_of(steps, solver)
    least = huge(least)
    do i = 1, repeats
        call run_counted(system, external, model, task, counter, time)
        least = min(least, time)
    end do
    print '(a,i8,a,i7,a,i5,a,f10.4,a,f9.1,a)', 'elements', elements, '  iterations', counter%iterations, &
        '  cuts', &
        counter%cuts, '  ms', 1.0e3_wp*least, '  ns an element and iteration', &
        1.0e9_wp*least/real(counter%iterations, wp)/real(elements, wp), ''
end program bench_kernel
