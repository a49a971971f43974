#include "io/json_edit.h"

#include "io/schema_text.h"

#include <string.h>

/* ---- paths ---- */

/* Parses "[12]" at *at and advances. */
static bool parse_index(char** at, size_t* index) {
    char* digit = *at + 1;
    size_t value = 0;
    for (; *digit >= '0' && *digit <= '9' && value < INT32_MAX; ++digit) value = 10 * value + (size_t)(*digit - '0');
    if (digit == *at + 1 || *digit != ']') return false;
    *index = value;
    *at = digit + 1;
    return true;
}

bool ty_json_parse_path(char* text, ty_json_path* path) {
    path->depth = 0;
    char* at = text;
    for (;;) {
        char* key = at;
        at += strcspn(at, ".[]");
        if (at == key || *at == ']' || path->depth == TY_JSON_PATH_STEPS) return false;
        path->steps[path->depth++] = (ty_json_step){.key = key};
        char* key_end = at;
        while (*at == '[') {
            size_t index;
            if (path->depth == TY_JSON_PATH_STEPS || !parse_index(&at, &index)) return false;
            path->steps[path->depth++] = (ty_json_step){.index = index};
        }
        const char next = *at;
        *key_end = '\0';
        if (next == '\0') return true;
        if (next != '.') return false;
        ++at;
    }
}

/* ---- comparison ---- */

static bool same_members(const json_t* a, const json_t* b) {
    if (json_object_size(a) != json_object_size(b)) return false;
    const char* key;
    json_t* member;
    json_object_foreach((json_t*)a, key, member) {
        if (!ty_json_same(member, json_object_get(b, key))) return false;
    }
    return true;
}

static bool same_elements(const json_t* a, const json_t* b) {
    if (json_array_size(a) != json_array_size(b)) return false;
    for (size_t i = 0; i < json_array_size(a); ++i)
        if (!ty_json_same(json_array_get(a, i), json_array_get(b, i))) return false;
    return true;
}

bool ty_json_same(const json_t* a, const json_t* b) {
    if (a == NULL || b == NULL) return a == b;
    if (json_is_object(a)) return json_is_object(b) && same_members(a, b);
    if (json_is_array(a)) return json_is_array(b) && same_elements(a, b);
    if (json_is_integer(a) && json_is_integer(b)) return json_integer_value(a) == json_integer_value(b);
    if (json_is_number(a)) return json_is_number(b) && json_number_value(a) == json_number_value(b);
    return json_equal(a, b);
}

json_t* ty_json_keep_same(json_t* old, json_t* value) {
    if (ty_json_same(old, value)) return json_incref(old);
    if (json_is_object(old) && json_is_object(value)) {
        const char* key;
        json_t* member;
        json_object_foreach(value, key, member) {
            json_t* kept = ty_json_keep_same(json_object_get(old, key), member);
            if (kept == NULL || (kept != member && json_object_set(value, key, kept) != 0)) {
                json_decref(kept);
                return NULL;
            }
            json_decref(kept);
        }
    } else if (json_is_array(old) && json_is_array(value)) {
        for (size_t i = 0; i < json_array_size(value); ++i) {
            json_t* kept = ty_json_keep_same(json_array_get(old, i), json_array_get(value, i));
            if (kept == NULL || json_array_set_new(value, i, kept) != 0) return NULL;
        }
    }
    return json_incref(value);
}

/* ---- changes ---- */

static json_t* child(const json_t* container, const ty_json_step* step) {
    return step->key != NULL ? json_object_get(container, step->key) : json_array_get(container, step->index);
}

/* Writes why container, at the first `depth` steps of path, cannot hold the next step. */
static void explain(const json_t* container, const ty_json_path* path, size_t depth, char* reason, size_t size) {
    char text[200];
    ty_json_path above = *path;
    above.depth = depth;
    ty_json_path_text(&above, text, sizeof text);
    reason[0] = '\0';
    const bool element = path->steps[depth].key == NULL;
    const size_t count = json_array_size(container);
    if (element && json_is_array(container) && count > 0) {
        ty_append(reason, size, "%s has %zu element%s", text, count, count == 1 ? "" : "s");
    } else if (element && (container == NULL || json_is_array(container))) {
        ty_append(reason, size, "%s has no elements", text);
    } else {
        ty_append(reason, size, "%s is ", depth == 0 ? "the scene" : text);
        ty_append_value(reason, size, container);
        ty_append(reason, size, ", not an %s", element ? "array" : "object");
    }
}

/* True if container has a place for a step; the last one may append. */
static bool can_hold(const json_t* container, const ty_json_step* step, bool last) {
    if (step->key != NULL) return json_is_object(container);
    return json_is_array(container) && step->index < json_array_size(container) + (last ? 1 : 0);
}

/* Takes over value. */
static bool set_child(json_t* container, const ty_json_step* step, json_t* value) {
    json_t* old = child(container, step);
    json_t* kept = old != NULL ? ty_json_keep_same(old, value) : json_incref(value);
    json_decref(value);
    if (kept == NULL) return false;
    if (step->key != NULL) return json_object_set_new(container, step->key, kept) == 0;
    const bool appends = step->index == json_array_size(container);
    return (appends ? json_array_append_new(container, kept) : json_array_set_new(container, step->index, kept)) == 0;
}

static void remove_child(json_t* container, const ty_json_step* step) {
    if (step->key != NULL)
        json_object_del(container, step->key);
    else
        json_array_remove(container, step->index);
}

/* Moves *container one step of the path down, which is not the last one. A missing member is created, an object or an
 * array to append to, unless something is to be removed below it: *container is NULL then. */
static ty_json_put_result descend(json_t** container, const ty_json_path* path, size_t i, bool removes, char* reason,
                                  size_t size) {
    const ty_json_step* below = &path->steps[i + 1];
    json_t* next = child(*container, &path->steps[i]);
    if (next == NULL && !removes) {
        const bool append = below->key == NULL && below->index == 0 && i + 2 == path->depth;
        if (below->key == NULL && !append) {
            explain(NULL, path, i + 1, reason, size);
            return TY_JSON_REFUSED;
        }
        next = append ? json_array() : json_object();
        if (json_object_set_new(*container, path->steps[i].key, next) != 0) return TY_JSON_NO_MEMORY;
    }
    *container = next;
    return TY_JSON_PUT;
}

/* Finds the container of path's last step, NULL if it does not exist and something is to be removed from it. */
static ty_json_put_result find_container(json_t* root, const ty_json_path* path, bool removes, json_t** container,
                                         char* reason, size_t size) {
    *container = root;
    for (size_t i = 0; *container != NULL; ++i) {
        const bool last = i + 1 == path->depth;
        if (!can_hold(*container, &path->steps[i], last && !removes)) {
            explain(*container, path, i, reason, size);
            return TY_JSON_REFUSED;
        }
        if (last) return TY_JSON_PUT;
        const ty_json_put_result result = descend(container, path, i, removes, reason, size);
        if (result != TY_JSON_PUT) return result;
    }
    return TY_JSON_PUT;
}

static bool has_valid_keys(const ty_json_path* path) {
    for (size_t i = 0; i < path->depth; ++i) {
        if (path->steps[i].key == NULL) continue;
        json_t* key = json_string(path->steps[i].key); /* NULL: not UTF-8 */
        if (key == NULL) return false;
        json_decref(key);
    }
    return true;
}

ty_json_put_result ty_json_put(json_t* root, const ty_json_path* path, json_t* value, char* reason, size_t size) {
    const ty_json_step* step = &path->steps[path->depth - 1];
    const bool removes = json_is_null(value);
    json_t* container = NULL;
    reason[0] = '\0';
    ty_json_put_result result = TY_JSON_REFUSED;
    if (has_valid_keys(path))
        result = find_container(root, path, removes, &container, reason, size);
    else
        ty_append(reason, size, "the key is not valid UTF-8");
    if (result != TY_JSON_PUT || removes) json_decref(value);
    if (result != TY_JSON_PUT || container == NULL) return result;
    if (!removes) return set_child(container, step, value) ? TY_JSON_PUT : TY_JSON_NO_MEMORY;
    remove_child(container, step);
    return TY_JSON_PUT;
}
