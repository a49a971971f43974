/* Scenes of benches and figures. */
#define _POSIX_C_SOURCE 200809L
#include "scenes/scenes.h"
#include "io/scenes/builtin.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

extern const ty_builtin_scene tools_scenes[]; /* generated from scenes/tools */

ty_result tools_load_scene(ty_context* context, const char* name, const char* data, const char* const* overrides,
                           int32_t override_count, ty_scene** out) {
    for (const ty_builtin_scene* scene = tools_scenes; scene->name != NULL; ++scene)
        if (strcmp(scene->name, name) == 0)
            return ty_scene_parse(context, scene->text, scene->size, name, data, overrides, override_count, out);
    return ty_scene_load(context, name, overrides, override_count, out);
}

bool tools_write_scene(const char* name, const char* path) {
    const ty_builtin_scene* scene = tools_scenes;
    while (scene->name != NULL && strcmp(scene->name, name) != 0) ++scene;
    FILE* file = scene->name != NULL ? fopen(path, "wb") : NULL;
    if (file == NULL) return false;
    const bool written = fwrite(scene->text, 1, scene->size, file) == scene->size;
    return fclose(file) == 0 && written;
}

const char* const lpv_scene_names[3] = {"atrium", "Cornell box", "Sponza"};
const char* const lpv_scene_files[3] = {"builtin:atrium", "builtin:fog_cornell", "lpv_sponza"};

bool tools_has_data(const char* data_or_null, const char* name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", data_or_null != NULL ? data_or_null : "", name);
    return data_or_null != NULL && access(path, R_OK) == 0;
}
