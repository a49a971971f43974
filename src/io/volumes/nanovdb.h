/* NanoVDB files in three parts: nanovdb_file.c reads the container (segments and grid metadata) and decompresses
 * grids, nanovdb.c reads grids through the portable C header with every access checked, and nanovdb.cpp contains the
 * C++ library, which writes. */
#ifndef TY_IO_NANOVDB_H
#define TY_IO_NANOVDB_H

#include "io/file.h"

#include <tyndall/io.h>

#ifdef __cplusplus
extern "C" {
#endif

struct ty_mapping;

enum { TY_NANOVDB_NAME_SIZE = 128 };

typedef enum ty_nanovdb_codec { TY_NANOVDB_PLAIN = 0, TY_NANOVDB_ZIP = 1, TY_NANOVDB_BLOSC = 2 } ty_nanovdb_codec;

typedef struct ty_nanovdb_grid {
    char name[TY_NANOVDB_NAME_SIZE];
    uint32_t type; /* number in the format */
    int64_t active_voxels;
    int32_t lower[3], upper[3];
    double voxel_size[3];
    uint32_t codec;
    uint64_t at, stored_size, size; /* offset of the grid in the file, compressed bytes, decompressed bytes */
} ty_nanovdb_grid;

typedef struct ty_nanovdb_file {
    ty_context* context;
    const char* path;
    void* stream; /* a FILE */
    uint64_t size;
    ty_nanovdb_grid* grids;
    size_t count, capacity;
} ty_nanovdb_file;

ty_result ty_nanovdb_open(ty_context* context, const char* path, ty_nanovdb_file* file);
void ty_nanovdb_close(ty_nanovdb_file* file);
/* Reads the grid->size bytes of a grid, from ty_alloc_array. */
ty_result ty_nanovdb_load(const ty_nanovdb_file* file, const ty_nanovdb_grid* grid, uint8_t** bytes);
/* The same bytes in a mapping of the file, or of another one without a name where the grid is compressed. */
ty_result ty_nanovdb_map(const ty_nanovdb_file* file, const ty_nanovdb_grid* grid, struct ty_mapping** mapping,
                         const uint8_t** bytes);
ty_result ty_nanovdb_damaged(const ty_nanovdb_file* file, const char* what);

/* C++ part. Write errors are left to the output's commit. */
ty_result ty_nanovdb_build(ty_context* context, const ty_grid* grid, const char* name, bool zip, ty_output* output);

#ifdef __cplusplus
}
#endif
#endif
