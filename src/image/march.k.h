/* One ray through the media: docs/marching.md explains it. */
#ifndef TY_IMAGE_MARCH_K_H
#define TY_IMAGE_MARCH_K_H

#include "image/kernel.h"
#include "image/track.k.h"

/* Transmittance below which a ray ends: nothing behind can be seen any more. */
#define TY_MARCH_BLACK 1e-5f
/* Optical depth of a step at most, and what of it is enough to end it. */
#define TY_MARCH_STEP_MOST 0.8f
#define TY_MARCH_STEP_LEAST 0.6f

/* What a ray brings. */
typedef struct ty_march_light {
    float transmittance[3], glow[3], single[3], multiple[3];
} ty_march_light;

typedef struct ty_march_ray {
    TY_GLOBAL const ty_march_request* request;
    ty_vec origin, direction;
    int32_t count, active_count;
    int32_t active[TY_SPANS_MAX];
    float begin, until;              /* the step, m along the ray */
    float offset;                    /* where the first step of a stretch ends, of a step */
    float longer;                    /* times which steps are longer than the request's */
    float depth;                     /* of the step so far, in the channel that counts most */
    float most;                      /* optical depth of a step */
    float time[TY_TRACK_PIECES + 1]; /* pieces looked at side by side, m along the ray */
    int32_t looks;                   /* whether there is any light to look up */
    uint32_t steps;
    ty_march_light light;
    ty_track tracks[TY_SPANS_MAX];
} ty_march_ray;

/* ---- a step's light ---- */

/* What one medium scatters and sends at a point, times how much of it is seen: reach is transmittance times the mean
 * decay over the step. Adds to scattering what the field's light is scattered by. */
TY_FN void ty_march_shine(ty_march_ray* ray, const ty_track* track, ty_vec point, const ty_cell_point* at,
                          const float reach[3], float scattering[3]) {
    TY_GLOBAL const ty_march_request* request = ray->request;
    float sigma_s[3];
    ty_medium_sigma_s(track->medium, point, sigma_s);
    for (int32_t c = 0; c < 3; ++c) scattering[c] += sigma_s[c] * track->taken_amount;
    if (track->medium->emits != 0) {
        float glow[3];
        ty_medium_emission(track->medium, point, glow);
        for (int32_t c = 0; c < 3; ++c)
            ray->light.glow[c] +=
                reach[c] * track->taken_amount * glow[c] * ty_maxf(0.0f, track->medium->sigma_t[c] - sigma_s[c]);
    }
    if (request->light_count == 0) return;
    const ty_vec way = ty_scale(ray->direction, -1.0f);
    float g[3], scattered[3] = {0.0f, 0.0f, 0.0f};
    ty_medium_g(track->medium, point, g);
    for (int32_t i = 0; i < request->light_count; ++i)
        ty_single_scattered(&request->lights[i], point, at, way, g, scattered);
    for (int32_t c = 0; c < 3; ++c) ray->light.single[c] += reach[c] * track->taken_amount * sigma_s[c] * scattered[c];
}

/* What the step's optical depths are, and where in it light is looked up: where its matter is in the mean, moved by how
 * much more of the near side is seen. False where there is nothing. */
TY_FN bool ty_march_weigh(const ty_march_ray* ray, float end, float depth[3], float* mean_depth, float* at) {
    float moment = 0.0f, mean = 0.0f;
    for (int c = 0; c < 3; ++c) depth[c] = 0.0f;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        for (int c = 0; c < 3; ++c) depth[c] += track->medium->sigma_t[c] * track->taken_amount;
        mean += track->mean * track->taken_amount;
        moment += track->mean * track->taken_moment;
    }
    *mean_depth = mean;
    if (!(mean > 0.0f)) return false;
    const float length = end - ray->begin;
    *at = ray->begin + ty_clampf(moment / mean - length * mean * (1.0f / 12.0f), 0.0f, length);
    return true;
}

/* Channels that are black count no more for how long steps are; false when all are. */
TY_FN bool ty_march_dim(ty_march_ray* ray) {
    const float* passed = ray->light.transmittance;
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

/* Ends a step; false when nothing behind it is seen. */
TY_FN bool ty_march_end_step(ty_march_ray* ray, float end) {
    float depth[3], reach[3], scattering[3] = {0.0f, 0.0f, 0.0f}, mean_depth, at;
    const bool dense = ty_march_weigh(ray, end, depth, &mean_depth, &at);
    if (dense) {
        float decay[3];
        for (int c = 0; c < 3; ++c) {
            decay[c] = ty_decay(depth[c]);
            reach[c] = ray->light.transmittance[c] * ty_mean_decay(depth[c], decay[c]);
            ray->light.transmittance[c] *= decay[c];
        }
        if (ray->looks != 0) {
            TY_GLOBAL const ty_march_request* request = ray->request;
            const ty_vec point = ty_mad(ray->origin, ray->direction, at);
            ty_cell_point place = {0};
            if (request->light_count > 0)
                place = ty_cell_locate(request->light.size, ty_cell_coordinates(&request->light, point));
            for (int32_t i = 0; i < ray->active_count; ++i) {
                const ty_track* track = &ray->tracks[ray->active[i]];
                if (track->taken_amount > 0.0f) ty_march_shine(ray, track, point, &place, reach, scattering);
            }
            if (request->has_field != 0) {
                float sent[3];
                ty_upsample(&request->field, point, mean_depth / (end - ray->begin), ty_scale(ray->direction, -1.0f),
                            sent);
                for (int c = 0; c < 3; ++c) ray->light.multiple[c] += reach[c] * scattering[c] * sent[c];
            }
            ++ray->steps;
        }
    }
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        track->taken_amount = track->taken_moment = 0.0f;
    }
    ray->begin = end;
    ray->depth = 0.0f;
    return !dense || ty_march_dim(ray);
}

/* ---- stretches ---- */

/* The next pieces from t on, which end where any medium's voxels do; returns how many. */
TY_FN int32_t ty_march_lay_out(ty_march_ray* ray, float t, float end) {
    int32_t count = 0;
    ray->time[0] = t;
    while (t < end && count < TY_TRACK_PIECES) {
        t = end;
        for (int32_t i = 0; i < ray->active_count; ++i) {
            ty_track* track = &ray->tracks[ray->active[i]];
            if (track->medium->has_grid == 0) continue;
            if (track->cell_leave <= ray->time[count]) ty_track_advance(track, ray->time[count]);
            ty_track_note(track, count);
            t = ty_minf(t, track->cell_leave);
        }
        ray->time[++count] = t;
    }
    for (int32_t i = count + 1; i <= TY_TRACK_PIECES; ++i) ray->time[i] = t;
    return count;
}

/* Takes the part of piece i between shares u and v of it into the step. */
TY_FN void ty_march_take_part(ty_march_ray* ray, int32_t i, float u, float v) {
    const float length = ray->time[i + 1] - ray->time[i], before = ray->time[i] - ray->begin;
    for (int32_t k = 0; k < ray->active_count; ++k) {
        ty_track* track = &ray->tracks[ray->active[k]];
        float amount, moment;
        ty_track_part(track, i, length, u, v, &amount, &moment);
        track->taken_amount += amount;
        track->taken_moment += moment + amount * before;
        ray->depth += track->live * amount;
    }
}

/* Takes piece i, ending steps where they are long or deep enough; false when nothing behind it is seen. */
TY_FN bool ty_march_take(ty_march_ray* ray, int32_t i, float step) {
    const float start = ray->time[i], end = ray->time[i + 1];
    float depth = 0.0f, u = 0.0f;
    for (int32_t k = 0; k < ray->active_count; ++k) {
        const ty_track* track = &ray->tracks[ray->active[k]];
        depth += track->live * track->amount[i];
    }
    while (u < 1.0f) {
        const float room = ray->most - ray->depth;
        float v = 1.0f;
        if (end > ray->until) v = ty_minf(v, (ray->until - start) / (end - start));
        if (depth * (v - u) > room) v = ty_minf(v, u + room / depth);
        v = ty_clampf(v, u + 1e-6f, 1.0f);
        ty_march_take_part(ray, i, u, v);
        u = v;
        const float t = v >= 1.0f ? end : start + v * (end - start);
        if (v >= 1.0f && t < ray->until && ray->depth < TY_MARCH_STEP_LEAST / TY_MARCH_STEP_MOST * ray->most) break;
        if (!ty_march_end_step(ray, t)) return false;
        ray->until = t + step;
    }
    return true;
}

/* Goes from t to end, within which the same media are there; false when nothing behind is seen. */
TY_FN bool ty_march_stretch(ty_march_ray* ray, float t, float end) {
    float step = TY_FLOAT_MAX;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        ty_track_find(track, t);
        step = ty_minf(step, track->step);
    }
    /* Where light is alike everywhere, one step does. */
    const bool even = step >= TY_FLOAT_MAX;
    if (!even) step *= ray->request->step * ray->longer;
    ray->begin = t;
    ray->until = even ? TY_FLOAT_MAX : t + step * ray->offset;
    ray->most = even ? TY_FLOAT_MAX : TY_MARCH_STEP_MOST;
    while (t < end) {
        const int32_t count = ty_march_lay_out(ray, t, end);
        for (int32_t i = 0; i < ray->active_count; ++i) ty_track_look(&ray->tracks[ray->active[i]], ray->time, count);
        for (int32_t i = 0; i < count; ++i)
            if (!ty_march_take(ray, i, step)) return false;
        t = ray->time[count];
    }
    return ty_march_end_step(ray, end);
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
    for (int c = 0; c < 3; ++c) ray->light.transmittance[c] = 1.0f;
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
    }
}

/* Follows a ray with a unit direction as far as `far`. offset: where its first step ends, (0, 1] of a step. */
TY_FN void ty_march_follow(ty_march_ray* ray, TY_GLOBAL const ty_march_request* request, ty_vec origin,
                           ty_vec direction, float far, float offset, float longer) {
    ty_march_begin(ray, request, origin, direction, far);
    ray->offset = offset;
    ray->longer = longer;
    float t = 0.0f;
    while (ray->count > 0 && t < TY_FLOAT_MAX) {
        const float end = ty_march_activate(ray, t);
        if (ray->active_count > 0 && !ty_march_stretch(ray, t, end)) {
            for (int c = 0; c < 3; ++c) ray->light.transmittance[c] = 0.0f;
            return;
        }
        t = end;
    }
}

#endif
