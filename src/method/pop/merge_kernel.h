/* The row loops of merging and of the residuum, built once per instruction set. */
#ifndef TY_METHOD_POP_MERGE_KERNEL_H
#define TY_METHOD_POP_MERGE_KERNEL_H

#include "base/dispatch.h"
#include "method/pop/grid.h"

enum {
    TY_POP_MERGE_RUN = 64, /* cells of a row at most */
    TY_POP_MERGE_ROWS = 8, /* at most, at once: what is known of their places before the first of them is added */
    TY_POP_MERGE_SUMS = 8  /* floats of a merged cell: seen (R, G, B), fluence (R, G, B), 2 unused */
};

/* Rows of merged cells along x, one after another along y. */
typedef struct ty_pop_merge_rows {
    int32_t count, rows; /* cells of a row */
    ty_vec first;        /* the middle of the first, m */
    float step[2];       /* from one middle to the next along x and y, m */
    float* sums;         /* TY_POP_MERGE_SUMS a cell */
} ty_pop_merge_rows;

/* A row of the residuum: light in it and beside it, and e^(-sigma_a dx / 2) of the same cells, dx along each axis.
 * Cells around the box are there, and dark. */
typedef struct ty_pop_residuum_row {
    int32_t count;
    ptrdiff_t stride[3]; /* to the next cell along each axis */
    const float* half[3];
    const float* from;
    float* to;
    float* through; /* what came in is added to it */
} ty_pop_residuum_row;

typedef struct ty_pop_merge_kernels {
    void (*merge)(const ty_pop_light* light, const ty_pop_merge_rows* rows);
    float (*pass)(const ty_pop_residuum_row* row); /* gives the sum of what came in */
} ty_pop_merge_kernels;
TY_DECLARE_KERNELS(ty_pop_merge_kernels);

#endif
