/* Glossy materials of shapes and meshes: defaults, checks, textures, and what kernels see of them. */
#ifndef TY_SCENE_SURFACES_GLOSS_H
#define TY_SCENE_SURFACES_GLOSS_H

#include "scene/surfaces/surface.k.h"

#include <tyndall/scene.h>

ty_gloss_def ty_default_gloss(void);
ty_texture_use ty_default_texture_use(void);
ty_result ty_texture_use_check(ty_context* context, const char* prefix, const ty_texture_use* use);
/* prefix: of the fields in messages, such as "material". */
ty_result ty_gloss_check(ty_context* context, const char* prefix, const ty_gloss_def* def);
/* False for Lambertian surfaces. */
bool ty_gloss_exists(const ty_gloss_def* def);
/* True for the boundary of a solid dielectric. */
bool ty_gloss_is_solid(const ty_gloss_def* def);
void ty_gloss_retain(const ty_gloss_def* def);
void ty_gloss_release(const ty_gloss_def* def);
ty_surface_gloss ty_gloss_get_view(const ty_gloss_def* def);

#endif
