/* Points in JSON files: positions of probes. */
#include "io/points.h"

#include "base/context.h"
#include "io/file.h"
#include "io/json_parse.h"

#include <jansson.h>
#include <math.h>

static const size_t file_size_max = (size_t)1 << 30;
static const double coordinate_max = 1e15;

static ty_result fill(ty_context* context, const char* path, const json_t* list, float* points) {
    size_t i;
    json_t* point;
    json_array_foreach(list, i, point) {
        for (size_t axis = 0; axis < 3; ++axis) {
            const json_t* value = json_array_get(point, axis);
            const double number = json_is_number(value) ? json_number_value(value) : NAN;
            if (json_array_size(point) != 3 || !(fabs(number) <= coordinate_max))
                return ty_fail(context, TY_ERROR_INPUT, "%s: positions[%zu] is not [x, y, z] in metres", path, i);
            points[3 * i + axis] = (float)number;
        }
    }
    return TY_OK;
}

static ty_result read_points(ty_context* context, const char* path, const json_t* root, float** out, int64_t* count) {
    const json_t* list = json_is_object(root) ? json_object_get(root, "positions") : root;
    const size_t size = json_array_size(list);
    if (size == 0)
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: no points: neither an array of [x, y, z] nor an object with one called \"positions\"",
                       path);
    float* points = ty_alloc_array(context, size, 3 * sizeof *points, false);
    if (points == NULL) return TY_ERROR_MEMORY;
    const ty_result result = fill(context, path, list, points);
    if (result == TY_OK) {
        *out = points;
        *count = (int64_t)size;
    } else {
        ty_points_destroy(context, points, (int64_t)size);
    }
    return result;
}

ty_result ty_points_parse(ty_context* context, const char* path, const uint8_t* text, size_t size, float** out,
                          int64_t* count) {
    json_t* root = NULL;
    ty_result result = ty_json_parse(context, path, (const char*)text, size, &root);
    if (result == TY_OK) result = read_points(context, path, root, out, count);
    json_decref(root);
    return result;
}

ty_result ty_points_read(ty_context* context, const char* path, float** out, int64_t* count) {
    if (path == NULL || out == NULL || count == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_points_read: an argument is NULL");
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_file(context, path, file_size_max, &bytes, &size);
    if (result != TY_OK) return result;
    result = ty_points_parse(context, path, bytes, size, out, count);
    ty_free_file(context, bytes, size);
    return result;
}

void ty_points_destroy(ty_context* context, float* points, int64_t count) {
    ty_free_array(context, points, (size_t)count, 3 * sizeof *points);
}
