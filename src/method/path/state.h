/* Serialised state of a render, from which a later run resumes. */
#ifndef TY_PATH_STATE_H
#define TY_PATH_STATE_H

#include "method/path/driver.h"

/* Blocks of a run with allocated items, and the most bytes that a record of its state has. */
size_t ty_path_state_blocks(const ty_path_run* run);
size_t ty_path_state_room(const ty_path_run* run);

/* Copies the run's statistics and those of its blocks whose sample counts are no longer those of saved, which it
 * updates. The result is the size of the record; with saved all zero the record is a state by itself, and so is a state
 * with the records that follow it. Sealing adds a checksum. They are separate calls because no block may be merged
 * during the copy, which must be short. Bytes of an invalid size are not sealed. */
size_t ty_path_state_copy(const ty_path_run* run, const ty_path_stats* stats, uint32_t* saved, uint8_t* state);
void ty_path_state_seal(uint8_t* state, size_t size);

/* Fills the run's items and statistics from its def's state. Requires the run's request, height and items. Errors:
 * TY_ERROR_INPUT. */
ty_result ty_path_state_resume(ty_path_run* run);

/* The guide of the render whose state this is; none if it is damaged, which ty_path_state_resume tells. */
ty_path_guide_kind ty_path_state_guide(const void* state, size_t size);

#endif
