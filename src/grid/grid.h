/* Grids: storage, dense or in blocks, and the table of local extremes for null-collision tracking. */
#ifndef TY_GRID_GRID_H
#define TY_GRID_GRID_H

#include "base/half.h"

#include <tyndall/grid.h>

/* Voxels per edge of a brick, one entry of the table of extremes. */
#define TY_BRICK 8
/* Maximum number of voxels along a side. */
#define TY_GRID_SIDE_MAX 16384

/* Voxels per edge of a block of a sparse grid, its logarithm, and voxels of a block. */
#define TY_GRID_BLOCK 8
#define TY_GRID_BLOCK_LOG2 3
#define TY_GRID_BLOCK_VOXELS 512

struct ty_mapping;

/* The table of a sparse grid: the number of the block that holds voxels [TY_GRID_BLOCK a, TY_GRID_BLOCK (a + 1)) of the
 * table, where voxel i of the grid is voxel i + shift of the table. Block 0 has one value throughout. */
typedef struct ty_grid_blocks {
    uint32_t* table; /* NULL: the grid is dense */
    int32_t size[3]; /* of the table, in blocks */
    int32_t shift[3];
    uint32_t count;             /* stored blocks */
    struct ty_mapping* mapping; /* the file that has the values; NULL: they are in memory */
    bool maps_tables;           /* the file has the table and the extremes, too */
} ty_grid_blocks;

struct ty_grid {
    ty_context* context;
    _Atomic int32_t owners;
    int32_t size[3];
    ty_grid_type type;
    bool placed;
    float background;
    float min, max;
    double mean;
    int64_t active; /* voxels that differ from the background */
    ty_affine index_to_local;
    void* values;               /* sparse: block after block, each x fastest */
    ty_grid_release_fn release; /* the values are borrowed; NULL: they are the grid's own */
    void* release_user;
    size_t voxels, stored; /* in the grid, and in memory */
    ty_grid_blocks blocks;
    /* Extremes of the trilinear function over brick (i, j, k), which spans index coordinates [-1 + TY_BRICK i, -1 +
     * TY_BRICK (i + 1)] etc.: pairs (min, max). The offset -1 accounts for trilinear interpolation reaching one voxel
     * outside the grid. */
    int32_t bricks[3];
    float* extremes;
};

/* Bytes per value. */
size_t ty_grid_value_size(ty_grid_type type);
size_t ty_grid_brick_count(const ty_grid* grid);

/* Takes ownership of values, an array from ty_alloc_array of exactly the voxels' bytes (or NULL for zeros); def->values
 * and def->release are ignored. values is freed on failure. */
ty_result ty_grid_adopt(ty_context* context, const ty_grid_def* def, void* values, ty_grid** out);

/* Replaces non-finite values, then computes the statistics and the bricks' extremes. */
ty_result ty_grid_measure(ty_grid* grid);

/* The grid of floats as halves, in the same storage. */
ty_result ty_grid_make_half(ty_context* context, const ty_grid* grid, ty_grid** out);

/* ---- sparse grids ---- */

/* True if voxels first..last, as far as they lie in the grid, are all in block 0, the value of which is stored; false
 * for dense grids. */
bool ty_grid_is_common(const ty_grid* grid, const int32_t first[3], const int32_t last[3], float* value);

/* True if TY_GRID_AUTO stores blocks, with the block of one value among them, in a table of `table` entries. */
bool ty_grid_saves_memory(ty_grid_type type, size_t voxels, size_t table, size_t blocks);
/* The table, all 0, for a grid of `size` voxels whose first voxel is `shift` voxels inside; NULL without memory. */
uint32_t* ty_grid_blocks_table(ty_context* context, const int32_t size[3], const int32_t shift[3],
                               ty_grid_blocks* blocks);
size_t ty_grid_table_count(const ty_grid_blocks* blocks);
/* Memory for the values of blocks->count blocks, or a file for them, which becomes blocks->mapping; NULL, with a
 * message, on failure, which is *result. */
void* ty_grid_blocks_values(ty_context* context, ty_grid_type type, bool paged, ty_grid_blocks* blocks,
                            ty_result* result);
/* Frees the values, which may be NULL, and the table. */
void ty_grid_free_blocks(ty_context* context, ty_grid_type type, ty_grid_blocks* blocks, void* values);
/* Takes ownership of a table and of values, blocks->count blocks; both are freed on failure. */
ty_result ty_grid_adopt_blocks(ty_context* context, const ty_grid_def* def, ty_grid_blocks* blocks, void* values,
                               ty_grid** out);

/* Properties of a grid that were measured when its file was written. */
typedef struct ty_grid_measured {
    float min, max;
    double mean;
    int64_t active;
} ty_grid_measured;

/* Takes ownership of blocks->mapping, which is closed on failure; table, values and extremes lie in it. */
ty_result ty_grid_adopt_mapping(ty_context* context, const ty_grid_def* def, const ty_grid_blocks* blocks,
                                const void* values, const float* extremes, const ty_grid_measured* measured,
                                ty_grid** out);

/* Storage of a grid in the making, and the part of it that is stored: the blocks that voxels [first, end) touch. The
 * voxels of other blocks have the value of block 0. */
typedef struct ty_grid_plan {
    ty_grid_storage storage; /* of a part: TY_GRID_SPARSE unless it is TY_GRID_PAGED */
    bool part;
    int32_t first[3], end[3];
} ty_grid_plan;

/* Blocks [first, end) along an axis of a grid of `size` voxels that a plan stores. */
void ty_grid_plan_blocks(const ty_grid_plan* plan, int axis, int32_t size, int32_t shift, int32_t* first, int32_t* end);
/* Rows [first, end) of each slice with such blocks. */
void ty_grid_plan_rows(const ty_grid_plan* plan, int32_t size, int32_t* first, int32_t* end);
/* The part of a grid, whose other blocks are not read. */
ty_result ty_grid_keep_part(ty_context* context, ty_grid* grid, const ty_grid_plan* plan, ty_grid** out);

/* Voxels slice by slice: stores the address of slices [first, first + count), as the grid stores them, which is valid
 * until the next call. */
typedef struct ty_slice_source {
    ty_result (*slices)(void* user, int32_t first, int32_t count, const void** values);
    void* user;
    int32_t row, rows; /* the first row that it stores of each slice, and their number; 0: all */
} ty_slice_source;

/* Creates a grid without ever having more in memory than it stores and eight slices of the source, which is read once
 * or twice, and of a part only where blocks are stored. lowest_outside: the background is ty_value_outside, of the
 * part.
 */
ty_result ty_grid_create_from_slices(ty_context* context, const ty_grid_def* def, const ty_grid_plan* plan,
                                     const ty_slice_source* source, bool lowest_outside, ty_grid** out);

/* Value outside of a placed grid: its lowest, which is air in Hounsfield units, but 0 if none is below. */
float ty_value_outside(ty_grid_type type, const void* values, size_t count);

#endif
