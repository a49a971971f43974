/* Media on their way into a scene. */
#ifndef TY_SCENE_MEDIUM_H
#define TY_SCENE_MEDIUM_H

#include "scene/medium.k.h"

#include <tyndall/scene.h>

/* Fails unless a medium is one that ty_scene_add_medium promises to take. */
ty_result ty_medium_check(ty_context* context, const ty_medium_def* def);
/* def's grid must outlive the view. */
ty_medium_view ty_medium_get_view(const ty_medium_def* def);
/* Widens a box, m, to hold the medium. */
void ty_medium_extent(const ty_medium_def* def, double lower[3], double upper[3]);

#endif
