!> What a cross-section is made of: the Gent material's constants and the rectangle it fills.
module gb_section
    use gb_kinds, only: wp
    implicit none
    private

    !> How the integral through the thickness is done (docs/theory.md, section rules).
    integer, parameter, public :: rule_gauss = 1, rule_linear = 2
    !> Which terms of the kinetic energy are kept.
    integer, parameter, public :: inertia_diagonal = 1, inertia_translational = 2, inertia_full = 3
    character(13), parameter, public :: inertia_names(3) = [character(13) :: 'diagonal', 'translational', &
        'full']
    !> `jm` of a neo-Hookean material.
    real(wp), parameter, public :: unlimited_jm = huge(1.0_wp)

    !> Compressible Gent material, eq. (15) corrected.
    type, public :: material_t
        character(:), allocatable :: name
        real(wp) :: mu = 0.0_wp             !! shear modulus [F/L^2]
        real(wp) :: c = 0.0_wp              !! volumetric modulus [F/L^2]
        real(wp) :: beta = -2.0_wp          !! exponent of the volumetric energy [-]
        real(wp) :: jm = unlimited_jm       !! limit of I1-2 (chain extensibility) [-]
        real(wp) :: rho = 0.0_wp            !! mass density of the reference state [F T^2/L^4]
    contains
        procedure :: lame => small_strain_lame
        procedure :: fibre_modulus
        procedure :: poisson_ratio
    end type material_t

    !> Rectangular section b x h.
    type, public :: section_t
        character(:), allocatable :: name
        real(wp) :: b = 0.0_wp              !! width [L]
        real(wp) :: h = 0.0_wp              !! thickness [L]
        integer :: rule = rule_gauss
        integer :: points = 3               !! Gauss points through the thickness (rule_gauss)
        logical :: is_auto = .false.        !! their number is the program's choice
        real(wp) :: tolerance = 1.0e-3_wp   !! auto: relative error of the stress resultants [-]
        integer :: inertia = inertia_diagonal
        logical :: inertia_is_given = .false.   !! by the deck: `auto` keeps it then
    contains
        procedure :: area
        procedure :: second_moment
        procedure :: fourth_moment
    end type section_t

contains

    !> First Lame modulus at small strain, c + 2 mu/jm [F/L^2].
    pure real(wp) function small_strain_lame(self)
        class(material_t), intent(in) :: self

        small_strain_lame = self%c + 2.0_wp*(self%mu/self%jm)
    end function small_strain_lame

    !> Modulus of a fibre whose thickness is free, 4 mu (lame+mu)/(lame+2mu) [F/L^2].
    pure real(wp) function fibre_modulus(self)
        class(material_t), intent(in) :: self
        real(wp) :: lame

        lame = self%lame()
        fibre_modulus = 4.0_wp*self%mu*(lame + self%mu)/(lame + 2.0_wp*self%mu)
    end function fibre_modulus

    !> Poisson's ratio (thickness against length, plane) at small strain, lame/(lame+2mu) [-].
    pure real(wp) function poisson_ratio(self)
        class(material_t), intent(in) :: self

        poisson_ratio = self%lame()/(self%lame() + 2.0_wp*self%mu)
    end function poisson_ratio

    !> A = b h [L^2].
    pure real(wp) function area(self)
        class(section_t), intent(in) :: self

        area = self%b*self%h
    end function area

    !> I = b h^3/12, integral of X3^2 [L^4].
    pure real(wp) function second_moment(self)
        class(section_t), intent(in) :: self

        second_moment = self%b*self%h**3/12.0_wp
    end function second_moment

    !> I4 = b h^5/80, integral of X3^4 [L^6].
    pure real(wp) function fourth_moment(self)
        class(section_t), intent(in) :: self

        fourth_moment = self%b*self%h**5/80.0_wp
    end function fourth_moment

end module gb_section
