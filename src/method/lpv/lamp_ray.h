/* Rays from lights through the texels of their maps, and media on the way. */
#ifndef TY_METHOD_LPV_LAMP_RAY_H
#define TY_METHOD_LPV_LAMP_RAY_H

#include "direct/cell_ray.h"
#include "method/lpv/inject.h"

typedef struct ty_lamp_ray {
    size_t texel;
    ty_vec origin, direction; /* unit */
    float length;             /* up to the surface, m; INFINITY: there is none */
    float power[3];           /* that the light sends along it, W */
} ty_lamp_ray;

/* Rows of all faces together. */
int64_t ty_lamp_rows(const ty_lpv_lamp* lamp);

/* The ray of texel x of a row; false: the light sends nothing there. */
bool ty_lamp_ray_at(const ty_lpv_lamp* lamp, int64_t row, int32_t x, ty_lamp_ray* out);

/* A medium that light passes; where it is the same in all cells it is one. */
typedef struct ty_lamp_medium {
    const ty_grid_medium* medium; /* NULL: vacuum */
    bool even;
} ty_lamp_medium;

ty_lamp_medium ty_lamp_medium_of(const ty_grid_medium* medium);

/* Optical depth up to a distance. */
void ty_lamp_depth(const ty_lamp_medium* medium, const ty_lamp_ray* ray, float far, float depth[3]);

/* A way along a ray, from one change of the medium to the next. */
typedef struct ty_lamp_walk {
    const ty_lamp_medium* medium;
    ty_cell_ray cells;
    bool inside; /* whether cells are still ahead */
    double at;   /* m */
} ty_lamp_walk;

typedef struct ty_lamp_stretch {
    float begin, length;                /* m */
    float extinction[3], scattering[3]; /* 1/m */
} ty_lamp_stretch;

ty_lamp_walk ty_lamp_walk_begin(const ty_lamp_medium* medium, const ty_lamp_ray* ray, float far);
/* The next stretch, which ends at `to` at the latest; false once there. */
bool ty_lamp_walk_step(ty_lamp_walk* walk, double to, ty_lamp_stretch* out);

#endif
