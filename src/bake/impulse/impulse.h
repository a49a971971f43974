/* Impulse responses in the baker (TY_BAKE_IMPULSE): the steps of a run. */
#ifndef TY_BAKE_IMPULSE_IMPULSE_H
#define TY_BAKE_IMPULSE_IMPULSE_H

#include "bake/gather/run.h"

/* Uses the caller's tables or creates them. */
ty_result ty_bake_impulse_take_tables(ty_bake_run* run);
/* True where the run has virtual emitters. */
bool ty_bake_impulse_emits(const ty_bake_run* run);
/* Finds the virtual emitters and their light. */
ty_result ty_bake_impulse_begin(ty_bake_run* run);
/* Frees everything, also after an error. */
void ty_bake_impulse_end(ty_bake_run* run);

#endif
