#define _POSIX_C_SOURCE 200112L
/* What Fortran's own input and output cannot tell: why the system refuses to write. */
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int refused(char *reason, size_t size)
{
    strncpy(reason, strerror(errno), size - 1);
    reason[size - 1] = '\0';
    return 1;
}

/* Write `bytes` bytes to a new file beside the results and remove it again. 0: went well; 1: `reason` says why not. */
int gb_try_to_write(const char *path, size_t bytes, char *reason, size_t size)
{
    static const char block[4096];
    int failed = 0;
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);

    if (file < 0)
        return refused(reason, size);
    while (bytes > 0 && !failed) {
        ssize_t written = write(file, block, bytes < sizeof block ? bytes : sizeof block);
        if (written < 0)
            failed = refused(reason, size);
        else
            bytes -= (size_t)written;
    }
    if (!failed && fsync(file) != 0)
        failed = refused(reason, size);
    if (close(file) != 0 && !failed)
        failed = refused(reason, size);
    unlink(path);
    return failed;
}

/* Give an environment variable a value for this process, unless the user has set it. */
void gb_set_default(const char *name, const char *value)
{
    setenv(name, value, 0);
}
