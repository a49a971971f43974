/* glTF primitives compressed by Draco (KHR_draco_mesh_compression). */
#include "base/context.h"
#include "io/meshes/draco.h"
#include "io/meshes/gltf.h"

#include <stdio.h>

static ty_json_path draco_path(const ty_gltf_primitive* p) {
    const ty_json_path extensions = ty_json_path_key(&p->json_path, "extensions");
    return ty_json_path_key(&extensions, "KHR_draco_mesh_compression");
}

/* True if positions are also there uncompressed, for readers without Draco. */
static bool has_fallback(const ty_gltf* gltf, const ty_gltf_primitive* p) {
    const json_t* position = json_object_get(json_object_get(p->json, "attributes"), "POSITION");
    const json_int_t index = json_is_integer(position) ? json_integer_value(position) : -1;
    return index >= 0 && json_object_get(ty_gltf_item(gltf, "accessors", (size_t)index), "bufferView") != NULL;
}

static ty_result read_corners(ty_gltf* gltf, ty_gltf_primitive* p, const ty_json_path* here) {
    const size_t triangles = ty_draco_triangles(p->draco);
    p->unpacked.vertices = ty_draco_vertices(p->draco);
    if (triangles == 0 || p->unpacked.vertices == 0)
        return ty_gltf_fail(gltf, here, "there are no triangles in this Draco mesh");
    p->corner_count = 3 * triangles;
    p->corners = ty_alloc_array(gltf->context, p->corner_count, sizeof *p->corners, false);
    if (p->corners == NULL) return TY_ERROR_MEMORY;
    return ty_draco_read_indices(p->draco, p->corners)
               ? TY_OK
               : ty_gltf_fail(gltf, here, "the Draco mesh names vertices that it does not have");
}

ty_result ty_gltf_open_draco(ty_gltf* gltf, ty_gltf_primitive* p) {
    const json_t* extension = ty_gltf_extension(p->json, "KHR_draco_mesh_compression");
    if (extension == NULL || has_fallback(gltf, p)) return TY_OK;
    const ty_json_path here = draco_path(p);
    int64_t view = -1;
    ty_result result = ty_gltf_read_reference(gltf, extension, &here, "bufferView", "bufferViews", &view);
    if (result != TY_OK) return result;
    if (view < 0) return ty_gltf_fail(gltf, &here, "bufferView is missing");
    const uint8_t* data = NULL;
    size_t size = 0, stride = 0;
    result = ty_gltf_open_view(gltf, (size_t)view, &data, &size, &stride);
    if (result != TY_OK) return result;
    char text[256], place[512];
    ty_json_path_text(&p->json_path, text, sizeof text);
    snprintf(place, sizeof place, "%s: %s", gltf->path, text);
    result = ty_draco_decode(gltf->context, place, data, size, &p->draco);
    return result == TY_OK ? read_corners(gltf, p, &here) : result;
}

/* Divides integers by the largest value of their type in the file. */
static void normalize(const ty_gltf_accessor* accessor, float* values, size_t count) {
    const float largest = accessor->type == TY_GLTF_I8    ? 0x7f
                          : accessor->type == TY_GLTF_U8  ? 0xff
                          : accessor->type == TY_GLTF_I16 ? 0x7fff
                                                          : 0xffff;
    for (size_t i = 0; i < count; ++i) values[i] = values[i] < -largest ? -1 : values[i] / largest;
}

ty_result ty_gltf_unpack_attribute(ty_gltf* gltf, ty_gltf_primitive* p, const char* name, ty_gltf_accessor* accessor) {
    if (p->draco == NULL) return TY_OK;
    const ty_json_path here = draco_path(p), attributes = ty_json_path_key(&here, "attributes");
    const json_t* extension = ty_gltf_extension(p->json, "KHR_draco_mesh_compression");
    int64_t id = -1;
    ty_result result =
        ty_gltf_read_integer(gltf, json_object_get(extension, "attributes"), &attributes, name, 0, UINT32_MAX, &id);
    if (result != TY_OK || id < 0) return result;
    ty_gltf_unpacked* unpacked = &p->unpacked;
    if (accessor->count != unpacked->vertices)
        return ty_gltf_fail(gltf, &accessor->json_path, "%zu elements, but %zu vertices in the Draco mesh",
                            accessor->count, unpacked->vertices);
    const size_t width = accessor->components;
    if (unpacked->count == sizeof unpacked->arrays / sizeof *unpacked->arrays)
        return ty_gltf_fail(gltf, &here, "more than %zu attributes", unpacked->count);
    float* values = ty_alloc_array(gltf->context, unpacked->vertices, width * sizeof *values, false);
    if (values == NULL) return TY_ERROR_MEMORY;
    unpacked->arrays[unpacked->count] = values;
    unpacked->widths[unpacked->count++] = width;
    bool normalized = false;
    if (!ty_draco_read_attribute(p->draco, (uint32_t)id, width, values, &normalized))
        return ty_gltf_fail(gltf, &here, "the Draco mesh has no %s of %zu components", name, width);
    if (accessor->normalized && !normalized && accessor->type != TY_GLTF_F32)
        normalize(accessor, values, unpacked->vertices * width);
    *accessor = (ty_gltf_accessor){.json_path = accessor->json_path,
                                   .count = unpacked->vertices,
                                   .components = width,
                                   .type = TY_GLTF_F32,
                                   .normalized = accessor->normalized,
                                   .data = (const uint8_t*)values,
                                   .stride = width * sizeof *values};
    return TY_OK;
}

void ty_gltf_close_draco(ty_gltf* gltf, ty_gltf_primitive* p) {
    for (size_t i = 0; i < p->unpacked.count; ++i)
        ty_free_array(gltf->context, p->unpacked.arrays[i], p->unpacked.vertices,
                      p->unpacked.widths[i] * sizeof(float));
    if (p->draco != NULL) ty_draco_free(p->draco);
}
