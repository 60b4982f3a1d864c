/* Files that tell whether they are whole: a block at the end holds the length and a digest of all before it.
   And what it takes to put one in the place of another at once. */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <libgen.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { block_size = 512, buffer_size = 1 << 16 };
enum { went_well = 0, refused = 1, damaged = 2 };

static int told(char *reason, size_t size, int error)
{
    strncpy(reason, strerror(error), size - 1);
    reason[size - 1] = '\0';
    return refused;
}

/* FNV-1a (Fowler, Noll, Vo), 64 bits. Each byte changes the digest one-to-one, so that no single damaged byte goes
   unnoticed. */
uint64_t gb_digest(const unsigned char *bytes, size_t count, uint64_t digest)
{
    for (size_t i = 0; i < count; i++)
        digest = (digest ^ bytes[i]) * UINT64_C(0x100000001b3);
    return digest;
}

/* The block for the first `length` bytes of an open file: a line of text, the rest NUL. */
static int make_block(int file, off_t length, char block[block_size])
{
    static unsigned char buffer[buffer_size];
    uint64_t digest = UINT64_C(0xcbf29ce484222325);
    off_t done = 0;

    while (done < length) {
        size_t wanted = length - done < buffer_size ? (size_t)(length - done) : buffer_size;
        ssize_t count = pread(file, buffer, wanted, done);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0)
            return -1;
        digest = gb_digest(buffer, (size_t)count, digest);
        done += count;
    }
    memset(block, 0, block_size);
    snprintf(block, block_size, "gentbeam sealed file, length %" PRIu64 ", FNV-1a %016" PRIx64 "\n", (uint64_t)length,
             digest);
    return 0;
}

/* Add the block, and see to it that the whole file is on the disk. */
int gb_seal_file(const char *path, char *reason, size_t size)
{
    char block[block_size];
    struct stat status;
    int failed = went_well;
    int file = open(path, O_RDWR);

    if (file < 0)
        return told(reason, size, errno);
    errno = EIO;
    if (fstat(file, &status) != 0 || make_block(file, status.st_size, block) != 0 ||
        pwrite(file, block, block_size, status.st_size) != block_size || fsync(file) != 0)
        failed = told(reason, size, errno);
    if (close(file) != 0 && !failed)
        failed = told(reason, size, errno);
    return failed;
}

/* 0: the file is what was sealed; 1: it cannot be read, `reason` says why; 2: it is something else, or damaged. */
int gb_check_seal(const char *path, char *reason, size_t size)
{
    char expected[block_size], block[block_size];
    struct stat status;
    int failed = went_well;
    int file = open(path, O_RDONLY | O_NONBLOCK);

    if (file < 0)
        return told(reason, size, errno);
    errno = EIO;
    if (fstat(file, &status) != 0)
        failed = told(reason, size, errno);
    else if (S_ISDIR(status.st_mode))
        failed = told(reason, size, EISDIR);
    else if (!S_ISREG(status.st_mode) || status.st_size < block_size)
        failed = damaged;
    else if (pread(file, block, block_size, status.st_size - block_size) != block_size ||
             make_block(file, status.st_size - block_size, expected) != 0)
        failed = told(reason, size, errno);
    else if (memcmp(block, expected, block_size) != 0)
        failed = damaged;
    close(file);
    return failed;
}

/* Give a file the name of another one, which it replaces in one instant, also where the machine stops. */
int gb_replace_file(const char *from, const char *to, char *reason, size_t size)
{
    char *copy;
    int folder;

    if (rename(from, to) != 0)
        return told(reason, size, errno);
    /* The name is safe once the folder is; a file system that cannot do that has done what it can. */
    copy = strdup(to);
    if (copy == NULL)
        return went_well;
    folder = open(dirname(copy), O_RDONLY | O_DIRECTORY);
    free(copy);
    if (folder >= 0) {
        fsync(folder);
        close(folder);
    }
    return went_well;
}

void gb_remove_file(const char *path)
{
    unlink(path);
}

/* Whether there is a file of that name. */
int gb_is_file(const char *path)
{
    return access(path, F_OK) == 0;
}

/* Whether two names lead to one file that is there. */
int gb_is_same_file(const char *first, const char *second)
{
    struct stat a, b;

    return stat(first, &a) == 0 && stat(second, &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/* Whether a checkpoint may take that name: nothing is there, or an empty file or one that HDF5 wrote; not a deck or a
   table. */
int gb_is_free_or_hdf5(const char *path)
{
    static const char signature[8] = {'\211', 'H', 'D', 'F', '\r', '\n', '\032', '\n'};
    char found[sizeof signature];
    struct stat status;
    ssize_t count;
    int file;

    if (stat(path, &status) != 0)
        return 1;
    if (!S_ISREG(status.st_mode))
        return 0;
    file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return 1;
    count = read(file, found, sizeof found);
    close(file);
    return count == 0 || (count == sizeof found && memcmp(found, signature, sizeof found) == 0);
}

/* Whether two paths are names of one file, which may be there or not: they lead to one, or are the same name in one
   folder. */
int gb_is_same_place(const char *first, const char *second)
{
    const char *first_name = strrchr(first, '/'), *second_name = strrchr(second, '/');
    char *first_copy = strdup(first), *second_copy = strdup(second);
    int answer = gb_is_same_file(first, second);

    if (!answer && first_copy && second_copy)
        answer = strcmp(first_name ? first_name + 1 : first, second_name ? second_name + 1 : second) == 0
                 && gb_is_same_file(dirname(first_copy), dirname(second_copy));
    free(first_copy);
    free(second_copy);
    return answer;
}

/* A copy of this process that tries out what may crash, or never end: 0 in the copy, its number in the original, -1
   where there is none. */
int gb_begin_rehearsal(int seconds)
{
    static const int deaths[] = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGALRM};
    struct rlimit none = {0, 0};
    pid_t process = fork();

    if (process == 0) {
        for (size_t i = 0; i < sizeof deaths / sizeof *deaths; i++)
            signal(deaths[i], SIG_DFL);
        setrlimit(RLIMIT_CORE, &none);
        if (freopen("/dev/null", "w", stderr) == NULL)
            _exit(0);
        alarm((unsigned)seconds);
    }
    return (int)process;
}

/* The end of the copy. */
void gb_end_rehearsal(void)
{
    _exit(0);
}

/* Whether the copy came to its end. */
int gb_rehearsal_went_well(int process)
{
    int status;

    while (waitpid((pid_t)process, &status, 0) < 0)
        if (errno != EINTR)
            return 1;
    return WIFEXITED(status);
}
