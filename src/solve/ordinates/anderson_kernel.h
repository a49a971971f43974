/* Source of a sweep of discrete ordinates, row by row. Compiled once per instruction set. */
#ifndef TY_SOLVE_ORDINATES_ANDERSON_KERNEL_H
#define TY_SOLVE_ORDINATES_ANDERSON_KERNEL_H

#include "base/dispatch.h"
#include "solve/ordinates/job.h"

/* Iterates of the mixed iterate with their Anderson weights, and the output arrays; arrays are those of a job. */
typedef struct ty_anderson_iterate {
    int32_t cells, bands; /* cells: per row */
    int32_t count;        /* number of iterates */
    const float *moments[TY_ANDERSON_DEPTH], *low_order[TY_ANDERSON_DEPTH];
    float anderson_weights[TY_ANDERSON_DEPTH];
    const float *scattering, *g, *scattered;
    const float* source;      /* first term, where `source_lm` is NULL */
    const float* source_lm;   /* all terms */
    const int32_t* diffusive; /* negative: transport cell; NULL: all are */
    float *mixed, *emission;
} ty_anderson_iterate;

typedef struct ty_anderson_kernels {
    /* Forms a row of the mixed iterate from cell `begin`: low-order moments to `mixed`, emission of all terms to
     * `emission`. Returns the sum of its first term. */
    double (*emit)(const ty_anderson_iterate* iterate, size_t begin);
} ty_anderson_kernels;
TY_DECLARE_KERNELS(ty_anderson_kernels);

#endif
