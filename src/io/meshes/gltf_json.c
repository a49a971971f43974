/* glTF: JSON values, validated as they are read. */
#include "base/context.h"
#include "io/meshes/gltf.h"
#include "io/schema_text.h"

#include <stdarg.h>
#include <stdio.h>

enum { MESSAGE_SIZE = 1024 };

ty_result ty_gltf_fail(const ty_gltf* gltf, const ty_json_path* json_path, const char* format, ...) {
    char text[MESSAGE_SIZE], where[MESSAGE_SIZE / 4];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ty_json_path_text(json_path, where, sizeof where);
    return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: %s: %s", gltf->path, where, text);
}

ty_json_path ty_gltf_json_path(const char* array, size_t index) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path json_path = ty_json_path_key(&root, array);
    return ty_json_path_index(&json_path, index);
}

ty_result ty_gltf_check_shape(const ty_gltf* gltf) {
    static const char* const arrays[] = {"accessors", "buffers", "bufferViews", "cameras", "images", "materials",
                                         "meshes",    "nodes",   "samplers",    "scenes",  "skins",  "textures"};
    for (size_t a = 0; a < sizeof arrays / sizeof *arrays; ++a) {
        const json_t* array = json_object_get(gltf->root, arrays[a]);
        const ty_json_path root = {.depth = 0};
        const ty_json_path json_path = ty_json_path_key(&root, arrays[a]);
        if (array != NULL && !json_is_array(array)) return ty_gltf_fail(gltf, &json_path, "expected an array");
        size_t i;
        json_t* item;
        json_array_foreach(array, i, item) {
            const ty_json_path here = ty_json_path_index(&json_path, i);
            if (!json_is_object(item)) return ty_gltf_fail(gltf, &here, "expected an object");
        }
    }
    return TY_OK;
}

size_t ty_gltf_count(const ty_gltf* gltf, const char* array) {
    return json_array_size(json_object_get(gltf->root, array));
}

const json_t* ty_gltf_item(const ty_gltf* gltf, const char* array, size_t index) {
    return json_array_get(json_object_get(gltf->root, array), index);
}

const json_t* ty_gltf_extension(const json_t* object, const char* name) {
    return json_object_get(json_object_get(object, "extensions"), name);
}

/* Fails with "...: WHAT is expected, found VALUE". */
static ty_result fail_value(const ty_gltf* gltf, const ty_json_path* json_path, const json_t* value, const char* what) {
    char text[MESSAGE_SIZE / 4] = "";
    ty_append_value(text, sizeof text, value);
    return ty_gltf_fail(gltf, json_path, "expected %s, found %s", what, text);
}

static bool is_whole(const json_t* value) {
    const double number = json_number_value(value);
    return json_is_number(value) && number >= -0x1p62 && number <= 0x1p62 &&
           number == (double)(int64_t)number; /* some writers store 3.0 for 3 */
}

int64_t ty_gltf_node_number(const ty_gltf* gltf, const json_t* value) {
    const double number = is_whole(value) ? json_number_value(value) : -1;
    return number >= 0 && number < (double)ty_gltf_count(gltf, "nodes") ? (int64_t)number : -1;
}

ty_result ty_gltf_read_integer(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path,
                               const char* key, int64_t low, int64_t high, int64_t* out) {
    const json_t* value = json_object_get(object, key);
    if (value == NULL) return TY_OK;
    const ty_json_path here = ty_json_path_key(json_path, key);
    if (!is_whole(value)) return fail_value(gltf, &here, value, "a whole number");
    const int64_t found =
        json_is_integer(value) ? (int64_t)json_integer_value(value) : (int64_t)json_number_value(value);
    if (found < low || found > high)
        return ty_gltf_fail(gltf, &here, "%lld is outside [%lld, %lld]", (long long)found, (long long)low,
                            (long long)high);
    *out = found;
    return TY_OK;
}

static ty_result read_value(const ty_gltf* gltf, const json_t* value, const ty_json_path* json_path, double low,
                            double high, double* out) {
    if (!json_is_number(value)) return fail_value(gltf, json_path, value, "a number");
    const double number = json_number_value(value);
    if (number < low || number > high)
        return ty_gltf_fail(gltf, json_path, "%g is outside [%g, %g]", number, low, high);
    *out = number;
    return TY_OK;
}

ty_result ty_gltf_read_number(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path, const char* key,
                              double low, double high, double* out) {
    const json_t* value = json_object_get(object, key);
    if (value == NULL) return TY_OK;
    const ty_json_path here = ty_json_path_key(json_path, key);
    return read_value(gltf, value, &here, low, high, out);
}

ty_result ty_gltf_read_numbers(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path,
                               const char* key, size_t count, double low, double high, double* out) {
    const json_t* array = json_object_get(object, key);
    if (array == NULL) return TY_OK;
    const ty_json_path here = ty_json_path_key(json_path, key);
    if (!json_is_array(array)) return fail_value(gltf, &here, array, "an array of numbers");
    if (json_array_size(array) != count)
        return ty_gltf_fail(gltf, &here, "expected %zu numbers, found %zu", count, json_array_size(array));
    ty_result result = TY_OK;
    for (size_t i = 0; i < count && result == TY_OK; ++i) {
        const ty_json_path element = ty_json_path_index(&here, i);
        result = read_value(gltf, json_array_get(array, i), &element, low, high, &out[i]);
    }
    return result;
}

ty_result ty_gltf_read_reference(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path,
                                 const char* key, const char* array, int64_t* out) {
    *out = -1;
    const ty_result result = ty_gltf_read_integer(gltf, object, json_path, key, 0, INT32_MAX, out);
    if (result != TY_OK || *out < (int64_t)ty_gltf_count(gltf, array)) return result;
    const ty_json_path here = ty_json_path_key(json_path, key);
    return ty_gltf_fail(gltf, &here, "there is no %s[%lld]", array, (long long)*out);
}
