!> The course of a probe through a command, and how far two courses of it are apart.
module gb_course
    use gb_kinds, only: wp
    implicit none
    private

    !> Rows of one probe in one command.
    type, public :: course_t
        logical :: is_static = .false.              !! only where it ends matters
        integer :: rows = 0
        real(wp), allocatable :: t(:)               !! time [T] or load factor [-] (at least rows), increasing
        real(wp), allocatable :: value(:)           !! (at least rows)
        real(wp), allocatable :: rate(:)            !! d value/dt as the motion has it (at least rows)
        real(wp), allocatable :: samples(:)         !! values at equidistant instants, once it is closed
    contains
        procedure :: add
        procedure :: close
        procedure :: reaches
        procedure :: size_of
        procedure :: angular_frequency
        procedure :: unevenness
    end type course_t

    public :: distance, likeness

    integer, parameter :: first_rows = 64           !! room to begin with; it doubles
    !> Courses are compared at so many instants, which is enough for a mean over time.
    integer, parameter :: n_instants = 2000

contains

    pure subroutine add(self, t, value, rate)
        class(course_t), intent(inout) :: self
        real(wp), intent(in) :: t, value, rate
        real(wp), allocatable :: more(:)

        if (.not. allocated(self%t)) then
            allocate (self%t(first_rows), self%value(first_rows), self%rate(first_rows))
        else if (self%rows == size(self%t)) then
            allocate (more(self%rows))
            more = 0.0_wp
            self%t = [self%t, more]
            self%value = [self%value, more]
            self%rate = [self%rate, more]
        end if
        self%rows = self%rows + 1
        self%t(self%rows) = t
        self%value(self%rows) = value
        self%rate(self%rows) = rate
    end subroutine add

    !> Nothing will be added: make ready for comparisons.
    pure subroutine close(self)
        class(course_t), intent(inout) :: self

        if (self%rows > 1 .and. .not. self%is_static) self%samples = sampled(self, n_instants)
    end subroutine close

    !> Whether there are rows up to the time t, but for rounding.
    pure logical function reaches(self, t)
        class(course_t), intent(in) :: self
        real(wp), intent(in) :: t

        reaches = .false.
        if (self%rows > 1) reaches = self%t(self%rows) >= (1.0_wp - 1.0e-9_wp)*t
    end function reaches

    !> What an error of the course is measured by: its root mean square over time; of a static command, the
    !> largest value on its way.
    pure real(wp) function size_of(self)
        class(course_t), intent(in) :: self

        if (self%is_static) then
            size_of = maxval(abs(self%value(:self%rows)))
        else
            size_of = norm2(self%samples)/sqrt(real(n_instants, wp))
        end if
    end function size_of

    !> Root mean square of the difference of two courses over time, or the difference of their ends.
    pure real(wp) function distance(first, second)
        type(course_t), intent(in) :: first, second

        if (first%is_static) then
            distance = abs(first%value(first%rows) - second%value(second%rows))
        else
            distance = norm2(first%samples - second%samples)/sqrt(real(n_instants, wp))
        end if
    end function distance

    !> How alike two changes of a course are: the cosine of the angle between them, 1 where they have the same
    !> shape and sign, -1 where one undoes the other; 0 where one is none.
    pure real(wp) function likeness(from, to, other_from, other_to)
        type(course_t), intent(in) :: from, to, other_from, other_to
        real(wp), allocatable :: change(:), other_change(:)
        real(wp) :: sizes

        if (from%is_static) then
            change = [from%value(from%rows) - to%value(to%rows)]
            other_change = [other_from%value(other_from%rows) - other_to%value(other_to%rows)]
        else
            change = from%samples - to%samples
            other_change = other_from%samples - other_to%samples
        end if
        sizes = norm2(change)*norm2(other_change)
        likeness = 0.0_wp
        if (sizes > 0.0_wp) likeness = dot_product(change, other_change)/sizes
    end function likeness

    !> Values at equidistant instants after the first row, to the last; between rows the cubic that has their
    !> values, and in each the slope of the parabola through it and its neighbours. (The motion's own rates
    !> hold vibrations that long steps do not follow; between rows they would swing far out.)
    pure function sampled(self, instants) result(values)
        type(course_t), intent(in) :: self
        integer, intent(in) :: instants
        real(wp) :: values(instants)
        real(wp) :: t, s, width, slope, next_slope
        integer :: i, row, last_row

        last_row = 0
        row = 1
        associate (first => self%t(1), last => self%t(self%rows))
            do i = 1, instants
                t = first + (last - first)*real(i, wp)/real(instants, wp)
                do while (row < self%rows - 1 .and. self%t(row + 1) < t)
                    row = row + 1
                end do
                width = self%t(row + 1) - self%t(row)
                if (row /= last_row) then
                    slope = slope_at(self, row, row)
                    next_slope = slope_at(self, row + 1, row)
                    last_row = row
                end if
                s = (t - self%t(row))/width
                values(i) = (1.0_wp + 2.0_wp*s)*(1.0_wp - s)**2*self%value(row) &
                    + s**2*(3.0_wp - 2.0_wp*s)*self%value(row + 1) &
                    + s*(1.0_wp - s)*width*((1.0_wp - s)*slope - s*next_slope)
            end do
        end associate
    end function sampled

    !> Slope in a row, of the parabola through it and its neighbours; of the nearest one at the ends. Next to
    !> an interval that is much longer than its neighbour the parabola means nothing: there it is the chord.
    pure real(wp) function slope_at(self, row, interval) result(slope)
        type(course_t), intent(in) :: self
        integer, intent(in) :: row
        integer, intent(in) :: interval             !! that it is for, from this row to the next
        real(wp), parameter :: uneven = 8.0_wp
        real(wp) :: before, after
        integer :: middle

        if (self%rows < 3) then
            slope = (self%value(2) - self%value(1))/(self%t(2) - self%t(1))
            return
        end if
        middle = min(max(row, 2), self%rows - 1)
        associate (t => self%t(middle - 1:middle + 1), value => self%value(middle - 1:middle + 1))
            if (self%t(interval + 1) - self%t(interval) > uneven*min(t(2) - t(1), t(3) - t(2))) then
                slope = (self%value(interval + 1) - self%value(interval)) &
                    /(self%t(interval + 1) - self%t(interval))
                return
            end if
            before = (value(2) - value(1))/(t(2) - t(1))
            after = (value(3) - value(2))/(t(3) - t(2))
            slope = before + (after - before)/(t(3) - t(1))*(2.0_wp*self%t(row) - t(1) - t(2))
        end associate
    end function slope_at

    !> Angular frequency of the motion as a whole: of its rate over its deviation from the mean [1/T]; 0 where
    !> nothing moves, or no rates are known. A rule without numerical damping tells it even at steps that are
    !> much too long for it.
    pure real(wp) function angular_frequency(self)
        class(course_t), intent(in) :: self
        real(wp) :: mean, deviation

        angular_frequency = 0.0_wp
        associate (values => self%value(:self%rows), rates => self%rate(:self%rows))
            mean = sum(values)/real(self%rows, wp)
            deviation = norm2(values - mean)
            if (deviation > 0.0_wp) angular_frequency = norm2(rates)/deviation
        end associate
    end function angular_frequency

    !> How many times as many steps a fixed size takes as sizes for every instant would, at equal error [-].
    !> With steps h(t) the error of a rule of second order is the integral of g h^2, g being the third
    !> derivative, and the number of steps that of 1/h. A fixed size gives T^2/n^2 times the integral of g;
    !> the best one, as g^(-1/3), the cube of the integral of g^(1/3) over n^2.
    pure real(wp) function unevenness(self)
        class(course_t), intent(in) :: self
        real(wp) :: g, whole, third, duration, slopes(3)
        integer :: row

        whole = 0.0_wp
        third = 0.0_wp
        duration = 0.0_wp
        do row = 1, self%rows - 3
            associate (t => self%t(row:row + 3), f => self%value(row:row + 3))
                slopes = (f(2:) - f(:3))/(t(2:) - t(:3))
                g = abs((slopes(3) - slopes(2))/(t(4) - t(2)) - (slopes(2) - slopes(1))/(t(3) - t(1))) &
                    /(t(4) - t(1))
                whole = whole + g*(t(3) - t(2))
                third = third + g**(1.0_wp/3.0_wp)*(t(3) - t(2))
                duration = duration + (t(3) - t(2))
            end associate
        end do
        unevenness = 1.0_wp
        if (third > 0.0_wp) unevenness = max(1.0_wp, duration*sqrt(whole/third**3))
    end function unevenness

end module gb_course
