!> The error of a setting that has not been tried, put together from its sources. They are courses in time,
!> and may add up or undo each other: a coarse mesh is too stiff, a long step too slow. Their shapes are those
!> of the changes that trials have shown, their sizes come from gb_convergence.
module gb_forecast
    use gb_kinds, only: wp
    use gb_course, only: likeness
    use gb_ladder, only: ladder_t
    use gb_tuning, only: n_sources
    implicit none
    private

    type, public :: forecast_t
        !> Of each channel (probe of a command): how much of a source's error it has, 1 for the one that has
        !> most (sources, channels), and how alike the sources' errors are (sources, sources, channels).
        real(wp), allocatable :: share(:, :), likeness(:, :, :)
    contains
        procedure :: learn
        procedure :: channels
        procedure :: largest
    end type forecast_t

    !> Shapes and sizes are known only about: of the sources' sum so much counts, whatever they undo.
    real(wp), parameter :: doubtful_part = 0.35_wp

contains

    !> `rungs` holds two rungs for each source, the poorer one first; 0 where the source plays no part.
    subroutine learn(self, ladder, rungs)
        class(forecast_t), intent(inout) :: self
        type(ladder_t), intent(in) :: ladder
        integer, intent(in) :: rungs(2, n_sources)
        integer :: c, i, k, n

        n = size(ladder%trials(rungs(1, 1))%channels)
        if (.not. allocated(self%share)) allocate (self%share(n_sources, n), &
            self%likeness(n_sources, n_sources, n))
        self%share = 0.0_wp
        self%likeness = 0.0_wp
        do i = 1, n_sources
            if (any(rungs(:, i) == 0)) cycle
            self%share(i, :) = ladder%changes(rungs(1, i), rungs(2, i))
            associate (share => self%share(i, :))
                if (maxval(share) > 0.0_wp) share = share/maxval(share)
            end associate
        end do
        do c = 1, n
            do i = 1, n_sources
                do k = 1, i
                    if (any(rungs(:, [i, k]) == 0)) cycle
                    associate (trials => ladder%trials, one => rungs(:, i), other => rungs(:, k))
                        self%likeness(i, k, c) = likeness(trials(one(1))%channels(c)%course, &
                            trials(one(2))%channels(c)%course, trials(other(1))%channels(c)%course, &
                            trials(other(2))%channels(c)%course)
                    end associate
                    self%likeness(k, i, c) = self%likeness(i, k, c)
                end do
            end do
        end do
    end subroutine learn

    !> Estimated error of every channel where the sources' errors are `sizes` in the channel that has most.
    pure function channels(self, sizes) result(errors)
        class(forecast_t), intent(in) :: self
        real(wp), intent(in) :: sizes(n_sources)
        real(wp) :: errors(size(self%share, 2))
        real(wp) :: own(n_sources)
        integer :: c

        do c = 1, size(errors)
            own = sizes*self%share(:, c)
            errors(c) = sqrt(max(0.0_wp, dot_product(own, matmul(self%likeness(:, :, c), own))) &
                + (doubtful_part*sum(own))**2)
        end do
    end function channels

    !> The largest of them.
    pure real(wp) function largest(self, sizes)
        class(forecast_t), intent(in) :: self
        real(wp), intent(in) :: sizes(n_sources)

        largest = maxval(self%channels(sizes))
    end function largest

end module gb_forecast
