/* Construction of the blackbody table of a scene. */
#ifndef TY_SCENE_MEDIA_BLACKBODY_H
#define TY_SCENE_MEDIA_BLACKBODY_H

#include "scene/media/blackbody.k.h"

/* Fills the table for ty_blackbody_lookup; takes milliseconds. */
void ty_blackbody_fill(ty_blackbody_table* table);

#endif
