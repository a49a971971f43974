/* A scene as what the viewer shows: its editor, the choice of its method, and what clients learn of it. */
#define _GNU_SOURCE
#include "cli/view/live_state.h"

#include "base/context.h"
#include "cli/session/ranks.h"
#include "cli/text/text.h"
#include "io/scenes/scene_schema.h"

#include <tyndall/choose.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SIDE_MAX_X = 960, SIDE_MAX_Y = 540 };

/* ---- the method ---- */

/* Without trials, which take longer than an image may. */
static const ty_method* choose(view_live* live) {
    ty_choose_def def = ty_default_choose_def();
    ty_choice choice;
    def.trials = false;
    def.width = live->width;
    def.height = live->height;
    live->choice_due = false;
    live->expected_error = live->expected_seconds = 0;
    if (ty_choose_method(live->scene, &def, &choice) != TY_OK) {
        ty_take_error(live->context);
        return &ty_method_path;
    }
    live->expected_error = choice.error;
    live->expected_seconds = choice.seconds / ty_context_threads(live->context);
    return ty_method_find(choice.method);
}

static void take_method(view_live* live, const ty_method* method) {
    live->method = method;
    live->shown = VIEW_SHOWN_NOTHING;
    live->failed = false;
    view_coarse_forget(live);
    live->has_difference = false;
    live->message[0] = '\0';
}

static bool set_method(view_live* live, const char* name) {
    const bool automatic = strcmp(name, "auto") == 0;
    const ty_method* method = automatic ? choose(live) : ty_method_find(name);
    if (method == NULL) return false;
    live->automatic = automatic;
    take_method(live, method);
    return true;
}

void view_choose_again(view_live* live) {
    if (!live->choice_due || live->moved > 0) return;
    const ty_method* method = live->automatic ? choose(live) : live->method;
    live->choice_due = false;
    if (method == live->method) return;
    take_method(live, method);
    view_tell_scene(live, NULL);
}

/* ---- edits ---- */

/* The other ranks, if there are any, have the same document before their next task. */
static ty_result apply(view_live* live, const ty_scene_change* changes, int32_t count, uint32_t* edited) {
    ty_work_queue* queue = ty_context_queue(live->context);
    const ty_result result = ty_scene_editor_apply(live->editor, changes, count, edited);
    if (result == TY_OK && queue != NULL) ty_queue_tell(queue, ty_scene_editor_text(live->editor));
    return result;
}

static void take(view_live* live, uint32_t edited) {
    live->scene = ty_scene_editor_scene(live->editor);
    live->up_axis = ty_scene_up_axis(live->scene);
    const ty_scene_info info = ty_scene_get_info(live->scene);
    live->has_surfaces = info.shapes > 0 || info.meshes > 0;
    pthread_mutex_lock(&live->mutex);
    memcpy(live->extent[0], info.lower, sizeof info.lower);
    memcpy(live->extent[1], info.upper, sizeof info.upper);
    pthread_mutex_unlock(&live->mutex);
    const bool light = (edited & (TY_EDIT_LIGHT | TY_EDIT_GEOMETRY | TY_EDIT_RENDER)) != 0;
    if (light || (live->light_method != NULL && live->light_method->follows_camera != NULL &&
                  live->light_method->follows_camera(live->scene)))
        view_live_drop_light(live);
    if (!live->automatic || !light) return;
    if (live->moved > 0) {
        live->choice_due = true;
        return;
    }
    const ty_method* method = choose(live);
    if (method != live->method) take_method(live, method);
}

static const char* text(const view_live* live) {
    return ty_scene_editor_text(live->editor);
}

/* ---- what clients learn ---- */

static json_t* point(const double at[3]) {
    return json_pack("[o, o, o]", view_number(at[0]), view_number(at[1]), view_number(at[2]));
}

/* Metres and degrees. */
static json_t* camera_object(const view_live* live) {
    const ty_camera_def camera = ty_scene_camera(live->scene);
    return json_pack("{s:o, s:o, s:o, s:o}", "position", point(camera.position), "target", point(camera.target), "up",
                     point(camera.up), "fov_y", view_number(camera.fov_y));
}

static void describe_view(const view_live* live, json_t* view) {
    json_object_set_new(view, "camera", camera_object(live));
    const bool expected = live->automatic && live->expected_seconds > 0;
    json_object_set_new(view, "expected",
                        expected ? json_pack("{s:o, s:o}", "error", view_number(live->expected_error), "seconds",
                                             view_number(live->expected_seconds))
                                 : json_null());
}

static json_t* methods_array(json_t* schema) {
    json_t* out = json_array();
    json_t* options = json_object_get(json_object_get(json_object_get(schema, "properties"), "render"), "properties");
    if (options == NULL) /* the section is a definition of its own */
        options = json_object_get(json_object_get(json_object_get(schema, "$defs"), "render"), "properties");
    for (int i = 0; ty_methods[i] != NULL; ++i) {
        json_t* of_method = json_object_get(options, ty_methods[i]->name);
        json_array_append_new(out, json_pack("{s:s, s:s, s:O?}", "name", ty_methods[i]->name, "summary",
                                             ty_methods[i]->summary, "options", of_method));
    }
    return out;
}

static void describe(const view_live* live, json_t* welcome) {
    json_t* schema = ty_scene_schema_tree();
    json_t* parts = json_pack("{s:o, s:o, s:o, s:s, s:[o, o], s:f}", "methods", methods_array(schema), "schema", schema,
                              "presets", view_presets(), "up_axis", live->up_axis == TY_AXIS_Z ? "z" : "y", "extent",
                              point(live->extent[0]), point(live->extent[1]), "meters_per_unit", live->meters_per_unit);
    json_object_update(welcome, parts);
    json_decref(parts);
}

/* ---- the document as text ---- */

static char* command_of(view_live* live, char** changes, int32_t count) {
    char *text = NULL, number_text[32];
    size_t size = 0;
    const char* const first[] = {"tyndall", "render", live->scene_path, "--method", live->method->name, "--size"};
    for (size_t i = 0; i < sizeof first / sizeof first[0]; ++i) cli_append_word(&text, &size, first[i]);
    snprintf(number_text, sizeof number_text, "%dx%d", (int)live->width, (int)live->height);
    cli_append_word(&text, &size, number_text);
    for (int32_t i = 0; i < count; ++i) {
        cli_append_word(&text, &size, "-D");
        cli_append_word(&text, &size, changes[i]);
    }
    cli_append_word(&text, &size, "-o");
    cli_append_word(&text, &size, "out.exr");
    return text;
}

static ty_result save(view_live* live, char** json, char** command) {
    char *saved = NULL, **changes = NULL;
    int32_t count = 0;
    ty_result result = ty_scene_editor_save_text(live->editor, &saved);
    if (result == TY_OK) result = ty_scene_editor_overrides(live->editor, &changes, &count);
    if (result == TY_OK) {
        *json = strdup(saved);
        *command = command_of(live, changes, count);
    }
    ty_free_text(live->context, saved);
    ty_scene_editor_free_overrides(live->editor, changes, count);
    return result;
}

/* ---- opening and closing ---- */

static void choose_size(view_live* live, const view_live_def* def) {
    const ty_camera_def camera = ty_scene_camera(live->scene);
    live->width = def->width > 0 ? def->width : camera.resolution[0];
    live->height = def->width > 0 ? def->height : camera.resolution[1];
    const double fit = fmin(1, fmin((double)SIDE_MAX_X / live->width, (double)SIDE_MAX_Y / live->height));
    if (def->width > 0 || fit >= 1) return;
    live->width = (int32_t)fmax(16, floor(fit * live->width));
    live->height = (int32_t)fmax(16, floor(fit * live->height));
}

/* The document's unit of length. */
static double document_unit(const view_live* live) {
    json_t* document = json_loads(ty_scene_editor_text(live->editor), 0, NULL);
    const json_t* unit = json_object_get(document, "meters_per_unit");
    const double meters = json_is_number(unit) ? json_number_value(unit) : 1;
    json_decref(document);
    return meters;
}

static ty_result open_editor(view_live* live, const view_live_def* def) {
    ty_result result =
        ty_scene_editor_open(live->context, def->path, def->overrides, def->override_count, &live->editor);
    if (result != TY_OK) return result;
    take(live, 0);
    live->meters_per_unit = document_unit(live);
    live->exposure = ty_scene_camera(live->scene).exposure;
    choose_size(live, def);
    const ty_render_settings settings = ty_scene_render_settings(live->scene);
    if (!set_method(live, def->method != NULL ? def->method : settings.method)) result = TY_ERROR_ARGUMENT;
    return result;
}

static void close_scene(view_live* live) {
    view_live_drop_light(live);
    view_accumulation_free(&live->surfaces);
    view_accumulation_free(&live->path);
    ty_scene_editor_close(live->editor);
}

static const view_source scene_source = {.kind = "scene",
                                         .reference = "path",
                                         .apply = apply,
                                         .take = take,
                                         .set_method = set_method,
                                         .step = view_step_scene,
                                         .text = text,
                                         .describe_view = describe_view,
                                         .describe = describe,
                                         .save = save,
                                         .close = close_scene};

int view_open_scene(view_live* live, const view_live_def* def) {
    live->source = &scene_source;
    live->curve = TY_TONE_FILMIC;
    const ty_result result = open_editor(live, def);
    return result == TY_OK ? cli_ranks_greet(def->session, live->scene) : cli_fail_reading(def->session, result);
}
