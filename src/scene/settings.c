/* Method, bounds and options that a scene asks for. */
#include "scene/settings.h"

#include "base/context.h"
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

const ty_render_settings ty_default_settings = {.method = "auto", .spp = 64};

ty_render_settings ty_scene_render_settings(const ty_scene* scene) {
    return scene->settings;
}

void ty_scene_set_render_settings(ty_scene* scene, const ty_render_settings* settings) {
    scene->settings = *settings;
}

/* The index of an option; the count of options if there is none. */
static size_t find_option(const ty_scene* scene, const char* method, const char* key) {
    size_t i = 0;
    while (i < scene->option_count &&
           (strcmp(scene->options[i].method, method) != 0 || strcmp(scene->options[i].key, key) != 0))
        ++i;
    return i;
}

ty_result ty_scene_set_option(ty_scene* scene, const char* method, const char* key, const char* value) {
    const size_t at = find_option(scene, method, key);
    if (value == NULL) {
        if (at < scene->option_count) scene->options[at] = scene->options[--scene->option_count];
        return TY_OK;
    }
    ty_scene_option option;
    if (strlen(method) >= sizeof option.method || strlen(key) >= sizeof option.key ||
        strlen(value) >= sizeof option.value)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "render.%.32s.%.32s: a text is too long", method, key);
    if (at == scene->option_count &&
        !ty_grow_array(scene->context, (void**)&scene->options, &scene->option_capacity, at, sizeof option))
        return TY_ERROR_MEMORY;
    snprintf(option.method, sizeof option.method, "%s", method);
    snprintf(option.key, sizeof option.key, "%s", key);
    snprintf(option.value, sizeof option.value, "%s", value);
    scene->options[at] = option;
    if (at == scene->option_count) ++scene->option_count;
    return TY_OK;
}

const char* ty_scene_get_option(const ty_scene* scene, const char* method, const char* key) {
    const size_t at = find_option(scene, method, key);
    return at < scene->option_count ? scene->options[at].value : NULL;
}
