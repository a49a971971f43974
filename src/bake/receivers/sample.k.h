/* One sample of a receiver: a path over surfaces, and every few samples the light scattered by media. */
#ifndef TY_BAKE_RECEIVERS_SAMPLE_K_H
#define TY_BAKE_RECEIVERS_SAMPLE_K_H

#include "bake/impulse/collisions.k.h"
#include "bake/receivers/path_sample.k.h"

/* Adds the direct light of one light sample; false if no light is visible. */
TY_FN bool ty_gather_add_light(ty_gather* g, ty_visible_light* visible) {
    float basis[TY_BAKE_TERMS_MAX], direct[3];
    if (!ty_gather_sample_light(g, g->face, visible)) return false;
    ty_gather_basis(g, visible->sample.wi, basis);
    for (int c = 0; c < 3; ++c)
        direct[c] = visible->sample.radiance[c] * visible->weight * visible->segment.transmittance[c];
    ty_gather_add_rgb(g, TY_BAKE_DIRECT, direct, basis);
    return true;
}

/* Adds the emission found by the path's first ray, and the light of the path that continues from its end. */
TY_FN void ty_gather_first_ray(ty_gather* g, const ty_intersection* end, const ty_segment* segment) {
    const ty_vec direction = g->path.direction;
    const float weight = 1.0f / g->path.pdf;
    float basis[TY_BAKE_TERMS_MAX], light[3] = {0.0f, 0.0f, 0.0f}, scattered[3];
    ty_gather_basis(g, direction, basis);
    if (g->request->impulse.media_only == 0) {
        for (int c = 0; c < 3; ++c) g->path.beta[c] = weight;
        ty_gather_add_hit(g, end, segment, light);
        ty_gather_add_rgb(g, TY_BAKE_DIRECT, light, basis);
        for (int c = 0; c < 3; ++c) scattered[c] = weight * g->enclosed[c];
        ty_gather_add_rgb(g, TY_BAKE_MULTIPLE, scattered, basis);
    }
    if (end == NULL) return;
    if (ty_impulse_is_active(g)) {
        ty_impulse_surface_fog(g, end, light);
        for (int c = 0; c < 3; ++c)
            light[c] *= weight * segment->transmittance[c] * end->point.albedo[c] * (1.0f / TY_PI);
        ty_gather_add_rgb(g, TY_BAKE_MULTIPLE, light, basis);
    }
    if (g->request->impulse.media_only != 0) return;
    for (int c = 0; c < 3; ++c) g->path.beta[c] = 1.0f;
    ty_gather_follow(g, end, light, scattered);
    for (int c = 0; c < 3; ++c) {
        light[c] *= weight * segment->transmittance[c];
        scattered[c] *= weight * segment->transmittance[c];
    }
    ty_gather_add_rgb(g, TY_BAKE_INDIRECT, light, basis);
    ty_gather_add_rgb(g, TY_BAKE_MULTIPLE, scattered, basis);
}

/* One sample of a receiver; true if its ray hit a back face. */
TY_FN bool ty_gather_sample(ty_gather* g, uint64_t item, uint32_t number) {
    const ty_bake_request* request = g->request;
    ty_path* path = &g->path;
    ty_intersection end;
    ty_segment segment;
    ty_visible_light light;
    ty_path_begin(path, &request->path, item, number);
    path->origin = g->origin;
    path->normal = g->normal;
    g->inside = g->around;
    if (request->method == TY_BAKE_PATH) {
        ty_gather_path(g);
        return false;
    }
    const bool visible =
        request->impulse.media_only != 0 ? ty_gather_sample_light(g, g->face, &light) : ty_gather_add_light(g, &light);
    if (!ty_gather_sample_direction(g)) return false;
    const bool hit = ty_gather_trace(g, &end, &segment);
    const bool blocked = hit && ty_dot(end.hit.normal, path->direction) > 0.0f;
    const bool gathers = ty_impulse_is_active(g) && ty_impulse_is_gathered(request, item, number);
    const float weight = 1.0f / path->pdf;
    if (gathers && request->impulse.published == 0) {
        g->emitter = ty_sobol_next(&path->random);
        g->collision = ty_sobol_next(&path->random);
    }
    g->direction = path->direction;
    g->max_distance = hit ? end.hit.distance : segment.leave;
    ty_gather_first_ray(g, hit ? &end : NULL, &segment);
    if (gathers) ty_impulse_gather(g, item, number, visible ? &light : NULL, hit, weight, &segment);
    return blocked;
}

#endif
