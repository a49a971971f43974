/* Columns of a grid: rays along the incident light, a block at a time, with the medium and surfaces along them. */
#ifndef TY_METHOD_POP_GRID_COLUMNS_H
#define TY_METHOD_POP_GRID_COLUMNS_H

#include "method/pop/grid/grid.h"

enum { TY_POP_BLOCK = 256, /* at least TY_POP_CELLS_MAX */ TY_POP_RAYS = 4 };

/* Columns first..first + count of a grid: whole rows, in cell order. Distances along them, m, start at the grid's
 * first cells (parallel) or at its point (radial). */
typedef struct ty_pop_columns {
    const ty_pop_grid* grid;
    int32_t first, count;
    int32_t shaded;                   /* nonzero if hit[] is set */
    int32_t inverse_square;           /* nonzero for a point light in a parallel grid, whose light falls as 1 / r^2 */
    float light_position[3];          /* the point light, m from the medium's lower corner */
    int32_t cell[TY_POP_BLOCK];       /* index in a slice with ghost cells */
    float base[3][TY_POP_BLOCK];      /* origin of the column, m from the medium's lower corner */
    float direction[3][TY_POP_BLOCK]; /* unit */
    float enter[TY_POP_BLOCK];        /* distances to the medium's box, m; both 0 if the column misses it */
    float leave[TY_POP_BLOCK];
    float profile[TY_POP_BLOCK];          /* angular profile of the light's intensity */
    float across[TY_POP_BLOCK];           /* cross section of a column: m^2; in radial grids its solid angle, sr */
    float hit[TY_POP_RAYS][TY_POP_BLOCK]; /* distances of shadow rays to the first surface, m */
} ty_pop_columns;

/* scene: for light profiles and shadows; NULL if neither is needed. */
void ty_pop_columns_begin(const ty_scene* scene, const ty_grid_medium* medium, const ty_pop_light* light, int32_t first,
                          ty_pop_columns* columns);

/* Distance at which slab k begins, m along columns. k = -1: the columns' origin. */
float ty_pop_slab_begin(const ty_pop_grid* grid, int32_t k);

/* Fills the ghost cells of `accumulated` in radial grids. */
void ty_pop_fill_ghost_cells(const ty_pop_light* light);

#endif
