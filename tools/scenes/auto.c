/* Test scenes of method auto's choices. */
#include "scenes/auto.h"

#define SQUARE_FILE "hdri/potsdamer_platz_1k.hdr"

const auto_scene auto_scenes[] = {
    {.name = "cube, g 0", .scene = "builtin:cube_g0"},
    {.name = "cube, g 0.7", .scene = "builtin:cube_g0.7"},
    {.name = "cube, g 0.96", .scene = "builtin:cube_g0.96"},
    {.name = "cloud, sun", .scene = "builtin:cloud_sun"},
    {.name = "cloud, sky", .scene = "builtin:cloud_sky"},
    {.name = "nebulae", .scene = "builtin:nebulae"},
    {.name = "cloud over a plain", .scene = "builtin:demo"},
    {.name = "box in fog, area light", .scene = "builtin:cornell_fog"},
    {.name = "box in fog, spot light", .scene = "builtin:fog_cornell"},
    {.name = "hall of lamps in fog", .scene = "builtin:lamps"},
    {.name = "atrium in fog, sun", .scene = "builtin:atrium"},
    {.name = "room under water", .scene = "builtin:screen_room"},
    {.name = "Disney cloud, sun", .scene = "auto_cloud_sun", .file = DISNEY_CLOUD_FILE},
    {.name = "Disney cloud, dawn", .scene = "auto_cloud_dawn", .file = DISNEY_CLOUD_FILE},
    {.name = "plume over a floor", .scene = "auto_plume", .file = PLUME_FILE},
    {.name = "burning plume", .scene = "auto_fire", .file = PLUME_FILE},
    {.name = "CT head", .scene = "auto_ct_head", .file = CT_HEAD_FILE},
    {.name = "Sponza in fog, sky", .scene = "auto_sponza_sky", .file = SPONZA_FILE},
    {.name = "Sponza in fog, lamps", .scene = "auto_sponza_lamps", .file = SPONZA_FILE},
    {.name = "box with smoke", .scene = "auto_cornell_smoke", .file = CORNELL_FILE},
    {.name = "staircase in haze", .scene = "auto_staircase", .file = STAIRCASE_FILE},
    {.name = "box in fog, g 0.8, area light", .scene = "builtin:cornell_fog", .overrides = {"media[0].g=0.8"}},
    {.name = "thick cloud, g 0.9, sun",
     .scene = "builtin:cloud_sun",
     .overrides = {"media[0].sigma_t=60", "media[0].g=0.9"},
     .held_out = true},
    {.name = "thin dark cloud, sky",
     .scene = "builtin:cloud_sky",
     .overrides = {"media[0].sigma_t=5", "media[0].albedo=0.5"},
     .held_out = true},
    {.name = "box of smoke, spot light",
     .scene = "builtin:fog_cornell",
     .overrides = {"media[0].sigma_t=3", "media[0].g=0.8"},
     .held_out = true},
    {.name = "atrium in dense fog", .scene = "builtin:atrium", .overrides = {"media[0].sigma_s=0.3"}, .held_out = true},
    {.name = "lamp beside smoke", .scene = "auto_lamp_in_smoke", .held_out = true},
    {.name = "ball of milk", .scene = "auto_milk_ball", .held_out = true},
    {.name = "fog bank on a plain", .scene = "auto_fog_bank", .held_out = true},
    {.name = "box in thin fog, area light",
     .scene = "builtin:cornell_fog",
     .overrides = {"media[0].sigma_t=0.3"},
     .held_out = true},
    {.name = "box in dark fog, area light",
     .scene = "builtin:cornell_fog",
     .overrides = {"media[0].albedo=0.6"},
     .held_out = true},
    {.name = "plume in a square", .scene = "auto_plume_square", .file = PLUME_FILE},
};
const int32_t auto_scene_count = sizeof auto_scenes / sizeof auto_scenes[0];

ty_result auto_load_scene(ty_context* context, const auto_scene* from, const char* data, ty_scene** out) {
    int32_t overrides = 0;
    while (overrides < AUTO_OVERRIDES_MAX && from->overrides[overrides] != NULL) ++overrides;
    return tools_load_scene(context, from->scene, data, from->overrides, overrides, out);
}
