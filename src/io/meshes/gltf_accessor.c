/* glTF accessors: typed arrays in buffer views, dense or sparse. */
#include "io/meshes/gltf.h"

#include <string.h>

/* Limit of implicit zeros, which take no bytes in the file. */
enum { ZEROS_MAX = 1 << 24 };

static size_t component_size(int64_t type) {
    switch (type) {
    case TY_GLTF_I8:
    case TY_GLTF_U8: return 1;
    case TY_GLTF_I16:
    case TY_GLTF_U16: return 2;
    case TY_GLTF_U32:
    case TY_GLTF_F32: return 4;
    default: return 0;
    }
}

/* ---- opening ---- */

/* Validates the byte range of `count` elements of `size` bytes with stride *stride (0: packed, which sets it). */
static ty_result open_elements(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path, size_t count,
                               size_t size, const uint8_t** data, size_t* stride) {
    int64_t view = -1, offset = 0;
    ty_result result = ty_gltf_read_reference(gltf, json, json_path, "bufferView", "bufferViews", &view);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, json_path, "byteOffset", 0, INT64_MAX, &offset);
    if (result != TY_OK || view < 0) return result;
    const uint8_t* bytes = NULL;
    size_t length = 0;
    result = ty_gltf_open_view(gltf, (size_t)view, &bytes, &length, stride);
    if (result != TY_OK) return result;
    if (*stride == 0) *stride = size;
    if (*stride < size)
        return ty_gltf_fail(gltf, json_path, "its elements take %zu bytes, more than the byteStride of %zu", size,
                            *stride);
    size_t reach = 0;
    if (__builtin_mul_overflow(count - 1, *stride, &reach) || __builtin_add_overflow(reach, size, &reach) ||
        reach > length || (uint64_t)offset > length - reach)
        return ty_gltf_fail(gltf, json_path, "reaches past the end of its bufferView");
    *data = bytes + offset;
    return TY_OK;
}

static uint32_t load_index(const uint8_t* at, int32_t type) {
    uint16_t narrow;
    uint32_t wide;
    switch (type) {
    case TY_GLTF_U8: return *at;
    case TY_GLTF_U16: memcpy(&narrow, at, sizeof narrow); return narrow;
    default: memcpy(&wide, at, sizeof wide); return wide;
    }
}

static uint32_t sparse_index(const ty_gltf_accessor* accessor, size_t i) {
    return load_index(accessor->sparse_indices + i * component_size(accessor->sparse_type), accessor->sparse_type);
}

/* The format wants increasing indices, and ty_gltf_read_floats searches among them. */
static ty_result check_sparse_indices(ty_gltf* gltf, const ty_json_path* json_path, const ty_gltf_accessor* accessor) {
    for (size_t i = 0; i < accessor->sparse_count; ++i) {
        const uint32_t index = sparse_index(accessor, i);
        if (index >= accessor->count)
            return ty_gltf_fail(gltf, json_path, "index %u is past the end of %zu elements", index, accessor->count);
        if (i > 0 && index <= sparse_index(accessor, i - 1))
            return ty_gltf_fail(gltf, json_path, "index %u follows %u: they do not increase", index,
                                sparse_index(accessor, i - 1));
    }
    return TY_OK;
}

static ty_result open_sparse(ty_gltf* gltf, const json_t* sparse, ty_gltf_accessor* accessor) {
    const ty_json_path json_path = ty_json_path_key(&accessor->json_path, "sparse");
    const ty_json_path indices_path = ty_json_path_key(&json_path, "indices");
    const ty_json_path values_path = ty_json_path_key(&json_path, "values");
    const json_t* indices = json_object_get(sparse, "indices");
    int64_t count = 0, type = 0;
    ty_result result = ty_gltf_read_integer(gltf, sparse, &json_path, "count", 1, (int64_t)accessor->count, &count);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, indices, &indices_path, "componentType", 0, 9999, &type);
    if (result != TY_OK) return result;
    if (count == 0) return ty_gltf_fail(gltf, &json_path, "count is missing");
    if (type != TY_GLTF_U8 && type != TY_GLTF_U16 && type != TY_GLTF_U32)
        return ty_gltf_fail(gltf, &indices_path, "the componentType is not that of unsigned integers");
    accessor->sparse_type = (int32_t)type;
    const size_t index_size = component_size(type), value_size = component_size(accessor->type) * accessor->components;
    size_t index_stride = 0, value_stride = 0;
    result = open_elements(gltf, indices, &indices_path, (size_t)count, index_size, &accessor->sparse_indices,
                           &index_stride);
    if (result == TY_OK)
        result = open_elements(gltf, json_object_get(sparse, "values"), &values_path, (size_t)count, value_size,
                               &accessor->sparse_values, &value_stride);
    if (result != TY_OK) return result;
    if (accessor->sparse_indices == NULL || accessor->sparse_values == NULL)
        return ty_gltf_fail(gltf, &json_path, "indices or values have no bufferView");
    if (index_stride != index_size || value_stride != value_size)
        return ty_gltf_fail(gltf, &json_path, "indices and values must be packed, without a byteStride");
    accessor->sparse_count = (size_t)count;
    return check_sparse_indices(gltf, &indices_path, accessor);
}

static size_t component_count(const char* type) {
    static const char* const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    for (size_t i = 0; i < 4 && type != NULL; ++i)
        if (strcmp(type, types[i]) == 0) return i + 1;
    return type != NULL && strcmp(type, "MAT4") == 0 ? 16 : 0;
}

ty_result ty_gltf_open_accessor(ty_gltf* gltf, size_t index, ty_gltf_accessor* accessor) {
    *accessor = (ty_gltf_accessor){.json_path = ty_gltf_json_path("accessors", index)};
    const json_t* json = ty_gltf_item(gltf, "accessors", index);
    int64_t count = 0, type = 0;
    ty_result result = ty_gltf_read_integer(gltf, json, &accessor->json_path, "count", 1, INT32_MAX, &count);
    if (result == TY_OK)
        result = ty_gltf_read_integer(gltf, json, &accessor->json_path, "componentType", 0, 9999, &type);
    if (result != TY_OK) return result;
    accessor->components = component_count(json_string_value(json_object_get(json, "type")));
    if (count == 0) return ty_gltf_fail(gltf, &accessor->json_path, "count is missing");
    if (component_size(type) == 0)
        return ty_gltf_fail(gltf, &accessor->json_path, "%lld is not a componentType", (long long)type);
    if (accessor->components == 0)
        return ty_gltf_fail(gltf, &accessor->json_path, "the type is not SCALAR, VEC2, VEC3, VEC4 or MAT4");
    accessor->count = (size_t)count;
    accessor->type = (int32_t)type;
    accessor->normalized = json_is_true(json_object_get(json, "normalized"));
    result = open_elements(gltf, json, &accessor->json_path, accessor->count,
                           component_size(type) * accessor->components, &accessor->data, &accessor->stride);
    if (result != TY_OK) return result;
    if (accessor->data == NULL && count > ZEROS_MAX)
        return ty_gltf_fail(gltf, &accessor->json_path, "%lld elements without a bufferView, more than %d",
                            (long long)count, (int)ZEROS_MAX);
    const json_t* sparse = json_object_get(json, "sparse");
    return sparse == NULL ? TY_OK : open_sparse(gltf, sparse, accessor);
}

/* ---- reading ---- */

static float load_float(const uint8_t* at, int32_t type, bool normalized) {
    int16_t short_value;
    float value;
    switch (type) {
    case TY_GLTF_I8: value = (float)(int8_t)*at; break;
    case TY_GLTF_U8: value = (float)*at; break;
    case TY_GLTF_I16:
        memcpy(&short_value, at, sizeof short_value);
        value = (float)short_value;
        break;
    case TY_GLTF_U16: value = (float)load_index(at, type); break;
    case TY_GLTF_U32: value = (float)load_index(at, type); break;
    default: memcpy(&value, at, sizeof value); return value;
    }
    if (!normalized) return value;
    const float largest = type == TY_GLTF_I8    ? 0x7f
                          : type == TY_GLTF_U8  ? 0xff
                          : type == TY_GLTF_I16 ? 0x7fff
                          : type == TY_GLTF_U16 ? 0xffff
                                                : 0x1p32f;
    return value < -largest ? -1 : value / largest;
}

static void load_element(const ty_gltf_accessor* accessor, const uint8_t* at, size_t width, float* out) {
    const size_t size = component_size(accessor->type);
    const size_t count = accessor->components < width ? accessor->components : width;
    for (size_t c = 0; c < count; ++c) out[c] = load_float(at + c * size, accessor->type, accessor->normalized);
}

/* Number of the first sparse value for an element from `first` on. */
static size_t find_sparse(const ty_gltf_accessor* accessor, size_t first) {
    size_t low = 0, high = accessor->sparse_count;
    while (low < high) {
        const size_t center = low + (high - low) / 2;
        if (sparse_index(accessor, center) < first)
            low = center + 1;
        else
            high = center;
    }
    return low;
}

void ty_gltf_read_floats(const ty_gltf_accessor* accessor, size_t first, size_t count, size_t width, float* out) {
    static const uint8_t zeros[16 * sizeof(float)];
    for (size_t i = 0; i < count; ++i)
        load_element(accessor, accessor->data == NULL ? zeros : accessor->data + (first + i) * accessor->stride, width,
                     out + i * width);
    const size_t value_size = component_size(accessor->type) * accessor->components;
    for (size_t i = find_sparse(accessor, first); i < accessor->sparse_count; ++i) {
        const size_t index = sparse_index(accessor, i);
        if (index - first >= count) break;
        load_element(accessor, accessor->sparse_values + i * value_size, width, out + (index - first) * width);
    }
}

void ty_gltf_read_indices(const ty_gltf_accessor* accessor, uint32_t* out) {
    for (size_t i = 0; i < accessor->count; ++i)
        out[i] = accessor->data == NULL ? 0 : load_index(accessor->data + i * accessor->stride, accessor->type);
    for (size_t i = 0; i < accessor->sparse_count; ++i)
        out[sparse_index(accessor, i)] =
            load_index(accessor->sparse_values + i * component_size(accessor->type), accessor->type);
}
