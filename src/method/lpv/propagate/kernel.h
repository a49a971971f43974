/* One iteration of propagation, built once per instruction set. */
#ifndef TY_METHOD_LPV_PROPAGATE_KERNEL_H
#define TY_METHOD_LPV_PROPAGATE_KERNEL_H

#include "base/dispatch.h"
#include "base/sh.k.h"
#include "method/lpv/lattice/link_directions.h"

#include <tyndall/lpv.h>

/* Cells that share one set of blocked links; rows are padded to whole blocks. */
enum { TY_LPV_BLOCK = 16 };

/* Memory layout of the propagated light, in floats: rows of cells, all terms of all channels of a row one after
 * another, with dark cells around the lattice. A row holds whole blocks and one more cell on either side. */
typedef struct ty_lpv_pitch {
    ptrdiff_t term, row, plane;
} ty_lpv_pitch;

/* The transfer functions G_j; for two bands also by the number of axes of a link, minus 1. */
typedef struct ty_lpv_link_functions {
    float band0[3], band1[3]; /* G_j0; each nonzero component of band 1 */
    float G[TY_LPV_LINKS][TY_SH_TERMS];
    float lobes[TY_LPV_LINKS][TY_SH_TERMS]; /* cosine lobes about the links, scaled to a first term of 1 */
} ty_lpv_link_functions;

/* Sums of first terms, per channel and lane: of the light that arrived, its absolute values, the part that goes on, the
 * part that surfaces absorb, and the part that leaves the lattice. */
enum { TY_LPV_ARRIVED, TY_LPV_SIZE, TY_LPV_GOES_ON, TY_LPV_BLOCKED, TY_LPV_LEFT, TY_LPV_SUMS };
typedef struct ty_lpv_lane_sums {
    _Alignas(64) float sums[3][TY_LPV_SUMS][TY_LPV_BLOCK];
} ty_lpv_lane_sums;

/* A row of cells, all channels. */
typedef struct ty_lpv_row {
    int32_t count, terms;
    ty_lpv_pitch pitch;
    const ty_lpv_link_functions* link_functions;
    const float*
        from;   /* light before the step, at the row's first cell and term, with the scattering operator applied */
    float* to;  /* light after the step, in the same layout */
    float* sum; /* accumulates both; NULL: not in this step */
    const float* scatter_factor[3][TY_LPV_BANDS_MAX]; /* per channel and band, padded to whole blocks */
    const uint8_t* const* transmission;               /* of all cells, per link */
    size_t first;                                     /* index of this row's first cell in it */
    const uint32_t* blocked_links;                    /* per block: bits of the blocked links; NULL: none */
    const float* albedo[3];                           /* of the row; NULL: blocked light is absorbed */
    float out[3][TY_SH_TERMS]; /* first term of the light that leaves the lattice through free links, per term of the
                                  cell: at the first cell, between, at the last cell */
    uint8_t leaves[3][TY_LPV_LINKS]; /* whether a link crosses the lattice's border: at the same three positions */
    bool border;                     /* whether cells other than the row's ends are at the border */
} ty_lpv_row;

typedef struct ty_lpv_kernels {
    /* Propagates a row and adds to the sums. */
    void (*step)(const ty_lpv_row* row, ty_lpv_lane_sums* sums);
} ty_lpv_kernels;
TY_DECLARE_KERNELS(ty_lpv_kernels);

#endif
