/* Choice of the method for a scene: rules in the order of docs/method/auto.md. */
#include "base/context.h"
#include "choose/features.h"
#include "image/march.h"
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

/* Thresholds of the rules on scene features, measured by `tyndall figure auto-choice`. */
static const double min_opacity = 2e-3; /* opacity below which media are negligible */
static const double max_enclosed =
    0.5; /* fraction of the scattered light; above it, surfaces and media light each other */
static const double max_surfaces =
    0.3; /* fraction of the frame; above it, path tracing's treatment of surfaces matters */
static const double few_scatterings = 4;  /* number of scatterings below which paths are cheap */
static const double max_cell = 10;        /* cell size in reduced mean free paths */
static const double g_directional = 0.65; /* g from which cells resolve the directions of light from surfaces poorly */
static const double g_path_only = 0.94;   /* g from which only path tracing resolves the directions of light */

enum { LPV_LIGHTS = 1 << TY_LIGHT_DIRECTIONAL | 1 << TY_LIGHT_POINT | 1 << TY_LIGHT_SPOT };

void ty_init_choose_def(void* def, size_t bytes) {
    const ty_choose_def own = {0};
    ty_init_def(def, bytes, &own, sizeof own);
}

/* ---- reason text ---- */

static void append(char* text, size_t size, const char* more) {
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "%s", more);
}

/* For example "the sun, lamps and an environment". */
static void name_lights(uint32_t lights, char* out, size_t size) {
    static const struct {
        uint32_t kinds;
        const char* name;
    } names[] = {{1 << TY_LIGHT_DIRECTIONAL, "the sun"},
                 {1 << TY_LIGHT_POINT | 1 << TY_LIGHT_SPOT, "lamps"},
                 {1 << TY_LIGHT_AREA, "glowing surfaces"},
                 {1 << TY_LIGHT_ENVIRONMENT, "an environment"}};
    enum { NAMES = sizeof names / sizeof names[0] };
    int left = 0;
    for (int i = 0; i < NAMES; ++i) left += (lights & names[i].kinds) != 0;
    out[0] = '\0';
    for (int i = 0; i < NAMES; ++i) {
        if ((lights & names[i].kinds) == 0) continue;
        append(out, size, names[i].name);
        --left;
        if (left > 0) append(out, size, left > 1 ? ", " : " and ");
    }
}

static bool media_emit(const ty_scene_features* features) {
    return features->glows;
}

/* For example "media of optical thickness 40, g 0.85, lit by the sun". */
static void describe(const ty_scene_features* features, char* out, size_t size) {
    char lights[80];
    name_lights(features->lights, lights, sizeof lights);
    snprintf(out, size, "%s media of optical thickness up to %.2g, g %.2g%s%s%s",
             features->heterogeneous ? "uneven" : "even", features->thickness, features->g,
             lights[0] != '\0' ? ", lit by " : "", lights, media_emit(features) ? ", that glow" : "");
}

static void set(ty_choice* out, const char* method, const char* because) {
    char media[160];
    out->method = method;
    describe(&out->features, media, sizeof media);
    snprintf(out->reason, sizeof out->reason, "%s; %s", media, because);
}

/* ---- rules ---- */

typedef struct request {
    uint32_t ask;
    const char* words;
} request;

/* True if only path tracing supports the request. */
static bool asks_path(const ty_choose_def* def, ty_choice* out) {
    static const request asks[] = {{TY_ASK_RESUME, "it alone can go on later"},
                                   {TY_ASK_ERROR, "it alone goes on until an error is reached"},
                                   {TY_ASK_TIME, "it alone makes the best of a time"},
                                   {TY_ASK_CROP, "it alone renders a part of the frame"},
                                   {TY_ASK_SAMPLES, "samples per pixel are asked for"}};
    for (size_t i = 0; i < sizeof asks / sizeof asks[0]; ++i)
        if ((def->asks & asks[i].ask) != 0) {
            snprintf(out->reason, sizeof out->reason, "%s", asks[i].words);
            return true;
        }
    if ((def->aovs & ~(uint32_t)(TY_MARCH_AOVS | TY_AOV_SAMPLES)) == 0) return false;
    snprintf(out->reason, sizeof out->reason, "it alone has all channels that are asked for");
    return true;
}

/* Estimated number of scatterings before absorption or escape, by the reduced optical thickness. */
static double scatterings(const ty_scene_features* features) {
    const double reduced = features->thickness * (1 - features->g);
    return 1 / (1 / (1 + reduced) + 1 - features->albedo);
}

/* True if surfaces cover much of the frame and paths are cheap; the faster methods trace paths for surfaces as well.
 * If area lights are the only light, paths are noisier than cells, which gather that light from all directions at
 * once. */
static bool suits_paths(const ty_scene_features* features) {
    const bool lit_by_surfaces = features->lights == 1 << TY_LIGHT_AREA && features->g < g_directional;
    return features->surfaces > max_surfaces && scatterings(features) < few_scatterings && !lit_by_surfaces;
}

static const char* ordinates_reason(const ty_scene_features* features) {
    if (!(features->surfaces > 0)) return "no surfaces";
    if (!(scatterings(features) < few_scatterings)) return "light scatters more than paths are cheap for";
    return features->surfaces > max_surfaces ? "glowing surfaces are all the light" : "few surfaces";
}

/* True if light comes from what lpv takes alone, into media whose emission and narrow phase functions it need not
 * scatter. */
static bool suits_lpv(const ty_scene_features* features) {
    return features->enclosed > max_enclosed && (features->lights & ~(uint32_t)LPV_LIGHTS) == 0 &&
           !media_emit(features) && features->g <= g_path_only;
}

static void choose_by_features(ty_choice* out) {
    const ty_scene_features* features = &out->features;
    if (features->opacity < min_opacity)
        snprintf(out->reason, sizeof out->reason, "no media are in view");
    else if (suits_lpv(features))
        set(out, "lpv", "surfaces all around, which lamps or the sun light");
    else if (features->cell * (1 - features->g) > max_cell)
        set(out, "path", "too dense for the cells of faster methods");
    else if (suits_paths(features))
        set(out, "path", "much of the frame is surfaces, and light scatters seldom");
    else if (features->g > g_path_only && scatterings(features) < few_scatterings)
        set(out, "path", "light goes nearly straight on");
    else
        set(out, "dom", ordinates_reason(features));
}

ty_result ty_choose_method(const ty_scene* scene, const ty_choose_def* def, ty_choice* out) {
    ty_context* context = ty_scene_context(scene);
    ty_choose_def own = ty_default_choose_def();
    ty_result result = ty_take_def(context, def, "ty_default_choose_def", &own, sizeof own);
    if (result == TY_OK && ty_scene_get_view(scene) == NULL) result = TY_ERROR_ARGUMENT;
    ty_choice choice = {.method = "path"};
    if (result == TY_OK) result = ty_scene_features_find(scene, &choice.features);
    if (result != TY_OK) return result;
    if (!asks_path(&own, &choice)) choose_by_features(&choice);
    *out = choice;
    return TY_OK;
}
