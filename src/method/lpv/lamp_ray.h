/* Rays from lights through the texels of their maps, and media on the way. */
#ifndef TY_METHOD_LPV_LAMP_RAY_H
#define TY_METHOD_LPV_LAMP_RAY_H

#include "direct/media/cell_ray.h"
#include "method/lpv/inject.h"
#include "method/lpv/lamp_kernel.h"

/* A medium that light passes; where it is the same in all cells it is one. */
typedef struct ty_lamp_medium {
    const ty_grid_medium* medium; /* NULL: vacuum */
    bool even;
    float lower[3], upper[3];
} ty_lamp_medium;

typedef struct ty_lamp_view {
    const ty_lpv_lamp* lamp;
    ty_lamp_face faces[6];
    ty_lamp_medium medium;
    const ty_lamp_kernels* kernels;
} ty_lamp_view;

ty_lamp_view ty_lamp_view_of(const ty_lpv_lamp* lamp, const ty_grid_medium* medium);

/* Rows of all faces together. */
int64_t ty_lamp_rows(const ty_lpv_lamp* lamp);

/* The rays of up to TY_LAMP_RAYS texels of a row from x on, but for jitter and the stretch in the lattice. */
void ty_lamp_rays_at(const ty_lamp_view* view, int64_t row, int32_t x, ty_ray_row* out);

/* Optical depth of ray i up to its surface. */
void ty_cell_depth(const ty_lamp_medium* medium, const ty_ray_row* rays, int32_t i, float depth[3]);

/* ---- media that are not the same everywhere ---- */

/* A way along a ray, from one change of the medium to the next. */
typedef struct ty_lamp_walk {
    const ty_grid_medium* medium;
    ty_cell_ray cells;
    bool inside; /* whether cells are still ahead */
    double at;   /* m */
} ty_lamp_walk;

typedef struct ty_lamp_stretch {
    float begin, length;                /* m */
    float extinction[3], scattering[3]; /* 1/m */
} ty_lamp_stretch;

ty_lamp_walk ty_lamp_walk_begin(const ty_grid_medium* medium, const ty_ray_row* rays, int32_t i);
/* The next stretch, which ends at `to` at the latest; false once there. */
bool ty_lamp_walk_step(ty_lamp_walk* walk, double to, ty_lamp_stretch* out);

#endif
