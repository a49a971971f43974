/* Row loops of merging, compiled once per instruction set. */
#ifndef TY_METHOD_POP_MERGE_MERGE_KERNEL_H
#define TY_METHOD_POP_MERGE_MERGE_KERNEL_H

#include "base/dispatch.h"
#include "method/pop/grid/grid.h"

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

typedef struct ty_pop_merge_kernels {
    void (*merge)(const ty_pop_light* light, const ty_pop_merge_rows* rows);
} ty_pop_merge_kernels;
TY_DECLARE_KERNELS(ty_pop_merge_kernels);

#endif
