/* Paths from a receiver over surfaces, through media that only take from light. docs/bake.md explains it. */
#ifndef TY_BAKE_GATHER_K_H
#define TY_BAKE_GATHER_K_H

#include "base/sh.k.h"
#include "bake/kernel.h"
#include "bake/segment.k.h"
#include "method/path/path.k.h"

/* Cosines to a surface's normal below which light counts less in the vector irradiance along the surface. */
#define TY_LEAST_GRAZING 0.02f

/* A light that a point sees, and the media in between. weight: of its light that goes straight to the point, which may
 * take that direction itself, with density cosine / pi (surfaces) or evenly (probes). */
typedef struct ty_seen_light {
    const ty_light_view* light;
    ty_light_sample sample;
    ty_segment segment;
    float chosen, weight, cosine;
} ty_seen_light;

typedef struct ty_gather {
    const ty_bake_request* request;
    const ty_bake_receiver* receiver;
    ty_vec position, normal, face; /* of the receiver; normal 0: a probe */
    ty_vec from;                   /* where its rays start */
    ty_vec off;                    /* off the surface: what looks at what is beside or behind it */
    double* light;                 /* layers x 3 x terms */
    float sample[3];               /* of this sample: all layers' first terms */
    ty_bake_sums* sums;
    ty_vec way;           /* this sample's ray, */
    float far;            /* which sees as far as this, m */
    const float* chances; /* of senders: cumulative, of this receiver */
    uint64_t rays;
    float glow[3]; /* of media along the path's last ray, per throughput at its origin */
    ty_path path;
} ty_gather;

/* ---- what is kept ---- */

/* What a receiver keeps of light from a direction. */
TY_FN void ty_gather_basis(const ty_gather* g, ty_vec from, float basis[TY_BAKE_TERMS_MAX]) {
    if (g->request->terms == TY_BAKE_SH_TERMS) {
        ty_sh_all(from, basis);
        return;
    }
    /* Rays that graze are few, and each would weigh much: the last hundredth of what comes along the surface is left
     * out, and half the noise of it. */
    const float cosine = ty_dot(g->normal, from), kept = ty_minf(1.0f, cosine * (1.0f / TY_LEAST_GRAZING));
    const ty_vec vector = ty_mad(ty_scale(from, kept), g->normal, cosine * (1.0f - kept));
    basis[0] = cosine;
    basis[1] = vector.x;
    basis[2] = vector.y;
    basis[3] = vector.z;
}

TY_FN void ty_gather_keep(ty_gather* g, int32_t layer, int32_t channel, float amount, const float* basis) {
    const int32_t terms = g->request->terms;
    double* light = g->light + (layer * 3 + channel) * terms;
    for (int32_t t = 0; t < terms; ++t) light[t] += (double)(amount * basis[t]);
    g->sample[channel] += amount * basis[0];
}

/* Radiance times solid angle that arrives from a direction. */
TY_FN void ty_gather_keep_all(ty_gather* g, int32_t layer, const float amount[3], const float* basis) {
    for (int c = 0; c < 3; ++c)
        if (amount[c] != 0.0f) ty_gather_keep(g, layer, c, amount[c], basis);
}

/* ---- segments ---- */

TY_FN void ty_gather_segment(const ty_gather* g, ty_vec from, ty_vec direction, float far, ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    segment->point = NULL;
    ty_segment_find(segment, scene->media, scene->medium_count, from, direction, far);
}

/* Where along the path's ray a point of the media is; what goes with it: what light from there, in the place of all,
 * weighs, up to the share that it was scattered, or sent, with. */
TY_FN ty_vec ty_gather_fog_place(const ty_gather* g, const ty_fog_point* point, float weight[3], float albedo[3]) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_path* path = &g->path;
    float left[3];
    const float t = ty_fog_point_place(point, weight, left);
    const ty_vec at = ty_mad(path->origin, path->direction, t);
    if (scene->medium_count > 1) {
        ty_segment before;
        before.point = NULL;
        ty_segment_find(&before, scene->media, scene->medium_count, path->origin, path->direction, t);
        for (int c = 0; c < 3; ++c) weight[c] *= left[c] > 0.0f ? before.transmittance[c] / left[c] : 0.0f;
    }
    ty_medium_albedo(point->medium, at, albedo);
    return at;
}

/* The path's ray to its end, and the media on it, which segment->point is offered; false where it meets no surface. */
TY_FN bool ty_gather_find_end(ty_gather* g, ty_encounter* end, ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_path* path = &g->path;
    ++g->rays;
    const bool hit =
        scene->mesh != NULL && ty_mesh_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    if (hit) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    ty_segment_find(segment, scene->media, scene->medium_count, path->origin, path->direction,
                    hit ? end->hit.distance : TY_FLOAT_MAX);
    return hit;
}

/* The same, and what glows on the way. */
TY_FN bool ty_gather_trace(ty_gather* g, ty_encounter* end, ty_segment* segment) {
    float weight[3], albedo[3];
    segment->point = NULL;
    if (g->request->glows == 0) return ty_gather_find_end(g, end, segment);
    ty_fog_point point = ty_fog_point_begin(ty_random_white(&g->path.random), &g->path.random);
    segment->point = &point;
    const bool hit = ty_gather_find_end(g, end, segment);
    for (int c = 0; c < 3; ++c) g->glow[c] = 0.0f;
    if (point.medium == NULL || point.medium->emits == 0) return hit;
    const ty_vec at = ty_gather_fog_place(g, &point, weight, albedo);
    ty_medium_emission(point.medium, at, g->glow);
    for (int c = 0; c < 3; ++c) g->glow[c] *= weight[c] * (1.0f - albedo[c]);
    return hit;
}

TY_FN bool ty_gather_see_light(ty_gather* g, ty_vec facing, ty_seen_light* seen) {
    ty_path* path = &g->path;
    seen->light = ty_path_choose_light(path, path->origin, &seen->chosen, &seen->sample);
    if (seen->light == NULL) return false;
    const bool probe = ty_dot(path->normal, path->normal) == 0.0f;
    seen->cosine = probe ? 1.0f : ty_dot(path->normal, seen->sample.look);
    if (!probe && (!(seen->cosine > 0.0f) || !(ty_dot(facing, seen->sample.look) > 0.0f))) return false;
    ++g->rays;
    if (!ty_path_sees(path, path->origin, &seen->sample)) return false;
    const float pdf = probe ? TY_INV_4PI : seen->cosine * (1.0f / TY_PI), own = seen->sample.pdf;
    seen->weight = own > 0.0f ? own / (seen->chosen * own + pdf) : 1.0f / seen->chosen;
    ty_gather_segment(g, path->origin, seen->sample.look, seen->sample.distance, &seen->segment);
    return true;
}

/* ---- paths over surfaces ---- */

/* Environments beyond the path's last ray. found: of light that is sampled, too, what is left to the ray; weigh_found
 * false: all of what is never sampled, and nothing else. */
TY_FN void ty_gather_sky(const ty_gather* g, bool sampled, float radiance[3]) {
    const ty_light_set* lights = &g->request->path.scene->lights;
    const ty_path* path = &g->path;
    float sends[3];
    for (int c = 0; c < 3; ++c) radiance[c] = 0.0f;
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        const ty_light_view* light = &lights->lights[lights->distant[i]];
        if (light->kind != TY_KIND_ENVIRONMENT || (!sampled && light->chosen > 0.0f)) continue;
        float weight = 1.0f;
        if (light->chosen > 0.0f)
            weight = path->pdf / (path->pdf + light->chosen * ty_environment_pdf(&light->environment, path->direction));
        ty_environment_radiance(&light->environment, path->direction, sends);
        for (int c = 0; c < 3; ++c) radiance[c] += sends[c] * weight;
    }
}

/* What one light sends over a surface point. */
TY_FN void ty_gather_reflect_light(ty_gather* g, const ty_encounter* at, float out[3]) {
    ty_seen_light seen;
    if (!ty_gather_see_light(g, at->point.facing, &seen)) return;
    for (int c = 0; c < 3; ++c)
        out[c] += g->path.beta[c] * at->point.albedo[c] * (1.0f / TY_PI) * seen.sample.radiance[c] * seen.weight *
                  seen.cosine * seen.segment.transmittance[c];
}

/* Light that the path's ray meets, on a surface (end) or beyond all (NULL), and on the way. */
TY_FN void ty_gather_meet(const ty_gather* g, const ty_encounter* end, const ty_segment* segment, float out[3]) {
    float radiance[3] = {0.0f, 0.0f, 0.0f};
    if (end == NULL)
        ty_gather_sky(g, true, radiance);
    else if (ty_max3(end->point.emission) > 0.0f) {
        const float weight = ty_path_met_weight(&g->path, end);
        for (int c = 0; c < 3; ++c) radiance[c] = end->point.emission[c] * weight;
    }
    for (int c = 0; c < 3; ++c) out[c] += g->path.beta[c] * (segment->transmittance[c] * radiance[c] + g->glow[c]);
}

/* Radiance that a surface reflects of light that media only took from: the path goes on from there. */
TY_FN void ty_gather_follow(ty_gather* g, const ty_encounter* start, float out[3]) {
    ty_path* path = &g->path;
    const int32_t most = path->request->max_depth;
    ty_encounter end = *start;
    ty_segment segment;
    for (int c = 0; c < 3; ++c) out[c] = 0.0f;
    path->survival = 1.0f;
    path->depth = 0;
    while (ty_max3(end.point.albedo) > 0.0f && (most == 0 || path->depth < most)) {
        path->origin = ty_hit_leave(&end.hit, end.point.facing);
        path->normal = end.point.normal;
        ++path->depth;
        ty_gather_reflect_light(g, &end, out);
        for (int c = 0; c < 3; ++c) path->beta[c] *= end.point.albedo[c];
        const float before = ty_sum3(path->beta); /* survival knows of albedo by itself */
        path->survival *= ty_max3(end.point.albedo);
        ty_path_turn(path);
        if (!(ty_dot(end.point.facing, path->direction) > 0.0f)) return;
        const bool hit = ty_gather_trace(g, &end, &segment);
        ty_gather_meet(g, hit ? &end : NULL, &segment, out);
        for (int c = 0; c < 3; ++c) path->beta[c] *= segment.transmittance[c];
        if (!hit || !ty_path_survives(path, before)) return;
    }
}

/* ---- at the receiver ---- */

TY_FN void ty_gather_stand(ty_gather* g, const ty_bake_receiver* receiver) {
    g->receiver = receiver;
    g->position = ty_vec_load(receiver->position);
    g->normal = ty_vec_load(receiver->normal);
    g->face = ty_vec_load(receiver->face);
    g->from = ty_mad(g->position, g->face, receiver->margin);
}

#endif
