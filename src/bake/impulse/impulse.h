/* Impulse responses in the baker (TY_BAKE_IMPULSE): their state in a request and in a run. */
#ifndef TY_BAKE_IMPULSE_IMPULSE_H
#define TY_BAKE_IMPULSE_IMPULSE_H

#include "bake/impulse/virtual_emitters.h"
#include "method/impulse/lookup.h"

/* State in a request. */
typedef struct ty_bake_impulse {
    const ty_impulse* tables;
    ty_impulse_merged merged[3]; /* per channel, for media of one albedo and g; rows NULL: media differ */
    float max_bounce_ratio[3];   /* upper bound of the ratio of successive bounces in the tables' infinite medium */
    const ty_virtual_emitters* emitters;
    int32_t media_only; /* 1: only light scattered by media counts */
} ty_bake_impulse;

/* State in a run, which owns its memory. */
typedef struct ty_bake_impulse_run {
    ty_impulse* tables;           /* created by the run; NULL: the caller's */
    ty_virtual_emitters emitters; /* emitter_capacity of them allocated */
    size_t emitter_capacity;
    ty_impulse_sum* merged; /* rows of ty_bake_impulse.merged */
    size_t merged_size;
} ty_bake_impulse_run;

struct ty_bake_run;

/* Uses the caller's tables or creates them. */
ty_result ty_bake_impulse_take_tables(struct ty_bake_run* run);
/* Finds the virtual emitters and their light. */
ty_result ty_bake_impulse_begin(struct ty_bake_run* run);
/* Frees everything, also after an error. */
void ty_bake_impulse_end(struct ty_bake_run* run);

#endif
