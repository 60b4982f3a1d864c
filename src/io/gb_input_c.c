/* Results files that are read: opening them, and whether they still hold what was written. HDF5 protects what describes
   the numbers, and the attributes `checksum` and `text_checksum` the rest (docs/results.md). */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <hdf5.h>
#include <zlib.h>
#include "gb_cache.h"

#define SLAB_BYTES ((hsize_t)16 << 20)      /* of an array that are read at once */
#define MOST_DIMENSIONS 8

typedef struct {
    char *name;                             /* of the first object that is not what was written */
    size_t size;
} finding_t;

void gb_limit_cache(hid_t access)
{
    H5AC_cache_config_t config = {.version = H5AC__CURR_CACHE_CONFIG_VERSION};

    if (H5Pget_mdc_config(access, &config) < 0)
        return;
    config.set_initial_size = 1;
    config.initial_size = config.min_size = (size_t)1 << 20;
    config.max_size = (size_t)2 << 20;
    H5Pset_mdc_config(access, &config);
}

/* Open a file to read it: HDF5's identifier, or negative. */
hid_t gb_open_to_read(const char *path)
{
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    hid_t file;

    gb_limit_cache(access);
    file = H5Fopen(path, H5F_ACC_RDONLY, access);
    H5Pclose(access);
    return file;
}

/* A checksum that an object claims to have. 1: it has one; 0: none; -1: it cannot be read. */
static int claimed(hid_t object, const char *name, uint32_t *checksum)
{
    htri_t exists = H5Aexists(object, name);
    hid_t attribute;
    herr_t read;

    if (exists <= 0)
        return (int)exists;
    attribute = H5Aopen(object, name, H5P_DEFAULT);
    read = attribute < 0 ? -1 : H5Aread(attribute, H5T_NATIVE_UINT32, checksum);
    if (attribute >= 0)
        H5Aclose(attribute);
    return read < 0 ? -1 : 1;
}

static uint32_t add_text(uint32_t checksum, const char *text, int is_line)
{
    if (text)
        checksum = (uint32_t)crc32_z(checksum, (const Bytef *)text, strlen(text));
    return is_line ? (uint32_t)crc32_z(checksum, (const Bytef *)"\n", 1) : checksum;
}

static int is_text(hid_t type)
{
    return H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) > 0;
}

/* Go on with the checksum of `count` texts; they are freed. */
static uint32_t add_texts(uint32_t checksum, char **texts, hssize_t count, int are_lines)
{
    for (hssize_t i = 0; i < count; i++) {
        checksum = add_text(checksum, texts[i], are_lines);
        H5free_memory(texts[i]);
    }
    return checksum;
}

/* H5Aiterate: go on with the checksum in `data`, if the attribute is a text or a list of them. */
static herr_t look_at_attribute(hid_t object, const char *name, const H5A_info_t *info, void *data)
{
    uint32_t *checksum = data;
    hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
    hid_t type = attribute < 0 ? -1 : H5Aget_type(attribute);
    hid_t space = attribute < 0 ? -1 : H5Aget_space(attribute);
    hssize_t count = space < 0 ? -1 : H5Sget_simple_extent_npoints(space);
    herr_t answer = type < 0 || count < 0 ? -1 : 0;

    (void)info;
    if (answer == 0 && is_text(type)) {
        char **texts = calloc((size_t)count + 1, sizeof *texts);
        answer = texts ? H5Aread(attribute, type, texts) : -1;
        if (answer >= 0)
            *checksum = add_texts(*checksum, texts, count, 1);
        free(texts);
    }
    if (type >= 0)
        H5Tclose(type);
    if (space >= 0)
        H5Sclose(space);
    if (attribute >= 0)
        H5Aclose(attribute);
    return answer < 0 ? -1 : 0;
}

/* 0: the attributes are what was written; those of the root and of /units together. */
static int check_attributes(hid_t object, int is_root)
{
    uint32_t expected = 0, found = 0;
    int has_checksum = claimed(object, "text_checksum", &expected);
    herr_t answer;

    if (has_checksum <= 0)
        return has_checksum;
    answer = H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, NULL, look_at_attribute, &found);
    if (answer >= 0 && is_root) {
        hid_t units = H5Oopen(object, "units", H5P_DEFAULT);
        answer = units < 0 ? -1 : H5Aiterate2(units, H5_INDEX_NAME, H5_ITER_INC, NULL, look_at_attribute, &found);
        if (units >= 0)
            H5Oclose(units);
    }
    return answer >= 0 && found == expected ? 0 : -1;
}

static int read_texts(hid_t dataset, hid_t type, hid_t space, uint32_t *checksum)
{
    hssize_t count = H5Sget_simple_extent_npoints(space);
    char **texts = count < 0 ? NULL : calloc((size_t)count + 1, sizeof *texts);
    int trouble = !texts || (count > 0 && H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts) < 0);

    if (!trouble)
        *checksum = add_texts(0, texts, count, H5Sget_simple_extent_ndims(space) > 0);
    free(texts);
    return trouble;
}

/* The bytes of an array, so many rows at once. */
static int read_numbers(hid_t dataset, hid_t type, hid_t space, uint32_t *checksum)
{
    hsize_t extent[MOST_DIMENSIONS] = {1}, start[MOST_DIMENSIONS] = {0}, part[MOST_DIMENSIONS];
    int dimensions = H5Sget_simple_extent_ndims(space);
    hsize_t row = H5Tget_size(type), rows;
    unsigned char *bytes;
    int trouble = 0;

    if (dimensions < 1 || dimensions > MOST_DIMENSIONS || H5Sget_simple_extent_dims(space, extent, NULL) < 0)
        return 1;
    memcpy(part, extent, sizeof part);
    for (int i = 1; i < dimensions; i++)
        row *= extent[i];
    if (row == 0 || extent[0] == 0)
        return 0;
    rows = row > SLAB_BYTES ? 1 : SLAB_BYTES / row;
    bytes = malloc((size_t)(row * (rows < extent[0] ? rows : extent[0])));
    if (!bytes)
        return 1;
    for (; start[0] < extent[0] && !trouble; start[0] += part[0]) {
        hid_t memory;
        part[0] = extent[0] - start[0] < rows ? extent[0] - start[0] : rows;
        memory = H5Screate_simple(dimensions, part, NULL);
        trouble = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, part, NULL) < 0 ||
                  H5Dread(dataset, type, memory, space, H5P_DEFAULT, bytes) < 0;
        H5Sclose(memory);
        if (!trouble)
            *checksum = (uint32_t)crc32_z(*checksum, bytes, (z_size_t)(row * part[0]));
    }
    free(bytes);
    return trouble;
}

/* 0: the numbers or texts are what was written. */
static int check_dataset(hid_t dataset)
{
    uint32_t expected = 0, found = 0;
    int has_checksum = claimed(dataset, "checksum", &expected);
    hid_t type, space;
    int trouble = 1;

    if (has_checksum <= 0)
        return has_checksum;
    type = H5Dget_type(dataset);
    space = H5Dget_space(dataset);
    if (type >= 0 && space >= 0)
        trouble = is_text(type) ? read_texts(dataset, type, space, &found) : read_numbers(dataset, type, space, &found);
    if (type >= 0)
        H5Tclose(type);
    if (space >= 0)
        H5Sclose(space);
    return trouble || found != expected;
}

/* H5Ovisit: 1 where an object is not what was written. */
static herr_t look_at(hid_t file, const char *name, const H5O_info_t *info, void *data)
{
    finding_t *finding = data;
    hid_t object = H5Oopen(file, name, H5P_DEFAULT);
    int trouble = object < 0 || check_attributes(object, strcmp(name, ".") == 0) != 0 ||
                  (info->type == H5O_TYPE_DATASET && check_dataset(object) != 0);

    if (object >= 0)
        H5Oclose(object);
    if (trouble)
        snprintf(finding->name, finding->size, "%s", name);
    return trouble;
}

/* Look at all that is in a file. 0: it is what was written; else `name` is the first object that is not. */
int gb_verify(hid_t file, char *name, size_t size)
{
    finding_t finding = {.name = name, .size = size};
    herr_t answer;

    snprintf(name, size, "it");
#if H5_VERSION_GE(1, 12, 0)
    answer = H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at, &finding, H5O_INFO_BASIC);
#else
    answer = H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at, &finding);
#endif
    return answer != 0;
}
