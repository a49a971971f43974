/* Fields whose plain interpolation has the means that cells hold. */
#ifndef TY_IMAGE_DECONVOLVE_H
#define TY_IMAGE_DECONVOLVE_H

#include "image/march/cuts.h"

/* Trilinear interpolation between the centers of cells is smoother than the field whose means the cells are: its
 * means over cells have 1/8 of either neighbour along each axis. Replaces cells by values that are interpolated to
 * means close to what they were. cells: `floats` of each, of which the first `terms` * n for n channels are the terms
 * of a source field, as ty_upsample_view has them; used: how many these are. Values at least 0 stay so in the first
 * term. cuts: faces across which nothing is interpolated; NULL: none. at_face: nonzero for cells whose values are no
 * means and stay; NULL: none. Errors: TY_ERROR_MEMORY. */
ty_result ty_deconvolve_means(ty_context* context, const int32_t size[3], int32_t floats, int32_t terms, int32_t used,
                              const ty_cuts* cuts, const uint8_t* at_face, float* cells);

#endif
