/* Choice of the method for a scene: the least expected cost of error and time (docs/method/auto.md). */
#include "base/context.h"
#include "choose/features.h"
#include "choose/predict.h"
#include "choose/trial.h"
#include "image/march/march.h"
#include "method/method.h"
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

/* Opacity of the view below which media are negligible: paths of surfaces are then all that any method traces. */
static const double min_opacity = 2e-3;
/* Interactions of the pilot's paths, which take about a tenth of a second, with trials and without. */
static const double tried_interactions = 400e3, untried_interactions = 0;

void ty_init_choose_def(void* def, size_t bytes) {
    const ty_choose_def own = {.trials = true};
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
    return features->emissive_media;
}

/* For example "media of optical thickness 40, g 0.85, lit by the sun". */
static void describe(const ty_scene_features* features, char* out, size_t size) {
    char lights[80];
    name_lights(features->lights, lights, sizeof lights);
    snprintf(out, size, "%s media of optical thickness up to %.2g, g %.2g%s%s%s",
             features->heterogeneous ? "uneven" : "even", features->thickness, features->g,
             lights[0] != '\0' ? ", lit by " : "", lights, media_emit(features) ? ", that glow" : "");
}

/* ---- requests ---- */

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

/* ---- the least cost ---- */

/* False if the method refuses the scene or a channel, or leaves out media in dielectrics. */
static bool takes(const ty_method* method, const ty_scene* scene, const ty_choose_def* def) {
    if (method == NULL || (def->aovs & ~method->aovs) != 0) return false;
    if (method->enclose == NULL && ty_method_of_interiors(method, scene) != NULL) return false;
    if (method->check == NULL || method->check(scene) == TY_OK) return true;
    ty_take_error(ty_scene_context(scene));
    return false;
}

static ty_picture_size size_of(const ty_scene* scene, const ty_choose_def* def) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const int32_t spp = def->spp > 0 ? def->spp : ty_scene_render_settings(scene).spp;
    const double width = def->width > 0 ? def->width : camera.resolution[0];
    const double height = def->height > 0 ? def->height : camera.resolution[1];
    return (ty_picture_size){width * height, spp};
}

const char* ty_choice_method_name(int32_t index) {
    return index >= 0 && index < ty_fitted_model.count ? ty_fitted_model.methods[index].name : NULL;
}

/* Traces the pilot and tries the methods that take the scene. */
static ty_result measure(const ty_scene* scene, const ty_choose_def* def, bool path_only, ty_scene_features* out) {
    const bool tried = def->trials && !path_only;
    ty_pilot pilot;
    const ty_result result = ty_pilot_trace(scene, tried ? tried_interactions : untried_interactions, &pilot, out);
    if (result == TY_OK && tried) {
        out->trial_noise = ty_trial_noise(&pilot);
        for (int32_t i = 1; i < ty_fitted_model.count; ++i) {
            const ty_method* method = ty_method_find(ty_fitted_model.methods[i].name);
            if (takes(method, scene, def)) out->trials[i] = ty_trial(scene, method, &pilot);
        }
    }
    ty_pilot_free(&pilot);
    return result;
}

/* The method of the least expected cost, and in words the one that comes next. */
static void choose_by_cost(const ty_scene* scene, const ty_choose_def* def, ty_choice* out) {
    const ty_picture_size size = size_of(scene, def);
    const char* next = NULL;
    double cost_min = INFINITY, second = INFINITY;
    for (int32_t i = 0; i < ty_fitted_model.count; ++i) {
        const char* name = ty_fitted_model.methods[i].name;
        if (i > 0 && !takes(ty_method_find(name), scene, def)) continue;
        const ty_expectation expected = ty_expect(&ty_fitted_model, i, &out->features, &size);
        const double cost = ty_cost_of(&expected);
        if (cost < cost_min) {
            second = cost_min;
            next = i > 0 ? out->method : NULL;
            cost_min = cost;
            out->method = name;
            out->error = expected.error;
            out->seconds = expected.seconds;
        } else if (cost < second) {
            second = cost;
            next = name;
        }
    }
    describe(&out->features, out->reason, sizeof out->reason);
    if (next == NULL) return;
    char more[80];
    if (second < 1.05 * cost_min)
        snprintf(more, sizeof more, "; %s is expected to cost the same", next);
    else
        snprintf(more, sizeof more, "; %s comes next, at %.2g times the cost", next, second / cost_min);
    append(out->reason, sizeof out->reason, more);
}

/* Path alone, with what is expected of it. */
static void choose_path(const ty_scene* scene, const ty_choose_def* def, ty_choice* out) {
    const ty_picture_size size = size_of(scene, def);
    const ty_expectation expected = ty_expect(&ty_fitted_model, 0, &out->features, &size);
    out->error = expected.error;
    out->seconds = expected.seconds;
}

ty_result ty_choose_method(const ty_scene* scene, const ty_choose_def* def, ty_choice* out) {
    ty_context* context = ty_scene_context(scene);
    ty_choose_def own = ty_default_choose_def();
    ty_result result = ty_take_def(context, def, "ty_default_choose_def", &own, sizeof own);
    if (result == TY_OK && ty_scene_get_view(scene) == NULL) result = TY_ERROR_ARGUMENT;
    ty_choice choice = {.method = "path"};
    if (result == TY_OK) result = ty_scene_features_find(scene, &choice.features);
    if (result != TY_OK) return result;
    bool path_only = asks_path(&own, &choice);
    if (!path_only && ty_scene_get_view(scene)->periodic.axes != 0) {
        snprintf(choice.reason, sizeof choice.reason, "it alone takes periodic scenes");
        path_only = true;
    }
    if (!path_only && choice.features.opacity < min_opacity) {
        snprintf(choice.reason, sizeof choice.reason, "no media are in view");
        path_only = true;
    }
    result = measure(scene, &own, path_only, &choice.features);
    if (result != TY_OK) return result;
    if (path_only)
        choose_path(scene, &own, &choice);
    else
        choose_by_cost(scene, &own, &choice);
    *out = choice;
    return TY_OK;
}
