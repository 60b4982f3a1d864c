/* Holding a results file against other writers, and asking the system why it takes no more. */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "gb_locks.h"

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

/* Make sure that `path` can be written and that nobody keeps it open, and hold it for this process, which never closes
   it. 0: went well; 1: `reason` says why not. */
int gb_claim_file(const char *path, char *reason, size_t size)
{
    int file = open(path, O_RDWR | O_CREAT, 0666);

    if (file < 0)
        return refused(reason, size, strerror(errno));
    if (gb_hold_against_writers(file) || gb_is_kept_locked(file)) {
        close(file);
        return refused(reason, size, gb_in_use);
    }
    return 0;
}

/* Give an environment variable a value for this process, unless the user has set it. */
void gb_set_default(const char *name, const char *value)
{
    setenv(name, value, 0);
}
