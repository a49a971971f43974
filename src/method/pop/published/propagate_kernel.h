/* Loops of the propagation between cells, compiled once per instruction set. */
#ifndef TY_METHOD_POP_PUBLISHED_PROPAGATE_KERNEL_H
#define TY_METHOD_POP_PUBLISHED_PROPAGATE_KERNEL_H

#include "method/pop/grid/grid_kernel.h"

/* Array counts of modes published and collided. Slices of cells have ghost cells, in which factors and light are 0. */
enum { TY_POP_PROPAGATION_PLANE_ARRAYS = 7, TY_POP_PROPAGATION_ARRAYS = 4, TY_POP_PROPAGATION_SLICES = 13 };

/* Factors of half a cell on light that enters or leaves it, along k and across: transmittance of absorption, and the
 * retained fraction of the mean cosine. */
typedef struct ty_pop_half_cells {
    const float *pass[2], *anisotropy_retained[2];
} ty_pop_half_cells;

/* Light that a slice of cells sends to its neighbours in front, beside and behind, and its first moments (light
 * times mean cosine). */
typedef struct ty_pop_outgoing {
    float *front, *side, *back, *front_moment, *side_moment, *back_moment;
} ty_pop_outgoing;

/* Initial light of a propagation in one slab. */
typedef struct ty_pop_initial_slab {
    int32_t collided; /* nonzero in mode collided, else mode published */
    int32_t plane;
    float across;      /* distance to the neighbour beside, relative to the slab's thickness */
    const float* mean; /* uncollided fluence, with surfaces' shadows */
    float light[TY_POP_BLOCK], next_g[TY_POP_BLOCK]; /* as in ty_pop_gather_slice */
    float pass[2][TY_POP_BLOCK], anisotropy_retained[2][TY_POP_BLOCK];
} ty_pop_initial_slab;

/* Accumulated light before the first iteration. */
typedef struct ty_pop_initial_cells {
    int32_t count, collided;
    float cosine; /* a_n */
    const float *uncollided, *light, *next_g, *two_one_minus_mu;
    float *cosines, *fluence, *accumulated_radiance;
} ty_pop_initial_cells;

typedef struct ty_pop_scatter_slice {
    int32_t count;
    ty_pop_half_cells half;
    const float *light, *cosine;
    ty_pop_outgoing out;
} ty_pop_scatter_slice;

typedef struct ty_pop_gather_slice {
    int32_t row;        /* cells of a row, ghosts included */
    int32_t begin, end; /* cell range; neighbours beside reach one row further */
    ty_pop_half_cells half;
    ty_pop_outgoing before, beside, after; /* slices k - 1, k, k + 1 */
    const float *two_one_minus_mu,
        *next_g; /* 2 (1 - mu) towards the eye; factor on the mean cosine for one more scattering, 1: none */
    float *light, *cosine;
    float *fluence, *accumulated_radiance; /* accumulated */
} ty_pop_gather_slice;

typedef struct ty_pop_propagation_kernels {
    void (*initial_slab)(const ty_pop_slab* slab, ty_pop_initial_slab* start);
    void (*initial_cells)(const ty_pop_initial_cells* begin);
    float (*sum)(const float* values, int32_t count);
    void (*scatter_to_neighbours)(const ty_pop_scatter_slice* slice);
    void (*gather_from_neighbours)(const ty_pop_gather_slice* slice);
} ty_pop_propagation_kernels;
TY_DECLARE_KERNELS(ty_pop_propagation_kernels);

#endif
