/* The table of black bodies, on its way into a scene. */
#ifndef TY_SCENE_BLACKBODY_H
#define TY_SCENE_BLACKBODY_H

#include "scene/blackbody.k.h"

/* The table for ty_blackbody_lookup; a matter of milliseconds. */
void ty_blackbody_fill(ty_blackbody_table* table);

#endif
