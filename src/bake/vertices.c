/* Receivers at the vertices of a mesh. */
#include "base/context.h"
#include "base/vector.k.h"
#include "scene/surfaces/accel.h"
#include "scene/surfaces/surface.k.h"

#include <tyndall/bake.h>

/* Fraction of the distance from a vertex to the center of its triangle by which its receiver is inset. */
static const float inset = 0.01f;

/* The largest triangle around a vertex. */
typedef struct largest_triangle {
    float area;      /* twice the area; 0: none */
    uint32_t corner; /* index among all corners of the mesh */
} largest_triangle;

static ty_vec load(const float* values, size_t index) {
    return ty_vec_load(values + 3 * index);
}

static void store(ty_vec v, float out[3]) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static ty_vec triangle_edges(const ty_mesh_def* mesh, size_t triangle, ty_vec corners[3]) {
    for (size_t k = 0; k < 3; ++k) corners[k] = load(mesh->positions, mesh->indices[3 * triangle + k]);
    return ty_cross(ty_sub(corners[1], corners[0]), ty_sub(corners[2], corners[0]));
}

/* Finds the largest triangle of every vertex, and sums area-weighted normals. */
static void visit_triangles(const ty_mesh_def* mesh, largest_triangle* largest, ty_bake_receiver* receivers) {
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i) {
        ty_vec corners[3];
        const size_t vertex = mesh->indices[i];
        const ty_vec cross = triangle_edges(mesh, i / 3, corners);
        const float area = sqrtf(ty_dot(cross, cross));
        if (!(area > 0) || !isfinite(area)) continue;
        store(ty_add(ty_vec_load(receivers[vertex].normal), cross), receivers[vertex].normal);
        if (area > largest[vertex].area) largest[vertex] = (largest_triangle){area, (uint32_t)i};
    }
}

/* The mesh's own normal, the mean normal of its triangles, or the face normal: the first that exists and lies on the
 * front side. */
static ty_vec choose_normal(const ty_mesh_def* mesh, size_t vertex, ty_vec mean, ty_vec face) {
    const ty_vec given = mesh->normals == NULL ? mean : load(mesh->normals, vertex);
    const float length = sqrtf(ty_dot(given, given));
    if (!(length > 0) || !isfinite(length) || !(ty_dot(given, face) > 0)) return face;
    return ty_scale(given, 1 / length);
}

static void make_receiver(const ty_mesh_def* mesh, size_t vertex, const largest_triangle* at,
                          ty_bake_receiver* receiver) {
    const ty_vec mean = ty_vec_load(receiver->normal);
    *receiver = (ty_bake_receiver){.position = {0}};
    store(load(mesh->positions, vertex), receiver->position);
    if (!(at->area > 0)) {
        receiver->normal[1] = receiver->face[1] = 1;
        return;
    }
    ty_vec corners[3];
    const ty_vec cross = triangle_edges(mesh, at->corner / 3, corners), corner = corners[at->corner % 3];
    const ty_vec center = ty_scale(ty_add(corners[0], ty_add(corners[1], corners[2])), 1.0f / 3);
    const ty_vec face = ty_scale(cross, 1 / at->area);
    store(ty_mad(corner, ty_sub(center, corner), inset), receiver->position);
    store(choose_normal(mesh, vertex, mean, face), receiver->normal);
    store(face, receiver->face);
    receiver->margin = ty_accel_ray_epsilon(face, corners[0], corners[1], corners[2]);
}

ty_result ty_bake_vertices(const ty_scene* scene, int32_t mesh, ty_bake_receiver* receivers) {
    if (scene == NULL) return TY_ERROR_ARGUMENT;
    ty_context* context = ty_scene_context(scene);
    ty_mesh_def def;
    ty_result result = ty_scene_get_mesh(scene, mesh, &def);
    if (result == TY_OK && receivers == NULL)
        result = ty_fail(context, TY_ERROR_ARGUMENT, "ty_bake_vertices: receivers is NULL");
    if (result != TY_OK) return result;
    const size_t count = (size_t)def.vertex_count;
    largest_triangle* largest = ty_alloc_array(context, count, sizeof *largest, true);
    if (largest == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) receivers[i] = (ty_bake_receiver){.margin = 0};
    visit_triangles(&def, largest, receivers);
    for (size_t i = 0; i < count; ++i) make_receiver(&def, i, &largest[i], &receivers[i]);
    ty_free_array(context, largest, count, sizeof *largest);
    return TY_OK;
}
