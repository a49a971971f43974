/* Traversal of an ordinate's grid slab by slab. */
#ifndef TY_METHOD_POP_GRID_SLAB_H
#define TY_METHOD_POP_GRID_SLAB_H

#include "method/pop/grid/grid_kernel.h"

/* The columns may be filled in later. */
void ty_pop_slab_setup(const ty_pop_grid_kernels* kernels, const ty_grid_medium* medium, const ty_pop_columns* columns,
                       ty_pop_slab* slab);
/* Enters slab k of the grid and samples its medium. k = -1: the segment before the first slab of a radial grid. */
void ty_pop_slab_enter(const ty_pop_grid_kernels* kernels, int32_t k, ty_pop_slab* slab);
/* Transmittances of 1, attenuated by the segment before the first slab. */
void ty_pop_transmittance_begin(const ty_pop_grid_kernels* kernels, int32_t orders, ty_pop_slab* slab,
                                ty_pop_transmittance* transmittance);
void ty_pop_eye_view_setup(const ty_grid_medium* medium, const float eye[3], const ty_pop_light* light,
                           ty_pop_eye_view* view);

/* Split mode: writes a slab's `accumulated` cells from R and the radiance towards the eye. */
void ty_pop_write_accumulated(const ty_pop_light* light, const ty_pop_slab* slab, const ty_pop_eye_view* view,
                              int32_t k);

/* Number of cells of a grid without ghosts. */
size_t ty_pop_cells(const ty_pop_grid* grid);
/* First float of slab k in `accumulated`. */
float* ty_pop_accumulated_slab(const ty_pop_light* light, int32_t k);

#endif
