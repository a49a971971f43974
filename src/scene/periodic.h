/* Periodic boundaries of scenes: the def, the cell of a commit, and what cannot repeat. */
#ifndef TY_SCENE_PERIODIC_H
#define TY_SCENE_PERIODIC_H

#include "scene/scene.h"

/* The cell of a scene with a def and media; axes 0 unless the def has any. Along other axes it is unbounded. */
ty_result ty_periodic_find_cell(ty_context* context, const ty_periodic_def* def, const ty_medium_def* media,
                                size_t count, ty_periodic_view* out);
/* Bounds the cell along the other axes by the media and surfaces of a scene. */
void ty_periodic_bound_cell(const ty_scene* scene, ty_periodic_view* cell);
/* Fails if the scene with these lights repeats and has what cannot: lights with a place, and dielectrics. */
ty_result ty_periodic_check(const ty_scene* scene, const ty_periodic_view* cell, const ty_committed_lights* lights,
                            const ty_committed_interiors* interiors);

#endif
