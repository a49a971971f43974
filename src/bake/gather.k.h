/* One path from a receiver over surfaces, and every few samples what media make of one light and of one surface point
 * that sends light. docs/bake.md explains it. */
#ifndef TY_BAKE_GATHER_K_H
#define TY_BAKE_GATHER_K_H

#include "base/sh.k.h"
#include "bake/response.k.h"
#include "method/path/path.k.h"

/* Cosines to a surface's normal below which light counts less in the vector irradiance along the surface. */
#define TY_LEAST_GRAZING 0.02f
/* Emitters with a receiver this far behind their plane (a cosine) count as if it were in it. */
#define TY_LEAST_FACING -0.1f

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

TY_FN bool ty_gather_scatters(const ty_gather* g) {
    return g->request->method == TY_BAKE_IMPULSE && g->request->path.scene->medium_count > 0;
}

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

/* The same of a zonal function about an axis: Eq. 13; on surfaces Appendix A, and its first harmonics, of which what
 * goes along the normal is known better. */
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

/* What an emitter with a place is to a point. */
TY_FN void ty_emitter_look_from(ty_emitter* emitter, ty_vec from) {
    const ty_vec to = ty_sub(emitter->position, from);
    const float distance = sqrtf(ty_dot(to, to));
    emitter->wi = distance > 0.0f ? ty_scale(to, 1.0f / distance) : ty_vec_make(0.0f, 0.0f, 1.0f);
    emitter->distance = ty_disc_distance(distance, emitter->area);
    emitter->cosine = emitter->kind == TY_IMPULSE_AREA ? -ty_dot(emitter->normal, emitter->wi) : 1.0f;
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
TY_FN bool ty_gather_find_end(ty_gather* g, ty_intersection* end, ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_path* path = &g->path;
    ++g->rays;
    const bool hit =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    if (hit) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    ty_segment_find(segment, scene->media, scene->medium_count, path->origin, path->direction,
                    hit ? end->hit.distance : TY_FLOAT_MAX);
    return hit;
}

/* The same, and what glows on the way. */
TY_FN bool ty_gather_trace(ty_gather* g, ty_intersection* end, ty_segment* segment) {
    float weight[3], albedo[3];
    segment->point = NULL;
    if (g->request->glows == 0) return ty_gather_find_end(g, end, segment);
    ty_fog_point point = ty_fog_point_begin(ty_rng_uniform(&g->path.random), &g->path.random);
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
    seen->cosine = probe ? 1.0f : ty_dot(path->normal, seen->sample.wi);
    if (!probe && (!(seen->cosine > 0.0f) || !(ty_dot(facing, seen->sample.wi) > 0.0f))) return false;
    ++g->rays;
    if (!ty_path_light_visible(path, path->origin, &seen->sample)) return false;
    const float pdf = probe ? TY_INV_4PI : seen->cosine * (1.0f / TY_PI), own = seen->sample.pdf;
    seen->weight = own > 0.0f ? own / (seen->chosen * own + pdf) : 1.0f / seen->chosen;
    ty_gather_segment(g, path->origin, seen->sample.wi, seen->sample.distance, &seen->segment);
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
TY_FN void ty_gather_reflect_light(ty_gather* g, const ty_intersection* at, float out[3]) {
    ty_seen_light seen;
    if (!ty_gather_see_light(g, at->point.ng, &seen)) return;
    for (int c = 0; c < 3; ++c)
        out[c] += g->path.beta[c] * at->point.albedo[c] * (1.0f / TY_PI) * seen.sample.radiance[c] * seen.weight *
                  seen.cosine * seen.segment.transmittance[c];
}

/* Light that the path's ray meets, on a surface (end) or beyond all (NULL), and on the way. */
TY_FN void ty_gather_meet(const ty_gather* g, const ty_intersection* end, const ty_segment* segment, float out[3]) {
    float radiance[3] = {0.0f, 0.0f, 0.0f};
    if (end == NULL)
        ty_gather_sky(g, true, radiance);
    else if (ty_max3(end->point.emission) > 0.0f) {
        const float weight = ty_path_mis_weight_emission(&g->path, end);
        for (int c = 0; c < 3; ++c) radiance[c] = end->point.emission[c] * weight;
    }
    for (int c = 0; c < 3; ++c) out[c] += g->path.beta[c] * (segment->transmittance[c] * radiance[c] + g->glow[c]);
}

/* Radiance that a surface reflects of light that media only took from: the path goes on from there. */
TY_FN void ty_gather_follow(ty_gather* g, const ty_intersection* start, float out[3]) {
    ty_path* path = &g->path;
    const int32_t most = path->request->max_depth;
    ty_intersection end = *start;
    ty_segment segment;
    for (int c = 0; c < 3; ++c) out[c] = 0.0f;
    path->rr_throughput = 1.0f;
    path->depth = 0;
    while (ty_max3(end.point.albedo) > 0.0f && (most == 0 || path->depth < most)) {
        path->origin = ty_hit_leave(&end.hit, end.point.ng);
        path->normal = end.point.ns;
        ++path->depth;
        ty_gather_reflect_light(g, &end, out);
        for (int c = 0; c < 3; ++c) path->beta[c] *= end.point.albedo[c];
        const float before = ty_sum3(path->beta); /* survival knows of albedo by itself */
        path->rr_throughput *= ty_max3(end.point.albedo);
        ty_path_sample_cosine_hemisphere(path);
        if (!(ty_dot(end.point.ng, path->direction) > 0.0f)) return;
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

/* A place off the surface: as far as light goes before it scatters, but not near the next surface. */
TY_FN ty_vec ty_gather_off(const ty_gather* g) {
    const ty_scene_view* scene = g->request->path.scene;
    ty_segment segment;
    ty_hit hit;
    if (ty_dot(g->face, g->face) == 0.0f) return g->position;
    const bool met = scene->mesh != NULL && ty_accel_intersect(scene->mesh, g->from, g->face, TY_FLOAT_MAX, &hit);
    ty_gather_segment(g, g->from, g->face, met ? hit.distance : TY_FLOAT_MAX, &segment);
    const float room = met ? hit.distance : segment.leave;
    const float free = segment.leave / ty_maxf(ty_max3(segment.depth), 1e-6f);
    return ty_mad(g->position, g->face, ty_maxf(g->receiver->margin, 0.5f * ty_minf(room, free)));
}

/* Light of a light that the receiver sees; false where it sees none. */
TY_FN bool ty_gather_light(ty_gather* g, ty_seen_light* seen) {
    float basis[TY_BAKE_TERMS_MAX], straight[3];
    if (!ty_gather_see_light(g, g->face, seen)) return false;
    ty_gather_basis(g, seen->sample.wi, basis);
    for (int c = 0; c < 3; ++c) straight[c] = seen->sample.radiance[c] * seen->weight * seen->segment.transmittance[c];
    ty_gather_keep_all(g, TY_BAKE_DIRECT, straight, basis);
    return true;
}

/* What the path's first ray met, and all that follows. */
TY_FN void ty_gather_ahead(ty_gather* g, const ty_intersection* end, const ty_segment* segment) {
    const ty_vec direction = g->path.direction;
    const float weight = 1.0f / g->path.pdf;
    float basis[TY_BAKE_TERMS_MAX], light[3] = {0.0f, 0.0f, 0.0f};
    ty_gather_basis(g, direction, basis);
    if (g->request->fog_alone == 0) {
        for (int c = 0; c < 3; ++c) g->path.beta[c] = weight;
        ty_gather_meet(g, end, segment, light);
        ty_gather_keep_all(g, TY_BAKE_DIRECT, light, basis);
    }
    if (end == NULL) return;
    if (ty_gather_scatters(g)) {
        /* Light that media sent to the surface. */
        ty_senders_fog(g->request->senders, end->hit.position, end->point.ns, light);
        for (int c = 0; c < 3; ++c)
            light[c] *= weight * segment->transmittance[c] * end->point.albedo[c] * (1.0f / TY_PI);
        ty_gather_keep_all(g, TY_BAKE_MULTIPLE, light, basis);
    }
    if (g->request->fog_alone != 0) return;
    for (int c = 0; c < 3; ++c) g->path.beta[c] = 1.0f;
    ty_gather_follow(g, end, light);
    for (int c = 0; c < 3; ++c) light[c] *= weight * segment->transmittance[c];
    ty_gather_keep_all(g, TY_BAKE_INDIRECT, light, basis);
}

/* ---- what media make of emitters ---- */

/* What the sky sends that is never sampled as a light, from where the sample's ray leaves all. */
TY_FN void ty_gather_sky_response(ty_gather* g, float weight, const ty_segment* segment) {
    const ty_emitter emitter = {.kind = TY_IMPULSE_DIRECTIONAL, .wi = g->way, .distance = segment->leave};
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

/* What media make of light from afar. weight: of the sample. */
TY_FN void ty_gather_far_response(ty_gather* g, const ty_light_sample* sample, const ty_segment* segment,
                                  float weight) {
    const ty_emitter emitter = {
        .kind = TY_IMPULSE_DIRECTIONAL, .wi = sample->wi, .distance = segment->leave, .cosine = 1.0f};
    ty_response response;
    float strength[3];
    for (int c = 0; c < 3; ++c) strength[c] = weight * sample->radiance[c];
    if (ty_response_find(g->request, segment, &emitter, &response))
        ty_gather_keep_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

/* And of what comes from behind the receiver: what is off the surface looks for it. */
TY_FN void ty_gather_far_behind(ty_gather* g, float weight) {
    ty_path* path = &g->path;
    ty_segment segment;
    ty_light_sample sample;
    float chosen;
    path->origin = g->off;
    path->normal = ty_vec_make(0.0f, 0.0f, 0.0f);
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    if (light == NULL || !ty_light_is_far(light)) return;
    if (ty_dot(g->normal, sample.wi) > 0.0f && ty_dot(g->face, sample.wi) > 0.0f) return;
    ++g->rays;
    if (!ty_path_light_visible(path, path->origin, &sample)) return;
    ty_gather_segment(g, path->origin, sample.wi, sample.distance, &segment);
    ty_gather_far_response(g, &sample, &segment, weight / chosen);
}

/* What a sender is to the receiver; false where they see nothing of each other. What is before both looks straight;
 * else, on surfaces, what is off the receiver looks. */
TY_FN bool ty_gather_see_sender(ty_gather* g, const ty_sender* sender, ty_emitter* emitter) {
    const ty_accel* mesh = g->request->path.scene->mesh;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    *emitter = (ty_emitter){
        .kind = sender->kind, .position = sender->position, .normal = sender->normal, .area = sender->area};
    ty_emitter_look_from(emitter, g->position);
    const bool ahead = probe || (ty_dot(g->normal, emitter->wi) > 0.0f && ty_dot(g->face, emitter->wi) > 0.0f);
    const bool straight = ahead && emitter->cosine > 0.0f;
    if (!straight && (probe || g->request->back_scattering == 0 || emitter->cosine < TY_LEAST_FACING)) return false;
    const ty_vec from = straight ? g->from : g->off;
    const ty_vec way = ty_sub(ty_mad(sender->position, sender->face, sender->margin), from);
    const float length = sqrtf(ty_dot(way, way));
    if (sender->kind == TY_IMPULSE_AREA && !(ty_dot(way, sender->face) < 0.0f)) return false;
    emitter->cosine = ty_maxf(0.0f, emitter->cosine);
    ++g->rays;
    return !(length > 0.0f) || mesh == NULL ||
           !ty_accel_occluded(mesh, from, ty_scale(way, 1.0f / length), length * 0.9999f);
}

/* Cumulative chances of senders: by their power and as what scatters near one falls with distance, and what parts of
 * media send with its square. */
TY_FN void ty_gather_weigh_senders(const ty_gather* g, float* chances) {
    const ty_senders* senders = g->request->senders;
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

/* How much of a lamp's intensity goes to where it is seen along look. */
TY_FN float ty_sender_falloff(const ty_gather* g, const ty_sender* sender, ty_vec look) {
    if (sender->light < 0) return 1.0f;
    const ty_light_view* light = &g->request->path.scene->lights.lights[sender->light];
    return light->kind == TY_KIND_SPOT ? ty_spot_falloff(light, -ty_dot(look, light->direction)) : 1.0f;
}

/* Whether light from afar comes straight to the receiver, or to what is off it where that comes from behind. */
TY_FN bool ty_gather_sees_far(ty_gather* g, ty_vec toward) {
    const ty_accel* mesh = g->request->path.scene->mesh;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const bool ahead = probe || (ty_dot(g->normal, toward) > 0.0f && ty_dot(g->face, toward) > 0.0f);
    ++g->rays;
    return mesh == NULL || !ty_accel_occluded(mesh, ahead ? g->from : g->off, toward, TY_FLOAT_MAX);
}

/* A part of a medium: what it sends straight has scattered once; what media make of that, more often. Where the
 * receiver sees the light itself, the light's own response has all of this. */
TY_FN void ty_gather_lit_response(ty_gather* g, const ty_sender* sender, const ty_emitter* emitter, float amount,
                                  const ty_segment* segment) {
    ty_response response;
    float basis[TY_BAKE_TERMS_MAX], strength[3];
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    if (ty_gather_sees_far(g, sender->toward)) return;
    const float mu = ty_clampf(-ty_dot(sender->toward, ty_scale(emitter->wi, -1.0f)), -1.0f, 1.0f);
    for (int c = 0; c < 3; ++c) strength[c] = amount * sender->sends[c];
    if (probe || (ty_dot(g->normal, emitter->wi) > 0.0f && ty_dot(g->face, emitter->wi) > 0.0f)) {
        float straight[3];
        const float over = 1.0f / (TY_INV_4PI * emitter->distance * emitter->distance);
        for (int c = 0; c < 3; ++c)
            straight[c] = strength[c] * over * ty_hg(mu, sender->g[c]) * segment->transmittance[c];
        ty_gather_basis(g, emitter->wi, basis);
        ty_gather_keep_all(g, TY_BAKE_SINGLE, straight, basis);
    }
    if (g->request->scatterings > 1 && ty_response_find(g->request, segment, emitter, &response))
        ty_gather_keep_response(g, emitter, &response, strength, TY_BAKE_MULTIPLE);
}

/* One sender, number k of this receiver's. */
TY_FN void ty_gather_sender_response(ty_gather* g, uint64_t item, uint32_t k, float weight) {
    const ty_senders* senders = g->request->senders;
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
    ty_gather_segment(g, g->position, emitter.wi, emitter.distance, &segment);
    const float amount = weight / chance * sender->amount * ty_sender_falloff(g, sender, emitter.wi);
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

/* One path of TY_BAKE_PATH: through media as well. */
TY_FN void ty_gather_path(ty_gather* g) {
    ty_path* path = &g->path;
    ty_light_sample sample;
    float basis[TY_BAKE_TERMS_MAX], chosen;
    const float factor[3] = {1.0f, 1.0f, 1.0f};
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const ty_light_view* light = ty_path_choose_light(path, path->origin, &chosen, &sample);
    const float cosine = light != NULL && !probe ? ty_dot(g->normal, sample.wi) : 1.0f;
    if (light != NULL && cosine > 0.0f && (probe || ty_dot(g->face, sample.wi) > 0.0f)) {
        ty_path_add_vertex_light(path, light, chosen, &sample, factor, probe ? TY_INV_4PI : cosine * (1.0f / TY_PI),
                                 0.0f);
        ty_gather_basis(g, sample.wi, basis);
        ty_gather_keep_all(g, TY_BAKE_DIRECT, path->radiance[TY_PATH_UNCOLLIDED], basis);
        memset(path->radiance, 0, sizeof path->radiance);
    }
    if (probe)
        ty_path_sample_sphere(path);
    else
        ty_path_sample_cosine_hemisphere(path);
    if (!probe && !(ty_dot(g->face, path->direction) > 0.0f)) return;
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f / path->pdf;
    ty_gather_basis(g, path->direction, basis);
    g->rays += 2 * ty_path_follow(path);
    for (int32_t part = 0; part < TY_PATH_CLASS_COUNT; ++part) ty_gather_keep_all(g, part, path->radiance[part], basis);
}

/* Whether a sample is the one of its group that asks what media make of emitters: any, since samples that are a fixed
 * number apart have the same strata. */
TY_FN bool ty_gather_asks(const ty_bake_request* request, uint64_t item, uint32_t number) {
    const uint32_t every = request->fog_every;
    const uint64_t bits = ty_mix64(ty_mix64(item) + number / every);
    return number % every == (uint32_t)(bits >> 32) % every;
}

/* What media make of emitters. seen: the light that the sample saw, or NULL; hit: whether its ray met a surface. */
TY_FN void ty_gather_ask(ty_gather* g, uint64_t item, uint32_t number, const ty_seen_light* seen, bool hit,
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

/* One sample of a receiver; true where its ray met the back of a surface. */
TY_FN bool ty_gather_sample(ty_gather* g, uint64_t item, uint32_t number) {
    const ty_bake_request* request = g->request;
    ty_path* path = &g->path;
    const bool probe = request->terms == TY_BAKE_SH_TERMS;
    ty_intersection end;
    ty_segment segment;
    ty_seen_light light;
    ty_path_begin(path, &request->path, item, number);
    path->origin = g->from;
    path->normal = g->normal;
    if (request->method == TY_BAKE_PATH) {
        ty_gather_path(g);
        return false;
    }
    const bool seen = request->fog_alone != 0 ? ty_gather_see_light(g, g->face, &light) : ty_gather_light(g, &light);
    if (probe)
        ty_path_sample_sphere(path);
    else
        ty_path_sample_cosine_hemisphere(path);
    if (!probe && !(ty_dot(g->face, path->direction) > 0.0f)) return false;
    const bool hit = ty_gather_trace(g, &end, &segment);
    const bool blocked = hit && ty_dot(end.hit.normal, path->direction) > 0.0f;
    const bool asks = ty_gather_scatters(g) && ty_gather_asks(request, item, number);
    const float weight = 1.0f / path->pdf;
    g->way = path->direction;
    g->far = hit ? end.hit.distance : segment.leave;
    ty_gather_ahead(g, hit ? &end : NULL, &segment);
    if (asks) ty_gather_ask(g, item, number, seen ? &light : NULL, hit, weight, &segment);
    return blocked;
}

#endif
