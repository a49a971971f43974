/* Sparse trees of OpenVDB and NanoVDB, leaves of 8^3 voxels and larger constant tiles, converted to grids. */
#ifndef TY_IO_SPARSE_H
#define TY_IO_SPARSE_H

#include "grid/grid.h"

enum {
    TY_LEAF_SIDE = 8,
    TY_LEAF_VOXELS = 512,
    TY_LOWER_SIDE = 128,  /* side of a lower inner node: 16^3 leaves */
    TY_UPPER_SIDE = 4096, /* side of an upper inner node: 32^3 lower nodes */
};

#define TY_SPARSE_TILE UINT64_MAX

/* A leaf, or a tile of one value. */
typedef struct ty_sparse_cell {
    int32_t origin[3], side;
    float value;
    uint64_t leaf; /* the reader's id of a leaf; TY_SPARSE_TILE: a tile */
} ty_sparse_cell;

/* Cells must not overlap; voxels without a cell have the background value. */
typedef struct ty_sparse {
    ty_context* context;
    const char *path, *name; /* of the file and the grid, for messages */
    ty_grid_type type;
    ty_grid_plan plan;  /* of the grid, of voxels of the active box; its storage is TY_GRID_AUTO or TY_GRID_PAGED */
    bool measures;      /* no cells are kept: active voxels and their box are what is wanted */
    int64_t keep[2][3]; /* of a part: cells that reach into [keep[0], keep[1]) are kept */
    float background;
    int64_t active;             /* active voxels */
    int32_t lower[3], upper[3]; /* box of active voxels, inclusive; lower > upper if there are none */
    uint64_t leaves;            /* that were added, also those that were not kept */
    ty_sparse_cell* cells;
    size_t count, capacity;
    int32_t (*roots)[3]; /* origins of the root's entries */
    size_t root_count, root_capacity;
} ty_sparse;

ty_sparse ty_sparse_begin(ty_context* context, const char* path, const char* name);
/* Begins anew with a tree that was measured, to keep the cells of a part of its active box. */
void ty_sparse_restart(ty_sparse* sparse);
void ty_sparse_end(ty_sparse* sparse);
/* All return false, with a message, if memory runs out. Root entries are added with their origin, a multiple of
 * TY_UPPER_SIDE, so that duplicates are detected. A leaf's mask has 64 bytes: bit 64 x + 8 y + z of a little-endian
 * number is the state of voxel (x, y, z). */
bool ty_sparse_add_root(ty_sparse* sparse, const int32_t origin[3]);
bool ty_sparse_add_tile(ty_sparse* sparse, const int32_t origin[3], int32_t side, bool active, float value);
bool ty_sparse_add_leaf(ty_sparse* sparse, const int32_t origin[3], const uint8_t* mask, uint64_t leaf);

/* Writes the 512 values of a leaf, voxel (x, y, z) at 64 x + 8 y + z, floats or halves by sparse->type; false if the
 * data is corrupt. Called from several threads. */
typedef bool (*ty_sparse_decode)(const void* user, uint64_t leaf, void* values);

/* Creates the grid of the active box, as sparse->plan says, placed by index_to_world; an empty grid gives one
 * voxel of background at 0. */
ty_result ty_sparse_make_grid(const ty_sparse* sparse, ty_sparse_decode decode, const void* user,
                              const ty_affine* index_to_world, ty_grid** out);

#endif
