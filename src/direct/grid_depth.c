/* Rays from cell to cell. */
#include "direct/grid_depth.h"

typedef struct cell_ray {
    double at, end;              /* m along the ray */
    double next[3], per_cell[3]; /* where it leaves its cell along each axis, and how far it is through one, m */
    int32_t cell[3], step[3];
} cell_ray;

/* Cuts the ray to the box; false where it misses. */
static bool clip(const ty_grid_box* box, const double origin[3], const double way[3], cell_ray* ray) {
    for (int a = 0; a < 3; ++a) {
        if (way[a] == 0) {
            if (!(origin[a] >= box->lower[a] && origin[a] <= box->upper[a])) return false;
            continue;
        }
        const double low = (box->lower[a] - origin[a]) / way[a], high = (box->upper[a] - origin[a]) / way[a];
        ray->at = fmax(ray->at, fmin(low, high));
        ray->end = fmin(ray->end, fmax(low, high));
    }
    return ray->at < ray->end;
}

static void begin(const ty_grid_medium* medium, const double origin[3], const double way[3], cell_ray* ray) {
    for (int a = 0; a < 3; ++a) {
        const double side = medium->cell[a], from = (origin[a] + ray->at * way[a] - medium->box.lower[a]) / side;
        const int32_t last = medium->box.size[a] - 1, cell = (int32_t)floor(from);
        ray->cell[a] = cell < 0 ? 0 : cell > last ? last : cell;
        ray->step[a] = way[a] > 0 ? 1 : -1;
        const double edge = medium->box.lower[a] + side * (ray->cell[a] + (way[a] > 0 ? 1 : 0));
        ray->next[a] = way[a] != 0 ? (edge - origin[a]) / way[a] : INFINITY;
        ray->per_cell[a] = way[a] != 0 ? side / fabs(way[a]) : INFINITY;
    }
}

/* Moves on; false past the box. */
static bool advance(const ty_grid_medium* medium, cell_ray* ray) {
    const int xy = ray->next[0] < ray->next[1] ? 0 : 1;
    const int a = ray->next[xy] < ray->next[2] ? xy : 2;
    ray->at = fmax(ray->at, ray->next[a]);
    ray->next[a] += ray->per_cell[a];
    ray->cell[a] += ray->step[a];
    return ray->at < ray->end && ray->cell[a] >= 0 && ray->cell[a] < medium->box.size[a];
}

void ty_grid_depth(const ty_grid_medium* medium, float* const planes[3], ty_vec origin, ty_vec direction, float far,
                   float depth[3]) {
    const double from[3] = {(double)origin.x, (double)origin.y, (double)origin.z};
    const double way[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    const int32_t* size = medium->box.size;
    float* const* coefficient = planes != NULL ? planes : medium->extinction;
    double sum[3] = {0, 0, 0};
    cell_ray ray = {.end = (double)far};
    if (clip(&medium->box, from, way, &ray)) {
        begin(medium, from, way, &ray);
        do {
            const double leave = fmin(ray.end, fmin(ray.next[0], fmin(ray.next[1], ray.next[2])));
            const size_t at =
                (size_t)ray.cell[0] + (size_t)size[0] * ((size_t)ray.cell[1] + (size_t)size[1] * (size_t)ray.cell[2]);
            for (int32_t c = 0; c < medium->planes; ++c) sum[c] += fmax(0, leave - ray.at) * (double)coefficient[c][at];
        } while (advance(medium, &ray));
    }
    for (int c = 0; c < 3; ++c) depth[c] = (float)sum[medium->planes == 1 ? 0 : c];
}
