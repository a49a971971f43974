/* Watertight crossings of a ray with the triangles of a closed surface. */
#ifndef TY_SCENE_SURFACES_CROSSING_K_H
#define TY_SCENE_SURFACES_CROSSING_K_H

#include "base/vector.k.h"

#if defined(TY_DEVICE)
enum { TY_CROSSINGS_MAX = 32 }; /* a thread's memory is scarce */
#else
enum { TY_CROSSINGS_MAX = 64 };
#endif

typedef struct ty_crossing {
    float t;
    int32_t exits; /* 1: exit, -1: entry */
} ty_crossing;

/* Crossings of one ray, nearest first. Beyond TY_CROSSINGS_MAX the farthest are dropped; beyond: exits minus entries
 * among the dropped ones. */
typedef struct ty_crossing_list {
    ty_crossing* crossings;
    int32_t count, beyond;
} ty_crossing_list;

/* Ray-space transform of watertight intersection (Woop et al. 2013): the largest direction component becomes z, and
 * space is sheared so that the ray runs along z through (0, 0). */
typedef struct ty_crossing_ray {
    double origin[3];
    double shear_x, shear_y, per_z;
    int32_t x, y, z; /* axes, in cyclic order */
} ty_crossing_ray;

/* A corner in ray space. Single precision across the ray makes products exact in double precision, so that the side of
 * an edge on which the ray passes is the same for both adjacent triangles. */
typedef struct ty_crossing_corner {
    float x, y;
    double t;
} ty_crossing_corner;

TY_FN ty_crossing_ray ty_crossing_ray_begin(ty_vec origin, ty_vec direction) {
    const double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    ty_crossing_ray ray = {.origin = {(double)origin.x, (double)origin.y, (double)origin.z}};
    ray.z = fabs(d[0]) > fabs(d[1]) ? 0 : 1;
    ray.z = fabs(d[2]) > fabs(d[ray.z]) ? 2 : ray.z;
    ray.x = (ray.z + 1) % 3;
    ray.y = (ray.z + 2) % 3;
    ray.per_z = 1.0 / d[ray.z];
    ray.shear_x = d[ray.x] * ray.per_z;
    ray.shear_y = d[ray.y] * ray.per_z;
    return ray;
}

TY_FN ty_crossing_corner ty_crossing_project(const ty_crossing_ray* ray, TY_GLOBAL const float* position) {
    const double z = (double)position[ray->z] - ray->origin[ray->z];
    ty_crossing_corner corner;
    corner.x = (float)((double)position[ray->x] - ray->origin[ray->x] - ray->shear_x * z);
    corner.y = (float)((double)position[ray->y] - ray->origin[ray->y] - ray->shear_y * z);
    corner.t = z * ray->per_z;
    return corner;
}

TY_FN double ty_crossing_area(ty_crossing_corner a, ty_crossing_corner b) {
    return (double)a.x * (double)b.y - (double)a.y * (double)b.x;
}

/* Side of a -> b on which the ray passes: 1 left, -1 right. A ray through the edge is perturbed symbolically by a small
 * amount along x and a smaller one along y; 0 for an edge without length. */
TY_FN int32_t ty_crossing_side(ty_crossing_corner a, ty_crossing_corner b) {
    const double left = (double)a.x * (double)b.y, right = (double)a.y * (double)b.x;
    if (left != right) return left > right ? 1 : -1;
    if (a.y != b.y) return a.y > b.y ? 1 : -1;
    return b.x > a.x ? 1 : b.x < a.x ? -1 : 0;
}

/* True if the ray crosses the triangle beyond its origin. Among the triangles around an edge or a corner of a closed
 * surface, entries and exits are counted as for a neighbouring ray. */
TY_FN bool ty_crossing_find(const ty_crossing_ray* ray, TY_GLOBAL const float* p, TY_GLOBAL const float* q,
                            TY_GLOBAL const float* r, ty_crossing* out) {
    const ty_crossing_corner a = ty_crossing_project(ray, p), b = ty_crossing_project(ray, q),
                             c = ty_crossing_project(ray, r);
    const int32_t side = ty_crossing_side(a, b);
    if (side == 0 || ty_crossing_side(b, c) != side || ty_crossing_side(c, a) != side) return false;
    const double at_a = ty_crossing_area(b, c), at_b = ty_crossing_area(c, a), at_c = ty_crossing_area(a, b);
    const double sum = at_a + at_b + at_c;
    if (sum == 0.0) return false;
    out->t = (float)((at_a * a.t + at_b * b.t + at_c * c.t) / sum);
    out->exits = ray->per_z > 0.0 ? side : -side;
    return out->t > 0.0f;
}

/* Inserts a crossing in order of distance. */
TY_FN void ty_crossing_insert(ty_crossing_list* list, ty_crossing crossing) {
    int32_t at = list->count;
    while (at > 0 && list->crossings[at - 1].t > crossing.t) --at;
    if (list->count == TY_CROSSINGS_MAX) {
        list->beyond += at < list->count ? list->crossings[list->count - 1].exits : crossing.exits;
        if (at == list->count) return;
        --list->count;
    }
    for (int32_t i = list->count++; i > at; --i) list->crossings[i] = list->crossings[i - 1];
    list->crossings[at] = crossing;
}

#endif
