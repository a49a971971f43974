/* OpenVDB files in two halves: vdb_file.c reads the container (grids, statistics, transforms) and checks every size
 * inside a tree, so that OpenVDB, which trusts what it reads, only ever meets trees that are whole; vdb.cpp alone
 * sees OpenVDB and turns trees into dense arrays and back. */
#ifndef TY_IO_VDB_H
#define TY_IO_VDB_H

#include <tyndall/grid.h>
#include <tyndall/io.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { TY_VDB_NAME_SIZE = 128 };

typedef struct ty_vdb_grid {
    char name[TY_VDB_NAME_SIZE];   /* "density", or "density[1]" for the second of two alike */
    char type[TY_VDB_NAME_SIZE];   /* "Tree_float_5_4_3" */
    char parent[TY_VDB_NAME_SIZE]; /* the grid whose tree this one shares, or "" */
    bool half;
    uint32_t compression;
    bool has_statistics; /* whether the next three are known */
    int64_t active_voxels;
    int32_t lower[3], upper[3];
    bool affine; /* whether index_to_world is known; frustum maps are not affine */
    ty_affine index_to_world;
    uint64_t tree, end; /* where the tree begins and the grid ends; tree is 0 when the map is not affine */
} ty_vdb_grid;

typedef struct ty_vdb_file {
    ty_context* context;
    const char* path;
    void* stream; /* a FILE */
    uint64_t size;
    uint32_t version, library[2];
    ty_vdb_grid* grids;
    size_t count, capacity;
} ty_vdb_file;

/* Reads what the file holds, without any tree. */
ty_result ty_vdb_open(ty_context* context, const char* path, ty_vdb_file* file);
void ty_vdb_close(ty_vdb_file* file);
/* Walks the tree of a float or double grid (value_size 4 or 8) and checks every count and length in it. */
ty_result ty_vdb_check_tree(const ty_vdb_file* file, const ty_vdb_grid* grid, size_t value_size);

/* A tree made dense over its active box. */
typedef struct ty_vdb_dense {
    int32_t lower[3], size[3];
    ty_grid_type type;
    float background;
    void* values; /* from ty_alloc_array */
} ty_vdb_dense;

/* OpenVDB's part; trees must have been checked. */
ty_result ty_openvdb_read(const ty_vdb_file* file, const ty_vdb_grid* grid, ty_vdb_dense* dense);
/* Fills in a grid's statistics from its topology. */
ty_result ty_openvdb_measure(const ty_vdb_file* file, ty_vdb_grid* grid);
/* Whether a compressed block with its byte count (blosc, else zip) unpacks to raw bytes. */
bool ty_openvdb_decodes(bool blosc, const void* block, size_t size, size_t raw);
/* Writes to the file named temporary, which exists; path is for messages. */
ty_result ty_openvdb_write(ty_context* context, const ty_grid* grid, const char* name, const char* codec,
                           const char* path, const char* temporary);

#ifdef __cplusplus
}
#endif
#endif
