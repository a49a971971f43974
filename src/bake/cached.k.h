/* Light of media that is known in cells, as it arrives at receivers: paths over surfaces know nothing of it, and rays
 * of its own gather it. docs/bake.md explains it. */
#ifndef TY_BAKE_CACHED_K_H
#define TY_BAKE_CACHED_K_H

#include "bake/cache_look.k.h"
#include "bake/gather.k.h"

/* What the media along one ray scatter back to where it began: light straight from lights, and other. */
typedef struct ty_cached_fog {
    float once[3], rest[3];
} ty_cached_fog;

/* Places where light in cells is looked up: along a receiver's ray; along the first ray of a walk for a cell's
 * surfaces, which many receivers share, and along its others. */
enum { TY_FOG_PLACES = 4, TY_WALK_PLACES = 16, TY_WALK_PLACES_ON = 4 };

/* What a point of the media sends, in the place of all of them; times share. */
TY_FN void ty_cached_fog_at(ty_gather* g, const ty_fog_point* point, float share, ty_cached_fog* fog) {
    const ty_bake_request* request = g->request;
    float weight[3], albedo[3], turn[3], once[3], rest[3];
    const ty_vec at = ty_gather_fog_place(g, point, weight, albedo);
    const float* light = ty_cache_look(&request->cache, request->path.scene->mesh, at, &g->path.random);
    ty_medium_g(point->medium, at, turn);
    ty_cache_scatter(&request->cache, light, g->path.direction, turn, once);
    ty_cache_scatter(&request->cache, light + request->cache.floats, g->path.direction, turn, rest);
    for (int c = 0; c < 3; ++c) {
        fog->once[c] += share * weight[c] * albedo[c] * once[c];
        fog->rest[c] += share * weight[c] * albedo[c] * rest[c];
    }
}

/* The path's ray to its end (false where it meets no surface), and the media on it, at places that u picks. */
TY_FN bool ty_cached_trace(ty_gather* g, float u, int32_t places, ty_intersection* end, ty_segment* segment,
                           ty_cached_fog* fog) {
    ty_fog_point point = ty_fog_point_begin(u, &g->path.random);
    segment->point = &point;
    const bool hit = ty_gather_find_end(g, end, segment);
    memset(fog, 0, sizeof *fog);
    for (int32_t i = 0; i < places && point.medium != NULL; ++i) {
        point.u = (u + (float)i) / (float)places;
        ty_cached_fog_at(g, &point, 1.0f / (float)places, fog);
    }
    return hit;
}

/* Light that media scattered and the surface at *start reflects. It is known where walls are (looks); else the path
 * goes on from there. */
TY_FN void ty_cached_follow(ty_gather* g, const ty_intersection* start, bool looks, float out[3]) {
    const ty_bake_request* request = g->request;
    ty_path* path = &g->path;
    const int32_t most = path->request->max_depth;
    ty_intersection end = *start;
    ty_segment segment;
    ty_cached_fog fog;
    for (int c = 0; c < 3; ++c) {
        path->beta[c] = 1.0f;
        out[c] = 0.0f;
    }
    path->rr_throughput = 1.0f;
    path->depth = 0;
    while (ty_max3(end.point.albedo) > 0.0f && (most == 0 || path->depth < most)) {
        path->origin = ty_hit_leave(&end.hit, end.point.ng);
        path->normal = end.point.ns;
        ++path->depth;
        for (int c = 0; c < 3; ++c) path->beta[c] *= end.point.albedo[c];
        const float before = ty_sum3(path->beta);
        const float* wall = looks ? ty_cache_look_wall(&request->cache, request->path.scene->mesh, path->origin,
                                                       path->normal, &path->random)
                                  : NULL;
        if (wall != NULL) {
            const float *single = wall + TY_WALL_LIGHT, *multiple = single + TY_WALL_MULTIPLE * 3 * TY_WALL_TERMS;
            for (int c = 0; c < 3; ++c)
                out[c] += path->beta[c] * (1.0f / TY_PI) * (single[c * TY_WALL_TERMS] + multiple[c * TY_WALL_TERMS]);
            return;
        }
        path->rr_throughput *= ty_max3(end.point.albedo);
        ty_path_sample_cosine_hemisphere(path);
        if (!(ty_dot(end.point.ng, path->direction) > 0.0f)) return;
        const bool hit =
            ty_cached_trace(g, ty_sobol_next(&path->random), looks ? 1 : TY_WALK_PLACES_ON, &end, &segment, &fog);
        for (int c = 0; c < 3; ++c) {
            out[c] += path->beta[c] * (fog.once[c] + fog.rest[c]);
            path->beta[c] *= segment.transmittance[c];
        }
        if (!hit || !ty_path_survives(path, before)) return;
    }
}

/* Radiance that media scattered, along the path's ray: once and never touched by anything else, and other. */
TY_FN void ty_cached_walk(ty_gather* g, bool looks, float single[3], float multiple[3]) {
    ty_intersection end;
    ty_segment segment;
    ty_cached_fog fog;
    float reflected[3] = {0.0f, 0.0f, 0.0f};
    const bool hit = ty_cached_trace(g, ty_sobol_next(&g->path.random), looks ? TY_FOG_PLACES : TY_WALK_PLACES, &end,
                                     &segment, &fog);
    if (hit) ty_cached_follow(g, &end, looks, reflected);
    for (int c = 0; c < 3; ++c) {
        single[c] = fog.once[c];
        multiple[c] = fog.rest[c] + segment.transmittance[c] * reflected[c];
    }
}

/* ---- at receivers ---- */

/* Numbers of a receiver's fog rays are apart from those of its paths. */
#define TY_FOG_ITEM 0x8000000000000000u

/* What cells near a receiver know of its light counts as so many of its fog rays as they are made of. */
TY_FN void ty_cached_borrow(ty_gather* g) {
    const ty_bake_request* request = g->request;
    ty_bake_sums* sums = g->sums;
    float light[TY_WALL_LIGHTS], variance[3];
    if (request->terms == TY_BAKE_SH_TERMS) return;
    const ty_accel* mesh = request->path.scene->mesh;
    const float walks = ty_cache_mean_wall(&request->cache, mesh, g->from, g->normal, light, variance);
    if (!(walks > 0.0f)) return;
    sums->borrowed = (double)walks;
    for (int c = 0; c < 3; ++c) sums->borrowed_variance[c] = (double)variance[c];
    for (int kind = 0; kind < TY_WALL_KINDS; ++kind)
        for (int c = 0; c < 3; ++c)
            ty_gather_keep(g, kind == TY_WALL_SINGLE ? TY_BAKE_SINGLE : TY_BAKE_MULTIPLE, c, walks,
                           light + (kind * 3 + c) * TY_WALL_TERMS);
}

/* One ray of a receiver that gathers what media scattered. */
TY_FN void ty_cached_ask(ty_gather* g, uint64_t item, uint32_t number) {
    const ty_bake_request* request = g->request;
    const bool probe = request->terms == TY_BAKE_SH_TERMS;
    ty_path* path = &g->path;
    ty_bake_sums* sums = g->sums;
    float basis[TY_BAKE_TERMS_MAX], single[3], multiple[3];
    ty_path_begin(path, &request->path, item | TY_FOG_ITEM, number);
    path->origin = g->from;
    path->normal = g->normal;
    for (int c = 0; c < 3; ++c) g->sample[c] = 0.0f;
    if (probe)
        ty_path_sample_sphere(path);
    else
        ty_path_sample_cosine_hemisphere(path);
    if (probe || ty_dot(g->face, path->direction) > 0.0f) {
        const float weight = 1.0f / path->pdf;
        ty_gather_basis(g, path->direction, basis);
        ty_cached_walk(g, true, single, multiple);
        for (int c = 0; c < 3; ++c) {
            single[c] *= weight;
            multiple[c] *= weight;
        }
        ty_gather_keep_all(g, TY_BAKE_SINGLE, single, basis);
        ty_gather_keep_all(g, TY_BAKE_MULTIPLE, multiple, basis);
    }
    for (int c = 0; c < 3; ++c) {
        sums->fog_mean[c] += (double)g->sample[c];
        sums->fog_square[c] += (double)g->sample[c] * (double)g->sample[c];
    }
    ++sums->asked;
}

/* Fog rays of a receiver after so many paths: as many where cells know little. What they know else is as good as many
 * rays, which only long bakes better. */
TY_FN uint32_t ty_cached_rays(const ty_gather* g, uint32_t paths) {
    if (g->sums->borrowed < TY_FOG_LEAST) return paths;
    return paths > TY_FOG_ENOUGH ? (paths - TY_FOG_ENOUGH) / g->request->fog_every : 0;
}

/* What goes with a receiver's paths [first, first + count). */
TY_FN void ty_cached_gather(ty_gather* g, uint64_t item, uint32_t first, uint32_t count) {
    if (first == 0) ty_cached_borrow(g);
    const uint32_t end = ty_cached_rays(g, first + count);
    for (uint32_t i = ty_cached_rays(g, first); i < end; ++i) ty_cached_ask(g, item, i);
}

#endif
