/* OBJ: triangles grouped by material, their corners merged into vertices. */
#include "base/context.h"
#include "io/meshes/obj.h"

#include <string.h>

/* Triangles of one material, with normals at all corners or at none. */
typedef struct group {
    int32_t material;
    bool normals;
    const uint32_t* order; /* indices of the triangles */
    size_t count;
    size_t* corners; /* per vertex: 3 * triangle + k of one corner that has it */
    uint32_t* table; /* open-addressing hash table: vertex index plus one, 0: empty */
    size_t table_size, vertex_count;
} group;

static const ty_obj_corner* corner_at(const ty_obj* obj, size_t corner) {
    return &obj->triangles[corner / 3].corners[corner % 3];
}

static size_t hash_corner(const ty_obj_corner* corner) {
    uint64_t hash = (uint64_t)(uint32_t)corner->position * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (uint32_t)corner->uv) * 0xff51afd7ed558ccdu;
    hash = (hash ^ (uint32_t)corner->normal) * 0xc4ceb9fe1a85ec53u;
    return (size_t)(hash ^ hash >> 32);
}

/* Vertex index of a corner. */
static uint32_t join_corner(const ty_obj* obj, group* g, size_t corner) {
    const ty_obj_corner* sought = corner_at(obj, corner);
    size_t slot = hash_corner(sought) & (g->table_size - 1);
    for (; g->table[slot] != 0; slot = (slot + 1) & (g->table_size - 1))
        if (memcmp(corner_at(obj, g->corners[g->table[slot] - 1]), sought, sizeof *sought) == 0)
            return g->table[slot] - 1;
    g->corners[g->vertex_count++] = corner;
    g->table[slot] = (uint32_t)g->vertex_count;
    return g->table[slot] - 1;
}

static void fill_vertex(const ty_obj* obj, const ty_obj_corner* corner, ty_model_mesh* mesh, size_t i) {
    memcpy(mesh->positions + 3 * i, obj->positions[corner->position], 3 * sizeof(float));
    if (mesh->normals != NULL) memcpy(mesh->normals + 3 * i, obj->normals[corner->normal], 3 * sizeof(float));
    if (mesh->uv[0] != NULL && corner->uv >= 0) memcpy(mesh->uv[0] + 2 * i, obj->uv[corner->uv], 2 * sizeof(float));
    if (mesh->colors == NULL) return;
    memcpy(mesh->colors + 4 * i, obj->colors[corner->position], 3 * sizeof(float));
    mesh->colors[4 * i + 3] = 1;
}

static ty_result fill_group(ty_obj* obj, group* g, uint32_t* indices) {
    bool uv = false;
    const bool shading = (obj->want & TY_MODEL_SHADING) != 0;
    for (size_t i = 0; i < g->count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            const size_t corner = 3 * (size_t)g->order[i] + k;
            uv = uv || corner_at(obj, corner)->uv >= 0;
            indices[3 * i + k] = join_corner(obj, g, corner);
        }
    ty_model_mesh mesh = {.vertex_count = g->vertex_count, .triangle_count = g->count, .material = g->material};
    const ty_result result =
        ty_model_alloc_mesh(obj->context, &mesh, shading && g->normals, shading && uv, false, shading && obj->colored);
    if (result != TY_OK) return result;
    memcpy(mesh.indices, indices, g->count * 3 * sizeof *indices);
    for (size_t i = 0; i < g->vertex_count; ++i) fill_vertex(obj, corner_at(obj, g->corners[i]), &mesh, i);
    ty_model_tidy_shading(&mesh);
    return ty_model_add_mesh(obj->model, &mesh);
}

static ty_result build_group(ty_obj* obj, group* g) {
    const size_t corners = 3 * g->count;
    g->table_size = 4;
    while (g->table_size < 2 * corners) g->table_size *= 2;
    g->corners = ty_alloc_array(obj->context, corners, sizeof *g->corners, false);
    g->table = ty_alloc_array(obj->context, g->table_size, sizeof *g->table, true);
    uint32_t* indices = ty_alloc_array(obj->context, corners, sizeof *indices, false);
    ty_result result = TY_ERROR_MEMORY;
    if (g->corners != NULL && g->table != NULL && indices != NULL) result = fill_group(obj, g, indices);
    ty_free_array(obj->context, g->corners, corners, sizeof *g->corners);
    ty_free_array(obj->context, g->table, g->table_size, sizeof *g->table);
    ty_free_array(obj->context, indices, corners, sizeof *indices);
    if (result != TY_OK) return result;
    const ty_affine identity = ty_affine_identity();
    return ty_model_add_instance(obj->model, obj->model->mesh_count - 1, &identity, -1, NULL);
}

static bool has_normals(const ty_obj_triangle* triangle) {
    for (int k = 0; k < 3; ++k)
        if (triangle->corners[k].normal < 0) return false;
    return true;
}

/* Group of a triangle: two per material, and two without. */
static size_t group_of(const ty_obj_triangle* triangle) {
    return 2 * (size_t)(triangle->material + 1) + has_normals(triangle);
}

/* order[starts[i]] .. order[starts[i + 1] - 1] are the triangles of group i. */
static void sort_triangles(const ty_obj* obj, size_t* starts, size_t groups, uint32_t* order) {
    for (size_t i = 0; i < obj->triangle_count; ++i) ++starts[group_of(&obj->triangles[i])];
    size_t sum = 0;
    for (size_t i = 0; i <= groups; ++i) {
        const size_t count = starts[i];
        starts[i] = sum;
        sum += count;
    }
    for (size_t i = 0; i < obj->triangle_count; ++i) order[starts[group_of(&obj->triangles[i])]++] = (uint32_t)i;
    for (size_t i = groups; i > 0; --i) starts[i] = starts[i - 1];
    starts[0] = 0;
}

ty_result ty_obj_build_meshes(ty_obj* obj) {
    const size_t groups = 2 * (obj->model->material_count + 1);
    size_t* starts = ty_alloc_array(obj->context, groups + 1, sizeof *starts, true);
    uint32_t* order = ty_alloc_array(obj->context, obj->triangle_count, sizeof *order, false);
    ty_result result = starts != NULL && order != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) sort_triangles(obj, starts, groups, order);
    for (size_t i = 0; i < groups && result == TY_OK; ++i) {
        group g = {.material = (int32_t)(i / 2) - 1,
                   .normals = i % 2 != 0,
                   .order = order + starts[i],
                   .count = starts[i + 1] - starts[i]};
        if (g.count > 0) result = build_group(obj, &g);
    }
    ty_free_array(obj->context, starts, groups + 1, sizeof *starts);
    ty_free_array(obj->context, order, obj->triangle_count, sizeof *order);
    return result;
}
