/* Surfaces for ray tracing. Only mesh.c sees Embree. */
#ifndef TY_SCENE_MESH_H
#define TY_SCENE_MESH_H

#include "base/vector.k.h"

#include <tyndall/scene.h>

typedef struct ty_mesh ty_mesh;

typedef struct ty_hit {
    float distance;
    ty_vec normal;   /* unit, outwards (front) */
    ty_vec position; /* on the surface to rounding, however long the ray was */
    float margin;    /* off the surface by this much, rounding cannot lead back to it */
    int32_t shape;   /* as added */
    int32_t part;    /* which quad of the shape */
} ty_hit;

/* Shapes must have passed ty_scene_add_shape's checks. *out is NULL when there are no shapes. */
ty_result ty_mesh_create(ty_context* context, const ty_shape_def* shapes, size_t count, ty_mesh** out);
void ty_mesh_destroy(ty_mesh* mesh);
size_t ty_mesh_bytes(const ty_mesh* mesh);

/* Denormals off for the calling thread, as Embree asks, until the returned state is given back. */
unsigned ty_mesh_enter_thread(void);
void ty_mesh_leave_thread(unsigned state);

/* The nearest hit closer than far; direction is unit. mesh is not NULL. */
bool ty_mesh_intersect(const ty_mesh* mesh, ty_vec origin, ty_vec direction, float far, ty_hit* hit);
/* Whether anything is hit closer than far. */
bool ty_mesh_occluded(const ty_mesh* mesh, ty_vec origin, ty_vec direction, float far);

/* Where a ray that leaves a hit towards direction may start without hitting the same surface again. */
TY_FN ty_vec ty_hit_leave(const ty_hit* hit, ty_vec direction) {
    return ty_mad(hit->position, hit->normal, ty_dot(hit->normal, direction) < 0.0f ? -hit->margin : hit->margin);
}

#endif
