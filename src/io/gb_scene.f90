!> Supports and loads of a model in words, one a line, with numbers in place of the deck's expressions: for
!> who draws the scene from a results file. "distributed from=0 to=10 q3=2.85 history=step stage=all".
module gb_scene
    use gb_kinds, only: wp
    use gb_text, only: exact_text, newline
    use gb_fields, only: field_names, n_fields
    use gb_model, only: model_t
    implicit none
    private

    character(2), parameter, public :: point_names(4) = ['f1', 'f3', 'm1', 'm3']
    character(2), parameter, public :: distributed_names(2) = ['q1', 'q3']
    character(2), parameter, public :: gravity_names(2) = ['g1', 'g3']
    character(9), parameter :: stage_names(3) = [character(9) :: 'all', 'static', 'transient']

    public :: scene_lines

contains

    pure function scene_lines(model) result(text)
        type(model_t), intent(in) :: model
        character(:), allocatable :: text
        integer :: i, field

        text = ''
        do i = 1, size(model%supports)
            text = text // 'support x=' // exact_text(model%supports(i)%x)
            do field = 1, n_fields
                if (model%supports(i)%fixed(field)) text = text // ' ' // field_names(field)
            end do
            text = text // newline
        end do
        do i = 1, size(model%prescribed)
            associate (driven => model%prescribed(i))
                text = text // 'prescribed x=' // exact_text(driven%x) // pairs(field_names, driven%value, &
                    driven%driven) // ' history=' // model%histories(driven%history)%name // newline
            end associate
        end do
        do i = 1, size(model%point_loads)
            associate (load => model%point_loads(i))
                text = text // 'point x=' // exact_text(load%x) // pairs(point_names, load%value, &
                    abs(load%value) > 0.0_wp) // acting(load%history, load%stage)
            end associate
        end do
        do i = 1, size(model%distributed_loads)
            associate (load => model%distributed_loads(i))
                text = text // 'distributed from=' // exact_text(load%from) // ' to=' // exact_text(load%to) &
                    // pairs(distributed_names, load%q, abs(load%q) > 0.0_wp) // acting(load%history, &
                    load%stage)
            end associate
        end do
        do i = 1, size(model%gravity)
            associate (load => model%gravity(i))
                text = text // 'gravity' // pairs(gravity_names, load%g, abs(load%g) > 0.0_wp) &
                    // acting(load%history, load%stage)
            end associate
        end do

    contains

        pure function acting(history, stage) result(words)
            integer, intent(in) :: history, stage
            character(:), allocatable :: words

            words = ' history=' // model%histories(history)%name // ' stage=' &
                // trim(stage_names(stage)) // newline
        end function acting

    end function scene_lines

    !> " u1=0 u3=-2" of the values that are given.
    pure function pairs(names, values, given) result(text)
        character(2), intent(in) :: names(:)
        real(wp), intent(in) :: values(:)
        logical, intent(in) :: given(:)
        character(:), allocatable :: text
        integer :: i

        text = ''
        do i = 1, size(names)
            if (given(i)) text = text // ' ' // names(i) // '=' // exact_text(values(i))
        end do
    end function pairs

end module gb_scene
