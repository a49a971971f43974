#define _GNU_SOURCE
#include "cli/view/photo_schema.h"

#include "base/context.h"
#include "io/json_text.h"
#include "io/scenes/medium_text.h"
#include "io/scenes/scene_schema.h"

#include <ctype.h>
#include <string.h>

/* Made of photo.schema.json: what the table of options does not say. */
extern const char view_photo_details_text[];
extern const unsigned view_photo_details_size;

/* ---- the schema ---- */

/* The words of "auto|plain|none". */
static json_t* words_of(const char* choices) {
    json_t* words = json_array();
    for (const char* word = choices; word != NULL;) {
        const size_t size = strcspn(word, "|");
        json_array_append_new(words, json_stringn(word, size));
        word = word[size] == '|' ? word + size + 1 : NULL;
    }
    return words;
}

/* The variants of an option as words, or NULL for all. */
static json_t* variants_of(const char* name) {
    json_t* all = words_of(SCREEN_KINDS);
    json_t* some = json_array();
    const unsigned kinds = screen_kinds_of(name);
    for (size_t i = 0; i < json_array_size(all); ++i)
        if ((kinds & 1u << i) != 0) json_array_append(some, json_array_get(all, i));
    const bool every = json_array_size(some) == json_array_size(all);
    json_decref(all);
    if (!every) return some;
    json_decref(some);
    return NULL;
}

/* "Full vertical angle of view." of "full vertical angle of view". */
static json_t* sentence(const char* help) {
    char text[256];
    snprintf(text, sizeof text, "%s.", help);
    text[0] = (char)toupper((unsigned char)text[0]);
    return json_string(text);
}

static json_t* type_of(const cli_option* option, const cli_option* preset) {
    switch (option->kind) {
    case CLI_FLAG: return json_pack("{s:s, s:b}", "type", "boolean", "default", 0);
    case CLI_CHOICE: {
        json_t* words = words_of(option->value);
        json_t* schema = json_pack("{s:s, s:o}", "type", "string", "enum", words);
        if (option->given == NULL)
            json_object_set(schema, "default", json_array_get(words, (size_t)(*(int*)preset->target)));
        return schema;
    }
    case CLI_INT:
        return json_pack("{s:s, s:f, s:f}", "type", "integer", "minimum", option->lower, "maximum", option->upper);
    case CLI_REAL: {
        json_t* schema =
            json_pack("{s:s, s:f, s:f}", "type", "number", "minimum", option->lower, "maximum", option->upper);
        if (*(double*)preset->target > 0) json_object_set_new(schema, "default", json_real(*(double*)preset->target));
        return schema;
    }
    default: return json_pack("{s:s, s:i}", "type", "string", "minLength", 1);
    }
}

static json_t* option_schema(const cli_option* option, const cli_option* preset, const json_t* details) {
    json_t* schema = type_of(option, preset);
    json_t* own = json_object_get(details, option->name);
    json_t* variants = variants_of(option->name);
    json_object_set_new(schema, "description", sentence(option->help));
    if (variants != NULL) json_object_set_new(schema, "x-variants", variants);
    if (json_object_get(own, "anyOf") != NULL || json_object_get(own, "type") != NULL) {
        json_object_del(schema, "type");
        json_object_del(schema, "minLength");
    }
    json_object_update(schema, own);
    return schema;
}

/* A scene's medium without what varies in space. */
static json_t* medium_schema(const json_t* definitions) {
    const json_t* all = json_object_get(json_object_get(definitions, "medium"), "properties");
    json_t* properties = json_object();
    for (const char* const* key = ty_homogeneous_keys; *key != NULL; ++key)
        json_object_set(properties, *key, json_object_get(all, *key));
    return json_pack("{s:s, s:s, s:b, s:o}", "type", "object", "description",
                     "What lies between the camera and what it sees.", "additionalProperties", 0, "properties",
                     properties);
}

json_t* view_photo_schema(void) {
    screen_options presets = screen_default_options("view");
    cli_option table[SCREEN_OPTIONS];
    screen_list_options(&presets, table);
    json_t* scene = ty_scene_schema_tree();
    json_t* details = json_loadb(view_photo_details_text, view_photo_details_size, 0, NULL);
    json_t* definitions = json_object_get(scene, "$defs");
    json_t* properties = json_object();
    for (int i = 0; i < SCREEN_OPTIONS; ++i)
        json_object_set_new(properties, table[i].name,
                            strcmp(table[i].name, "medium") == 0
                                ? medium_schema(definitions)
                                : option_schema(&table[i], &table[i], json_object_get(details, "properties")));
    json_t* schema = json_pack("{s:s, s:b, s:[s], s:o, s:O}", "type", "object", "additionalProperties", 0, "required",
                               "medium", "properties", properties, "$defs", definitions);
    json_decref(details);
    json_decref(scene);
    return schema;
}

/* ---- options as a document ---- */

/* Numbers where the text has them and the schema does not ask for a text. */
static json_t* value_of_text(const json_t* schema, const char* text) {
    double numbers[3];
    const char* type = json_string_value(json_object_get(schema, "type"));
    const int count = type != NULL && strcmp(type, "string") == 0 ? 0 : screen_parse_numbers(text, 1, numbers);
    if (count == 0) return json_string(text);
    if (count == 1) return ty_json_number(numbers[0]);
    json_t* list = json_array();
    for (int i = 0; i < count; ++i) json_array_append_new(list, ty_json_number(numbers[i]));
    return list;
}

static json_t* value_of(const json_t* schema, const cli_option* option) {
    switch (option->kind) {
    case CLI_FLAG: return json_true();
    case CLI_REAL: return ty_json_number(*(double*)option->target);
    case CLI_INT: return json_integer(*(int32_t*)option->target);
    case CLI_CHOICE:
        return json_incref(json_array_get(json_object_get(schema, "enum"), (size_t)(*(int*)option->target)));
    default: return value_of_text(schema, *(const char**)option->target);
    }
}

int view_photo_document(cli_session* session, const json_t* schema, screen_options* options, json_t** out) {
    screen_options presets = screen_default_options("view");
    cli_option table[SCREEN_OPTIONS], preset[SCREEN_OPTIONS];
    const json_t* properties = json_object_get(schema, "properties");
    screen_list_options(options, table);
    screen_list_options(&presets, preset);
    json_t *document = json_object(), *medium = NULL;
    const ty_result result = ty_medium_object(session->context, options->medium, &medium);
    if (result != TY_OK) {
        json_decref(document);
        return cli_fail_reading(session, result);
    }
    for (int i = 0; i < SCREEN_OPTIONS; ++i) {
        json_t* value = NULL;
        if (table[i].target == (void*)&options->medium)
            value = medium;
        else if (screen_is_given(&table[i], &preset[i]))
            value = value_of(json_object_get(properties, table[i].name), &table[i]);
        if (value != NULL && json_object_set_new(document, table[i].name, value) != 0) {
            json_decref(document);
            return cli_fail(CLI_USAGE, "--%s: not UTF-8", table[i].name);
        }
    }
    *out = document;
    return CLI_GO;
}

/* ---- a document as options ---- */

/* True if the document's variant has the option. */
static bool has_option(const json_t* document, const char* name) {
    const char* variant = json_string_value(json_object_get(document, "variant"));
    return (screen_kinds_of(name) & 1u << (variant != NULL ? cli_find_choice(SCREEN_KINDS, variant) : 0)) != 0;
}

char* view_photo_text(ty_context* context, const json_t* document, const cli_option* option) {
    const json_t* value = json_object_get(document, option->name);
    if (value == NULL || json_is_false(value) || !has_option(document, option->name)) return NULL;
    if (json_is_string(value)) return strdup(json_string_value(value));
    ty_text text = {.context = context};
    ty_text_add_compact(&text, value);
    char* made = ty_text_finish(&text);
    char* out = NULL;
    if (made != NULL && json_is_array(value)) /* [1,2,3] as 1,2,3 */
        out = strndup(made + 1, strlen(made) - 2);
    else if (made != NULL)
        out = strdup(made);
    ty_free_text(context, made);
    return out;
}
