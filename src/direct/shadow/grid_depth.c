/* Rays through media on cells. */
#include "direct/shadow/grid_depth.h"

#include "direct/media/cell_ray.h"

void ty_grid_depth(const ty_grid_medium* medium, float* const planes[3], ty_vec origin, ty_vec direction, float far,
                   float depth[3]) {
    const double from[3] = {(double)origin.x, (double)origin.y, (double)origin.z};
    const double omega[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    float* const* coefficient = planes != NULL ? planes : medium->extinction;
    double sum[3] = {0, 0, 0};
    ty_cell_ray ray = {.end = (double)far};
    if (ty_cell_ray_clip(&medium->box, from, omega, &ray)) {
        ty_cell_ray_begin(medium, from, omega, &ray);
        do {
            const double leave = ty_cell_ray_leave(&ray);
            const size_t at = ty_cell_ray_index(medium, &ray);
            for (int32_t c = 0; c < medium->planes; ++c)
                sum[c] += ty_cell_max(0, leave - ray.at) * (double)coefficient[c][at];
        } while (ty_cell_ray_advance(medium, &ray));
    }
    for (int c = 0; c < 3; ++c) depth[c] = (float)sum[medium->planes == 1 ? 0 : c];
}
