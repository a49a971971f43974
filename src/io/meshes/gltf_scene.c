/* glTF node hierarchy with its meshes, lights and cameras. */
#include "base/context.h"
#include "io/meshes/gltf.h"

#include <math.h>
#include <string.h>

enum { DEPTH_MAX = 512, INSTANCES_MAX = 1 << 20 };

#define DEGREES_PER_RADIAN 57.295779513082320877
#define NUMBER_MAX 1e30

/* ---- transforms ---- */

ty_affine ty_gltf_compose(const double translation[3], const double quaternion[4], const double scale[3]) {
    const double *q = quaternion, x = q[0], y = q[1], z = q[2], w = q[3];
    const double n = x * x + y * y + z * z + w * w, s = n > 0 ? 2 / n : 0; /* it need not be unit */
    ty_affine out = {{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y), 0, s * (x * y + w * z),
                      1 - s * (x * x + z * z), s * (y * z - w * x), 0, s * (x * z - w * y), s * (y * z + w * x),
                      1 - s * (x * x + y * y), 0}};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) out.m[4 * r + c] *= scale[c];
        out.m[4 * r + 3] = translation[r];
    }
    return out;
}

ty_result ty_gltf_read_transform(const ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                                 ty_affine* out) {
    double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double translation[3] = {0, 0, 0}, quaternion[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    ty_result result = ty_gltf_read_numbers(gltf, json, json_path, "matrix", 16, -NUMBER_MAX, NUMBER_MAX, matrix);
    if (result == TY_OK)
        result = ty_gltf_read_numbers(gltf, json, json_path, "translation", 3, -NUMBER_MAX, NUMBER_MAX, translation);
    if (result == TY_OK) result = ty_gltf_read_numbers(gltf, json, json_path, "rotation", 4, -1e6, 1e6, quaternion);
    if (result == TY_OK)
        result = ty_gltf_read_numbers(gltf, json, json_path, "scale", 3, -NUMBER_MAX, NUMBER_MAX, scale);
    if (result != TY_OK) return result;
    if (json_object_get(json, "matrix") == NULL) {
        *out = ty_gltf_compose(translation, quaternion, scale);
        return TY_OK;
    }
    if (matrix[3] != 0 || matrix[7] != 0 || matrix[11] != 0 || matrix[15] != 1)
        return ty_gltf_fail(gltf, json_path, "the last row of the matrix is not 0, 0, 0, 1");
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) out->m[4 * r + c] = matrix[4 * c + r];
    return TY_OK;
}

/* Unit direction of a node's axis or its opposite. */
static ty_result node_direction(const ty_gltf* gltf, const ty_json_path* json_path, const ty_affine* transform,
                                int axis, double sign, double out[3]) {
    double largest = 0, length = 0;
    for (int r = 0; r < 3; ++r) largest = fmax(largest, fabs(transform->m[4 * r + axis]));
    if (!(largest > 0))
        return ty_gltf_fail(gltf, json_path, "what looks along its %c axis is scaled to 0", "xyz"[axis]);
    for (int r = 0; r < 3; ++r) out[r] = sign * transform->m[4 * r + axis] / largest;
    for (int r = 0; r < 3; ++r) length += out[r] * out[r];
    for (int r = 0; r < 3; ++r) out[r] /= sqrt(length);
    return TY_OK;
}

static void node_position(const ty_affine* transform, double out[3]) {
    for (int r = 0; r < 3; ++r) out[r] = transform->m[4 * r + 3];
}

/* ---- lights ---- */

/* Cone angles from the axis: intensity falls off from inner to outer. */
static ty_result read_cone(const ty_gltf* gltf, const json_t* json, const ty_json_path* json_path, ty_light_def* def) {
    const double right_angle = 90 / DEGREES_PER_RADIAN;
    const json_t* spot = json_object_get(json, "spot");
    const ty_json_path here = ty_json_path_key(json_path, "spot");
    double inner = 0, outer = right_angle / 2;
    ty_result result = ty_gltf_read_number(gltf, spot, &here, "innerConeAngle", 0, right_angle * 1.000001, &inner);
    if (result == TY_OK)
        result = ty_gltf_read_number(gltf, spot, &here, "outerConeAngle", 0, right_angle * 1.000001, &outer);
    if (result != TY_OK) return result;
    if (!(outer > inner)) return ty_gltf_fail(gltf, &here, "the inner cone is not inside the outer one");
    def->cone = fmin(2 * outer * DEGREES_PER_RADIAN, 180);
    def->penumbra = 1 - inner / outer;
    return TY_OK;
}

static ty_result read_light(ty_gltf* gltf, const json_t* node, const ty_json_path* json_path,
                            const ty_affine* transform) {
    const json_t* extension = ty_gltf_extension(node, "KHR_lights_punctual");
    if (extension == NULL) return TY_OK;
    const json_t* lights = json_object_get(ty_gltf_extension(gltf->root, "KHR_lights_punctual"), "lights");
    int64_t index = -1;
    ty_result result = ty_gltf_read_integer(gltf, extension, json_path, "light", 0, INT32_MAX, &index);
    if (result != TY_OK) return result;
    const json_t* json = index < 0 ? NULL : json_array_get(lights, (size_t)index);
    if (!json_is_object(json)) return ty_gltf_fail(gltf, json_path, "there is no light %lld", (long long)index);
    const ty_json_path here = ty_gltf_json_path("lights", (size_t)index);
    const char* type = json_string_value(json_object_get(json, "type"));
    ty_light_def def = ty_default_light_def();
    if (type != NULL && strcmp(type, "point") == 0)
        def.kind = TY_LIGHT_POINT;
    else if (type != NULL && strcmp(type, "spot") == 0)
        def.kind = TY_LIGHT_SPOT;
    else if (type == NULL || strcmp(type, "directional") != 0)
        return ty_gltf_fail(gltf, &here, "the type is not point, spot or directional");
    double color[3] = {1, 1, 1}, intensity = 1;
    result = ty_gltf_read_numbers(gltf, json, &here, "color", 3, 0, NUMBER_MAX, color);
    if (result == TY_OK) result = ty_gltf_read_number(gltf, json, &here, "intensity", 0, NUMBER_MAX, &intensity);
    if (result == TY_OK && def.kind == TY_LIGHT_SPOT) result = read_cone(gltf, json, &here, &def);
    if (result == TY_OK && def.kind != TY_LIGHT_POINT)
        result = node_direction(gltf, json_path, transform, 2, -1, def.direction);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) def.color[c] = (float)fmin(color[c] * intensity, NUMBER_MAX);
    node_position(transform, def.position);
    return ty_model_add_light(gltf->model, &def);
}

/* ---- cameras ---- */

static ty_result read_camera(ty_gltf* gltf, const json_t* node, const ty_json_path* json_path,
                             const ty_affine* transform) {
    int64_t index = -1;
    ty_result result = ty_gltf_read_reference(gltf, node, json_path, "camera", "cameras", &index);
    if (result != TY_OK || index < 0) return result;
    const json_t* json = ty_gltf_item(gltf, "cameras", (size_t)index);
    const ty_json_path here = ty_gltf_json_path("cameras", (size_t)index);
    const json_t* perspective = json_object_get(json, "perspective");
    ty_model_camera camera = {.orthographic = perspective == NULL};
    double yfov = 0;
    result = ty_gltf_read_number(gltf, perspective, &here, "yfov", 1e-6, 3.14159, &yfov);
    if (result == TY_OK && yfov == 0 && perspective != NULL)
        return ty_gltf_fail(gltf, &here, "perspective.yfov is missing");
    if (result == TY_OK) result = node_direction(gltf, json_path, transform, 2, -1, camera.forward);
    if (result == TY_OK) result = node_direction(gltf, json_path, transform, 1, 1, camera.up);
    if (result != TY_OK) return result;
    node_position(transform, camera.position);
    camera.fov_y = yfov * DEGREES_PER_RADIAN;
    const json_t* name = json_object_get(json, "name");
    if (!json_is_string(name)) name = json_object_get(node, "name");
    camera.name = ty_copy_text(gltf->context, json_string_value(name));
    return ty_model_add_camera(gltf->model, &camera);
}

/* ---- nodes ---- */

static bool is_finite(const ty_affine* transform) {
    for (int i = 0; i < 12; ++i)
        if (!(fabs(transform->m[i]) <= NUMBER_MAX)) return false;
    return true;
}

/* Name of a mesh, or else of its node. */
static const char* mesh_name(const ty_gltf* gltf, int64_t mesh, const json_t* node) {
    const char* name = json_string_value(json_object_get(ty_gltf_item(gltf, "meshes", (size_t)mesh), "name"));
    return name != NULL && name[0] != '\0' ? name : json_string_value(json_object_get(node, "name"));
}

static ty_result add_instances(ty_gltf* gltf, int64_t number, const char* name, const ty_json_path* json_path,
                               const ty_gltf_mesh* mesh, const ty_affine* transform) {
    ty_result result = TY_OK;
    for (size_t i = 0; i < mesh->count && result == TY_OK; ++i) {
        gltf->triangles += (int64_t)gltf->model->meshes[mesh->first + i].triangle_count;
        if (gltf->model->instance_count == INSTANCES_MAX || gltf->triangles > INT32_MAX)
            return ty_gltf_fail(gltf, json_path, "more than %d primitives or 2^31 - 1 triangles in all nodes together",
                                (int)INSTANCES_MAX);
        result = ty_model_add_instance(gltf->model, mesh->first + i, transform, (int32_t)number, name);
    }
    return result;
}

/* Vertices of a skinned mesh are in scene space, whatever the transform of its node, so its instances are, too. */
static ty_result add_posed_mesh(ty_gltf* gltf, int64_t number, size_t index, const json_t* node,
                                const ty_json_path* json_path, const ty_affine* transform) {
    ty_gltf_pose pose;
    ty_gltf_mesh mesh = {.count = 0};
    ty_affine* maps = NULL;
    size_t map_count = 0;
    const ty_affine identity = ty_affine_identity();
    const char* name = mesh_name(gltf, (int64_t)index, node);
    ty_result result = ty_gltf_read_pose(gltf, node, json_path, index, transform, &pose);
    const bool posed = pose.weight_count + pose.joint_count > 0;
    const ty_affine* base = pose.joint_count > 0 ? &identity : transform;
    if (result == TY_OK) result = ty_gltf_read_mesh(gltf, index, posed ? &pose : NULL, &mesh);
    if (result == TY_OK) result = ty_gltf_read_instances(gltf, node, &maps, &map_count);
    if (result == TY_OK && map_count == 0) result = add_instances(gltf, number, name, json_path, &mesh, base);
    for (size_t i = 0; i < map_count && result == TY_OK; ++i) {
        const ty_affine map = ty_affine_multiply(base, &maps[i]);
        result = is_finite(&map) ? add_instances(gltf, number, name, json_path, &mesh, &map)
                                 : ty_gltf_fail(gltf, json_path, "instance %zu is too far away", i);
    }
    ty_free_array(gltf->context, maps, map_count, sizeof *maps);
    ty_gltf_free_pose(gltf, &pose);
    return result;
}

static ty_result add_mesh_instance(ty_gltf* gltf, int64_t number, const json_t* node, const ty_json_path* json_path,
                                   const ty_affine* transform) {
    int64_t index = -1;
    const ty_result result = ty_gltf_read_reference(gltf, node, json_path, "mesh", "meshes", &index);
    return result != TY_OK || index < 0 ? result
                                        : add_posed_mesh(gltf, number, (size_t)index, node, json_path, transform);
}

static ty_result read_node(ty_gltf* gltf, int64_t index, const ty_affine* parent, int depth);

static ty_result read_children(ty_gltf* gltf, const json_t* object, const ty_json_path* json_path, const char* key,
                               const ty_affine* transform, int depth) {
    const json_t* children = json_object_get(object, key);
    const ty_json_path here = ty_json_path_key(json_path, key);
    if (children != NULL && !json_is_array(children)) return ty_gltf_fail(gltf, &here, "expected an array");
    ty_result result = TY_OK;
    size_t i;
    json_t* child;
    json_array_foreach(children, i, child) {
        const ty_json_path at = ty_json_path_index(&here, i);
        const int64_t number = ty_gltf_node_number(gltf, child);
        if (number < 0) return ty_gltf_fail(gltf, &at, "it is not the number of a node");
        result = read_node(gltf, number, transform, depth);
        if (result != TY_OK) break;
    }
    return result;
}

static ty_result read_node(ty_gltf* gltf, int64_t index, const ty_affine* parent, int depth) {
    const ty_json_path json_path = ty_gltf_json_path("nodes", (size_t)index);
    const json_t* node = ty_gltf_item(gltf, "nodes", (size_t)index);
    if (gltf->visited[index]) return ty_gltf_fail(gltf, &json_path, "it is the child of two nodes, or of itself");
    if (depth >= DEPTH_MAX) return ty_gltf_fail(gltf, &json_path, "nodes are nested more than %d deep", (int)DEPTH_MAX);
    gltf->visited[index] = true;
    ty_affine local;
    ty_result result = ty_gltf_read_transform(gltf, node, &json_path, &local);
    if (result != TY_OK) return result;
    const ty_affine transform = ty_affine_multiply(parent, &local);
    if (!is_finite(&transform)) return ty_gltf_fail(gltf, &json_path, "its transform leads too far away");
    if ((gltf->want & TY_MODEL_MESHES) != 0) result = add_mesh_instance(gltf, index, node, &json_path, &transform);
    if (result == TY_OK && (gltf->want & TY_MODEL_LIGHTS) != 0) result = read_light(gltf, node, &json_path, &transform);
    if (result == TY_OK && (gltf->want & TY_MODEL_CAMERAS) != 0)
        result = read_camera(gltf, node, &json_path, &transform);
    if (result != TY_OK) return result;
    return read_children(gltf, node, &json_path, "children", &transform, depth + 1);
}

/* Without scenes, the roots are all nodes without a parent. */
static ty_result read_roots(ty_gltf* gltf) {
    const ty_affine identity = ty_affine_identity();
    ty_result result = TY_OK;
    for (size_t i = 0; i < ty_gltf_count(gltf, "nodes") && result == TY_OK; ++i)
        if (gltf->parents[i] < 0) result = read_node(gltf, (int64_t)i, &identity, 0);
    return result;
}

static void find_parents(ty_gltf* gltf) {
    const size_t count = ty_gltf_count(gltf, "nodes");
    for (size_t i = 0; i < count; ++i) gltf->parents[i] = -1;
    for (size_t i = 0; i < count; ++i) {
        size_t k;
        json_t* number;
        json_array_foreach(json_object_get(ty_gltf_item(gltf, "nodes", i), "children"), k, number) {
            const int64_t index = ty_gltf_node_number(gltf, number);
            if (index >= 0) gltf->parents[index] = (int32_t)i;
        }
    }
}

ty_result ty_gltf_read_scene(ty_gltf* gltf) {
    const ty_json_path root = {.depth = 0};
    const ty_affine identity = ty_affine_identity();
    int64_t scene = -1;
    const ty_result result = ty_gltf_read_reference(gltf, gltf->root, &root, "scene", "scenes", &scene);
    if (result != TY_OK) return result;
    find_parents(gltf);
    if (ty_gltf_count(gltf, "scenes") == 0) return read_roots(gltf);
    if (scene < 0) scene = 0;
    const ty_json_path json_path = ty_gltf_json_path("scenes", (size_t)scene);
    return read_children(gltf, ty_gltf_item(gltf, "scenes", (size_t)scene), &json_path, "nodes", &identity, 0);
}
