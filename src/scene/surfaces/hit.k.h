/* Hits in full from what an intersection finds: the shape or triangle, and where on it. */
#ifndef TY_SCENE_SURFACES_HIT_K_H
#define TY_SCENE_SURFACES_HIT_K_H

#include "base/random.k.h"
#include "scene/surfaces/surface.k.h"

/* Self-intersection offset relative to the coordinates that are rounded: 70 roundings; and the least one, m. */
#define TY_RELATIVE_MARGIN 4e-6f
#define TY_MIN_MARGIN 4e-9f

/* A quad of a shape: one corner, the normal on its front. */
typedef struct ty_quad_face {
    int32_t shape, primitive_id; /* as in ty_hit */
    ty_vec corner, normal;
    float margin;
} ty_quad_face;

typedef struct ty_sphere_face {
    int32_t shape;
    ty_vec center;
    float radius, margin;
} ty_sphere_face;

/* Self-intersection offset of rays leaving a triangle with this unit normal, m: the margin of ty_hit. */
TY_FN float ty_accel_ray_epsilon(ty_vec normal, ty_vec a, ty_vec b, ty_vec c) {
    const ty_vec largest = ty_vec_make(ty_maxf(fabsf(a.x), ty_maxf(fabsf(b.x), fabsf(c.x))),
                                       ty_maxf(fabsf(a.y), ty_maxf(fabsf(b.y), fabsf(c.y))),
                                       ty_maxf(fabsf(a.z), ty_maxf(fabsf(b.z), fabsf(c.z))));
    const ty_vec magnitude = ty_vec_make(fabsf(normal.x), fabsf(normal.y), fabsf(normal.z));
    return ty_maxf(TY_RELATIVE_MARGIN * ty_dot(magnitude, largest), TY_MIN_MARGIN);
}

/* A hit of a triangle of a mesh, which is surface `number` of the scene view. The distance is left as it is. */
TY_FN void ty_hit_on_triangle(TY_GLOBAL const ty_surface* surface, int32_t number, uint32_t triangle, float b1,
                              float b2, ty_hit* hit) {
    TY_GLOBAL const uint32_t* corners = surface->indices + 3 * (size_t)triangle;
    const ty_vec a = ty_vec_load(surface->positions + 3 * (size_t)corners[0]);
    const ty_vec b = ty_vec_load(surface->positions + 3 * (size_t)corners[1]);
    const ty_vec c = ty_vec_load(surface->positions + 3 * (size_t)corners[2]);
    const ty_vec ab = ty_sub(b, a), ac = ty_sub(c, a);
    float area;
    hit->normal = ty_triangle_normal(ab, ac, &area);
    hit->position = ty_mad(ty_mad(a, ab, b1), ac, b2);
    hit->margin = ty_accel_ray_epsilon(hit->normal, a, b, c);
    hit->surface = number;
    hit->primitive_id = (int32_t)triangle;
    hit->b1 = b1;
    hit->b2 = b2;
}

/* A hit of a sphere; the position is initially a point on the ray. */
TY_FN void ty_hit_on_sphere(TY_GLOBAL const ty_sphere_face* sphere, ty_hit* hit) {
    hit->normal = ty_normalize(ty_sub(hit->position, sphere->center));
    hit->position = ty_mad(sphere->center, hit->normal, sphere->radius);
    hit->margin = sphere->margin;
    hit->surface = sphere->shape;
    hit->primitive_id = 0;
    hit->b1 = hit->b2 = 0.0f;
}

/* The same of a quad. */
TY_FN void ty_hit_on_quad(TY_GLOBAL const ty_quad_face* quad, ty_hit* hit) {
    hit->normal = quad->normal;
    hit->position = ty_mad(hit->position, hit->normal, ty_dot(hit->normal, ty_sub(quad->corner, hit->position)));
    hit->margin = quad->margin;
    hit->surface = quad->shape;
    hit->primitive_id = quad->primitive_id;
    hit->b1 = hit->b2 = 0.0f;
}

/* True if a ray, its origin and direction, meets a point of a triangle by the surface's alpha: the stochastic alpha
 * test, a hash of ray and triangle that is uniform in [0, 1). */
TY_FN bool ty_hit_is_present(TY_GLOBAL const ty_surface* surface, const float ray[6], uint32_t triangle, float b1,
                             float b2) {
    uint32_t bits = triangle;
    for (int i = 0; i < 6; ++i) bits = ty_mix32(bits ^ ty_bits_from_float(ray[i]));
    const float presence = ty_surface_presence(surface, (int32_t)triangle, b1, b2);
    return (float)(bits >> 8) * 0x1p-24f < presence;
}

#endif
