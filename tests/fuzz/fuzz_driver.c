/* A coverage-guided fuzzer of the deck reader.

   usage: fuzz_deck [--runs N] [--seed N] [--new FOLDER] [--found FOLDER] FILE-OR-FOLDER...

   The files are decks to start from. Each run changes one of those that are worth keeping (bits, bytes, lines, words
   of the deck's own vocabulary, numbers, deep nesting, long repeats, a piece of another one), reads the result as a
   deck, and keeps it if it reached code that none before had reached (gcc's -fsanitize-coverage=trace-pc calls
   __sanitizer_cov_trace_pc in every basic block). A child process does the reading; where it dies, or takes too
   long, the input goes to the folder --found, and another child goes on. With --runs 0 the given decks alone are
   read, and --new gets those of them that reach something the ones before did not. The same seed gives the same runs. Exit status 0: nothing found. */
#define _GNU_SOURCE
#include <dirent.h>
#include <fcntl.h>
#include <fenv.h>
#include <inttypes.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

int fuzz_deck(const char *bytes, size_t count);
size_t fuzz_words(char *bytes, size_t size);

enum {
    map_size = 1 << 16,
    most_bytes = 1 << 13,
    most_kept = 8192,
    most_words = 1024,
    seconds_a_run = 20,
    megabytes = 6000,
    most_found = 20,
    runs_a_report = 50000,
};

typedef struct {
    size_t count;
    char *bytes;
} text_t;

/* What parent and child share. */
typedef struct {
    uint8_t reached[map_size]; /* how often, in powers of two, a pair of neighbouring blocks has been met */
    size_t count;              /* the input being read */
    char bytes[most_bytes];
    uint64_t runs, accepted, kept_runs;
    double slowest; /* seconds of the slowest run, and its input */
    size_t slowest_count;
    char slowest_bytes[most_bytes];
    size_t n_kept; /* lengths and bytes of the inputs worth keeping */
    size_t kept_count[most_kept];
    size_t kept_start[most_kept];
    size_t n_good; /* those of them that are decks without a mistake */
    size_t good[most_kept];
    size_t used;
    char store[];
} shared_t;

enum { store_size = 256 << 20 };

static shared_t *shared;
static uint8_t met[map_size];
static uintptr_t last_block;
static bool counting;
static text_t words[most_words];
static size_t n_words;
static uint64_t state = 1;

/* Called by the code under test at every basic block. */
__attribute__((no_sanitize("address", "undefined"))) void __sanitizer_cov_trace_pc(void)
{
    uintptr_t block;

    if (!counting)
        return;
    block = (uintptr_t)__builtin_return_address(0);
    block = (block ^ (block >> 16)) * 0x9E3779B1u;
    block = (block >> 8) & (map_size - 1);
    uint8_t *counter = &met[block ^ last_block];
    if (*counter < 255)
        ++*counter;
    last_block = block >> 1;
}

/* xorshift64*, so that a seed gives the same runs everywhere. */
static uint64_t random_bits(void)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return state * UINT64_C(2685821657736338717) >> 16;
}

static size_t below(size_t limit)
{
    return limit == 0 ? 0 : (size_t)(random_bits() % limit);
}

static void fail(const char *what)
{
    perror(what);
    exit(2);
}

/* Keep an input for the rest of the runs. Where it ends up is the last one. */
static void keep(const char *bytes, size_t count)
{
    if (shared->n_kept == most_kept || shared->used + count > store_size)
        return;
    memcpy(shared->store + shared->used, bytes, count);
    shared->kept_start[shared->n_kept] = shared->used;
    shared->kept_count[shared->n_kept] = count;
    shared->used += count;
    shared->n_kept++;
}

static uint8_t power_class(uint8_t n)
{
    uint8_t bit = 1;

    while (n > 1 && bit < 128) {
        n >>= 1;
        bit = (uint8_t)(bit << 1);
    }
    return bit;
}

/* Whether the run met something for the first time, which is noted. */
static bool is_news(void)
{
    bool news = false;

    for (size_t i = 0; i < map_size; i++) {
        if (i % sizeof(uint64_t) == 0 && memcmp(met + i, &(uint64_t){0}, sizeof(uint64_t)) == 0) {
            i += sizeof(uint64_t) - 1; /* most pairs are not met */
            continue;
        }
        if (met[i] == 0)
            continue;
        uint8_t class = power_class(met[i]);
        if (!(shared->reached[i] & class)) {
            shared->reached[i] |= class;
            news = true;
        }
    }
    return news;
}

/* Read the shared input as a deck. True where it led somewhere new. */
static bool run_once(bool *accepted)
{
    /* Seconds of its own: others may keep the machine busy. Waiting for ever counts too, later. */
    struct itimerval limit = {.it_value = {.tv_sec = seconds_a_run}};
    struct itimerval wait_limit = {.it_value = {.tv_sec = 20 * seconds_a_run}};
    clock_t start = clock();
    double seconds;
    int outcome;

    memset(met, 0, sizeof met);
    last_block = 0;
    setitimer(ITIMER_PROF, &limit, NULL);
    setitimer(ITIMER_REAL, &wait_limit, NULL);
    counting = true;
    outcome = fuzz_deck(shared->bytes, shared->count);
    counting = false;
    if (outcome < 0)
        abort();
    seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    if (seconds > shared->slowest) {
        shared->slowest = seconds;
        shared->slowest_count = shared->count;
        memcpy(shared->slowest_bytes, shared->bytes, shared->count);
    }
    shared->runs++;
    *accepted = outcome > 0;
    shared->accepted += (uint64_t)*accepted;
    return is_news();
}

/* The input under way, changed in place. */
typedef struct {
    size_t count;
    char bytes[most_bytes];
} draft_t;

/* Replace `gone` bytes at `place` by others. */
static void put_in(draft_t *draft, size_t place, size_t gone, const char *bytes, size_t count)
{
    static char tail[most_bytes];
    size_t rest = draft->count - place - gone;

    if (place + count > most_bytes)
        count = most_bytes - place;
    if (place + count + rest > most_bytes)
        rest = most_bytes - place - count;
    memcpy(tail, draft->bytes + place + gone, rest);
    memmove(draft->bytes + place, bytes, count);
    memcpy(draft->bytes + place + count, tail, rest);
    draft->count = place + count + rest;
}

static bool is_word(char c)
{
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || strchr("_.+-=", c) != NULL;
}

/* A word of the input: its place and length. */
static size_t find_word(const draft_t *draft, size_t *count)
{
    size_t place = below(draft->count);
    size_t first = place, last = place;

    while (first > 0 && is_word(draft->bytes[first - 1]))
        first--;
    while (last < draft->count && is_word(draft->bytes[last]))
        last++;
    *count = last - first;
    return first;
}

static size_t find_line(const draft_t *draft, size_t *count)
{
    size_t first = below(draft->count);
    const char *end;

    while (first > 0 && draft->bytes[first - 1] != '\n')
        first--;
    end = memchr(draft->bytes + first, '\n', draft->count - first);
    *count = end ? (size_t)(end - draft->bytes) - first + 1 : draft->count - first;
    return first;
}

static const char *const numbers[] = {
    "0", "-0", "1", "-1", "2", "3", "5", "10", "0.5", "1e-300", "1e300", "-1e300", "1e308", "1.8e308", "1e-324", "1e999",
    "9999999999", "2147483647", "2147483648", "-2147483648", "1d5", "1e", ".", "1.", ".5", "nan", "inf", "infinity", "pi",
    "x", "t", "L", "h", "q", "1/0", "0/0", "0^0", "0^-1", "2^1024", "-2^0.5", "2^-1024", "sqrt(-1)", "log(0)", "asin(2)",
    "exp(1e3)", "max(1,2)", "min(1)", "(1)", "((1", "1))", "1e-10", "0.1+0.2", "1-1", "1e5*1e5", "[1 2 3]", "[]", "[",
    "]", "[1,2,3,4,5,6,7,8,9]", "\"a b\"", "\"", "''", "u1", "v3", "none", "a=1", "=", "==", "&\n", "!", "#", "load.csv",
    "\"/dev/null\"", "\"../good/load.csv\"", "\"a\nb\"", "/", "..", "\xef\xbb\xbf", "\xc3\xa9", "\xff", "\t", "\r\n", "\r",
    "#set q=1\n", "PARAMETER q=1\n", "END\n", "STOP\n", "name=a", "file=load.csv", "every=1", "x=0", "x=10", "x=5",
};
enum { n_numbers = sizeof numbers / sizeof *numbers };

static void insert_repeat(draft_t *draft, size_t place)
{
    static char block[most_bytes];
    static const char *const units[] = {"(", ")", "-", "+1", "((", "[", "]", " ", "\t", "a", "1", "\n", "&\n", "sin(", "^2",
                                        "x=0 ", "\"", ",", "\0", "\xc3", "=", "1 "};
    size_t unit = below(sizeof units / sizeof *units);
    size_t length = units[unit][0] == '\0' ? 1 : strlen(units[unit]);
    size_t count = 0, most = below(16) == 0 ? most_bytes : 40;

    most = 1 + below(most);
    while (count + length <= most_bytes && most-- > 0) {
        memcpy(block + count, units[unit], length);
        count += length;
    }
    put_in(draft, place, 0, block, count);
}

/* One change, of one kind out of many. */
static void change(draft_t *draft)
{
    size_t place = below(draft->count + 1), count, other, other_count;
    char byte;
    const text_t *word;

    switch (below(16)) {
    case 0:
        if (place < draft->count)
            draft->bytes[place] ^= (char)(1 << below(8));
        break;
    case 1:
        byte = (char)below(256);
        put_in(draft, place, 0, &byte, 1);
        break;
    case 2:
        count = 1 + below(draft->count - place < 20 ? draft->count - place : 20);
        if (place + count <= draft->count)
            put_in(draft, place, count, "", 0);
        break;
    case 3:
    case 4:
        place = find_word(draft, &count);
        word = &words[below(n_words)];
        put_in(draft, place, count, word->bytes, word->count);
        break;
    case 5:
    case 6:
    case 7:
        place = find_word(draft, &count);
        other = below(n_numbers);
        /* After a key, only its value. */
        for (size_t i = place; i < place + count; i++)
            if (draft->bytes[i] == '=' && below(4) > 0) {
                count -= i + 1 - place;
                place = i + 1;
                break;
            }
        put_in(draft, place, count, numbers[other], strlen(numbers[other]));
        break;
    case 8:
        word = &words[below(n_words)];
        put_in(draft, place, 0, word->bytes, word->count);
        put_in(draft, place, 0, " ", 1);
        break;
    case 9:
        other = below(n_numbers);
        put_in(draft, place, 0, numbers[other], strlen(numbers[other]));
        break;
    case 10:
        place = find_line(draft, &count);
        put_in(draft, place, count, "", 0);
        break;
    case 11: {
        static char line[most_bytes];
        place = find_line(draft, &count);
        memcpy(line, draft->bytes + place, count);
        other = find_line(draft, &other_count);
        put_in(draft, other, 0, line, count);
        break;
    }
    case 12:
        insert_repeat(draft, place);
        break;
    case 13: {
        size_t from = below(shared->n_kept);
        const char *bytes = shared->store + shared->kept_start[from];
        count = shared->kept_count[from];
        other = below(count);
        count = 1 + below(count - other < 200 ? count - other : 200);
        if (other + count <= shared->kept_count[from])
            put_in(draft, place, 0, bytes + other, count);
        break;
    }
    case 14: {
        /* A line of another one in the place of a line of this one. */
        static draft_t donor;
        size_t from = below(shared->n_kept);
        donor.count = shared->kept_count[from];
        memcpy(donor.bytes, shared->store + shared->kept_start[from], donor.count);
        other = find_line(&donor, &other_count);
        place = find_line(draft, &count);
        put_in(draft, place, below(2) ? count : 0, donor.bytes + other, other_count);
        break;
    }
    default:
        place = find_word(draft, &count);
        put_in(draft, place, count, "", 0);
        break;
    }
}

static void make_input(void)
{
    static draft_t draft;
    /* Every other time one of the latest, which have led somewhere new. */
    size_t n = shared->n_kept;
    size_t i = below(2) && n > 64 ? n - 1 - below(64) : below(n);
    size_t changes = (size_t)1 << (below(4) * below(2));

    if (below(2) && shared->n_good > 0)
        i = shared->good[below(shared->n_good)];
    draft.count = shared->kept_count[i];
    memcpy(draft.bytes, shared->store + shared->kept_start[i], draft.count);
    while (changes-- > 0)
        change(&draft);
    shared->count = draft.count;
    memcpy(shared->bytes, draft.bytes, draft.count);
}

static void write_input(const char *folder, const char *kind, uint64_t number, const char *bytes, size_t count)
{
    char path[4096];
    FILE *file;

    snprintf(path, sizeof path, "%s/%s-%" PRIu64 ".inp", folder, kind, number);
    file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, count, file) != count || fclose(file) != 0)
        fail(path);
}

static void read_file(const char *path)
{
    static char bytes[most_bytes];
    FILE *file = fopen(path, "rb");
    size_t count;

    if (!file)
        fail(path);
    count = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    keep(bytes, count);
}

static int by_name(const void *first, const void *second)
{
    return strcmp(*(char *const *)first, *(char *const *)second);
}

/* All *.inp of a folder, by name; or a file. */
static void read_seeds(const char *path)
{
    struct stat info;
    struct dirent *entry;
    char *names[most_kept], full[4096];
    size_t n = 0;
    DIR *folder;

    if (stat(path, &info) != 0)
        fail(path);
    if (!S_ISDIR(info.st_mode)) {
        read_file(path);
        return;
    }
    folder = opendir(path);
    if (!folder)
        fail(path);
    while ((entry = readdir(folder)) != NULL && n < most_kept) {
        size_t length = strlen(entry->d_name);
        if (length > 4 && strcmp(entry->d_name + length - 4, ".inp") == 0)
            names[n++] = strdup(entry->d_name);
    }
    closedir(folder);
    qsort(names, n, sizeof *names, by_name);
    for (size_t i = 0; i < n; i++) {
        snprintf(full, sizeof full, "%s/%s", path, names[i]);
        read_file(full);
        free(names[i]);
    }
}

static void read_words(void)
{
    static char bytes[1 << 16];
    size_t count = fuzz_words(bytes, sizeof bytes), first = 0;

    for (size_t i = 0; i < count && n_words < most_words; i++)
        if (bytes[i] == '\n') {
            words[n_words].bytes = bytes + first;
            words[n_words++].count = i - first;
            first = i + 1;
        }
}

/* In the child: the seeds from number `seed` on, then run after run. */
static void child(size_t *seed, size_t n_seeds, uint64_t runs, const char *new_folder)
{
    struct rlimit core = {0, 0};
    struct rusage usage;
    size_t i;
    bool accepted;

    setrlimit(RLIMIT_CORE, &core);
    feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
    while (*seed < n_seeds) {
        shared->count = shared->kept_count[*seed];
        memcpy(shared->bytes, shared->store + shared->kept_start[*seed], shared->count);
        i = (*seed)++;
        if (run_once(&accepted) && new_folder && runs == 0)
            write_input(new_folder, "deck", i, shared->bytes, shared->count);
        if (accepted)
            shared->good[shared->n_good++] = i;
    }
    while (shared->kept_runs < runs) {
        shared->kept_runs++;
        make_input();
        if (run_once(&accepted)) {
            size_t before = shared->n_kept;
            keep(shared->bytes, shared->count);
            if (accepted && shared->n_kept > before)
                shared->good[shared->n_good++] = before;
            if (new_folder)
                write_input(new_folder, "new", shared->kept_runs, shared->bytes, shared->count);
        }
        if (shared->kept_runs % runs_a_report == 0)
            fprintf(stderr, "%" PRIu64 " of %" PRIu64 " decks, %zu kept\n", shared->kept_runs, runs, shared->n_kept);
        if (shared->kept_runs % 1024 == 0 && getrusage(RUSAGE_SELF, &usage) == 0 && usage.ru_maxrss / 1024 > megabytes) {
            fprintf(stderr, "more than %d MB of memory\n", megabytes);
            abort();
        }
    }
    _exit(0);
}

static bool is_slow(int status)
{
    return WIFSIGNALED(status) && (WTERMSIG(status) == SIGPROF || WTERMSIG(status) == SIGALRM);
}

int main(int count, char **arguments)
{
    const char *new_folder = NULL, *found_folder = ".";
    uint64_t runs = 10000, seed = 1, found = 0;
    size_t *next, n_seeds, reached = 0;

    shared = mmap(NULL, sizeof *shared + store_size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    next = mmap(NULL, sizeof *next, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED || next == MAP_FAILED)
        fail("mmap");
    for (int i = 1; i < count; i++) {
        bool has_value = i + 1 < count;
        if (strcmp(arguments[i], "--runs") == 0 && has_value)
            runs = strtoull(arguments[++i], NULL, 10);
        else if (strcmp(arguments[i], "--seed") == 0 && has_value)
            seed = strtoull(arguments[++i], NULL, 10);
        else if (strcmp(arguments[i], "--new") == 0 && has_value)
            new_folder = arguments[++i];
        else if (strcmp(arguments[i], "--found") == 0 && has_value)
            found_folder = arguments[++i];
        else
            read_seeds(arguments[i]);
    }
    n_seeds = shared->n_kept;
    if (n_seeds == 0) {
        fprintf(stderr, "no deck to start from\n");
        return 2;
    }
    read_words();
    while (found < most_found) {
        int status = 0;
        pid_t process;

        fflush(NULL);
        process = fork();
        if (process < 0)
            fail("fork");
        if (process == 0) {
            state = seed * UINT64_C(0x9E3779B97F4A7C15) + shared->kept_runs + 1;
            child(next, n_seeds, runs, new_folder);
        }
        if (waitpid(process, &status, 0) != process)
            fail("waitpid");
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && shared->kept_runs >= runs)
            break;
        found++;
        printf("run %" PRIu64 ", %s %d\n", shared->runs, WIFSIGNALED(status) ? "signal" : "exit status", WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
        write_input(found_folder, is_slow(status) ? "slow" : "crash", shared->runs, shared->bytes,
                    shared->count);
    }
    printf("slowest: %.3f s\n", shared->slowest);
    write_input(found_folder, "slowest", 0, shared->slowest_bytes, shared->slowest_count);
    for (size_t i = 0; i < map_size; i++)
        reached += shared->reached[i] != 0;
    printf("%" PRIu64 " decks read (%zu given, %" PRIu64 " made), %" PRIu64 " accepted, %zu pairs of blocks reached, %zu decks kept\n",
           shared->runs, n_seeds, shared->kept_runs, shared->accepted, reached, shared->n_kept);
    printf("%" PRIu64 " passed, %" PRIu64 " failed\n", shared->runs, found);
    return found > 0;
}
