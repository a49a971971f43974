/* Writing a copy of a glTF file with second texture coordinates. */
#include "base/context.h"
#include "io/meshes/gltf_writer.h"

#include <math.h>
#include <string.h>

/* The elements of an accessor in the output's binary chunk. */
typedef struct elements {
    size_t at, stride, size; /* of one */
    int64_t count;
} elements;

static size_t component_bytes(int64_t type) {
    return type == TY_GLTF_U8 || type == TY_GLTF_I8 ? 1 : type == TY_GLTF_U16 || type == TY_GLTF_I16 ? 2 : 4;
}

static size_t components_of(const char* type) {
    if (strncmp(type, "VEC", 3) == 0 && type[3] >= '2' && type[3] <= '4') return (size_t)(type[3] - '0');
    return strcmp(type, "SCALAR") == 0 ? 1 : 0;
}

static int64_t member(const json_t* object, const char* name, int64_t absent) {
    const json_t* value = json_object_get(object, name);
    return json_is_integer(value) ? (int64_t)json_integer_value(value) : absent;
}

/* False: none that could be copied. */
static bool find_elements(const ty_gltf_writer* w, int64_t index, elements* out) {
    const json_t* accessor = json_array_get(json_object_get(w->root, "accessors"), (size_t)index);
    const char* type = json_string_value(json_object_get(accessor, "type"));
    const int64_t view_index = member(accessor, "bufferView", -1);
    const json_t* view = json_array_get(json_object_get(w->root, "bufferViews"), (size_t)view_index);
    if (type == NULL || view_index < 0 || view == NULL || json_object_get(accessor, "sparse") != NULL) return false;
    const int64_t at = member(view, "byteOffset", 0) + member(accessor, "byteOffset", 0);
    out->size = components_of(type) * component_bytes(member(accessor, "componentType", 0));
    out->stride = (size_t)member(view, "byteStride", (int64_t)out->size);
    out->count = member(accessor, "count", 0);
    if (at < 0 || out->size == 0 || out->stride < out->size || out->stride > 252 || out->count < 1) return false;
    out->at = (size_t)at;
    return out->at <= w->size && (size_t)out->count <= w->size &&
           out->at + ((size_t)out->count - 1) * out->stride + out->size <= w->size;
}

static ty_result fail_layout(const ty_gltf_writer* w, const ty_mesh_origin* origin, const char* name) {
    return ty_fail(w->gltf.context, TY_ERROR_INPUT, "%s: node %d, primitive %d: %s cannot be given new vertices",
                   w->gltf.path, (int)origin->node, (int)origin->primitive, name);
}

/* Positions must have bounds, and exact ones. */
static ty_result set_bounds(const ty_gltf_writer* w, json_t* accessor, size_t at, size_t stride, int64_t count) {
    if (member(accessor, "componentType", 0) != TY_GLTF_F32) return TY_OK; /* quantized ones keep theirs */
    double bounds[2][3] = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int64_t i = 0; i < count; ++i)
        for (size_t a = 0; a < 3; ++a) {
            const uint8_t* bytes = w->body + at + stride * (size_t)i + 4 * a;
            uint32_t bits = 0;
            for (size_t b = 0; b < 4; ++b) bits |= (uint32_t)bytes[b] << (8 * b);
            float value;
            memcpy(&value, &bits, sizeof value);
            bounds[0][a] = fmin(bounds[0][a], (double)value);
            bounds[1][a] = fmax(bounds[1][a], (double)value);
        }
    for (int i = 0; i < 2; ++i) {
        json_t* corner = json_pack("[f, f, f]", bounds[i][0], bounds[i][1], bounds[i][2]);
        if (corner == NULL || json_object_set_new(accessor, i == 0 ? "min" : "max", corner) != 0)
            return ty_gltf_no_memory(w);
    }
    return TY_OK;
}

/* Appends elements, aligned to four bytes each, as an accessor like another. */
static ty_result gather(ty_gltf_writer* w, int64_t from, const ty_mesh_uv2* mesh, const elements* source,
                        int64_t* index) {
    const size_t stride = (source->size + 3) & ~(size_t)3;
    size_t at = 0;
    int64_t view = 0;
    ty_result result = ty_gltf_append(w, NULL, stride * (size_t)mesh->vertex_count, &at);
    for (int64_t i = 0; i < mesh->vertex_count && result == TY_OK; ++i) {
        const int64_t vertex = mesh->origin.first_vertex + mesh->source[i];
        if (vertex < 0 || vertex >= source->count) return ty_gltf_fail_changed(w, &mesh->origin);
        memcpy(w->body + at + stride * (size_t)i, w->body + source->at + source->stride * (size_t)vertex, source->size);
    }
    if (result == TY_OK) result = ty_gltf_add_view(w, at, stride * (size_t)mesh->vertex_count, &view);
    if (result != TY_OK) return result;
    json_t* views = json_object_get(w->root, "bufferViews");
    if (json_object_set_new(json_array_get(views, (size_t)view), "byteStride", json_integer((json_int_t)stride)) != 0)
        return ty_gltf_no_memory(w);
    json_t* copy = json_deep_copy(json_array_get(json_object_get(w->root, "accessors"), (size_t)from));
    json_object_del(copy, "byteOffset");
    if (copy == NULL || json_object_set_new(copy, "bufferView", json_integer((json_int_t)view)) != 0 ||
        json_object_set_new(copy, "count", json_integer((json_int_t)mesh->vertex_count)) != 0) {
        json_decref(copy);
        return ty_gltf_no_memory(w);
    }
    if (json_object_get(copy, "min") != NULL && source->size == 12)
        result = set_bounds(w, copy, at, stride, mesh->vertex_count);
    if (result == TY_OK) return ty_gltf_add_item(w, "accessors", copy, index);
    json_decref(copy);
    return result;
}

/* Appends an array as an accessor. */
static ty_result add_array(ty_gltf_writer* w, const uint8_t* bytes, size_t size, int type, int64_t count,
                           const char* kind, int64_t* index) {
    size_t at = 0;
    int64_t view = 0;
    ty_result result = ty_gltf_append(w, bytes, size, &at);
    if (result == TY_OK) result = ty_gltf_add_view(w, at, size, &view);
    if (result != TY_OK) return result;
    return ty_gltf_add_item(w, "accessors",
                            json_pack("{s:I, s:i, s:I, s:s}", "bufferView", (json_int_t)view, "componentType", type,
                                      "count", (json_int_t)count, "type", kind),
                            index);
}

static ty_result add_coordinates(ty_gltf_writer* w, const ty_mesh_uv2* mesh, int64_t* uv, int64_t* indices) {
    const size_t floats = 2 * (size_t)mesh->vertex_count, corners = 3 * (size_t)mesh->triangle_count;
    const size_t words = floats > corners ? floats : corners;
    uint8_t* bytes = ty_alloc_array(w->gltf.context, words, 4, false);
    if (bytes == NULL) return TY_ERROR_MEMORY;
    ty_gltf_put_floats(mesh->uv, floats, bytes);
    ty_result result = add_array(w, bytes, 4 * floats, TY_GLTF_F32, mesh->vertex_count, "VEC2", uv);
    for (size_t i = 0; i < corners; ++i)
        for (size_t b = 0; b < 4; ++b) bytes[4 * i + b] = (uint8_t)(mesh->indices[i] >> (8 * b));
    if (result == TY_OK)
        result = add_array(w, bytes, 4 * corners, TY_GLTF_U32, 3 * mesh->triangle_count, "SCALAR", indices);
    ty_free_array(w->gltf.context, bytes, words, 4);
    return result;
}

/* The mesh of a node, or NULL where another node gave it its coordinates. */
static ty_result find_mesh(ty_gltf_writer* w, const ty_mesh_origin* origin, json_t** out) {
    const json_t* node = json_array_get(json_object_get(w->root, "nodes"), (size_t)origin->node);
    const int64_t index = member(node, "mesh", -1);
    *out = index < 0 || (size_t)index >= w->mesh_count
               ? NULL
               : json_array_get(json_object_get(w->root, "meshes"), (size_t)index);
    if (*out == NULL) return ty_gltf_fail_changed(w, origin);
    if (w->mesh_nodes[index] == 0) w->mesh_nodes[index] = origin->node + 1;
    if (w->mesh_nodes[index] != origin->node + 1) *out = NULL;
    return TY_OK;
}

static ty_result unwrap_primitive(ty_gltf_writer* w, const ty_mesh_uv2* mesh) {
    json_t* owner = NULL;
    ty_result result = find_mesh(w, &mesh->origin, &owner);
    if (result != TY_OK || owner == NULL) return result;
    json_t* primitive = json_array_get(json_object_get(owner, "primitives"), (size_t)mesh->origin.primitive);
    json_t* attributes = json_object_get(primitive, "attributes");
    if (!json_is_object(attributes)) return ty_gltf_fail_changed(w, &mesh->origin);
    if (json_object_get(primitive, "targets") != NULL) return fail_layout(w, &mesh->origin, "morph targets");
    json_t* made = json_object();
    const char* name;
    json_t* value;
    int64_t uv = 0, indices = 0;
    json_object_foreach(attributes, name, value) {
        elements source;
        int64_t index = 0;
        if (result != TY_OK || strcmp(name, "TEXCOORD_1") == 0) continue;
        const int64_t from = json_is_integer(value) ? (int64_t)json_integer_value(value) : -1;
        result = from >= 0 && find_elements(w, from, &source) ? gather(w, from, mesh, &source, &index)
                                                              : fail_layout(w, &mesh->origin, name);
        if (result == TY_OK && json_object_set_new(made, name, json_integer((json_int_t)index)) != 0)
            result = ty_gltf_no_memory(w);
    }
    if (result == TY_OK) result = add_coordinates(w, mesh, &uv, &indices);
    if (result == TY_OK && (json_object_set_new(made, "TEXCOORD_1", json_integer((json_int_t)uv)) != 0 ||
                            json_object_set_new(primitive, "indices", json_integer((json_int_t)indices)) != 0 ||
                            json_object_set_new(primitive, "mode", json_integer(4)) != 0 ||
                            json_object_set(primitive, "attributes", made) != 0))
        result = ty_gltf_no_memory(w);
    json_decref(made);
    return result;
}

ty_result ty_mesh_file_write_uv2(ty_context* context, const char* from, const ty_mesh_uv2* meshes, int64_t count,
                                 const char* path) {
    if (from == NULL || path == NULL || count < 0 || (count > 0 && meshes == NULL))
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_mesh_file_write_uv2: an argument is NULL or negative");
    ty_gltf_writer w;
    ty_result result = ty_gltf_writer_open(&w, context, from, "texture coordinates");
    for (int64_t i = 0; i < count && result == TY_OK; ++i) result = unwrap_primitive(&w, &meshes[i]);
    if (result == TY_OK) result = ty_gltf_writer_finish(&w, NULL, path);
    ty_gltf_writer_close(&w);
    return result;
}
