/* Scenes that benches and figures of light propagation volumes share. */
#define _POSIX_C_SOURCE 200809L
#include "scenes/lpv_scenes.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

const char* const lpv_scene_names[3] = {"atrium", "Cornell box", "Sponza"};
const char lpv_sponza_file[] = "scenes/sponza_atrium.glb";

/* As scenes/sponza_lamps.json. */
static const char sponza_text[] =
    "{\"tyndall\": 1,"
    " \"camera\": {\"position\": [-10.2, 1.6, -1.7], \"target\": [-2, 3.9, 1.9], \"fov_y\": 66,"
    "  \"resolution\": [1280, 720], \"exposure\": 0.5},"
    " \"media\": [{\"bounds\": [[-14.3, -0.03, -6.5], [13.1, 13.1, 6.0]], \"sigma_s\": [0.058, 0.06, 0.062],"
    "  \"sigma_a\": 0, \"g\": 0.5}],"
    " \"lights\": [{\"type\": \"directional\", \"direction\": [-0.3, -1, 0.3], \"irradiance\": [20, 18.5, 16]},"
    "  {\"type\": \"point\", \"position\": [-6.2, 2.6, 4.4], \"intensity\": [8, 5, 2.4]},"
    "  {\"type\": \"spot\", \"position\": [-5.6, 3.4, -3.2], \"direction\": [0.5, -1, 0.6], \"cone\": 70,"
    "   \"penumbra\": 0.4, \"intensity\": [20, 26, 40]}],"
    " \"geometry\": [{\"file\": \"scenes/sponza_atrium.glb\"}],"
    " \"render\": {\"lpv\": {\"resolution\": 64}}}";

bool lpv_has_sponza(const char* data_or_null) {
    char path[4096];
    if (data_or_null == NULL) return false;
    snprintf(path, sizeof path, "%s/%s", data_or_null, lpv_sponza_file);
    return access(path, R_OK) == 0;
}

ty_result lpv_load_scene(ty_context* context, lpv_scene which, const char* data, const char* const* overrides,
                         int32_t override_count, ty_scene** out) {
    static const char* const builtin[] = {[LPV_ATRIUM] = "builtin:atrium", [LPV_CORNELL] = "builtin:fog_cornell"};
    if (which == LPV_SPONZA)
        return ty_scene_parse(context, sponza_text, strlen(sponza_text), "sponza", data, overrides, override_count,
                              out);
    return ty_scene_load(context, builtin[which], overrides, override_count, out);
}
