/* One ray through the media: docs/marching.md explains it. */
#ifndef TY_IMAGE_MARCH_K_H
#define TY_IMAGE_MARCH_K_H

#include "image/near.k.h"
#include "image/track.k.h"

/* Transmittance below which a ray ends: nothing behind can be seen any more. */
#define TY_MARCH_BLACK 1e-5f
/* Optical depth of pieces that light is looked up in at most, and of steps before they end. */
#define TY_MARCH_PIECE 0.7f
#define TY_MARCH_STEP 0.5f

/* What a ray brings. */
typedef struct ty_march_light {
    float transmittance[3], glow[3], single[3], multiple[3];
    float aside[3]; /* transmittance for light that may scatter nearly straight on: with a fit alone */
} ty_march_light;

typedef struct ty_march_ray {
    TY_GLOBAL const ty_march_request* request;
    ty_vec origin, direction;
    int32_t count, active_count;
    int32_t active[TY_SPANS_MAX];
    float begin;   /* of the step, m along the ray */
    float offset;  /* where the first step of a stretch ends, of a step */
    float longer;  /* times which steps are longer than the request's */
    float growth;  /* of the stretch, see ty_track */
    float depth;   /* of the step so far, in the channel that counts most */
    float piece;   /* optical depth of a piece at most */
    int32_t looks; /* whether there is any light to look up */
    uint32_t steps;
    ty_march_light light;
    ty_track tracks[TY_SPANS_MAX];
} ty_march_ray;

/* ---- a step's light ---- */

/* What all media scatter of a step: the integral of their scattering coefficients, and the same times mean cosines, and
 * their cubes. */
typedef struct ty_march_scattering {
    float amount[3], forward[3], third[3];
} ty_march_scattering;

/* How much is seen of what a step sends: transmittance times the mean decay over it; aside: of what may scatter nearly
 * straight on on its way, which is the same without a fit. */
typedef struct ty_march_reach {
    float all[3], aside[3];
} ty_march_reach;

/* What one medium scatters and sends at a point, times how much of it is seen. Adds to scattering what the field's
 * light is scattered by. */
TY_FN void ty_march_shine(ty_march_ray* ray, const ty_track* track, ty_vec point, const ty_near_light* lights,
                          const ty_march_reach* reach, ty_march_scattering* scattering) {
    TY_GLOBAL const ty_march_request* request = ray->request;
    float sigma_s[3], g[3];
    ty_medium_sigma_s(track->medium, point, sigma_s);
    ty_medium_g(track->medium, point, g);
    for (int32_t c = 0; c < 3; ++c) {
        scattering->amount[c] += sigma_s[c] * track->amount;
        scattering->forward[c] += g[c] * sigma_s[c] * track->amount;
        scattering->third[c] += g[c] * g[c] * g[c] * sigma_s[c] * track->amount;
    }
    if (track->medium->emits != 0) {
        float glow[3];
        ty_medium_emission(track->medium, point, glow);
        for (int32_t c = 0; c < 3; ++c)
            ray->light.glow[c] +=
                reach->all[c] * track->amount * glow[c] * ty_maxf(0.0f, track->medium->sigma_t[c] - sigma_s[c]);
    }
    if (request->light_count == 0) return;
    const ty_vec way = ty_scale(ray->direction, -1.0f);
    ty_single_sent sent;
    memset(&sent, 0, sizeof sent);
    for (int32_t i = 0; i < request->light_count; ++i)
        ty_single_scattered(&request->lights[i], point, &lights[i].at, way, lights[i].passing, g, &request->fit, &sent);
    for (int32_t c = 0; c < 3; ++c) {
        const float amount = track->amount * sigma_s[c], seen = reach->all[c] * amount;
        ray->light.single[c] += seen * sent.first[c];
        ray->light.multiple[c] += seen * sent.again[c] + reach->aside[c] * amount * sent.aside[c];
    }
}

/* What the step's optical depths are, and where in it light is looked up: where its matter is in the mean, moved by how
 * much more of the near side is seen. False where there is nothing. */
TY_FN bool ty_march_weigh(const ty_march_ray* ray, float end, float depth[3], float* at) {
    float moment = 0.0f, mean = 0.0f;
    for (int c = 0; c < 3; ++c) depth[c] = 0.0f;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        for (int c = 0; c < 3; ++c) depth[c] += track->medium->sigma_t[c] * track->amount;
        mean += track->mean * track->amount;
        moment += track->mean * track->moment;
    }
    if (!(mean > 0.0f)) return false;
    const float length = end - ray->begin;
    *at = ray->begin + ty_clampf(moment / mean - length * mean * (1.0f / 12.0f), 0.0f, length);
    return true;
}

/* The extinction at a place itself, mean of the channels, 1/m: means over steps differ from pixel to pixel, and show.
 */
TY_FN float ty_march_extinction(const ty_march_ray* ray, float at) {
    float extinction = 0.0f;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        if (track->amount > 0.0f) extinction += ty_track_extinction(track, at);
    }
    return extinction;
}

/* Adds the field's term sigma_s phi of the source at a point: Eq. 8 (Koerner 2014). */
TY_FN void ty_march_add_field(ty_march_ray* ray, ty_vec point, float extinction, const float reach[3],
                              const ty_march_scattering* scattering) {
    float even[3], directed[3], third[3];
    ty_upsample(&ray->request->field, point, extinction, ty_scale(ray->direction, -1.0f), even, directed, third);
    for (int c = 0; c < 3; ++c) {
        const float sent =
            scattering->amount[c] * even[c] + scattering->forward[c] * directed[c] + scattering->third[c] * third[c];
        ray->light.multiple[c] += reach[c] * ty_maxf(0.0f, sent);
    }
}

/* Looks up what reaches the eye from a step around a place `at` metres along. */
TY_FN void ty_march_add(ty_march_ray* ray, float at, const ty_march_reach* reach) {
    TY_GLOBAL const ty_march_request* request = ray->request;
    ty_march_scattering scattering = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    ty_near_light lights[TY_MARCH_LIGHTS_MAX];
    const ty_vec point = ty_mad(ray->origin, ray->direction, at);
    const float extinction = ty_march_extinction(ray, at);
    ty_near_look(request, point, extinction, lights);
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        if (track->amount > 0.0f) ty_march_shine(ray, track, point, lights, reach, &scattering);
    }
    if (request->has_field != 0) ty_march_add_field(ray, point, extinction, reach->aside, &scattering);
    ++ray->steps;
}

/* Channels that are black count no more for how long steps are; false when all are. */
TY_FN bool ty_march_dim(ty_march_ray* ray) {
    const float* passed = ray->light.aside;
    const bool live[3] = {passed[0] >= TY_MARCH_BLACK, passed[1] >= TY_MARCH_BLACK, passed[2] >= TY_MARCH_BLACK};
    if (live[0] && live[1] && live[2]) return true;
    for (int32_t i = 0; i < ray->count; ++i) {
        ty_track* track = &ray->tracks[i];
        track->live = 0.0f;
        for (int c = 0; c < 3; ++c)
            if (live[c]) track->live = ty_maxf(track->live, track->medium->sigma_t[c]);
    }
    return live[0] || live[1] || live[2];
}

/* Of a step of these optical depths, what is seen; dims what is behind it. */
TY_FN void ty_march_pass(const float depth[3], float transmittance[3], float reach[3]) {
    for (int c = 0; c < 3; ++c) {
        const float decay = ty_decay(depth[c]);
        reach[c] = transmittance[c] * ty_mean_decay(depth[c], decay);
        transmittance[c] *= decay;
    }
}

/* Takes from a step's optical depths what scatters nearly straight on in it. */
TY_FN void ty_march_reduce(const ty_march_ray* ray, float at, float depth[3]) {
    const ty_vec point = ty_mad(ray->origin, ray->direction, at);
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        float sigma_s[3];
        if (!(track->amount > 0.0f)) continue;
        ty_medium_sigma_s(track->medium, point, sigma_s);
        for (int c = 0; c < 3; ++c)
            depth[c] = ty_maxf(0.0f, depth[c] - ray->request->fit.straight * sigma_s[c] * track->amount);
    }
}

/* Ends a step; false when nothing behind it is seen. */
TY_FN bool ty_march_end_step(ty_march_ray* ray, float end) {
    ty_march_reach reach;
    float depth[3], at;
    const bool dense = ty_march_weigh(ray, end, depth, &at);
    if (dense) {
        ty_march_pass(depth, ray->light.transmittance, reach.all);
        if (ray->request->fit.bands > 0) {
            ty_march_reduce(ray, at, depth);
            ty_march_pass(depth, ray->light.aside, reach.aside);
        } else {
            for (int c = 0; c < 3; ++c) {
                reach.aside[c] = reach.all[c];
                ray->light.aside[c] = ray->light.transmittance[c];
            }
        }
        if (ray->looks != 0) ty_march_add(ray, at, &reach);
    }
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        track->amount = track->moment = 0.0f;
    }
    ray->begin = end;
    ray->depth = 0.0f;
    return !dense || ty_march_dim(ray);
}

/* ---- stretches ---- */

/* Looks at the piece from t to end in all media; returns its optical depth. */
TY_FN float ty_march_look(ty_march_ray* ray, float t, float end) {
    float depth = 0.0f;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        depth += track->live * ty_track_look(track, t, end);
    }
    return depth;
}

/* The next piece begins at t; returns where it ends: where any medium's voxels do, at `most` if not before. */
TY_FN float ty_march_piece(ty_march_ray* ray, float t, float most) {
    float end = most;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        if (track->cell_leave <= t) ty_track_advance(track, t);
        end = ty_minf(end, track->cell_leave);
    }
    float depth = ty_march_look(ray, t, end);
    if (depth > ray->piece) {
        const float shorter = t + (end - t) * ray->piece / depth;
        if (shorter > t) {
            end = shorter;
            depth = ty_march_look(ray, t, end);
        }
    }
    for (int32_t i = 0; i < ray->active_count; ++i) ty_track_take(&ray->tracks[ray->active[i]], ray->begin, t, end);
    ray->depth += depth;
    return end;
}

/* Steps where all but a little is hidden may err by more: an error that rises with the square of the length is least in
 * all, for as many steps, if lengths go with transmittance^(-1/3); this is close to that, and bounded. */
TY_FN float ty_march_grown(const ty_march_ray* ray) {
    const float* passed = ray->light.aside;
    const float hidden = 1.0f - ty_maxf(passed[0], ty_maxf(passed[1], passed[2]));
    return 1.0f + ray->growth * hidden * hidden;
}

/* Goes from t to end, within which the same media are there; false when nothing behind is seen. */
TY_FN bool ty_march_stretch(ty_march_ray* ray, float t, float end) {
    float step = TY_FLOAT_MAX, slack = 0.0f;
    ray->growth = TY_FLOAT_MAX;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        ty_track_find(track, t);
        step = ty_minf(step, track->step);
        ray->growth = ty_minf(ray->growth, track->growth);
        if (track->medium->has_grid != 0) slack = 0.5f;
    }
    const bool even = step >= TY_FLOAT_MAX;
    step = even ? step : step * ray->request->step * ray->longer;
    /* Steps end where voxels do, if that is near: a piece less. */
    slack = even ? 0.0f : slack * step;
    float grown = even ? 1.0f : ty_march_grown(ray);
    float until = even ? step : t + step * grown * ray->offset;
    ray->begin = t;
    ray->piece = even ? TY_FLOAT_MAX : TY_MARCH_PIECE;
    /* Where media are dense, it is depth that the first step is cut short in. */
    const float first = even ? 0.0f : 1.0f - ray->offset;
    ray->piece *= 1.0f - first;
    ray->depth = first * TY_MARCH_STEP;
    while (t < end) {
        t = ty_march_piece(ray, t, ty_minf(end, until + slack));
        if (t < until && ray->depth < TY_MARCH_STEP * grown && t < end) continue;
        if (!ty_march_end_step(ray, t)) return false;
        if (!even) {
            grown = ty_march_grown(ray);
            until = t + step * grown;
            ray->piece = TY_MARCH_PIECE;
        }
    }
    return true;
}

/* The media that are at t, and up to where no other comes and none of them ends. */
TY_FN float ty_march_activate(ty_march_ray* ray, float t) {
    float end = TY_FLOAT_MAX;
    ray->active_count = 0;
    for (int32_t i = 0; i < ray->count; ++i) {
        ty_track* track = &ray->tracks[i];
        while (track->leave <= t) ty_track_next_run(track);
        end = ty_minf(end, track->enter <= t ? track->leave : track->enter);
        if (track->enter <= t) ray->active[ray->active_count++] = i;
    }
    return end;
}

/* ---- rays ---- */

/* Cells per metre along a direction. */
TY_FN float ty_march_cells_per_metre(const ty_cell_place* place, ty_vec direction) {
    const ty_vec d =
        ty_vec_make(direction.x * place->per_cell.x, direction.y * place->per_cell.y, direction.z * place->per_cell.z);
    return sqrtf(ty_dot(d, d));
}

TY_FN void ty_march_begin(ty_march_ray* ray, TY_GLOBAL const ty_march_request* request, ty_vec origin, ty_vec direction,
                          float far) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    ty_spans spans;
    ray->request = request;
    ray->origin = origin;
    ray->direction = direction;
    ray->count = ray->active_count = 0;
    ray->steps = 0;
    ray->depth = 0.0f;
    memset(&ray->light, 0, sizeof ray->light);
    for (int c = 0; c < 3; ++c) ray->light.transmittance[c] = ray->light.aside[c] = 1.0f;
    ty_spans_find(scene->media, scene->medium_count, origin, direction, far, &spans);
    ray->looks = request->light_count > 0 || request->has_field != 0 || spans.emits != 0;
    float light_per_metre = 0.0f;
    if (request->light_count > 0)
        light_per_metre = ty_march_cells_per_metre(&request->light, direction);
    else if (request->has_field != 0)
        light_per_metre = ty_march_cells_per_metre(&request->field.place, direction);
    for (int32_t i = 0; i < spans.count; ++i) {
        TY_GLOBAL const ty_medium_view* medium = &scene->media[spans.medium[i]];
        if (!(medium->sigma_t_max > 0.0f)) continue;
        ty_track* track = &ray->tracks[ray->count++];
        ty_track_begin(track, medium, origin, direction, spans.enter[i], spans.leave[i]);
        track->step = ray->looks != 0 ? ty_track_step(medium, direction, light_per_metre) : TY_FLOAT_MAX;
        track->growth = ty_track_growth(medium, direction, track->step);
    }
}

/* Sums the source along a ray, Eq. 3 (Koerner 2014): follows a unit direction as far as `far`. offset: where its first
 * step ends, (0, 1] of a step. */
TY_FN void ty_march_follow(ty_march_ray* ray, TY_GLOBAL const ty_march_request* request, ty_vec origin,
                           ty_vec direction, float far, float offset, float longer) {
    ty_march_begin(ray, request, origin, direction, far);
    ray->offset = offset;
    ray->longer = longer;
    float t = 0.0f;
    while (ray->count > 0 && t < TY_FLOAT_MAX) {
        const float end = ty_march_activate(ray, t);
        if (ray->active_count > 0 && !ty_march_stretch(ray, t, end)) {
            for (int c = 0; c < 3; ++c) ray->light.transmittance[c] = ray->light.aside[c] = 0.0f;
            return;
        }
        t = end;
    }
}

#endif
