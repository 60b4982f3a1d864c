!> Whether the machine has the memory for a model: asked before it is taken, since a system that runs out of
!> it kills the program, or another one.
module gb_capacity
    use, intrinsic :: iso_c_binding, only: c_int64_t
    use gb_kinds, only: wp, i8
    use gb_text, only: to_text
    implicit none
    private

    interface
        function c_available_memory() bind(c, name="gb_available_memory") result(bytes)
            import :: c_int64_t
            integer(c_int64_t) :: bytes
        end function c_available_memory
    end interface

    !> Bytes that any machine has. Asking costs a tenth of a millisecond, as much as some tens of steps.
    integer(i8), parameter :: worth_asking = 32000000_i8

    public :: lacks_memory

contains

    !> Why so many bytes cannot be had ("it needs about 12 GB of memory, and 3.1 GB are available"), or an
    !> empty text.
    function lacks_memory(bytes) result(reason)
        integer(i8), intent(in) :: bytes
        character(:), allocatable :: reason
        integer(i8) :: available

        reason = ''
        if (bytes < worth_asking) return
        available = int(c_available_memory(), i8)
        if (bytes > available) reason = 'it needs about ' // memory_text(bytes) // ' of memory, and ' &
            // memory_text(available) // ' are available'
    end function lacks_memory

    !> "3.1 GB", "420 MB".
    pure function memory_text(bytes) result(text)
        integer(i8), intent(in) :: bytes
        character(:), allocatable :: text

        if (bytes < 1000000000_i8) then
            text = to_text(nint(real(bytes, wp)*1.0e-6_wp)) // ' MB'
        else
            text = to_text(real(bytes, wp)*1.0e-9_wp, 2) // ' GB'
        end if
    end function memory_text

end module gb_capacity
