/* Light on cells from a coarse solve, as one method hands it to another. */
#ifndef TY_METHOD_CELL_LIGHT_H
#define TY_METHOD_CELL_LIGHT_H

#include "direct/media/grid_medium.h"

/* Means over the cells of a box, x fastest, in luminance, W m^-2: of light that scattered and of light that did not. */
typedef struct ty_cell_light {
    ty_context* context;
    size_t cells;
    float* fluence;
    float* flux[3];
} ty_cell_light;

/* The light of a committed scene with media on the cells of a box, by method dom with few directions and cells. Cells
 * outside of its media are dark. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_dom_cell_light(const ty_scene* scene, const ty_grid_box* box, uint64_t seed, ty_cell_light* out);
void ty_cell_light_free(ty_cell_light* light);

#endif
