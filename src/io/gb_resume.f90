!> Where a run that was interrupted finds the results of its earlier steps. That file is only read: the run
!> goes on in a new one, into which it takes over the rows up to the checkpoint.
module gb_resume
    use gb_error, only: error_t, raise, status_file
    use gb_files, only: is_file
    use gb_checkpoint, only: origin_t, checkpoint_t
    use gb_hdf5, only: start_hdf5
    use gb_hdf5_input, only: hid_t, open_file, close_file, get_attribute, get_deck
    implicit none
    private

    public :: find_source

contains

    !> Find the results of the steps before a checkpoint: in the file `path` that the run writes, in the one
    !> it wrote before, by its old name, or beside the checkpoint. A run (`as_written`) takes its old name
    !> first: that file is sure to reach the checkpoint. A study may have gone on in the one it writes.
    subroutine find_source(path, beside, origin, checkpoint, as_written, source, error)
        character(*), intent(in) :: path            !! of the results
        character(*), intent(in) :: beside          !! path of the checkpoint
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(in) :: checkpoint
        logical, intent(in) :: as_written
        character(:), allocatable, intent(out) :: source
        type(error_t), allocatable, intent(out) :: error
        character(:), allocatable :: neighbour, said
        integer :: slash

        call start_hdf5()
        slash = index(checkpoint%results, '/', back=.true.)
        neighbour = beside(:index(beside, '/', back=.true.)) // checkpoint%results(slash + 1:)
        said = ''
        if (as_written) call look_into(checkpoint%results)
        if (.not. (as_written .and. path == checkpoint%results)) call look_into(path)
        if (.not. (as_written .or. path == checkpoint%results)) call look_into(checkpoint%results)
        if (neighbour /= path .and. neighbour /= checkpoint%results) call look_into(neighbour)
        if (.not. allocated(source)) call raise(error, status_file, 'cannot restart from ' // beside &
            // ' without the results of the steps before it: ' // said)

    contains

        subroutine look_into(candidate)
            character(*), intent(in) :: candidate
            character(:), allocatable :: trouble

            if (allocated(source)) return
            call compare(candidate, origin, checkpoint, trouble)
            if (len(trouble) == 0) source = candidate
            if (len(said) > 0) said = said // '; '
            said = said // candidate // ' ' // trouble
        end subroutine look_into

    end subroutine find_source

    !> Whether a file holds the results of the run that wrote the checkpoint: why not, or an empty text.
    subroutine compare(path, origin, checkpoint, trouble)
        character(*), intent(in) :: path
        type(origin_t), intent(in) :: origin
        type(checkpoint_t), intent(in) :: checkpoint
        character(:), allocatable, intent(out) :: trouble
        type(error_t), allocatable :: error
        character(:), allocatable :: format, created, deck, parameters, version, revision
        integer(hid_t) :: file

        trouble = 'is not there'
        if (.not. is_file(path)) return
        trouble = 'is no HDF5 file, or is damaged'
        call open_file(path, file, error)
        if (allocated(error)) return
        call get_attribute(file, 'format', format, error)
        if (.not. allocated(error)) call get_attribute(file, 'created', created, error)
        if (.not. allocated(error)) call get_attribute(file, 'program_version', version, error)
        if (.not. allocated(error)) call get_attribute(file, 'git_revision', revision, error)
        if (.not. allocated(error)) call get_deck(file, deck, parameters, error)
        if (.not. allocated(error)) then
            if (format == 'gentbeam' .and. created == checkpoint%created .and. deck == origin%deck &
                .and. parameters == origin%parameters &
                .and. version // ' (' // revision // ')' == origin%program) then
                trouble = ''
            else
                trouble = 'holds the results of another run'
            end if
        end if
        call close_file(file)
    end subroutine compare

end module gb_resume
