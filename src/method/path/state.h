/* Serialised state of a render, from which a later run resumes. */
#ifndef TY_PATH_STATE_H
#define TY_PATH_STATE_H

#include "method/path/driver.h"

/* Bytes of the state of a run with allocated items. */
size_t ty_path_state_size(const ty_path_run* run);

/* Copies to `state` the run's statistics and those of its items that have more samples than `state` has; the first time
 * `state` is zeroed. Sealing adds a checksum. They are separate calls because no block may be merged during the copy,
 * which must be short. Bytes of an invalid size are not sealed. */
void ty_path_state_copy(const ty_path_run* run, const ty_path_stats* stats, uint8_t* state);
void ty_path_state_seal(uint8_t* state, size_t size);

/* Fills the run's items and statistics from its def's state. Requires the run's request, height and items. Errors:
 * TY_ERROR_INPUT. */
ty_result ty_path_state_resume(ty_path_run* run);

#endif
