/* Traversal of a medium's cells along a ray (3D DDA). */
#ifndef TY_DIRECT_MEDIA_CELL_RAY_H
#define TY_DIRECT_MEDIA_CELL_RAY_H

#include "direct/media/grid_medium.h"

#include <math.h>

typedef struct ty_cell_ray {
    double at, end;              /* current and last distance, m along the ray */
    double next[3], per_cell[3]; /* distance to the next cell boundary along each axis, and between boundaries, m */
    int32_t cell[3], step[3];
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
        ray->cell[a] = cell < 0 ? 0 : cell > last ? last : cell;
        ray->step[a] = omega[a] > 0 ? 1 : -1;
        const double edge = medium->box.lower[a] + side * (ray->cell[a] + (omega[a] > 0 ? 1 : 0));
        ray->next[a] = omega[a] != 0 ? (edge - origin[a]) / omega[a] : INFINITY;
        ray->per_cell[a] = omega[a] != 0 ? side / fabs(omega[a]) : INFINITY;
    }
}

/* Distance at which the ray leaves its cell or ends. */
static inline double ty_cell_ray_leave(const ty_cell_ray* ray) {
    return ty_cell_min(ray->end, ty_cell_min(ray->next[0], ty_cell_min(ray->next[1], ray->next[2])));
}

static inline size_t ty_cell_ray_index(const ty_grid_medium* medium, const ty_cell_ray* ray) {
    const size_t row = (size_t)ray->cell[1] + (size_t)medium->box.size[1] * (size_t)ray->cell[2];
    return (size_t)ray->cell[0] + (size_t)medium->box.size[0] * row;
}

/* Advances to the next cell; false past the box or the end. */
static inline bool ty_cell_ray_advance(const ty_grid_medium* medium, ty_cell_ray* ray) {
    const int xy = ray->next[0] < ray->next[1] ? 0 : 1;
    const int a = ray->next[xy] < ray->next[2] ? xy : 2;
    ray->at = ty_cell_max(ray->at, ray->next[a]);
    ray->next[a] += ray->per_cell[a];
    ray->cell[a] += ray->step[a];
    return ray->at < ray->end && ray->cell[a] >= 0 && ray->cell[a] < medium->box.size[a];
}

#endif
