/* What a sweep of discrete ordinates emits, row by row, built once per instruction set. */
#ifndef TY_SOLVE_ORDINATES_KERNEL_H
#define TY_SOLVE_ORDINATES_KERNEL_H

#include "base/dispatch.h"
#include "solve/ordinates_job.h"

/* Iterates that a mixture has a share of, and what it is in: arrays as those of a job, whole. */
typedef struct ty_ordinates_mixture {
    int32_t cells, bands; /* cells: of a row */
    int32_t count;        /* of iterates */
    const float *moments[TY_ORDINATES_DEPTH], *low[TY_ORDINATES_DEPTH];
    float shares[TY_ORDINATES_DEPTH];
    const float *scattering, *g, *scattered;
    const float* source;  /* of the first term alone, where `fixed` is NULL */
    const float* fixed;   /* of all terms */
    const int32_t* thick; /* below 0: a cell that sweeps go through; NULL: all are */
    float *before, *emission;
} ty_ordinates_mixture;

typedef struct ty_ordinates_kernels {
    /* Mixes a row from cell `begin` on: low terms to `before`, what all terms emit to `emission`. Returns the sum of
     * its first term. */
    double (*emit)(const ty_ordinates_mixture* mixture, size_t begin);
} ty_ordinates_kernels;
TY_DECLARE_KERNELS(ty_ordinates_kernels);

#endif
