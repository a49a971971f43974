/* Features of a scene as seen by its camera. */
#ifndef TY_CHOOSE_FEATURES_H
#define TY_CHOOSE_FEATURES_H

#include <tyndall/choose.h>

/* Requires a committed scene. Errors: TY_ERROR_MEMORY. */
ty_result ty_scene_features_find(const ty_scene* scene, ty_scene_features* out);

#endif
