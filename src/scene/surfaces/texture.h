/* Texture storage. */
#ifndef TY_SCENE_SURFACES_TEXTURE_H
#define TY_SCENE_SURFACES_TEXTURE_H

#include "scene/surfaces/texture.k.h"

#include <tyndall/scene.h>

/* NULL gives the view of no texture. */
ty_texture_view ty_texture_get_view(const ty_texture* texture);
size_t ty_texture_bytes(const ty_texture* texture);
/* Number of references. */
int32_t ty_texture_owners(const ty_texture* texture);

#endif
