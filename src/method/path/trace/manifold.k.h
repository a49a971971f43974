/* Manifold next-event estimation: light through specular chains at smooth interfaces of dielectrics (Hanika et al.
 * 2015, as specular manifold sampling in Zeltner et al. 2020).
 *
 * Directions w of a vertex are refracted, or reflected, at all interfaces that they meet, with their derivatives (Igehy
 * 1999). Newton's method looks for one that reaches a target: a point, or a direction of light from infinity. With the
 * throughput T of the chain, light of irradiance E from a direction contributes f(w) cos T E / |det dv/dw|, with v the
 * direction of the ray behind the interfaces; for a point light v is the ray's offset at the light over its distance D
 * from the last interface, and E is I / D^2.
 *
 * Started on the straight line, Newton's method is a function of vertex and target, which finds at most one chain. It
 * is used for delta lights, and for small emitters and bright parts of environments by multiple importance sampling
 * with sampled directions: these find all chains to an emitter, and one that Newton's method finds, too, has the
 * solid-angle density p = p_A D^2 |det dv/dw| / cos, with p_A the density of the point on the emitter and cos the
 * emitter's cosine. Further chains to delta lights are found from sampled directions (refracted_light.k.h). */
#ifndef TY_METHOD_PATH_TRACE_MANIFOLD_K_H
#define TY_METHOD_PATH_TRACE_MANIFOLD_K_H

#include "method/path/trace/interface.k.h"

enum { TY_MANIFOLD_INTERFACES_MAX = 16, TY_MANIFOLD_STEPS_MAX = 24, TY_MANIFOLD_REFLECTIONS_MAX = 3 };

/* Largest deviation of a ray from its light, rad. */
#define TY_MANIFOLD_TOLERANCE 1e-5f

/* Purposes of a ray through interfaces. */
enum {
    TY_MANIFOLD_SEED = 0,   /* reflected by chance, with the probability of Fresnel's reflectance */
    TY_MANIFOLD_SEARCH = 1, /* as ray->reflections says, and so below; opaque surfaces do not hide the light */
    TY_MANIFOLD_SEE = 2,    /* opaque surfaces hide the light */
    TY_MANIFOLD_ARRIVE = 3  /* media attenuate it, too */
};

/* Where a ray is to arrive. */
typedef struct ty_manifold_target {
    ty_vec point; /* or the unit direction to it */
    bool distant;
} ty_manifold_target;

/* A ray after refractions and reflections; its derivatives are by shifts of the first direction along two axes. */
typedef struct ty_refracted_ray {
    ty_vec origin, direction;
    ty_vec d_origin[2], d_direction[2];
    ty_interior_list inside;
    float throughput[3];
    float chance;         /* of a sampled path to follow the chain, by Fresnel's reflectance */
    int32_t interfaces;   /* that turned it */
    uint32_t reflections; /* bit i: the i-th of them reflected it */
    int32_t reflection_count;
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

/* Refracts, or reflects, a ray at a hit of a smooth interface; false: it does not follow the chain. */
TY_FN bool ty_manifold_interact(const ty_scene_view* scene, const ty_hit* hit, const ty_interior_list* beyond,
                                ty_sampler* starts, ty_refracted_ray* ray) {
    TY_GLOBAL const ty_surface* surface = &scene->surfaces[hit->surface];
    TY_GLOBAL const ty_surface_gloss* gloss = surface->gloss;
    if (gloss->factor.roughness > 0.0f || gloss->factor.transmission < 1.0f || gloss->factor.metallic > 0.0f ||
        gloss->textured != 0)
        return false;
    ty_surface_look point;
    ty_surface_evaluate_color(surface, hit, ray->direction, &point);
    const float ratio = scene->interiors[ray->inside.top].ior / scene->interiors[beyond->top].ior;
    const float cosine = -ty_dot(point.ns, ray->direction), square = ty_refracted_cosine2(cosine, 1.0f / ratio);
    if (!(cosine > 0.0f)) return false;
    const float fresnel = ty_fresnel_dielectric(cosine, 1.0f / ratio);
    if (starts != NULL && ty_rng_uniform(starts) < fresnel) {
        if (++ray->reflection_count > TY_MANIFOLD_REFLECTIONS_MAX) return false;
        ray->reflections |= 1u << ray->interfaces;
    }
    const bool reflects = (ray->reflections >> ray->interfaces & 1u) != 0;
    if (!reflects && !(square > 0.0f)) return false;
    /* The new direction is scale times the old one and bend times the normal. */
    const float refracted = sqrtf(ty_maxf(square, 0.0f)), scale = reflects ? 1.0f : ratio;
    const float bend = reflects ? 2.0f * cosine : ratio * cosine - refracted;
    const ty_vec direction = ty_mad(ty_scale(ray->direction, scale), point.ns, bend);
    if ((ty_dot(direction, point.ng) > 0.0f) != reflects) return false;
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
        const float d_bend =
            reflects ? 2.0f * d_cosine : ratio * d_cosine - ratio * ratio * cosine * d_cosine / refracted;
        ray->d_direction[k] = ty_mad(ty_mad(ty_scale(ray->d_direction[k], scale), point.ns, d_bend), turn, bend);
        ray->d_origin[k] = along;
    }
    const float part = reflects ? fresnel : 1.0f - fresnel;
    ray->chance *= part;
    for (int c = 0; c < 3; ++c) ray->throughput[c] *= reflects ? part : part * point.albedo[c];
    ray->direction = ty_normalize(direction);
    ++ray->interfaces;
    if (!reflects) ray->inside = *beyond;
    return true;
}

/* Compares the ray's direction with that of the light. */
TY_FN void ty_manifold_compare(const ty_manifold_target* target, ty_refracted_ray* ray) {
    ty_vec wi = target->point, s, t;
    float distance = TY_FLOAT_MAX;
    if (!target->distant) {
        wi = ty_sub(target->point, ray->origin);
        distance = sqrtf(ty_maxf(ty_dot(wi, wi), 1e-30f));
        wi = ty_scale(wi, 1.0f / distance);
    }
    ty_onb(wi, &s, &t);
    ray->deviation[0] = ty_dot(s, ray->direction);
    ray->deviation[1] = ty_dot(t, ray->direction);
    for (int k = 0; k < 2; ++k) {
        /* Shifts of the origin rotate the direction of a near light in the opposite sense. */
        const ty_vec change = ty_mad(ray->d_direction[k], ray->d_origin[k], 1.0f / distance);
        ray->jacobian[k] = ty_dot(s, change);
        ray->jacobian[2 + k] = ty_dot(t, change);
    }
    if (ty_dot(wi, ray->direction) < 0.0f) ray->deviation[0] += 2.0f;
}

/* Follows a direction from a vertex to the side of the target; false: it does not get there, or meets no interface. */
TY_FN bool ty_manifold_trace(ty_path* path, const ty_manifold_vertex* vertex, const ty_manifold_target* target,
                             ty_vec direction, int32_t mode, ty_refracted_ray* ray) {
    const ty_scene_view* scene = path->request->scene;
    ty_vec zero = {0.0f, 0.0f, 0.0f};
    ray->origin = vertex->origin;
    ray->direction = direction;
    ty_onb(direction, &ray->d_direction[0], &ray->d_direction[1]);
    ray->d_origin[0] = ray->d_origin[1] = zero;
    ray->inside = vertex->inside;
    ray->interfaces = ray->reflection_count = 0;
    ray->chance = 1.0f;
    for (int c = 0; c < 3; ++c) ray->throughput[c] = 1.0f;
    for (int32_t i = 0; i < TY_MANIFOLD_INTERFACES_MAX; ++i) {
        const ty_interior* interior = &scene->interiors[ray->inside.top];
        ty_hit hit;
        ty_interior_list beyond;
        float end = TY_FLOAT_MAX;
        if (!target->distant) {
            end = ty_dot(ty_sub(target->point, ray->origin), ray->direction);
            if (end <= 0.0f) end = TY_FLOAT_MAX;
        }
        const bool hits = ty_accel_intersect(scene->mesh, ray->origin, ray->direction, end * 0.9999f, &hit);
        if (mode == TY_MANIFOLD_ARRIVE) {
            float transmittance[3];
            ty_transmittance(interior->media, ty_path_medium_count(path, interior), ray->origin, ray->direction,
                             hits ? hit.distance : end, &path->random, transmittance);
            for (int c = 0; c < 3; ++c) ray->throughput[c] *= transmittance[c];
        }
        const int32_t interface =
            hits ? ty_interface_find(scene, &ray->inside, &hit, ray->direction, &beyond) : TY_INTERFACE_NONE;
        if (interface == TY_INTERFACE_NONE) {
            if (ray->interfaces == 0 || (hits && mode >= TY_MANIFOLD_SEE) || (end >= TY_FLOAT_MAX && !target->distant))
                return false;
            ty_manifold_compare(target, ray);
            return true;
        }
        ty_vec leaves = ray->direction;
        if (interface == TY_INTERFACE_REFRACTS) {
            if (!ty_manifold_interact(scene, &hit, &beyond, mode == TY_MANIFOLD_SEED ? &path->random : NULL, ray))
                return false;
            leaves = ray->direction;
        } else {
            float tint[3];
            ty_interface_tint(scene, interface, &ray->inside, &beyond, &hit, ray->direction, tint);
            for (int c = 0; c < 3; ++c) ray->throughput[c] *= tint[c];
            for (int k = 0; k < 2; ++k) ray->d_origin[k] = ty_mad(ray->d_origin[k], ray->d_direction[k], hit.distance);
            ray->inside = beyond;
        }
        ray->origin = ty_hit_leave(&hit, leaves);
    }
    return false;
}

TY_FN float ty_manifold_deviation(const ty_refracted_ray* ray) {
    return sqrtf(ray->deviation[0] * ray->deviation[0] + ray->deviation[1] * ray->deviation[1]);
}

/* Newton's method from a direction and its ray on; false: it finds no chain in these steps. */
TY_FN bool ty_manifold_solve(ty_path* path, const ty_manifold_vertex* vertex, const ty_manifold_target* target,
                             int32_t steps, ty_vec* direction, ty_refracted_ray* ray) {
    ty_refracted_ray next;
    float part = 1.0f;
    next.reflections = ray->reflections;
    for (int32_t i = 0; i < steps; ++i) {
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
        const bool nearer = ty_manifold_trace(path, vertex, target, rotated, TY_MANIFOLD_SEARCH, &next) &&
                            ty_manifold_deviation(&next) < deviation;
        part = nearer ? ty_minf(2.0f * part, 1.0f) : 0.5f * part;
        if (!nearer) continue;
        *direction = rotated;
        *ray = next;
    }
    return ty_manifold_deviation(ray) < TY_MANIFOLD_TOLERANCE;
}

/* Where the straight line is reflected totally at the first interface, the direction that Snell's law would take to it
 * there; false: none does. */
TY_FN bool ty_manifold_start(const ty_path* path, const ty_manifold_vertex* vertex, ty_vec* direction) {
    const ty_scene_view* scene = path->request->scene;
    ty_hit hit;
    ty_interior_list beyond;
    ty_surface_look point;
    if (!ty_accel_intersect(scene->mesh, vertex->origin, *direction, TY_FLOAT_MAX, &hit) ||
        ty_interface_find(scene, &vertex->inside, &hit, *direction, &beyond) != TY_INTERFACE_REFRACTS)
        return false;
    ty_surface_evaluate_color(&scene->surfaces[hit.surface], &hit, *direction, &point);
    const float ratio = scene->interiors[beyond.top].ior / scene->interiors[vertex->inside.top].ior;
    const float cosine = -ty_dot(point.ns, *direction), square = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
    if (!(cosine > 0.0f) || !(square > 0.0f)) return false;
    *direction = ty_normalize(ty_mad(ty_scale(*direction, ratio), point.ns, ratio * cosine - sqrtf(square)));
    return true;
}

/* The direction of a vertex in which it sees a target through interfaces, from the straight line on; false: none is
 * found. The result depends on nothing but vertex and target. */
TY_FN bool ty_manifold_find(ty_path* path, const ty_manifold_vertex* vertex, const ty_manifold_target* target,
                            ty_vec* direction, ty_refracted_ray* ray) {
    ty_vec straight = target->distant ? target->point : ty_normalize(ty_sub(target->point, vertex->origin));
    ray->reflections = 0;
    if (!ty_manifold_trace(path, vertex, target, straight, TY_MANIFOLD_SEARCH, ray) &&
        (!ty_manifold_start(path, vertex, &straight) ||
         !ty_manifold_trace(path, vertex, target, straight, TY_MANIFOLD_SEARCH, ray)))
        return false;
    *direction = straight;
    return ty_manifold_solve(path, vertex, target, TY_MANIFOLD_STEPS_MAX, direction, ray);
}

/* True if the chain that was found in a direction is that of another direction. Near a fold, where two chains meet, it
 * is told by what the ray's derivatives make of the difference. */
TY_FN bool ty_manifold_is_same(const ty_refracted_ray* ray, ty_vec direction, ty_vec other) {
    const ty_vec off = ty_sub(other, direction);
    const float* j = ray->jacobian;
    ty_vec s, t;
    if (!(ty_dot(off, off) < 4e-4f)) return false;
    ty_onb(direction, &s, &t);
    const float a = ty_dot(off, s), b = ty_dot(off, t);
    const float x = j[0] * a + j[1] * b, y = j[2] * a + j[3] * b;
    return x * x + y * y < 16.0f * TY_MANIFOLD_TOLERANCE * TY_MANIFOLD_TOLERANCE;
}

TY_FN float ty_manifold_determinant(const ty_refracted_ray* ray) {
    return fabsf(ray->jacobian[0] * ray->jacobian[3] - ray->jacobian[1] * ray->jacobian[2]);
}

/* ---- emitters with a size ---- */

/* Solid-angle density, 1/sr, of light sampling times the probability of the light from which on emitters count as small
 * (0.2 sr). Others are found by sampled directions alone. */
#define TY_MANIFOLD_DENSITY_MIN 5.0f

/* Unit normal of an emitter at a point. */
TY_FN ty_vec ty_manifold_light_normal(const ty_light_view* light, ty_vec at) {
    return light->kind == TY_KIND_SPHERE ? ty_scale(ty_sub(at, light->position), 1.0f / light->radius)
                                         : light->direction;
}

/* Solid-angle density of light sampling towards a target, without regard to interfaces, 1/sr. */
TY_FN float ty_manifold_straight_pdf(const ty_light_view* light, ty_vec from, const ty_manifold_target* target) {
    if (target->distant) return ty_environment_pdf(&light->environment, target->point);
    const ty_vec to = ty_sub(target->point, from);
    const float distance = sqrtf(ty_maxf(ty_dot(to, to), 1e-30f));
    const ty_vec wi = ty_scale(to, 1.0f / distance);
    /* Of a sphere the near side alone is sampled. */
    if (light->kind == TY_KIND_SPHERE && !(ty_dot(ty_manifold_light_normal(light, target->point), wi) < 0.0f))
        return 0.0f;
    return ty_light_pdf(light, from, wi, distance);
}

/* Density of the direction of a found chain, 1/sr at the vertex. straight: that without interfaces. */
TY_FN float ty_manifold_pdf(const ty_light_view* light, ty_vec from, const ty_manifold_target* target, float straight,
                            const ty_refracted_ray* ray) {
    const float determinant = ty_manifold_determinant(ray);
    if (target->distant) return straight * determinant;
    const ty_vec to = ty_sub(target->point, from), last = ty_sub(target->point, ray->origin);
    const ty_vec normal = ty_manifold_light_normal(light, target->point);
    const float d2 = ty_dot(to, to), facing = fabsf(ty_dot(normal, to)) / sqrtf(ty_maxf(d2, 1e-30f));
    const float cosine = ty_maxf(fabsf(ty_dot(normal, ray->direction)), 1e-6f);
    return straight * facing / ty_maxf(d2, 1e-30f) * determinant * ty_dot(last, last) / cosine;
}

/* The chain that light sampling finds to a target on a light, and its density; 0: none is found, or the light is not
 * small. chosen: probability of the light. mode: of the ray that ends there. */
TY_FN float ty_manifold_emitter_chain(ty_path* path, const ty_manifold_vertex* vertex, const ty_light_view* light,
                                      float chosen, const ty_manifold_target* target, int32_t mode, ty_vec* direction,
                                      ty_refracted_ray* ray) {
    const float straight = ty_manifold_straight_pdf(light, vertex->origin, target);
    if (!(chosen * straight > TY_MANIFOLD_DENSITY_MIN)) return 0.0f;
    if (!ty_manifold_find(path, vertex, target, direction, ray) ||
        !ty_manifold_trace(path, vertex, target, *direction, mode, ray))
        return 0.0f;
    if (!target->distant && light->kind != TY_KIND_SPHERE && !(ty_light_facing(light, ray->direction) > 0.0f))
        return 0.0f;
    return chosen * ty_manifold_pdf(light, vertex->origin, target, straight, ray);
}

/* MIS weight of emission that a path meets behind smooth interfaces, against light sampling from the vertex before
 * them. */
TY_FN_CALLED float ty_manifold_mis_weight_emission(ty_path* path, int32_t light, const ty_manifold_target* target) {
    const ty_light_set* lights = &path->request->scene->lights;
    const ty_manifold_vertex* vertex = &path->vertex;
    const ty_light_lobe* lobe = vertex->lobe.weight > 0.0f ? &vertex->lobe : NULL;
    const float chosen = target->distant ? lights->lights[light].chosen
                                         : ty_lights_probability(lights, light, vertex->origin, vertex->normal, lobe);
    ty_vec direction;
    ty_refracted_ray ray;
    const float density = ty_manifold_emitter_chain(path, vertex, &lights->lights[light], chosen, target,
                                                    TY_MANIFOLD_SEE, &direction, &ray);
    if (!(density > 0.0f) || !ty_manifold_is_same(&ray, direction, vertex->direction)) return 1.0f;
    const float own = vertex->pdf * ray.chance;
    return own / (own + density);
}

#endif
