/* Interiors of solid dielectrics: their media, and the dielectrics around a point. */
#ifndef TY_SCENE_INTERIORS_H
#define TY_SCENE_INTERIORS_H

#include "scene/interior_list.k.h"
#include "scene/scene.h"

/* Input of interiors: the media of a scene and their views, and surfaces. */
typedef struct ty_interiors_input {
    const ty_medium_def* defs;
    const ty_committed_media* media;       /* their `dielectric` is set */
    const ty_committed_surfaces* surfaces; /* the `interior` of their dielectrics is set */
    ty_triangle_mesh* const* meshes;       /* after the shapes of surfaces */
} ty_interiors_input;

/* Warns of boundaries that are not closed if `warns`. On failure the caller drops what was made. */
ty_result ty_interiors_create(ty_context* context, const ty_interiors_input* input, bool warns,
                              ty_committed_interiors* out);
/* The dielectrics around a point, by the nearest surface of each in one direction. The scene has some. */
TY_FN_APART void ty_interiors_around(const ty_scene_view* scene, ty_vec point, ty_interior_list* out);
/* Warns that a method knows no refraction, where the scene has any. does: the sentence's end, after `method: `. */
void ty_interiors_warn(const ty_scene* scene, const char* method, const char* does);
void ty_interiors_destroy(ty_context* context, ty_committed_interiors* interiors);

#endif
