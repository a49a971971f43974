/* A bounding volume hierarchy as plain arrays, and rays through it, for devices without Embree. */
#ifndef TY_SCENE_SURFACES_BVH_K_H
#define TY_SCENE_SURFACES_BVH_K_H

#include "scene/surfaces/crossing.k.h"
#include "scene/surfaces/hit.k.h"

/* Levels of a hierarchy at most, which bound the stack of a traversal. */
enum { TY_BVH_DEPTH = 48 };

enum { TY_BVH_TRIANGLE = 0, TY_BVH_QUAD = 1, TY_BVH_SPHERE = 2 };

/* An inner node: two children with their boxes. */
typedef struct ty_bvh_node {
    float lower[2][3], upper[2][3]; /* m */
    int32_t child[2];               /* an inner node, or the first primitive of a leaf */
    int32_t count[2];               /* 0: an inner node; -1: no child; else the primitives of a leaf, at
                                       most 7 */
} ty_bvh_node;

typedef struct ty_bvh_primitive {
    float corner[3][3]; /* half of a quad has three of its corners; a sphere its centre, then its radius */
    int32_t kind;
    int32_t mesh;     /* triangles: index in ty_bvh.surfaces */
    uint32_t element; /* triangle of the mesh, quad or sphere */
} ty_bvh_primitive;

typedef struct ty_bvh {
    TY_GLOBAL const ty_bvh_node* nodes; /* the root is the first */
    TY_GLOBAL const ty_bvh_primitive* primitives;
    TY_GLOBAL const ty_quad_face* quads;
    TY_GLOBAL const ty_sphere_face* spheres;
    TY_GLOBAL const ty_surface* surfaces; /* of meshes; NULL: the primitives are those of a closed mesh */
    int32_t first_mesh;                   /* index of surfaces[0] in the scene view */
} ty_bvh;

typedef struct ty_bvh_hit {
    float distance, b1, b2;
    int32_t primitive; /* in ty_bvh.primitives */
} ty_bvh_hit;

/* A ray as boxes are tested with: zero components of the direction count as very small ones. */
typedef struct ty_bvh_ray {
    ty_vec origin, direction, inverse;
} ty_bvh_ray;

TY_FN float ty_bvh_invert(float x) {
    const float min = 1e-18f;
    return 1.0f / (fabsf(x) > min ? x : x < 0.0f ? -min : min);
}

TY_FN ty_bvh_ray ty_bvh_ray_make(ty_vec origin, ty_vec direction) {
    ty_bvh_ray ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.inverse = ty_vec_make(ty_bvh_invert(direction.x), ty_bvh_invert(direction.y), ty_bvh_invert(direction.z));
    return ray;
}

/* Where a ray enters a child's box, or TY_FLOAT_MAX if it misses it before far. The exit is rounded up by more than its
 * error (Ize 2013). */
TY_FN float ty_bvh_enter(TY_GLOBAL const ty_bvh_node* node, int32_t child, const ty_bvh_ray* ray, float far) {
    if (node->count[child] < 0) return TY_FLOAT_MAX;
    TY_GLOBAL const float *low = node->lower[child], *high = node->upper[child];
    const float ax = (low[0] - ray->origin.x) * ray->inverse.x, bx = (high[0] - ray->origin.x) * ray->inverse.x;
    const float ay = (low[1] - ray->origin.y) * ray->inverse.y, by = (high[1] - ray->origin.y) * ray->inverse.y;
    const float az = (low[2] - ray->origin.z) * ray->inverse.z, bz = (high[2] - ray->origin.z) * ray->inverse.z;
    const float enter = ty_maxf(ty_maxf(ty_minf(ax, bx), ty_minf(ay, by)), ty_maxf(ty_minf(az, bz), 0.0f));
    const float leave = ty_minf(ty_minf(ty_maxf(ax, bx), ty_maxf(ay, by)), ty_maxf(az, bz)) * 1.0000005f;
    return enter <= ty_minf(leave, far) ? enter : TY_FLOAT_MAX;
}

/* Side of an edge on which a ray from 0 passes, as a volume: Plücker coordinates, whose sign is the same for both
 * triangles at the edge (Davidovic et al. 2012). */
TY_FN float ty_bvh_side(ty_vec from, ty_vec to, ty_vec direction) {
    return ty_dot(ty_cross(ty_sub(from, to), ty_add(from, to)), direction);
}

/* A triangle on (0, hit->distance); hit->distance, b1 and b2 are set if it is hit. */
TY_FN bool ty_bvh_intersect_triangle(TY_GLOBAL const ty_bvh_primitive* p, const ty_bvh_ray* ray, ty_bvh_hit* hit) {
    const ty_vec a = ty_sub(ty_vec_load(p->corner[0]), ray->origin), b = ty_sub(ty_vec_load(p->corner[1]), ray->origin),
                 c = ty_sub(ty_vec_load(p->corner[2]), ray->origin);
    const float at_b = ty_bvh_side(c, a, ray->direction), at_c = ty_bvh_side(a, b, ray->direction),
                at_a = ty_bvh_side(b, c, ray->direction);
    const float min = ty_minf(at_a, ty_minf(at_b, at_c)), max = ty_maxf(at_a, ty_maxf(at_b, at_c));
    if (min < 0.0f && max > 0.0f) return false;
    const float sum = at_a + at_b + at_c;
    if (sum == 0.0f) return false;
    const float inverse = 1.0f / sum;
    const float distance =
        (at_a * ty_dot(a, ray->direction) + at_b * ty_dot(b, ray->direction) + at_c * ty_dot(c, ray->direction)) *
        inverse / ty_dot(ray->direction, ray->direction);
    if (!(distance > 0.0f && distance < hit->distance)) return false;
    hit->distance = distance;
    hit->b1 = at_b * inverse;
    hit->b2 = at_c * inverse;
    return true;
}

/* The same of a sphere, by the point of the ray that is nearest its centre. */
TY_FN bool ty_bvh_intersect_sphere(TY_GLOBAL const ty_bvh_primitive* p, const ty_bvh_ray* ray, ty_bvh_hit* hit) {
    const ty_vec to_center = ty_sub(ty_vec_load(p->corner[0]), ray->origin);
    const float dd = ty_dot(ray->direction, ray->direction), closest = ty_dot(to_center, ray->direction) / dd;
    const ty_vec offset = ty_mad(to_center, ray->direction, -closest);
    const float radius = p->corner[1][0], half_square = (radius * radius - ty_dot(offset, offset)) / dd;
    if (half_square < 0.0f) return false;
    const float half = sqrtf(half_square), front = closest - half, back = closest + half;
    const float distance = front > 0.0f ? front : back;
    if (!(distance > 0.0f && distance < hit->distance)) return false;
    hit->distance = distance;
    return true;
}

TY_FN bool ty_bvh_intersect_primitive(TY_GLOBAL const ty_bvh* bvh, int32_t index, const ty_bvh_ray* ray,
                                      ty_bvh_hit* hit) {
    TY_GLOBAL const ty_bvh_primitive* p = &bvh->primitives[index];
    ty_bvh_hit found = *hit;
    if (!(p->kind == TY_BVH_SPHERE ? ty_bvh_intersect_sphere(p, ray, &found)
                                   : ty_bvh_intersect_triangle(p, ray, &found)))
        return false;
    if (p->kind == TY_BVH_TRIANGLE && bvh->surfaces[p->mesh].alpha_mode != 0) {
        const float six[6] = {ray->origin.x,    ray->origin.y,    ray->origin.z,
                              ray->direction.x, ray->direction.y, ray->direction.z};
        if (!ty_hit_is_present(&bvh->surfaces[p->mesh], six, p->element, found.b1, found.b2)) return false;
    }
    found.primitive = index;
    *hit = found;
    return true;
}

/* Leaves and nodes that a traversal has still to visit: their first primitive or number, times 8, plus the primitives
 * of a leaf. */
typedef struct ty_bvh_walk {
    uint32_t todo[TY_BVH_DEPTH];
    int32_t size;
} ty_bvh_walk;

TY_FN void ty_bvh_walk_begin(ty_bvh_walk* walk) {
    walk->todo[0] = 0;
    walk->size = 1;
}

TY_FN void ty_bvh_walk_push(ty_bvh_walk* walk, TY_GLOBAL const ty_bvh_node* node, int32_t child) {
    walk->todo[walk->size++] = (uint32_t)node->child[child] << 3 | (uint32_t)node->count[child];
}

/* The next leaf whose box the ray meets before far: its first primitive and their number; 0 at the end. */
TY_FN int32_t ty_bvh_walk_next(TY_GLOBAL const ty_bvh* bvh, const ty_bvh_ray* ray, float far, ty_bvh_walk* walk,
                               int32_t* first) {
    while (walk->size > 0) {
        const uint32_t todo = walk->todo[--walk->size];
        *first = (int32_t)(todo >> 3);
        if ((todo & 7u) != 0) return (int32_t)(todo & 7u);
        TY_GLOBAL const ty_bvh_node* node = &bvh->nodes[*first];
        const float enter0 = ty_bvh_enter(node, 0, ray, far), enter1 = ty_bvh_enter(node, 1, ray, far);
        const int32_t near = enter0 <= enter1 ? 0 : 1;
        if ((near == 0 ? enter1 : enter0) < TY_FLOAT_MAX) ty_bvh_walk_push(walk, node, 1 - near);
        if ((near == 0 ? enter0 : enter1) < TY_FLOAT_MAX) ty_bvh_walk_push(walk, node, near);
    }
    return 0;
}

/* The closest hit nearer than far, or with `any` some hit. */
TY_FN_CALLED bool ty_bvh_trace(TY_GLOBAL const ty_bvh* bvh, ty_vec origin, ty_vec direction, float far, int32_t any,
                               ty_bvh_hit* hit) {
    const ty_bvh_ray ray = ty_bvh_ray_make(origin, direction);
    ty_bvh_walk walk;
    int32_t first, count;
    bool found = false;
    hit->distance = far;
    hit->b1 = hit->b2 = 0.0f;
    hit->primitive = -1;
    ty_bvh_walk_begin(&walk);
    while ((count = ty_bvh_walk_next(bvh, &ray, hit->distance, &walk, &first)) > 0)
        for (int32_t i = 0; i < count; ++i)
            if (ty_bvh_intersect_primitive(bvh, first + i, &ray, hit)) {
                found = true;
                if (any != 0) return true;
            }
    return found;
}

/* A hit in full, as ty_accel_intersect gives it. */
TY_FN void ty_bvh_complete(TY_GLOBAL const ty_bvh* bvh, ty_vec origin, ty_vec direction, const ty_bvh_hit* found,
                           ty_hit* hit) {
    TY_GLOBAL const ty_bvh_primitive* p = &bvh->primitives[found->primitive];
    hit->distance = found->distance;
    hit->position = ty_mad(origin, direction, hit->distance);
    if (p->kind == TY_BVH_TRIANGLE)
        ty_hit_on_triangle(&bvh->surfaces[p->mesh], bvh->first_mesh + p->mesh, p->element, found->b1, found->b2, hit);
    else if (p->kind == TY_BVH_SPHERE)
        ty_hit_on_sphere(&bvh->spheres[p->element], hit);
    else
        ty_hit_on_quad(&bvh->quads[p->element], hit);
}

/* ty_accel_crossings, by the hierarchy of a closed mesh. */
TY_FN_CALLED int32_t ty_bvh_crossings(TY_GLOBAL const ty_bvh* closed, ty_vec origin, ty_vec direction,
                                      ty_crossing crossings[TY_CROSSINGS_MAX], int32_t* beyond) {
    const ty_bvh_ray ray = ty_bvh_ray_make(origin, direction);
    const ty_crossing_ray exact = ty_crossing_ray_begin(origin, direction);
    ty_crossing_list list = {crossings, 0, 0};
    ty_bvh_walk walk;
    int32_t first, count;
    ty_bvh_walk_begin(&walk);
    while ((count = ty_bvh_walk_next(closed, &ray, 0.5f * TY_FLOAT_MAX, &walk, &first)) > 0)
        for (int32_t i = 0; i < count; ++i) {
            TY_GLOBAL const ty_bvh_primitive* p = &closed->primitives[first + i];
            ty_crossing crossing;
            if (ty_crossing_find(&exact, p->corner[0], p->corner[1], p->corner[2], &crossing))
                ty_crossing_insert(&list, crossing);
        }
    *beyond = list.beyond;
    return list.count;
}

#endif
