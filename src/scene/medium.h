/* Media on their way into a scene. */
#ifndef TY_SCENE_MEDIUM_H
#define TY_SCENE_MEDIUM_H

#include "scene/medium.k.h"

#include <tyndall/scene.h>

/* Fails unless a medium is one that ty_scene_add_medium promises to take. */
ty_result ty_medium_check(ty_context* context, const ty_medium_def* def);
/* Copies a def with everything it points to, retaining grids and shell; false, with a message, when memory is short. */
bool ty_medium_copy(ty_context* context, const ty_medium_def* def, ty_medium_def* out);
void ty_medium_release(ty_context* context, ty_medium_def* copy);

/* All grids of a medium, NULL where it has none. */
enum { TY_MEDIUM_GRIDS = 6 };
void ty_medium_grids(const ty_medium_def* def, ty_grid* grids[TY_MEDIUM_GRIDS]);

/* def must outlive the view. Failed or not, ty_medium_view_destroy may follow. */
ty_result ty_medium_view_create(ty_context* context, const ty_medium_def* def, ty_medium_view* view);
void ty_medium_view_destroy(ty_context* context, ty_medium_view* view);
/* Widens a box, m, to hold the medium. */
void ty_medium_extent(const ty_medium_def* def, double lower[3], double upper[3]);

#endif
