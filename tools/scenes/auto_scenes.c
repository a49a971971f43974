/* Scenes on which method auto's choices are measured. */
#include "scenes/auto_scenes.h"

#include <string.h>

#define CLOUD_FILE "volumes/wdas_cloud_sixteenth.vdb"
#define PLUME_FILE "volumes/plume/plume_0042.vdb"
#define CT_FILE "volumes/headsq_ct_64x64x93_i16.nrrd"
#define SPONZA_FILE "scenes/sponza_atrium.glb"
#define STAIRCASE_FILE "scenes/wooden_staircase.glb"
#define CORNELL_FILE "scenes/cornell_box_lightmap_uv.glb"
#define SQUARE_FILE "hdri/potsdamer_platz_1k.hdr"

#define CLOUD_MEDIUM                                                                                                   \
    "{\"density\": {\"file\": \"" CLOUD_FILE "\", \"grid\": \"density\"}, \"sigma_t\": 0.5, \"albedo\": 0.999, "       \
    "\"g\": 0.8}"
#define PLUME_DENSITY "\"density\": {\"file\": \"" PLUME_FILE "\", \"grid\": \"density\"}, \"sigma_t\": 14"
#define FLOOR                                                                                                          \
    "{\"quad\": {\"origin\": [-30, -30, 0], \"u\": [60, 0, 0], \"v\": [0, 60, 0]}, \"material\": {\"albedo\": "        \
    "[0.3, 0.27, 0.22]}}"
#define SPONZA_CAMERA                                                                                                  \
    "\"camera\": {\"position\": [-10.2, 1.6, -1.7], \"target\": [-2, 3.9, 1.9], \"fov_y\": 66, \"resolution\": [960, " \
    "540]}"
#define SPONZA_FOG                                                                                                     \
    "{\"bounds\": [[-14.3, -0.03, -6.5], [13.1, 13.1, 6.0]], \"sigma_s\": [0.058, 0.06, 0.062], \"g\": 0.6}"

/* As scenes/disney_cloud_sun.json, and so on. */
static const char cloud_sun[] =
    "{\"tyndall\": 1, \"camera\": {\"position\": [-560, 60, 420], \"target\": [0, 45, -40], \"fov_y\": 28,"
    " \"resolution\": [960, 540]}, \"media\": [" CLOUD_MEDIUM "],"
    " \"lights\": [{\"type\": \"environment\", \"sky\": {\"sun_direction\": [0.75, -0.5, -0.1], \"haze\": 0.8,"
    " \"sun\": true}}]}";
static const char cloud_dawn[] =
    "{\"tyndall\": 1, \"camera\": {\"position\": [-560, -10, 420], \"target\": [0, 45, -40], \"fov_y\": 28,"
    " \"resolution\": [960, 540]}, \"media\": [" CLOUD_MEDIUM "],"
    " \"lights\": [{\"type\": \"environment\", \"file\": \"hdri/kiara_1_dawn_1k.hdr\"}]}";
static const char plume[] =
    "{\"tyndall\": 1, \"up_axis\": \"z\", \"camera\": {\"position\": [4.2, -5.2, 1.7], \"target\": [1, 1, 2.0],"
    " \"fov_y\": 36, \"resolution\": [540, 720]},"
    " \"media\": [{" PLUME_DENSITY ", \"albedo\": [0.85, 0.84, 0.82], \"g\": 0.3}],"
    " \"lights\": [{\"type\": \"environment\", \"sky\": {\"sun_direction\": [-0.5, 0.6, -0.55], \"sun\": true}}],"
    " \"geometry\": [" FLOOR "]}";
static const char fire[] =
    "{\"tyndall\": 1, \"up_axis\": \"z\", \"camera\": {\"position\": [4.4, -5.4, 1.5], \"target\": [1, 1, 1.9],"
    " \"fov_y\": 38, \"resolution\": [540, 720]},"
    " \"media\": [{" PLUME_DENSITY ", \"albedo\": [0.8, 0.78, 0.75], \"g\": 0.4, \"emission\": {\"temperature\":"
    " {\"file\": \"" PLUME_FILE "\", \"grid\": \"temperature\"}, \"kelvin\": [300, 1000], \"scale\": 0.012}}],"
    " \"lights\": [{\"type\": \"environment\", \"radiance\": [0.008, 0.012, 0.022]}],"
    " \"geometry\": [" FLOOR "], \"render\": {\"spp\": 128}}";
static const char ct_head[] =
    "{\"tyndall\": 1, \"meters_per_unit\": 0.001, \"up_axis\": \"z\", \"camera\": {\"position\": [-250, -360, 120],"
    " \"target\": [101, 108, 66], \"fov_y\": 23, \"resolution\": [640, 640]},"
    " \"media\": [{\"density\": {\"file\": \"" CT_FILE "\"},"
    " \"transform\": {\"rotate\": [180, 0, 0], \"translate\": [0, 202, 138]}, \"transfer\": ["
    " {\"value\": 500, \"density\": 0, \"albedo\": [0.98, 0.9, 0.84]},"
    " {\"value\": 900, \"density\": 0.004, \"albedo\": [0.98, 0.9, 0.84]},"
    " {\"value\": 1150, \"density\": 0.006, \"albedo\": [0.97, 0.85, 0.78]},"
    " {\"value\": 1260, \"density\": 1, \"albedo\": [0.985, 0.97, 0.93]},"
    " {\"value\": 3000, \"density\": 1, \"albedo\": [0.985, 0.975, 0.95]}], \"sigma_t\": 5000}],"
    " \"lights\": [{\"type\": \"environment\", \"radiance\": [0.05, 0.06, 0.08]},"
    " {\"type\": \"area\", \"origin\": [-240, -820, 330], \"u\": [-260, 260, 0], \"v\": [60, 60, 260],"
    " \"radiance\": [22, 20, 17]}, {\"type\": \"area\", \"origin\": [520, 100, 100], \"u\": [0, -200, 0],"
    " \"v\": [-40, 0, 200], \"radiance\": [6, 8, 12]}]}";
static const char sponza_sky[] =
    "{\"tyndall\": 1, " SPONZA_CAMERA ", \"media\": [" SPONZA_FOG "],"
    " \"lights\": [{\"type\": \"environment\", \"sky\": {\"sun_direction\": [-0.5, -1, 0.42], \"sun\": true},"
    " \"scale\": 4}], \"geometry\": [{\"file\": \"" SPONZA_FILE "\"}], \"render\": {\"spp\": 256}}";
static const char sponza_lamps[] =
    "{\"tyndall\": 1, " SPONZA_CAMERA ", \"media\": [" SPONZA_FOG "], \"lights\": ["
    " {\"type\": \"directional\", \"direction\": [-0.3, -1, 0.3], \"irradiance\": [20, 18.5, 16]},"
    " {\"type\": \"point\", \"position\": [-6.2, 2.6, 4.4], \"intensity\": [8, 5, 2.4]},"
    " {\"type\": \"spot\", \"position\": [-5.6, 3.4, -3.2], \"direction\": [0.5, -1, 0.6], \"cone\": 70,"
    " \"penumbra\": 0.4, \"intensity\": [20, 26, 40]}],"
    " \"geometry\": [{\"file\": \"" SPONZA_FILE "\"}], \"render\": {\"spp\": 256, \"lpv\": {\"resolution\": 64}}}";
static const char cornell_smoke[] =
    "{\"tyndall\": 1, \"meters_per_unit\": 0.01, \"camera\": {\"position\": [-278, 273, 800],"
    " \"target\": [-278, 273, 0], \"fov_y\": 39, \"resolution\": [600, 600]}, \"media\": ["
    " {\"density\": {\"noise\": {\"kind\": \"cloud\", \"resolution\": [96, 64, 96], \"frequency\": 3, \"octaves\": 5,"
    " \"coverage\": 0.6, \"sharpness\": 3, \"seed\": 7}}, \"bounds\": [[-560, 0, -560], [-200, 330, -60]],"
    " \"sigma_t\": 3, \"albedo\": [0.97, 0.8, 0.995], \"g\": 0.3},"
    " {\"bounds\": [[-556, 0, -559], [0, 548, 0]], \"sigma_s\": 0.05}],"
    " \"geometry\": [{\"file\": \"" CORNELL_FILE "\"}], \"render\": {\"spp\": 256}}";
static const char staircase[] =
    "{\"tyndall\": 1, \"camera\": {\"file\": \"" STAIRCASE_FILE "\", \"resolution\": [540, 960]},"
    " \"media\": [{\"bounds\": [[-4.2, -0.17, -5.3], [2.6, 7.2, 5.2]], \"sigma_s\": 0.09, \"sigma_a\": 0.002,"
    " \"g\": 0.5}], \"geometry\": [{\"file\": \"" STAIRCASE_FILE "\"}], \"render\": {\"spp\": 128}}";

/* Of no scene file. */
static const char milk_ball[] =
    "{\"tyndall\": 1, \"camera\": {\"position\": [0, 0.16, 0.5], \"target\": [0, 0.05, 0], \"fov_y\": 28,"
    " \"resolution\": [480, 360]}, \"media\": [{\"bounds\": {\"sphere\": {\"center\": [0, 0.05, 0], \"radius\": 0.05}},"
    " \"preset\": \"skimmilk\"}], \"lights\": [{\"type\": \"environment\", \"sky\": {\"sun\": true}}],"
    " \"geometry\": [{\"quad\": {\"origin\": [-1, 0, 1], \"u\": [2, 0, 0], \"v\": [0, 0, -2]},"
    " \"material\": {\"albedo\": 0.4}}]}";
static const char fog_bank[] =
    "{\"tyndall\": 1, \"camera\": {\"position\": [0, 40, 320], \"target\": [0, 15, 0], \"fov_y\": 40,"
    " \"resolution\": [960, 540]}, \"media\": [{\"bounds\": [[-150, 0, -150], [150, 30, 150]], \"sigma_s\": 0.03,"
    " \"g\": 0.85}], \"lights\": [{\"type\": \"environment\", \"sky\": {\"sun\": true}}],"
    " \"geometry\": [{\"quad\": {\"origin\": [-2000, 0, 2000], \"u\": [4000, 0, 0], \"v\": [0, 0, -4000]},"
    " \"material\": {\"albedo\": 0.2}}]}";
static const char lamp_in_smoke[] =
    "{\"tyndall\": 1, \"up_axis\": \"z\", \"camera\": {\"position\": [0, -3.4, 0.3], \"target\": [0, 0, 0],"
    " \"fov_y\": 30, \"resolution\": [480, 480]}, \"media\": [{\"density\": {\"noise\": {\"kind\": \"cloud\","
    " \"resolution\": 64, \"seed\": 3}}, \"bounds\": [[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]], \"sigma_t\": 12,"
    " \"albedo\": 0.9, \"g\": 0.2}],"
    " \"lights\": [{\"type\": \"point\", \"position\": [0.8, -0.5, 0.3], \"intensity\": [3, 2.5, 2]}]}";
static const char plume_square[] =
    "{\"tyndall\": 1, \"up_axis\": \"z\", \"camera\": {\"position\": [4.2, -5.2, 1.7], \"target\": [1, 1, 2.0],"
    " \"fov_y\": 36, \"resolution\": [540, 720]}, \"media\": [{" PLUME_DENSITY ", \"albedo\": 0.9, \"g\": 0.9}],"
    " \"lights\": [{\"type\": \"environment\", \"file\": \"" SQUARE_FILE "\"}]}";

const auto_scene auto_scenes[] = {
    {.name = "cube, g 0", .builtin = "builtin:cube_g0"},
    {.name = "cube, g 0.7", .builtin = "builtin:cube_g0.7"},
    {.name = "cube, g 0.96", .builtin = "builtin:cube_g0.96"},
    {.name = "cloud, sun", .builtin = "builtin:cloud_sun"},
    {.name = "cloud, sky", .builtin = "builtin:cloud_sky"},
    {.name = "nebulae", .builtin = "builtin:nebulae"},
    {.name = "cloud over a plain", .builtin = "builtin:demo"},
    {.name = "box in fog, area light", .builtin = "builtin:cornell_fog"},
    {.name = "box in fog, spot light", .builtin = "builtin:fog_cornell"},
    {.name = "hall of lamps in fog", .builtin = "builtin:lamps"},
    {.name = "atrium in fog, sun", .builtin = "builtin:atrium"},
    {.name = "room under water", .builtin = "builtin:screen_room"},
    {.name = "Disney cloud, sun", .text = cloud_sun, .file = CLOUD_FILE},
    {.name = "Disney cloud, dawn", .text = cloud_dawn, .file = CLOUD_FILE},
    {.name = "plume over a floor", .text = plume, .file = PLUME_FILE},
    {.name = "burning plume", .text = fire, .file = PLUME_FILE},
    {.name = "CT head", .text = ct_head, .file = CT_FILE},
    {.name = "Sponza in fog, sky", .text = sponza_sky, .file = SPONZA_FILE},
    {.name = "Sponza in fog, lamps", .text = sponza_lamps, .file = SPONZA_FILE},
    {.name = "box with smoke", .text = cornell_smoke, .file = CORNELL_FILE},
    {.name = "staircase in haze", .text = staircase, .file = STAIRCASE_FILE},
    {.name = "box in fog, g 0.8, area light", .builtin = "builtin:cornell_fog", .overrides = {"media[0].g=0.8"}},
    {.name = "thick cloud, g 0.9, sun",
     .builtin = "builtin:cloud_sun",
     .overrides = {"media[0].sigma_t=60", "media[0].g=0.9"},
     .held_out = true},
    {.name = "thin dark cloud, sky",
     .builtin = "builtin:cloud_sky",
     .overrides = {"media[0].sigma_t=5", "media[0].albedo=0.5"},
     .held_out = true},
    {.name = "box of smoke, spot light",
     .builtin = "builtin:fog_cornell",
     .overrides = {"media[0].sigma_t=3", "media[0].g=0.8"},
     .held_out = true},
    {.name = "atrium in dense fog",
     .builtin = "builtin:atrium",
     .overrides = {"media[0].sigma_s=0.3"},
     .held_out = true},
    {.name = "lamp beside smoke", .text = lamp_in_smoke, .held_out = true},
    {.name = "ball of milk", .text = milk_ball, .held_out = true},
    {.name = "fog bank on a plain", .text = fog_bank, .held_out = true},
    {.name = "box in thin fog, area light",
     .builtin = "builtin:cornell_fog",
     .overrides = {"media[0].sigma_t=0.3"},
     .held_out = true},
    {.name = "box in dark fog, area light",
     .builtin = "builtin:cornell_fog",
     .overrides = {"media[0].albedo=0.6"},
     .held_out = true},
    {.name = "plume in a square", .text = plume_square, .file = PLUME_FILE},
};
const int32_t auto_scene_count = sizeof auto_scenes / sizeof auto_scenes[0];

ty_result auto_load_scene(ty_context* context, const auto_scene* from, const char* data, ty_scene** out) {
    int32_t overrides = 0;
    while (overrides < AUTO_OVERRIDES_MAX && from->overrides[overrides] != NULL) ++overrides;
    if (from->builtin != NULL) return ty_scene_load(context, from->builtin, from->overrides, overrides, out);
    return ty_scene_parse(context, from->text, strlen(from->text), from->name, data, from->overrides, overrides, out);
}
