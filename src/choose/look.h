/* What the camera sees of a scene, at a glance. */
#ifndef TY_CHOOSE_LOOK_H
#define TY_CHOOSE_LOOK_H

#include <tyndall/choose.h>

/* The scene is committed. Errors: TY_ERROR_MEMORY. */
ty_result ty_look_at(const ty_scene* scene, ty_look* out);

#endif
