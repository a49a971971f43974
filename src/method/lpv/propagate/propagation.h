/* Light on its way through a lattice: what steps work on. */
#ifndef TY_METHOD_LPV_PROPAGATION_H
#define TY_METHOD_LPV_PROPAGATION_H

#include "method/lpv/propagate/kernel.h"
#include "method/lpv/propagate/transfer.h"

/* Per cell, of ty_lpv_medium_step. */
enum { TY_FACTOR_SCATTER = 0, TY_FACTOR_LENGTH = 3, TY_FACTOR_FLUX = 4, TY_FACTOR_INJECTED = 5, TY_FACTORS = 8 };

/* Sums over a slab of cells, or over all, in first terms: see ty_lpv_lane_sums. */
typedef struct ty_lpv_sums {
    double arrived[3], size[3], goes_on[3], kept[3], left[3];
} ty_lpv_sums;

typedef struct ty_lpv_propagation {
    ty_lattice* lattice;
    ty_lpv_mode mode;
    ty_lpv_transfer transfer;
    ty_lpv_link_functions link_functions;
    const ty_lpv_kernels* kernels;
    ty_lpv_pitch pitch;
    float* buffers;          /* the memory of the following three */
    size_t floats;           /* of each of them, which begin before the first cell */
    float *from, *to;        /* what flows, with extinction applied, and the next */
    float* sum;              /* of all that flowed, injected light as far as it counts; every other step adds two */
    bool adds;               /* whether this step does */
    bool entered;            /* whether light of an outer lattice came in before the lattice's own */
    int32_t blocks;          /* of TY_LPV_BLOCK cells in a row */
    int32_t planes;          /* 1: media are alike in all channels */
    bool homogeneous;        /* media are the same everywhere: factors are of one row */
    float* factors[3];       /* TY_FACTORS after one another, rows of whole blocks */
    size_t factor_floats;    /* of each factor */
    uint32_t* blocked_links; /* per block: bits of the links into it that are not open; NULL: all are */
    size_t blocked_link_count;
    int32_t batch;      /* slabs that one thread takes at a time */
    ty_lpv_sums* slabs; /* per z */
} ty_lpv_propagation;

ty_result ty_lpv_propagation_create(ty_lattice* lattice, const ty_lpv_def* def, ty_lpv_propagation* propagation);
void ty_lpv_propagation_destroy(ty_lpv_propagation* propagation);

/* Where a row's first cell and term are in from, to and sum; y and z from -1 to size (sum: within). */
static inline size_t ty_lpv_propagation_index(const ty_lpv_propagation* propagation, int32_t y, int32_t z) {
    const ptrdiff_t place = (z + 1) * propagation->pitch.plane + (y + 1) * propagation->pitch.row;
    return (size_t)(place + TY_LPV_BLOCK);
}

/* A row of one of the factors of a channel. */
static inline const float* ty_lpv_propagation_factor(const ty_lpv_propagation* propagation, int32_t channel,
                                                     int32_t factor, int32_t y, int32_t z) {
    const size_t row = propagation->homogeneous ? 0 : (size_t)z * (size_t)propagation->lattice->box.size[1] + (size_t)y;
    return propagation->factors[channel < propagation->planes ? channel : 0] +
           (size_t)factor * propagation->factor_floats + row * (size_t)(propagation->blocks * TY_LPV_BLOCK);
}

/* One step of all light: from goes to `to`, and they change places. adds: whether both are added to sum. */
ty_lpv_sums ty_lpv_propagation_step(ty_lpv_propagation* propagation, bool adds);

/* Light of the outer lattice that comes in through the faces, as having arrived in the cells at the border. To be done
 * first. */
ty_lpv_sums ty_lpv_propagation_inflow(ty_lpv_propagation* propagation, const ty_lattice* outer);
/* The lattice's own light, which counts as far as `seen` says. */
ty_lpv_sums ty_lpv_propagation_inject(ty_lpv_propagation* propagation, float* const own_cell_sh[3][TY_SH_TERMS]);
/* What arrived as radiance into the lattice's light, and what does not count of what was injected. pending: whether the
 * last step did not add to sum. */
void ty_lpv_propagation_gather(ty_lpv_propagation* propagation, float* const own_cell_sh[3][TY_SH_TERMS], bool pending);

#endif
