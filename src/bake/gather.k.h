/* One path from a receiver over surfaces; media answer to each of its segments. docs/bake.md explains it. */
#ifndef TY_BAKE_GATHER_K_H
#define TY_BAKE_GATHER_K_H

#include "base/sh.k.h"
#include "bake/response.k.h"
#include "method/path/path.k.h"

/* One in so many samples, and of reflections in media, looks all around for what is near and behind. */
enum { TY_BACK_EVERY = 8 };

/* Cosines below this count as this where light that a surface scatters towards a probe is weighed. */
#define TY_LEAST_COSINE 0.03f

/* Cosines to a surface's normal below which light counts less in the vector irradiance along the surface. */
#define TY_LEAST_GRAZING 0.02f
/* A point of a flat light is no nearer than this, in parts of the light's size: what is scattered close by grows
 * without bound, but the light does not. */
#define TY_LEAST_LAMP 0.2f
/* What one segment may at most add to a path's throughput: rare paths that found dark corners would bring more. */
#define TY_MOST_FACTOR 4.0f

typedef struct ty_gather {
    const ty_bake_request* request;
    const ty_bake_receiver* receiver;
    ty_vec position, normal, face; /* of the receiver; normal 0: a probe */
    double* light;                 /* layers x 3 x terms */
    float sample[3];               /* of this sample: all layers' first terms */
    float step;                    /* m, off the surface: where rays that look behind start */
    ty_bake_sums* sums;
    float most[3], once; /* what the receiver's surroundings leave of responses (ty_bake_sums) */
    uint64_t rays;
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
TY_FN void ty_gather_zonal_basis(const ty_gather* g, const ty_response* response, const float zonal[TY_IMPULSE_TERMS],
                                 ty_vec axis, float basis[TY_BAKE_TERMS_MAX]) {
    if (g->request->terms == TY_BAKE_SH_TERMS) {
        ty_sh_all(axis, basis);
        for (int32_t l = 0, t = 0; l < TY_SH_BANDS_MAX; ++l) {
            const float turned = zonal[l] * sqrtf(4.0f * TY_PI / (float)(2 * l + 1));
            for (const int32_t end = (l + 1) * (l + 1); t < end; ++t) basis[t] *= turned;
        }
        return;
    }
    const float cosine = ty_dot(axis, g->normal), first = zonal[1] * 2.04665342f; /* sqrt(4 pi / 3) */
    basis[0] = ty_response_on(response, zonal, axis, g->normal);
    const ty_vec vector = ty_mad(ty_scale(axis, first), g->normal, basis[0] - first * cosine);
    basis[1] = vector.x;
    basis[2] = vector.y;
    basis[3] = vector.z;
}

/* Takes off what a response holds of light scattered behind the surface that the receiver's last ray met: one ray
 * stands for all directions. Returns how much irradiance, in green. */
TY_FN float ty_gather_take_beyond(ty_gather* g, const ty_emitter* emitter, const ty_response* response,
                                  const float strength[3], int32_t layer) {
    const ty_bake_sums* sums = g->sums;
    float basis[TY_BAKE_TERMS_MAX], beyond = 0.0f, green = 0.0f;
    if (!(sums->way[3] > 0.0f)) return 0.0f;
    const ty_vec direction = ty_vec_load(sums->way);
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const float weight = probe ? 1.0f / TY_INV_4PI : TY_PI / ty_dot(g->normal, direction);
    ty_gather_basis(g, direction, basis);
    for (int c = 0; c < 3; ++c) {
        if (c < response->channels)
            beyond = -weight * ty_response_beyond(emitter, &response->medium[c], direction, sums->way[3]);
        ty_gather_keep(g, layer, c, beyond * strength[c], basis);
        if (c == 1) green = -beyond * strength[1] * basis[0];
    }
    return green;
}

/* Light of an emitter that media scatter towards the receiver. single: the layer of light that scattered once. */
TY_FN void ty_gather_keep_response(ty_gather* g, const ty_emitter* emitter, const ty_response* response,
                                   const float strength[3], int32_t single) {
    float one[TY_BAKE_TERMS_MAX], more[TY_BAKE_TERMS_MAX];
    for (int c = 0; c < 3; ++c) {
        if (c < response->channels) {
            ty_gather_zonal_basis(g, response, response->channel[c].single, response->axis[c], one);
            ty_gather_zonal_basis(g, response, response->channel[c].multiple, response->axis[c], more);
        }
        ty_gather_keep(g, single, c, strength[c], one);
        ty_gather_keep(g, TY_BAKE_MULTIPLE, c, strength[c], more);
    }
    const float beyond = ty_gather_take_beyond(g, emitter, response, strength, single);
    if (single != TY_BAKE_SINGLE || !(emitter->cosine > 0.0f) || ty_dot(g->normal, emitter->look) < 0.0f) return;
    g->sums->once += (double)(strength[1] * one[0]);
    g->sums->beyond += (double)beyond;
}

/* Notes how far media go along a sample's first ray. */
TY_FN void ty_gather_note(ty_gather* g, bool hit, const ty_segment* segment, float distance) {
    ty_bake_sums* sums = g->sums;
    const ty_vec d = g->path.direction;
    const float far = hit ? distance : segment->leave;
    sums->way[0] = d.x;
    sums->way[1] = d.y;
    sums->way[2] = d.z;
    sums->way[3] = far < TY_FLOAT_MAX ? far : 0.0f;
    for (int c = 0; c < 3; ++c) {
        sums->depth[c] += (double)ty_minf(segment->depth[c], 1e6f);
        sums->stopped[c] += (double)ty_stopped(segment->depth[c]);
        g->most[c] = ty_response_most(sums->depth[c], sums->stopped[c]);
    }
    if (sums->once > 0) g->once = ty_clampf((float)(1 - sums->beyond / sums->once), 0.2f, 1.0f);
}

/* ---- emitters ---- */

/* A light, by its sample from a point. */
TY_FN void ty_emitter_of_light(const ty_light_view* light, const ty_light_sample* sample, ty_vec from,
                               const ty_segment* segment, float weight, ty_emitter* out) {
    const float d2 = sample->distance * sample->distance;
    float factor = weight * d2;
    out->kind = TY_IMPULSE_POINT;
    out->look = sample->look;
    out->distance = sample->distance;
    out->cosine = 1.0f;
    if (light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_ENVIRONMENT) {
        out->kind = TY_IMPULSE_DIRECTIONAL;
        out->distance = segment->leave;
        factor = weight;
    } else if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE) {
        const float mu = ty_light_facing(light, sample->look);
        out->kind = TY_IMPULSE_AREA;
        out->cosine = mu;
        out->distance = ty_maxf(out->distance, TY_LEAST_LAMP * sqrtf(light->area));
        out->normal = ty_scale(light->direction, ty_dot(light->direction, sample->look) < 0.0f ? 1.0f : -1.0f);
        factor = weight * d2 / mu;
    } else if (light->kind == TY_KIND_SPHERE) {
        const ty_vec to = ty_sub(light->position, from);
        out->distance = sqrtf(ty_dot(to, to));
        out->look = ty_scale(to, 1.0f / out->distance);
        for (int c = 0; c < 3; ++c) out->strength[c] = weight * light->color[c] * TY_PI * light->radius * light->radius;
        return;
    }
    for (int c = 0; c < 3; ++c) out->strength[c] = factor * sample->radiance[c];
}

/* A surface that a ray from `from` met; its strength is left alone. */
TY_FN void ty_emitter_of_surface(const ty_encounter* end, ty_vec from, ty_emitter* out) {
    const ty_vec to = ty_sub(end->hit.position, from);
    out->kind = TY_IMPULSE_AREA;
    out->distance = sqrtf(ty_dot(to, to));
    out->look = ty_scale(to, 1.0f / out->distance);
    out->normal = end->point.facing;
    out->cosine = ty_maxf(0.0f, -ty_dot(out->normal, out->look));
}

/* ---- segments ---- */

TY_FN void ty_gather_segment(const ty_gather* g, ty_vec from, ty_vec direction, float far, ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    segment->point = NULL;
    ty_segment_find(segment, scene->media, scene->medium_count, from, direction, far);
}

/* The path's ray to its end, and the media on it; false where it meets no surface. */
TY_FN bool ty_gather_trace(ty_gather* g, ty_encounter* end, ty_segment* segment) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_path* path = &g->path;
    ++g->rays;
    const bool hit =
        scene->mesh != NULL && ty_mesh_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    if (hit) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    ty_gather_segment(g, path->origin, path->direction, hit ? end->hit.distance : TY_FLOAT_MAX, segment);
    return hit;
}

/* A light that the path's vertex sees, and the media in between. weight: of its light that goes straight to the vertex,
 * which may take that direction itself, with density cosine / pi (surfaces) or evenly (probes). */
typedef struct ty_seen_light {
    const ty_light_view* light;
    ty_light_sample sample;
    ty_segment segment;
    float chosen, weight, cosine;
} ty_seen_light;

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

/* ---- where light is looked for ---- */

/* A point on a surface that gathers light: by cosine-distributed rays from it, ahead per sample, and by even ones from
 * a place off the surface, around per sample. Together they find what is near its plane, too. */
typedef struct ty_gatherer {
    ty_vec position, normal, face, off;
    float ahead, around;
} ty_gatherer;

/* The area that a surface point stands for which a ray found. */
TY_FN float ty_gatherer_area(const ty_gatherer* at, const ty_encounter* end, const ty_emitter* emitter) {
    const float d2 = ty_maxf(emitter->distance * emitter->distance, 1e-20f);
    const ty_vec way = ty_sub(end->hit.position, at->off);
    const float w2 = ty_maxf(ty_dot(way, way), 1e-20f);
    const float aside = ty_maxf(0.05f, -ty_dot(way, end->point.facing) / sqrtf(w2));
    const float cosine = ty_dot(at->normal, emitter->look);
    float density = at->around * aside * TY_INV_4PI / w2;
    if (cosine > 0.0f && ty_dot(at->face, emitter->look) > 0.0f)
        density += at->ahead * cosine * emitter->cosine / (TY_PI * d2);
    return density > 0.0f ? 1.0f / density : 0.0f;
}

/* Whether what an even ray found counts: without back-scattering, what lies in or behind the plane does not, and
 * nothing comes from behind a surface. */
TY_FN bool ty_gatherer_counts(const ty_gatherer* at, const ty_encounter* end, int32_t back_scattering) {
    const ty_vec to = ty_sub(end->hit.position, at->position);
    const float distance = sqrtf(ty_dot(to, to));
    if (!(distance > 0.0f) || -ty_dot(to, end->point.facing) < -0.1f * distance) return false;
    return back_scattering != 0 || ty_dot(to, at->face) > 0.01f * distance;
}

/* A light seen from off a surface that sends nothing straight to it: it is behind, or turned away. weight: of its
 * light. */
TY_FN bool ty_gather_light_aside(ty_gather* g, const ty_gatherer* at, float weight, ty_emitter* emitter,
                                 ty_response* response) {
    ty_path* path = &g->path;
    ty_seen_light seen;
    path->origin = at->off;
    path->normal = ty_vec_make(0.0f, 0.0f, 0.0f);
    if (!ty_gather_see_light(g, at->face, &seen)) return false;
    ty_emitter_of_light(seen.light, &seen.sample, path->origin, &seen.segment, weight / seen.chosen, emitter);
    if (emitter->kind != TY_IMPULSE_DIRECTIONAL) {
        const ty_vec to = ty_sub(ty_mad(path->origin, emitter->look, emitter->distance), at->position);
        emitter->distance = sqrtf(ty_dot(to, to));
        emitter->look = ty_scale(to, 1.0f / emitter->distance);
        if (emitter->kind == TY_IMPULSE_AREA) emitter->cosine = -ty_dot(emitter->normal, emitter->look);
    }
    const bool ahead = ty_dot(at->normal, emitter->look) > 0.0f && ty_dot(at->face, emitter->look) > 0.0f;
    if (ahead ? emitter->cosine > 0.0f : g->request->back_scattering == 0) return false;
    emitter->cosine = ty_maxf(0.0f, emitter->cosine);
    if (emitter->kind == TY_IMPULSE_AREA)
        emitter->distance = ty_maxf(emitter->distance, TY_LEAST_LAMP * sqrtf(seen.light->area));
    return ty_response_find(g->request, &seen.segment, emitter, g->most, response);
}

/* ---- light that leaves a surface ---- */

/* Radiance, up to what the ray that found the surface lost: of light that only surfaces reflected, and of all. */
typedef struct ty_leaving {
    float clear[3], all[3];
} ty_leaving;

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

/* Irradiance on a surface of light scattered on the way from where a ray of the path ends: per radiance of a surface,
 * or of the sky (end NULL), of the part of directions that the ray stands for. */
TY_FN void ty_gather_scattered(const ty_gather* g, const ty_gatherer* at, const ty_encounter* end,
                               const ty_segment* segment, float irradiance[3]) {
    ty_emitter emitter;
    ty_response response;
    float amount = 1.0f / (g->path.pdf * at->ahead);
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    if (end != NULL) {
        ty_emitter_of_surface(end, at->position, &emitter);
        amount = ty_gatherer_area(at, end, &emitter);
    } else {
        emitter.kind = TY_IMPULSE_DIRECTIONAL;
        emitter.look = g->path.direction;
        emitter.distance = segment->leave;
        emitter.cosine = 1.0f;
    }
    if (!ty_response_find(g->request, segment, &emitter, g->most, &response)) return;
    ty_response_irradiance(&response, at->normal, g->once, irradiance);
    for (int c = 0; c < 3; ++c) irradiance[c] *= amount;
}

/* What one light sends over a surface point; false where none is seen. */
TY_FN bool ty_gather_reflect_light(ty_gather* g, const ty_encounter* at, const float clear[3], ty_leaving* out) {
    ty_path* path = &g->path;
    ty_seen_light seen;
    float scattered[3] = {0.0f, 0.0f, 0.0f};
    if (!ty_gather_see_light(g, at->point.facing, &seen)) return false;
    if (ty_gather_scatters(g)) {
        ty_emitter emitter;
        ty_response response;
        ty_emitter_of_light(seen.light, &seen.sample, path->origin, &seen.segment, 1.0f / seen.chosen, &emitter);
        if (ty_response_find(g->request, &seen.segment, &emitter, g->most, &response)) {
            ty_response_irradiance(&response, path->normal, g->once, scattered);
            for (int c = 0; c < 3; ++c) scattered[c] *= emitter.strength[c];
        }
    }
    for (int c = 0; c < 3; ++c) {
        const float reflects = at->point.albedo[c] * (1.0f / TY_PI);
        const float straight = seen.sample.radiance[c] * seen.weight * seen.cosine * seen.segment.transmittance[c];
        out->clear[c] += clear[c] * reflects * straight;
        out->all[c] += path->beta[c] * reflects * (straight + scattered[c]);
    }
    return true;
}

/* Light that the path's ray meets, on a surface (end) or beyond all (NULL). ahead: the weight of what comes straight
 * along it. */
TY_FN void ty_gather_meet(ty_gather* g, const ty_encounter* end, const ty_segment* segment, const float clear[3],
                          float ahead, const float scattered[3], ty_leaving* out) {
    float radiance[3], rest[3];
    if (end != NULL) {
        if (!(ty_max3(end->point.emission) > 0.0f)) return;
        const float weight = ty_path_met_weight(&g->path, end);
        for (int c = 0; c < 3; ++c) {
            radiance[c] = end->point.emission[c] * weight;
            rest[c] = end->point.light < 0 ? end->point.emission[c] : 0.0f;
        }
    } else {
        ty_gather_sky(g, true, radiance);
        ty_gather_sky(g, false, rest);
    }
    for (int c = 0; c < 3; ++c) {
        const float straight = ahead * segment->transmittance[c] * radiance[c];
        out->clear[c] += clear[c] * straight;
        out->all[c] += g->path.beta[c] * (straight + scattered[c] * (1.0f / TY_PI) * rest[c]);
    }
}

/* The path's next surface, found by a ray that goes all around; false where there is none. factor: of its radiance. */
TY_FN bool ty_gather_around(ty_gather* g, const ty_gatherer* at, ty_encounter* end, float factor[3], ty_leaving* out) {
    const ty_scene_view* scene = g->request->path.scene;
    ty_path* path = &g->path;
    ty_segment segment;
    ty_path_turn_anywhere(path);
    ++g->rays;
    if (!ty_mesh_intersect(scene->mesh, at->off, path->direction, TY_FLOAT_MAX, &end->hit)) return false;
    ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    if (!ty_gatherer_counts(at, end, g->request->back_scattering)) return false;
    const ty_vec to = ty_sub(end->hit.position, at->position);
    const float distance = sqrtf(ty_dot(to, to));
    ty_gather_segment(g, at->position, ty_scale(to, 1.0f / distance), distance, &segment);
    ty_gather_scattered(g, at, end, &segment, factor);
    for (int c = 0; c < 3; ++c) {
        factor[c] *= 1.0f / TY_PI;
        if (end->point.light < 0) out->all[c] += path->beta[c] * factor[c] * end->point.emission[c];
    }
    return true;
}

/* The path's next surface, found by a ray that light comes straight along. */
TY_FN bool ty_gather_onward(ty_gather* g, const ty_gatherer* at, ty_encounter* end, float clear[3], float factor[3],
                            ty_leaving* out) {
    ty_segment segment;
    float scattered[3] = {0.0f, 0.0f, 0.0f};
    const float weight = 1.0f / at->ahead;
    const bool hit = ty_gather_trace(g, end, &segment);
    if (ty_gather_scatters(g)) ty_gather_scattered(g, at, hit ? end : NULL, &segment, scattered);
    ty_gather_meet(g, hit ? end : NULL, &segment, clear, weight, scattered, out);
    for (int c = 0; c < 3; ++c) {
        factor[c] = weight * segment.transmittance[c] + scattered[c] * (1.0f / TY_PI);
        clear[c] *= weight * segment.transmittance[c];
    }
    return hit;
}

/* What lights that send nothing straight to a surface point send over it. weight: of their light. */
TY_FN void ty_gather_reflect_aside(ty_gather* g, const ty_gatherer* at, const ty_encounter* end, float weight,
                                   ty_leaving* out) {
    ty_emitter emitter;
    ty_response response;
    float scattered[3];
    if (!ty_gather_light_aside(g, at, weight, &emitter, &response)) return;
    ty_response_irradiance(&response, at->normal, g->once, scattered);
    for (int c = 0; c < 3; ++c)
        out->all[c] += g->path.beta[c] * end->point.albedo[c] * (1.0f / TY_PI) * scattered[c] * emitter.strength[c];
}

/* Where nothing is seen that sends light straight on, what is aside is looked for, and else every now and then; returns
 * the weight of what is found, 0: it is not looked for. */
TY_FN float ty_gather_look_aside(bool seen, bool now) {
    return !seen ? 1.0f : now ? (float)TY_BACK_EVERY : 0.0f;
}

/* The path stands where it has just arrived: at a surface. */
TY_FN ty_gatherer ty_gather_stand(ty_gather* g, const ty_encounter* end) {
    ty_path* path = &g->path;
    ty_gatherer at = {.normal = end->point.normal, .face = end->point.facing, .ahead = 1.0f};
    at.position = ty_hit_leave(&end->hit, at.face);
    at.off = ty_mad(at.position, path->direction, -ty_minf(g->step, 0.5f * end->hit.distance));
    path->origin = at.position;
    path->normal = at.normal;
    if (!ty_gather_scatters(g)) return at;
    at.around = 1.0f / (float)TY_BACK_EVERY;
    at.ahead = 1.0f - at.around;
    return at;
}

/* Follows the path from the surface at *start, which it has just reached. */
TY_FN void ty_gather_follow(ty_gather* g, const ty_encounter* start, ty_leaving* out) {
    ty_path* path = &g->path;
    const int32_t most = path->request->max_depth;
    ty_encounter end = *start;
    float clear[3] = {1.0f, 1.0f, 1.0f}, factor[3];
    memset(out, 0, sizeof *out);
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f;
    path->survival = 1.0f;
    path->depth = 0;
    while (ty_max3(end.point.albedo) > 0.0f && (most == 0 || path->depth < most)) {
        const ty_gatherer at = ty_gather_stand(g, &end);
        ++path->depth;
        const bool seen = ty_gather_reflect_light(g, &end, clear, out);
        const bool around = at.around > 0.0f && ty_random_white(&path->random) < at.around;
        const float aside = at.around > 0.0f ? ty_gather_look_aside(seen, around) : 0.0f;
        if (aside > 0.0f) {
            ty_gather_reflect_aside(g, &at, &end, aside, out);
            path->origin = at.position;
            path->normal = at.normal;
        }
        const float before = ty_sum3(path->beta);
        for (int c = 0; c < 3; ++c) {
            path->beta[c] *= end.point.albedo[c];
            clear[c] *= end.point.albedo[c];
        }
        path->survival *= ty_max3(end.point.albedo);
        if (around) {
            for (int c = 0; c < 3; ++c) clear[c] = 0.0f;
            if (!ty_gather_around(g, &at, &end, factor, out)) return;
        } else {
            ty_path_turn(path);
            if (!(ty_dot(end.point.facing, path->direction) > 0.0f)) return;
            if (!ty_gather_onward(g, &at, &end, clear, factor, out)) return;
        }
        for (int c = 0; c < 3; ++c) path->beta[c] *= ty_minf(factor[c], TY_MOST_FACTOR);
        const float now = ty_sum3(path->beta);
        if (!ty_path_survives(path, before)) return;
        const float kept = ty_sum3(path->beta) / now;
        for (int c = 0; c < 3; ++c) clear[c] *= kept;
    }
}

/* ---- at the receiver ---- */

TY_FN ty_gatherer ty_gather_receiver(const ty_gather* g) {
    return (ty_gatherer){.position = ty_mad(g->position, g->face, g->receiver->margin),
                         .normal = g->normal,
                         .face = g->face,
                         .off = ty_mad(g->position, g->face, g->step),
                         .ahead = 1.0f,
                         .around = 1.0f / (float)TY_BACK_EVERY};
}

TY_FN bool ty_gather_light(ty_gather* g) {
    ty_path* path = &g->path;
    ty_seen_light seen;
    float basis[TY_BAKE_TERMS_MAX], straight[3];
    if (!ty_gather_see_light(g, g->face, &seen)) return false;
    ty_gather_basis(g, seen.sample.look, basis);
    for (int c = 0; c < 3; ++c) straight[c] = seen.sample.radiance[c] * seen.weight * seen.segment.transmittance[c];
    ty_gather_keep_all(g, TY_BAKE_DIRECT, straight, basis);
    if (!ty_gather_scatters(g)) return true;
    ty_emitter emitter;
    ty_response response;
    ty_emitter_of_light(seen.light, &seen.sample, path->origin, &seen.segment, 1.0f / seen.chosen, &emitter);
    if (ty_response_find(g->request, &seen.segment, &emitter, g->most, &response))
        ty_gather_keep_response(g, &emitter, &response, emitter.strength, TY_BAKE_SINGLE);
    return true;
}

/* Light that a surface point sends out and media scatter towards the receiver. */
TY_FN void ty_gather_surface_response(ty_gather* g, const ty_encounter* end, const ty_segment* segment,
                                      const ty_leaving* leaving) {
    ty_emitter emitter;
    ty_response response;
    float strength[3];
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    ty_emitter_of_surface(end, g->position, &emitter);
    const ty_gatherer at = ty_gather_receiver(g);
    const float d2 = emitter.distance * emitter.distance;
    const float area =
        probe ? d2 / (ty_maxf(emitter.cosine, TY_LEAST_COSINE) * TY_INV_4PI) : ty_gatherer_area(&at, end, &emitter);
    if (!(area > 0.0f) || !ty_response_find(g->request, segment, &emitter, g->most, &response)) return;
    for (int c = 0; c < 3; ++c) strength[c] = area * leaving->all[c];
    ty_gather_keep_response(g, &emitter, &response, strength, TY_BAKE_MULTIPLE);
    if (!(ty_max3(end->point.emission) > 0.0f) || end->point.light >= 0) return;
    for (int c = 0; c < 3; ++c) strength[c] = area * end->point.emission[c];
    ty_gather_keep_response(g, &emitter, &response, strength, TY_BAKE_SINGLE);
}

/* What the path's first ray met, and all that follows. */
TY_FN void ty_gather_ahead(ty_gather* g, ty_encounter* end, bool hit, const ty_segment* segment) {
    ty_path* path = &g->path;
    const float weight = 1.0f / path->pdf;
    const bool scatters = ty_gather_scatters(g);
    const ty_vec direction = path->direction;
    float basis[TY_BAKE_TERMS_MAX], clear[3], rest[3] = {0.0f, 0.0f, 0.0f};
    const float one[3] = {1.0f, 1.0f, 1.0f};
    ty_leaving leaving;
    memset(&leaving, 0, sizeof leaving);
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f;
    ty_gather_basis(g, direction, basis);
    ty_gather_meet(g, hit ? end : NULL, segment, one, 1.0f, rest, &leaving);
    for (int c = 0; c < 3; ++c) clear[c] = weight * leaving.clear[c];
    ty_gather_keep_all(g, TY_BAKE_DIRECT, clear, basis);
    if (!hit) {
        if (!scatters) return;
        const ty_emitter emitter = {.kind = TY_IMPULSE_DIRECTIONAL, .look = direction, .distance = segment->leave};
        ty_response response;
        ty_gather_sky(g, false, rest);
        for (int c = 0; c < 3; ++c) rest[c] *= weight;
        if (ty_max3(rest) > 0.0f && ty_response_find(g->request, segment, &emitter, g->most, &response))
            ty_gather_keep_response(g, &emitter, &response, rest, TY_BAKE_SINGLE);
        return;
    }
    ty_gather_follow(g, end, &leaving);
    for (int c = 0; c < 3; ++c) {
        const float passing = weight * segment->transmittance[c];
        clear[c] = passing * leaving.clear[c];
        rest[c] = passing * (leaving.all[c] - leaving.clear[c]);
    }
    ty_gather_keep_all(g, TY_BAKE_INDIRECT, clear, basis);
    if (!scatters) return;
    ty_gather_keep_all(g, TY_BAKE_MULTIPLE, rest, basis);
    ty_gather_surface_response(g, end, segment, &leaving);
}

/* Lights that send nothing straight to the receiver. */
TY_FN void ty_gather_receive_aside(ty_gather* g, float weight) {
    const ty_gatherer at = ty_gather_receiver(g);
    ty_emitter emitter;
    ty_response response;
    if (ty_gather_light_aside(g, &at, weight, &emitter, &response))
        ty_gather_keep_response(g, &emitter, &response, emitter.strength, TY_BAKE_SINGLE);
    g->path.origin = at.position;
    g->path.normal = at.normal;
}

/* From off the surface to anywhere: what is there sends light into the medium, in front or behind. */
TY_FN void ty_gather_behind(ty_gather* g) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_gatherer at = ty_gather_receiver(g);
    ty_path* path = &g->path;
    ty_encounter end;
    ty_segment segment;
    ty_leaving leaving;
    path->origin = at.off;
    ty_path_turn_anywhere(path);
    ++g->rays;
    if (scene->mesh == NULL || !ty_mesh_intersect(scene->mesh, at.off, path->direction, TY_FLOAT_MAX, &end.hit)) return;
    ty_surface_evaluate(&scene->surfaces[end.hit.surface], &end.hit, path->direction, &end.point);
    if (!ty_gatherer_counts(&at, &end, g->request->back_scattering)) return;
    const ty_vec to = ty_sub(end.hit.position, at.position);
    const float distance = sqrtf(ty_dot(to, to));
    ty_gather_segment(g, at.position, ty_scale(to, 1.0f / distance), distance, &segment);
    ty_gather_follow(g, &end, &leaving);
    ty_gather_surface_response(g, &end, &segment, &leaving);
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
    ty_path* path = &g->path;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    ty_encounter end;
    ty_segment segment;
    ty_path_begin(path, &g->request->path, item, number);
    path->origin = ty_mad(g->position, g->face, g->receiver->margin);
    path->normal = g->normal;
    if (g->request->method == TY_BAKE_PATH) {
        ty_gather_path(g);
        return false;
    }
    const bool scatters = ty_gather_scatters(g), seen = ty_gather_light(g);
    const float aside = scatters && !probe ? ty_gather_look_aside(seen, number % TY_BACK_EVERY == 0) : 0.0f;
    if (aside > 0.0f) ty_gather_receive_aside(g, aside);
    if (probe)
        ty_path_turn_anywhere(path);
    else
        ty_path_turn(path);
    if (!probe && !(ty_dot(g->face, path->direction) > 0.0f)) return false;
    const bool hit = ty_gather_trace(g, &end, &segment);
    const bool blocked = hit && ty_dot(end.hit.normal, path->direction) > 0.0f;
    const float distance = hit ? end.hit.distance : TY_FLOAT_MAX;
    const ty_vec direction = path->direction;
    ty_gather_ahead(g, &end, hit, &segment);
    path->direction = direction;
    if (scatters) ty_gather_note(g, hit, &segment, distance);
    return blocked;
}

#endif
