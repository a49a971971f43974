/* Light of media whose scattered light is cached, as it arrives at receivers: paths over surfaces ignore it, and
 * separate rays gather it. docs/bake.md explains the method. */
#ifndef TY_BAKE_CACHE_CACHED_K_H
#define TY_BAKE_CACHE_CACHED_K_H

#include "bake/cache/lookup.k.h"
#include "bake/gather/gather.k.h"

/* Radiance that the media along a ray scatter back to its origin: once-scattered light, and all other. */
typedef struct ty_cached_fog {
    float direct[3], indirect[3];
} ty_cached_fog;

/* Number of cache lookups: along a receiver's ray; along the first ray of a surfel's path, which many receivers share,
 * and along its other rays. */
enum { TY_FOG_RAY_SAMPLES = 4, TY_SURFEL_RAY_SAMPLES = 16, TY_SURFEL_BOUNCE_SAMPLES = 4 };

/* Adds the scattered radiance of one sample point, scaled by the sample weight. */
TY_FN void ty_cached_add_fog(ty_gather* g, const ty_fog_point* point, float weight_of_sample, ty_cached_fog* fog) {
    const ty_bake_request* request = g->request;
    float weight[3], albedo[3], g_medium[3], direct[3], indirect[3];
    const ty_vec at = ty_gather_fog_position(g, point, weight, albedo);
    const float* light = ty_cache_lookup(&request->cache, request->path.scene->mesh, at, &g->path.random);
    ty_medium_g(point->medium, at, g_medium);
    ty_cache_scatter(&request->cache, light, g->path.direction, g_medium, direct);
    ty_cache_scatter(&request->cache, light + request->cache.floats, g->path.direction, g_medium, indirect);
    for (int c = 0; c < 3; ++c) {
        fog->direct[c] += weight_of_sample * weight[c] * albedo[c] * direct[c];
        fog->indirect[c] += weight_of_sample * weight[c] * albedo[c] * indirect[c];
    }
}

/* Traces the path's ray to its end (false: it hits no surface) and samples the media along it at `count` stratified
 * points, offset by u. */
TY_FN bool ty_cached_trace(ty_gather* g, float u, int32_t count, ty_intersection* end, ty_segment* segment,
                           ty_cached_fog* fog) {
    ty_fog_point point = ty_fog_point_begin(u, &g->path.random);
    segment->point = &point;
    const bool hit = ty_gather_find_end(g, end, segment);
    memset(fog, 0, sizeof *fog);
    for (int32_t i = 0; i < count && point.medium != NULL; ++i) {
        point.u = (u + (float)i) / (float)count;
        ty_cached_add_fog(g, &point, 1.0f / (float)count, fog);
    }
    return hit;
}

/* Light scattered by media and reflected by the surface at *start. It is looked up where surfels exist (use_surfels);
 * elsewhere the path continues. */
TY_FN void ty_cached_follow(ty_gather* g, const ty_intersection* start, bool use_surfels, float out[3]) {
    const ty_bake_request* request = g->request;
    ty_path* path = &g->path;
    const int32_t max_depth = path->request->max_depth;
    ty_intersection end = *start;
    ty_segment segment;
    ty_cached_fog fog;
    for (int c = 0; c < 3; ++c) {
        path->beta[c] = 1.0f;
        out[c] = 0.0f;
    }
    path->rr_throughput = 1.0f;
    path->depth = 0;
    while (ty_max3(end.point.albedo) > 0.0f && (max_depth == 0 || path->depth < max_depth)) {
        path->origin = ty_hit_leave(&end.hit, end.point.ng);
        path->normal = end.point.ns;
        ++path->depth;
        for (int c = 0; c < 3; ++c) path->beta[c] *= end.point.albedo[c];
        const float before = ty_sum3(path->beta);
        const float* surfel = use_surfels ? ty_cache_lookup_surfel(&request->cache, request->path.scene->mesh,
                                                                   path->origin, path->normal, &path->random)
                                          : NULL;
        if (surfel != NULL) {
            const float *single = surfel + TY_SURFEL_IRRADIANCE,
                        *multiple = single + TY_SURFEL_MULTIPLE * 3 * TY_SURFEL_TERMS;
            for (int c = 0; c < 3; ++c)
                out[c] +=
                    path->beta[c] * (1.0f / TY_PI) * (single[c * TY_SURFEL_TERMS] + multiple[c * TY_SURFEL_TERMS]);
            return;
        }
        path->rr_throughput *= ty_max3(end.point.albedo);
        ty_path_sample_cosine_hemisphere(path);
        if (!(ty_dot(end.point.ng, path->direction) > 0.0f)) return;
        const bool hit = ty_cached_trace(g, ty_sobol_next(&path->random), use_surfels ? 1 : TY_SURFEL_BOUNCE_SAMPLES,
                                         &end, &segment, &fog);
        for (int c = 0; c < 3; ++c) {
            out[c] += path->beta[c] * (fog.direct[c] + fog.indirect[c]);
            path->beta[c] *= segment.transmittance[c];
        }
        if (!hit || !ty_path_survives(path, before)) return;
    }
}

/* Radiance scattered by media along the path's ray: scattered once and not reflected, and all other. */
TY_FN void ty_cached_radiance(ty_gather* g, bool use_surfels, float single[3], float multiple[3]) {
    ty_intersection end;
    ty_segment segment;
    ty_cached_fog fog;
    float reflected[3] = {0.0f, 0.0f, 0.0f};
    const bool hit = ty_cached_trace(g, ty_sobol_next(&g->path.random),
                                     use_surfels ? TY_FOG_RAY_SAMPLES : TY_SURFEL_RAY_SAMPLES, &end, &segment, &fog);
    if (hit) ty_cached_follow(g, &end, use_surfels, reflected);
    for (int c = 0; c < 3; ++c) {
        single[c] = fog.direct[c];
        multiple[c] = fog.indirect[c] + segment.transmittance[c] * reflected[c];
    }
}

/* ---- at receivers ---- */

/* Separates the random numbers of a receiver's gather rays from those of its paths. */
#define TY_FOG_ITEM 0x8000000000000000u

/* The surfels near a receiver form a prior that counts as the number of gather rays with equal noise. */
TY_FN void ty_cached_load_prior(ty_gather* g) {
    const ty_bake_request* request = g->request;
    ty_bake_sums* sums = g->sums;
    float light[TY_SURFEL_IRRADIANCE_FLOATS], variance[3];
    if (request->terms == TY_BAKE_SH_TERMS) return;
    const ty_accel* mesh = request->path.scene->mesh;
    const float prior_rays = ty_cache_mean_surfel(&request->cache, mesh, g->origin, g->normal, light, variance);
    if (!(prior_rays > 0.0f)) return;
    sums->prior_rays = (double)prior_rays;
    for (int c = 0; c < 3; ++c) sums->prior_variance[c] = (double)variance[c];
    for (int kind = 0; kind < TY_SURFEL_KINDS; ++kind)
        for (int c = 0; c < 3; ++c)
            ty_gather_add(g, kind == TY_SURFEL_SINGLE ? TY_BAKE_SINGLE : TY_BAKE_MULTIPLE, c, prior_rays,
                          light + (kind * 3 + c) * TY_SURFEL_TERMS);
}

/* One gather ray of a receiver: radiance scattered by media. */
TY_FN void ty_cached_gather_ray(ty_gather* g, uint64_t item, uint32_t number) {
    const ty_bake_request* request = g->request;
    ty_path* path = &g->path;
    ty_bake_sums* sums = g->sums;
    float basis[TY_BAKE_TERMS_MAX], single[3], multiple[3];
    ty_path_begin(path, &request->path, item | TY_FOG_ITEM, number);
    path->origin = g->origin;
    path->normal = g->normal;
    g->inside = g->around;
    for (int c = 0; c < 3; ++c) g->sample[c] = 0.0f;
    if (ty_gather_sample_direction(g)) {
        const float weight = 1.0f / path->pdf;
        ty_gather_basis(g, path->direction, basis);
        ty_cached_radiance(g, true, single, multiple);
        for (int c = 0; c < 3; ++c) {
            single[c] *= weight;
            multiple[c] *= weight;
        }
        ty_gather_add_rgb(g, TY_BAKE_SINGLE, single, basis);
        ty_gather_add_rgb(g, TY_BAKE_MULTIPLE, multiple, basis);
    }
    for (int c = 0; c < 3; ++c) {
        sums->fog_mean[c] += (double)g->sample[c];
        sums->fog_square[c] += (double)g->sample[c] * (double)g->sample[c];
    }
    ++sums->gather_rays;
}

/* Gather rays of a receiver after the given number of paths. Where the cache is uninformed there is one per path; where
 * it is informed the prior is already as good as many rays, and extra rays only pay off in long bakes. */
TY_FN uint32_t ty_cached_rays(const ty_gather* g, uint32_t paths) {
    if (g->sums->prior_rays < TY_FOG_MIN_PRIOR_RAYS) return paths;
    return paths > TY_FOG_PRIOR_PATHS ? (paths - TY_FOG_PRIOR_PATHS) / g->request->fog_every : 0;
}

/* Gathers scattered light along with a receiver's paths [first, first + count). */
TY_FN void ty_cached_gather(ty_gather* g, uint64_t item, uint32_t first, uint32_t count) {
    if (first == 0) ty_cached_load_prior(g);
    const uint32_t end = ty_cached_rays(g, first + count);
    for (uint32_t i = ty_cached_rays(g, first); i < end; ++i) ty_cached_gather_ray(g, item, i);
}

#endif
