/* Merged grid of all ordinates' light, aligned with the medium: Sec. 5.3 (Elek 2014). */
#ifndef TY_METHOD_POP_MERGE_MERGE_H
#define TY_METHOD_POP_MERGE_MERGE_H

#include "direct/single/single.k.h"
#include "method/pop/grid/grid.h"

/* Edge of a box's cells along an axis, m. */
static inline double ty_pop_cell_edge(const ty_grid_box* box, int axis) {
    return (box->upper[axis] - box->lower[axis]) / box->size[axis];
}

/* Cells of the medium's box; one array per channel. */
typedef struct ty_pop_merged {
    ty_grid_box box;
    float* accumulated_radiance[3]; /* radiance scattered towards the eye per scattering coefficient, L_acc, W m^-2
                                       sr^-1 */
    float* fluence[3];              /* in forward lobes (propagated modes: of all light), W m^-2 */
    float* unpropagated[3];         /* fluence not yet propagated, in the residuum's cells; else NULL */
} ty_pop_merged;

/* Allocates zeros. with_unpropagated: with arrays of light not yet propagated. */
ty_result ty_pop_merged_create(ty_context* context, const ty_grid_box* box, bool with_unpropagated, ty_pop_merged* out);
void ty_pop_merged_destroy(ty_context* context, ty_pop_merged* merged);

/* Adds the lights' radiance and fluence at the centers of merged cells, on all threads. The order of lights changes
 * only rounding. */
void ty_pop_merge(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged);

/* Position of a cell's center among the cells of another box. Returns true if it lies inside. */
bool ty_pop_locate_center(const ty_grid_box* box, const int32_t cell[3], const ty_grid_box* other,
                          ty_cell_point* point);
/* Adds the radiance and fluence of one grid to another's, trilinearly. */
void ty_pop_merged_add(ty_context* context, const ty_pop_merged* from, ty_pop_merged* to);

#endif
