/* The method of impulse responses in the baker (TY_BAKE_IMPULSE): its part of a request and of a run. */
#ifndef TY_BAKE_IMPULSE_IMPULSE_H
#define TY_BAKE_IMPULSE_IMPULSE_H

#include "bake/impulse/senders.h"
#include "method/impulse/look.h"

/* The part of a request. */
typedef struct ty_bake_impulse {
    const ty_impulse* tables;
    ty_impulse_merged merged[3]; /* per channel, of media that have one albedo and g; rows NULL: they have not */
    float most[3];               /* times as bright as a bounce is the next at most, in the tables' unlimited medium */
    const ty_senders* senders;
    int32_t alone; /* whether only light counts that media scattered */
} ty_bake_impulse;

/* The part of a run: memory of its own. */
typedef struct ty_bake_impulse_run {
    ty_impulse* tables; /* made here; NULL: the caller's */
    ty_senders senders; /* sender_size of them at most */
    size_t sender_size;
    ty_impulse_sum* merged; /* rows of ty_bake_impulse.merged */
    size_t merged_size;
} ty_bake_impulse_run;

struct ty_bake_run;

/* Takes the caller's tables or makes them. */
ty_result ty_bake_impulse_take_tables(struct ty_bake_run* run);
/* Finds the senders of light into media. */
ty_result ty_bake_impulse_begin(struct ty_bake_run* run);
/* Frees everything, also after an error. */
void ty_bake_impulse_end(struct ty_bake_run* run);

#endif
