/* Render settings of scenes. */
#ifndef TY_SCENE_SETTINGS_H
#define TY_SCENE_SETTINGS_H

#include <tyndall/scene.h>

/* Defaults of all settings, in this one place; the methods' default defs are derived from them. */
extern const ty_render_settings ty_default_settings;

/* Index of a setting's value among the words allowed by the schema; 0 if there is no match. */
int32_t ty_setting_index(const char* word, const char* const* words, int32_t count);

#endif
