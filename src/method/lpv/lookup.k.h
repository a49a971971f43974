/* Light between the cells of a lattice: of the eight around a point only those count that no surface separates from the
 * cell that the point lies in. */
#ifndef TY_METHOD_LPV_LOOKUP_K_H
#define TY_METHOD_LPV_LOOKUP_K_H

#include "method/lpv/lattice.h"

/* Cells around a point, with weights that add up to 1. */
typedef struct ty_lattice_cells {
    int32_t index[8];
    float weight[8];
} ty_lattice_cells;

#endif
