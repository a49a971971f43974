/* Isotropic residuum, Sec. 5.4 (Elek 2014): light that has lost its direction, propagated in one grid for all
 * ordinates. */
#ifndef TY_METHOD_POP_PUBLISHED_RESIDUUM_H
#define TY_METHOD_POP_PUBLISHED_RESIDUUM_H

#include "method/pop/merge/merge.h"

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
                        ty_pop_merged* merged, double* left);

#endif
