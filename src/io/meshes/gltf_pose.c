/* Rest pose of glTF meshes: morph targets with the weights of the node or the mesh, and skins. */
#include "base/context.h"
#include "io/meshes/gltf.h"

#include <math.h>
#include <stdio.h>

enum { JOINT_SETS_MAX = 8, DEPTH_MAX = 512 };

#define WEIGHT_MAX 1e6

/* ---- reading ---- */

/* Morph weights of a node, or else of its mesh; none if all are 0. */
static ty_result read_weights(ty_gltf* gltf, const json_t* node, const ty_json_path* json_path, size_t mesh,
                              ty_gltf_pose* pose) {
    const ty_json_path mesh_path = ty_gltf_json_path("meshes", mesh);
    const bool own = json_object_get(node, "weights") != NULL;
    const json_t* object = own ? node : ty_gltf_item(gltf, "meshes", mesh);
    const size_t count = json_array_size(json_object_get(object, "weights"));
    if (count == 0) return TY_OK;
    pose->weights = ty_alloc_array(gltf->context, count, sizeof *pose->weights, true);
    if (pose->weights == NULL) return TY_ERROR_MEMORY;
    pose->weight_count = count;
    const ty_result result = ty_gltf_read_numbers(gltf, object, own ? json_path : &mesh_path, "weights", count,
                                                  -WEIGHT_MAX, WEIGHT_MAX, pose->weights);
    bool any = false;
    for (size_t i = 0; i < count; ++i) any = any || pose->weights[i] != 0;
    if (any || result != TY_OK) return result;
    ty_gltf_free_pose(gltf, pose);
    return TY_OK;
}

/* Transform of a node from its own space to that of the scene. */
static ty_result find_world_transform(ty_gltf* gltf, size_t node, ty_affine* out) {
    *out = ty_affine_identity();
    for (int depth = 0; depth < DEPTH_MAX; ++depth) {
        const ty_json_path json_path = ty_gltf_json_path("nodes", node);
        ty_affine local;
        const ty_result result = ty_gltf_read_transform(gltf, ty_gltf_item(gltf, "nodes", node), &json_path, &local);
        if (result != TY_OK) return result;
        *out = ty_affine_multiply(&local, out);
        if (gltf->parents[node] < 0) return TY_OK;
        node = (size_t)gltf->parents[node];
    }
    const ty_json_path json_path = ty_gltf_json_path("nodes", node);
    return ty_gltf_fail(gltf, &json_path, "nodes are nested more than %d deep", (int)DEPTH_MAX);
}

/* Multiplies the joints' matrices by the inverse bind matrices. */
static ty_result bind_joints(ty_gltf* gltf, const json_t* binding, const ty_json_path* json_path, ty_gltf_pose* pose) {
    int64_t index = -1;
    ty_result result = ty_gltf_read_reference(gltf, binding, json_path, "inverseBindMatrices", "accessors", &index);
    if (result != TY_OK || index < 0) return result;
    ty_gltf_accessor accessor;
    result = ty_gltf_open_accessor(gltf, (size_t)index, &accessor);
    if (result != TY_OK) return result;
    if (accessor.components != 16 || accessor.count < pose->joint_count)
        return ty_gltf_fail(gltf, &accessor.json_path, "not one 4 x 4 matrix for each of %zu joints",
                            pose->joint_count);
    for (size_t i = 0; i < pose->joint_count; ++i) {
        float columns[16];
        ty_affine inverse;
        ty_gltf_read_floats(&accessor, i, 1, 16, columns);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 4; ++c) inverse.m[4 * r + c] = (double)columns[4 * c + r];
        pose->joints[i] = ty_affine_multiply(&pose->joints[i], &inverse);
    }
    return TY_OK;
}

static ty_result read_skin(ty_gltf* gltf, const json_t* node, const ty_json_path* json_path, ty_gltf_pose* pose) {
    int64_t index = -1;
    ty_result result = ty_gltf_read_reference(gltf, node, json_path, "skin", "skins", &index);
    if (result != TY_OK || index < 0) return result;
    const ty_json_path binding_path = ty_gltf_json_path("skins", (size_t)index);
    const ty_json_path here = ty_json_path_key(&binding_path, "joints");
    const json_t* binding = ty_gltf_item(gltf, "skins", (size_t)index);
    const json_t* joints = json_object_get(binding, "joints");
    const size_t count = json_array_size(joints);
    if (count == 0) return ty_gltf_fail(gltf, &here, "there are no joints");
    pose->joints = ty_alloc_array(gltf->context, count, sizeof *pose->joints, true);
    if (pose->joints == NULL) return TY_ERROR_MEMORY;
    pose->joint_count = count;
    for (size_t i = 0; i < count && result == TY_OK; ++i) {
        const int64_t number = ty_gltf_node_number(gltf, json_array_get(joints, i));
        const ty_json_path at = ty_json_path_index(&here, i);
        if (number < 0) return ty_gltf_fail(gltf, &at, "it is not the number of a node");
        result = find_world_transform(gltf, (size_t)number, &pose->joints[i]);
    }
    return result == TY_OK ? bind_joints(gltf, binding, &binding_path, pose) : result;
}

ty_result ty_gltf_read_pose(ty_gltf* gltf, const json_t* node, const ty_json_path* json_path, size_t mesh,
                            const ty_affine* transform, ty_gltf_pose* pose) {
    *pose = (ty_gltf_pose){.transform = *transform};
    const ty_result result = read_weights(gltf, node, json_path, mesh, pose);
    return result == TY_OK ? read_skin(gltf, node, json_path, pose) : result;
}

void ty_gltf_free_pose(ty_gltf* gltf, ty_gltf_pose* pose) {
    ty_free_array(gltf->context, pose->weights, pose->weight_count, sizeof *pose->weights);
    ty_free_array(gltf->context, pose->joints, pose->joint_count, sizeof *pose->joints);
    *pose = (ty_gltf_pose){.transform = pose->transform};
}

/* ---- morph targets ---- */

/* Adds `weight` times an attribute of a morph target to the first three of `width` values per vertex of the primitive's
 * range; values: NULL if the mesh lacks the attribute. */
static ty_result add_target(ty_gltf* gltf, const ty_gltf_primitive* p, const json_t* target,
                            const ty_json_path* json_path, const char* name, double weight, size_t width,
                            float* values) {
    if (values == NULL) return TY_OK;
    int64_t index = -1;
    ty_gltf_accessor accessor;
    ty_result result = ty_gltf_read_reference(gltf, target, json_path, name, "accessors", &index);
    if (result == TY_OK && index >= 0) result = ty_gltf_open_accessor(gltf, (size_t)index, &accessor);
    if (result != TY_OK || index < 0) return result;
    if (accessor.components != 3 || accessor.count != p->positions.count)
        return ty_gltf_fail(gltf, &accessor.json_path, "not three components for each of %zu vertices",
                            p->positions.count);
    const size_t count = p->last - p->first + 1;
    for (size_t i = 0; i < count; ++i) {
        float displacement[3] = {0, 0, 0};
        ty_gltf_read_floats(&accessor, p->first + i, 1, 3, displacement);
        for (size_t a = 0; a < 3; ++a)
            values[width * i + a] = (float)((double)values[width * i + a] + weight * (double)displacement[a]);
    }
    return TY_OK;
}

static ty_result morph(ty_gltf* gltf, const ty_gltf_primitive* p, const ty_gltf_pose* pose, ty_model_mesh* mesh) {
    const ty_json_path targets_path = ty_json_path_key(&p->json_path, "targets");
    const json_t* targets = json_object_get(p->json, "targets");
    ty_result result = TY_OK;
    for (size_t i = 0; i < pose->weight_count && i < json_array_size(targets) && result == TY_OK; ++i) {
        if (pose->weights[i] == 0) continue;
        const ty_json_path here = ty_json_path_index(&targets_path, i);
        const json_t* target = json_array_get(targets, i);
        result = add_target(gltf, p, target, &here, "POSITION", pose->weights[i], 3, mesh->positions);
        if (result == TY_OK) result = add_target(gltf, p, target, &here, "NORMAL", pose->weights[i], 3, mesh->normals);
        if (result == TY_OK)
            result = add_target(gltf, p, target, &here, "TANGENT", pose->weights[i], 4, mesh->tangents);
    }
    return result;
}

/* ---- skins ---- */

/* Weighted sum of a vertex's joint matrices. */
typedef struct blend {
    ty_affine matrix;
    double weight;
    size_t joint; /* the first one, which a vertex without weights follows */
} blend;

static ty_result add_joints(ty_gltf* gltf, const ty_gltf_primitive* p, const ty_gltf_pose* pose, int set,
                            const ty_gltf_accessor* joints, const ty_gltf_accessor* weights, blend* blends) {
    for (size_t i = 0; i < p->last - p->first + 1; ++i) {
        float numbers[4], fractions[4];
        ty_gltf_read_floats(joints, p->first + i, 1, 4, numbers);
        ty_gltf_read_floats(weights, p->first + i, 1, 4, fractions);
        for (int k = 0; k < 4; ++k) {
            if (fractions[k] == 0 && (k > 0 || set > 0)) continue;
            if (!(numbers[k] >= 0 && numbers[k] < (float)pose->joint_count) || !isfinite(fractions[k]))
                return ty_gltf_fail(gltf, &joints->json_path, "element %zu names joint %g of %zu with weight %g",
                                    p->first + i, (double)numbers[k], pose->joint_count, (double)fractions[k]);
            const size_t joint = (size_t)numbers[k];
            if (k == 0 && set == 0) blends[i].joint = joint;
            for (int e = 0; e < 12; ++e) blends[i].matrix.m[e] += (double)fractions[k] * pose->joints[joint].m[e];
            blends[i].weight += (double)fractions[k];
        }
    }
    return TY_OK;
}

static ty_result read_blends(ty_gltf* gltf, ty_gltf_primitive* p, const ty_gltf_pose* pose, blend* blends,
                             bool* has_joints) {
    for (int set = 0; set < JOINT_SETS_MAX; ++set) {
        ty_gltf_accessor joints, weights;
        char names[2][24];
        bool joints_found = false, weights_found = false;
        snprintf(names[0], sizeof names[0], "JOINTS_%d", set);
        snprintf(names[1], sizeof names[1], "WEIGHTS_%d", set);
        ty_result result = ty_gltf_open_attribute(gltf, p, names[0], 4, 4, &joints, &joints_found);
        if (result == TY_OK) result = ty_gltf_open_attribute(gltf, p, names[1], 4, 4, &weights, &weights_found);
        if (result != TY_OK || !joints_found || !weights_found) return result;
        result = add_joints(gltf, p, pose, set, &joints, &weights, blends);
        if (result != TY_OK) return result;
        *has_joints = true;
    }
    return TY_OK;
}

static void transform_point(const ty_affine* map, float point[3]) {
    double p[3] = {(double)point[0], (double)point[1], (double)point[2]};
    ty_affine_point(map, p, p);
    for (int a = 0; a < 3; ++a) point[a] = (float)p[a];
}

/* Cofactors of the linear part, which transform normals up to a positive factor times the sign of the determinant. */
static void find_cofactors(const double* m, double out[9]) {
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[3 * r + c] = m[4 * r1 + c1] * m[4 * r2 + c2] - m[4 * r1 + c2] * m[4 * r2 + c1];
        }
}

/* Multiplies a vector by sign times a matrix with rows of `stride` numbers, to a largest component of 1; a vector that
 * becomes zero stays as it is. */
static void rotate(const double* matrix, int stride, double sign, float vector[3]) {
    double rotated[3], largest = 0;
    for (int r = 0; r < 3; ++r) {
        const double* row = matrix + stride * r;
        rotated[r] = row[0] * (double)vector[0] + row[1] * (double)vector[1] + row[2] * (double)vector[2];
        largest = fmax(largest, fabs(rotated[r]));
    }
    for (int r = 0; r < 3; ++r) vector[r] = largest > 0 ? (float)(sign * rotated[r] / largest) : vector[r];
}

/* Moves vertex i; returns true if the map mirrors it. Tangents transform as differences of positions, and a mirrored
 * one has its bitangent on the other side. */
static bool move_vertex(const ty_affine* map, ty_model_mesh* mesh, size_t i) {
    double cofactors[9];
    find_cofactors(map->m, cofactors);
    const bool mirrored = map->m[0] * cofactors[0] + map->m[1] * cofactors[1] + map->m[2] * cofactors[2] < 0;
    transform_point(map, mesh->positions + 3 * i);
    if (mesh->normals != NULL) rotate(cofactors, 3, mirrored ? -1 : 1, mesh->normals + 3 * i);
    if (mesh->tangents == NULL) return mirrored;
    rotate(map->m, 4, 1, mesh->tangents + 4 * i);
    if (mirrored) mesh->tangents[4 * i + 3] = -mesh->tangents[4 * i + 3];
    return mirrored;
}

/* Places vertices by their blended joints, or by the node if the primitive has no joints. */
static void place_vertices(const ty_gltf_pose* pose, const blend* blends, bool has_joints, ty_model_mesh* mesh,
                           bool* mirrored) {
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        ty_affine map = pose->transform;
        if (has_joints && blends[i].weight != 0)
            for (int e = 0; e < 12; ++e) map.m[e] = blends[i].matrix.m[e] / blends[i].weight;
        else if (has_joints)
            map = pose->joints[blends[i].joint];
        mirrored[i] = move_vertex(&map, mesh, i);
    }
}

/* Reverses triangles that the skin has mirrored. */
static void restore_winding(ty_model_mesh* mesh, const bool* mirrored) {
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        uint32_t* corners = mesh->indices + 3 * i;
        if (!mirrored[corners[0]] || !mirrored[corners[1]] || !mirrored[corners[2]]) continue;
        const uint32_t second = corners[1];
        corners[1] = corners[2];
        corners[2] = second;
    }
}

static ty_result apply_skin(ty_gltf* gltf, ty_gltf_primitive* p, const ty_gltf_pose* pose, ty_model_mesh* mesh) {
    const size_t count = mesh->vertex_count;
    blend* blends = ty_alloc_array(gltf->context, count, sizeof *blends, true);
    bool* mirrored = ty_alloc_array(gltf->context, count, sizeof *mirrored, true);
    bool has_joints = false;
    ty_result result =
        blends == NULL || mirrored == NULL ? TY_ERROR_MEMORY : read_blends(gltf, p, pose, blends, &has_joints);
    if (result == TY_OK) {
        place_vertices(pose, blends, has_joints, mesh, mirrored);
        restore_winding(mesh, mirrored);
    }
    ty_free_array(gltf->context, blends, count, sizeof *blends);
    ty_free_array(gltf->context, mirrored, count, sizeof *mirrored);
    return result;
}

ty_result ty_gltf_apply_pose(ty_gltf* gltf, ty_gltf_primitive* p, const ty_gltf_pose* pose, ty_model_mesh* mesh) {
    const ty_result result = morph(gltf, p, pose, mesh);
    return result == TY_OK && pose->joint_count > 0 ? apply_skin(gltf, p, pose, mesh) : result;
}
