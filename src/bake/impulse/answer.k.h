/* Light that media scatter to a receiver, by tables of one emitter's light (method/impulse): of one light, of one
 * sender, and of surfaces that the receiver's ray meets. docs/bake.md explains it. */
#ifndef TY_BAKE_IMPULSE_ANSWER_K_H
#define TY_BAKE_IMPULSE_ANSWER_K_H

#include "bake/gather.k.h"
#include "bake/impulse/response.k.h"

/* Emitters with a receiver this far behind their plane (a cosine) count as if it were in it. */
#define TY_LEAST_FACING -0.1f

TY_FN bool ty_impulse_answers(const ty_gather* g) {
    return g->request->method == TY_BAKE_IMPULSE && g->request->path.scene->medium_count > 0;
}

/* ---- responses ---- */

/* As ty_gather_basis, of a zonal function about an axis: Eq. 13; on surfaces Appendix A, and its first harmonics, of
 * which what goes along the normal is known better. */
TY_FN void ty_gather_zonal_basis(const ty_gather* g, const float zonal[TY_IMPULSE_TERMS], ty_vec axis,
                                 float basis[TY_BAKE_TERMS_MAX]) {
    if (g->request->terms == TY_BAKE_SH_TERMS) {
        ty_sh_all(axis, basis);
        for (int32_t l = 0, t = 0; l < TY_SH_BANDS_MAX; ++l) {
            const float turned = zonal[l] * sqrtf(4.0f * TY_PI / (float)(2 * l + 1));
            for (const int32_t end = (l + 1) * (l + 1); t < end; ++t) basis[t] *= turned;
        }
        return;
    }
    const float cosine = ty_dot(axis, g->normal), first = zonal[1] * 2.04665342f; /* sqrt(4 pi / 3) */
    basis[0] = ty_maxf(0.0f, ty_impulse_irradiance(zonal, cosine));
    const ty_vec vector = ty_mad(ty_scale(axis, first), g->normal, basis[0] - first * cosine);
    basis[1] = vector.x;
    basis[2] = vector.y;
    basis[3] = vector.z;
}

/* Takes off what a response holds of light scattered behind the surface that the sample's ray met: one ray stands for
 * all directions. */
TY_FN void ty_gather_take_beyond(ty_gather* g, const ty_emitter* emitter, const ty_response* response,
                                 const float strength[3], int32_t layer) {
    float basis[TY_BAKE_TERMS_MAX], beyond = 0.0f;
    if (!(g->far < TY_FLOAT_MAX)) return;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const float weight = probe ? 1.0f / TY_INV_4PI : TY_PI / ty_dot(g->normal, g->way);
    ty_gather_basis(g, g->way, basis);
    for (int c = 0; c < 3; ++c) {
        if (c < response->channels)
            beyond = -weight * ty_response_beyond(emitter, &response->medium[c], g->way, g->far);
        ty_gather_keep(g, layer, c, beyond * strength[c], basis);
    }
}

/* Light of an emitter that media scatter towards the receiver. single: the layer of light that scattered once. */
TY_FN void ty_gather_keep_response(ty_gather* g, const ty_emitter* emitter, const ty_response* response,
                                   const float strength[3], int32_t single) {
    float one[TY_BAKE_TERMS_MAX], more[TY_BAKE_TERMS_MAX];
    for (int c = 0; c < 3; ++c) {
        if (c < response->channels) {
            ty_gather_zonal_basis(g, response->channel[c].single, response->axis[c], one);
            ty_gather_zonal_basis(g, response->channel[c].multiple, response->axis[c], more);
        }
        ty_gather_keep(g, single, c, strength[c], one);
        ty_gather_keep(g, TY_BAKE_MULTIPLE, c, strength[c], more);
    }
    ty_gather_take_beyond(g, emitter, response, strength, single);
}

/* ---- emitters ---- */

/* Sets the direction, distance and cosine of an emitter with a place, as seen from a point. */
TY_FN void ty_emitter_look_from(ty_emitter* emitter, ty_vec from) {
    const ty_vec to = ty_sub(emitter->position, from);
    const float distance = sqrtf(ty_dot(to, to));
    emitter->look = distance > 0.0f ? ty_scale(to, 1.0f / distance) : ty_vec_make(0.0f, 0.0f, 1.0f);
    emitter->distance = ty_disc_distance(distance, emitter->area);
    emitter->cosine = emitter->kind == TY_IMPULSE_AREA ? -ty_dot(emitter->normal, emitter->look) : 1.0f;
}

/* A place off the surface: as far as light goes before it scatters, but not near the next surface. */
TY_FN ty_vec ty_gather_off(const ty_gather* g) {
    const ty_scene_view* scene = g->request->path.scene;
    ty_segment segment;
    ty_hit hit;
    if (ty_dot(g->face, g->face) == 0.0f) return g->position;
    const bool met = scene->mesh != NULL && ty_mesh_intersect(scene->mesh, g->from, g->face, TY_FLOAT_MAX, &hit);
    ty_gather_segment(g, g->from, g->face, met ? hit.distance : TY_FLOAT_MAX, &segment);
    const float room = met ? hit.distance : segment.leave;
    const float free = segment.leave / ty_maxf(ty_max3(segment.depth), 1e-6f);
    return ty_mad(g->position, g->face, ty_maxf(g->receiver->margin, 0.5f * ty_minf(room, free)));
}

/* ---- one emitter ---- */

/* Adds the response to environments that are never sampled as lights, where the sample's ray leaves the scene. */
TY_FN void ty_gather_sky_response(ty_gather* g, float weight, const ty_segment* segment) {
    const ty_emitter emitter = {.kind = TY_IMPULSE_DIRECTIONAL, .look = g->way, .distance = segment->leave};
    ty_response response;
    float strength[3];
    ty_gather_sky(g, false, strength);
    for (int c = 0; c < 3; ++c) strength[c] *= weight;
    if (ty_max3(strength) > 0.0f && ty_response_find(g->request, segment, &emitter, &response))
        ty_gather_keep_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

TY_FN bool ty_light_is_far(const ty_light_view* light) {
    return light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_ENVIRONMENT;
}

/* Adds the response to a light at infinity. weight: of the sample. */
TY_FN void ty_gather_far_response(ty_gather* g, const ty_light_sample* sample, const ty_segment* segment,
                                  float weight) {
    const ty_emitter emitter = {
        .kind = TY_IMPULSE_DIRECTIONAL, .look = sample->look, .distance = segment->leave, .cosine = 1.0f};
    ty_response response;
    float strength[3];
    for (int c = 0; c < 3; ++c) strength[c] = weight * sample->radiance[c];
    if (ty_response_find(g->request, segment, &emitter, &response))
        ty_gather_keep_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

/* Adds the response to a light at infinity behind the receiver, which the point off the surface looks for. */
TY_FN void ty_gather_far_behind(ty_gather* g, float weight) {
    ty_path* path = &g->path;
    ty_segment segment;
    ty_light_sample sample;
    float chosen;
    path->origin = g->off;
    path->normal = ty_vec_make(0.0f, 0.0f, 0.0f);
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    if (light == NULL || !ty_light_is_far(light)) return;
    if (ty_dot(g->normal, sample.look) > 0.0f && ty_dot(g->face, sample.look) > 0.0f) return;
    ++g->rays;
    if (!ty_path_sees(path, path->origin, &sample)) return;
    ty_gather_segment(g, path->origin, sample.look, sample.distance, &segment);
    ty_gather_far_response(g, &sample, &segment, weight / chosen);
}

/* Sets up a sender as an emitter; false where it and the receiver are hidden from each other. A sender in front of the
 * receiver is seen from the receiver; any other, where the receiver lies on a surface, from the point off it. */
TY_FN bool ty_gather_see_sender(ty_gather* g, const ty_sender* sender, ty_emitter* emitter) {
    const ty_mesh* mesh = g->request->path.scene->mesh;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    *emitter = (ty_emitter){
        .kind = sender->kind, .position = sender->position, .normal = sender->normal, .area = sender->area};
    ty_emitter_look_from(emitter, g->position);
    const bool ahead = probe || (ty_dot(g->normal, emitter->look) > 0.0f && ty_dot(g->face, emitter->look) > 0.0f);
    const bool straight = ahead && emitter->cosine > 0.0f;
    if (!straight && (probe || g->request->back_scattering == 0 || emitter->cosine < TY_LEAST_FACING)) return false;
    const ty_vec from = straight ? g->from : g->off;
    const ty_vec way = ty_sub(ty_mad(sender->position, sender->face, sender->margin), from);
    const float length = sqrtf(ty_dot(way, way));
    if (sender->kind == TY_IMPULSE_AREA && !(ty_dot(way, sender->face) < 0.0f)) return false;
    emitter->cosine = ty_maxf(0.0f, emitter->cosine);
    ++g->rays;
    return !(length > 0.0f) || mesh == NULL ||
           !ty_mesh_occluded(mesh, from, ty_scale(way, 1.0f / length), length * 0.9999f);
}

/* Cumulative chances of senders: by their power and as what scatters near one falls with distance, and what parts of
 * media send with its square. */
TY_FN void ty_gather_weigh_senders(const ty_gather* g, float* chances) {
    const ty_senders* senders = g->request->impulse.senders;
    const ty_vec at = g->position;
    for (int32_t i = 0; i < senders->count; ++i) {
        const float x = senders->x[i] - at.x, y = senders->y[i] - at.y, z = senders->z[i] - at.z;
        const float over = 1.0f / sqrtf(x * x + y * y + z * z + senders->area[i] * (0.25f / TY_PI));
        const float cosine = -(x * senders->nx[i] + y * senders->ny[i] + z * senders->nz[i]) * over;
        chances[i] = cosine < TY_LEAST_FACING ? 0.0f : senders->power[i] * over;
        if (i >= senders->surfaces + senders->lamps) chances[i] *= over;
    }
    for (int32_t i = 1; i < senders->count; ++i) chances[i] += chances[i - 1];
}

/* Share of a lamp's intensity towards a point that sees it along look. */
TY_FN float ty_sender_falloff(const ty_gather* g, const ty_sender* sender, ty_vec look) {
    if (sender->light < 0) return 1.0f;
    const ty_light_view* light = &g->request->path.scene->lights.lights[sender->light];
    return light->kind == TY_KIND_SPOT ? ty_spot_falloff(light, -ty_dot(look, light->direction)) : 1.0f;
}

/* True where light from infinity reaches the receiver or, if it comes from behind, the point off its surface. */
TY_FN bool ty_gather_sees_far(ty_gather* g, ty_vec toward) {
    const ty_mesh* mesh = g->request->path.scene->mesh;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const bool ahead = probe || (ty_dot(g->normal, toward) > 0.0f && ty_dot(g->face, toward) > 0.0f);
    ++g->rays;
    return mesh == NULL || !ty_mesh_occluded(mesh, ahead ? g->from : g->off, toward, TY_FLOAT_MAX);
}

/* A part of a medium: the light that it sends straight has scattered once; the response to that, more often. Where the
 * receiver sees the light itself, the light's own response has all of this. */
TY_FN void ty_gather_lit_response(ty_gather* g, const ty_sender* sender, const ty_emitter* emitter, float amount,
                                  const ty_segment* segment) {
    ty_response response;
    float basis[TY_BAKE_TERMS_MAX], strength[3];
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    if (ty_gather_sees_far(g, sender->toward)) return;
    const float mu = ty_clampf(-ty_dot(sender->toward, ty_scale(emitter->look, -1.0f)), -1.0f, 1.0f);
    for (int c = 0; c < 3; ++c) strength[c] = amount * sender->sends[c];
    if (probe || (ty_dot(g->normal, emitter->look) > 0.0f && ty_dot(g->face, emitter->look) > 0.0f)) {
        float straight[3];
        const float over = 1.0f / (TY_INV_4PI * emitter->distance * emitter->distance);
        for (int c = 0; c < 3; ++c)
            straight[c] = strength[c] * over * ty_hg(mu, sender->g[c]) * segment->transmittance[c];
        ty_gather_basis(g, emitter->look, basis);
        ty_gather_keep_all(g, TY_BAKE_SINGLE, straight, basis);
    }
    if (g->request->scatterings > 1 && ty_response_find(g->request, segment, emitter, &response))
        ty_gather_keep_response(g, emitter, &response, strength, TY_BAKE_MULTIPLE);
}

/* One sender, number k of this receiver's. */
TY_FN void ty_gather_sender_response(ty_gather* g, uint64_t item, uint32_t k, float weight) {
    const ty_senders* senders = g->request->impulse.senders;
    const float all = senders->count > 0 ? g->chances[senders->count - 1] : 0.0f;
    if (!(all > 0.0f)) return;
    const uint32_t seed = (uint32_t)(ty_mix64(item + 0x9e3779b97f4a7c15u) >> 32);
    const float place = ty_unit_float(ty_owen_scramble(ty_reverse_bits(k), seed)) * all;
    int32_t low = 0, high = senders->count - 1;
    while (low < high) {
        const int32_t middle = (low + high) / 2;
        if (place < g->chances[middle])
            high = middle;
        else
            low = middle + 1;
    }
    const float chance = (g->chances[low] - (low > 0 ? g->chances[low - 1] : 0.0f)) / all;
    const ty_sender* sender = &senders->at[low];
    ty_emitter emitter;
    ty_segment segment;
    ty_response response;
    float strength[3];
    if (!(chance > 0.0f) || !ty_gather_see_sender(g, sender, &emitter)) return;
    ty_gather_segment(g, g->position, emitter.look, emitter.distance, &segment);
    const float amount = weight / chance * sender->amount * ty_sender_falloff(g, sender, emitter.look);
    if (sender->lit != 0) {
        ty_gather_lit_response(g, sender, &emitter, amount, &segment);
        return;
    }
    if (!ty_response_find(g->request, &segment, &emitter, &response)) return;
    for (int c = 0; c < 3; ++c) strength[c] = amount * sender->sends[c];
    if (ty_max3(strength) > 0.0f) ty_gather_keep_response(g, &emitter, &response, strength, TY_BAKE_MULTIPLE);
    for (int c = 0; c < 3; ++c) strength[c] = amount * sender->glows[c];
    if (ty_max3(strength) > 0.0f) ty_gather_keep_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

/* Prepares a receiver. chances: room for TY_SENDERS_MAX. */
TY_FN void ty_impulse_begin(ty_gather* g, float* chances) {
    if (!ty_impulse_answers(g)) return;
    g->off = ty_gather_off(g);
    ty_gather_weigh_senders(g, chances);
    g->chances = chances;
}

/* Light from media that a surface reflects, as irradiance. */
TY_FN void ty_impulse_on_surface(const ty_gather* g, const ty_encounter* at, float irradiance[3]) {
    ty_senders_fog(g->request->impulse.senders, at->hit.position, at->point.normal, irradiance);
}

/* True for one sample in each group of fog_every, chosen at random, since samples that are a fixed number apart have
 * the same strata. */
TY_FN bool ty_impulse_asks(const ty_bake_request* request, uint64_t item, uint32_t number) {
    const uint32_t every = request->fog_every;
    const uint64_t bits = ty_mix64(ty_mix64(item) + number / every);
    return number % every == (uint32_t)(bits >> 32) % every;
}

/* Adds the responses to emitters. seen: the light that the sample saw, or NULL; hit: its ray met a surface. */
TY_FN void ty_impulse_ask(ty_gather* g, uint64_t item, uint32_t number, const ty_seen_light* seen, bool hit,
                          float weight, const ty_segment* segment) {
    const ty_bake_request* request = g->request;
    const bool probe = request->terms == TY_BAKE_SH_TERMS;
    const float each = (float)request->fog_every;
    ty_bake_sums* sums = g->sums;
    float before[3];
    for (int c = 0; c < 3; ++c) {
        before[c] = g->sample[c];
        g->sample[c] = 0.0f;
    }
    if (!hit) ty_gather_sky_response(g, each * weight, segment);
    if (seen != NULL && ty_light_is_far(seen->light))
        ty_gather_far_response(g, &seen->sample, &seen->segment, each / seen->chosen);
    if (!probe && request->back_scattering != 0 && request->path.scene->lights.distant_count > 0)
        ty_gather_far_behind(g, each);
    ty_gather_sender_response(g, item, number / request->fog_every, each);
    for (int c = 0; c < 3; ++c) {
        const double amount = (double)(g->sample[c] / each);
        sums->fog_mean[c] += amount;
        sums->fog_square[c] += amount * amount;
        g->sample[c] = before[c];
    }
    ++sums->asked;
}

#endif
