/* Overrides of scene files: "media[0].g=0.5" sets one value before validation. */
#include "base/context.h"
#include "io/json_edit.h"
#include "io/scenes/scene_reader.h"
#include "io/schema_text.h"

#include <string.h>

static ty_result fail_override(const ty_scene_reader* reader, const ty_scene_override* override, const char* reason) {
    char text[128] = "";
    ty_append_quoted(text, sizeof text, override->text);
    return ty_fail(reader->context, TY_ERROR_ARGUMENT, "override %s: %s", text, reason);
}

/* Parses JSON, or else a bare word. NULL for malformed JSON and for invalid UTF-8. */
static json_t* parse_value(const char* text) {
    json_t* value = json_loads(text, JSON_DECODE_ANY | JSON_REJECT_DUPLICATES, NULL);
    if (value != NULL) return value;
    const char* first = text + strspn(text, " \t");
    return *first != '\0' && strchr("{[\"", *first) != NULL ? NULL : json_string(text);
}

static ty_result apply(ty_scene_reader* reader, ty_scene_override* override) {
    const char* equals = strchr(override->text, '=');
    if (equals == NULL) return fail_override(reader, override, "expected PATH=VALUE, such as media[0].g=0.5");
    override->keys_size = (size_t)(equals - override->text) + 1;
    override->keys = ty_alloc_array(reader->context, override->keys_size, 1, false);
    if (override->keys == NULL) return TY_ERROR_MEMORY;
    memcpy(override->keys, override->text, override->keys_size - 1);
    override->keys[override->keys_size - 1] = '\0';
    if (!ty_json_parse_path(override->keys, &override->path))
        return fail_override(reader, override, "expected a path such as media[0].g before the =");
    json_t* value = parse_value(equals + 1);
    if (value == NULL) return fail_override(reader, override, "the value is not valid JSON");
    char reason[256];
    switch (ty_json_put(reader->root, &override->path, value, reason, sizeof reason)) {
    case TY_JSON_PUT: return TY_OK;
    case TY_JSON_REFUSED: return fail_override(reader, override, reason);
    case TY_JSON_NO_MEMORY: break;
    }
    return ty_fail(reader->context, TY_ERROR_MEMORY, "not enough memory for an override");
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
