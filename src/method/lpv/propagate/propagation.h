/* The state of a propagation. */
#ifndef TY_METHOD_LPV_PROPAGATE_PROPAGATION_H
#define TY_METHOD_LPV_PROPAGATE_PROPAGATION_H

#include "method/lpv/lattice/lattice.h"
#include "method/lpv/propagate/kernel.h"
#include "method/lpv/propagate/transfer.h"

/* Factors per cell, from ty_lpv_medium_step. */
enum { TY_FACTOR_SCATTER = 0, TY_FACTOR_LENGTH = 3, TY_FACTOR_FLUX = 4, TY_FACTOR_INJECTED = 5, TY_FACTORS = 8 };

/* Sums of first terms over a slab of cells or over all cells: see ty_lpv_lane_sums. */
typedef struct ty_lpv_sums {
    double arrived[3], size[3], goes_on[3], blocked[3], left[3];
} ty_lpv_sums;

typedef struct ty_lpv_propagation {
    ty_lattice* lattice;
    ty_lpv_mode mode;
    ty_lpv_transfer transfer;
    ty_lpv_link_functions link_functions;
    const ty_lpv_kernels* kernels;
    ty_lpv_pitch pitch;
    float* buffers;    /* memory of from, to and sum */
    size_t floats;     /* size of each of the three, including the border */
    float *from, *to;  /* light before and after a step, with the scattering operator applied */
    float* sum;        /* sum over all steps, with the counted part of the injected light; every other step adds two */
    bool adds;         /* whether this step adds to sum */
    bool entered;      /* whether there was inflow before the lattice's own light */
    int32_t blocks;    /* blocks of TY_LPV_BLOCK cells in a row */
    int32_t planes;    /* 1: the medium is equal in all channels */
    bool homogeneous;  /* whether the medium is homogeneous: factors hold one row */
    float* factors[3]; /* TY_FACTORS planes one after another, in rows of whole blocks */
    size_t factor_floats;    /* size of each plane */
    uint32_t* blocked_links; /* per block: bits of the blocked links into it; NULL: none */
    size_t blocked_link_count;
    int32_t batch;      /* slabs per task */
    ty_lpv_sums* slabs; /* per z */
} ty_lpv_propagation;

ty_result ty_lpv_propagation_create(ty_lattice* lattice, const ty_lpv_def* def, ty_lpv_propagation* propagation);
void ty_lpv_propagation_destroy(ty_lpv_propagation* propagation);

/* Index of a row's first cell and term in from, to and sum; y and z from -1 to size (in sum: inside only). */
static inline size_t ty_lpv_propagation_index(const ty_lpv_propagation* propagation, int32_t y, int32_t z) {
    const ptrdiff_t place = (z + 1) * propagation->pitch.plane + (y + 1) * propagation->pitch.row;
    return (size_t)(place + TY_LPV_BLOCK);
}

/* A row of a factor of a channel. */
static inline const float* ty_lpv_propagation_factor(const ty_lpv_propagation* propagation, int32_t channel,
                                                     int32_t factor, int32_t y, int32_t z) {
    const size_t row = propagation->homogeneous ? 0 : (size_t)z * (size_t)propagation->lattice->box.size[1] + (size_t)y;
    return propagation->factors[channel < propagation->planes ? channel : 0] +
           (size_t)factor * propagation->factor_floats + row * (size_t)(propagation->blocks * TY_LPV_BLOCK);
}

/* The row that all others of a lattice begin as, and its move to (y, z): rows of a slab are visited with y ascending
 * from 0. */
ty_lpv_row ty_lpv_propagation_begin_row(const ty_lpv_propagation* propagation);
void ty_lpv_propagation_move_row(const ty_lpv_propagation* propagation, int32_t y, int32_t z, ty_lpv_row* row);

/* One step from `from` to `to`, which are then swapped. adds: whether both are added to sum. */
ty_lpv_sums ty_lpv_propagation_step(ty_lpv_propagation* propagation, bool adds);

/* Inflow of the outer cascade through the faces into the border cells; must be the first step. */
ty_lpv_sums ty_lpv_propagation_inflow(ty_lpv_propagation* propagation, const ty_lattice* outer);
/* Injects the lattice's own light; own_cell_sh: its part that counts in its own cell. */
ty_lpv_sums ty_lpv_propagation_inject(ty_lpv_propagation* propagation, float* const own_cell_sh[3][TY_SH_TERMS]);
/* Writes the propagated radiance to `light`, and the uncounted part of the injected light to propagated_sh. pending:
 * whether the last step is not in sum yet. */
void ty_lpv_propagation_gather(ty_lpv_propagation* propagation, float* const own_cell_sh[3][TY_SH_TERMS], bool pending);

#endif
