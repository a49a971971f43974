/* Closed triangle meshes as bounds of media. */
#ifndef TY_SCENE_SURFACES_CLOSED_MESH_H
#define TY_SCENE_SURFACES_CLOSED_MESH_H

#include "scene/surfaces/accel.h"

#include <tyndall/scene.h>

struct ty_closed_mesh {
    ty_context* context;
    _Atomic int32_t owners;
    ty_triangle_mesh* triangles;
    ty_accel* mesh;
};

/* Number of edges that are not traversed once in each direction; SIZE_MAX on allocation failure. Degenerate triangles
 * do not count. */
size_t ty_count_open_edges(ty_context* context, const ty_triangle_mesh* triangles);
size_t ty_closed_mesh_bytes(const ty_closed_mesh* closed);

#endif
