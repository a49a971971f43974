/* glTF buffer views compressed by meshoptimizer (EXT_meshopt_compression). */
#include "base/context.h"
#include "io/file.h"
#include "io/meshes/gltf.h"

#include <string.h>

#if TYNDALL_MESHOPT
#include <meshoptimizer.h>
#endif

/* Compressed bytes of a view with the parameters of their decoder. */
typedef struct packing {
    const uint8_t* bytes;
    size_t size, count, stride;
    const char *mode, *filter;
} packing;

const json_t* ty_gltf_packed_view(const json_t* view) {
    return ty_gltf_extension(view, "EXT_meshopt_compression");
}

#if TYNDALL_MESHOPT

static bool is(const char* text, const char* word) {
    return strcmp(text, word) == 0;
}

/* Preconditions of the library; NULL if they are met. */
static const char* find_fault(const packing* p) {
    const bool attributes = is(p->mode, "ATTRIBUTES"), triangles = is(p->mode, "TRIANGLES");
    if (!attributes && !triangles && !is(p->mode, "INDICES")) return "the mode is not ATTRIBUTES, TRIANGLES or INDICES";
    if (attributes && (p->stride % 4 != 0 || p->stride > 256)) return "the byteStride is not 4, 8 ... 256";
    if (!attributes && p->stride != 2 && p->stride != 4) return "the byteStride is neither 2 nor 4";
    if (triangles && p->count % 3 != 0) return "the count is not that of whole triangles";
    if (is(p->filter, "NONE")) return NULL;
    if (!attributes) return "there is a filter for indices";
    if (is(p->filter, "OCTAHEDRAL")) return p->stride == 4 || p->stride == 8 ? NULL : "OCTAHEDRAL needs 4 or 8 bytes";
    if (is(p->filter, "QUATERNION")) return p->stride == 8 ? NULL : "QUATERNION needs 8 bytes";
    return is(p->filter, "EXPONENTIAL") ? NULL : "the filter is not NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL";
}

static bool decode(const packing* p, uint8_t* to) {
    if (is(p->mode, "TRIANGLES")) return meshopt_decodeIndexBuffer(to, p->count, p->stride, p->bytes, p->size) == 0;
    if (is(p->mode, "INDICES")) return meshopt_decodeIndexSequence(to, p->count, p->stride, p->bytes, p->size) == 0;
    if (meshopt_decodeVertexBuffer(to, p->count, p->stride, p->bytes, p->size) != 0) return false;
    if (is(p->filter, "OCTAHEDRAL")) meshopt_decodeFilterOct(to, p->count, p->stride);
    if (is(p->filter, "QUATERNION")) meshopt_decodeFilterQuat(to, p->count, p->stride);
    if (is(p->filter, "EXPONENTIAL")) meshopt_decodeFilterExp(to, p->count, p->stride);
    return true;
}

#else

static const char* find_fault(const packing* p) {
    (void)p;
    return "compressed by meshoptimizer, which this build was made without; \"gltf-transform copy\" decompresses it";
}

static bool decode(const packing* p, uint8_t* to) {
    (void)p;
    (void)to;
    return false;
}

#endif

static ty_result read_packing(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path, packing* p) {
    int64_t buffer = -1, offset = 0, size = 0, count = 0, stride = 0;
    ty_result result = ty_gltf_read_reference(gltf, json, json_path, "buffer", "buffers", &buffer);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, json_path, "byteOffset", 0, INT64_MAX, &offset);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, json_path, "byteLength", 1, INT64_MAX, &size);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, json_path, "count", 1, INT32_MAX, &count);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, json, json_path, "byteStride", 1, 256, &stride);
    if (result != TY_OK) return result;
    p->mode = json_string_value(json_object_get(json, "mode"));
    p->filter = json_string_value(json_object_get(json, "filter"));
    if (p->filter == NULL) p->filter = "NONE";
    if (buffer < 0 || size == 0 || count == 0 || stride == 0 || p->mode == NULL)
        return ty_gltf_fail(gltf, json_path, "buffer, byteLength, byteStride, count or mode is missing");
    const ty_gltf_buffer* from = NULL;
    result = ty_gltf_open_buffer(gltf, (size_t)buffer, &from);
    if (result != TY_OK) return result;
    if ((uint64_t)offset > from->size || (uint64_t)size > from->size - (uint64_t)offset)
        return ty_gltf_fail(gltf, json_path, "reaches past the end of its buffer");
    p->bytes = from->data + offset;
    p->size = (size_t)size;
    p->count = (size_t)count;
    p->stride = (size_t)stride;
    return TY_OK;
}

ty_result ty_gltf_unpack_view(ty_gltf* gltf, size_t index, const uint8_t** data, size_t* size) {
    enum { RATIO_MAX = 256, SMALL = 1 << 16 }; /* 16 equal bytes take two bits */
    ty_gltf_buffer* unpacked = &gltf->views[index];
    if (unpacked->data == NULL) {
        const ty_json_path view = ty_gltf_json_path("bufferViews", index);
        const ty_json_path extensions = ty_json_path_key(&view, "extensions");
        const ty_json_path here = ty_json_path_key(&extensions, "EXT_meshopt_compression");
        packing p = {0};
        const ty_result result =
            read_packing(gltf, ty_gltf_packed_view(ty_gltf_item(gltf, "bufferViews", index)), &here, &p);
        if (result != TY_OK) return result;
        const char* fault = find_fault(&p);
        if (fault != NULL) return ty_gltf_fail(gltf, &here, "%s", fault);
        const size_t length = p.count * p.stride;
        if (length > p.size * RATIO_MAX + SMALL)
            return ty_gltf_fail(gltf, &here, "%zu bytes cannot hold %zu elements", p.size, p.count);
        uint8_t* bytes = ty_alloc_array(gltf->context, length + 1, 1, false);
        if (bytes == NULL) return TY_ERROR_MEMORY;
        if (!decode(&p, bytes)) {
            ty_free_file(gltf->context, bytes, length);
            return ty_gltf_fail(gltf, &here, "the compressed data are damaged");
        }
        *unpacked = (ty_gltf_buffer){bytes, length, bytes, length};
    }
    *data = unpacked->data;
    *size = unpacked->size;
    return TY_OK;
}
