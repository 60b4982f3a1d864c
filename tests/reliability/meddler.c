/* Stands between the program and the system's calls that write files (LD_PRELOAD), and meddles:

   MEDDLER_KILL=N     the N-th call kills the process; a pwrite has then written a part of its bytes, up to the end
                      of a page as in the kernel, which looks for a kill between pages
   MEDDLER_FAIL=N     the N-th call fails, and all after it but close, with the error MEDDLER_ERROR (a number of errno)
   MEDDLER_ONCE=1     only the N-th call fails
   MEDDLER_MEMORY=N   the N-th request for a kilobyte of memory or more is refused
   MEDDLER_COUNT=F    at the end the numbers of calls and of such requests are written to the file F
   MEDDLER_CLOCK=X    the monotonic clock runs X times faster
   MEDDLER_TICK=X     the monotonic clock goes on by X seconds whenever it is asked, and only then: every run of a deck
                      does the same at the same step

   Calls are counted from the first open of a file whose name ends in .part. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

static long calls, kill_at, fail_at, requests, refuse_at;
static int error_number, only_once, has_begun;
static double clock_factor, tick;
static long ticks;

static double number(const char *name, double otherwise)
{
    const char *value = getenv(name);

    return value ? atof(value) : otherwise;
}

__attribute__((constructor)) static void read_orders(void)
{
    kill_at = (long)number("MEDDLER_KILL", 0);
    fail_at = (long)number("MEDDLER_FAIL", 0);
    refuse_at = (long)number("MEDDLER_MEMORY", 0);
    error_number = (int)number("MEDDLER_ERROR", EIO);
    only_once = (int)number("MEDDLER_ONCE", 0);
    clock_factor = number("MEDDLER_CLOCK", 1);
    tick = number("MEDDLER_TICK", 0);
}

__attribute__((destructor)) static void report(void)
{
    const char *name = getenv("MEDDLER_COUNT");
    FILE *file = name ? fopen(name, "w") : NULL;

    if (file) {
        fprintf(file, "%ld %ld\n", calls, requests);
        fclose(file);
    }
}

static void die(void)
{
    kill(getpid(), SIGKILL);
    for (;;)
        pause();
}

/* Whether this call fails; it may be the process's last. */
static int meddle(int may_die_here)
{
    if (!has_begun)
        return 0;
    calls++;
    if (may_die_here && calls == kill_at)
        die();
    if (fail_at > 0 && (calls == fail_at || (calls > fail_at && !only_once))) {
        errno = error_number;
        return 1;
    }
    return 0;
}

/* Bytes of a write that is torn about its middle. */
static size_t torn(size_t count, long at)
{
    const long page = 4096;
    long end = (at + (long)count / 2) / page * page;

    return end > at ? (size_t)(end - at) : 0;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static void look_at(const char *path)
{
    size_t length = strlen(path);

    if (length > 5 && strcmp(path + length - 5, ".part") == 0)
        has_begun = 1;
}

int open(const char *path, int flags, ...)
{
    mode_t mode = 0;
    va_list rest;

    va_start(rest, flags);
    if (flags & O_CREAT)
        mode = va_arg(rest, mode_t);
    va_end(rest);
    look_at(path);
    if ((flags & O_CREAT) && meddle(1))
        return -1;
    return REAL(open)(path, flags, mode);
}

int open64(const char *path, int flags, ...)
{
    mode_t mode = 0;
    va_list rest;

    va_start(rest, flags);
    if (flags & O_CREAT)
        mode = va_arg(rest, mode_t);
    va_end(rest);
    look_at(path);
    if ((flags & O_CREAT) && meddle(1))
        return -1;
    return REAL(open64)(path, flags, mode);
}

ssize_t pwrite(int file, const void *bytes, size_t count, off_t at)
{
    if (meddle(0))
        return -1;
    if (has_begun && calls == kill_at) {
        REAL(pwrite)(file, bytes, torn(count, (long)at), at);
        die();
    }
    return REAL(pwrite)(file, bytes, count, at);
}

ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t at)
{
    if (meddle(0))
        return -1;
    if (has_begun && calls == kill_at) {
        REAL(pwrite64)(file, bytes, torn(count, (long)at), at);
        die();
    }
    return REAL(pwrite64)(file, bytes, count, at);
}

int ftruncate(int file, off_t length)
{
    return meddle(1) ? -1 : REAL(ftruncate)(file, length);
}

int ftruncate64(int file, off64_t length)
{
    return meddle(1) ? -1 : REAL(ftruncate64)(file, length);
}

int fdatasync(int file)
{
    return meddle(1) ? -1 : REAL(fdatasync)(file);
}

int fchmod(int file, mode_t mode)
{
    return meddle(1) ? -1 : REAL(fchmod)(file, mode);
}

int rename(const char *from, const char *to)
{
    return meddle(1) ? -1 : REAL(rename)(from, to);
}

int close(int file)
{
    int fails = meddle(1);

    if (fails && !only_once && calls != fail_at)
        fails = 0;
    if (REAL(close)(file) != 0)
        return -1;
    if (fails)
        errno = error_number;
    return fails ? -1 : 0;
}

void *__libc_malloc(size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static int refuses(size_t size)
{
    return has_begun && size >= 1024 && ++requests == refuse_at;
}

void *malloc(size_t size)
{
    if (refuses(size)) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_malloc(size);
}

int posix_memalign(void **memory, size_t alignment, size_t size)
{
    void *got = refuses(size) ? NULL : __libc_memalign(alignment, size);

    if (!got)
        return ENOMEM;
    *memory = got;
    return 0;
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    int status = REAL(clock_gettime)(clock, time);

    if (clock == CLOCK_MONOTONIC && (clock_factor != 1 || tick > 0)) {
        double seconds = clock_factor * ((double)time->tv_sec + 1e-9 * (double)time->tv_nsec);
        if (tick > 0)
            seconds = tick * (double)++ticks;
        time->tv_sec = (time_t)seconds;
        time->tv_nsec = (long)(1e9 * (seconds - (double)time->tv_sec));
    }
    return status;
}
