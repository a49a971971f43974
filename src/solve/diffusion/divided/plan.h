/* Needs of a divided solve for diffusion: memory and messages, for any number of ranks. */
#ifndef TY_SOLVE_DIFFUSION_DIVIDED_PLAN_H
#define TY_SOLVE_DIFFUSION_DIVIDED_PLAN_H

#include "solve/diffusion/diffusion.h"

/* Bytes are of rank 0, whose part is as large as any. */
typedef struct ty_diffusion_plan {
    int32_t ranks[3]; /* along each axis */
    int32_t part[3];  /* cells of a part */
    int32_t levels;   /* of multigrid that are divided */
    double arrays;    /* the part's coefficients, source, fluence and fluxes, bytes */
    double solve;     /* what ty_diffusion_solve takes besides */
    double whole;     /* the same arrays of all cells */
    /* Of a rank in the middle, in a linear cycle: */
    double cells;        /* that it visits, those of levels that all ranks have whole among them */
    double messages;     /* that it sends for the layers of its neighbours, and in gatherings */
    double halo_bytes;   /* of the layers that it sends */
    double gather_bytes; /* that it receives of the first whole level */
} ty_diffusion_plan;

/* size, cell, limiter, solver and boundary kinds of the def are used; its arrays may be NULL. Errors:
 * TY_ERROR_ARGUMENT: there are too few cells for so many ranks; TY_ERROR_MEMORY. */
ty_result ty_diffusion_plan_ranks(ty_context* context, const ty_diffusion_def* whole, int32_t ranks,
                                  ty_diffusion_plan* out);

#endif
