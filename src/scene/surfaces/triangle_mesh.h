/* Triangle meshes of a scene, in world space, with vertex attributes. */
#ifndef TY_SCENE_SURFACES_TRIANGLE_MESH_H
#define TY_SCENE_SURFACES_TRIANGLE_MESH_H

#include "scene/surfaces/surface.k.h"

#include <tyndall/scene.h>

typedef struct ty_triangle_mesh {
    size_t vertex_count, triangle_count;
    float* positions; /* 3 per vertex, m; one more float after the last, for vector loads */
    float* normals;   /* or NULL */
    float* uv[2];     /* or NULL */
    float* colors;    /* or NULL */
    float* tangents;  /* 4 per vertex, or NULL */
    uint32_t* indices;
    ty_material_def material; /* textures retained */
    ty_mesh_origin origin;    /* strings owned */
    double lower[3], upper[3];
} ty_triangle_mesh;

ty_result ty_triangle_mesh_create(ty_context* context, const ty_mesh_def* def, ty_triangle_mesh** out);
void ty_triangle_mesh_destroy(ty_context* context, ty_triangle_mesh* triangles);
/* Bytes of vertices and texture coordinates; textures are not counted, as meshes may share them. */
size_t ty_triangle_mesh_bytes(const ty_triangle_mesh* triangles);

bool ty_triangle_mesh_emits(const ty_triangle_mesh* triangles);
/* Without gloss, which the commit adds. */
ty_surface ty_triangle_mesh_get_surface(const ty_triangle_mesh* triangles);

/* Bounding box of a triangle, enlarged by more than the rounding of ty_crossing_find. */
void ty_closed_triangle_bounds(const ty_triangle_mesh* triangles, size_t triangle, float low[3], float high[3]);

/* Checks of arrays shared with closed meshes: counts, indices, finite positions. */
ty_result ty_triangle_mesh_check(ty_context* context, const char* what, const float* positions, int64_t vertex_count,
                                 const uint32_t* indices, int64_t triangle_count);

#endif
