/* Ray tracing acceleration structures. Only accel.c includes Embree. */
#ifndef TY_SCENE_SURFACES_ACCEL_H
#define TY_SCENE_SURFACES_ACCEL_H

#include "scene/surfaces/crossing.k.h"
#include "scene/surfaces/hit.k.h"
#include "scene/surfaces/triangle_mesh.h"

#include <tyndall/scene.h>

typedef struct ty_accel ty_accel;

/* Geometry of a scene. Surfaces are numbered shapes first, then meshes. All input must have passed the checks of
 * ty_scene_add_shape and ty_scene_add_mesh, and must outlive the structure. */
typedef struct ty_accel_input {
    const ty_shape_def* shapes;
    size_t shape_count;
    ty_triangle_mesh* const* meshes;
    size_t mesh_count;
    const ty_surface* surfaces; /* shape_count + mesh_count */
} ty_accel_input;

/* *out is NULL for an empty scene. */
ty_result ty_accel_create(ty_context* context, const ty_accel_input* input, ty_accel** out);
void ty_accel_destroy(ty_accel* mesh);
size_t ty_accel_bytes(const ty_accel* mesh);

/* Closest hit nearer than far; direction is unit, mesh is not NULL. Alpha tests are a function of the ray: equal rays
 * hit equal surfaces. */
TY_FN_APART bool ty_accel_intersect(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far, ty_hit* hit);
/* True if anything is hit nearer than far. */
TY_FN_APART bool ty_accel_occluded(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far);

/* Packets of sixteen rays; fastest for coherent neighbours. */
enum { TY_PACKET = 16 };

/* hits[i].surface is -1 where ray i misses. count: 1..TY_PACKET. */
void ty_accel_intersect_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, ty_hit* hits);
/* Distance to the closest hits, m; INFINITY: miss. count: 1..TY_PACKET. */
void ty_accel_distance_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, float* distances);
/* occluded[i]: ray i hits anything. count: 1..TY_PACKET. */
void ty_accel_occluded_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, bool* occluded);

/* All intersections along a ray, not only the closest. */
enum { TY_ALL_HITS_MAX = 256 };

/* Intersection of a ray with a surface; ty_accel_complete_hit computes the full hit. */
typedef struct ty_hit_record {
    float distance, b1, b2;
    uint32_t geometry, primitive;
} ty_hit_record;

/* Intersections of each ray, nearest first; beyond TY_ALL_HITS_MAX the farthest are dropped. Coincident surfaces, and
 * triangles sharing the edge that a ray hits, are all listed. */
typedef struct ty_all_hits {
    ty_hit_record layer[TY_PACKET][TY_ALL_HITS_MAX];
    int32_t count[TY_PACKET];
} ty_all_hits;

/* count: 1..TY_PACKET. */
void ty_accel_all_hits_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, ty_all_hits* out);
void ty_accel_complete_hit(const ty_accel* mesh, const ty_ray* ray, const ty_hit_record* layer, ty_hit* hit);

/* ---- closed surfaces ---- */

/* Structure of a closed mesh's triangles, whose arrays must outlive it. */
ty_result ty_accel_create_closed(ty_context* context, const ty_triangle_mesh* triangles, ty_accel** out);
/* Crossings of a ray (direction of any length) with a closed mesh beyond the origin, nearest first; returns their
 * number. Beyond TY_CROSSINGS_MAX the farthest are dropped; *beyond: exits minus entries among the dropped ones. */
TY_FN_APART int32_t ty_accel_crossings(const ty_accel* closed, ty_vec origin, ty_vec direction,
                                       ty_crossing crossings[TY_CROSSINGS_MAX], int32_t* beyond);

#endif
