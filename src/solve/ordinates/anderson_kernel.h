/* What a sweep of discrete ordinates emits, row by row, built once per instruction set. */
#ifndef TY_SOLVE_ORDINATES_ANDERSON_KERNEL_H
#define TY_SOLVE_ORDINATES_ANDERSON_KERNEL_H

#include "solve/ordinates/job.h"

/* Iterates that a mixture has a share of, and what it is in: arrays as those of a job, whole. */
typedef struct ty_anderson_iterate {
    int32_t cells, bands; /* cells: of a row */
    int32_t count;        /* of iterates */
    const float *moments[TY_ANDERSON_DEPTH], *low[TY_ANDERSON_DEPTH];
    float shares[TY_ANDERSON_DEPTH];
    const float *scattering, *g, *scattered;
    const float* source;  /* of the first term alone, where `fixed` is NULL */
    const float* fixed;   /* of all terms */
    const int32_t* thick; /* below 0: a cell that sweeps go through; NULL: all are */
    float *before, *emission;
} ty_anderson_iterate;

typedef struct ty_anderson_kernels {
    /* Mixes a row from cell `begin` on: low terms to `before`, what all terms emit to `emission`. Returns the sum of
     * its first term. */
    double (*emit)(const ty_anderson_iterate* mixture, size_t begin);
} ty_anderson_kernels;

extern const ty_anderson_kernels ty_anderson_kernels_v1, ty_anderson_kernels_v3, ty_anderson_kernels_v4;

#endif
