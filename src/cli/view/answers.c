/* The viewer's texts for its clients (docs/view_protocol.md). */
#define _GNU_SOURCE
#include "cli/view/live_state.h"

#include "cli/session/session.h"

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

/* The same of an object with a further member, whose value is JSON text. */
static void tell_with(view_live* live, view_slot slot, json_t* message, const char* key, const char* value) {
    char *text = json_dumps(message, JSON_COMPACT), *whole = NULL;
    json_decref(message);
    if (text != NULL) {
        text[strlen(text) - 1] = '\0';
        if (asprintf(&whole, "%s,\"%s\":%s}", text, key, value) < 0) whole = NULL;
    }
    if (whole != NULL && live->server != NULL) view_server_tell(live->server, slot, whole);
    free(whole);
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

json_t* view_number(double value) {
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
    json_object_set_new(times, key, view_number(ms));
}

static json_t* times_of(const view_live* live) {
    const view_times* times = &live->times;
    json_t* stages = json_object();
    for (int32_t i = 0; i < times->count; ++i) set_stage(stages, times->stages[i].name, times->stages[i].ms);
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "load", view_number(times->load), "solve",
                     view_number(times->solve), "view", view_number(times->view), "surfaces",
                     view_number(times->surfaces), "latency", view_number(times->latency), "stages", stages);
}

/* Why the method refuses the scene, or what it does not show of it; "": nothing. */
static const char* message_of(const view_live* live) {
    if (live->message[0] != '\0' || live->scene == NULL) return live->message;
    const char* unseen = ty_method_of_interiors(live->method, live->scene);
    return unseen != NULL ? unseen : "";
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
        difference = json_pack("{s:o, s:o, s:o}", "mean_ratio", view_number(live->difference.mean_ratio), "rmse",
                               view_number(live->difference.rmse), "noise", view_number(live->difference.noise));
    json_t* message = json_pack(
        "{s:s, s:i, s:s, s:s, s:o, s:b, s:o, s:{s:o, s:o}, s:o, s:o, s:b, s:s}", "type", "status", "revision",
        (int)live->revision, "method", live->method->name, "stage", live->stage != NULL ? live->stage : "", "fraction",
        view_number(live->fraction), "final", live->shown == VIEW_SHOWN_FULL, "times", times_of(live), "path", "spp",
        view_number(has_path ? view_accumulation_spp(path) : 0), "seconds", view_number(has_path ? path->seconds : 0),
        "difference", difference, "fps", view_number(rate(live)), "paused", live->paused, "message", message_of(live));
    tell(live, VIEW_SLOT_STATUS, message);
}

/* ---- scene and welcome ---- */

static json_t* view_object(const view_live* live) {
    json_t* view =
        json_pack("{s:s, s:s, s:b, s:b, s:i, s:i, s:s, s:o}", "method", live->automatic ? "auto" : live->method->name,
                  "chosen", live->method->name, "compare", live->compare, "paused", live->paused, "width",
                  (int)live->width, "height", (int)live->height, "curve",
                  live->curve == TY_TONE_FILMIC ? "filmic" : "srgb", "exposure", view_number(live->exposure));
    if (view != NULL) live->source->describe_view(live, view);
    return view;
}

void view_tell_scene(view_live* live, const json_t* changed) {
    const char* text = live->source->text(live);
    json_t* view = view_object(live);
    json_t* message = json_pack("{s:s, s:i, s:O, s:o}", "type", "scene", "revision", (int)live->revision, "view", view,
                                "changed", changed != NULL ? json_deep_copy(changed) : json_array());
    pthread_mutex_lock(&live->mutex);
    free(live->document);
    free(live->view);
    live->document = strdup(text);
    live->view = json_dumps(view, JSON_COMPACT);
    live->document_revision = live->revision;
    pthread_mutex_unlock(&live->mutex);
    json_decref(view);
    if (message != NULL) tell_with(live, VIEW_SLOT_SCENE, message, "document", text);
}

json_t* view_presets(void) {
    json_t* out = json_array();
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i)
        json_array_append_new(out, json_string(ty_medium_preset_name(i)));
    return out;
}

char* view_welcome(view_live* live) {
    json_t* message =
        json_pack("{s:s, s:s, s:s, s:s, s:s, s:o, s:o, s:o, s:i, s:b, s:b}", "type", "welcome", "version", ty_version(),
                  "kind", live->source->kind, "reference", live->source->reference, "name", live->name, "document",
                  json_loads(live->document, 0, NULL), "original", json_loads(live->original, 0, NULL), "view",
                  json_loads(live->view, 0, NULL), "revision", (int)live->document_revision, "remote", live->remote,
                  "record", live->record != NULL);
    if (message != NULL) live->source->describe(live, message);
    char* text = message != NULL ? json_dumps(message, JSON_COMPACT) : NULL;
    json_decref(message);
    return text;
}

/* ---- the document as text ---- */

void view_answer_document(view_live* live, const view_request* request) {
    char *json = NULL, *command = NULL;
    const ty_result result = live->source->save(live, &json, &command);
    if (result != TY_OK || json == NULL || command == NULL) {
        const char* text = ty_take_error(live->context);
        view_refuse(live->server, request->client, request->id, text[0] != '\0' ? text : "not enough memory");
    } else {
        json_t* message = json_pack("{s:s, s:s, s:s}", "type", "done", "json", json, "command", command);
        if (request->id >= 0) json_object_set_new(message, "id", json_integer(request->id));
        send(live->server, request->client, message);
    }
    free(command);
    free(json);
}
