/* Going through an ordinate's grid slab by slab. */
#ifndef TY_METHOD_POP_SLAB_H
#define TY_METHOD_POP_SLAB_H

#include "method/pop/grid_kernel.h"

/* columns may be filled in later. */
void ty_pop_slab_setup(const ty_pop_grid_kernels* kernels, const ty_grid_medium* medium, const ty_pop_columns* columns,
                       ty_pop_slab* slab);
/* Slab k of the grid, -1: what is before the first of a radial one, and the medium in it. */
void ty_pop_slab_enter(const ty_pop_grid_kernels* kernels, int32_t k, ty_pop_slab* slab);
/* Transmittances of 1, and through what is before the first slab. */
void ty_pop_transmittance_begin(const ty_pop_grid_kernels* kernels, int32_t orders, ty_pop_slab* slab,
                                ty_pop_transmittance* transmittance);
void ty_pop_look_setup(const ty_grid_medium* medium, const float eye[3], const ty_pop_light* light, ty_pop_look* look);

/* Split mode: a slab's share of `seen`, from R and what of it scatters towards the eye. */
void ty_pop_write_seen(const ty_pop_light* light, const ty_pop_slab* slab, const ty_pop_look* look, int32_t k);

/* Cells of a grid without a ring. */
size_t ty_pop_cells(const ty_pop_frame* frame);
/* The first of the floats of slab k in `seen`. */
float* ty_pop_seen_slab(const ty_pop_light* light, int32_t k);

#endif
