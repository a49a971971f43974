/* Method, bounds and options that a scene asks for. */
#ifndef TY_SCENE_SETTINGS_H
#define TY_SCENE_SETTINGS_H

#include <tyndall/scene.h>

/* One option, as it stands in a scene file: render.METHOD.KEY = VALUE. */
typedef struct ty_scene_option {
    char method[16], key[32], value[48];
} ty_scene_option;

extern const ty_render_settings ty_default_settings;

#endif
