/* The viewer's texts for its clients (docs/view_protocol.md). */
#define _GNU_SOURCE
#include "cli/view/live_state.h"

#include "base/context.h"
#include "base/number.h"
#include "cli/session.h"
#include "io/scenes/scene_schema.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double status_seconds = 0.1;

/* Sends to all clients in a slot; releases the message. */
static void tell(view_live* live, view_slot slot, json_t* message) {
    char* text = json_dumps(message, JSON_COMPACT);
    json_decref(message);
    if (text != NULL && live->server != NULL) view_server_tell(live->server, slot, text);
    free(text);
}

static void send(view_server* server, int32_t client, json_t* message) {
    char* text = json_dumps(message, JSON_COMPACT);
    json_decref(message);
    if (text != NULL) view_server_send(server, client, text);
    free(text);
}

void view_refuse(view_server* server, int32_t client, json_int_t id, const char* text) {
    json_t* message = json_pack("{s:s, s:s}", "type", "error", "text", text);
    if (message == NULL) message = json_pack("{s:s, s:s}", "type", "error", "text", "the message is not understood");
    if (id >= 0) json_object_set_new(message, "id", json_integer(id));
    send(server, client, message);
}

void view_answer_done(view_live* live, const view_request* request, const char* key, const char* value) {
    json_t* message = json_pack("{s:s, s:s}", "type", "done", key, value);
    if (request->id >= 0) json_object_set_new(message, "id", json_integer(request->id));
    send(live->server, request->client, message);
}

void view_answer_unchanged(view_live* live, const view_request* request) {
    if (request->id < 0) return;
    send(live->server, request->client,
         json_pack("{s:s, s:I, s:i}", "type", "done", "id", request->id, "revision", (int)live->revision));
}

/* ---- status ---- */

/* A finite number, or null. */
static json_t* number(double value) {
    json_t* out = json_real(value);
    return out != NULL ? out : json_null();
}

/* Images per second over the last second of those that were shown. */
static double rate(const view_live* live) {
    enum { RING = sizeof live->shown_times / sizeof live->shown_times[0] };
    const double now = cli_wall_seconds();
    int32_t count = 0;
    double oldest = now;
    for (uint32_t i = 0; i < RING && i < live->shown_count; ++i) {
        if (now - live->shown_times[i] > 1) continue;
        ++count;
        if (live->shown_times[i] < oldest) oldest = live->shown_times[i];
    }
    return count > 1 && now > oldest ? count / (now - oldest) : 0;
}

/* "march" of "march_seconds". */
static void set_stage(json_t* times, const char* name, double ms) {
    char key[64];
    snprintf(key, sizeof key, "%.*s", (int)strcspn(name, "_"), name);
    json_object_set_new(times, key, number(ms));
}

static json_t* times_of(const view_live* live) {
    const view_times* times = &live->times;
    json_t* stages = json_object();
    for (int32_t i = 0; i < times->count; ++i) set_stage(stages, times->stages[i].name, times->stages[i].ms);
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "load", number(times->load), "solve", number(times->solve),
                     "view", number(times->view), "surfaces", number(times->surfaces), "latency",
                     number(times->latency), "stages", stages);
}

void view_tell_status(view_live* live, bool at_once) {
    const double now = cli_wall_seconds();
    if (!at_once && now - live->told < status_seconds) return;
    if (live->server == NULL) return;
    live->told = now;
    const view_accumulation* path = &live->path;
    const bool has_path = live->path_revision == live->revision;
    json_t* difference = json_null();
    if (live->has_difference)
        difference = json_pack("{s:o, s:o, s:o}", "mean_ratio", number(live->difference.mean_ratio), "rmse",
                               number(live->difference.rmse), "noise", number(live->difference.noise));
    json_t* message = json_pack(
        "{s:s, s:i, s:s, s:s, s:o, s:b, s:o, s:{s:o, s:o}, s:o, s:o, s:b, s:s}", "type", "status", "revision",
        (int)live->revision, "method", live->method->name, "stage", live->stage != NULL ? live->stage : "", "fraction",
        number(live->fraction), "final", live->shown == VIEW_SHOWN_FULL, "times", times_of(live), "path", "spp",
        number(has_path ? view_accumulation_spp(path) : 0), "seconds", number(has_path ? path->seconds : 0),
        "difference", difference, "fps", number(rate(live)), "paused", live->paused, "message", live->message);
    tell(live, VIEW_SLOT_STATUS, message);
}

/* ---- scene and welcome ---- */

static json_t* point(const double at[3]) {
    return json_pack("[o, o, o]", number(at[0]), number(at[1]), number(at[2]));
}

/* Metres and degrees. */
static json_t* camera_object(const view_live* live) {
    const ty_camera_def camera = ty_scene_camera(live->scene);
    return json_pack("{s:o, s:o, s:o, s:o}", "position", point(camera.position), "target", point(camera.target), "up",
                     point(camera.up), "fov_y", number(camera.fov_y));
}

static json_t* view_object(const view_live* live) {
    return json_pack("{s:s, s:s, s:b, s:b, s:i, s:i, s:o, s:o}", "method",
                     live->automatic ? "auto" : live->method->name, "chosen", live->method->name, "compare",
                     live->compare, "paused", live->paused, "width", (int)live->width, "height", (int)live->height,
                     "exposure", number(live->exposure), "camera", camera_object(live));
}

void view_tell_scene(view_live* live, const json_t* changed) {
    const char* text = ty_scene_editor_text(live->editor);
    json_t* view = view_object(live);
    json_t* message = json_pack("{s:s, s:i, s:o, s:O, s:o}", "type", "scene", "revision", (int)live->revision,
                                "document", json_loads(text, 0, NULL), "view", view, "changed",
                                changed != NULL ? json_deep_copy(changed) : json_array());
    pthread_mutex_lock(&live->mutex);
    free(live->document);
    free(live->view);
    live->document = strdup(text);
    live->view = json_dumps(view, JSON_COMPACT);
    live->document_revision = live->revision;
    pthread_mutex_unlock(&live->mutex);
    json_decref(view);
    if (message != NULL) tell(live, VIEW_SLOT_SCENE, message);
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

static json_t* presets_array(void) {
    json_t* out = json_array();
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i)
        json_array_append_new(out, json_string(ty_medium_preset_name(i)));
    return out;
}

char* view_welcome(view_live* live) {
    json_t* schema = ty_scene_schema_tree();
    json_t* message = json_pack(
        "{s:s, s:s, s:s, s:o, s:o, s:o, s:i, s:o, s:o, s:o, s:s, s:[o, o], s:b, s:b, s:f}", "type", "welcome",
        "version", ty_version(), "name", live->name, "document", json_loads(live->document, 0, NULL), "original",
        json_loads(live->original, 0, NULL), "view", json_loads(live->view, 0, NULL), "revision",
        (int)live->document_revision, "methods", methods_array(schema), "schema", schema, "presets", presets_array(),
        "up_axis", live->up_axis == TY_AXIS_Z ? "z" : "y", "extent", point(live->extent[0]), point(live->extent[1]),
        "remote", live->remote, "record", live->record != NULL, "meters_per_unit", live->meters_per_unit);
    char* text = message != NULL ? json_dumps(message, JSON_COMPACT) : NULL;
    json_decref(message);
    return text;
}

/* ---- the document as text ---- */

/* A word of a command line: as it is, or in single quotes. */
static void append_word(char** text, size_t* size, const char* word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,-+";
    const bool quoted = word[0] == '\0' || strspn(word, plain) != strlen(word);
    const size_t needed = *size + 4 * strlen(word) + 4;
    char* longer = realloc(*text, needed);
    if (longer == NULL) return;
    *text = longer;
    if (*size > 0) longer[(*size)++] = ' ';
    if (quoted) longer[(*size)++] = '\'';
    for (const char* at = word; *at != '\0'; ++at) {
        if (*at == '\'') {
            memcpy(longer + *size, "'\\''", 4);
            *size += 4;
        } else {
            longer[(*size)++] = *at;
        }
    }
    if (quoted) longer[(*size)++] = '\'';
    longer[*size] = '\0';
}

static char* command_of(view_live* live, char** changes, int32_t count) {
    char *text = NULL, number_text[32];
    size_t size = 0;
    const char* const first[] = {"tyndall", "render", live->scene_path, "--method", live->method->name, "--size"};
    for (size_t i = 0; i < sizeof first / sizeof first[0]; ++i) append_word(&text, &size, first[i]);
    snprintf(number_text, sizeof number_text, "%dx%d", (int)live->width, (int)live->height);
    append_word(&text, &size, number_text);
    for (int32_t i = 0; i < count; ++i) {
        append_word(&text, &size, "-D");
        append_word(&text, &size, changes[i]);
    }
    append_word(&text, &size, "-o");
    append_word(&text, &size, "out.exr");
    return text;
}

void view_answer_document(view_live* live, const view_request* request) {
    char *json = NULL, **changes = NULL;
    int32_t count = 0;
    ty_result result = ty_scene_editor_save_text(live->editor, &json);
    if (result == TY_OK) result = ty_scene_editor_overrides(live->editor, &changes, &count);
    char* command = result == TY_OK ? command_of(live, changes, count) : NULL;
    if (command == NULL) {
        const char* text = ty_take_error(live->context);
        view_refuse(live->server, request->client, request->id, text[0] != '\0' ? text : "not enough memory");
    } else {
        json_t* message = json_pack("{s:s, s:s, s:s}", "type", "done", "json", json, "command", command);
        if (request->id >= 0) json_object_set_new(message, "id", json_integer(request->id));
        send(live->server, request->client, message);
    }
    free(command);
    ty_free_text(live->context, json);
    ty_scene_editor_free_overrides(live->editor, changes, count);
}
