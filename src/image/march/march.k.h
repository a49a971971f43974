/* Ray marching through the media: docs/marching.md explains it. */
#ifndef TY_IMAGE_MARCH_K_H
#define TY_IMAGE_MARCH_K_H

#include "image/march/octaves.k.h"
#include "image/march/track.k.h"

/* Maximum optical depth of a piece with one light lookup, and optical depth at which a step ends. */
#define TY_MARCH_PIECE 0.7f
#define TY_MARCH_STEP 0.5f

/* Intervals of media that a ray marches through, and lights that are looked up together. On devices a thread's memory
 * is scarce: scenes with more than TY_MARCH_DEVICE_MEDIA media march on the processor, and of a ray's further intervals
 * in closed meshes none is seen. */
enum { TY_MARCH_DEVICE_MEDIA = 5 };
#if defined(TY_DEVICE)
enum { TY_MARCH_TRACKS_MAX = TY_MARCH_DEVICE_MEDIA, TY_MARCH_LIGHTS_GROUP = 1 };
#else
enum { TY_MARCH_TRACKS_MAX = TY_SPANS_MAX, TY_MARCH_LIGHTS_GROUP = TY_MARCH_LIGHTS_MAX };
#endif

/* Result of a ray. */
typedef struct ty_march_light {
    float transmittance[3], emission[3], single[3], multiple[3];
    float scaled[3]; /* transmittance with the delta-scaled extinction, for light scattered nearly straight on: differs
                        only with a fit */
    float octaves[TY_OCTAVES_MAX][3]; /* transmittance of each octave, if they scale the view */
} ty_march_light;

typedef struct ty_march_ray {
    TY_GLOBAL const ty_march_request* request;
    ty_vec origin, direction;
    int32_t count, active_count;
    int32_t active[TY_MARCH_TRACKS_MAX];
    float begin;       /* start of the step, m along the ray */
    float offset;      /* end of the first step of an interval, as a fraction of a step */
    float step_scale;  /* factor on the request's step length */
    float growth;      /* of the interval, see ty_track */
    float depth;       /* optical depth of the step so far, in the most significant channel */
    float piece;       /* maximum optical depth of a piece */
    int32_t has_light; /* 1: there is light to look up */
    uint32_t steps;
    ty_march_light light;
    ty_track tracks[TY_MARCH_TRACKS_MAX];
} ty_march_ray;

/* ---- light of a step ---- */

/* Scattering of all media in a step: integrals of the scattering coefficient, and of its products with the mean cosine
 * g and with g^3. */
typedef struct ty_march_scattering {
    float amount[3], forward[3], third[3];
} ty_march_scattering;

/* Visibility of the sources in a step: transmittance times the mean attenuation over it; scaled: the same with the
 * delta-scaled extinction, identical without a fit. */
typedef struct ty_march_visibility {
    float transmitted[3], scaled[3];
    float octaves[TY_OCTAVES_MAX][3]; /* of each octave, if they scale the view */
} ty_march_visibility;

/* Adds the radiance scattered and emitted by one medium at a point, times its visibility: that of a group of lights,
 * and with the first group what the medium emits. Adds to scattering the coefficients for the field's light. */
TY_FN void ty_march_add_sources(ty_march_ray* ray, const ty_track* track, ty_vec point, const ty_near_light* lights,
                                int32_t first, int32_t end, const ty_march_visibility* visibility,
                                ty_march_scattering* scattering) {
    TY_GLOBAL const ty_march_request* request = ray->request;
    float sigma_s[3], g[3];
    ty_medium_sigma_s(track->medium, point, sigma_s);
    ty_medium_g(track->medium, point, g);
    for (int32_t c = 0; c < 3; ++c) {
        scattering->amount[c] += sigma_s[c] * track->column;
        scattering->forward[c] += g[c] * sigma_s[c] * track->column;
        scattering->third[c] += g[c] * g[c] * g[c] * sigma_s[c] * track->column;
    }
    if (track->medium->emits != 0 && first == 0) {
        float emission[3];
        ty_medium_emission(track->medium, point, emission);
        for (int32_t c = 0; c < 3; ++c)
            ray->light.emission[c] += visibility->transmitted[c] * track->column * emission[c] *
                                      ty_maxf(0.0f, track->medium->sigma_t[c] - sigma_s[c]);
    }
    if (request->light_count == 0) return;
    const ty_vec wo = ty_scale(ray->direction, -1.0f);
    ty_single_radiance scattered;
    memset(&scattered, 0, sizeof scattered);
    for (int32_t i = first; i < end; ++i) {
        const ty_near_light* near = &lights[i - first];
        ty_single_scattered(&request->lights[i], point, &near->at, wo, near->transmittance, g, track->medium->phase,
                            &request->fit, &scattered);
    }
    for (int32_t c = 0; c < 3; ++c) {
        const float amount = track->column * sigma_s[c], transmitted = visibility->transmitted[c] * amount;
        ray->light.single[c] += transmitted * scattered.first[c];
        ray->light.multiple[c] +=
            transmitted * scattered.again[c] + visibility->scaled[c] * amount * scattered.aside[c];
    }
}

/* Adds the light of octaves 1 and above that one medium scatters at a point. Never inlined: compilers would contract
 * the products of its callers in another way, and other methods' images would differ in the last bit. */
static __attribute__((noinline)) void ty_march_add_octaves(ty_march_ray* ray, const ty_track* track, ty_vec point,
                                                           const ty_near_light* lights, int32_t first, int32_t end,
                                                           const ty_march_visibility* visibility) {
    TY_GLOBAL const ty_march_request* request = ray->request;
    const ty_vec omega = ty_scale(ray->direction, -1.0f);
    float sigma_s[3], g[3];
    ty_medium_sigma_s(track->medium, point, sigma_s);
    ty_medium_g(track->medium, point, g);
    for (int32_t i = 1; i < request->octaves.count; ++i) {
        const float* passed = request->octaves.scales_view ? visibility->octaves[i] : visibility->transmitted;
        float radiance[3];
        ty_octave_scattered(request, i, point, lights, first, end, omega, g, radiance);
        for (int32_t c = 0; c < 3; ++c) ray->light.multiple[c] += passed[c] * track->column * sigma_s[c] * radiance[c];
    }
}

/* Optical depths of a step, and the position of its light lookup: the centroid of its extinction, shifted towards the
 * more visible near side. False: the step is empty. */
TY_FN bool ty_march_step_depth(const ty_march_ray* ray, float end, float depth[3], float* at) {
    float moment = 0.0f, mean = 0.0f;
    for (int c = 0; c < 3; ++c) depth[c] = 0.0f;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        for (int c = 0; c < 3; ++c) depth[c] += track->medium->sigma_t[c] * track->column;
        mean += track->mean * track->column;
        moment += track->mean * track->moment;
    }
    if (!(mean > 0.0f)) return false;
    const float length = end - ray->begin;
    *at = ray->begin + ty_clampf(moment / mean - length * mean * (1.0f / 12.0f), 0.0f, length);
    return true;
}

/* Extinction at a point, channel mean, 1/m: means over steps vary from pixel to pixel, which is visible. */
TY_FN float ty_march_extinction(const ty_march_ray* ray, float at) {
    float extinction = 0.0f;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        if (track->column > 0.0f) extinction += ty_track_extinction(track, at);
    }
    return extinction;
}

/* Adds the field's light at a point, scattered by the media there: the term sigma_s phi of Eq. 8 (Koerner 2014). */
TY_FN void ty_march_add_field_light(ty_march_ray* ray, ty_vec point, float extinction, const float visibility[3],
                                    const ty_march_scattering* scattering) {
    float isotropic[3], directed[3], third[3];
    ty_upsample(&ray->request->field, point, extinction, ty_scale(ray->direction, -1.0f), isotropic, directed, third);
    for (int c = 0; c < 3; ++c) {
        const float scattered = scattering->amount[c] * isotropic[c] + scattering->forward[c] * directed[c] +
                                scattering->third[c] * third[c];
        ray->light.multiple[c] += visibility[c] * ty_maxf(0.0f, scattered);
    }
}

/* Adds the light of a step to the ray, looked up `at` metres along it. */
TY_FN void ty_march_add_light(ty_march_ray* ray, float at, const ty_march_visibility* visibility) {
    TY_GLOBAL const ty_march_request* request = ray->request;
    ty_march_scattering scattering;
    ty_near_light lights[TY_MARCH_LIGHTS_GROUP];
    const ty_vec point = ty_mad(ray->origin, ray->direction, at);
    const float extinction = ty_march_extinction(ray, at);
    int32_t first = 0;
    do {
        const int32_t after = first + TY_MARCH_LIGHTS_GROUP;
        const int32_t end = after < TY_MARCH_LIGHTS_MAX && after < request->light_count ? after : request->light_count;
        ty_near_lookup(request, point, extinction, first, end, lights);
        memset(&scattering, 0, sizeof scattering);
        for (int32_t i = 0; i < ray->active_count; ++i) {
            const ty_track* track = &ray->tracks[ray->active[i]];
            if (!(track->column > 0.0f)) continue;
            ty_march_add_sources(ray, track, point, lights, first, end, visibility, &scattering);
            if (request->octaves.count > 1) ty_march_add_octaves(ray, track, point, lights, first, end, visibility);
        }
        first = after;
    } while (first < TY_MARCH_LIGHTS_MAX && first < request->light_count);
    if (request->has_field != 0) ty_march_add_field_light(ray, point, extinction, visibility->scaled, &scattering);
    ++ray->steps;
}

/* Opaque channels no longer limit the step length; false if all are opaque. */
TY_FN bool ty_march_update_live_channels(ty_march_ray* ray) {
    const float* transmittance = ray->light.scaled;
    const float black = ray->request->black;
    const bool live[3] = {transmittance[0] >= black, transmittance[1] >= black, transmittance[2] >= black};
    if (live[0] && live[1] && live[2]) return true;
    for (int32_t i = 0; i < ray->count; ++i) {
        ty_track* track = &ray->tracks[i];
        track->max_sigma_t = 0.0f;
        for (int c = 0; c < 3; ++c)
            if (live[c]) track->max_sigma_t = ty_maxf(track->max_sigma_t, track->medium->sigma_t[c]);
    }
    return live[0] || live[1] || live[2];
}

/* Visibility of a step of these optical depths; attenuates the transmittance by it. */
TY_FN void ty_march_attenuate(const float depth[3], float transmittance[3], float visibility[3]) {
    for (int c = 0; c < 3; ++c) {
        const float attenuation = ty_attenuation(depth[c]);
        visibility[c] = transmittance[c] * ty_mean_attenuation(depth[c], attenuation);
        transmittance[c] *= attenuation;
    }
}

/* Attenuates each octave by its scaled extinction b^i sigma_t towards the eye. */
TY_FN void ty_march_pass_octaves(ty_march_ray* ray, const float depth[3], ty_march_visibility* visibility) {
    TY_GLOBAL const ty_march_octaves* octaves = &ray->request->octaves;
    for (int32_t i = 1; i < octaves->count; ++i) {
        float scaled[3];
        for (int c = 0; c < 3; ++c) scaled[c] = octaves->extinction[i] * depth[c];
        ty_march_attenuate(scaled, ray->light.octaves[i], visibility->octaves[i]);
    }
    for (int c = 0; c < 3; ++c) ray->light.scaled[c] = ray->light.octaves[octaves->count - 1][c];
}

/* Subtracts the delta-scattered fraction from a step's optical depths. */
TY_FN void ty_march_scale_depth(const ty_march_ray* ray, float at, float depth[3]) {
    const ty_vec point = ty_mad(ray->origin, ray->direction, at);
    for (int32_t i = 0; i < ray->active_count; ++i) {
        const ty_track* track = &ray->tracks[ray->active[i]];
        float sigma_s[3];
        if (!(track->column > 0.0f)) continue;
        ty_medium_sigma_s(track->medium, point, sigma_s);
        for (int c = 0; c < 3; ++c)
            depth[c] = ty_maxf(0.0f, depth[c] - ray->request->fit.forward_fraction * sigma_s[c] * track->column);
    }
}

/* Ends a step; false: everything behind it is invisible. */
TY_FN bool ty_march_end_step(ty_march_ray* ray, float end) {
    ty_march_visibility visibility;
    float depth[3], at;
    const bool dense = ty_march_step_depth(ray, end, depth, &at);
    if (dense) {
        ty_march_attenuate(depth, ray->light.transmittance, visibility.transmitted);
        if (ray->request->fit.bands > 0) {
            ty_march_scale_depth(ray, at, depth);
            ty_march_attenuate(depth, ray->light.scaled, visibility.scaled);
        } else {
            for (int c = 0; c < 3; ++c) {
                visibility.scaled[c] = visibility.transmitted[c];
                ray->light.scaled[c] = ray->light.transmittance[c];
            }
            if (ray->request->octaves.scales_view) ty_march_pass_octaves(ray, depth, &visibility);
        }
        if (ray->has_light != 0) ty_march_add_light(ray, at, &visibility);
    }
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        track->column = track->moment = 0.0f;
    }
    ray->begin = end;
    ray->depth = 0.0f;
    return !dense || ty_march_update_live_channels(ray);
}

/* ---- intervals of constant media ---- */

/* Integrates the piece from t to end in all media; returns its optical depth. */
TY_FN float ty_march_integrate_piece(ty_march_ray* ray, float t, float end) {
    float depth = 0.0f;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        depth += track->max_sigma_t * ty_track_integrate(track, t, end);
    }
    return depth;
}

/* Processes the piece that begins at t; returns its end: the nearest voxel boundary of any medium, at most max_end. */
TY_FN float ty_march_piece(ty_march_ray* ray, float t, float max_end) {
    float end = max_end;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        if (track->cell_leave <= t) ty_track_advance(track, t);
        end = ty_minf(end, track->cell_leave);
    }
    float depth = ty_march_integrate_piece(ray, t, end);
    if (depth > ray->piece) {
        const float shorter = t + (end - t) * ray->piece / depth;
        if (shorter > t) {
            end = shorter;
            depth = ty_march_integrate_piece(ray, t, end);
        }
    }
    for (int32_t i = 0; i < ray->active_count; ++i)
        ty_track_add_piece(&ray->tracks[ray->active[i]], ray->begin, t, end);
    ray->depth += depth;
    return end;
}

/* Step growth with opacity: for an error proportional to the squared step length the total is minimal, at a fixed
 * number of steps, for lengths proportional to transmittance^(-1/3); this is a bounded approximation. */
TY_FN float ty_march_step_growth(const ty_march_ray* ray) {
    const float* transmittance = ray->light.scaled;
    const float hidden = 1.0f - ty_maxf(transmittance[0], ty_maxf(transmittance[1], transmittance[2]));
    return 1.0f + ray->growth * hidden * hidden;
}

/* Marches from t to end through a constant set of media; false: everything behind is invisible. */
TY_FN bool ty_march_cross_interval(ty_march_ray* ray, float t, float end) {
    float step = TY_FLOAT_MAX, slack = 0.0f;
    ray->growth = TY_FLOAT_MAX;
    for (int32_t i = 0; i < ray->active_count; ++i) {
        ty_track* track = &ray->tracks[ray->active[i]];
        ty_track_seek(track, t);
        step = ty_minf(step, track->step);
        ray->growth = ty_minf(ray->growth, track->growth);
        if (track->medium->has_grid != 0) slack = 0.5f;
    }
    const bool uniform = step >= TY_FLOAT_MAX;
    step = uniform ? step : step * ray->request->step * ray->step_scale;
    /* Steps end at voxel boundaries if one is near, which saves a piece. */
    slack = uniform ? 0.0f : slack * step;
    float growth = uniform ? 1.0f : ty_march_step_growth(ray);
    float until = uniform ? step : t + step * growth * ray->offset;
    ray->begin = t;
    ray->piece = uniform ? TY_FLOAT_MAX : TY_MARCH_PIECE;
    /* In dense media the offset shortens the optical depth of the first step. */
    const float first = uniform ? 0.0f : 1.0f - ray->offset;
    ray->piece *= 1.0f - first;
    ray->depth = first * TY_MARCH_STEP;
    while (t < end) {
        t = ty_march_piece(ray, t, ty_minf(end, until + slack));
        if (t < until && ray->depth < TY_MARCH_STEP * growth && t < end) continue;
        if (!ty_march_end_step(ray, t)) return false;
        if (!uniform) {
            growth = ty_march_step_growth(ray);
            until = t + step * growth;
            ray->piece = TY_MARCH_PIECE;
        }
    }
    return true;
}

/* Activates the media at t; returns the distance at which the set changes. */
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
TY_FN float ty_march_cells_per_metre(const ty_cell_lattice* lattice, ty_vec direction) {
    const ty_vec d = ty_vec_make(direction.x * lattice->per_cell.x, direction.y * lattice->per_cell.y,
                                 direction.z * lattice->per_cell.z);
    return sqrtf(ty_dot(d, d));
}

TY_FN void ty_march_begin(ty_march_ray* ray, TY_GLOBAL const ty_march_request* request, ty_vec origin, ty_vec direction,
                          float max_distance) {
    TY_GLOBAL const ty_scene_view* scene = request->scene;
    ty_spans spans;
    ray->request = request;
    ray->origin = origin;
    ray->direction = direction;
    ray->count = ray->active_count = 0;
    ray->steps = 0;
    ray->depth = 0.0f;
    memset(&ray->light, 0, sizeof ray->light);
    for (int c = 0; c < 3; ++c) ray->light.transmittance[c] = ray->light.scaled[c] = 1.0f;
    for (int32_t i = 1; i < request->octaves.count; ++i)
        for (int32_t c = 0; c < 3; ++c) ray->light.octaves[i][c] = 1.0f;
    ty_spans_find(scene->media, scene->medium_count, origin, direction, max_distance, &spans);
    ray->has_light = request->light_count > 0 || request->has_field != 0 || spans.emits != 0;
    float light_per_metre = 0.0f;
    if (request->light_count > 0)
        light_per_metre = ty_march_cells_per_metre(&request->light, direction);
    else if (request->has_field != 0)
        light_per_metre = ty_march_cells_per_metre(&request->field.lattice, direction);
    for (int32_t i = 0; i < spans.count && ray->count < TY_MARCH_TRACKS_MAX; ++i) {
        TY_GLOBAL const ty_medium_view* medium = &scene->media[spans.medium[i]];
        if (!(medium->sigma_t_max > 0.0f)) continue;
        ty_track* track = &ray->tracks[ray->count++];
        ty_track_begin(track, medium, origin, direction, spans.enter[i], spans.leave[i]);
        track->step = ray->has_light != 0 ? ty_track_step(medium, direction, light_per_metre) : TY_FLOAT_MAX;
        track->growth = ty_track_growth(medium, direction, track->step);
    }
}

/* Marches a ray with a unit direction up to max_distance and integrates its source: Eq. 3 (Koerner 2014). offset: end
 * of its first step, (0, 1] of a step. */
TY_FN void ty_march_follow(ty_march_ray* ray, TY_GLOBAL const ty_march_request* request, ty_vec origin,
                           ty_vec direction, float max_distance, float offset, float step_scale) {
    ty_march_begin(ray, request, origin, direction, max_distance);
    ray->offset = offset;
    ray->step_scale = step_scale;
    float t = 0.0f;
    while (ray->count > 0 && t < TY_FLOAT_MAX) {
        const float end = ty_march_activate(ray, t);
        if (ray->active_count > 0 && !ty_march_cross_interval(ray, t, end)) {
            for (int c = 0; c < 3; ++c) ray->light.transmittance[c] = ray->light.scaled[c] = 0.0f;
            return;
        }
        t = end;
    }
}

#endif
