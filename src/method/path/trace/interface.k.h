/* Paths at interfaces of solid dielectrics: nested interiors, light through interfaces that do not deflect it,
 * reflection and refraction. Refraction keeps L / n^2: BSDFs have no factor for it, and throughput takes the ratio of
 * n^2 where a path crosses. */
#ifndef TY_METHOD_PATH_TRACE_INTERFACE_K_H
#define TY_METHOD_PATH_TRACE_INTERFACE_K_H

#include "direct/media/transmittance.k.h"
#include "method/path/trace/light_path.k.h"
#include "scene/bsdf/dielectric.k.h"
#include "scene/interiors.h"

/* Defined as 0, it makes glossy surfaces diffuse ones of their directional albedo, in less code; dielectrics, too. */
#ifndef TY_PATH_GLOSS
#define TY_PATH_GLOSS 1
#endif

/* Interfaces that a shadow ray passes at most. */
enum { TY_SHADOW_INTERFACES_MAX = 64 };

/* In path.k.h. */
TY_FN int32_t ty_path_sample_light(ty_path* path, ty_vec from, float* chosen, ty_light_sample* sample, bool* shines);
TY_FN void ty_path_add_vertex_light(ty_path* path, const ty_light_view* light, float chosen,
                                    const ty_light_sample* sample, const float factor[3], float pdf, float phase);
TY_FN void ty_path_reflect_gloss(ty_path* path, const ty_intersection* at);

TY_FN bool ty_path_sees_dielectrics(const ty_path* path) {
    return TY_PATH_GLOSS != 0 && path->request->scene->interior_count > 0;
}

/* ---- interiors ---- */

/* Where a scene has interiors, those without media of the scene may be requested, which leaves the first one. */
TY_FN int32_t ty_path_medium_count(const ty_path* path, const ty_interior* interior) {
    return path->request->scene->medium_count > 0 ? interior->medium_count : interior->absorbs;
}

/* Radiance here that light of radiance 1 in another interior becomes by refraction alone: the ratio of n^2. */
TY_FN float ty_path_radiance_ratio(const ty_path* path, int32_t there) {
    const ty_interior* interiors = path->request->scene->interiors;
    const float ratio = interiors[path->inside.top].ior / interiors[there].ior;
    return ratio * ratio;
}

TY_FN void ty_path_set_inside(ty_path* path, const ty_interior_list* inside) {
    const ty_interior* interior = &path->request->scene->interiors[inside->top];
    path->inside = *inside;
    path->media = interior->media;
    path->medium_count = ty_path_medium_count(path, interior);
}

/* Starts a path in the dielectrics around its origin. */
TY_FN void ty_path_begin_inside(ty_path* path) {
    if (!ty_path_sees_dielectrics(path)) return;
    ty_interior_list inside;
    ty_interiors_around(path->request->scene, path->origin, &inside);
    ty_path_set_inside(path, &inside);
}

/* True if nothing around the path scatters or emits, so that its light needs no collisions to be sampled. */
TY_FN bool ty_path_only_absorbs(const ty_path* path) {
    return ty_path_sees_dielectrics(path) && path->request->scene->interiors[path->inside.top].scatters == 0;
}

/* Solved light of the medium around the path; NULL: none. */
TY_FN const ty_enclosed_field* ty_path_enclosed_field(const ty_path* path) {
    if (!ty_path_sees_dielectrics(path) || path->request->enclosed == NULL) return NULL;
    const ty_enclosed_field* field = &path->request->enclosed[path->inside.top];
    return field->bands > 0 ? field : NULL;
}

/* Adds the known light that scatters towards the path at a collision at distance t. */
TY_FN void ty_path_add_field(ty_path* path, const ty_enclosed_field* field, float t) {
    const int32_t path_class = path->path_class;
    float radiance[3];
    ty_enclosed_radiance(field, ty_mad(path->origin, path->direction, t), ty_scale(path->direction, -1.0f), radiance);
    for (int c = 0; c < 3; ++c) radiance[c] *= path->beta[c];
    path->path_class = ty_path_class_scattered(path_class);
    ty_path_add(path, radiance);
    path->path_class = path_class;
}

/* The interface of dielectrics at a hit of a ray from `inside`. *beyond: the dielectrics behind it. */
TY_FN int32_t ty_interface_find(const ty_scene_view* scene, const ty_interior_list* inside, const ty_hit* hit,
                                ty_vec direction, ty_interior_list* beyond) {
    const ty_surface_gloss* gloss = scene->surfaces[hit->surface].gloss;
    if (gloss == NULL) return TY_INTERFACE_NONE;
    if (gloss->pane != 0) {
        *beyond = *inside;
        return TY_INTERFACE_PANE;
    }
    if (gloss->dielectric.solid == 0) return TY_INTERFACE_NONE;
    *beyond = ty_interior_list_beyond(scene->interiors, inside, gloss->dielectric.interior, hit, direction);
    if (beyond->top == inside->top) return TY_INTERFACE_PASSED;
    const bool clear = gloss->textured == 0 && gloss->factor.transmission >= 1.0f && gloss->factor.metallic <= 0.0f;
    const bool matched = scene->interiors[beyond->top].ior == scene->interiors[inside->top].ior;
    return clear && matched ? TY_INTERFACE_PASSED : TY_INTERFACE_REFRACTS;
}

/* Part of the light that goes straight on at a hit of a ray along direction. */
TY_FN void ty_interface_tint(const ty_scene_view* scene, int32_t interface, const ty_interior_list* inside,
                             const ty_interior_list* beyond, const ty_hit* hit, ty_vec direction, float tint[3]) {
    TY_GLOBAL const ty_surface* surface = &scene->surfaces[hit->surface];
    ty_surface_look look;
    ty_surface_evaluate_color(surface, hit, direction, &look);
    for (int c = 0; c < 3; ++c) tint[c] = beyond->top != inside->top ? look.albedo[c] : 1.0f;
    if (interface != TY_INTERFACE_PANE) return;
    const ty_bsdf_parameters pane = surface->gloss->factor;
    ty_bsdf_pane_transmittance(&pane, look.albedo, fabsf(ty_dot(look.ns, direction)), tint);
}

/* A pane lets the path pass or reflects it, by chance. */
TY_FN void ty_path_meet_pane(ty_path* path, ty_intersection* end) {
    const float passing = ty_max3(end->tint), sum = passing + ty_max3(end->point.bsdf.albedo);
    const float chance = sum > 0.0f ? passing / sum : 0.0f;
    if (ty_sobol_next(&path->random) < chance) {
        end->interface = TY_INTERFACE_PASSED;
        for (int c = 0; c < 3; ++c) end->tint[c] /= chance;
        return;
    }
    ty_bsdf_drop_transmission(&end->point.bsdf);
    for (int c = 0; c < 3; ++c) {
        end->point.albedo[c] = end->point.bsdf.albedo[c];
        end->tint[c] = 1.0f / (1.0f - chance);
    }
}

TY_FN void ty_path_meet_interface(ty_path* path, ty_intersection* end) {
    const ty_scene_view* scene = path->request->scene;
    end->interface = ty_interface_find(scene, &path->inside, &end->hit, path->direction, &end->beyond);
    if (end->interface == TY_INTERFACE_NONE) return;
    if (end->interface != TY_INTERFACE_REFRACTS)
        ty_interface_tint(scene, end->interface, &path->inside, &end->beyond, &end->hit, path->direction, end->tint);
    if (end->interface == TY_INTERFACE_PANE) ty_path_meet_pane(path, end);
    if (end->interface == TY_INTERFACE_PANE) return;
    for (int c = 0; c < 3; ++c) end->point.albedo[c] = 1.0f;
    if (end->interface != TY_INTERFACE_PASSED) return;
    end->point.light = -1;
    for (int c = 0; c < 3; ++c) end->point.emission[c] = 0.0f;
}

/* The path goes on behind an interface that changes no direction. Lamp directions end there. */
TY_FN void ty_path_pass_interface(ty_path* path, const ty_intersection* at) {
    for (int c = 0; c < 3; ++c) path->beta[c] *= at->tint[c];
    path->passed += at->hit.distance;
    path->origin = ty_hit_leave(&at->hit, path->direction);
    path->point_light_rate = 0.0f;
    ty_path_set_inside(path, &at->beyond);
}

/* Part of the light of a sample that arrives at origin through media and interfaces that do not deflect it; 0: nothing.
 */
TY_FN_CALLED void ty_path_light_through(ty_path* path, ty_vec origin, const ty_light_sample* sample, float out[3]) {
    const ty_scene_view* scene = path->request->scene;
    ty_interior_list inside = path->inside, beyond;
    float left = sample->distance;
    for (int c = 0; c < 3; ++c) out[c] = 1.0f;
    for (int32_t i = 0; i < TY_SHADOW_INTERFACES_MAX; ++i) {
        const ty_interior* interior = &scene->interiors[inside.top];
        float transmittance[3];
        ty_hit hit;
        int32_t interface = TY_INTERFACE_NONE;
        const bool hits = ty_accel_intersect(scene->mesh, origin, sample->wi,
                                             left < TY_FLOAT_MAX ? left * 0.9999f : TY_FLOAT_MAX, &hit);
        if (hits) interface = ty_interface_find(scene, &inside, &hit, sample->wi, &beyond);
        if (hits && interface != TY_INTERFACE_PASSED && interface != TY_INTERFACE_PANE) break;
        ty_transmittance(interior->media, ty_path_medium_count(path, interior), origin, sample->wi,
                         hits ? hit.distance : left, &path->random, transmittance);
        for (int c = 0; c < 3; ++c) out[c] *= transmittance[c];
        if (!hits) return;
        float tint[3];
        ty_interface_tint(scene, interface, &inside, &beyond, &hit, sample->wi, tint);
        for (int c = 0; c < 3; ++c) out[c] *= tint[c];
        inside = beyond;
        origin = ty_hit_leave(&hit, sample->wi);
        if (left < TY_FLOAT_MAX) left -= hit.distance;
    }
    for (int c = 0; c < 3; ++c) out[c] = 0.0f;
}

/* ---- reflection and refraction ---- */

/* The path leaves an interface along direction, in the dielectric or medium there. */
TY_FN void ty_path_leave_interface(ty_path* path, const ty_intersection* at, ty_vec direction) {
    path->direction = direction;
    path->origin = ty_hit_leave(&at->hit, direction);
    if (!(ty_dot(at->point.ng, direction) < 0.0f)) return;
    const float ratio = ty_path_radiance_ratio(path, at->beyond.top);
    for (int c = 0; c < 3; ++c) path->beta[c] *= ratio;
    ty_path_set_inside(path, &at->beyond);
}

/* Smooth: one direction by Snell's law or by reflection, with the probability of Fresnel's reflectance. Emission
 * behind it counts in full, unless light sampling finds the same chain (manifold.k.h). */
TY_FN void ty_path_refract_smooth(ty_path* path, const ty_intersection* at, float eta) {
    const ty_surface_point* point = &at->point;
    const ty_vec wo = ty_scale(path->direction, -1.0f), normal = point->bsdf.frame.n;
    const float cosine = ty_clampf(ty_dot(wo, normal), 0.0f, 1.0f);
    const bool reflects = ty_sobol_next(&path->random) < ty_fresnel_dielectric(cosine, eta);
    if (path->vertex.refractions == 0) {
        path->vertex.direction = path->direction;
        path->vertex.pdf = path->pdf;
    }
    path->vertex.refractions = reflects || path->vertex.refractions < 0 ? -1 : path->vertex.refractions + 1;
    ty_vec direction = reflects ? ty_reflect(wo, normal) : ty_refract(wo, normal, eta);
    /* Shading normals may send light to the wrong side of the triangle; it then leaves along the triangle. */
    const float height = ty_dot(point->ng, direction) * (reflects ? 1.0f : -1.0f);
    if (!(height > 0.0f)) direction = ty_mad(direction, point->ng, (reflects ? 1.0f : -1.0f) * (1e-4f - height));
    ty_path_leave_interface(path, at, ty_normalize(direction));
    path->pdf = 0.0f;
    for (int c = 0; c < 3 && !reflects; ++c) path->beta[c] *= point->tint[c];
}

TY_FN void ty_path_refract_rough(ty_path* path, const ty_intersection* at, float eta) {
    const ty_surface_point* point = &at->point;
    ty_rough_dielectric d;
    ty_light_sample sample;
    float factor[3], chosen;
    bool shines;
    path->vertex.refractions = -1;
    ty_rough_dielectric_prepare(&d, point->bsdf.tables, &point->bsdf.frame, ty_scale(path->direction, -1.0f), eta,
                                point->roughness, point->tint, path->request->single_reflection == 0);
    path->origin = at->hit.position;
    const int32_t light = ty_path_sample_light(path, path->origin, &chosen, &sample, &shines);
    const bool same = shines && (ty_dot(point->ng, sample.wi) > 0.0f) == (ty_dot(d.frame.n, sample.wi) > 0.0f);
    const float density = same ? ty_rough_dielectric_evaluate(&d, sample.wi, factor) : 0.0f;
    if (density > 0.0f) {
        const ty_interior_list inside = path->inside;
        const ty_vec direction = path->direction;
        const float beta[3] = {path->beta[0], path->beta[1], path->beta[2]};
        ty_path_leave_interface(path, at, sample.wi);
        ty_path_add_vertex_light(path, &path->request->scene->lights.lights[light], chosen, &sample, factor, density,
                                 0.0f);
        path->direction = direction;
        memcpy(path->beta, beta, sizeof beta);
        ty_path_set_inside(path, &inside);
    }
    const float pick = ty_sobol_next(&path->random);
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    ty_vec direction;
    path->pdf = ty_rough_dielectric_sample(&d, pick, u, v, &direction)
                    ? ty_rough_dielectric_evaluate(&d, direction, factor)
                    : 0.0f;
    const bool kept =
        path->pdf > 0.0f && (ty_dot(point->ng, direction) > 0.0f) == (ty_dot(d.frame.n, direction) > 0.0f);
    for (int c = 0; c < 3; ++c) path->beta[c] *= kept ? factor[c] / path->pdf : 0.0f;
    if (kept) ty_path_leave_interface(path, at, direction);
}

/* A vertex on an interface of dielectrics. The part of it that transmits nothing is chosen by chance. */
TY_FN_CALLED void ty_path_refract(ty_path* path, const ty_intersection* at) {
    const ty_scene_view* scene = path->request->scene;
    const ty_surface_point* point = &at->point;
    if (point->opaque > 0.0f && ty_rng_uniform(&path->random) < point->opaque) {
        ty_path_reflect_gloss(path, at);
        return;
    }
    const float eta = scene->interiors[at->beyond.top].ior / scene->interiors[path->inside.top].ior;
    path->normal = ty_vec_make(0, 0, 0);
    path->lobe.weight = 0.0f;
    path->passed = 0.0f;
    path->point_light_rate = 0.0f;
    if (point->roughness > 0.0f && eta != 1.0f)
        ty_path_refract_rough(path, at, eta);
    else
        ty_path_refract_smooth(path, at, eta);
}

#endif
