/* The file under a results file: numbers are appended, and what describes them (HDF5's metadata) is written anew,
   whole, for every edition. One small write of the superblock then makes the new edition the valid one, so that the
   file is a complete HDF5 file at every instant (docs/reliability.md).

   HDF5 makes the metadata through a driver of ours (its "virtual file layer"). The driver never touches the disk: it
   hands out addresses and keeps what it is given in memory. Numbers that are in the file already get the addresses
   they have ("offers").

   Whole groups that never change again can be kept: they are written once, as an edition that never becomes the valid
   one, and every later edition links to them. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <hdf5.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif
#include "gb_cache.h"
#include "gb_locks.h"

#define SUPERBLOCK_ROOM 64                  /* the first bytes of the file; HDF5's superblock of version 2 takes 48 */
#define GATHER_ROOM ((size_t)256 * 1024)    /* bytes of small writes that are put together */
#define REASON_ROOM 256
#define GRACE_SECONDS 30.0                  /* for which a replaced edition stays, for those who still read it */

/* A stretch of the file that holds an edition's metadata. */
typedef struct {
    int64_t base, capacity;                 /* no capacity yet: it is new, and ends where the file ends */
    double left_at;                         /* when another edition took its place */
    int is_kept;                            /* what it holds is linked to by all later editions */
} region_t;

typedef struct {
    int file;
    char *path, *part;                      /* the file's name, and the one it has before its first edition */
    int published;                          /* editions in the file */
    int64_t end;                            /* first byte that is not given away */
    int64_t disk_size;                      /* length of the file as we have made it */
    char *gathered;                         /* neighbouring writes, not yet made */
    int64_t gathered_at;
    size_t gathered_bytes;
    region_t *regions;
    int n_regions, regions_room;
    int valid, current;                     /* regions of the edition in the file, and of the one being made */
    int wants_new_region;
    unsigned char *image;                   /* its metadata */
    size_t image_room, image_bytes;
    unsigned char *annex;                   /* what did not fit in the region, as if it lay at the end of the file */
    size_t annex_room, annex_bytes;
    unsigned char superblock[SUPERBLOCK_ROOM];
    size_t superblock_bytes;
    int superblock_given;
    const int64_t *offers;                  /* addresses of the next numbers that HDF5 asks room for */
    int64_t offers_left, offer_bytes;
    char reason[REASON_ROOM];
} store_t;

static int failed(store_t *store, const char *words)
{
    snprintf(store->reason, sizeof store->reason, "%s", words);
    return 1;
}

/* ---- writing ------------------------------------------------------------------------------------------------- */

static int write_at(store_t *store, const void *bytes, size_t count, int64_t at)
{
    const char *next = bytes;

    while (count > 0) {
        ssize_t written = pwrite(store->file, next, count, (off_t)at);
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return failed(store, strerror(errno));
        next += written;
        at += written;
        count -= (size_t)written;
        if (at > store->disk_size)
            store->disk_size = at;
    }
    return 0;
}

static int write_gathered(store_t *store)
{
    size_t count = store->gathered_bytes;

    store->gathered_bytes = 0;
    return count > 0 ? write_at(store, store->gathered, count, store->gathered_at) : 0;
}

/* Room for so many bytes: its address. */
int64_t gb_store_allocate(store_t *store, int64_t bytes)
{
    int64_t at = store->end;

    store->end += (bytes + 7) / 8 * 8;
    return at;
}

/* Write numbers into room that was allocated. 0: went well. */
int gb_store_write(store_t *store, int64_t at, const void *bytes, int64_t count)
{
    int64_t gap = at - (store->gathered_at + (int64_t)store->gathered_bytes);
    int is_next = store->gathered_bytes > 0 && gap >= 0 && gap < 8;

    if (is_next && store->gathered_bytes + (size_t)(gap + count) <= GATHER_ROOM) {
        memset(store->gathered + store->gathered_bytes, 0, (size_t)gap);
        memcpy(store->gathered + store->gathered_bytes + gap, bytes, (size_t)count);
        store->gathered_bytes += (size_t)(gap + count);
        return 0;
    }
    if (write_gathered(store) != 0)
        return 1;
    if (count > (int64_t)GATHER_ROOM / 4)
        return write_at(store, bytes, (size_t)count, at);
    memcpy(store->gathered, bytes, (size_t)count);
    store->gathered_at = at;
    store->gathered_bytes = (size_t)count;
    return 0;
}

/* ---- the driver ---------------------------------------------------------------------------------------------- */

typedef struct {
    H5FD_t pub;
    store_t *store;
} driver_file_t;

typedef struct {
    store_t *store;
} driver_info_t;

static store_t *store_of(const H5FD_t *file)
{
    return ((const driver_file_t *)file)->store;
}

static int64_t base_of(const store_t *store)
{
    return store->regions[store->current].base;
}

static H5FD_t *driver_open(const char *name, unsigned flags, hid_t fapl, haddr_t maxaddr)
{
    const driver_info_t *info = H5Pget_driver_info(fapl);
    driver_file_t *file = info ? calloc(1, sizeof *file) : NULL;

    (void)name, (void)flags, (void)maxaddr;
    if (file)
        file->store = info->store;
    return (H5FD_t *)file;
}

static herr_t driver_close(H5FD_t *file)
{
    free(file);
    return 0;
}

/* Every edition is a file of its own to HDF5. */
static int driver_compare(const H5FD_t *first, const H5FD_t *second)
{
    return first < second ? -1 : first > second;
}

static herr_t driver_query(const H5FD_t *file, unsigned long *flags)
{
    (void)file;
    *flags = 0;
    return 0;
}

static haddr_t driver_get_eoa(const H5FD_t *file, H5FD_mem_t type)
{
    const store_t *store = store_of(file);
    int64_t top = base_of(store) + (int64_t)store->image_bytes;

    (void)type;
    /* HDF5 takes a file for new while it is empty. */
    if (!store->superblock_given)
        return 0;
    return (haddr_t)((top > store->end ? top : store->end) + (int64_t)store->annex_bytes);
}

/* Room for metadata: the next bytes of the region, or, where it is full, of the annex. Its address. */
static int64_t take(store_t *store, size_t bytes)
{
    const region_t *region = &store->regions[store->current];
    size_t at = (store->image_bytes + 7) / 8 * 8;

    if (region->capacity > 0 && (store->annex_bytes > 0 || (int64_t)(at + bytes) > region->capacity)) {
        at = (store->annex_bytes + 7) / 8 * 8;
        store->annex_bytes = at + bytes;
        return store->end + (int64_t)at;
    }
    store->image_bytes = at + bytes;
    return region->base + (int64_t)at;
}

/* HDF5 makes its last piece longer, the one at the end. */
static herr_t driver_set_eoa(H5FD_t *file, H5FD_mem_t type, haddr_t address)
{
    store_t *store = store_of(file);
    int64_t more = (int64_t)address - (int64_t)driver_get_eoa(file, type);

    if (more > 0 && store->annex_bytes > 0)
        store->annex_bytes += (size_t)more;
    else if (more > 0)
        store->image_bytes += (size_t)more;
    return 0;
}

static haddr_t driver_allocate(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, hsize_t size)
{
    store_t *store = store_of(file);

    (void)dxpl;
    if (type == H5FD_MEM_SUPER && !store->superblock_given) {
        store->superblock_given = 1;
        return 0;
    }
    if (type == H5FD_MEM_DRAW && store->offers_left > 0) {
        if ((int64_t)size != store->offer_bytes)
            return HADDR_UNDEF;
        store->offers_left--;
        return (haddr_t)*store->offers++;
    }
    return (haddr_t)take(store, (size_t)size);
}

static herr_t driver_free(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t address, hsize_t size)
{
    (void)file, (void)type, (void)dxpl, (void)address, (void)size;
    return 0;
}

/* Let a buffer have so many bytes at least; new ones are 0. */
static int make_room(store_t *store, unsigned char **buffer, size_t *room, size_t bytes)
{
    size_t wanted = *room ? *room : 32768;
    unsigned char *larger;

    if (bytes <= *room)
        return 0;
    while (wanted < bytes)
        wanted *= 2;
    larger = realloc(*buffer, wanted);
    if (!larger)
        return failed(store, strerror(ENOMEM));
    memset(larger + *room, 0, wanted - *room);
    *buffer = larger;
    *room = wanted;
    return 0;
}

/* Where a piece of metadata is kept, or NULL where the file holds no metadata. */
static unsigned char *place(store_t *store, haddr_t address, size_t size)
{
    int64_t within = (int64_t)address - base_of(store), beyond = (int64_t)address - store->end;

    if (address + size <= SUPERBLOCK_ROOM)
        return store->superblock + address;
    if (within >= 0 && within + (int64_t)size <= (int64_t)store->image_bytes)
        return make_room(store, &store->image, &store->image_room, store->image_bytes) ? NULL : store->image + within;
    if (beyond >= 0 && beyond + (int64_t)size <= (int64_t)store->annex_bytes)
        return make_room(store, &store->annex, &store->annex_room, store->annex_bytes) ? NULL : store->annex + beyond;
    return NULL;
}

/* Whether an address belongs to what earlier editions have kept. Regions lie in the file in their order. */
static int is_kept(const store_t *store, haddr_t address)
{
    int low = 0, high = store->n_regions - 1;

    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (store->regions[middle].base <= (int64_t)address)
            low = middle;
        else
            high = middle - 1;
    }
    return store->regions[low].is_kept && low != store->current && (int64_t)address >= store->regions[low].base &&
           (int64_t)address < store->regions[low].base + store->regions[low].capacity;
}

/* HDF5 reads what it has given us in this edition, and the headers of objects kept by earlier ones. */
static herr_t driver_read(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t address, size_t size, void *bytes)
{
    store_t *store = store_of(file);
    const unsigned char *from = place(store, address, size);
    size_t done = 0;

    (void)type, (void)dxpl;
    if (from) {
        memcpy(bytes, from, size);
        return 0;
    }
    while (is_kept(store, address) && done < size) {
        ssize_t count = pread(store->file, (char *)bytes + done, size - done, (off_t)(address + done));
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return -1;
        /* HDF5 reads more than a header to begin with, and that may go beyond the end of the file. */
        if (count == 0) {
            memset((char *)bytes + done, 0, size - done);
            count = (ssize_t)(size - done);
        }
        done += (size_t)count;
    }
    return done == size ? 0 : -1;
}

static herr_t driver_write(H5FD_t *file, H5FD_mem_t type, hid_t dxpl, haddr_t address, size_t size,
                           const void *bytes)
{
    store_t *store = store_of(file);
    unsigned char *to = place(store, address, size);

    (void)dxpl;
    /* A kept object's header, which would count one link more. Each edition has only one, and so the header in the
       file is right as it is. */
    if (!to && type == H5FD_MEM_OHDR && is_kept(store, address))
        return 0;
    if (!to)
        return -1;
    memcpy(to, bytes, size);
    if (address == 0)
        store->superblock_bytes = size;
    return 0;
}

static const H5FD_class_t driver = {
#if H5_VERSION_GE(1, 13, 0)
    .version = H5FD_CLASS_VERSION,
    .value = (H5FD_class_value_t)511,
#endif
    .name = "gentbeam",
    .maxaddr = (haddr_t)INT64_MAX,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(driver_info_t),
    .open = driver_open,
    .close = driver_close,
    .cmp = driver_compare,
    .query = driver_query,
    .alloc = driver_allocate,
    .free = driver_free,
    .get_eoa = driver_get_eoa,
    .set_eoa = driver_set_eoa,
    .get_eof = driver_get_eoa,
    .read = driver_read,
    .write = driver_write,
    .fl_map = H5FD_FLMAP_DEFAULT,           /* numbers never get room that metadata has given back */
};

/* ---- editions ------------------------------------------------------------------------------------------------ */

static double now(void)
{
    struct timespec time;

    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* The smallest region that nobody reads any more and that the metadata will fit in: its index, or -1. */
static int find_region(const store_t *store)
{
    int64_t wanted = (int64_t)(store->image_bytes + store->image_bytes / 8);
    double latest = now() - GRACE_SECONDS;
    int best = -1;

    for (int i = 0; i < store->n_regions && !store->wants_new_region; i++) {
        const region_t *region = &store->regions[i];
        if (i == store->valid || region->is_kept || region->left_at > latest || region->capacity < wanted)
            continue;
        if (best < 0 || region->capacity < store->regions[best].capacity)
            best = i;
    }
    return best;
}

static int add_region(store_t *store)
{
    if (store->n_regions == store->regions_room) {
        int room = 2 * store->regions_room + 8;
        region_t *larger = realloc(store->regions, (size_t)room * sizeof *larger);
        if (!larger)
            return -1;
        store->regions = larger;
        store->regions_room = room;
    }
    store->regions[store->n_regions] = (region_t){.base = store->end};
    return store->n_regions++;
}

/* Begin an edition, or one that is to be kept: HDF5's identifier of an empty file, or negative. All numbers must have
   got their room before. */
hid_t gb_store_begin(store_t *store, int to_be_kept)
{
    static hid_t driver_id = H5I_INVALID_HID;
    driver_info_t info = {.store = store};
    hid_t access, file;

    store->current = to_be_kept ? -1 : find_region(store);
    if (store->current < 0)
        store->current = add_region(store);
    if (store->current < 0) {
        failed(store, strerror(ENOMEM));
        return H5I_INVALID_HID;
    }
    if (store->image)
        memset(store->image, 0, store->image_room);
    store->image_bytes = 0;
    store->annex_bytes = 0;
    store->superblock_given = 0;
    store->offers_left = 0;
    memset(store->superblock, 0, sizeof store->superblock);
    if (driver_id < 0)
        driver_id = H5FDregister(&driver);
    access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_driver(access, driver_id, &info);
    /* Superblocks from version 3 on are marked while somebody writes: after a kill no reader would take the file. */
    H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
    gb_limit_cache(access);
    file = H5Fcreate(store->part, H5F_ACC_TRUNC, H5P_DEFAULT, access);
    H5Pclose(access);
    return file;
}

/* The next `count` rooms of `bytes` bytes that HDF5 asks for are these. */
void gb_store_offer(store_t *store, const int64_t *addresses, int64_t count, int64_t bytes)
{
    store->offers = addresses;
    store->offers_left = count;
    store->offer_bytes = bytes;
}

int64_t gb_store_offers_left(const store_t *store)
{
    return store->offers_left;
}

static int is_in_its_place(store_t *store)
{
    struct stat ours, there;

    if (fstat(store->file, &ours) != 0 || stat(store->path, &there) != 0 || ours.st_ino != there.st_ino ||
        ours.st_dev != there.st_dev)
        return 0;
    return 1;
}

/* Network file systems tell of a full quota when a file is closed: closing a second descriptor asks them. */
static int ask_file_system(store_t *store)
{
#ifdef F_OFD_SETLK
    int again = dup(store->file);

    if (again >= 0 && close(again) != 0)
        return failed(store, strerror(errno));
#endif
    return 0;
}

/* Put the metadata that HDF5 has made into its region; a new one gets a length, with `reserve` more than it needs. */
static int write_image(store_t *store, int reserve)
{
    region_t *region = &store->regions[store->current];
    int64_t bytes;

    if (store->superblock_bytes == 0 || store->superblock_bytes > SUPERBLOCK_ROOM)
        return failed(store, "HDF5 made no superblock of the expected kind");
    if (region->capacity == 0) {
        region->capacity = ((int64_t)store->image_bytes + 7) / 8 * 8;
        if (reserve)
            region->capacity += region->capacity / 4 / 8 * 8;
        store->end = region->base + region->capacity;
    }
    /* The last edition's region ends with it, rounded up; then the file ends there too. */
    bytes = reserve ? (int64_t)store->image_bytes : ((int64_t)store->image_bytes + 7) / 8 * 8;
    if (make_room(store, &store->image, &store->image_room, (size_t)bytes) != 0)
        return 1;
    return gb_store_write(store, region->base, store->image, bytes) != 0 || write_gathered(store) != 0;
}

/* After HDF5 has closed an edition that is to be kept: what it holds has its place in the file for good. 0: went
   well. */
int gb_store_keep(store_t *store)
{
    if (write_image(store, 0) != 0)
        return 1;
    store->regions[store->current].is_kept = 1;
    return 0;
}

/* Where an object of an edition lies in the file; negative where HDF5 does not tell. */
int64_t gb_store_address(hid_t object)
{
#if H5_VERSION_GE(1, 12, 0)
    H5O_info1_t info;
#else
    H5O_info_t info;
#endif

    return H5Oget_info1(object, &info) < 0 ? -1 : (int64_t)info.addr;
}

/* Give an object that is kept at an address a name in this edition. 0: went well. */
int gb_store_link(hid_t group, const char *name, int64_t address)
{
    hid_t object = H5Oopen_by_addr(group, (haddr_t)address);
    int trouble = object < 0 || H5Olink(object, group, name, H5P_DEFAULT, H5P_DEFAULT) < 0;

    if (object >= 0)
        H5Oclose(object);
    return trouble;
}

/* After HDF5 has closed the edition: put it into the file and make it the valid one. `reserve`: leave room for it to
   grow; `durable`: let it reach the disk first. 0: went well; 1: it failed; 2: it did not fit, make it once more. */
int gb_store_commit(store_t *store, int reserve, int durable)
{
    store->wants_new_region = store->annex_bytes > 0;
    if (store->wants_new_region)
        return 2;
    if (store->published && !is_in_its_place(store))
        return failed(store, "it was removed or replaced during the run");
    if (write_image(store, reserve) != 0)
        return 1;
    if (store->disk_size < store->end && ftruncate(store->file, (off_t)store->end) != 0)
        return failed(store, strerror(errno));
    if (store->disk_size < store->end)
        store->disk_size = store->end;
    if (ask_file_system(store) != 0 || (durable && fdatasync(store->file) != 0))
        return failed(store, strerror(errno));
    if (write_at(store, store->superblock, store->superblock_bytes, 0) != 0)
        return 1;
    if (!store->published && rename(store->part, store->path) != 0)
        return failed(store, strerror(errno));
    if (store->valid >= 0)
        store->regions[store->valid].left_at = now();
    store->valid = store->current;
    store->published = 1;
    return 0;
}

/* ---- the file ------------------------------------------------------------------------------------------------ */

/* Whether the results may be replaced that are there: NULL, or why not. */
static const char *why_not_replace(const char *path, mode_t *mode)
{
    struct stat status;
    const char *why = NULL;
    int file = open(path, O_RDWR | O_CLOEXEC);

    if (file < 0)
        return errno == ENOENT ? NULL : strerror(errno);
    if (fstat(file, &status) != 0)
        why = strerror(errno);
    else if (!S_ISREG(status.st_mode))
        why = "it is not an ordinary file";
    else if (gb_hold_against_writers(file) || gb_is_kept_locked(file))
        why = gb_in_use;
    else
        *mode = status.st_mode & 07777;
    close(file);
    return why;
}

/* The file NAME.part, claimed; a run may just be giving it its final name, and then it is another file. */
static int open_part(store_t *store)
{
    struct stat ours, there;

    for (int tries = 0; tries < 100; tries++) {
        store->file = open(store->part, O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (store->file < 0)
            return failed(store, errno == ELOOP ? "the same name with .part is a link" : strerror(errno));
        if (fstat(store->file, &ours) == 0 && !S_ISREG(ours.st_mode)) {
            close(store->file);
            store->file = -1;
            return failed(store, "the same name with .part is not an ordinary file");
        }
        if (gb_hold_against_writers(store->file)) {
            close(store->file);
            store->file = -1;
            return failed(store, gb_in_use);
        }
        if (fstat(store->file, &ours) == 0 && stat(store->part, &there) == 0 && ours.st_ino == there.st_ino &&
            ours.st_dev == there.st_dev)
            return 0;
        close(store->file);
    }
    store->file = -1;
    return failed(store, gb_in_use);
}

/* Empty what a killed run has left, and set the permissions of the file that is replaced, if there is one. */
static int prepare(int file, mode_t mode)
{
    struct stat status;

    if (fstat(file, &status) != 0 || (status.st_size > 0 && ftruncate(file, 0) != 0))
        return -1;
    return mode != 0 && mode != (status.st_mode & 07777) ? fchmod(file, mode) : 0;
}

static void release(store_t *store)
{
    free(store->path);
    free(store->part);
    free(store->gathered);
    free(store->regions);
    free(store->image);
    free(store->annex);
    free(store);
}

/* Open the file that is to become `path`. What is there already stays until the first edition takes its place. NULL:
   `reason` says why not. */
store_t *gb_store_open(const char *path, char *reason, size_t size)
{
    store_t *store = calloc(1, sizeof *store);
    mode_t mode = 0;
    const char *why = NULL;

    if (store) {
        store->file = -1;
        store->valid = -1;
        store->end = store->gathered_at = SUPERBLOCK_ROOM;
        store->path = realpath(path, NULL);
        if (!store->path)
            store->path = strdup(path);
        store->gathered = malloc(GATHER_ROOM);
        if (store->path && asprintf(&store->part, "%s.part", store->path) < 0)
            store->part = NULL;
    }
    if (!store || !store->path || !store->part || !store->gathered)
        why = strerror(ENOMEM);
    else if (open_part(store) != 0)
        why = store->reason;
    else if ((why = why_not_replace(store->path, &mode)) == NULL && prepare(store->file, mode) != 0)
        why = strerror(errno);
    if (!why)
        return store;
    snprintf(reason, size, "%s", why);
    if (store && store->file >= 0) {
        unlink(store->part);
        close(store->file);
    }
    if (store)
        release(store);
    return NULL;
}

/* Close the file; one that has no edition yet is removed. 0: went well; 1: `reason` says what did not. */
int gb_store_close(store_t *store, char *reason, size_t size)
{
    int trouble = 0;

    if (!store->published)
        unlink(store->part);
    if (close(store->file) != 0)
        trouble = failed(store, strerror(errno));
    snprintf(reason, size, "%s", store->reason);
    release(store);
    return trouble;
}

void gb_store_reason(const store_t *store, char *reason, size_t size)
{
    snprintf(reason, size, "%s", store->reason);
}
