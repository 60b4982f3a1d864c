/* What Fortran's own input and output cannot do: say why the system refuses to write, ignore signals. */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stddef.h>
#include <sys/resource.h>
#include <time.h>
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

/* Where the program begins without standard input, output or error, the next file that is opened would get their
   number, and what is meant for them: the log, into the results. So these numbers are taken by a file with which what is
   meant for them fails as it would without any. */
void gb_hold_standard_files(void)
{
    static const int ways[] = {O_WRONLY, O_RDONLY, O_RDONLY};

    for (int file = 0; file < 3; file++)
        if (fcntl(file, F_GETFD) < 0)
            open("/dev/null", ways[file]);
}

/* A write that cannot be done shall be told by its status, not end the program. */
void gb_ignore_write_signals(void)
{
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

/* As many open files as the system allows. */
void gb_raise_file_limit(void)
{
    struct rlimit limit;

    if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
        limit.rlim_cur = limit.rlim_max;
        setrlimit(RLIMIT_NOFILE, &limit);
    }
}

/* Let others work for a tenth of a millisecond. */
void gb_pause_briefly(void)
{
    struct timespec moment = {.tv_nsec = 100000};
    nanosleep(&moment, NULL);
}
