/* Overrides of scene files: "media[0].g=0.5" sets one value before validation. */
#include "base/context.h"
#include "io/scenes/scene_reader.h"
#include "io/schema_text.h"

#include <stdint.h>
#include <string.h>

static ty_result fail_override(const ty_scene_reader* reader, const ty_scene_override* override, const char* reason) {
    char text[128] = "";
    ty_append_quoted(text, sizeof text, override->text);
    return ty_fail(reader->context, TY_ERROR_ARGUMENT, "override %s: %s", text, reason);
}

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

/* Splits "media[0].g"; keys point into the text, which is zero-terminated between them. */
static bool parse_path(char* text, ty_json_path* path) {
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

/* Parses JSON, or else a bare word. NULL for malformed JSON and for invalid UTF-8. */
static json_t* parse_value(const char* text) {
    json_t* value = json_loads(text, JSON_DECODE_ANY | JSON_REJECT_DUPLICATES, NULL);
    if (value != NULL) return value;
    const char* first = text + strspn(text, " \t");
    return *first != '\0' && strchr("{[\"", *first) != NULL ? NULL : json_string(text);
}

/* The member or element one step below container; a missing member is created as an object if `create` is set. NULL
 * after an error message. */
static json_t* descend(const ty_scene_reader* reader, const ty_scene_override* override, json_t* container, size_t i) {
    const ty_json_step* step = &override->path.steps[i];
    if (step->key == NULL) return json_array_get(container, step->index);
    json_t* member = json_object_get(container, step->key);
    if (member != NULL) return member;
    member = json_object();
    if (json_object_set_new(container, step->key, member) == 0) return member;
    ty_fail(reader->context, TY_ERROR_MEMORY, "not enough memory for an override");
    return NULL;
}

/* Fails unless container can hold step i of the override's path. */
static ty_result check_step(const ty_scene_reader* reader, const ty_scene_override* override, const json_t* container,
                            size_t i) {
    const ty_json_step* step = &override->path.steps[i];
    const size_t size = json_array_size(container);
    if (step->key == NULL ? json_is_array(container) && step->index < size : json_is_object(container)) return TY_OK;
    char reason[256] = "", json_path[200];
    ty_json_path above = override->path;
    above.depth = i;
    ty_json_path_text(&above, json_path, sizeof json_path);
    if (step->key == NULL && json_is_array(container)) {
        ty_append(reason, sizeof reason, "%s has %zu element%s", json_path, size, size == 1 ? "" : "s");
    } else if (step->key == NULL && json_is_object(container) && json_object_size(container) == 0) {
        ty_append(reason, sizeof reason, "%s has no elements", json_path);
    } else {
        ty_append(reason, sizeof reason, "%s is ", i == 0 ? "the scene" : json_path);
        ty_append_value(reason, sizeof reason, container);
        ty_append(reason, sizeof reason, ", not an %s", step->key == NULL ? "array" : "object");
    }
    return fail_override(reader, override, reason);
}

static ty_result apply(ty_scene_reader* reader, ty_scene_override* override) {
    const char* equals = strchr(override->text, '=');
    if (equals == NULL) return fail_override(reader, override, "expected PATH=VALUE, such as media[0].g=0.5");
    override->keys_size = (size_t)(equals - override->text) + 1;
    override->keys = ty_alloc_array(reader->context, override->keys_size, 1, false);
    if (override->keys == NULL) return TY_ERROR_MEMORY;
    memcpy(override->keys, override->text, override->keys_size - 1);
    override->keys[override->keys_size - 1] = '\0';
    if (!parse_path(override->keys, &override->path))
        return fail_override(reader, override, "expected a path such as media[0].g before the =");
    json_t* container = reader->root;
    const size_t last = override->path.depth - 1;
    for (size_t i = 0; i <= last; ++i) {
        const ty_result result = check_step(reader, override, container, i);
        if (result != TY_OK) return result;
        if (i < last) container = descend(reader, override, container, i);
        if (container == NULL) return TY_ERROR_MEMORY;
    }
    json_t* value = parse_value(equals + 1);
    if (value == NULL) return fail_override(reader, override, "the value is not valid JSON");
    const ty_json_step* step = &override->path.steps[last];
    const int failed = step->key != NULL ? json_object_set_new(container, step->key, value)
                                         : json_array_set_new(container, step->index, value);
    return failed ? fail_override(reader, override, "the key is not valid UTF-8") : TY_OK;
}

ty_result ty_apply_overrides(ty_scene_reader* reader, const char* const* texts, int32_t count) {
    if (count == 0) return TY_OK;
    if (count < 0 || texts == NULL)
        return ty_fail(reader->context, TY_ERROR_ARGUMENT, "%d overrides, but none are given", (int)count);
    reader->overrides = ty_alloc_array(reader->context, (size_t)count, sizeof *reader->overrides, true);
    if (reader->overrides == NULL) return TY_ERROR_MEMORY;
    reader->override_count = count;
    for (int32_t i = 0; i < count; ++i) {
        if (texts[i] == NULL) return ty_fail(reader->context, TY_ERROR_ARGUMENT, "override %d is NULL", (int)i);
        reader->overrides[i].text = texts[i];
        const ty_result result = apply(reader, &reader->overrides[i]);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

void ty_free_overrides(ty_scene_reader* reader) {
    for (int32_t i = 0; i < reader->override_count; ++i)
        ty_free_array(reader->context, reader->overrides[i].keys, reader->overrides[i].keys_size, 1);
    ty_free_array(reader->context, reader->overrides, (size_t)reader->override_count, sizeof *reader->overrides);
}
