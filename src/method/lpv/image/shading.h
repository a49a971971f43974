/* Light that the visible surfaces reflect. */
#ifndef TY_METHOD_LPV_SHADING_H
#define TY_METHOD_LPV_SHADING_H

#include "method/lpv/image/march_state.h"

/* Adds the reflected direct light and the reflected light of the lattices to the radiance of a tile's pixels, and
 * stores it for the composite. */
void ty_lpv_shade_surfaces(ty_lpv_march_state* state, ty_lpv_tile* tile);

#endif
