/* Cells that surfaces hide from an eye. */
#ifndef TY_IMAGE_HIDDEN_CELLS_H
#define TY_IMAGE_HIDDEN_CELLS_H

#include "image/march/cuts.h"

/* State of a box's cells that surfaces hide from an eye; NULL without surfaces. The caller frees one byte per cell.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_hidden_cells_find(ty_context* context, const ty_scene* scene, const ty_grid_box* box, const double eye[3],
                               uint8_t** hidden);
/* Fills hidden cells of a plane from visible neighbours. cuts (NULL: none): surfaces that must not lie between them, as
 * interpolation respects these itself. A NULL hidden does nothing. */
void ty_hidden_cells_fill(ty_context* context, const ty_grid_box* box, const ty_cuts* cuts, const uint8_t* hidden,
                          float* plane);

#endif
