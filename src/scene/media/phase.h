/* Checks, copies and views of phase functions. */
#ifndef TY_SCENE_MEDIA_PHASE_H
#define TY_SCENE_MEDIA_PHASE_H

#include "scene/media/phase_lobes.k.h"

#include <tyndall/phase.h>

/* Fails unless the lobes are those of a phase function; `name` begins the message. */
ty_result ty_phase_check(ty_context* context, const char* name, const ty_phase_lobe* lobes, int32_t count);

/* Replaces the tables of checked lobes, in `copy`, by copies; false, with a message, on allocation failure. */
bool ty_phase_copy_tables(ty_context* context, const ty_phase_lobe* lobes, int32_t count, ty_phase_lobe* copy);
void ty_phase_free_tables(ty_context* context, const ty_phase_lobe* lobes, int32_t count);

/* The view of checked lobes, whose tables belong to it. ty_phase_view_destroy takes NULL, too. */
ty_result ty_phase_view_create(ty_context* context, const ty_phase_lobe* lobes, int32_t count, ty_phase_view** out);
void ty_phase_view_destroy(ty_context* context, const ty_phase_view* view);

#endif
