/* First-collision sources of cells that surfaces cut. */
#ifndef TY_DIRECT_SURFACES_CUT_CELLS_H
#define TY_DIRECT_SURFACES_CUT_CELLS_H

#include "direct/single/single.k.h"
#include "direct/surfaces/boundary_faces.h"

/* A source on the cells of closed faces, and the uncollided light on finer cells that it was averaged from. */
typedef struct ty_cut_source {
    const ty_boundary_faces* faces;
    double cell[3];                 /* edges of the faces' cells, m */
    ty_grid_box fine_box;           /* of the same extent */
    const ty_light_fluence* lights; /* on the cells of fine_box */
    int32_t light_count;
    int32_t channels; /* 1 or 3 */
    size_t terms;     /* planes of each channel */
    size_t cells;     /* of one plane */
    float* source[3];
} ty_cut_source;

/* Moves the part of a cell's source that is behind a surface to the cell there, and removes that between a surface and
 * the box's own face. Errors: TY_ERROR_MEMORY. */
ty_result ty_cut_cells_correct(ty_context* context, const ty_cut_source* source);

#endif
