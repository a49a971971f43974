/* OpenVDB files in three parts: vdb_file.c reads the container (grids, statistics, transforms), vdb_tree.c reads
 * trees and validates every count and length, and vdb_write.c writes. */
#ifndef TY_IO_VDB_H
#define TY_IO_VDB_H

#include "io/file.h"
#include "io/volumes/sparse.h"

#include <tyndall/io.h>

#include <stdio.h>

#define TY_VDB_MAGIC 0x56444220

enum {
    TY_VDB_NAME_SIZE = 128,
    TY_VDB_UUID_SIZE = 36,
    TY_VDB_NODE_SLOTS_MAX = 32768, /* of an upper inner node */
};

/* Bits of a grid's compression. */
enum { TY_VDB_ZIP = 1, TY_VDB_ACTIVE_MASK = 2, TY_VDB_BLOSC = 4 };

typedef struct ty_vdb_grid {
    char name[TY_VDB_NAME_SIZE];   /* "density", or "density[1]" for the second grid of that name */
    char type[TY_VDB_NAME_SIZE];   /* "Tree_float_5_4_3" */
    char parent[TY_VDB_NAME_SIZE]; /* grid that owns the shared tree, or "" */
    bool half;
    uint32_t compression;
    bool has_statistics; /* true if the next three are known */
    int64_t active_voxels;
    int32_t lower[3], upper[3];
    bool affine; /* true if index_to_world is known; frustum maps are not affine */
    ty_affine index_to_world;
    uint64_t tree, end; /* file offsets of the tree and of the grid's end; tree is 0 if the map is not affine */
} ty_vdb_grid;

typedef struct ty_vdb_file {
    ty_context* context;
    const char* path;
    FILE* stream;
    uint64_t size;
    uint32_t version, library[2];
    ty_vdb_grid* grids;
    size_t count, capacity;
} ty_vdb_file;

/* Reads the container without any tree. */
ty_result ty_vdb_open(ty_context* context, const char* path, ty_vdb_file* file);
void ty_vdb_close(ty_vdb_file* file);
/* Reads the bytes of a grid's tree, from ty_alloc_array. */
ty_result ty_vdb_load(const ty_vdb_file* file, const ty_vdb_grid* grid, uint8_t** bytes, size_t* size);
ty_result ty_vdb_damaged(const ty_vdb_file* file, const char* what);

/* Value type of a tree; bytes is 0 for unsupported ones. */
typedef struct ty_vdb_value {
    uint32_t bytes;     /* of a component: 4 or 8 */
    int32_t components; /* 1, or 3 for vectors */
} ty_vdb_value;

ty_vdb_value ty_vdb_value_of(const ty_vdb_grid* grid);
/* Computes a grid's statistics from the topology of a tree. */
ty_result ty_vdb_measure(const ty_vdb_file* file, const ty_vdb_grid* owner, ty_vdb_grid* grid);
/* Reads one component of a tree, dense over its active box. */
ty_result ty_vdb_read_tree(const ty_vdb_file* file, const ty_vdb_grid* owner, int32_t component,
                           const ty_affine* index_to_world, const ty_grid_plan* plan, ty_grid** out);

/* Writes a file of a grid per field; codec is 0, TY_VDB_ZIP or TY_VDB_BLOSC. Write errors are left to the output's
 * commit. */
ty_result ty_vdb_write_file(ty_context* context, const ty_volume_field* fields, int32_t count, uint32_t codec,
                            ty_output* output);
/* The number of a codec by its name; false, with a message, for an unknown one. */
bool ty_vdb_find_codec(ty_context* context, const char* name, uint32_t* codec);

#endif
