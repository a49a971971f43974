/* The JSON Schema of scene files. */
#include "io/scenes/scene_schema.h"

#include "io/json_text.h"
#include "io/scenes/builtin.h"
#include "option/option.h"

#include <pthread.h>
#include <tyndall/io.h>

static int set_range(json_t* schema, const ty_option* option) {
    const char* min = (option->flags & TY_OPTION_OPEN_MIN) != 0 ? "exclusiveMinimum" : "minimum";
    const char* max = (option->flags & TY_OPTION_OPEN_MAX) != 0 ? "exclusiveMaximum" : "maximum";
    int failed = json_object_set_new(schema, "type", json_string(option->type == TY_OPTION_INT ? "integer" : "number"));
    failed |= json_object_set_new(schema, min, ty_json_number(option->min));
    failed |= json_object_set_new(schema, max, ty_json_number(option->max));
    if (option->multiple != 0) failed |= json_object_set_new(schema, "multipleOf", ty_json_number(option->multiple));
    return failed;
}

/* A number that stands beside a word, or beside 0. */
static int set_alternatives(json_t* schema, const ty_option* option) {
    json_t* ranged = json_object();
    json_t* other = (option->flags & TY_OPTION_AUTO) != 0 ? json_pack("{s:s, s:s}", "type", "string", "const", "auto")
                                                          : json_pack("{s:s, s:i}", "type", "integer", "const", 0);
    const int failed = set_range(ranged, option);
    return failed | json_object_set_new(schema, "anyOf", json_pack("[o, o]", ranged, other));
}

static int set_words(json_t* schema, const ty_option* option) {
    json_t* words = json_array();
    int failed = 0;
    for (int32_t i = 0; option->words[i] != NULL; ++i)
        failed |= json_array_append_new(words, json_string(option->words[i]));
    return failed | json_object_set_new(schema, "enum", words);
}

static int set_default(json_t* schema, const ty_option* option) {
    char text[TY_OPTION_TEXT_SIZE];
    const bool automatic = (option->flags & TY_OPTION_AUTO) != 0 && option->preset == TY_AUTO;
    ty_option_text(option, option->preset, text);
    json_t* value = option->type == TY_OPTION_BOOL                ? json_boolean(option->preset != 0)
                    : option->type == TY_OPTION_WORD || automatic ? json_string(text)
                                                                  : ty_json_number(option->preset);
    return json_object_set_new(schema, "default", value);
}

static json_t* option_schema(const ty_option* option) {
    json_t* schema = json_object();
    int failed = json_object_set_new(schema, "description",
                                     option->unit == NULL ? json_string(option->doc)
                                                          : json_sprintf("%s Unit: %s.", option->doc, option->unit));
    if (option->type == TY_OPTION_WORD)
        failed |= set_words(schema, option);
    else if (option->type == TY_OPTION_BOOL)
        failed |= json_object_set_new(schema, "type", json_string("boolean"));
    else if ((option->flags & (TY_OPTION_AUTO | TY_OPTION_OR_ZERO)) != 0)
        failed |= set_alternatives(schema, option);
    else
        failed |= set_range(schema, option);
    failed |= set_default(schema, option);
    if (option->formerly != NULL) failed |= json_object_set_new(schema, "x-formerly", json_string(option->formerly));
    if (failed == 0) return schema;
    json_decref(schema);
    return NULL;
}

/* Of `render.METHOD`. */
static json_t* table_schema(const ty_option_table* table) {
    json_t* properties = json_object();
    int failed = 0;
    for (int32_t i = 0; i < table->count; ++i)
        if ((table->options[i].flags & TY_OPTION_CALLS_ONLY) == 0)
            failed |= json_object_set_new(properties, table->options[i].name, option_schema(&table->options[i]));
    if (failed == 0)
        return json_pack("{s:s, s:b, s:o}", "type", "object", "additionalProperties", 0, "properties", properties);
    json_decref(properties);
    return NULL;
}

/* Adds every method's name and options to the schema of `render`. */
static int add_methods(const json_t* render) {
    json_t* properties = json_object_get(render, "properties");
    json_t* names = json_object_get(json_object_get(properties, "method"), "enum");
    const char* method;
    int failed = 0;
    for (int32_t i = 0; failed == 0; ++i) {
        const ty_option_table* table = ty_method_options_at(i, &method);
        if (method == NULL) break;
        failed |= json_array_append_new(names, json_string(method));
        if (table != NULL && json_object_get(properties, table->name) == NULL)
            failed |= json_object_set_new(properties, table->name, table_schema(table));
    }
    return failed;
}

json_t* ty_scene_schema_tree(void) {
    json_t* schema = json_loadb(ty_scene_schema_text, ty_scene_schema_size, 0, NULL);
    if (schema == NULL) return NULL;
    if (add_methods(json_object_get(json_object_get(schema, "$defs"), "render")) == 0) return schema;
    json_decref(schema);
    return NULL;
}

/* ---- The text, made once ---- */

static char* text;

static void make_text(void) {
    json_t* schema = ty_scene_schema_tree();
    if (schema != NULL) text = json_dumps(schema, JSON_INDENT(2) | JSON_REAL_PRECISION(15));
    json_decref(schema);
}

const char* ty_scene_schema(void) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, make_text);
    return text;
}
