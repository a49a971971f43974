/* Surfaces that the camera sees, traced or handed in by a caller. */
#ifndef TY_METHOD_LPV_VISIBLE_SURFACES_H
#define TY_METHOD_LPV_VISIBLE_SURFACES_H

#include "method/lpv/image/march_state.h"

/* Fills in the tile: the visible surface of each pixel and its emission; stores its distance and the depth and normal
 * channels. */
void ty_lpv_find_visible_surfaces(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom,
                                  ty_lpv_tile* tile);

#endif
