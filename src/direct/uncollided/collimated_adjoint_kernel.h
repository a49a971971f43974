/* The row loops of the adjoint of parallel light, built once per instruction set. Tube t of a row overlaps the cells
 * t - 2, t - 1 and t of three rows. */
#ifndef TY_DIRECT_UNCOLLIDED_COLLIMATED_ADJOINT_KERNEL_H
#define TY_DIRECT_UNCOLLIDED_COLLIMATED_ADJOINT_KERNEL_H

#include "base/dispatch.h"
#include "base/kernel.h"

/* Weighted means of three rows of values, each NULL beyond the box. */
typedef struct ty_adjoint_rows {
    int32_t count;         /* cells in a row; there are two more tubes */
    const float* cells[3]; /* rows of cells, or in gather of tubes */
    const float* across;   /* weights of the three rows */
    const float* along;    /* weights of the three values along the row */
    float* blend;          /* scratch, count + 4 */
} ty_adjoint_rows;

/* A row of tubes through a slab. */
typedef struct ty_adjoint_tubes {
    float length;    /* m */
    float* before;   /* transmittance before the slab */
    float* depth;    /* optical depth within it */
    float* through;  /* on the way: transmittance; on the way back: derivative by it */
    float* by_mean;  /* scratch, count + 4: derivative by the mean transmittance */
    float* mean;     /* out: mean transmittance */
    float* by_depth; /* out */
} ty_adjoint_tubes;

typedef struct ty_collimated_adjoint_kernels {
    /* The way of the light. */
    void (*pass)(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes);
    /* The same, which sets before and depth. */
    void (*note)(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes);
    /* The way back for one channel of weights; returns as weigh. */
    double (*back_of_one)(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes, float color);
    /* The way back for several: begin, weigh for each channel, and back. */
    void (*begin)(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes);
    /* Adds color times the blended weights of a channel to by_mean; returns the sum of that times the mean. */
    double (*weigh)(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes, float color);
    void (*back)(const ty_adjoint_rows* rows, const ty_adjoint_tubes* tubes);
    /* Adds `length` times the blended values of tubes to a row of cells. */
    void (*gather)(const ty_adjoint_rows* rows, float length, float* cells);
} ty_collimated_adjoint_kernels;
TY_DECLARE_KERNELS(ty_collimated_adjoint_kernels);

#endif
