/* Merged grid of all ordinates' light, aligned with the medium: Sec. 5.3 (Elek 2014); isotropic residuum: Sec. 5.4. */
#ifndef TY_METHOD_POP_MERGE_H
#define TY_METHOD_POP_MERGE_H

#include "method/pop/grid.h"

/* Cells of the medium's box; one array per channel. */
typedef struct ty_pop_merged {
    ty_grid_box box;
    float* accumulated_radiance[3]; /* radiance scattered towards the eye per scattering coefficient, L_acc, W m^-2
                                       sr^-1 */
    float* fluence[3];              /* in forward lobes (propagated modes: of all light), W m^-2 */
    float* unpropagated[3];         /* fluence not yet propagated, in the residuum's cells; else NULL */
} ty_pop_merged;

/* Adds the lights' radiance and fluence at the centers of merged cells, on all threads. The order of lights changes
 * only rounding. */
void ty_pop_merge(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged);

/* Box of the residuum's cells. They have the RMS spacing of the lights' own grids along each axis, because the
 * random walk advances one cell per step and its diffusion coefficient is proportional to the mean squared spacing.
 * Their number is that of the lights' grids or more, to hold the medium's box at their center. */
ty_grid_box ty_pop_residuum_box(const ty_grid_box* medium, const ty_pop_light* lights, int32_t count);

/* Deposits the lights' unpropagated fluence on the cells around the centers of theirs (trilinear, conservative), in
 * `unpropagated`. */
void ty_pop_residuum_deposit(ty_context* context, const ty_pop_light* lights, int32_t count, ty_pop_merged* merged);

/* Propagates the residuum as isotropic light, a sixth to each neighbour, until the fraction `tolerance` of its initial
 * light remains or `iterations` are done. Light that passes through a cell is added to its fluence and, over 4 pi,
 * to its radiance. medium: any resolution; it is empty outside its box. Returns the iterations, -1 if memory runs
 * out; *left: the fraction that remains. */
int32_t ty_pop_residuum(ty_context* context, const ty_grid_medium* medium, double tolerance, int32_t iterations,
                        ty_pop_merged* merged, double* unpropagated);

/* Adds the radiance and fluence of one grid to another's, trilinearly. */
void ty_pop_merged_add(ty_context* context, const ty_pop_merged* from, ty_pop_merged* to);

#endif
