/* Rendering by the name of a method. */
#include "base/context.h"
#include "base/mapping.h"
#include "image/aovs.h"
#include "image/image.h"
#include "method/registry.h"
#include "scene/scene.h"

#include <stdio.h>
#include <string.h>

void ty_init_render_def(void* def, size_t bytes) {
    const ty_render_def own = {.state_seconds = TY_AUTO};
    ty_init_def(def, bytes, &own, sizeof own);
}

/* ---- measurements ---- */

typedef struct receiver {
    ty_measurement_fn function;
    void* user;
} receiver;

static void give_number(const receiver* to, const char* name, double number) {
    to->function(to->user, name, &number, 1, NULL);
}

static double stat_number(const ty_stat* stat, const char* field, int32_t element) {
    switch (stat->type) {
    case TY_STAT_INT: return ((const int32_t*)field)[element];
    case TY_STAT_LONG: return (double)((const int64_t*)field)[element];
    case TY_STAT_NUMBER: return ((const double*)field)[element];
    case TY_STAT_BOOL: return ((const bool*)field)[element];
    case TY_STAT_LATTICES: return ((const int32_t*)field)[element];
    case TY_STAT_TEXT: break;
    }
    return 0;
}

static void give_stat(const receiver* to, const ty_stat* stat, const char* stats) {
    enum { ELEMENTS_MAX = 24 };
    double numbers[ELEMENTS_MAX];
    const char* field = stats + stat->offset;
    if (stat->type == TY_STAT_TEXT) {
        const char* text = *(const char* const*)field;
        to->function(to->user, stat->name, NULL, 0, text != NULL ? text : "");
        return;
    }
    int32_t count = stat->count > 0 ? stat->count : 1;
    if (stat->type == TY_STAT_LATTICES) count *= 3;
    if (count > ELEMENTS_MAX) count = ELEMENTS_MAX;
    for (int32_t i = 0; i < count; ++i) numbers[i] = stat_number(stat, field, i);
    to->function(to->user, stat->name, numbers, count, NULL);
}

static void give_measurements(const receiver* to, const ty_method* method, const ty_method_run* run) {
    if (to->function == NULL) return;
    for (int32_t i = 0; i < method->stat_count && !run->enclosed; ++i)
        if (strcmp(method->stats[i].name, "seconds") != 0 && strcmp(method->stats[i].name, "isa") != 0)
            give_stat(to, &method->stats[i], run->stats);
    give_number(to, "spp", run->path.spp);
    give_number(to, "paths", (double)run->path.paths);
    give_number(to, "vertices", (double)run->path.vertices);
    give_number(to, "error", run->path.error);
    give_number(to, "error_pixels", run->path.error_pixels);
    give_number(to, "own_seconds", run->own_seconds);
    give_number(to, "cpu_seconds", run->path.cpu_seconds);
    give_number(to, "seconds", run->path.seconds);
}

/* ---- requests ---- */

static ty_result find_method(ty_context* context, const char* name, const ty_method** out) {
    *out = ty_method_find(name);
    if (*out != NULL) return TY_OK;
    char known[256] = "";
    for (int32_t i = 0; ty_methods[i] != NULL; ++i) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i > 0 ? ", " : "", ty_methods[i]->name);
    }
    return ty_fail(context, TY_ERROR_ARGUMENT, "there is no method %.15s; known: %s", name, known);
}

static ty_result check_channels(ty_context* context, const ty_method* method, uint32_t aovs) {
    const uint32_t outside = aovs & ~method->aovs;
    if (outside == 0) return TY_OK;
    for (int32_t i = 0; i < TY_AOV_GROUPS; ++i)
        if (ty_aov_groups[i].aov != TY_AOV_COLOR && (ty_aov_groups[i].aov & ~outside) == 0)
            return ty_fail(context, TY_ERROR_ARGUMENT, "the method %s has no channel %s", method->name,
                           ty_aov_groups[i].names[0]);
    return ty_fail(context, TY_ERROR_ARGUMENT, "the method %s has not all of the channels 0x%x", method->name,
                   (unsigned)aovs);
}

static ty_result check(const ty_scene* scene, const ty_render_def* def, const ty_method* method) {
    const ty_result result = check_channels(scene->context, method, def->aovs);
    if (result != TY_OK) return result;
    if (def->crop[2] > 0 && !method->crops)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                       "the method %s renders whole frames, since light spreads over them", method->name);
    if ((def->state != NULL || def->resume != NULL) && method != &ty_method_path)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "the method %s has no states; path has", method->name);
    return method->check != NULL ? method->check(scene) : TY_OK;
}

ty_result ty_render(const ty_scene* scene, const ty_render_def* given, ty_image** out) {
    if (scene == NULL || out == NULL) return ty_fail(NULL, TY_ERROR_ARGUMENT, "ty_render: scene or out is NULL");
    *out = NULL;
    ty_render_def def = ty_default_render_def();
    ty_result result = ty_take_def(scene->context, given, "ty_default_render_def", &def, sizeof def);
    if (result != TY_OK) return result;
    const ty_render_settings settings = def.settings != NULL ? *def.settings : scene->settings;
    const ty_method* method = NULL;
    result = find_method(scene->context, settings.method, &method);
    if (result == TY_OK) result = check(scene, &def, method);
    if (result != TY_OK) return result;
    ty_render_request request = {.spp = settings.spp,
                                 .seed = settings.seed,
                                 .seconds = def.seconds,
                                 .error = def.error,
                                 .width = def.width,
                                 .height = def.height,
                                 .aovs = def.aovs,
                                 .progress = def.progress,
                                 .progress_user = def.progress_user,
                                 .partial = def.partial,
                                 .partial_user = def.partial_user,
                                 .state = def.state,
                                 .state_user = def.state_user,
                                 .state_seconds = def.state_seconds,
                                 .resume = def.resume,
                                 .resume_size = def.resume_size};
    memcpy(request.crop, def.crop, sizeof request.crop);
    ty_method_run run = {.own_seconds = 0};
    result = method->render(scene, &request, out, &run);
    if (*out != NULL && ty_mappings_check(scene->context) != TY_OK) {
        ty_image_destroy(*out);
        *out = NULL;
        return TY_ERROR_INPUT;
    }
    if (*out != NULL) give_measurements(&(receiver){def.measurement, def.measurement_user}, method, &run);
    return result;
}
