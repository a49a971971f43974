/* The parameters of a directive: "type name" and values. */
#include "base/context.h"
#include "io/interchange/pbrt/pbrt.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char* name;
    ty_pbrt_type type;
} types[] = {{"integer", TY_PBRT_INTEGER},   {"float", TY_PBRT_FLOAT},     {"point2", TY_PBRT_POINT2},
             {"point3", TY_PBRT_POINT3},     {"vector2", TY_PBRT_VECTOR2}, {"vector3", TY_PBRT_VECTOR3},
             {"normal3", TY_PBRT_NORMAL},    {"rgb", TY_PBRT_RGB},         {"blackbody", TY_PBRT_BLACKBODY},
             {"spectrum", TY_PBRT_SPECTRUM}, {"string", TY_PBRT_TEXT},     {"bool", TY_PBRT_BOOL},
             {"texture", TY_PBRT_TEXTURE},   {"point", TY_PBRT_POINT3},    {"vector", TY_PBRT_VECTOR3},
             {"normal", TY_PBRT_NORMAL},     {"color", TY_PBRT_RGB}};

/* The number of numbers of one value. */
static size_t width_of(ty_pbrt_type type) {
    switch (type) {
    case TY_PBRT_POINT2:
    case TY_PBRT_VECTOR2: return 2;
    case TY_PBRT_POINT3:
    case TY_PBRT_VECTOR3:
    case TY_PBRT_NORMAL:
    case TY_PBRT_RGB: return 3;
    default: return 1;
    }
}

static bool takes_strings(ty_pbrt_type type) {
    return type == TY_PBRT_TEXT || type == TY_PBRT_BOOL || type == TY_PBRT_TEXTURE || type == TY_PBRT_SPECTRUM;
}

static bool takes_numbers(ty_pbrt_type type) {
    return type != TY_PBRT_TEXT && type != TY_PBRT_BOOL && type != TY_PBRT_TEXTURE;
}

/* Splits "float radius". */
static ty_result read_declaration(ty_pbrt* reader, int32_t file, const ty_pbrt_token* token, ty_pbrt_parameter* out) {
    const char *at = token->text, *end = at + token->length;
    while (at < end && (*at == ' ' || *at == '\t')) ++at;
    const char* word = at;
    while (at < end && *at != ' ' && *at != '\t') ++at;
    const ty_pbrt_token type = {TY_PBRT_WORD, word, (size_t)(at - word), token->line};
    while (at < end && (*at == ' ' || *at == '\t')) ++at;
    const char* name = at;
    while (at < end && *at != ' ' && *at != '\t') ++at;
    snprintf(out->name, sizeof out->name, "%.*s", (int)(at - name), name);
    if (out->name[0] == '\0' || at - name >= TY_PBRT_NAME_SIZE)
        return ty_pbrt_fail(reader, file, token->line, "\"%.*s\" is not a type and a name", (int)(end - token->text),
                            token->text);
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (ty_pbrt_is(&type, types[i].name)) {
            out->type = types[i].type;
            out->file = file;
            out->line = token->line;
            return TY_OK;
        }
    return ty_pbrt_fail(reader, file, token->line, "the type \"%.*s\" of the parameter \"%s\" is not known",
                        (int)type.length, type.text, out->name);
}

static ty_result add_value(ty_pbrt* reader, ty_pbrt_parameter* out, const ty_pbrt_token* token) {
    double number;
    if (token->kind == TY_PBRT_STRING
            ? takes_strings(out->type)
            : out->type == TY_PBRT_BOOL && (ty_pbrt_is(token, "true") || ty_pbrt_is(token, "false"))) {
        if (!ty_grow_array(reader->context, (void**)&out->strings, &out->string_capacity, out->string_count,
                           sizeof *out->strings))
            return TY_ERROR_MEMORY;
        out->strings[out->string_count++] = *token;
        return TY_OK;
    }
    if (!takes_numbers(out->type) || !ty_pbrt_number(token, &number))
        return ty_pbrt_fail(reader, out->file, token->line, "\"%.*s\" is not a value of the parameter \"%s\"",
                            (int)(token->length < 60 ? token->length : 60), token->text, out->name);
    if (!ty_grow_array(reader->context, (void**)&out->numbers, &out->number_capacity, out->number_count,
                       sizeof *out->numbers))
        return TY_ERROR_MEMORY;
    out->numbers[out->number_count++] = number;
    return TY_OK;
}

static ty_result read_values(ty_pbrt* reader, ty_pbrt_text* text, ty_pbrt_parameter* out) {
    ty_pbrt_token token = ty_pbrt_next(text);
    ty_result result = TY_OK;
    if (token.kind != TY_PBRT_OPEN) {
        if (token.kind != TY_PBRT_WORD && token.kind != TY_PBRT_STRING)
            return ty_pbrt_fail(reader, out->file, out->line, "the parameter \"%s\" has no value", out->name);
        return add_value(reader, out, &token);
    }
    for (token = ty_pbrt_next(text); token.kind != TY_PBRT_CLOSE && result == TY_OK; token = ty_pbrt_next(text)) {
        if (token.kind != TY_PBRT_WORD && token.kind != TY_PBRT_STRING)
            return ty_pbrt_fail(reader, out->file, out->line,
                                "the values of the parameter \"%s\" do not end with \"]\"", out->name);
        result = add_value(reader, out, &token);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

static ty_result check(ty_pbrt* reader, const ty_pbrt_parameter* parameter) {
    const size_t width = width_of(parameter->type);
    if (parameter->number_count % width != 0)
        return ty_pbrt_fail(reader, parameter->file, parameter->line,
                            "the parameter \"%s\" has %zu numbers, which are not a multiple of %zu", parameter->name,
                            parameter->number_count, width);
    if (parameter->number_count > 0 && parameter->string_count > 0)
        return ty_pbrt_fail(reader, parameter->file, parameter->line, "the parameter \"%s\" has numbers and strings",
                            parameter->name);
    return TY_OK;
}

ty_result ty_pbrt_read_parameters(ty_pbrt* reader, ty_pbrt_text* text, ty_pbrt_parameters* out) {
    ty_result result = TY_OK;
    while (result == TY_OK) {
        ty_pbrt_text ahead = *text;
        const ty_pbrt_token token = ty_pbrt_next(&ahead);
        if (token.kind == TY_PBRT_BROKEN) return ty_pbrt_fail(reader, text->file, token.line, "the string has no end");
        if (token.kind != TY_PBRT_STRING) break;
        *text = ahead;
        if (!ty_grow_array(reader->context, (void**)&out->items, &out->capacity, out->count, sizeof *out->items))
            return TY_ERROR_MEMORY;
        ty_pbrt_parameter* parameter = &out->items[out->count++];
        *parameter = (ty_pbrt_parameter){0};
        result = read_declaration(reader, text->file, &token, parameter);
        if (result == TY_OK) result = read_values(reader, text, parameter);
        if (result == TY_OK) result = check(reader, parameter);
    }
    return result;
}

void ty_pbrt_free_parameters(ty_pbrt_parameters* parameters) {
    ty_context* context = parameters->reader->context;
    for (size_t i = 0; i < parameters->count; ++i) {
        ty_pbrt_parameter* parameter = &parameters->items[i];
        ty_free_array(context, parameter->numbers, parameter->number_capacity, sizeof *parameter->numbers);
        ty_free_array(context, parameter->strings, parameter->string_capacity, sizeof *parameter->strings);
    }
    ty_free_array(context, parameters->items, parameters->capacity, sizeof *parameters->items);
    parameters->items = NULL;
    parameters->count = parameters->capacity = 0;
}

void ty_pbrt_note_unused(const ty_pbrt_parameters* parameters, const char* kind) {
    for (size_t i = 0; i < parameters->count; ++i)
        if (!parameters->items[i].used)
            ty_conversion_leave_out(parameters->reader->conversion, "%s \"%s\": the parameter \"%s\"", kind,
                                    parameters->type, parameters->items[i].name);
}

/* ---- lookups ---- */

const ty_pbrt_parameter* ty_pbrt_find(const ty_pbrt_parameters* parameters, const char* name) {
    const ty_pbrt_parameter* found = NULL;
    for (size_t i = 0; i < parameters->count; ++i) {
        if (strcmp(parameters->items[i].name, name) != 0) continue;
        parameters->items[i].used = true;
        if (found == NULL) found = &parameters->items[i];
    }
    return found;
}

double ty_pbrt_float(const ty_pbrt_parameters* parameters, const char* name, double otherwise) {
    const ty_pbrt_parameter* found = ty_pbrt_find(parameters, name);
    return found != NULL && found->number_count > 0 ? found->numbers[0] : otherwise;
}

int32_t ty_pbrt_int(const ty_pbrt_parameters* parameters, const char* name, int32_t otherwise) {
    const double value = ty_pbrt_float(parameters, name, otherwise);
    return value >= -2147483647.0 && value <= 2147483647.0 ? (int32_t)value : otherwise;
}

bool ty_pbrt_bool(const ty_pbrt_parameters* parameters, const char* name, bool otherwise) {
    const ty_pbrt_parameter* found = ty_pbrt_find(parameters, name);
    return found != NULL && found->string_count > 0 ? ty_pbrt_is(&found->strings[0], "true") : otherwise;
}

bool ty_pbrt_string(const ty_pbrt_parameters* parameters, const char* name, char* out, size_t size) {
    const ty_pbrt_parameter* found = ty_pbrt_find(parameters, name);
    out[0] = '\0';
    if (found == NULL || found->string_count == 0) return false;
    snprintf(out, size, "%.*s", (int)found->strings[0].length, found->strings[0].text);
    return true;
}

void ty_pbrt_point(const ty_pbrt_parameters* parameters, const char* name, double out[3]) {
    const ty_pbrt_parameter* found = ty_pbrt_find(parameters, name);
    if (found != NULL && found->number_count >= 3) memcpy(out, found->numbers, 3 * sizeof *out);
}
