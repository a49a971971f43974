/* Meshes as a scene keeps them: in world space, with what their vertices carry. */
#ifndef TY_SCENE_TRIANGLES_H
#define TY_SCENE_TRIANGLES_H

#include "scene/surface.k.h"

#include <tyndall/scene.h>

typedef struct ty_triangles {
    size_t vertex_count, triangle_count;
    float* positions; /* 3 per vertex, m; one more float after the last, for vector loads */
    float* normals;   /* or NULL */
    float* uv[2];     /* or NULL */
    float* colors;    /* or NULL */
    uint32_t* indices;
    ty_material_def material; /* its textures retained */
    ty_mesh_origin origin;    /* its texts owned */
    int32_t* lights;          /* per triangle, once committed; NULL when the mesh does not emit */
    double lower[3], upper[3];
} ty_triangles;

ty_result ty_triangles_create(ty_context* context, const ty_mesh_def* def, ty_triangles** out);
void ty_triangles_destroy(ty_context* context, ty_triangles* triangles);
/* Vertices and texture coordinates; textures are not counted, as meshes may share them. */
size_t ty_triangles_bytes(const ty_triangles* triangles);

bool ty_triangles_emit(const ty_triangles* triangles);
ty_surface ty_triangles_get_surface(const ty_triangles* triangles);

/* Checks of arrays that shells share: counts, indices, finite positions. */
ty_result ty_triangles_check(ty_context* context, const char* what, const float* positions, int64_t vertex_count,
                             const uint32_t* indices, int64_t triangle_count);

#endif
