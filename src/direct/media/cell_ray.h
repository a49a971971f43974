/* Traversal of a medium's cells along a ray (3D DDA). */
#ifndef TY_DIRECT_MEDIA_CELL_RAY_H
#define TY_DIRECT_MEDIA_CELL_RAY_H

#include "base/voxel_dda.h"
#include "direct/media/grid_medium.h"

typedef struct ty_cell_ray {
    double at, end; /* current and last distance, m along the ray */
    ty_voxel_dda dda;
} ty_cell_ray;

/* fmin and fmax without NaN handling, which the compiler inlines. */
static inline double ty_cell_min(double a, double b) {
    return a < b ? a : b;
}

static inline double ty_cell_max(double a, double b) {
    return a > b ? a : b;
}

/* Clips the ray's range [at, end] to the box; false where it misses. */
static inline bool ty_cell_ray_clip(const ty_grid_box* box, const double origin[3], const double omega[3],
                                    ty_cell_ray* ray) {
    for (int a = 0; a < 3; ++a) {
        if (omega[a] == 0) {
            if (!(origin[a] >= box->lower[a] && origin[a] <= box->upper[a])) return false;
            continue;
        }
        const double low = (box->lower[a] - origin[a]) / omega[a], high = (box->upper[a] - origin[a]) / omega[a];
        ray->at = ty_cell_max(ray->at, ty_cell_min(low, high));
        ray->end = ty_cell_min(ray->end, ty_cell_max(low, high));
    }
    return ray->at < ray->end;
}

/* Initialises the traversal at the ray's first point, which is in the box. */
static inline void ty_cell_ray_begin(const ty_grid_medium* medium, const double origin[3], const double omega[3],
                                     ty_cell_ray* ray) {
    for (int a = 0; a < 3; ++a) {
        const double side = medium->cell[a], from = (origin[a] + ray->at * omega[a] - medium->box.lower[a]) / side;
        const int32_t last = medium->box.size[a] - 1, cell = (int32_t)floor(from);
        const int32_t inside = cell < 0 ? 0 : cell > last ? last : cell;
        const double low = medium->box.lower[a] + side * inside, high = medium->box.lower[a] + side * (inside + 1);
        ty_voxel_dda_set(&ray->dda, a, inside, omega[a], low - origin[a], high - origin[a], side);
    }
}

/* Distance at which the ray leaves its cell or ends. */
static inline double ty_cell_ray_leave(const ty_cell_ray* ray) {
    return ty_cell_min(ray->end, ray->dda.next[ty_voxel_dda_axis(&ray->dda)]);
}

static inline size_t ty_cell_ray_index(const ty_grid_medium* medium, const ty_cell_ray* ray) {
    const int32_t* cell = ray->dda.voxel;
    const size_t row = (size_t)cell[1] + (size_t)medium->box.size[1] * (size_t)cell[2];
    return (size_t)cell[0] + (size_t)medium->box.size[0] * row;
}

/* Advances to the next cell; false past the box or the end. */
static inline bool ty_cell_ray_advance(const ty_grid_medium* medium, ty_cell_ray* ray) {
    const int a = ty_voxel_dda_axis(&ray->dda);
    ray->at = ty_cell_max(ray->at, ray->dda.next[a]);
    ty_voxel_dda_advance(&ray->dda, a);
    return ray->at < ray->end && ray->dda.voxel[a] >= 0 && ray->dda.voxel[a] < medium->box.size[a];
}

#endif
