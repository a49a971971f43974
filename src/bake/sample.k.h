/* One sample of a receiver: a path over surfaces, and every few samples the light that media scatter to it. */
#ifndef TY_BAKE_SAMPLE_K_H
#define TY_BAKE_SAMPLE_K_H

#include "bake/impulse/answer.k.h"

/* Light of a light that the receiver sees; false where it sees none. */
TY_FN bool ty_gather_light(ty_gather* g, ty_seen_light* seen) {
    float basis[TY_BAKE_TERMS_MAX], straight[3];
    if (!ty_gather_see_light(g, g->face, seen)) return false;
    ty_gather_basis(g, seen->sample.look, basis);
    for (int c = 0; c < 3; ++c) straight[c] = seen->sample.radiance[c] * seen->weight * seen->segment.transmittance[c];
    ty_gather_keep_all(g, TY_BAKE_DIRECT, straight, basis);
    return true;
}

/* Adds the light that the path's first ray met, and of the path from there on. */
TY_FN void ty_gather_ahead(ty_gather* g, const ty_encounter* end, const ty_segment* segment) {
    const ty_vec direction = g->path.direction;
    const float weight = 1.0f / g->path.pdf;
    float basis[TY_BAKE_TERMS_MAX], light[3] = {0.0f, 0.0f, 0.0f};
    ty_gather_basis(g, direction, basis);
    if (g->request->impulse.alone == 0) {
        for (int c = 0; c < 3; ++c) g->path.beta[c] = weight;
        ty_gather_meet(g, end, segment, light);
        ty_gather_keep_all(g, TY_BAKE_DIRECT, light, basis);
    }
    if (end == NULL) return;
    if (ty_impulse_answers(g)) {
        ty_impulse_on_surface(g, end, light);
        for (int c = 0; c < 3; ++c)
            light[c] *= weight * segment->transmittance[c] * end->point.albedo[c] * (1.0f / TY_PI);
        ty_gather_keep_all(g, TY_BAKE_MULTIPLE, light, basis);
    }
    if (g->request->impulse.alone != 0) return;
    for (int c = 0; c < 3; ++c) g->path.beta[c] = 1.0f;
    ty_gather_follow(g, end, light);
    for (int c = 0; c < 3; ++c) light[c] *= weight * segment->transmittance[c];
    ty_gather_keep_all(g, TY_BAKE_INDIRECT, light, basis);
}

/* One path of TY_BAKE_PATH: through media as well. */
TY_FN void ty_gather_path(ty_gather* g) {
    ty_path* path = &g->path;
    ty_light_sample sample;
    float basis[TY_BAKE_TERMS_MAX], chosen;
    const float factor[3] = {1.0f, 1.0f, 1.0f};
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    const float cosine = light != NULL && !probe ? ty_dot(g->normal, sample.look) : 1.0f;
    if (light != NULL && cosine > 0.0f && (probe || ty_dot(g->face, sample.look) > 0.0f)) {
        ty_path_add_vertex_light(path, light, chosen, &sample, factor, probe ? TY_INV_4PI : cosine * (1.0f / TY_PI),
                                 0.0f);
        ty_gather_basis(g, sample.look, basis);
        ty_gather_keep_all(g, TY_BAKE_DIRECT, path->radiance[TY_PART_UNCOLLIDED], basis);
        memset(path->radiance, 0, sizeof path->radiance);
    }
    if (probe)
        ty_path_turn_anywhere(path);
    else
        ty_path_turn(path);
    if (!probe && !(ty_dot(g->face, path->direction) > 0.0f)) return;
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f / path->pdf;
    ty_gather_basis(g, path->direction, basis);
    g->rays += 2 * ty_path_follow(path);
    for (int32_t part = 0; part < TY_PART_COUNT; ++part) ty_gather_keep_all(g, part, path->radiance[part], basis);
}

/* One sample of a receiver; true where its ray met the back of a surface. */
TY_FN bool ty_gather_sample(ty_gather* g, uint64_t item, uint32_t number) {
    const ty_bake_request* request = g->request;
    ty_path* path = &g->path;
    const bool probe = request->terms == TY_BAKE_SH_TERMS;
    ty_encounter end;
    ty_segment segment;
    ty_seen_light light;
    ty_path_begin(path, &request->path, item, number);
    path->origin = g->from;
    path->normal = g->normal;
    if (request->method == TY_BAKE_PATH) {
        ty_gather_path(g);
        return false;
    }
    const bool seen =
        request->impulse.alone != 0 ? ty_gather_see_light(g, g->face, &light) : ty_gather_light(g, &light);
    if (probe)
        ty_path_turn_anywhere(path);
    else
        ty_path_turn(path);
    if (!probe && !(ty_dot(g->face, path->direction) > 0.0f)) return false;
    const bool hit = ty_gather_trace(g, &end, &segment);
    const bool blocked = hit && ty_dot(end.hit.normal, path->direction) > 0.0f;
    const bool asks = ty_impulse_answers(g) && ty_impulse_asks(request, item, number);
    const float weight = 1.0f / path->pdf;
    g->way = path->direction;
    g->far = hit ? end.hit.distance : segment.leave;
    ty_gather_ahead(g, hit ? &end : NULL, &segment);
    if (asks) ty_impulse_ask(g, item, number, seen ? &light : NULL, hit, weight, &segment);
    return blocked;
}

#endif
