/* The row loops of beams, built once per instruction set. */
#ifndef TY_DIRECT_KERNEL_H
#define TY_DIRECT_KERNEL_H

#include "direct/beam.k.h"

/* Tubes through a slab. */
typedef struct ty_beam_row {
    int32_t count;       /* cells in a row; tubes are one more */
    float share[2];      /* of each tube that is in its second cell, and its second row */
    float length;        /* of a tube within the slab, m */
    float start;         /* how far the slab's near side is along the tubes, m */
    const float* first;  /* extinction of the rows of cells that the tubes overlap, 1/m */
    const float* second; /* the other */
    const float* hit;    /* how far along each tube a surface is, m; NULL: there is none */
    const float* in;     /* transmittance of each tube up to the slab, or to the surface */
    float* out;          /* and up to its far side */
    float* mean;         /* transmittance over the slab, 0 behind surfaces */
    float* blend;        /* scratch, count + 2 */
} ty_beam_row;

/* Cells of a slab. */
typedef struct ty_beam_cells {
    int32_t count;
    float share[2];
    const float* first;  /* mean transmittance of the row of tubes that has these cells as its first row */
    const float* second; /* and as its second */
    float* lit;          /* mean transmittance of cells */
} ty_beam_cells;

typedef struct ty_beam_kernels {
    void (*tubes)(const ty_beam_row* row);
    void (*cells)(const ty_beam_cells* cells);
} ty_beam_kernels;

extern const ty_beam_kernels ty_beam_kernels_v1;
extern const ty_beam_kernels ty_beam_kernels_v3;
extern const ty_beam_kernels ty_beam_kernels_v4;

#endif
