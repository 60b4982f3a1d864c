/* Locks on results files. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <time.h>
#include <unistd.h>
#include "gb_locks.h"

const char gb_in_use[] = "another program is using it";

int gb_hold_against_writers(int file)
{
    struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
#ifdef F_OFD_SETLK
    int refused = fcntl(file, F_OFD_SETLK, &whole);
#else
    int refused = fcntl(file, F_SETLK, &whole);
#endif
    return refused != 0 && (errno == EACCES || errno == EAGAIN);
}

int gb_is_kept_locked(int file)
{
    const struct timespec pause = {.tv_nsec = 1000000};

    for (int tries = 0; tries < 1000; tries++) {
        if (flock(file, LOCK_EX | LOCK_NB) == 0) {
            flock(file, LOCK_UN);
            return 0;
        }
        if (errno != EWOULDBLOCK && errno != EINTR)
            return 0;
        nanosleep(&pause, NULL);
    }
    return 1;
}
