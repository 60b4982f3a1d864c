/* Locks on results files, for gb_store_c.c. */
#ifndef GB_LOCKS_H
#define GB_LOCKS_H

/* Why a file cannot be had that is held by others. */
extern const char gb_in_use[];

/* Hold a file against other writers, till it is closed: no second run may claim it. Readers ask with flock, and are
   let in. 1: somebody else holds it. A file system without such locks lets everybody in. */
int gb_hold_against_writers(int file);

/* Whether others keep a file locked with flock, as HDF5 does. Who only looks into it, as a script that waits for
   results does again and again, lets go within the second that is waited. */
int gb_is_kept_locked(int file);

#endif
