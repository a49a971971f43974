/* Columns of a grid: rays along which light comes, some at a time, and the medium and surfaces that they meet. */
#ifndef TY_METHOD_POP_COLUMNS_H
#define TY_METHOD_POP_COLUMNS_H

#include "method/pop/grid.h"

enum { TY_POP_BLOCK = 256, /* TY_POP_CELLS_MAX at least */ TY_POP_RAYS = 4 };

/* Columns first..first + count of a grid, whole rows, in order of cells. Lengths along them, m, begin at the grid's
 * first cells (parallel) or at its point (radial). */
typedef struct ty_pop_columns {
    const ty_pop_frame* frame;
    int32_t first, count;
    int32_t shaded;              /* whether there are hits */
    int32_t spreads;             /* whether light spreads from `lamp`, in a parallel grid */
    float lamp[3];               /* m from the medium's lower corner */
    int32_t cell[TY_POP_BLOCK];  /* in a slice of ringed cells */
    float base[3][TY_POP_BLOCK]; /* where lengths begin, m from the medium's lower corner */
    float way[3][TY_POP_BLOCK];  /* unit */
    float enter[TY_POP_BLOCK];   /* where the medium's box begins and ends; both 0: it is not met */
    float leave[TY_POP_BLOCK];
    float profile[TY_POP_BLOCK];          /* of intensity */
    float across[TY_POP_BLOCK];           /* what a column covers: m^2, of radial grids sr */
    float hit[TY_POP_RAYS][TY_POP_BLOCK]; /* how far rays near by get before they meet a surface */
} ty_pop_columns;

/* scene: what profiles and shadows need; NULL: neither is asked for. */
void ty_pop_columns_begin(const ty_scene* scene, const ty_grid_medium* medium, const ty_pop_light* light, int32_t first,
                          ty_pop_columns* columns);

/* Where slab k begins, m along columns; k = -1: where they do. */
float ty_pop_slab_begin(const ty_pop_frame* frame, int32_t k);

/* Fills the ring of `seen` of radial grids. */
void ty_pop_fill_ring(const ty_pop_light* light);

#endif
