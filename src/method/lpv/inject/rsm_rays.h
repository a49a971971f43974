/* Rays from lights through the texels of their maps, and the media along them. */
#ifndef TY_METHOD_LPV_INJECT_RSM_RAYS_H
#define TY_METHOD_LPV_INJECT_RSM_RAYS_H

#include "direct/media/cell_ray.h"
#include "method/lpv/inject/inject.h"
#include "method/lpv/inject/rsm_ray_kernel.h"

/* A medium on cells; homogeneous if all cells are equal. */
typedef struct ty_rsm_ray_medium {
    const ty_grid_medium* medium; /* NULL: vacuum */
    bool homogeneous;
    float lower[3], upper[3];
} ty_rsm_ray_medium;

typedef struct ty_rsm_ray_view {
    const ty_lpv_light* light;
    ty_rsm_face faces[6];
    ty_rsm_ray_medium medium;
    const ty_rsm_ray_kernels* kernels;
} ty_rsm_ray_view;

ty_rsm_ray_view ty_rsm_ray_view_of(const ty_lpv_light* light, const ty_grid_medium* medium);

/* The number of rows of all faces together. */
int64_t ty_rsm_row_count(const ty_lpv_light* light);

/* The rays of up to TY_RSM_RAYS texels of a row from x on, without jitter and the interval in the lattice. */
void ty_rsm_rays_at(const ty_rsm_ray_view* view, int64_t row, int32_t x, ty_rsm_rays* out);

/* Optical depth of ray i to its surface. */
void ty_rsm_ray_optical_depth(const ty_rsm_ray_medium* medium, const ty_rsm_rays* rays, int32_t i, float depth[3]);

/* ---- heterogeneous media ---- */

/* A traversal of the medium's cells along a ray. */
typedef struct ty_medium_walk {
    const ty_grid_medium* medium;
    ty_cell_ray cells;
    bool inside; /* whether there are cells ahead */
    double at;   /* m */
} ty_medium_walk;

typedef struct ty_medium_segment {
    float begin, length;                /* m */
    float extinction[3], scattering[3]; /* 1/m */
} ty_medium_segment;

ty_medium_walk ty_medium_walk_begin(const ty_grid_medium* medium, const ty_rsm_rays* rays, int32_t i);
/* The next segment with constant coefficients, ending at `to` at the latest; false at `to`. */
bool ty_medium_walk_step(ty_medium_walk* walk, double to, ty_medium_segment* out);

#endif
