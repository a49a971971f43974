/* A lamp at work, and the cells next to it. */
#ifndef TY_DIRECT_UNCOLLIDED_NEAR_CELLS_H
#define TY_DIRECT_UNCOLLIDED_NEAR_CELLS_H

#include "direct/uncollided/kernel.h"
#include "direct/uncollided/point_light.h"

typedef struct ty_point_light_job {
    const ty_scene_view* scene;
    const ty_grid_medium* medium;
    const ty_discrete_light* source;
    const ty_light_view* light;
    float* const* extinction;
    ty_point_light_target out;
    double lower[3], upper[3]; /* of the box, m from the lamp */
    int32_t home[3];           /* the lamp's cell; it may be outside the box */
    float lift;                /* m off the lamp's own surface, where shadow rays start */
    const ty_direct_kernels* kernels;
    float* scratch; /* of the workers */
    size_t scratch_size;
    ty_progress_meter* meter;
    double finished; /* of the work */
} ty_point_light_job;

/* How far a ray from the lamp goes before it meets a surface, m, at most `far`. */
float ty_point_light_visible_distance(const ty_point_light_job* lamp, ty_vec direction, float far);
/* Whether a cell is among those next to the lamp. */
bool ty_near_cells_contain(const ty_point_light_job* lamp, const int32_t cell[3]);
/* The range of such cells along an axis; it may reach beyond the box. */
void ty_near_cells_range(const ty_point_light_job* lamp, int32_t axis, int32_t range[2]);
/* Lights those, as far as they are in the box, by following rays. Errors: TY_ERROR_MEMORY. */
ty_result ty_near_cells_add(const ty_point_light_job* lamp);

#endif
