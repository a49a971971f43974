/* Surfaces behind media. */
#ifndef TY_METHOD_LPV_COMPOSITE_H
#define TY_METHOD_LPV_COMPOSITE_H

#include "method/lpv/image/march_state.h"

/* Interpolation weights of the four half-resolution rays around a pixel. */
void ty_lpv_find_upsample_weights(ty_lpv_march_state* state);
/* Adds surfaces behind media to the output planes. */
void ty_lpv_composite_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom);

#endif
