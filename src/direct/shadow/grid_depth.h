/* Optical depth along rays through media on cells. */
#ifndef TY_DIRECT_SHADOW_GRID_DEPTH_H
#define TY_DIRECT_SHADOW_GRID_DEPTH_H

#include "base/vector.k.h"
#include "direct/media/grid_medium.h"

/* Integrals of planes (as many as the medium has; NULL: its extinction) over [0, far] of a ray with unit direction,
 * from cell to cell, so exact for what cells hold. Channels are alike where there is one plane. */
void ty_grid_depth(const ty_grid_medium* medium, float* const planes[3], ty_vec origin, ty_vec direction, float far,
                   float depth[3]);

#endif
