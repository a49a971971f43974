/* glTF meshes: one model mesh for each triangle primitive. */
#include "base/context.h"
#include "io/meshes/gltf.h"

#include <math.h>

enum { MODE_TRIANGLES = 4, MODE_STRIP = 5, MODE_FAN = 6 };

/* ---- attributes ---- */

ty_result ty_gltf_open_attribute(ty_gltf* gltf, ty_gltf_primitive* p, const char* name, size_t low, size_t high,
                                 ty_gltf_accessor* accessor, bool* found) {
    const ty_json_path json_path = ty_json_path_key(&p->json_path, "attributes");
    const ty_json_path here = ty_json_path_key(&json_path, name);
    int64_t index = -1;
    ty_result result =
        ty_gltf_read_reference(gltf, json_object_get(p->json, "attributes"), &json_path, name, "accessors", &index);
    if (result == TY_OK && index >= 0) result = ty_gltf_open_accessor(gltf, (size_t)index, accessor);
    if (result != TY_OK || index < 0) return result;
    if (accessor->components < low || accessor->components > high)
        return ty_gltf_fail(gltf, &here, "an accessor of %zu components, not %zu", accessor->components, low);
    if (accessor != &p->positions && accessor->count != p->positions.count)
        return ty_gltf_fail(gltf, &here, "%zu elements for %zu positions", accessor->count, p->positions.count);
    if (accessor == &p->colors && accessor->type != TY_GLTF_F32 && !accessor->normalized)
        return ty_gltf_fail(gltf, &here, "integers that are not normalized");
    *found = true;
    return ty_gltf_unpack_attribute(gltf, p, name, accessor);
}

static ty_result open_attributes(ty_gltf* gltf, ty_gltf_primitive* p, bool* found) {
    ty_result result = ty_gltf_open_attribute(gltf, p, "POSITION", 3, 3, &p->positions, found);
    if (result != TY_OK || !*found || (gltf->want & TY_MODEL_SHADING) == 0) return result;
    result = ty_gltf_open_attribute(gltf, p, "NORMAL", 3, 3, &p->normals, &p->has_normals);
    if (result == TY_OK) result = ty_gltf_open_attribute(gltf, p, "TEXCOORD_0", 2, 2, &p->uv[0], &p->has_uv[0]);
    if (result == TY_OK) result = ty_gltf_open_attribute(gltf, p, "TEXCOORD_1", 2, 2, &p->uv[1], &p->has_uv[1]);
    if (result == TY_OK) result = ty_gltf_open_attribute(gltf, p, "COLOR_0", 3, 4, &p->colors, &p->has_colors);
    if (result == TY_OK) result = ty_gltf_open_attribute(gltf, p, "TANGENT", 4, 4, &p->tangents, &p->has_tangents);
    return result;
}

/* ---- triangles ---- */

static ty_result read_indices(ty_gltf* gltf, ty_gltf_primitive* p, ty_json_path* json_path) {
    p->corner_count = p->positions.count;
    int64_t index = -1;
    ty_gltf_accessor indices;
    ty_result result = ty_gltf_read_reference(gltf, p->json, &p->json_path, "indices", "accessors", &index);
    if (result == TY_OK && index >= 0) result = ty_gltf_open_accessor(gltf, (size_t)index, &indices);
    if (result != TY_OK || index < 0) return result;
    const bool whole = indices.type == TY_GLTF_U8 || indices.type == TY_GLTF_U16 || indices.type == TY_GLTF_U32;
    if (!whole || indices.components != 1)
        return ty_gltf_fail(gltf, &indices.json_path, "indices must be single unsigned integers");
    p->corners = ty_alloc_array(gltf->context, indices.count, sizeof *p->corners, false);
    if (p->corners == NULL) return TY_ERROR_MEMORY;
    p->corner_count = indices.count;
    ty_gltf_read_indices(&indices, p->corners);
    *json_path = indices.json_path;
    return TY_OK;
}

/* Reads the corner indices and the range of vertices that they use: exporters often share one accessor between many
 * primitives, each of which uses a range. */
static ty_result read_corners(ty_gltf* gltf, ty_gltf_primitive* p) {
    ty_json_path json_path = p->json_path;
    const ty_result result = p->draco == NULL ? read_indices(gltf, p, &json_path) : TY_OK;
    p->last = p->positions.count - 1;
    if (result != TY_OK || p->corners == NULL) return result;
    p->first = p->last = p->corners[0];
    for (size_t i = 0; i < p->corner_count; ++i) {
        if (p->corners[i] >= p->positions.count)
            return ty_gltf_fail(gltf, &json_path, "index %u is past the end of %zu vertices", p->corners[i],
                                p->positions.count);
        if (p->corners[i] < p->first) p->first = p->corners[i];
        if (p->corners[i] > p->last) p->last = p->corners[i];
    }
    return TY_OK;
}

/* Corners of triangle i. In strips every second triangle is flipped, so that all have the same orientation. */
static void triangle_corners(int64_t mode, size_t i, size_t corners[3]) {
    const size_t odd = i % 2;
    corners[0] = mode == MODE_TRIANGLES ? 3 * i : mode == MODE_STRIP ? i : i + 1;
    corners[1] = mode == MODE_TRIANGLES ? 3 * i + 1 : mode == MODE_STRIP ? i + 1 + odd : i + 2;
    corners[2] = mode == MODE_TRIANGLES ? 3 * i + 2 : mode == MODE_STRIP ? i + 2 - odd : 0;
}

static void fill_triangles(const ty_gltf_primitive* p, ty_model_mesh* mesh) {
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        size_t corners[3];
        triangle_corners(p->mode, i, corners);
        for (int k = 0; k < 3; ++k) {
            const size_t vertex = p->corners == NULL ? corners[k] : p->corners[corners[k]];
            mesh->indices[3 * i + (size_t)k] = (uint32_t)(vertex - p->first);
        }
    }
}

static ty_result fill_vertices(ty_gltf* gltf, ty_gltf_primitive* p, const ty_gltf_pose* pose, ty_model_mesh* mesh) {
    const size_t count = mesh->vertex_count;
    ty_gltf_read_floats(&p->positions, p->first, count, 3, mesh->positions);
    if (p->has_normals) ty_gltf_read_floats(&p->normals, p->first, count, 3, mesh->normals);
    if (mesh->tangents != NULL) ty_gltf_read_floats(&p->tangents, p->first, count, 4, mesh->tangents);
    const ty_result result = pose == NULL ? TY_OK : ty_gltf_apply_pose(gltf, p, pose, mesh);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < 3 * count; ++i)
        if (!isfinite(mesh->positions[i]))
            return ty_gltf_fail(gltf, &p->positions.json_path, "element %zu is not finite", p->first + i / 3);
    for (int set = 0; set < 2; ++set)
        if (p->has_uv[set]) ty_gltf_read_floats(&p->uv[set], p->first, count, 2, mesh->uv[set]);
    for (size_t i = 0; p->has_colors && i < count; ++i) mesh->colors[4 * i + 3] = 1;
    if (p->has_colors) ty_gltf_read_floats(&p->colors, p->first, count, 4, mesh->colors);
    ty_model_tidy_shading(mesh);
    return TY_OK;
}

/* ---- primitives ---- */

/* Number of triangles of the primitive's corners; 0 if there are too few. */
static ty_result count_triangles(const ty_gltf* gltf, const ty_gltf_primitive* p, size_t* count) {
    if (p->mode == MODE_TRIANGLES && p->corner_count % 3 != 0)
        return ty_gltf_fail(gltf, &p->json_path, "%zu corners do not make whole triangles", p->corner_count);
    *count = p->mode == MODE_TRIANGLES ? p->corner_count / 3 : p->corner_count < 3 ? 0 : p->corner_count - 2;
    return TY_OK;
}

static ty_result build_mesh(ty_gltf* gltf, ty_gltf_primitive* p, const ty_gltf_pose* pose) {
    int64_t material = -1;
    ty_model_mesh mesh = {.vertex_count = p->last - p->first + 1,
                          .primitive = (int32_t)p->number,
                          .first_vertex = p->first,
                          .vertex_total = p->positions.count};
    ty_result result = count_triangles(gltf, p, &mesh.triangle_count);
    if (result == TY_OK)
        result = ty_gltf_read_reference(gltf, p->json, &p->json_path, "material", "materials", &material);
    if (result != TY_OK || mesh.triangle_count == 0) return result;
    const bool materials = (gltf->want & TY_MODEL_MATERIALS) != 0;
    mesh.material = !materials ? -1 : (int32_t)(material >= 0 ? material : (int64_t)ty_gltf_count(gltf, "materials"));
    result = ty_model_alloc_mesh(gltf->context, &mesh, p->has_normals, p->has_uv[0], p->has_uv[1], p->has_colors);
    if (result != TY_OK) return result;
    fill_triangles(p, &mesh);
    if (p->has_tangents) {
        mesh.tangents = ty_alloc_array(gltf->context, mesh.vertex_count, 4 * sizeof(float), true);
        if (mesh.tangents == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK) result = fill_vertices(gltf, p, pose, &mesh);
    if (result == TY_OK) return ty_model_add_mesh(gltf->model, &mesh);
    ty_model_free_mesh(gltf->context, &mesh);
    return result;
}

static ty_result read_content(ty_gltf* gltf, ty_gltf_primitive* p, const ty_gltf_pose* pose) {
    bool found = false;
    ty_result result = ty_gltf_read_integer(gltf, p->json, &p->json_path, "mode", 0, 6, &p->mode);
    if (result == TY_OK && p->mode >= MODE_TRIANGLES) result = ty_gltf_open_draco(gltf, p);
    if (p->draco != NULL) p->mode = MODE_TRIANGLES;
    if (result == TY_OK && p->mode >= MODE_TRIANGLES) result = open_attributes(gltf, p, &found);
    if (result == TY_OK && !found) ++gltf->skipped;
    if (result != TY_OK || !found) return result;
    result = read_corners(gltf, p);
    return result == TY_OK ? build_mesh(gltf, p, pose) : result;
}

static ty_result read_primitive(ty_gltf* gltf, const json_t* json, size_t number, const ty_json_path* json_path,
                                const ty_gltf_pose* pose) {
    ty_gltf_primitive p = {.json = json, .json_path = *json_path, .mode = MODE_TRIANGLES, .number = number};
    const ty_result result = read_content(gltf, &p, pose);
    if (p.corners != NULL) ty_free_array(gltf->context, p.corners, p.corner_count, sizeof *p.corners);
    ty_gltf_close_draco(gltf, &p);
    return result;
}

static ty_result read_primitives(ty_gltf* gltf, size_t index, const ty_gltf_pose* pose, ty_gltf_mesh* mesh) {
    const ty_json_path json_path = ty_gltf_json_path("meshes", index);
    const ty_json_path primitives = ty_json_path_key(&json_path, "primitives");
    ty_result result = TY_OK;
    size_t i;
    json_t* json;
    *mesh = (ty_gltf_mesh){.read = true, .first = gltf->model->mesh_count};
    json_array_foreach(json_object_get(ty_gltf_item(gltf, "meshes", index), "primitives"), i, json) {
        const ty_json_path here = ty_json_path_index(&primitives, i);
        result = read_primitive(gltf, json, i, &here, pose);
        if (result != TY_OK) break;
    }
    mesh->count = gltf->model->mesh_count - mesh->first;
    return result;
}

ty_result ty_gltf_read_mesh(ty_gltf* gltf, size_t index, const ty_gltf_pose* pose, ty_gltf_mesh* out) {
    if (pose != NULL) return read_primitives(gltf, index, pose, out);
    ty_gltf_mesh* mesh = &gltf->meshes[index];
    const ty_result result = mesh->read ? TY_OK : read_primitives(gltf, index, NULL, mesh);
    *out = *mesh;
    return result;
}
