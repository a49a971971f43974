/* Raw voxel samples: ten types, either byte order, one of several components. */
#ifndef TY_IO_SAMPLES_H
#define TY_IO_SAMPLES_H

#include "grid/grid.h"

typedef enum ty_sample_type {
    TY_SAMPLE_INT8,
    TY_SAMPLE_UINT8,
    TY_SAMPLE_INT16,
    TY_SAMPLE_UINT16,
    TY_SAMPLE_INT32,
    TY_SAMPLE_UINT32,
    TY_SAMPLE_INT64,
    TY_SAMPLE_UINT64,
    TY_SAMPLE_HALF,
    TY_SAMPLE_FLOAT,
    TY_SAMPLE_DOUBLE,
    TY_SAMPLE_TYPES
} ty_sample_type;

/* "int8" ... "double"; TY_SAMPLE_TYPES for any other name. */
ty_sample_type ty_sample_type_of(const char* name);
const char* ty_sample_name(ty_sample_type type);
size_t ty_sample_size(ty_sample_type type);
/* Grid type that represents the samples exactly: half for half, int8 and uint8, else float. */
ty_grid_type ty_sample_grid_type(ty_sample_type type);

/* Value of the sample at `from`. */
double ty_sample_value(ty_sample_type type, bool big_endian, const uint8_t* from);

/* Stores a value among those of a grid. */
void ty_store_value(ty_grid_type type, void* values, size_t at, double value);

typedef struct ty_samples {
    const uint8_t* bytes;
    /* Reads size bytes, from `at` on, to an address that is valid until the next call; NULL: all are at `bytes`. */
    ty_result (*read)(void* user, size_t at, size_t size, const uint8_t** bytes);
    void* user;
    ty_sample_type type;
    bool big_endian;
    size_t first, step;      /* in samples: offset of the component, and stride between voxels */
    ty_grid_plan plan;       /* of the grid; its storage is TY_GRID_AUTO or TY_GRID_PAGED */
    double slope, intercept; /* a value is slope times its sample plus intercept; slope 0: the sample itself */
} ty_samples;

/* Creates a grid of def->size voxels, x fastest, placed by def: of ty_sample_grid_type, or float where samples are
 * scaled; as samples->plan says; rows outside of a part are not read. */
ty_result ty_samples_make_grid(ty_context* context, const ty_samples* samples, const ty_grid_def* def, ty_grid** out);

#endif
