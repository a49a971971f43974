/* Row loops of merging and of the residuum, compiled once per instruction set. */
#ifndef TY_METHOD_POP_MERGE_KERNEL_H
#define TY_METHOD_POP_MERGE_KERNEL_H

#include "base/dispatch.h"
#include "method/pop/grid.h"

enum {
    TY_POP_MERGE_RUN = 64, /* max cells per run */
    TY_POP_MERGE_ROWS = 8, /* max rows per call; their positions are computed before the first is added */
    TY_POP_MERGE_SUMS = 8  /* floats of a merged cell: radiance (R, G, B), fluence (R, G, B), 2 unused */
};

/* Rows of merged cells along x, consecutive along y. */
typedef struct ty_pop_merge_rows {
    int32_t count, rows; /* count: cells per row */
    ty_vec first;        /* center of the first cell, m */
    float step[2];       /* spacing of centers along x and y, m */
    float* sums;         /* TY_POP_MERGE_SUMS per cell */
} ty_pop_merge_rows;

/* A row of the residuum: light, and transmittance e^(-sigma_a dx / 2) of half a cell along each axis. Arrays have
 * dark ghost cells around the box. */
typedef struct ty_pop_residuum_row {
    int32_t count;
    ptrdiff_t stride[3]; /* offset to the next cell along each axis */
    const float* half[3];
    const float* from;
    float* to;
    float* accumulated; /* sum of the light that entered */
} ty_pop_residuum_row;

typedef struct ty_pop_merge_kernels {
    void (*merge)(const ty_pop_light* light, const ty_pop_merge_rows* rows);
    float (*propagate)(const ty_pop_residuum_row* row); /* returns the sum of entering light */
} ty_pop_merge_kernels;
TY_DECLARE_KERNELS(ty_pop_merge_kernels);

#endif
