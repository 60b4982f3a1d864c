/* How much memory the system would give. */
#define _GNU_SOURCE
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#define PATH_ROOM 4096

/* The number after `name` in a file of lines "name number ..."; with an empty name the first number. -1: none. */
static int64_t number_in(const char *path, const char *name)
{
    char line[512];
    int64_t number = -1;
    size_t length = strlen(name);
    FILE *file = fopen(path, "r");

    while (file && number < 0 && fgets(line, sizeof line, file))
        if (strncmp(line, name, length) == 0 && sscanf(line + length, "%*[: ]%" SCNd64, &number) != 1 &&
            sscanf(line + length, "%" SCNd64, &number) != 1)
            number = -1;
    if (file)
        fclose(file);
    return number;
}

static int64_t least(int64_t first, int64_t second)
{
    return first < second ? first : second;
}

/* What a limit of the process leaves: `column` of /proc/self/statm tells what is taken. */
static int64_t below_limit(int resource, int column)
{
    struct rlimit limit;
    int64_t pages[6] = {0};
    FILE *file;

    if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return INT64_MAX;
    file = fopen("/proc/self/statm", "r");
    if (file) {
        for (int i = 0; i < 6; i++)
            if (fscanf(file, "%" SCNd64, &pages[i]) != 1)
                break;
        fclose(file);
    }
    return (int64_t)limit.rlim_cur - pages[column] * sysconf(_SC_PAGESIZE);
}

/* What the control groups leave in which batch systems and containers keep a job (version 2). */
static int64_t below_groups(void)
{
    char path[PATH_ROOM], name[PATH_ROOM + 64];
    int64_t left = INT64_MAX;
    FILE *file = fopen("/proc/self/cgroup", "r");
    char *end;

    path[0] = '\0';
    while (file && fgets(path, sizeof path, file) && strncmp(path, "0::/", 4) != 0)
        path[0] = '\0';
    if (file)
        fclose(file);
    if (path[0] == '\0')
        return left;
    path[strcspn(path, "\n")] = '\0';
    while ((end = strrchr(path + 3, '/')) != NULL) {
        snprintf(name, sizeof name, "/sys/fs/cgroup%s/memory.max", path + 3);
        int64_t most = number_in(name, "");
        snprintf(name, sizeof name, "/sys/fs/cgroup%s/memory.stat", path + 3);
        int64_t taken = number_in(name, "anon");
        if (most >= 0)
            left = least(left, most - (taken > 0 ? taken : 0));
        *end = '\0';
    }
    return left;
}

/* Bytes that the process can still get: limits of the process, of its groups, and of the machine. */
int64_t gb_available_memory(void)
{
    int64_t free_kb = number_in("/proc/meminfo", "MemAvailable");
    int64_t swap_kb = number_in("/proc/meminfo", "SwapFree");
    int64_t left = least(below_limit(RLIMIT_AS, 0), below_limit(RLIMIT_DATA, 5));

    if (free_kb >= 0)
        left = least(left, 1024 * (free_kb + (swap_kb > 0 ? swap_kb : 0)));
    left = least(left, below_groups());
    return left > 0 ? left : 0;
}
