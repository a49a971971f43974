/* Parallel light through a grid that repeats along two axes. */
#ifndef TY_DIRECT_UNCOLLIDED_REPEATED_H
#define TY_DIRECT_UNCOLLIDED_REPEATED_H

#include "direct/uncollided/kernel.h"
#include "direct/media/grid_medium.h"

/* Tubes go around the grid: those that leave by one face come in by the opposite one. The light enters by the grid's
 * first or last cells along the third axis with transmittance 1. */
typedef struct ty_repeated_beam {
    const float* extinction; /* plane of the medium's cells, 1/m */
    ty_vec direction;
    int32_t plane_count;
    float* planes[TY_TUBE_PLANES_MAX]; /* mean transmittances are added to these, each times a factor */
    float factor[TY_TUBE_PLANES_MAX];
    double* through; /* out: mean transmittance at the faces across the third axis, of one layer of cells after the
                        other from the lowest face on; of each face of a cell, times |cos| of the direction; NULL: not
                        asked for */
} ty_repeated_beam;

/* The third axis: the one along which the medium does not repeat. Light along the layers never enters. */
int32_t ty_repeated_axis(const ty_grid_medium* medium);
/* Cells do as those of ty_collimated: what tubes lose is what cells absorb. Errors: TY_ERROR_MEMORY. */
ty_result ty_repeated_sweep(const ty_grid_medium* medium, const ty_repeated_beam* beam);

#endif
