/* A pilot of path tracing: a picture of a few thousand paths, whose noise and length the choice of a method rests on. */
#ifndef TY_CHOOSE_PILOT_H
#define TY_CHOOSE_PILOT_H

#include <tyndall/choose.h>

/* Fills in the features noise, multiple, vertices, surface_noise and surface_vertices of a committed scene. Errors: TY_ERROR_MEMORY,
 * those of the path tracer. */
ty_result ty_pilot_trace(const ty_scene* scene, ty_scene_features* out);

#endif
