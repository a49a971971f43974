/* A synthetic environment: a dim room with windows and a light. */
#ifndef TY_FIGURES_WINDOWS_H
#define TY_FIGURES_WINDOWS_H

#include <tyndall/tyndall.h>

/* The map of the environment, equirectangular. Errors: TY_ERROR_MEMORY. */
ty_result figure_create_windows(ty_context* context, ty_image** out);
/* Adds the environment to a scene, and commits it. Errors: TY_ERROR_MEMORY. */
ty_result figure_add_windows(ty_scene* scene);

#endif
