/* The paper's propagation (modes published and collided): L_i and a_i from cell to cell of an ordinate's grid. */
#ifndef TY_METHOD_POP_PUBLISHED_PROPAGATE_H
#define TY_METHOD_POP_PUBLISHED_PROPAGATE_H

#include "method/pop/grid/grid.h"

/* Statistics of a propagation. */
typedef struct ty_pop_propagation_stats {
    double initial, unpropagated; /* fluence times volume, summed over cells and channels: initial, and not yet
                                     propagated at the end */
    double initial_seconds, propagation_seconds;
} ty_pop_propagation_stats;

/* Size in floats of the scratch memory of ty_pop_propagate; 0 in split mode. */
size_t ty_pop_scratch_floats(const ty_pop_grid* grid, const ty_pop_def* def, int32_t planes);
/* Runs `iterations` iterations of Eq. 1-8 (Elek 2014) from the initial light of def->mode. */
void ty_pop_propagate(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium, const float eye[3],
                      int32_t iterations, float* scratch, ty_pop_light* light, ty_pop_propagation_stats* stats);

/* Eq. 9-10 (Elek 2014): number of iterations after which the mean cosine falls from `cosine` to def->residuum, for
 * cells of length `step`, m; at least the number of cells along the direction. */
int32_t ty_pop_iteration_count(const ty_pop_def* def, const ty_grid_medium* medium, float cosine, float step);

#endif
