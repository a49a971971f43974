/* Manifold next-event estimation: the light of directional, point and spot lights through smooth interfaces of
 * dielectrics, which no sampled direction meets (Hanika et al. 2015, as specular manifold sampling in Zeltner et al.
 * 2020).
 *
 * Directions w of a vertex are refracted through all interfaces that they meet, with their derivatives (Igehy 1999).
 * Newton's method looks for the one that reaches the light, from the straight line on. With the throughput T of that
 * path its light is f(w) cos T E / |det dv/dw|, with v the direction of the ray at a directional light of irradiance E;
 * for a point light v is the ray's offset at the light over its distance D from the last interface, and E is I / D^2.
 *
 * One such path is found for each vertex and light. Further ones, which curved surfaces may have, and light that is
 * reflected at an interface, are left out. */
#ifndef TY_METHOD_PATH_TRACE_MANIFOLD_K_H
#define TY_METHOD_PATH_TRACE_MANIFOLD_K_H

#include "method/path/trace/interface.k.h"

enum { TY_MANIFOLD_INTERFACES_MAX = 16, TY_MANIFOLD_STEPS_MAX = 24 };

/* Largest deviation of a ray from its light, rad. */
#define TY_MANIFOLD_TOLERANCE 1e-5f

/* A ray after refractions; its derivatives are by shifts of the first direction along two axes. */
typedef struct ty_refracted_ray {
    ty_vec origin, direction;
    ty_vec d_origin[2], d_direction[2];
    ty_interior_list inside;
    float throughput[3];
    int32_t refractions;
    float deviation[2], jacobian[4]; /* from the light's direction, across it; rows by derivative */
} ty_refracted_ray;

/* Derivative of a shading normal along the surface. */
TY_FN ty_vec ty_manifold_bend(TY_GLOBAL const ty_surface* surface, const ty_hit* hit, ty_vec along) {
    if (surface->normals == NULL) return ty_scale(along, surface->curvature);
    TY_GLOBAL const uint32_t* corners = surface->indices + 3 * (size_t)hit->primitive_id;
    const ty_vec a = ty_vec_load(surface->positions + 3 * (size_t)corners[0]);
    const ty_vec ab = ty_sub(ty_vec_load(surface->positions + 3 * (size_t)corners[1]), a);
    const ty_vec ac = ty_sub(ty_vec_load(surface->positions + 3 * (size_t)corners[2]), a);
    const ty_vec normal_a = ty_vec_load(surface->normals + 3 * (size_t)corners[0]);
    const ty_vec by_b = ty_sub(ty_vec_load(surface->normals + 3 * (size_t)corners[1]), normal_a);
    const ty_vec by_c = ty_sub(ty_vec_load(surface->normals + 3 * (size_t)corners[2]), normal_a);
    const float bb = ty_dot(ab, ab), bc = ty_dot(ab, ac), cc = ty_dot(ac, ac), area2 = bb * cc - bc * bc;
    if (!(area2 > 0.0f)) return ty_vec_make(0.0f, 0.0f, 0.0f);
    const float on_b = ty_dot(along, ab), on_c = ty_dot(along, ac);
    const ty_vec change =
        ty_add(ty_scale(by_b, (on_b * cc - on_c * bc) / area2), ty_scale(by_c, (on_c * bb - on_b * bc) / area2));
    const ty_vec smooth = ty_mad(ty_mad(normal_a, by_b, hit->b1), by_c, hit->b2);
    const float scale = 1.0f / sqrtf(ty_maxf(ty_dot(smooth, smooth), 1e-20f));
    const ty_vec unit = ty_scale(smooth, scale);
    return ty_scale(ty_mad(change, unit, -ty_dot(change, unit)), scale);
}

/* Refracts a ray at a hit of a smooth interface; false: it does not pass. */
TY_FN bool ty_manifold_refract(const ty_scene_view* scene, const ty_hit* hit, const ty_interior_list* beyond,
                               ty_refracted_ray* ray) {
    TY_GLOBAL const ty_surface* surface = &scene->surfaces[hit->surface];
    TY_GLOBAL const ty_surface_gloss* gloss = surface->gloss;
    if (gloss->factor.roughness > 0.0f || gloss->factor.transmission < 1.0f || gloss->factor.metallic > 0.0f ||
        gloss->textured != 0)
        return false;
    ty_surface_point point;
    ty_surface_evaluate_color(surface, hit, ray->direction, &point);
    const float ratio = scene->interiors[ray->inside.top].ior / scene->interiors[beyond->top].ior;
    const float cosine = -ty_dot(point.ns, ray->direction), square = ty_refracted_cosine2(cosine, 1.0f / ratio);
    if (!(cosine > 0.0f) || !(square > 0.0f)) return false;
    const float refracted = sqrtf(square), bend = ratio * cosine - refracted;
    const ty_vec direction = ty_mad(ty_scale(ray->direction, ratio), point.ns, bend);
    if (!(ty_dot(direction, point.ng) < 0.0f)) return false;
    const float front = ty_dot(point.ng, hit->normal) > 0.0f ? 1.0f : -1.0f;
    for (int k = 0; k < 2; ++k) {
        ty_vec along = ty_mad(ray->d_origin[k], ray->d_direction[k], hit->distance);
        along = ty_mad(along, ray->direction, -ty_dot(hit->normal, along) / ty_dot(hit->normal, ray->direction));
        /* The stored normals may point either way; those of the point are on the ray's side. */
        ty_vec turn = ty_manifold_bend(surface, hit, along);
        if (surface->normals != NULL) {
            float stored[3];
            ty_surface_interpolate(surface->normals, 3, surface->indices + 3 * (size_t)hit->primitive_id, hit->b1,
                                   hit->b2, stored);
            if (ty_dot(ty_vec_make(stored[0], stored[1], stored[2]), point.ns) < 0.0f) turn = ty_scale(turn, -1.0f);
        } else {
            turn = ty_scale(turn, front);
        }
        const float d_cosine = -(ty_dot(turn, ray->direction) + ty_dot(point.ns, ray->d_direction[k]));
        const float d_bend = ratio * d_cosine - ratio * ratio * cosine * d_cosine / refracted;
        ray->d_direction[k] = ty_mad(ty_mad(ty_scale(ray->d_direction[k], ratio), point.ns, d_bend), turn, bend);
        ray->d_origin[k] = along;
    }
    const float passed = 1.0f - ty_fresnel_dielectric(cosine, 1.0f / ratio);
    for (int c = 0; c < 3; ++c) ray->throughput[c] *= passed * point.albedo[c];
    ray->direction = ty_normalize(direction);
    ++ray->refractions;
    return true;
}

/* Compares the ray's direction with that of the light. */
TY_FN void ty_manifold_compare(const ty_light_view* light, ty_refracted_ray* ray) {
    ty_vec target = ty_scale(light->direction, -1.0f), s, t;
    float distance = TY_FLOAT_MAX;
    if (light->kind != TY_KIND_DIRECTIONAL) {
        target = ty_sub(light->position, ray->origin);
        distance = sqrtf(ty_maxf(ty_dot(target, target), 1e-30f));
        target = ty_scale(target, 1.0f / distance);
    }
    ty_onb(target, &s, &t);
    ray->deviation[0] = ty_dot(s, ray->direction);
    ray->deviation[1] = ty_dot(t, ray->direction);
    for (int k = 0; k < 2; ++k) {
        /* Shifts of the origin rotate the direction of a near light in the opposite sense. */
        const ty_vec change = ty_mad(ray->d_direction[k], ray->d_origin[k], 1.0f / distance);
        ray->jacobian[k] = ty_dot(s, change);
        ray->jacobian[2 + k] = ty_dot(t, change);
    }
    if (ty_dot(target, ray->direction) < 0.0f) ray->deviation[0] += 2.0f;
}

/* Traces a direction from the path's vertex to the side of the light; false: it does not get there. attenuates: with
 * the transmittance of media along the path. */
TY_FN bool ty_manifold_trace(ty_path* path, const ty_light_view* light, ty_vec direction, bool attenuates,
                             ty_refracted_ray* ray) {
    const ty_scene_view* scene = path->request->scene;
    ty_vec zero = {0.0f, 0.0f, 0.0f};
    ray->origin = path->origin;
    ray->direction = direction;
    ty_onb(direction, &ray->d_direction[0], &ray->d_direction[1]);
    ray->d_origin[0] = ray->d_origin[1] = zero;
    ray->inside = path->inside;
    ray->refractions = 0;
    for (int c = 0; c < 3; ++c) ray->throughput[c] = 1.0f;
    for (int32_t i = 0; i < TY_MANIFOLD_INTERFACES_MAX; ++i) {
        const ty_interior* interior = &scene->interiors[ray->inside.top];
        ty_hit hit;
        ty_interior_list beyond;
        float end = TY_FLOAT_MAX;
        if (light->kind != TY_KIND_DIRECTIONAL) {
            end = ty_dot(ty_sub(light->position, ray->origin), ray->direction);
            if (end <= 0.0f) end = TY_FLOAT_MAX;
        }
        const bool hits = ty_accel_intersect(scene->mesh, ray->origin, ray->direction, end * 0.9999f, &hit);
        if (attenuates) {
            float transmittance[3];
            ty_transmittance(interior->media, ty_path_medium_count(path, interior), ray->origin, ray->direction,
                             hits ? hit.distance : end, &path->random, transmittance);
            for (int c = 0; c < 3; ++c) ray->throughput[c] *= transmittance[c];
        }
        if (!hits) {
            if (ray->refractions == 0 || (end >= TY_FLOAT_MAX && light->kind != TY_KIND_DIRECTIONAL)) return false;
            ty_manifold_compare(light, ray);
            return true;
        }
        const int32_t interface = ty_interface_find(scene, &ray->inside, &hit, ray->direction, &beyond);
        if (interface == TY_INTERFACE_NONE) return false;
        if (interface == TY_INTERFACE_REFRACTS) {
            if (!ty_manifold_refract(scene, &hit, &beyond, ray)) return false;
        } else {
            ty_surface_point point;
            ty_surface_evaluate_color(&scene->surfaces[hit.surface], &hit, ray->direction, &point);
            ty_interface_tint(&ray->inside, &beyond, point.albedo, ray->throughput);
            for (int k = 0; k < 2; ++k) ray->d_origin[k] = ty_mad(ray->d_origin[k], ray->d_direction[k], hit.distance);
        }
        ray->inside = beyond;
        ray->origin = ty_hit_leave(&hit, ray->direction);
    }
    return false;
}

TY_FN float ty_manifold_deviation(const ty_refracted_ray* ray) {
    return sqrtf(ray->deviation[0] * ray->deviation[0] + ray->deviation[1] * ray->deviation[1]);
}

/* Where the straight line is reflected totally at the first interface, the direction that Snell's law would take to it
 * there; false: none does. */
TY_FN bool ty_manifold_start(const ty_path* path, ty_vec* direction) {
    const ty_scene_view* scene = path->request->scene;
    ty_hit hit;
    ty_interior_list beyond;
    ty_surface_point point;
    if (!ty_accel_intersect(scene->mesh, path->origin, *direction, TY_FLOAT_MAX, &hit) ||
        ty_interface_find(scene, &path->inside, &hit, *direction, &beyond) != TY_INTERFACE_REFRACTS)
        return false;
    ty_surface_evaluate_color(&scene->surfaces[hit.surface], &hit, *direction, &point);
    const float ratio = scene->interiors[beyond.top].ior / scene->interiors[path->inside.top].ior;
    const float cosine = -ty_dot(point.ns, *direction), square = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
    if (!(cosine > 0.0f) || !(square > 0.0f)) return false;
    *direction = ty_normalize(ty_mad(ty_scale(*direction, ratio), point.ns, ratio * cosine - sqrtf(square)));
    return true;
}

/* The direction of the path's vertex in which it sees the light through interfaces; false: none is found. *direction:
 * in, the straight one. */
TY_FN bool ty_manifold_find(ty_path* path, const ty_light_view* light, ty_vec* direction, ty_refracted_ray* ray) {
    ty_refracted_ray next;
    float part = 1.0f;
    if (!ty_manifold_trace(path, light, *direction, false, ray) &&
        (!ty_manifold_start(path, direction) || !ty_manifold_trace(path, light, *direction, false, ray)))
        return false;
    for (int32_t i = 0; i < TY_MANIFOLD_STEPS_MAX; ++i) {
        const float deviation = ty_manifold_deviation(ray);
        if (deviation < TY_MANIFOLD_TOLERANCE) return true;
        const float* j = ray->jacobian;
        const float determinant = j[0] * j[3] - j[1] * j[2];
        if (!(fabsf(determinant) > 1e-12f)) return false;
        float a = -part * (j[3] * ray->deviation[0] - j[1] * ray->deviation[1]) / determinant;
        float b = -part * (j[0] * ray->deviation[1] - j[2] * ray->deviation[0]) / determinant;
        const float length = sqrtf(a * a + b * b), limit = 0.5f;
        if (length > limit) a *= limit / length, b *= limit / length;
        ty_vec s, t;
        ty_onb(*direction, &s, &t);
        const ty_vec rotated = ty_normalize(ty_mad(ty_mad(*direction, s, a), t, b));
        const bool nearer =
            ty_manifold_trace(path, light, rotated, false, &next) && ty_manifold_deviation(&next) < deviation;
        part = nearer ? ty_minf(2.0f * part, 1.0f) : 0.5f * part;
        if (!nearer) continue;
        *direction = rotated;
        *ray = next;
    }
    return ty_manifold_deviation(ray) < TY_MANIFOLD_TOLERANCE;
}

#endif
