/* Dense grids: storage, and the table of local extremes for null-collision tracking. */
#ifndef TY_GRID_GRID_H
#define TY_GRID_GRID_H

#include "base/half.h"

#include <tyndall/grid.h>

/* Voxels per edge of a brick, one entry of the table of extremes. */
#define TY_BRICK 8
/* Maximum number of voxels along a side. */
#define TY_GRID_SIDE_MAX 16384

struct ty_grid {
    ty_context* context;
    _Atomic int32_t owners;
    int32_t size[3];
    ty_grid_type type;
    bool placed;
    float background;
    float min, max;
    double mean;
    ty_affine index_to_local;
    void* values;
    ty_grid_release_fn release; /* the values are borrowed; NULL: they are the grid's own */
    void* release_user;
    size_t voxels;
    /* Extremes of the trilinear function over brick (i, j, k), which spans index coordinates [-1 + TY_BRICK i, -1 +
     * TY_BRICK (i + 1)] etc.: pairs (min, max). The offset -1 accounts for trilinear interpolation reaching one voxel
     * outside the grid. */
    int32_t bricks[3];
    float* extremes;
};

/* Bytes per value. */
size_t ty_grid_value_size(ty_grid_type type);

/* Takes ownership of values, an array from ty_alloc_array of exactly the voxels' bytes (or NULL for zeros); def->values
 * and def->release are ignored. values is freed on failure. */
ty_result ty_grid_adopt(ty_context* context, const ty_grid_def* def, void* values, ty_grid** out);

#endif
