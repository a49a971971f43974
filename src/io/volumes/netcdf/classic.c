/* Headers of classic NetCDF files (CDF-1, -2 and -5), of which the library reads zeros where they are cut short: the
 * bytes that a whole file has. */
#include "io/volumes/netcdf/netcdf.h"

#include "base/context.h"
#include "io/file.h"

#include <string.h>

enum { HEADER_MAX = 1 << 24, PADDING = 4, TYPES = 12, DIMENSIONS_MAX = 1 << 16 };

typedef struct cursor {
    const uint8_t* bytes;
    size_t size, at;
    size_t count_size, offset_size; /* bytes of a count and of an offset */
    bool bad;
} cursor;

static uint64_t take(cursor* c, size_t size) {
    uint64_t value = 0;
    if (c->bad || size > c->size - c->at) {
        c->bad = true;
        return 0;
    }
    for (size_t i = 0; i < size; ++i) value = value << 8 | c->bytes[c->at++];
    return value;
}

/* Passes bytes that are padded. */
static void skip(cursor* c, uint64_t size) {
    const uint64_t left = c->size - c->at;
    if (c->bad || size > left || (size + PADDING - 1) / PADDING * PADDING > left)
        c->bad = true;
    else
        c->at += (size_t)((size + PADDING - 1) / PADDING * PADDING);
}

static void skip_name(cursor* c) {
    skip(c, take(c, c->count_size));
}

static uint64_t type_size(uint64_t type) {
    static const uint8_t sizes[TYPES] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    return type < TYPES ? sizes[type] : 0;
}

static uint64_t take_list(cursor* c) {
    take(c, sizeof(uint32_t)); /* the kind of the list */
    return take(c, c->count_size);
}

static void skip_attributes(cursor* c) {
    for (uint64_t count = take_list(c); count > 0 && !c->bad; --count) {
        skip_name(c);
        const uint64_t size = type_size(take(c, sizeof(uint32_t))), values = take(c, c->count_size);
        if (size > 0 && values > UINT64_MAX / 2 / size) c->bad = true;
        skip(c, values * size);
    }
}

/* End of the data of all variables: in double precision, which no count of a file overflows. */
typedef struct extent {
    double end, record_begin, record_size; /* of fixed data; of the first record; of a record without padding */
} extent;

static void take_variable(cursor* c, const double* lengths, uint64_t dimensions, extent* e) {
    skip_name(c);
    double bytes = 1;
    bool record = false;
    const uint64_t count = take(c, c->count_size);
    for (uint64_t d = 0; d < count && !c->bad; ++d) {
        const uint64_t dimension = take(c, c->count_size);
        if (dimension >= dimensions) c->bad = true;
        if (c->bad) return;
        record |= d == 0 && lengths[dimension] == 0;
        if (d > 0 || !record) bytes *= lengths[dimension];
    }
    skip_attributes(c);
    bytes *= (double)type_size(take(c, sizeof(uint32_t)));
    take(c, c->count_size); /* the padded size, which large variables do not have */
    const double begin = (double)take(c, c->offset_size);
    if (!record) {
        if (bytes > 0 && begin + bytes > e->end) e->end = begin + bytes;
        return;
    }
    e->record_size += bytes;
    if (e->record_begin == 0 || begin < e->record_begin) e->record_begin = begin;
}

static double find_end(ty_context* context, cursor* c) {
    const uint64_t records = take(c, c->count_size);
    const uint64_t streaming = c->count_size == sizeof(uint32_t) ? UINT32_MAX : UINT64_MAX;
    const uint64_t dimensions = take_list(c);
    extent e = {0};
    if (c->bad || dimensions > DIMENSIONS_MAX || dimensions > c->size) {
        c->bad = true;
        return 0;
    }
    double* lengths = ty_alloc_array(context, (size_t)dimensions, sizeof *lengths, true);
    if (lengths == NULL) return -1;
    for (uint64_t i = 0; i < dimensions && !c->bad; ++i) {
        skip_name(c);
        lengths[i] = (double)take(c, c->count_size);
    }
    skip_attributes(c);
    for (uint64_t count = take_list(c); count > 0 && !c->bad; --count) take_variable(c, lengths, dimensions, &e);
    ty_free_array(context, lengths, (size_t)dimensions, sizeof *lengths);
    if (records == 0 || records == streaming || e.record_size == 0) return e.end;
    const double end = e.record_begin + (double)records * e.record_size;
    return end > e.end ? end : e.end;
}

ty_result ty_netcdf_check_classic(const ty_netcdf_file* file) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_part(file->context, file->path, 0, HEADER_MAX, &bytes, &size);
    if (result != TY_OK) return result;
    const uint8_t version = size >= PADDING && memcmp(bytes, "CDF", 3) == 0 ? bytes[3] : 0;
    if (version == 1 || version == 2 || version == 5) {
        cursor c = {.bytes = bytes,
                    .size = size,
                    .at = PADDING,
                    .count_size = version == 5 ? sizeof(uint64_t) : sizeof(uint32_t),
                    .offset_size = version == 1 ? sizeof(uint32_t) : sizeof(uint64_t)};
        const double end = find_end(file->context, &c);
        if (end < 0)
            result = TY_ERROR_MEMORY;
        else if (c.bad)
            result = ty_fail(file->context, TY_ERROR_INPUT, "%s: the header is damaged or cut short", file->path);
        else if (end > (double)file->size)
            result = ty_fail(file->context, TY_ERROR_INPUT, "%s: cut short: %llu bytes of %.0f", file->path,
                             (unsigned long long)file->size, end);
    }
    ty_free_file(file->context, bytes, size);
    return result;
}
