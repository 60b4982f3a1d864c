! Links against HDF5 as gentbeam does: asks whether its archives can be used on this machine.
program uses_hdf5
    use hdf5, only: hid_t, h5open_f, h5fcreate_f, h5fclose_f, h5f_acc_trunc_f
    implicit none
    integer(hid_t) :: file
    integer :: info

    call h5open_f(info)
    call h5fcreate_f('uses_hdf5.h5', h5f_acc_trunc_f, file, info)
    call h5fclose_f(file, info)
end program uses_hdf5
