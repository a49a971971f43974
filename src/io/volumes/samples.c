/* Conversion of raw voxel samples. */
#include "io/volumes/samples.h"

#include "base/context.h"
#include "base/half.h"
#include "grid/grid.h"

#include <math.h>
#include <string.h>

static const struct {
    const char* name;
    size_t size;
} types[TY_SAMPLE_TYPES] = {
    [TY_SAMPLE_INT8] = {"int8", 1},     [TY_SAMPLE_UINT8] = {"uint8", 1},   [TY_SAMPLE_INT16] = {"int16", 2},
    [TY_SAMPLE_UINT16] = {"uint16", 2}, [TY_SAMPLE_INT32] = {"int32", 4},   [TY_SAMPLE_UINT32] = {"uint32", 4},
    [TY_SAMPLE_INT64] = {"int64", 8},   [TY_SAMPLE_UINT64] = {"uint64", 8}, [TY_SAMPLE_HALF] = {"half", 2},
    [TY_SAMPLE_FLOAT] = {"float", 4},   [TY_SAMPLE_DOUBLE] = {"double", 8},
};

ty_sample_type ty_sample_type_of(const char* name) {
    int type = 0;
    while (type < TY_SAMPLE_TYPES && strcmp(name, types[type].name) != 0) ++type;
    return (ty_sample_type)type;
}

const char* ty_sample_name(ty_sample_type type) {
    return types[type].name;
}

size_t ty_sample_size(ty_sample_type type) {
    return types[type].size;
}

ty_grid_type ty_sample_grid_type(ty_sample_type type) {
    return type == TY_SAMPLE_HALF || type == TY_SAMPLE_INT8 || type == TY_SAMPLE_UINT8 ? TY_GRID_F16 : TY_GRID_F32;
}

/* Loads an unsigned number of 1, 2, 4 or 8 bytes. */
static uint64_t load(const uint8_t* from, size_t size, bool swap) {
    uint64_t bits = 0;
    if (size == 1) return *from;
    if (size == sizeof(uint16_t)) {
        uint16_t narrow;
        memcpy(&narrow, from, size);
        return swap ? __builtin_bswap16(narrow) : narrow;
    }
    if (size == sizeof(uint32_t)) {
        uint32_t word;
        memcpy(&word, from, size);
        return swap ? __builtin_bswap32(word) : word;
    }
    memcpy(&bits, from, size);
    return swap ? __builtin_bswap64(bits) : bits;
}

static float float_of(uint64_t bits) {
    return ty_float_from_bits((uint32_t)bits);
}

static double double_of(uint64_t bits) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool must_swap(bool big_endian) {
    return big_endian != (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__);
}

double ty_sample_value(ty_sample_type type, bool big_endian, const uint8_t* from) {
    const uint64_t bits = load(from, types[type].size, must_swap(big_endian));
    switch (type) {
    case TY_SAMPLE_INT8: return (int8_t)bits;
    case TY_SAMPLE_INT16: return (int16_t)bits;
    case TY_SAMPLE_INT32: return (int32_t)bits;
    case TY_SAMPLE_INT64: return (double)(int64_t)bits;
    case TY_SAMPLE_HALF: return (double)ty_half_to_float((uint16_t)bits);
    case TY_SAMPLE_FLOAT: return (double)float_of(bits);
    case TY_SAMPLE_DOUBLE: return double_of(bits);
    default: return (double)bits;
    }
}

void ty_store_value(ty_grid_type type, void* values, size_t at, double value) {
    if (type == TY_GRID_F16)
        ((uint16_t*)values)[at] = ty_float_to_half((float)value);
    else
        ((float*)values)[at] = (float)value;
}

/* Converts a row of voxels `step` bytes apart by an expression of their bits. */
#define TY_CONVERT_ROW(size, output, expression)                                                                       \
    for (size_t i = 0; i < count; ++i) {                                                                               \
        const uint64_t bits = load(from + step * i, size, swap);                                                       \
        ((output*)to)[i] = expression;                                                                                 \
    }                                                                                                                  \
    break

static void convert_row(ty_sample_type type, bool swap, const uint8_t* from, size_t step, size_t count, void* to) {
    switch (type) {
    case TY_SAMPLE_INT8: TY_CONVERT_ROW(1, uint16_t, ty_float_to_half((int8_t)bits));
    case TY_SAMPLE_UINT8: TY_CONVERT_ROW(1, uint16_t, ty_float_to_half((uint8_t)bits));
    case TY_SAMPLE_INT16: TY_CONVERT_ROW(2, float, (int16_t)bits);
    case TY_SAMPLE_UINT16: TY_CONVERT_ROW(2, float, (uint16_t)bits);
    case TY_SAMPLE_INT32: TY_CONVERT_ROW(4, float, (float)(int32_t)bits);
    case TY_SAMPLE_UINT32: TY_CONVERT_ROW(4, float, (float)(uint32_t)bits);
    case TY_SAMPLE_INT64: TY_CONVERT_ROW(8, float, (float)(int64_t)bits);
    case TY_SAMPLE_UINT64: TY_CONVERT_ROW(8, float, (float)bits);
    case TY_SAMPLE_HALF: TY_CONVERT_ROW(2, uint16_t, (uint16_t)bits);
    case TY_SAMPLE_FLOAT: TY_CONVERT_ROW(4, float, float_of(bits));
    case TY_SAMPLE_DOUBLE: TY_CONVERT_ROW(8, float, (float)double_of(bits));
    case TY_SAMPLE_TYPES: break;
    }
}

/* Converts slices in turn, as ty_slice_source. */
typedef struct converter {
    ty_context* context;
    const ty_samples* samples;
    ty_grid_def def;
    int32_t row, rows;    /* those of each slice that are converted */
    const uint8_t* bytes; /* of their first sample */
    uint8_t* values;      /* of TY_GRID_BLOCK slices */
    uint8_t* to;
} converter;

/* Voxels of the rows of a slice. */
static size_t slice_voxels(const converter* c) {
    return (size_t)c->def.size[0] * (size_t)c->rows;
}

static void convert_slice(void* user, int64_t k, int32_t worker) {
    (void)worker;
    const converter* c = user;
    const ty_samples* samples = c->samples;
    const size_t sample = types[samples->type].size;
    const size_t voxels = slice_voxels(c), first = voxels * (size_t)k;
    const uint8_t* from = c->bytes + sample * samples->step * first;
    if (samples->slope == 0) {
        const size_t value = ty_grid_value_size(c->def.type);
        convert_row(samples->type, must_swap(samples->big_endian), from, sample * samples->step, voxels,
                    c->to + value * first);
        return;
    }
    float* to = (float*)(void*)c->to + first;
    for (size_t i = 0; i < voxels; ++i)
        to[i] = (float)(samples->slope *
                            ty_sample_value(samples->type, samples->big_endian, from + sample * samples->step * i) +
                        samples->intercept);
}

/* Converts slices whose rows follow one another in the file. */
static ty_result convert_run(converter* c, int32_t first, int32_t count) {
    const ty_samples* samples = c->samples;
    const size_t sample = types[samples->type].size, width = (size_t)c->def.size[0];
    const size_t voxel = width * ((size_t)c->row + (size_t)c->def.size[1] * (size_t)first);
    const size_t at = sample * (samples->first + samples->step * voxel);
    const size_t bytes = sample * (samples->step * (slice_voxels(c) * (size_t)count - 1) + 1);
    ty_result result = TY_OK;
    if (samples->read != NULL)
        result = samples->read(samples->user, at, bytes, &c->bytes);
    else
        c->bytes = samples->bytes + at;
    if (result == TY_OK) ty_parallel_for(c->context, count, convert_slice, c);
    return result;
}

static ty_result convert_slices(void* user, int32_t first, int32_t count, const void** values) {
    converter* c = user;
    const size_t slice = slice_voxels(c) * ty_grid_value_size(c->def.type);
    const int32_t run = c->rows == c->def.size[1] ? count : 1;
    ty_result result = TY_OK;
    for (int32_t k = 0; k < count && result == TY_OK; k += run) {
        c->to = c->values + slice * (size_t)k;
        result = convert_run(c, first + k, run);
    }
    *values = c->values;
    return result;
}

ty_result ty_samples_make_grid(ty_context* context, const ty_samples* samples, const ty_grid_def* def, ty_grid** out) {
    converter c = {.context = context, .samples = samples, .def = *def};
    c.def.type = samples->slope != 0 ? TY_GRID_F32 : ty_sample_grid_type(samples->type);
    ty_grid_plan_rows(&samples->plan, def->size[1], &c.row, &c.rows);
    c.rows -= c.row;
    const size_t slices = (size_t)(def->size[2] < TY_GRID_BLOCK ? def->size[2] : TY_GRID_BLOCK);
    const size_t count = slices * slice_voxels(&c), value = ty_grid_value_size(c.def.type);
    c.values = ty_alloc_array(context, count, value, false);
    if (c.values == NULL) return TY_ERROR_MEMORY;
    const ty_slice_source source = {convert_slices, &c, c.row, c.rows};
    const ty_result result = ty_grid_create_from_slices(context, &c.def, &samples->plan, &source, def->placed, out);
    ty_free_array(context, c.values, count, value);
    return result;
}
