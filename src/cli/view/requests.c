#include "cli/view/requests.h"

#include "cli/session/session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NESTED_MAX = 64, CHANGES_MAX = 256, SIDE_MAX = 8192, SIDE_MIN = 16 };

/* ---- checks: each leaves one line in text ---- */

typedef struct parsed_message {
    json_t* root;
    char* text;
    size_t size;
} parsed_message;

static bool refuse(const parsed_message* message, const char* format, const char* name) {
    snprintf(message->text, message->size, format, name);
    return false;
}

static bool is_boolean_or_missing(const parsed_message* message, const char* key) {
    const json_t* value = json_object_get(message->root, key);
    return value == NULL || json_is_boolean(value) || refuse(message, "%s: is not true or false", key);
}

static bool is_number_or_missing(const parsed_message* message, const char* key, double lower, double upper) {
    const json_t* value = json_object_get(message->root, key);
    if (value == NULL) return true;
    if (!json_is_number(value)) return refuse(message, "%s: is not a number", key);
    const double number = json_number_value(value);
    return (number >= lower && number <= upper) || refuse(message, "%s: is out of range", key);
}

static bool is_vector(const json_t* value) {
    if (!json_is_array(value) || json_array_size(value) != 3) return false;
    for (size_t i = 0; i < 3; ++i)
        if (!json_is_number(json_array_get(value, i))) return false;
    return true;
}

static bool knows_keys(const parsed_message* message, const char* const* known) {
    const char* key;
    json_t* value;
    json_object_foreach(message->root, key, value) {
        const char* const* name = known;
        while (*name != NULL && strcmp(*name, key) != 0) ++name;
        if (*name == NULL) return refuse(message, "unknown key '%.64s'", key);
    }
    return true;
}

/* ---- kinds ---- */

static bool take_set(const parsed_message* message, view_request* out) {
    static const char* const keys[] = {"type", "id", "changes", "moving", NULL};
    json_t* changes = json_object_get(message->root, "changes");
    if (!knows_keys(message, keys)) return false;
    if (!json_is_array(changes) || json_array_size(changes) < 1 || json_array_size(changes) > CHANGES_MAX)
        return refuse(message, "%s: is not an array of 1 to 256 changes", "changes");
    size_t i;
    json_t* change;
    json_array_foreach(changes, i, change) {
        const char* path = json_string_value(json_object_get(change, "path"));
        if (path == NULL || path[0] == '\0') return refuse(message, "%s: a change has no path", "changes");
        if (json_object_get(change, "value") == NULL) return refuse(message, "%.64s: the change has no value", path);
    }
    out->changes = json_incref(changes);
    return true;
}

static bool add_change(json_t* changes, const char* path, json_t* value) {
    return json_array_append_new(changes, json_pack("{s:s, s:o}", "path", path, "value", value)) == 0;
}

static json_t* divided(const json_t* vector, double by) {
    json_t* out = json_array();
    for (size_t i = 0; i < 3; ++i)
        json_array_append_new(out, json_real(json_number_value(json_array_get(vector, i)) / by));
    return out;
}

static bool take_camera(const parsed_message* message, double meters_per_unit, view_request* out) {
    static const char* const keys[] = {"type", "id", "position", "target", "up", "fov_y", "moving", NULL};
    static const struct {
        const char *key, *path;
        bool length;
    } vectors[] = {
        {"position", "camera.position", true}, {"target", "camera.target", true}, {"up", "camera.up", false}};
    if (!knows_keys(message, keys) || !is_number_or_missing(message, "fov_y", 0, 180)) return false;
    out->camera = true;
    out->changes = json_array();
    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; ++i) {
        const json_t* value = json_object_get(message->root, vectors[i].key);
        if (value == NULL) continue;
        if (!is_vector(value)) return refuse(message, "%s: is not three numbers", vectors[i].key);
        if (!add_change(out->changes, vectors[i].path, divided(value, vectors[i].length ? meters_per_unit : 1)))
            return refuse(message, "%s", "not enough memory");
    }
    json_t* fov = json_object_get(message->root, "fov_y");
    if (fov != NULL) add_change(out->changes, "camera.fov_y", json_incref(fov));
    return json_array_size(out->changes) > 0 || refuse(message, "%s: sets nothing", "camera");
}

static bool take_view(const parsed_message* message, view_request* out) {
    static const char* const keys[] = {"type",  "id",     "method",   "compare", "paused",
                                       "width", "height", "exposure", NULL};
    const json_t* method = json_object_get(message->root, "method");
    (void)out;
    if (!knows_keys(message, keys)) return false;
    if (method != NULL && !json_is_string(method)) return refuse(message, "%s: is not a name", "method");
    return is_boolean_or_missing(message, "compare") && is_boolean_or_missing(message, "paused") &&
           is_number_or_missing(message, "width", SIDE_MIN, SIDE_MAX) &&
           is_number_or_missing(message, "height", SIDE_MIN, SIDE_MAX) &&
           is_number_or_missing(message, "exposure", -100, 100);
}

static bool take_record(const parsed_message* message, view_request* out) {
    static const char* const keys[] = {"type", "id", "name", NULL};
    const char* name = json_string_value(json_object_get(message->root, "name"));
    (void)out;
    if (!knows_keys(message, keys)) return false;
    if (name == NULL || strlen(name) > 200 || strchr(name, '/') != NULL || name[0] == '.')
        return refuse(message, "%s: is not the name of a file without folders", "name");
    return cli_has_extension(name, ".exr") || cli_has_extension(name, ".png") ||
           refuse(message, "%.64s: the extension is not .exr or .png", name);
}

static bool take_document(const parsed_message* message, view_request* out) {
    static const char* const keys[] = {"type", "id", NULL};
    (void)out;
    return knows_keys(message, keys);
}

static bool take(const parsed_message* message, double meters_per_unit, view_request* out) {
    const char* type = json_string_value(json_object_get(message->root, "type"));
    if (!is_boolean_or_missing(message, "moving")) return false;
    out->moving = json_is_true(json_object_get(message->root, "moving"));
    if (type == NULL) return refuse(message, "%s", "the message has no type");
    if (strcmp(type, "set") == 0) return take_set(message, out);
    if (strcmp(type, "camera") == 0) return take_camera(message, meters_per_unit, out);
    out->kind = VIEW_REQUEST_VIEW;
    if (strcmp(type, "view") == 0) return take_view(message, out);
    out->kind = VIEW_REQUEST_DOCUMENT;
    if (strcmp(type, "document") == 0) return take_document(message, out);
    out->kind = VIEW_REQUEST_RECORD;
    if (strcmp(type, "record") == 0) return take_record(message, out);
    return refuse(message, "unknown type '%.64s'", type);
}

/* ---- requests ---- */

/* False for texts whose arrays and objects nest deeper than the parser's recursion may go on the server's small stacks.
 */
static bool is_shallow(const char* text, size_t length) {
    int depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < length; ++i) {
        if (quoted && text[i] == '\\')
            ++i;
        else if (text[i] == '"')
            quoted = !quoted;
        else if (!quoted && (text[i] == '[' || text[i] == '{'))
            ++depth;
        else if (!quoted && (text[i] == ']' || text[i] == '}'))
            --depth;
        if (depth > NESTED_MAX) return false;
    }
    return true;
}

view_request* view_request_parse(const char* text, size_t length, double meters_per_unit, json_int_t* id, char* reason,
                                 size_t size) {
    *id = -1;
    if (!is_shallow(text, length)) {
        snprintf(reason, size, "the message nests deeper than %d levels", NESTED_MAX);
        return NULL;
    }
    json_error_t error;
    json_t* root = json_loadb(text, length, JSON_REJECT_DUPLICATES, &error);
    if (!json_is_object(root)) {
        snprintf(reason, size, root == NULL ? "the message is not JSON" : "the message is not a JSON object");
        json_decref(root);
        return NULL;
    }
    const json_t* number = json_object_get(root, "id");
    if (json_is_integer(number)) *id = json_integer_value(number);
    view_request* request = calloc(1, sizeof *request);
    const parsed_message message = {root, reason, size};
    if (request == NULL) snprintf(reason, size, "not enough memory");
    if (request == NULL || !take(&message, meters_per_unit, request)) {
        json_decref(root);
        if (request != NULL) json_decref(request->changes);
        free(request);
        return NULL;
    }
    request->id = *id;
    request->message = root;
    request->received = cli_wall_seconds();
    return request;
}

void view_request_free(view_request* request) {
    if (request == NULL) return;
    json_decref(request->changes);
    json_decref(request->message);
    free(request);
}

static bool sets(const view_request* request, const char* path) {
    size_t i;
    json_t* change;
    json_array_foreach(request->changes, i, change) if (strcmp(view_change_path(change), path) == 0) return true;
    return false;
}

bool view_request_replaces(const view_request* later, const view_request* earlier) {
    if (later->kind != VIEW_REQUEST_SET || earlier->kind != VIEW_REQUEST_SET) return false;
    if (later->client != earlier->client) return false;
    size_t i;
    json_t* change;
    json_array_foreach(earlier->changes, i, change) if (!sets(later, view_change_path(change))) return false;
    return true;
}

const char* view_change_path(const json_t* change) {
    return json_string_value(json_object_get(change, "path"));
}

char* view_change_value(const json_t* change) {
    const json_t* value = json_object_get(change, "value");
    return json_is_null(value) ? NULL : json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT);
}
