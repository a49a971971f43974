/* One step of a lattice's light, built once per instruction set. */
#ifndef TY_METHOD_LPV_KERNEL_H
#define TY_METHOD_LPV_KERNEL_H

#include "base/dispatch.h"
#include "method/lpv/lattice.h"

/* Cells that have one flag for whether surfaces are near, and to which rows are filled up. */
enum { TY_LPV_BLOCK = 16 };

/* Where light on its way is: rows of cells with those of one channel's terms after one another, dark cells around the
 * lattice. Whole blocks and one cell more on either side are in a row. Counted in floats. */
typedef struct ty_lpv_pitch {
    ptrdiff_t term, row, plane;
} ty_lpv_pitch;

/* Links' shapes: of two bands also by how many axes they go along, less 1. */
typedef struct ty_lpv_shapes {
    float even[3], along[3]; /* first term; each component of the second band */
    float all[TY_LPV_LINKS][TY_SH_TERMS];
    float lobes[TY_LPV_LINKS][TY_SH_TERMS]; /* cosines about the links, of a first term of 1 */
} ty_lpv_shapes;

/* Sums of first terms, per channel and lane: of what arrived, the same without signs, what of it goes on, what surfaces
 * keep, and what leaves the lattice. */
enum { TY_LPV_ARRIVED, TY_LPV_SIZE, TY_LPV_GOES_ON, TY_LPV_KEPT, TY_LPV_LEFT, TY_LPV_SUMS };
typedef struct ty_lpv_lane_sums {
    _Alignas(64) float sums[3][TY_LPV_SUMS][TY_LPV_BLOCK];
} ty_lpv_lane_sums;

/* A row of cells, all channels. */
typedef struct ty_lpv_row {
    int32_t count, terms;
    ty_lpv_pitch pitch;
    const ty_lpv_shapes* shapes;
    const float* from;                      /* what flows, at the row's first cell and term, extinction applied */
    float* to;                              /* what flows from here, in the same order */
    float* sum;                             /* of both; NULL: at another step */
    const float* pass[3][TY_LPV_BANDS_MAX]; /* per channel and band, in whole blocks */
    const uint8_t* const* open;             /* of all cells, by link */
    size_t first;                           /* of this row's cells there */
    const uint32_t* near;                   /* per block: bits of the links that are not open; NULL: all are */
    const float* albedo[3];                 /* of the row; NULL: nothing comes back */
    float out[3][TY_SH_TERMS];              /* what of a cell's terms leaves the lattice if links are open, in first
                                               terms: at the first cell, between, at the last one */
    uint8_t leaves[3][TY_LPV_LINKS];        /* whether light that would have come by a link from outside, or that goes
                                               the other way, crosses the border: at the same cells */
    bool border;                            /* whether any of the row's cells but its ends is at the border */
} ty_lpv_row;

typedef struct ty_lpv_kernels {
    /* Adds to sums. */
    void (*step)(const ty_lpv_row* row, ty_lpv_lane_sums* sums);
} ty_lpv_kernels;
TY_DECLARE_KERNELS(ty_lpv_kernels);

#endif
