/* One path from a receiver over surfaces, through media whose light is known in cells. */
#ifndef TY_BAKE_CACHED_K_H
#define TY_BAKE_CACHED_K_H

#include "bake/cache_look.k.h"
#include "bake/gather.k.h"

/* What the media along one ray of a path send back to where it began. */
typedef struct ty_cached_fog {
    float glow[3];
    float once[3], rest[3]; /* scattered: light straight from lights, and other */
} ty_cached_fog;

/* What a point of the media sends, in the place of all of them. */
TY_FN void ty_cached_fog_at(ty_gather* g, const ty_fog_point* point, ty_cached_fog* fog) {
    const ty_bake_request* request = g->request;
    const ty_scene_view* scene = request->path.scene;
    const ty_path* path = &g->path;
    float weight[3], left[3], albedo[3], turn[3], once[3], rest[3];
    const float t = ty_fog_point_place(point, weight, left);
    const ty_vec at = ty_mad(path->origin, path->direction, t);
    if (scene->medium_count > 1) {
        ty_segment before;
        before.point = NULL;
        ty_segment_find(&before, scene->media, scene->medium_count, path->origin, path->direction, t);
        for (int c = 0; c < 3; ++c) weight[c] *= left[c] > 0.0f ? before.transmittance[c] / left[c] : 0.0f;
    }
    ty_medium_albedo(point->medium, at, albedo);
    if (point->medium->emits != 0) {
        ty_medium_emission(point->medium, at, fog->glow);
        for (int c = 0; c < 3; ++c) fog->glow[c] *= weight[c] * (1.0f - albedo[c]);
    }
    if (request->cache.light == NULL) return;
    const float* light = ty_cache_look(&request->cache, scene->mesh, at, &g->path.random);
    ty_medium_g(point->medium, at, turn);
    ty_cache_scatter(&request->cache, light, path->direction, turn, once);
    ty_cache_scatter(&request->cache, light + request->cache.floats, path->direction, turn, rest);
    for (int c = 0; c < 3; ++c) {
        fog->once[c] = weight[c] * albedo[c] * once[c];
        fog->rest[c] = weight[c] * albedo[c] * rest[c];
    }
}

/* The path's ray to its end (false where it meets no surface), and the media on it, at the place that u picks. */
TY_FN bool ty_cached_trace(ty_gather* g, float u, ty_encounter* end, ty_segment* segment, ty_cached_fog* fog) {
    const ty_scene_view* scene = g->request->path.scene;
    ty_path* path = &g->path;
    ty_fog_point point = ty_fog_point_begin(u, &path->random);
    ++g->rays;
    const bool hit =
        scene->mesh != NULL && ty_mesh_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    if (hit) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    segment->point = &point;
    ty_segment_find(segment, scene->media, scene->medium_count, path->origin, path->direction,
                    hit ? end->hit.distance : TY_FLOAT_MAX);
    memset(fog, 0, sizeof *fog);
    if (point.medium != NULL) ty_cached_fog_at(g, &point, fog);
    return hit;
}

/* Light that comes straight along the path's ray from its end, on a surface or beyond all (NULL). */
TY_FN void ty_cached_meet(const ty_gather* g, const ty_encounter* end, float radiance[3]) {
    if (end == NULL) {
        ty_gather_sky(g, true, radiance);
        return;
    }
    const bool glows = ty_max3(end->point.emission) > 0.0f;
    const float weight = glows ? ty_path_met_weight(&g->path, end) : 0.0f;
    for (int c = 0; c < 3; ++c) radiance[c] = end->point.emission[c] * weight;
}

/* Radiance that leaves a surface: of light that only surfaces reflected, and of all. */
typedef struct ty_leaving {
    float clear[3], all[3];
} ty_leaving;

/* Follows the path from the surface at *start, which it has just reached: radiance that leaves it. */
TY_FN void ty_cached_follow(ty_gather* g, const ty_encounter* start, ty_leaving* out) {
    ty_path* path = &g->path;
    const int32_t most = path->request->max_depth;
    ty_encounter end = *start;
    ty_segment segment;
    ty_seen_light seen;
    ty_cached_fog fog;
    float met[3];
    memset(out, 0, sizeof *out);
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f;
    path->survival = 1.0f;
    path->depth = 0;
    while (ty_max3(end.point.albedo) > 0.0f && (most == 0 || path->depth < most)) {
        path->origin = ty_hit_leave(&end.hit, end.point.facing);
        path->normal = end.point.normal;
        ++path->depth;
        const float before = ty_sum3(path->beta);
        for (int c = 0; c < 3; ++c) path->beta[c] *= end.point.albedo[c];
        if (ty_gather_see_light(g, end.point.facing, &seen))
            for (int c = 0; c < 3; ++c) {
                const float light = path->beta[c] * (1.0f / TY_PI) * seen.sample.radiance[c] * seen.weight *
                                    seen.cosine * seen.segment.transmittance[c];
                out->clear[c] += light;
                out->all[c] += light;
            }
        path->survival *= ty_max3(end.point.albedo);
        ty_path_turn(path);
        if (!(ty_dot(end.point.facing, path->direction) > 0.0f)) return;
        const bool hit = ty_cached_trace(g, ty_random_white(&path->random), &end, &segment, &fog);
        ty_cached_meet(g, hit ? &end : NULL, met);
        for (int c = 0; c < 3; ++c) {
            const float sent = fog.glow[c] + segment.transmittance[c] * met[c];
            out->clear[c] += path->beta[c] * sent;
            out->all[c] += path->beta[c] * (sent + fog.once[c] + fog.rest[c]);
            path->beta[c] *= segment.transmittance[c];
        }
        if (!hit || !ty_path_survives(path, before)) return;
    }
}

/* Evenly spread over [0, 1) for successive samples: multiples of the golden ratio. */
TY_FN float ty_cached_stratum(uint64_t item, uint32_t number) {
    return ty_unit_float((uint32_t)ty_mix64(item + 0x51ed270b7f0a92c5u) + number * 0x9e3779b9u);
}

/* One sample of a receiver; true where its ray met the back of a surface. */
TY_FN bool ty_cached_sample(ty_gather* g, uint64_t item, uint32_t number) {
    ty_path* path = &g->path;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    float basis[TY_BAKE_TERMS_MAX], part[3];
    ty_encounter end;
    ty_segment segment;
    ty_seen_light seen;
    ty_cached_fog fog;
    ty_leaving leaving;
    ty_path_begin(path, &g->request->path, item, number);
    path->origin = ty_mad(g->position, g->face, g->receiver->margin);
    path->normal = g->normal;
    if (ty_gather_see_light(g, g->face, &seen)) {
        ty_gather_basis(g, seen.sample.look, basis);
        for (int c = 0; c < 3; ++c) part[c] = seen.sample.radiance[c] * seen.weight * seen.segment.transmittance[c];
        ty_gather_keep_all(g, TY_BAKE_DIRECT, part, basis);
    }
    if (probe)
        ty_path_turn_anywhere(path);
    else
        ty_path_turn(path);
    if (!probe && !(ty_dot(g->face, path->direction) > 0.0f)) return false;
    const float weight = 1.0f / path->pdf;
    ty_gather_basis(g, path->direction, basis);
    const bool hit = ty_cached_trace(g, ty_cached_stratum(item, number), &end, &segment, &fog);
    ty_cached_meet(g, hit ? &end : NULL, part);
    for (int c = 0; c < 3; ++c) {
        part[c] = weight * (segment.transmittance[c] * part[c] + fog.glow[c]);
        fog.once[c] *= weight;
        fog.rest[c] *= weight;
    }
    ty_gather_keep_all(g, TY_BAKE_DIRECT, part, basis);
    ty_gather_keep_all(g, TY_BAKE_SINGLE, fog.once, basis);
    if (!hit) {
        ty_gather_keep_all(g, TY_BAKE_MULTIPLE, fog.rest, basis);
        return false;
    }
    const bool blocked = ty_dot(end.hit.normal, path->direction) > 0.0f;
    ty_cached_follow(g, &end, &leaving);
    for (int c = 0; c < 3; ++c) {
        const float passing = weight * segment.transmittance[c];
        part[c] = passing * leaving.clear[c];
        fog.rest[c] += passing * (leaving.all[c] - leaving.clear[c]);
    }
    ty_gather_keep_all(g, TY_BAKE_INDIRECT, part, basis);
    ty_gather_keep_all(g, TY_BAKE_MULTIPLE, fog.rest, basis);
    return blocked;
}

#endif
