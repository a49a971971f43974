/* All ordinates' light in one grid along the medium's axes (Sec. 5.3), and the isotropic residuum in it (Sec. 5.4). */
#ifndef TY_METHOD_POP_MERGE_H
#define TY_METHOD_POP_MERGE_H

#include "method/pop/grid.h"

/* Cells of the medium's box; per channel an array each. */
typedef struct ty_pop_merged {
    ty_grid_box box;
    float* seen[3];    /* radiance that scatters towards the eye per scattering coefficient, W m^-2 sr^-1 */
    float* fluence[3]; /* of light that keeps its direction (propagated: of all light), W m^-2 */
    float* left[3];    /* not passed on yet: of the residuum's cells; else NULL */
} ty_pop_merged;

/* Adds what is seen of lights and their fluence, at the middles of cells, on all threads; the order of lights decides
 * nothing but rounding. */
void ty_pop_merge(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged);

/* The box of the residuum's cells. Light that moves one cell a step gets as far as its cells are large, and what goes
 * through cells counts once a step: so these are, along each axis, as large as the lights' own cells in the mean (of
 * squares: it is what diffusion goes by), and as many as theirs, or as it takes to hold the medium's box in their
 * middle. */
ty_grid_box ty_pop_residuum_box(const ty_grid_box* medium, const ty_pop_light* lights, int32_t count);

/* Shares out what lights have not passed on among the cells beside the middles of theirs, all of it: adds to left. */
void ty_pop_residuum_take(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged);

/* Passes on what is left as isotropic light, a sixth to each neighbour, until `least` of what there was at first is
 * left or `iterations` are done; adds what went through cells to fluence and, over 4 pi, to seen. medium: any cells;
 * there is none outside its box. Returns the iterations; *left: what is left of what there was. Errors: TY_ERROR_MEMORY
 * as -1. */
int32_t ty_pop_residuum(ty_context* context, const ty_grid_medium* medium, double least, int32_t iterations,
                        ty_pop_merged* merged, double* left);

/* Adds seen and fluence of one grid to another's, between the middles of cells. */
void ty_pop_merged_add(ty_context* context, const ty_pop_merged* from, ty_pop_merged* to);

#endif
