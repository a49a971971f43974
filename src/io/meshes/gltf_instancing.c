/* Instances of a glTF node's mesh (EXT_mesh_gpu_instancing). */
#include "base/context.h"
#include "io/meshes/gltf.h"

enum { INSTANCES_MAX = 1 << 20 };

static ty_result open_values(ty_gltf* gltf, const json_t* attributes, const ty_json_path* json_path, const char* name,
                             size_t width, ty_gltf_accessor* accessor, size_t* count) {
    int64_t index = -1;
    *accessor = (ty_gltf_accessor){.count = 0};
    ty_result result = ty_gltf_read_reference(gltf, attributes, json_path, name, "accessors", &index);
    if (result == TY_OK && index >= 0) result = ty_gltf_open_accessor(gltf, (size_t)index, accessor);
    if (result != TY_OK || index < 0) return result;
    if (accessor->components != width || accessor->count > INSTANCES_MAX || (*count > 0 && accessor->count != *count))
        return ty_gltf_fail(gltf, &accessor->json_path, "%zu components for %zu instances", accessor->components,
                            accessor->count);
    *count = accessor->count;
    return TY_OK;
}

static void read_values(const ty_gltf_accessor* accessor, size_t i, size_t width, double* out) {
    float values[4];
    if (accessor->count == 0) return;
    ty_gltf_read_floats(accessor, i, 1, width, values);
    for (size_t k = 0; k < width; ++k) out[k] = (double)values[k];
}

ty_result ty_gltf_read_instances(ty_gltf* gltf, const json_t* node, ty_affine** out, size_t* count) {
    const ty_json_path root = {.depth = 0}, json_path = ty_json_path_key(&root, "EXT_mesh_gpu_instancing");
    const json_t* attributes = json_object_get(ty_gltf_extension(node, "EXT_mesh_gpu_instancing"), "attributes");
    ty_gltf_accessor translations, rotations, scales;
    *count = 0;
    ty_result result = open_values(gltf, attributes, &json_path, "TRANSLATION", 3, &translations, count);
    if (result == TY_OK) result = open_values(gltf, attributes, &json_path, "ROTATION", 4, &rotations, count);
    if (result == TY_OK) result = open_values(gltf, attributes, &json_path, "SCALE", 3, &scales, count);
    if (result != TY_OK || *count == 0) return result;
    *out = ty_alloc_array(gltf->context, *count, sizeof **out, false);
    if (*out == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < *count; ++i) {
        double translation[3] = {0, 0, 0}, quaternion[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
        read_values(&translations, i, 3, translation);
        read_values(&rotations, i, 4, quaternion);
        read_values(&scales, i, 3, scale);
        (*out)[i] = ty_gltf_compose(translation, quaternion, scale);
    }
    return TY_OK;
}
