/* Holding a results file against other writers, and asking the system why it takes no more. */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <time.h>
#include <unistd.h>

static int refused(char *reason, size_t size, const char *words)
{
    strncpy(reason, words, size - 1);
    reason[size - 1] = '\0';
    return 1;
}

/* All bytes, or -1 with errno set. */
static int write_all(int file, const char *bytes, size_t count)
{
    while (count > 0) {
        ssize_t written = write(file, bytes, count);
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return -1;
        bytes += written;
        count -= (size_t)written;
    }
    return 0;
}

/* Write `bytes` bytes to a new file beside the results and remove it again. 0: went well; 1: `reason` says why not. */
int gb_try_to_write(const char *path, size_t bytes, char *reason, size_t size)
{
    static const char block[4096];
    int failed = 0;
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);

    if (file < 0)
        return refused(reason, size, strerror(errno));
    while (bytes > 0 && !failed) {
        size_t part = bytes < sizeof block ? bytes : sizeof block;
        if (write_all(file, block, part) != 0)
            failed = refused(reason, size, strerror(errno));
        bytes -= part;
    }
    if (!failed && fsync(file) != 0)
        failed = refused(reason, size, strerror(errno));
    if (close(file) != 0 && !failed)
        failed = refused(reason, size, strerror(errno));
    unlink(path);
    return failed;
}

/* Whether others keep `file` locked. Who only looks into it, as a script that waits for results does again and again,
   lets go within the second that is waited. A file system without such locks lets everybody in. */
static int is_kept_locked(int file)
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

/* Make sure that `path` can be written and that nobody keeps it open, and hold it for this process. Others may
   read it from then on (HDF5 asks with flock), but no second run may claim it (fcntl; held until the program ends or
   closes the file). 0: went well; 1: `reason` says why not. */
int gb_claim_file(const char *path, char *reason, size_t size)
{
    struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    int file = open(path, O_RDWR | O_CREAT, 0666);

    if (file < 0)
        return refused(reason, size, strerror(errno));
    if (fcntl(file, F_SETLK, &whole) != 0 && (errno == EACCES || errno == EAGAIN)) {
        close(file);
        return refused(reason, size, "another program is using it");
    }
    if (is_kept_locked(file)) {
        close(file);
        return refused(reason, size, "another program is using it");
    }
    return 0;
}

/* Give an environment variable a value for this process, unless the user has set it. */
void gb_set_default(const char *name, const char *value)
{
    setenv(name, value, 0);
}
