/* What Fortran's own input and output cannot do: say why the system refuses to write, ignore signals. */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <unistd.h>

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

/* Write to standard output. 0: went well. */
int gb_write_output(const char *text, size_t length)
{
    return write_all(STDOUT_FILENO, text, length);
}

/* A write that cannot be done shall be told by its status, not end the program. */
void gb_ignore_write_signals(void)
{
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}
