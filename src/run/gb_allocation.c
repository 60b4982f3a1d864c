/* Stands before C's memory routines in the program (not in the library). */
#include <stdio.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

/* The arrays of a large model are walked through once an iteration: with pages of 4 kB looking up where these lie
   costs a sixth of the time. Where the system leaves it to programs to ask for large pages, they are asked for. */
static void *in_large_pages(void *memory, size_t size)
{
#ifdef MADV_HUGEPAGE
    const size_t worthwhile = 8 << 20;
    uintptr_t page, first, end;

    if (size >= worthwhile) {
        page = (uintptr_t)sysconf(_SC_PAGESIZE);
        first = ((uintptr_t)memory + page - 1) / page * page;
        end = ((uintptr_t)memory + size) / page * page;
        madvise((void *)first, end - first, MADV_HUGEPAGE); /* refused where there are none: no harm */
    }
#endif
    return memory;
}

/* Memory that is refused ends the program with a sentence and the exit status of a deck that asks for too much,
   wherever in the program or its libraries that happens: Fortran's assignments and temporary arrays do not ask
   whether they got any. The linker puts these in the place of C's (src/CMakeLists.txt). */
static void *got(void *memory, size_t size)
{
    char said[200];
    int length;

    if (memory || size == 0)
        return in_large_pages(memory, size);
    length = snprintf(said, sizeof said,
                      "gentbeam: error: out of memory: the system refuses another %.3g %s; a smaller model needs less, "
                      "and limits may be set for this job\n",
                      size < 1000000 ? 1e-3 * (double)size : 1e-6 * (double)size, size < 1000000 ? "kB" : "MB");
    if (write(STDERR_FILENO, said, (size_t)length) < 0)
        _exit(1);
    _exit(1);
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);

/* Arrays begin with a line of the cache: of vectors that do not, every second one lies in two lines. */
static void *in_whole_lines(size_t size)
{
    const size_t line = 64;
    void *memory;

    return posix_memalign(&memory, line, size) ? NULL : memory;
}

void *__wrap_malloc(size_t size)
{
    const size_t worthwhile = 1024;

    return got(size < worthwhile ? __real_malloc(size) : in_whole_lines(size), size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return got(__real_calloc(count, size), count * size);
}

void *__wrap_realloc(void *memory, size_t size)
{
    return got(__real_realloc(memory, size), size);
}
