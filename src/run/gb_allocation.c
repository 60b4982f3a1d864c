/* Stands before C's memory routines in the program (not in the library). */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/mman.h>
#endif
#ifdef __GLIBC__
#include <malloc.h>
#endif

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);

/* Pages of 4 kB cost a large model a sixth of its time, in looking up where its arrays lie, and a small one a fifth, in
   asking the system for each of them. Where the system leaves it to programs to ask for large pages, they are asked
   for: by every block of this size, and by the first memory that small blocks are cut from. */
static const size_t large_page = 2 << 20;

#ifdef MADV_HUGEPAGE
static void *in_large_pages(void *memory, size_t size)
{
    uintptr_t page, first, end;

    if (size >= large_page) {
        page = (uintptr_t)sysconf(_SC_PAGESIZE);
        first = ((uintptr_t)memory + page - 1) / page * page;
        end = ((uintptr_t)memory + size) / page * page;
        madvise((void *)first, end - first, MADV_HUGEPAGE); /* refused where there are none: no harm */
    }
    return memory;
}
#else
static void *in_large_pages(void *memory, size_t size)
{
    (void)size;
    return memory;
}
#endif

/* Before the program begins: let the heap's first pages be large ones. One of them is given out only where none of its
   small pages has been touched, so the heap goes on a little before such a page, and gets the room for two of them at
   once, with the note it keeps at the end of what is in use still before both. */
#if defined(__GLIBC__) && defined(MADV_HUGEPAGE) && !defined(__SANITIZE_ADDRESS__)
__attribute__((constructor)) static void begin_heap(void)
{
    const size_t room = 2 * large_page, lead = 192 << 10, usual_pad = 128 << 10;
    uintptr_t end = (uintptr_t)sbrk(0), first = (end + lead + large_page - 1) / large_page * large_page;
    void *block;

    if (end == UINTPTR_MAX || sbrk((intptr_t)(first - lead - end)) == (void *)-1)
        return;
    mallopt(M_MMAP_THRESHOLD, (int)room); /* what is larger than the room lies for itself */
    mallopt(M_TRIM_THRESHOLD, 32 << 20);
    mallopt(M_TOP_PAD, (int)(room + lead));
    block = __real_malloc(lead - (32 << 10));
    madvise((void *)first, room, MADV_HUGEPAGE);
    free(block);
    mallopt(M_TOP_PAD, (int)usual_pad);
}
#endif

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
