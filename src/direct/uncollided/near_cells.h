/* The state of a point light's computation, and the cells next to the light. */
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
    double lower[3], upper[3]; /* of the box, m from the light */
    int32_t home[3];           /* the light's cell, which may be outside of the box */
    float lift;                /* offset of shadow rays from a surface light, m */
    const ty_direct_kernels* kernels;
    float* scratch; /* of all workers */
    size_t scratch_size;
    ty_part_progress* progress;
    double finished; /* fraction of the work */
} ty_point_light_job;

/* Places the box around the light. */
void ty_point_light_place(ty_point_light_job* point);
/* Distance to the first surface from the light, m, at most `far`. */
float ty_point_light_visible_distance(const ty_point_light_job* point, ty_vec direction, float far);
/* True if a cell is next to the light. */
bool ty_near_cells_contain(const ty_point_light_job* point, const int32_t cell[3]);
/* The range of the near cells along an axis; it may exceed the box. */
void ty_near_cells_range(const ty_point_light_job* point, int32_t axis, int32_t range[2]);
/* Adds the light of the near cells within the box. Errors: TY_ERROR_MEMORY. */
ty_result ty_near_cells_add(const ty_point_light_job* point);
/* Its adjoint for a medium of one plane: adds to `gradient` the derivatives by extinction of the sum over near cells of
 * weight times the light in it, which is volume times mean fluence over intensity. weight: of all cells of
 * the box. Adds that light to `light`. */
void ty_near_cells_return(const ty_point_light_job* point, const float* weight, float* gradient, float* light);

#endif
