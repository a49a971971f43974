/* Common functions of the scene file reader. */
#include "io/scenes/scene_reader.h"

#include "base/context.h"
#include "io/schema_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MESSAGE_SIZE = 1024 };

/* ---- messages ---- */

/* The override that set the value at path: the last one to set it or a container of it, or, for a path absent from
 * the file's text, the last one to set a value within it. NULL if there is none. */
static const ty_scene_override* origin(const ty_scene_reader* reader, const ty_json_path* path, int32_t line) {
    for (int32_t i = reader->override_count; i-- > 0;)
        if (ty_json_path_within(path, &reader->overrides[i].path)) return &reader->overrides[i];
    for (int32_t i = reader->override_count; line == 0 && i-- > 0;)
        if (ty_json_path_within(&reader->overrides[i].path, path)) return &reader->overrides[i];
    return NULL;
}

ty_result ty_reader_fail(const ty_scene_reader* reader, const ty_json_path* path, ty_result result, const char* format,
                         ...) {
    char text[MESSAGE_SIZE] = "";
    const int32_t line = reader->length > 0 ? ty_json_line(reader->text, reader->length, path) : 0;
    const ty_scene_override* override = origin(reader, path, line);
    if (reader->bare) {
        text[0] = '\0';
    } else if (override != NULL) {
        ty_append(text, sizeof text, "override ");
        ty_append_quoted(text, sizeof text, override->text);
        ty_append(text, sizeof text, ": ");
    } else if (line > 0) {
        ty_append(text, sizeof text, "%s:%d: ", reader->name, (int)line);
    } else {
        ty_append(text, sizeof text, "%s: ", reader->name);
    }
    if (path->depth > 0) {
        char json_path[MESSAGE_SIZE / 2];
        ty_json_path_text(path, json_path, sizeof json_path);
        ty_append(text, sizeof text, "%s: ", json_path);
    }
    const size_t used = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + used, sizeof text - used, format, arguments);
    va_end(arguments);
    return ty_fail(reader->context, result, "%s", text);
}

ty_result ty_reader_prefix_error(const ty_scene_reader* reader, const ty_json_path* path, ty_result result) {
    if (result == TY_OK) return TY_OK;
    if (result == TY_ERROR_ARGUMENT) result = TY_ERROR_INPUT;
    if (!reader->clean) return result;
    char message[MESSAGE_SIZE];
    snprintf(message, sizeof message, "%s", ty_take_error(reader->context));
    return ty_reader_fail(reader, path, result, "%s", message[0] != '\0' ? message : ty_result_text(result));
}

/* ---- values ---- */

void ty_read_number(const json_t* object, const char* key, double* out) {
    const json_t* value = json_object_get(object, key);
    if (value != NULL) *out = json_number_value(value);
}

void ty_read_float(const json_t* object, const char* key, float* out) {
    const json_t* value = json_object_get(object, key);
    if (value != NULL) *out = (float)json_number_value(value);
}

void ty_read_int(const json_t* object, const char* key, int32_t* out) {
    const json_t* value = json_object_get(object, key);
    if (value != NULL) *out = (int32_t)json_number_value(value);
}

void ty_read_bool(const json_t* object, const char* key, bool* out) {
    const json_t* value = json_object_get(object, key);
    if (value != NULL) *out = json_is_true(value);
}

static void read_array(const json_t* array, double factor, double out[3]) {
    for (size_t a = 0; a < 3; ++a) out[a] = factor * json_number_value(json_array_get(array, a));
}

void ty_read_vector(const json_t* object, const char* key, double factor, double out[3]) {
    const json_t* value = json_object_get(object, key);
    if (value != NULL) read_array(value, factor, out);
}

void ty_read_numbers(const json_t* object, const char* key, double out[3]) {
    const json_t* value = json_object_get(object, key);
    if (json_is_array(value))
        read_array(value, 1, out);
    else if (value != NULL)
        for (int c = 0; c < 3; ++c) out[c] = json_number_value(value);
}

void ty_read_rgb(const json_t* object, const char* key, float out[3]) {
    double numbers[3] = {out[0], out[1], out[2]};
    ty_read_numbers(object, key, numbers);
    for (int c = 0; c < 3; ++c) out[c] = (float)numbers[c];
}

ty_result ty_read_direction(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            const char* key, double out[3]) {
    double direction[3] = {out[0], out[1], out[2]};
    ty_read_vector(object, key, 1, direction);
    const double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    if (!(length > 1e-9)) {
        const ty_json_path json_path = ty_json_path_key(path, key);
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "a direction must not be zero");
    }
    memcpy(out, direction, sizeof direction);
    return TY_OK;
}

ty_result ty_read_box(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path, const char* key,
                      double factor, double lower[3], double upper[3]) {
    const json_t* corners = json_object_get(object, key);
    read_array(json_array_get(corners, 0), factor, lower);
    read_array(json_array_get(corners, 1), factor, upper);
    for (int a = 0; a < 3; ++a)
        if (!(upper[a] > lower[a])) {
            const ty_json_path json_path = ty_json_path_key(path, key);
            return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                                  "the second corner must be above the first along %c", "xyz"[a]);
        }
    return TY_OK;
}

ty_result ty_read_edges(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path, double origin[3],
                        double u[3], double v[3]) {
    ty_read_vector(object, "origin", reader->unit, origin);
    ty_read_vector(object, "u", reader->unit, u);
    ty_read_vector(object, "v", reader->unit, v);
    for (int a = 0; a < 3; ++a)
        if (u[a] * v[(a + 1) % 3] != u[(a + 1) % 3] * v[a]) return TY_OK;
    return ty_reader_fail(reader, path, TY_ERROR_INPUT, "the edges u and v span no area");
}

ty_result ty_read_transform(const ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            double from_unit, double to_unit, ty_affine* out) {
    const json_t* transform = json_object_get(object, "transform");
    const ty_json_path json_path = ty_json_path_key(path, "transform");
    ty_affine map = ty_affine_identity();
    if (json_is_array(transform)) {
        for (size_t i = 0; i < 16; ++i) {
            const double value = json_number_value(json_array_get(transform, i));
            if (i < 12)
                map.m[i] = value;
            else if (value != (i == 15 ? 1 : 0))
                return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                                      "the last row of the matrix must be 0, 0, 0, 1");
        }
    } else if (transform != NULL) {
        double translate[3] = {0, 0, 0}, rotate[3] = {0, 0, 0}, scale[3] = {1, 1, 1};
        ty_read_vector(transform, "translate", 1, translate);
        ty_read_vector(transform, "rotate", 1, rotate);
        ty_read_numbers(transform, "scale", scale);
        map = ty_affine_compose(translate, rotate, scale);
    }
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) map.m[4 * r + c] *= from_unit / to_unit;
        map.m[4 * r + 3] *= reader->unit / to_unit;
    }
    ty_affine inverse;
    if (!ty_affine_invert(&map, &inverse))
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "the matrix cannot be inverted");
    *out = map;
    return TY_OK;
}
