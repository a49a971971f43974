/* Bounding volume hierarchies of a scene's surfaces and of closed meshes, for devices. */
#ifndef TY_SCENE_SURFACES_BVH_H
#define TY_SCENE_SURFACES_BVH_H

#include "scene/surfaces/accel.h"
#include "scene/surfaces/bvh.k.h"

/* A hierarchy with its arrays; bvh.surfaces is that of the input. */
typedef struct ty_bvh_data {
    ty_context* context;
    ty_bvh bvh;
    size_t node_count, node_capacity, primitive_count, quad_count, sphere_count;
    ty_bvh_node* nodes;
    ty_bvh_primitive* primitives;
    ty_quad_face* quads;
    ty_sphere_face* spheres;
} ty_bvh_data;

/* Of what ty_accel_create takes, which must outlive it; *out is NULL for an empty scene. Errors: TY_ERROR_MEMORY,
 * TY_ERROR_UNSUPPORTED. */
ty_result ty_bvh_create(ty_context* context, const ty_accel_input* input, ty_bvh_data** out);
/* Of a closed mesh, for ty_bvh_crossings alone. */
ty_result ty_bvh_create_closed(ty_context* context, const ty_triangle_mesh* triangles, ty_bvh_data** out);
void ty_bvh_destroy(ty_bvh_data* data);

#endif
