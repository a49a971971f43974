/* Means of a density grid over cells with the same axes, by three one-dimensional filters instead of many lookups. */
#ifndef TY_DIRECT_MEDIA_ALIGNED_H
#define TY_DIRECT_MEDIA_ALIGNED_H

#include "direct/media/grid_medium.h"
#include "scene/media/medium.k.h"

enum { TY_ALIGNED_VOXELS = 20 };

/* Weights of the voxels along one axis in the mean over a cell's sample points. */
typedef struct ty_aligned_cell {
    int32_t first, count;
    float weight[TY_ALIGNED_VOXELS];
} ty_aligned_cell;

typedef struct ty_aligned {
    ty_aligned_cell* cells[3]; /* per axis; NULL: the grid is not aligned, or the density is not linear in it */
    float* scratch;            /* of all workers */
    size_t scratch_size;       /* floats of each worker */
} ty_aligned;

/* samples: points along a cell's sides, at most two per voxel and 16. Errors: TY_ERROR_MEMORY. */
ty_result ty_aligned_create(const ty_grid_medium* out, const ty_medium_view* medium, const int32_t samples[3],
                            ty_aligned* aligned);
void ty_aligned_destroy(const ty_grid_medium* out, ty_aligned* aligned);
/* Mean densities of row (y, z) of cells, in the worker's scratch. */
const float* ty_aligned_row(const ty_aligned* aligned, const ty_grid_medium* out, const ty_medium_view* medium,
                            int32_t y, int32_t z, int32_t worker);
/* The transpose of that: adds to the voxels, x fastest, the derivatives by the mean densities of row (y, z). */
void ty_aligned_spread_row(const ty_aligned* aligned, const ty_grid_medium* out, const ty_medium_view* medium,
                           int32_t y, int32_t z, const double* by_density, double* voxels);

#endif
