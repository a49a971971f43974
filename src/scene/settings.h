/* What scenes ask of methods. */
#ifndef TY_SCENE_SETTINGS_H
#define TY_SCENE_SETTINGS_H

#include <tyndall/scene.h>

/* Of scenes that say nothing: the one place for what is in settings; methods' default defs are made of them. */
extern const ty_render_settings ty_default_settings;

/* A setting's place among the words that the schema lets through; 0 if it is none of them. */
int32_t ty_setting_index(const char* word, const char* const* words, int32_t count);

#endif
