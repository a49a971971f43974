/* The state of a render as bytes, which a later run takes up again. */
#ifndef TY_PATH_STATE_H
#define TY_PATH_STATE_H

#include "method/path/driver.h"

/* Bytes of the state of a run whose items are there. */
size_t ty_path_state_size(const ty_path_run* run);

/* Copies the run's items and what was done for them into state, then seals it with a checksum. Two calls, because the
 * first must be quick: no block may come in meanwhile. Bytes of a size that no state has are not sealed. */
void ty_path_state_copy(const ty_path_run* run, const ty_path_stats* stats, uint8_t* state);
void ty_path_state_seal(uint8_t* state, size_t size);

/* Fills in the run's items and stats from its def's state. The run's request, height and items must be there. Errors:
 * TY_ERROR_INPUT. */
ty_result ty_path_state_resume(ty_path_run* run);

#endif
