/* Paths from a receiver over surfaces, through media that only attenuate light. docs/bake.md explains the method. */
#ifndef TY_BAKE_GATHER_GATHER_K_H
#define TY_BAKE_GATHER_GATHER_K_H

#include "base/sh.k.h"
#include "bake/gather/request.h"
#include "bake/gather/segment.k.h"
#include "bake/gather/transparent.k.h"
#include "method/path/trace/path.k.h"

/* Cosine to the normal below which light is damped in the tangential vector irradiance. */
#define TY_GRAZING_COSINE 0.02f

/* A visible light sample, and the media in between. weight: MIS weight of the light sample against directions of
 * density cosine / pi (surfaces) or 1 / (4 pi) (probes). */
typedef struct ty_visible_light {
    const ty_light_view* light;
    ty_light_sample sample;
    ty_segment segment;
    float chosen, weight, cosine;
} ty_visible_light;

typedef struct ty_gather {
    const ty_bake_request* request;
    const ty_bake_receiver* receiver;
    ty_vec position, normal, face; /* of the receiver; normal 0: a probe */
    ty_vec origin;                 /* origin of its rays */
    ty_vec offset_origin;          /* point off the surface, for visibility of emitters beside or behind it */
    double* light;                 /* layers x 3 channels x terms */
    float sample[3];               /* of this sample: first term summed over layers */
    ty_bake_sums* sums;
    ty_vec direction;         /* direction of this sample's ray, */
    float max_distance;       /* and its length, m */
    float emitter, collision; /* uniform in [0, 1): choose a virtual emitter, and a collision on a ray */
    const float* emitter_cdf; /* cumulative selection weights of the virtual emitters for this receiver */
    uint64_t rays;
    ty_interior_list around, inside; /* dielectrics around the receiver, and around the origin of the path's ray */
    float enclosed[3]; /* radiance that media in dielectrics scatter to the path's last ray, as `emission` */
    float emission[3]; /* radiance emitted by media along the path's last ray, per throughput at its origin */
    ty_path path;
} ty_gather;

/* ---- accumulation ---- */

/* Basis functions of a receiver at a direction of incidence. */
TY_FN void ty_gather_basis(const ty_gather* g, ty_vec from, float basis[TY_BAKE_TERMS_MAX]) {
    if (g->request->terms == TY_BAKE_SH_TERMS) {
        ty_sh_all(from, basis);
        return;
    }
    /* Grazing rays are rare and would carry large weights: omitting the last hundredth of the tangential component
     * removes half of its noise. */
    const float cosine = ty_dot(g->normal, from), damping = ty_minf(1.0f, cosine * (1.0f / TY_GRAZING_COSINE));
    const ty_vec vector = ty_mad(ty_scale(from, damping), g->normal, cosine * (1.0f - damping));
    basis[0] = cosine;
    basis[1] = vector.x;
    basis[2] = vector.y;
    basis[3] = vector.z;
}

TY_FN void ty_gather_add(ty_gather* g, int32_t layer, int32_t channel, float amount, const float* basis) {
    const int32_t terms = g->request->terms;
    double* light = g->light + (layer * 3 + channel) * terms;
    for (int32_t t = 0; t < terms; ++t) light[t] += (double)(amount * basis[t]);
    g->sample[channel] += amount * basis[0];
}

/* Adds radiance times solid angle from a direction. */
TY_FN void ty_gather_add_rgb(ty_gather* g, int32_t layer, const float amount[3], const float* basis) {
    for (int c = 0; c < 3; ++c)
        if (amount[c] != 0.0f) ty_gather_add(g, layer, c, amount[c], basis);
}

/* ---- segments ---- */

TY_FN void ty_gather_segment(const ty_gather* g, ty_vec from, ty_vec direction, float max_distance,
                             ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    segment->point = NULL;
    ty_segment_find(segment, scene->media, scene->medium_count, from, direction, max_distance);
}

/* Position of a media sample point on the path's ray. weight: its sample weight including the other media, without the
 * albedo, which is returned too. */
TY_FN ty_vec ty_gather_fog_position(const ty_gather* g, const ty_fog_point* point, float weight[3], float albedo[3]) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_path* path = &g->path;
    float transmitted[3];
    const float t = ty_fog_point_sample_distance(point, weight, transmitted);
    const ty_vec at = ty_mad(path->origin, path->direction, t);
    if (scene->medium_count > 1) {
        ty_segment before;
        before.point = NULL;
        ty_segment_find(&before, scene->media, scene->medium_count, path->origin, path->direction, t);
        for (int c = 0; c < 3; ++c)
            weight[c] *= transmitted[c] > 0.0f ? before.transmittance[c] / transmitted[c] : 0.0f;
    }
    ty_medium_albedo(point->medium, at, albedo);
    return at;
}

/* Traces the path's ray through glass to where it ends. */
TY_FN bool ty_gather_pass_to_end(ty_gather* g, ty_intersection* end, ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    ty_path* path = &g->path;
    ty_transparent_ray ray;
    ty_transparent_begin(&ray, scene, path->request->enclosed, &g->inside);
    const bool hit = ty_transparent_trace(&ray, path->origin, path->direction, &path->random, end);
    ty_segment_find(segment, scene->media, scene->medium_count, path->origin, path->direction,
                    hit ? end->hit.distance : TY_FLOAT_MAX);
    for (int c = 0; c < 3; ++c) {
        segment->transmittance[c] *= ray.passed[c];
        g->enclosed[c] = ray.scattered[c];
    }
    g->inside = ray.inside;
    return hit;
}

/* Traces the path's ray; segment->point samples the media along it. False: it hits no surface. */
TY_FN bool ty_gather_find_end(ty_gather* g, ty_intersection* end, ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_path* path = &g->path;
    ++g->rays;
    if (g->request->transparent != 0) return ty_gather_pass_to_end(g, end, segment);
    const bool hit =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    if (hit) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    ty_segment_find(segment, scene->media, scene->medium_count, path->origin, path->direction,
                    hit ? end->hit.distance : TY_FLOAT_MAX);
    return hit;
}

/* Traces the path's ray, including emission of the media along it. */
TY_FN bool ty_gather_trace(ty_gather* g, ty_intersection* end, ty_segment* segment) {
    float weight[3], albedo[3];
    segment->point = NULL;
    if (g->request->media_emit == 0) return ty_gather_find_end(g, end, segment);
    ty_fog_point point = ty_fog_point_begin(ty_rng_uniform(&g->path.random), &g->path.random);
    segment->point = &point;
    const bool hit = ty_gather_find_end(g, end, segment);
    for (int c = 0; c < 3; ++c) g->emission[c] = 0.0f;
    if (point.medium == NULL || point.medium->emits == 0) return hit;
    const ty_vec at = ty_gather_fog_position(g, &point, weight, albedo);
    ty_medium_emission(point.medium, at, g->emission);
    for (int c = 0; c < 3; ++c) g->emission[c] *= weight[c] * (1.0f - albedo[c]);
    return hit;
}

TY_FN bool ty_gather_sample_light(ty_gather* g, ty_vec ng, ty_visible_light* visible) {
    ty_path* path = &g->path;
    visible->light = ty_path_choose_light(path, path->origin, &visible->chosen, &visible->sample);
    if (visible->light == NULL) return false;
    const bool probe = ty_dot(path->normal, path->normal) == 0.0f;
    visible->cosine = probe ? 1.0f : ty_dot(path->normal, visible->sample.wi);
    if (!probe && (!(visible->cosine > 0.0f) || !(ty_dot(ng, visible->sample.wi) > 0.0f))) return false;
    ++g->rays;
    ty_transparent_ray ray;
    if (g->request->transparent != 0) {
        ty_transparent_begin(&ray, path->request->scene, path->request->enclosed, &g->inside);
        if (!ty_transparent_passes(&ray, path->origin, visible->sample.wi, visible->sample.distance)) return false;
    } else if (!ty_path_light_visible(path, path->origin, &visible->sample))
        return false;
    const float pdf = probe ? TY_INV_4PI : visible->cosine * (1.0f / TY_PI), light_pdf = visible->sample.pdf;
    visible->weight = light_pdf > 0.0f ? light_pdf / (visible->chosen * light_pdf + pdf) : 1.0f / visible->chosen;
    ty_gather_segment(g, path->origin, visible->sample.wi, visible->sample.distance, &visible->segment);
    for (int c = 0; c < 3 && g->request->transparent != 0; ++c) visible->segment.transmittance[c] *= ray.passed[c];
    return true;
}

/* ---- paths over surfaces ---- */

/* Radiance of environments beyond the path's last ray. sampled: of lights that are also sampled, with the MIS weight of
 * the ray; otherwise only of lights that are never sampled. */
TY_FN void ty_gather_environment(const ty_gather* g, bool sampled, float radiance[3]) {
    const ty_light_set* lights = &g->request->path.scene->lights;
    const ty_path* path = &g->path;
    float emitted[3];
    for (int c = 0; c < 3; ++c) radiance[c] = 0.0f;
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        const ty_light_view* light = &lights->lights[lights->distant[i]];
        if (light->kind != TY_KIND_ENVIRONMENT || (!sampled && light->chosen > 0.0f)) continue;
        float weight = 1.0f;
        if (light->chosen > 0.0f)
            weight = path->pdf / (path->pdf + light->chosen * ty_environment_pdf(&light->environment, path->direction));
        ty_environment_radiance(&light->environment, path->direction, emitted);
        for (int c = 0; c < 3; ++c) radiance[c] += emitted[c] * weight;
    }
}

/* Adds the light of one light sample reflected by a surface point. */
TY_FN void ty_gather_reflect_light(ty_gather* g, const ty_intersection* at, float out[3]) {
    ty_visible_light visible;
    if (!ty_gather_sample_light(g, at->point.ng, &visible)) return;
    for (int c = 0; c < 3; ++c)
        out[c] += g->path.beta[c] * at->point.albedo[c] * (1.0f / TY_PI) * visible.sample.radiance[c] * visible.weight *
                  visible.cosine * visible.segment.transmittance[c];
}

/* Adds the emission found by the path's ray: on a surface (end) or in the environment (end NULL), and in the media
 * along it. */
TY_FN void ty_gather_add_hit(const ty_gather* g, const ty_intersection* end, const ty_segment* segment, float out[3]) {
    float radiance[3] = {0.0f, 0.0f, 0.0f};
    if (end == NULL)
        ty_gather_environment(g, true, radiance);
    else if (ty_max3(end->point.emission) > 0.0f) {
        const float weight = ty_path_mis_weight_emission(&g->path, end);
        for (int c = 0; c < 3; ++c) radiance[c] = end->point.emission[c] * weight;
    }
    for (int c = 0; c < 3; ++c) out[c] += g->path.beta[c] * (segment->transmittance[c] * radiance[c] + g->emission[c]);
}

/* Radiance reflected by a surface, of light that media only attenuated: continues the path from there. scattered: that
 * of light which media in dielectrics scattered. */
TY_FN void ty_gather_follow(ty_gather* g, const ty_intersection* start, float out[3], float scattered[3]) {
    ty_path* path = &g->path;
    const int32_t max_depth = path->request->max_depth;
    ty_intersection end = *start;
    ty_segment segment;
    for (int c = 0; c < 3; ++c) out[c] = scattered[c] = 0.0f;
    path->rr_throughput = 1.0f;
    path->depth = 0;
    while (ty_max3(end.point.albedo) > 0.0f && (max_depth == 0 || path->depth < max_depth)) {
        path->origin = ty_hit_leave(&end.hit, end.point.ng);
        path->normal = end.point.ns;
        ++path->depth;
        ty_gather_reflect_light(g, &end, out);
        for (int c = 0; c < 3; ++c) path->beta[c] *= end.point.albedo[c];
        const float before = ty_sum3(path->beta); /* survival accounts for the albedo separately */
        path->rr_throughput *= ty_max3(end.point.albedo);
        ty_path_sample_cosine_hemisphere(path);
        if (!(ty_dot(end.point.ng, path->direction) > 0.0f)) return;
        const bool hit = ty_gather_trace(g, &end, &segment);
        ty_gather_add_hit(g, hit ? &end : NULL, &segment, out);
        for (int c = 0; c < 3; ++c) {
            scattered[c] += path->beta[c] * g->enclosed[c];
            path->beta[c] *= segment.transmittance[c];
        }
        if (!hit || !ty_path_survives(path, before)) return;
    }
}

/* ---- at the receiver ---- */

/* Samples the path's direction at the receiver: over the sphere at a probe, else by the cosine about the normal. False:
 * it is behind the receiver's face. */
TY_FN bool ty_gather_sample_direction(ty_gather* g) {
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    if (probe)
        ty_path_sample_sphere(&g->path);
    else
        ty_path_sample_cosine_hemisphere(&g->path);
    return probe || ty_dot(g->face, g->path.direction) > 0.0f;
}

TY_FN void ty_gather_set_receiver(ty_gather* g, const ty_bake_receiver* receiver) {
    g->receiver = receiver;
    g->position = ty_vec_load(receiver->position);
    g->normal = ty_vec_load(receiver->normal);
    g->face = ty_vec_load(receiver->face);
    g->origin = ty_mad(g->position, g->face, receiver->margin);
    g->around.top = g->around.count = 0;
    if (g->request->transparent != 0 && g->request->path.scene->interior_count > 0)
        ty_interiors_around(g->request->path.scene, g->origin, &g->around);
    g->inside = g->around;
}

#endif
