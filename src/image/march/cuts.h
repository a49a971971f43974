/* Surfaces between cells, as interpolation has to know them: where they keep cells apart, and of which of these a point
 * among them is. */
#ifndef TY_IMAGE_CUTS_H
#define TY_IMAGE_CUTS_H

#include "direct/surfaces/boundary_faces.h"
#include "image/march/cuts.k.h"

typedef struct ty_cuts {
    ty_context* context;
    int32_t size[3]; /* cells */
    size_t cells;
    int32_t count;    /* of cuts */
    int32_t* of_cell; /* as in ty_cuts_view */
    ty_cell_cut* cuts;
} ty_cuts;

/* Cuts where closed faces leave eight neighbouring cells in parts that no open faces join. box: whose cells they
 * are. *out is NULL where there are none; freed with ty_cuts_destroy. Errors: TY_ERROR_MEMORY. */
ty_result ty_cuts_find(ty_context* context, const ty_boundary_faces* walls, const ty_grid_box* box, ty_cuts** out);
void ty_cuts_destroy(ty_cuts* cuts);
/* True if there is a cut among a cell and its neighbours. */
bool ty_cuts_are_about(const ty_cuts* cuts, const int32_t at[3]);
/* True if open faces join two cells that are next to each other, corners included. */
bool ty_cuts_join(const ty_cuts* cuts, const int32_t at[3], const int32_t next[3]);
/* Of NULL: of no cuts. */
ty_cuts_view ty_cuts_get_view(const ty_cuts* cuts);

#endif
