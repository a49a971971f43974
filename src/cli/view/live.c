#define _GNU_SOURCE
#include "cli/view/live_state.h"

#include "cli/session/session.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double rest_seconds = 0.3;      /* without messages after which a drag counts as ended */
static const double patience_seconds = 0.02; /* of a change that waits for its image, while others arrive */

/* ---- requests ---- */

static void begin_revision(view_live* live, const view_request* request) {
    ++live->revision;
    live->rested = false;
    live->shown = VIEW_SHOWN_NOTHING;
    live->failed = false;
    live->has_difference = false;
    live->message[0] = '\0';
    live->moved = request->moving ? cli_wall_seconds() : 0;
    if (live->received == 0) live->received = request->received;
}

/* Changes that clients ask for, as the editor takes them. Returns NULL without memory. */
static ty_scene_change* to_changes(const json_t* list, char*** values) {
    const size_t count = json_array_size(list);
    ty_scene_change* changes = calloc(count, sizeof *changes);
    *values = calloc(count, sizeof **values);
    if (changes == NULL || *values == NULL) {
        free(changes);
        free(*values);
        return NULL;
    }
    for (size_t i = 0; i < count; ++i) {
        const json_t* change = json_array_get(list, i);
        (*values)[i] = view_change_value(change);
        changes[i] = (ty_scene_change){view_change_path(change), (*values)[i]};
    }
    return changes;
}

static ty_result apply_changes(view_live* live, const json_t* list, uint32_t* edited) {
    char** values;
    ty_scene_change* changes = to_changes(list, &values);
    if (changes == NULL) return TY_ERROR_MEMORY;
    const size_t count = json_array_size(list);
    const ty_result result = live->source->apply(live, changes, (int32_t)count, edited);
    for (size_t i = 0; i < count; ++i) free(values[i]);
    free(values);
    free(changes);
    return result;
}

static void set(view_live* live, const view_request* request) {
    const double begun = cli_wall_seconds();
    uint32_t edited = 0;
    const ty_result result = apply_changes(live, request->changes, &edited);
    if (result != TY_OK) {
        const char* text = ty_take_error(live->context);
        view_refuse(live->server, request->client, request->id, text[0] != '\0' ? text : ty_result_text(result));
        return;
    }
    live->times.load = 1e3 * (cli_wall_seconds() - begun);
    if (edited == 0) { /* the end of a drag whose last value is there already */
        live->moved = request->moving ? live->moved : 0;
        view_answer_unchanged(live, request);
        return;
    }
    begin_revision(live, request);
    live->source->take(live, edited);
    json_t* paths = json_array();
    size_t i;
    json_t* change;
    json_array_foreach(request->changes, i, change) json_array_append(paths, json_object_get(change, "path"));
    view_tell_scene(live, paths);
    json_decref(paths);
}

static bool take_size(view_live* live, const json_t* message) {
    const json_t *width = json_object_get(message, "width"), *height = json_object_get(message, "height");
    const int32_t before[2] = {live->width, live->height};
    if (width != NULL) live->width = (int32_t)json_number_value(width);
    if (height != NULL) live->height = (int32_t)json_number_value(height);
    return before[0] != live->width || before[1] != live->height;
}

static void change_view(view_live* live, const view_request* request) {
    const json_t* message = request->message;
    const char* method = json_string_value(json_object_get(message, "method"));
    if (method != NULL && !live->source->set_method(live, method)) {
        char text[128];
        snprintf(text, sizeof text, "unknown method '%.64s'", method);
        view_refuse(live->server, request->client, request->id, text);
        return;
    }
    const json_t *compare = json_object_get(message, "compare"), *paused = json_object_get(message, "paused"),
                 *exposure = json_object_get(message, "exposure");
    if (compare != NULL) live->compare = json_is_true(compare);
    if (paused != NULL) live->paused = json_is_true(paused);
    if (exposure != NULL) live->exposure = json_number_value(exposure);
    if ((json_object_get(message, "width") != NULL || json_object_get(message, "height") != NULL) &&
        live->source->own_size) {
        view_refuse(live->server, request->client, request->id, "width: the image has its own size");
        return;
    }
    if (take_size(live, message)) begin_revision(live, request);
    view_tell_scene(live, NULL);
}

static void record(view_live* live, const view_request* request) {
    const char* name = json_string_value(json_object_get(request->message, "name"));
    char path[4096], text[512];
    if (live->record == NULL) {
        view_refuse(live->server, request->client, request->id, "recording needs 'tyndall view --record FOLDER'");
        return;
    }
    snprintf(path, sizeof path, "%s/%s", live->record, name);
    if (view_write_picture(live, VIEW_CHANNEL_METHOD, path, text, sizeof text))
        view_answer_done(live, request, "file", path);
    else
        view_refuse(live->server, request->client, request->id, text);
}

static void serve(view_live* live, const view_request* request) {
    switch (request->kind) {
    case VIEW_REQUEST_SET: set(live, request); break;
    case VIEW_REQUEST_VIEW: change_view(live, request); break;
    case VIEW_REQUEST_DOCUMENT: view_answer_document(live, request); break;
    case VIEW_REQUEST_RECORD: record(live, request); break;
    }
}

/* ---- the thread ---- */

static view_request* take_request(view_live* live) {
    pthread_mutex_lock(&live->mutex);
    view_request* request = live->first;
    if (request != NULL) live->first = request->next;
    if (live->first == NULL) live->last = NULL;
    atomic_store(&live->interrupted, live->stop || live->first != NULL);
    pthread_mutex_unlock(&live->mutex);
    return request;
}

/* Waits for a request; while something moves only until that counts as ended. */
static void wait_for_request(view_live* live) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    const double seconds = live->moved > 0 ? fmax(0.01, live->moved + rest_seconds - cli_wall_seconds()) : 1;
    until.tv_nsec += (long)(1e9 * fmod(seconds, 1));
    until.tv_sec += (time_t)seconds + until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_mutex_lock(&live->mutex);
    if (live->first == NULL && !live->stop)
        live->rested = pthread_cond_timedwait(&live->changed, &live->mutex, &until) == ETIMEDOUT;
    pthread_mutex_unlock(&live->mutex);
}

/* Shows a client that has just connected what the others see. */
static void greet(view_live* live) {
    pthread_mutex_lock(&live->mutex);
    const bool newcomer = live->newcomer;
    live->newcomer = false;
    pthread_mutex_unlock(&live->mutex);
    if (!newcomer) return;
    for (int i = 0; i < VIEW_CHANNEL_COUNT; ++i) view_show_picture(live, (view_channel)i);
    view_tell_status(live, true);
}

/* True if something moves and its image is due: changes that arrive as fast as they are served would put it off for
 * ever. */
static bool is_due(const view_live* live) {
    return live->moved > 0 && live->shown == VIEW_SHOWN_NOTHING && !live->failed && live->received > 0 &&
           cli_wall_seconds() - live->received > patience_seconds;
}

static void* run(void* user) {
    view_live* live = user;
    while (!atomic_load(&live->stop)) {
        greet(live);
        view_request* request = is_due(live) ? NULL : take_request(live);
        if (request != NULL) {
            serve(live, request);
            view_request_free(request);
            continue;
        }
        if (live->moved > 0 && cli_wall_seconds() - live->moved > rest_seconds) live->moved = 0;
        const bool worked = view_server_clients(live->server) > 0 && view_live_step(live);
        view_tell_status(live, !worked);
        if (!worked) wait_for_request(live);
    }
    return NULL;
}

/* ---- the server's threads ---- */

/* Takes the last request off the queue if the new one makes it superfluous. Under the mutex. */
static void drop_superfluous(view_live* live, const view_request* later) {
    view_request** at = &live->first;
    view_request* before = NULL;
    while (*at != NULL && (*at)->next != NULL) {
        before = *at;
        at = &(*at)->next;
    }
    if (*at == NULL || !view_request_replaces(later, *at)) return;
    view_request_free(*at);
    *at = NULL;
    live->last = before;
}

/* The server, which begins to listen before the thread starts. */
static view_server* wait_for_server(view_live* live) {
    pthread_mutex_lock(&live->mutex);
    while (live->server == NULL && !live->stop) pthread_cond_wait(&live->changed, &live->mutex);
    view_server* server = live->server;
    pthread_mutex_unlock(&live->mutex);
    return server;
}

void view_live_receive(void* user, int32_t client, const char* text, size_t size) {
    view_live* live = user;
    view_server* server = wait_for_server(live);
    char reason[256];
    json_int_t id;
    if (server == NULL) return;
    view_request* request = view_request_parse(text, size, live->meters_per_unit, &id, reason, sizeof reason);
    if (request == NULL) {
        view_refuse(server, client, id, reason);
        return;
    }
    request->client = client;
    pthread_mutex_lock(&live->mutex);
    drop_superfluous(live, request);
    if (live->last != NULL)
        live->last->next = request;
    else
        live->first = request;
    live->last = request;
    atomic_store(&live->interrupted, true);
    pthread_cond_signal(&live->changed);
    pthread_mutex_unlock(&live->mutex);
}

bool view_live_connected(void* user, int32_t client) {
    view_live* live = user;
    view_server* server = wait_for_server(live);
    if (server == NULL) return false;
    pthread_mutex_lock(&live->mutex);
    char* text = view_welcome(live);
    live->newcomer = true;
    atomic_store(&live->interrupted, true);
    pthread_cond_signal(&live->changed);
    pthread_mutex_unlock(&live->mutex);
    if (text == NULL) return false;
    view_server_send(server, client, text);
    free(text);
    return true;
}

/* ---- opening and closing ---- */

int view_live_open(const view_live_def* def, view_live** out) {
    view_live* live = calloc(1, sizeof *live);
    if (live == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    live->context = def->session->context;
    live->compare = def->compare;
    live->remote = def->remote;
    live->record = def->record;
    live->tev = def->tev;
    live->scene_path = def->path;
    live->revision = 1;
    live->view_power = 2;
    const char* slash = strrchr(def->path, '/');
    snprintf(live->name, sizeof live->name, "%s", slash != NULL ? slash + 1 : def->path);
    pthread_mutex_init(&live->mutex, NULL);
    pthread_cond_init(&live->changed, NULL);
    int status = def->photo != NULL ? view_open_photo(live, def) : view_open_scene(live, def);
    if (status == CLI_GO) {
        live->original = strdup(live->source->text(live));
        if (live->original == NULL) status = cli_fail(CLI_FAILED, "not enough memory");
    }
    if (status != CLI_GO) {
        view_live_close(live);
        return status;
    }
    view_tell_scene(live, NULL);
    *out = live;
    return CLI_GO;
}

bool view_live_start(view_live* live, view_server* server) {
    pthread_mutex_lock(&live->mutex);
    live->server = server;
    pthread_cond_broadcast(&live->changed);
    pthread_mutex_unlock(&live->mutex);
    live->running = pthread_create(&live->thread, NULL, run, live) == 0;
    return live->running;
}

void view_live_stop(view_live* live) {
    pthread_mutex_lock(&live->mutex);
    live->stop = true;
    atomic_store(&live->interrupted, true);
    pthread_cond_broadcast(&live->changed);
    pthread_mutex_unlock(&live->mutex);
    if (live->running) pthread_join(live->thread, NULL);
    live->running = false;
}

void view_live_close(view_live* live) {
    if (live == NULL) return;
    view_live_stop(live);
    while (live->first != NULL) {
        view_request* next = live->first->next;
        view_request_free(live->first);
        live->first = next;
    }
    live->source->close(live);
    for (int i = 0; i < VIEW_CHANNEL_COUNT; ++i) free(live->pictures[i].rgb);
    free(live->rgb);
    free(live->media);
    free(live->enlarged);
    free(live->original);
    free(live->document);
    free(live->view);
    pthread_cond_destroy(&live->changed);
    pthread_mutex_destroy(&live->mutex);
    free(live);
}
