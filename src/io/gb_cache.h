/* How much HDF5 remembers of what describes a file. */
#ifndef GB_CACHE_H
#define GB_CACHE_H

#include <hdf5.h>

/* Let the files that are opened with these properties have a small cache: HDF5's own may take a gigabyte where there are
   many thousands of groups, none of which is looked at twice. */
void gb_limit_cache(hid_t access);

#endif
