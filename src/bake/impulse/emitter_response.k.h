/* Light scattered by media to a receiver, from tables of impulse responses (method/impulse): of one light, of one
 * virtual emitter, and of surfaces hit by the receiver's ray. docs/bake.md explains the method. */
#ifndef TY_BAKE_IMPULSE_EMITTER_RESPONSE_K_H
#define TY_BAKE_IMPULSE_EMITTER_RESPONSE_K_H

#include "bake/gather/gather.k.h"
#include "bake/impulse/response.k.h"

/* Cosine at the emitter down to which a receiver behind its plane is treated as lying in the plane. */
#define TY_MIN_EMITTER_COSINE -0.1f

TY_FN bool ty_impulse_is_active(const ty_gather* g) {
    return g->request->method == TY_BAKE_IMPULSE && g->request->path.scene->medium_count > 0;
}

/* ---- responses ---- */

/* Projects a zonal function about an axis onto the basis of ty_gather_basis: Eq. 13 (Dubouchet 2019); on surfaces
 * App. A (Dubouchet 2019) and the first harmonics, with the normal component replaced by the more accurate
 * irradiance. */
TY_FN void ty_gather_zonal_basis(const ty_gather* g, const float zonal[TY_IMPULSE_TERMS], ty_vec axis,
                                 float basis[TY_BAKE_TERMS_MAX]) {
    if (g->request->terms == TY_BAKE_SH_TERMS) {
        ty_sh_all(axis, basis);
        for (int32_t l = 0, t = 0; l < TY_SH_BANDS_MAX; ++l) {
            const float convolution = zonal[l] * sqrtf(4.0f * TY_PI / (float)(2 * l + 1));
            for (const int32_t end = (l + 1) * (l + 1); t < end; ++t) basis[t] *= convolution;
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

/* Subtracts light of a response that is scattered behind the surface hit by the sample's ray: one ray represents all
 * directions. */
TY_FN void ty_gather_subtract_occluded(ty_gather* g, const ty_emitter* emitter, const ty_response* response,
                                       const float strength[3], int32_t layer) {
    float basis[TY_BAKE_TERMS_MAX], occluded = 0.0f;
    if (!(g->max_distance < TY_FLOAT_MAX)) return;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const float weight = probe ? 1.0f / TY_INV_4PI : TY_PI / ty_dot(g->normal, g->direction);
    ty_gather_basis(g, g->direction, basis);
    for (int c = 0; c < 3; ++c) {
        if (c < response->channels)
            occluded = -weight * ty_response_occluded(emitter, &response->medium[c], g->direction, g->max_distance);
        ty_gather_add(g, layer, c, occluded * strength[c], basis);
    }
}

/* Adds light of an emitter scattered by media towards the receiver. single: the layer of once-scattered light. */
TY_FN void ty_gather_add_response(ty_gather* g, const ty_emitter* emitter, const ty_response* response,
                                  const float strength[3], int32_t single) {
    float single_basis[TY_BAKE_TERMS_MAX], multiple_basis[TY_BAKE_TERMS_MAX];
    for (int c = 0; c < 3; ++c) {
        if (c < response->channels) {
            ty_gather_zonal_basis(g, response->channel[c].single, response->axis[c], single_basis);
            ty_gather_zonal_basis(g, response->channel[c].multiple, response->axis[c], multiple_basis);
        }
        ty_gather_add(g, single, c, strength[c], single_basis);
        ty_gather_add(g, TY_BAKE_MULTIPLE, c, strength[c], multiple_basis);
    }
    ty_gather_subtract_occluded(g, emitter, response, strength, single);
}

/* ---- emitters ---- */

/* Sets direction, distance and cosine of a positioned emitter relative to a receiver. */
TY_FN void ty_emitter_set_receiver(ty_emitter* emitter, ty_vec receiver) {
    const ty_vec to = ty_sub(emitter->position, receiver);
    const float distance = sqrtf(ty_dot(to, to));
    emitter->wi = distance > 0.0f ? ty_scale(to, 1.0f / distance) : ty_vec_make(0.0f, 0.0f, 1.0f);
    emitter->distance = ty_disc_distance(distance, emitter->area);
    emitter->cosine = emitter->kind == TY_IMPULSE_AREA ? -ty_dot(emitter->normal, emitter->wi) : 1.0f;
}

/* A virtual emitter relative to a point. */
TY_FN ty_emitter ty_virtual_emitter_at(const ty_virtual_emitter* virtual_emitter, ty_vec receiver) {
    ty_emitter emitter = {.kind = virtual_emitter->kind,
                          .position = virtual_emitter->position,
                          .normal = virtual_emitter->normal,
                          .area = virtual_emitter->area};
    ty_emitter_set_receiver(&emitter, receiver);
    return emitter;
}

/* A point off the surface by half a mean free path, at most half the clearance to the next surface. */
TY_FN ty_vec ty_gather_find_offset(const ty_gather* g) {
    const ty_scene_view* scene = g->request->path.scene;
    ty_segment segment;
    ty_hit hit;
    if (ty_dot(g->face, g->face) == 0.0f) return g->position;
    const bool hit_surface =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, g->origin, g->face, TY_FLOAT_MAX, &hit);
    ty_gather_segment(g, g->origin, g->face, hit_surface ? hit.distance : TY_FLOAT_MAX, &segment);
    const float clearance = hit_surface ? hit.distance : segment.leave;
    const float mean_free_path = segment.leave / ty_maxf(ty_max3(segment.depth), 1e-6f);
    return ty_mad(g->position, g->face, ty_maxf(g->receiver->margin, 0.5f * ty_minf(clearance, mean_free_path)));
}

/* ---- one emitter ---- */

/* Adds the response to environments that are never sampled as lights, if the sample's ray leaves the scene. */
TY_FN void ty_gather_environment_response(ty_gather* g, float weight, const ty_segment* segment) {
    const ty_emitter emitter = {.kind = TY_IMPULSE_DIRECTIONAL, .wi = g->direction, .distance = segment->leave};
    ty_response response;
    float strength[3];
    ty_gather_environment(g, false, strength);
    for (int c = 0; c < 3; ++c) strength[c] *= weight;
    if (ty_max3(strength) > 0.0f && ty_response_find(g->request, segment, &emitter, &response))
        ty_gather_add_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

TY_FN bool ty_light_is_distant(const ty_light_view* light) {
    return light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_ENVIRONMENT;
}

/* Adds the response to a distant light. weight: of the sample. */
TY_FN void ty_gather_distant_response(ty_gather* g, const ty_light_sample* sample, const ty_segment* segment,
                                      float weight) {
    const ty_emitter emitter = {
        .kind = TY_IMPULSE_DIRECTIONAL, .wi = sample->wi, .distance = segment->leave, .cosine = 1.0f};
    ty_response response;
    float strength[3];
    for (int c = 0; c < 3; ++c) strength[c] = weight * sample->radiance[c];
    if (ty_response_find(g->request, segment, &emitter, &response))
        ty_gather_add_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

/* Adds the response to a distant light behind the receiver, tested for visibility from the point off the surface. */
TY_FN void ty_gather_backlight_response(ty_gather* g, float weight) {
    ty_path* path = &g->path;
    ty_segment segment;
    ty_light_sample sample;
    float chosen;
    path->origin = g->offset_origin;
    path->normal = ty_vec_make(0.0f, 0.0f, 0.0f);
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    if (light == NULL || !ty_light_is_distant(light)) return;
    if (ty_dot(g->normal, sample.wi) > 0.0f && ty_dot(g->face, sample.wi) > 0.0f) return;
    ++g->rays;
    if (!ty_path_light_visible(path, path->origin, &sample)) return;
    ty_gather_segment(g, path->origin, sample.wi, sample.distance, &segment);
    ty_gather_distant_response(g, &sample, &segment, weight / chosen);
}

/* True if a surface is between a point and a virtual emitter. to: from the point to the emitter; length: of it, m. */
TY_FN bool ty_virtual_emitter_is_hidden(const ty_accel* mesh, const ty_virtual_emitter* virtual_emitter, ty_vec from,
                                        ty_vec to, float length) {
    const float free = length * 0.9999f - virtual_emitter->radius;
    return mesh != NULL && free > 0.0f && ty_accel_occluded(mesh, from, ty_scale(to, 1.0f / length), free);
}

/* Sets up a virtual emitter; false: it is occluded. Visibility of an emitter in front of the receiver is tested from
 * the receiver, otherwise from the point off its surface. */
TY_FN bool ty_gather_see_virtual_emitter(ty_gather* g, const ty_virtual_emitter* virtual_emitter, ty_emitter* emitter) {
    const ty_accel* mesh = g->request->path.scene->mesh;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    *emitter = ty_virtual_emitter_at(virtual_emitter, g->position);
    const bool in_front = probe || (ty_dot(g->normal, emitter->wi) > 0.0f && ty_dot(g->face, emitter->wi) > 0.0f);
    const bool direct = in_front && emitter->cosine > 0.0f;
    if (!direct && (probe || g->request->back_scattering == 0 || emitter->cosine < TY_MIN_EMITTER_COSINE)) return false;
    const ty_vec receiver = direct ? g->origin : g->offset_origin;
    const ty_vec to_emitter =
        ty_sub(ty_mad(virtual_emitter->position, virtual_emitter->face, virtual_emitter->margin), receiver);
    const float length = sqrtf(ty_dot(to_emitter, to_emitter));
    if (virtual_emitter->kind == TY_IMPULSE_AREA && !(ty_dot(to_emitter, virtual_emitter->face) < 0.0f)) return false;
    emitter->cosine = ty_maxf(0.0f, emitter->cosine);
    ++g->rays;
    return !ty_virtual_emitter_is_hidden(mesh, virtual_emitter, receiver, to_emitter, length);
}

/* Cumulative selection weights of the virtual emitters: power over distance, as light scattered near an emitter falls
 * off, and power over squared distance for parts of media. */
TY_FN void ty_gather_build_emitter_cdf(const ty_gather* g, float* cdf) {
    const ty_virtual_emitters* emitters = g->request->impulse.emitters;
    const ty_vec at = g->position;
    const bool published = g->request->impulse.published != 0;
    /* Light of emitters that face away from the receiver reaches collisions on its rays. */
    const float behind = published ? 0.0f : 0.25f;
    for (int32_t i = 0; i < emitters->count; ++i) {
        const float x = emitters->x[i] - at.x, y = emitters->y[i] - at.y, z = emitters->z[i] - at.z;
        const float inverse_distance = 1.0f / sqrtf(x * x + y * y + z * z + emitters->area[i] * (0.25f / TY_PI));
        const float cosine = -(x * emitters->nx[i] + y * emitters->ny[i] + z * emitters->nz[i]) * inverse_distance;
        cdf[i] = emitters->power[i] * inverse_distance;
        if (cosine < TY_MIN_EMITTER_COSINE) cdf[i] *= behind;
        if (i >= emitters->surfaces + emitters->local_lights) cdf[i] *= inverse_distance;
    }
    for (int32_t i = 1; i < emitters->count; ++i) cdf[i] += cdf[i - 1];
}

/* Relative intensity of a point light towards a point that sees it along wi. */
TY_FN float ty_virtual_emitter_falloff(const ty_gather* g, const ty_virtual_emitter* virtual_emitter, ty_vec wi) {
    if (virtual_emitter->light < 0) return 1.0f;
    const ty_light_view* light = &g->request->path.scene->lights.lights[virtual_emitter->light];
    return ty_light_falloff(light, wi);
}

/* True if distant light from direction wi reaches the receiver or, from behind, the point off its surface. */
TY_FN bool ty_gather_sees_distant(ty_gather* g, ty_vec wi) {
    const ty_accel* mesh = g->request->path.scene->mesh;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const bool in_front = probe || (ty_dot(g->normal, wi) > 0.0f && ty_dot(g->face, wi) > 0.0f);
    ++g->rays;
    return mesh == NULL || !ty_accel_occluded(mesh, in_front ? g->origin : g->offset_origin, wi, TY_FLOAT_MAX);
}

/* A lit part of a medium: its direct light has scattered once, the response to it more often. Where the receiver sees
 * the light itself, the response of that light includes all of this. */
TY_FN void ty_gather_medium_response(ty_gather* g, const ty_virtual_emitter* virtual_emitter, const ty_emitter* emitter,
                                     float measure, const ty_segment* segment) {
    ty_response response;
    float basis[TY_BAKE_TERMS_MAX], strength[3];
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    if (ty_gather_sees_distant(g, virtual_emitter->wi)) return;
    const float mu = ty_clampf(-ty_dot(virtual_emitter->wi, ty_scale(emitter->wi, -1.0f)), -1.0f, 1.0f);
    for (int c = 0; c < 3; ++c) strength[c] = measure * virtual_emitter->outgoing[c];
    if (probe || (ty_dot(g->normal, emitter->wi) > 0.0f && ty_dot(g->face, emitter->wi) > 0.0f)) {
        float direct[3];
        const float inverse_distance = 1.0f / (TY_INV_4PI * emitter->distance * emitter->distance);
        for (int c = 0; c < 3; ++c)
            direct[c] = strength[c] * inverse_distance * ty_hg(mu, virtual_emitter->g[c]) * segment->transmittance[c];
        ty_gather_basis(g, emitter->wi, basis);
        ty_gather_add_rgb(g, TY_BAKE_SINGLE, direct, basis);
    }
    if (g->request->scatterings > 1 && ty_response_find(g->request, segment, emitter, &response))
        ty_gather_add_response(g, emitter, &response, strength, TY_BAKE_MULTIPLE);
}

/* Uniform in [0, 1): chooses the k-th virtual emitter of a receiver. */
TY_FN float ty_gather_emitter_stratum(uint64_t item, uint32_t k) {
    const uint32_t seed = (uint32_t)(ty_mix64(item + 0x9e3779b97f4a7c15u) >> 32);
    return ty_unit_float(ty_owen_scramble(ty_reverse_bits(k), seed));
}

/* The index of the virtual emitter that u chooses, and its probability; -1: none. */
TY_FN int32_t ty_gather_choose_emitter(const ty_gather* g, float u, float* probability) {
    const ty_virtual_emitters* emitters = g->request->impulse.emitters;
    const float total = emitters->count > 0 ? g->emitter_cdf[emitters->count - 1] : 0.0f;
    const float position = u * total;
    if (!(total > 0.0f)) return -1;
    int32_t index = 0, last = emitters->count - 1;
    while (index < last) {
        const int32_t center = (index + last) / 2;
        if (position < g->emitter_cdf[center])
            last = center;
        else
            index = center + 1;
    }
    *probability = (g->emitter_cdf[index] - (index > 0 ? g->emitter_cdf[index - 1] : 0.0f)) / total;
    return *probability > 0.0f ? index : -1;
}

/* The response to the k-th virtual emitter of this receiver. */
TY_FN void ty_gather_virtual_response(ty_gather* g, uint64_t item, uint32_t k, float weight) {
    float probability;
    const int32_t index = ty_gather_choose_emitter(g, ty_gather_emitter_stratum(item, k), &probability);
    if (index < 0) return;
    const ty_virtual_emitter* virtual_emitter = &g->request->impulse.emitters->items[index];
    ty_emitter emitter;
    ty_segment segment;
    ty_response response;
    float strength[3];
    if (!ty_gather_see_virtual_emitter(g, virtual_emitter, &emitter)) return;
    ty_gather_segment(g, g->position, emitter.wi, emitter.distance, &segment);
    const float measure =
        weight / probability * virtual_emitter->measure * ty_virtual_emitter_falloff(g, virtual_emitter, emitter.wi);
    if (virtual_emitter->in_medium != 0) {
        ty_gather_medium_response(g, virtual_emitter, &emitter, measure, &segment);
        return;
    }
    if (!ty_response_find(g->request, &segment, &emitter, &response)) return;
    for (int c = 0; c < 3; ++c) strength[c] = measure * virtual_emitter->outgoing[c];
    if (ty_max3(strength) > 0.0f) ty_gather_add_response(g, &emitter, &response, strength, TY_BAKE_MULTIPLE);
    for (int c = 0; c < 3; ++c) strength[c] = measure * virtual_emitter->emission[c];
    if (ty_max3(strength) > 0.0f) ty_gather_add_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

/* Prepares a receiver. emitter_cdf: TY_VIRTUAL_EMITTERS_MAX floats. */
TY_FN void ty_impulse_begin(ty_gather* g, float* cdf) {
    if (!ty_impulse_is_active(g)) return;
    g->offset_origin = ty_gather_find_offset(g);
    ty_gather_build_emitter_cdf(g, cdf);
    g->emitter_cdf = cdf;
}

/* Irradiance at a surface point of light scattered by media. */
TY_FN void ty_impulse_surface_fog(const ty_gather* g, const ty_intersection* at, float irradiance[3]) {
    ty_virtual_emitters_fog(g->request->impulse.emitters, at->hit.position, at->point.ns, irradiance);
}

/* True for one sample in each group of fog_every, chosen at random, since samples that are a fixed number apart have
 * the same strata. */
TY_FN bool ty_impulse_is_gathered(const ty_bake_request* request, uint64_t item, uint32_t number) {
    const uint32_t interval = request->fog_every;
    const uint64_t bits = ty_mix64(ty_mix64(item) + number / interval);
    return number % interval == (uint32_t)(bits >> 32) % interval;
}

/* Adds the responses to emitters at the receiver: the composition of Sec. 5 (Dubouchet 2019). visible: the light
 * sample, or NULL; hit: its ray hit a surface; scale: samples that this one stands for. */
TY_FN void ty_gather_published(ty_gather* g, uint64_t item, uint32_t k, const ty_visible_light* visible, bool hit,
                               float scale, float weight, const ty_segment* segment) {
    const ty_bake_request* request = g->request;
    const bool probe = request->terms == TY_BAKE_SH_TERMS;
    if (!hit) ty_gather_environment_response(g, scale * weight, segment);
    if (visible != NULL && ty_light_is_distant(visible->light))
        ty_gather_distant_response(g, &visible->sample, &visible->segment, scale / visible->chosen);
    if (!probe && request->back_scattering != 0 && request->path.scene->lights.distant_count > 0)
        ty_gather_backlight_response(g, scale);
    ty_gather_virtual_response(g, item, k, scale);
}

#endif
