/* The row loops of beams, built once per instruction set. */
#ifndef TY_DIRECT_KERNEL_H
#define TY_DIRECT_KERNEL_H

#include "direct/beam.k.h"

/* Rays along each tube that find where surfaces are. */
enum { TY_BEAM_RAYS = 4 };

/* Tubes through a slab: tube t of a row overlaps its cells t - 2, t - 1 and t. */
typedef struct ty_beam_row {
    int32_t count;                  /* cells in a row; tubes are two more */
    float weight[2][3];             /* of each tube's three cells, and three rows */
    float length;                   /* of a tube within the slab, m */
    float start;                    /* how far the slab's near side is along the tubes, m */
    const float* cells[3];          /* extinction of the three rows, 1/m */
    const float* hit[TY_BEAM_RAYS]; /* how far along each tube its rays meet a surface, m; NULL: there is none */
    const float* in;                /* transmittance of each tube up to the slab, surfaces ignored */
    float* out;                     /* and up to its far side */
    float* mean;                    /* transmittance over the slab, times the share of it before surfaces */
    float* blend;                   /* scratch, count + 4 */
} ty_beam_row;

/* Cells of a slab. */
typedef struct ty_beam_cells {
    int32_t count;
    float weight[2][3];
    const float* mean[3]; /* of the rows of tubes that have these cells as their first, second and third row */
    float* lit;           /* mean transmittance of cells */
} ty_beam_cells;

typedef struct ty_beam_kernels {
    void (*tubes)(const ty_beam_row* row);
    void (*cells)(const ty_beam_cells* cells);
} ty_beam_kernels;

extern const ty_beam_kernels ty_beam_kernels_v1;
extern const ty_beam_kernels ty_beam_kernels_v3;
extern const ty_beam_kernels ty_beam_kernels_v4;

#endif
