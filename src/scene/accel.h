/* Surfaces for ray tracing. Only mesh.c sees Embree. */
#ifndef TY_SCENE_ACCEL_H
#define TY_SCENE_ACCEL_H

#include "scene/crossing.k.h"
#include "scene/surface.k.h"
#include "scene/triangle_mesh.h"

#include <tyndall/scene.h>

typedef struct ty_accel ty_accel;

/* What a mesh is made of. Surfaces are numbered as shapes first, then meshes. Everything must have passed the checks
 * of ty_scene_add_shape and ty_scene_add_mesh, and outlive the mesh. */
typedef struct ty_accel_input {
    const ty_shape_def* shapes;
    size_t shape_count;
    ty_triangle_mesh* const* meshes;
    size_t mesh_count;
    const ty_surface* surfaces; /* shape_count + mesh_count */
} ty_accel_input;

/* *out is NULL when there is nothing to hit. */
ty_result ty_accel_create(ty_context* context, const ty_accel_input* parts, ty_accel** out);
void ty_accel_destroy(ty_accel* mesh);
size_t ty_accel_bytes(const ty_accel* mesh);

/* How far off a triangle with this unit normal rays may start without meeting it again, m: ty_hit's margin. */
float ty_accel_ray_epsilon(ty_vec normal, ty_vec a, ty_vec b, ty_vec c);

/* The nearest hit closer than far; direction is unit. mesh is not NULL. Where surfaces have alpha, the ray itself
 * decides which it meets: the same ray always meets the same. */
bool ty_accel_intersect(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far, ty_hit* hit);
/* Whether anything is hit closer than far. */
bool ty_accel_occluded(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far);

/* Many rays at once, sixteen by sixteen: quickest where neighbours go the same way. */
enum { TY_PACKET = 16 };

/* hits[i].surface is -1 where ray i meets nothing. count: 1..TY_PACKET. */
void ty_accel_intersect_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, ty_hit* hits);
/* How far off what they meet is, m; INFINITY: nothing. count: 1..TY_PACKET. */
void ty_accel_distance_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, float* distances);
/* occluded[i]: whether ray i meets anything. count: 1..TY_PACKET. */
void ty_accel_occluded_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, bool* occluded);

/* All that rays go through, not only what they meet first. */
enum { TY_ALL_HITS_MAX = 256 };

/* Where a ray goes through a surface; ty_accel_complete_hit says more. */
typedef struct ty_hit_record {
    float distance, b1, b2;
    uint32_t geometry, primitive;
} ty_hit_record;

/* What each ray goes through, nearest first; of more than TY_ALL_HITS_MAX surfaces the farthest are left out. Two that
 * lie in one place, or share the edge that a ray goes through, are both there. */
typedef struct ty_all_hits {
    ty_hit_record layer[TY_PACKET][TY_ALL_HITS_MAX];
    int32_t count[TY_PACKET];
} ty_all_hits;

/* count: 1..TY_PACKET. */
void ty_accel_all_hits_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, ty_all_hits* out);
void ty_accel_complete_hit(const ty_accel* mesh, const ty_ray* ray, const ty_hit_record* layer, ty_hit* hit);

/* ---- closed surfaces ---- */

enum { TY_CROSSINGS_MAX = 64 };

/* A mesh of its own for a shell's triangles, whose arrays must outlive it. */
ty_result ty_accel_create_closed(ty_context* context, const ty_triangle_mesh* triangles, ty_accel** out);
/* Where a ray (direction of any length) crosses a shell's triangles beyond its origin, nearest first; returns how
 * many. Of more than TY_CROSSINGS_MAX, the farthest are left out; *beyond: how many more of those lead out than in. */
int32_t ty_accel_crossings(const ty_accel* shell, ty_vec origin, ty_vec direction,
                           ty_crossing crossings[TY_CROSSINGS_MAX], int32_t* beyond);

#endif
