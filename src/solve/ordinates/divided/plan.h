/* Needs of a divided solve by discrete ordinates: memory, stages and messages, for any number of ranks. */
#ifndef TY_SOLVE_ORDINATES_DIVIDED_PLAN_H
#define TY_SOLVE_ORDINATES_DIVIDED_PLAN_H

#include "solve/ordinates/ordinates.h"

/* All bytes are of the rank that needs most, which is rank 0 (parts of the same size as others, or larger). */
typedef struct ty_ordinates_plan {
    int32_t ranks[2]; /* along x and y */
    int32_t part[3];  /* cells of a part */
    double arrays;    /* the part's media, sources and moments, bytes */
    double solve;     /* what ty_ordinates_solve takes besides: iterates, sweep and acceleration, without walls */
    double whole;     /* the media, sources and moments of all cells on rank 0, which has them before and after */
    int32_t units;    /* of work of a rank in a sweep (sweep_schedule.h) */
    int32_t stages;   /* until all ranks have done their units; units + the stages of waiting */
    double messages, message_bytes; /* that a rank in the middle sends in a sweep for the faces of its part */
    double cell_bytes;              /* that all ranks together send for the acceleration of a sweep, without halos */
} ty_ordinates_plan;

/* size, cell, set, bands, output_order, source_terms and accelerated of the def are used; its arrays may be NULL.
 * Errors: TY_ERROR_ARGUMENT: there are too few cells for so many ranks; TY_ERROR_MEMORY. */
ty_result ty_ordinates_plan_ranks(ty_context* context, const ty_ordinates_def* whole, int32_t ranks,
                                  ty_ordinates_plan* out);
/* Stages of the same units by the published KBA, which fills the pipeline of ranks at each of the four corners of the
 * box: Sec. 3 (Baker & Koch 1998). */
int32_t ty_ordinates_stages_kba(const ty_ordinates_plan* plan);

#endif
