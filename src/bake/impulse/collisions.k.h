/* Responses along walks through the media, corrected at collisions.
 *
 * A response (Dubouchet 2019) takes its medium for infinite, and nothing in it for shaded. With V = 1 where a point
 * sees the emitter, f the light of the emitter that a collision at x' scatters towards x, and f_table what the response
 * at x counts of it, the light that scatters once on its way to x is V(x) response(x) + integral over rays from x and
 * their collisions x' of V(x') f - V(x) f_table. One collision samples the integral: the response is its control
 * variate. Light that scatters more often is found by walks from the receiver, to whose every collision responses bring
 * light that scattered once before it. */
#ifndef TY_BAKE_IMPULSE_COLLISIONS_K_H
#define TY_BAKE_IMPULSE_COLLISIONS_K_H

#include "base/legendre.k.h"
#include "bake/impulse/emitter_response.k.h"

/* Metres of a ray without an end along which collisions are sampled. */
#define TY_LONGEST_RAY 1e6f

/* Rays closer to an emitter, rad, are left out: 3e-4 of the correction. */
#define TY_MIN_ANGLE 1e-3f

/* A vertex of a walk, the receiver or a collision, with the ray that leaves it. */
typedef struct ty_walk {
    ty_vec origin, direction;
    float max_distance;             /* of the ray, m */
    ty_vec back;                    /* direction of the ray before; collisions alone */
    float g[3];                     /* of the medium there; collisions alone */
    float beta[3];                  /* throughput of the walk up to the vertex */
    float ray[3];                   /* phase function over density of the direction; at the receiver 1 / density */
    float basis[TY_BAKE_TERMS_MAX]; /* of the walk's first direction */
    int32_t depth;                  /* collisions before */
} ty_walk;

/* A ray from a vertex along which a response is corrected: the walk's, or one about the direction to the emitter. */
typedef struct ty_corrected_ray {
    ty_vec origin, direction;
    float max_distance;
    float weight[3]; /* phase function over density of the direction, times the walk's throughput */
    float basis[TY_BAKE_TERMS_MAX];
} ty_corrected_ray;

/* A collision on the ray. */
typedef struct ty_collision_point {
    ty_vec at;
    float t;                           /* m from its origin */
    float measure;                     /* 1 / density, m */
    float passed[3], sigma_s[3], g[3]; /* transmittance to the origin; coefficients, 1/m and 1 */
} ty_collision_point;

/* One emitter at one vertex. */
typedef struct ty_corrected {
    ty_emitter emitter;                        /* relative to the vertex, */
    ty_response response;                      /* and the response there; unset where it is not seen */
    const ty_virtual_emitter* virtual_emitter; /* NULL: light from infinity */
    bool seen;                                 /* by the vertex */
    float strength[3];                         /* per sample, without the falloff towards a point */
    float falloff;                             /* towards the vertex */
    int32_t layer;
} ty_corrected;

/* ---- collisions ---- */

/* A collision at distance t. Returns the sum over media and the mean over channels of sigma_t times the medium's own
 * transmittance: the density of ty_fog_point_sample_distance() there, times the total of that point. */
TY_FN float ty_collision_set(const ty_gather* g, const ty_corrected_ray* ray, float t, ty_collision_point* out) {
    const ty_scene_view* scene = g->request->path.scene;
    const float step = g->request->impulse.step;
    float depth[3] = {0.0f, 0.0f, 0.0f}, scattered[3] = {0.0f, 0.0f, 0.0f}, g_scattered[3] = {0.0f, 0.0f, 0.0f};
    float density = 0.0f;
    ty_segment segment;
    segment.point = NULL;
    out->t = t;
    out->at = ty_mad(ray->origin, ray->direction, t);
    for (int32_t m = 0; m < scene->medium_count; ++m) {
        float passed[3];
        ty_segment_find(&segment, &scene->media[m], 1, ray->origin, ray->direction, t);
        for (int c = 0; c < 3; ++c) {
            depth[c] += segment.depth[c];
            passed[c] = segment.transmittance[c];
        }
        ty_segment_find(&segment, &scene->media[m], 1, out->at, ray->direction, step);
        for (int c = 0; c < 3; ++c) {
            scattered[c] += segment.scattering_depth[c];
            g_scattered[c] += segment.g_scattering_depth[c];
            density += segment.depth[c] * passed[c];
        }
    }
    for (int c = 0; c < 3; ++c) {
        out->passed[c] = ty_expf(-depth[c]);
        out->sigma_s[c] = scattered[c] / step;
        out->g[c] = scattered[c] > 0.0f ? g_scattered[c] / scattered[c] : 0.0f;
    }
    return density / (3.0f * step);
}

/* Distances in proportion to the falloff of an emitter's light along a ray: for light from infinity to what the
 * response counts of it, for local emitters to 1 / d^2 (Kulla and Fajardo 2012). */
typedef struct ty_falloff_distances {
    bool distant;
    float length;                    /* of the ray, m */
    float depth, collided;           /* distant: optical depth over the length, and the probability to collide in it */
    float from, to, closest, height; /* local: angles at the emitter, rad, and its closest point and distance, m */
} ty_falloff_distances;

TY_FN ty_falloff_distances ty_falloff_distances_find(const ty_corrected_ray* ray, const ty_corrected* of) {
    ty_falloff_distances d = {.distant = of->virtual_emitter == NULL,
                              .length = ty_minf(ray->max_distance, TY_LONGEST_RAY)};
    if (d.distant) {
        const float mu = ty_clampf(ty_dot(of->emitter.wi, ray->direction), -1.0f, 1.0f);
        const float sigma = of->seen ? of->response.medium[of->response.channels == 1 ? 0 : 1].sigma_t : 0.0f;
        d.depth = ty_maxf(sigma * (1.0f - mu) * d.length, 1e-4f);
        d.collided = ty_collision_probability(d.depth);
        return d;
    }
    const ty_closest_approach closest =
        ty_closest_approach_find(ray->origin, ray->direction, of->emitter.position, 1.0f);
    d.closest = closest.t;
    d.height = sqrtf(closest.distance2 + of->emitter.area * (0.25f / TY_PI));
    d.from = atanf(-d.closest / d.height);
    d.to = atanf((d.length - d.closest) / d.height);
    return d;
}

TY_FN float ty_falloff_distances_sample(const ty_falloff_distances* d, float u) {
    if (d->distant) return ty_minf(ty_sample_collision_depth(u * d->collided) / d->depth, 1.0f) * d->length;
    return ty_clampf(d->closest + d->height * tanf(ty_lerpf(d->from, d->to, u)), 0.0f, d->length);
}

/* Density, 1/m. */
TY_FN float ty_falloff_distances_density(const ty_falloff_distances* d, float t) {
    if (d->distant) return d->depth / (d->length * d->collided) * ty_expf(-d->depth * (t / d->length));
    return ty_equiangular_density(d->to - d->from, d->height, t - d->closest);
}

/* Samples a collision on the ray for the correction of a response: one-sample MIS with the balance heuristic of
 * distances at which the ray collides with the media and of distances by the falloff of the emitter's light. The first
 * bounds what scatters in dense media, the second what the response counts. False: there is nothing to correct. */
TY_FN bool ty_collision_sample(const ty_gather* g, const ty_corrected_ray* ray, const ty_corrected* of, float u,
                               ty_sampler* random, ty_collision_point* out) {
    const ty_scene_view* scene = g->request->path.scene;
    const ty_falloff_distances falloff = ty_falloff_distances_find(ray, of);
    float weight[3], left[3];
    ty_fog_point point = ty_fog_point_begin(u, random);
    ty_segment segment;
    segment.point = &point;
    ty_segment_find(&segment, scene->media, scene->medium_count, ray->origin, ray->direction, falloff.length);
    const bool collides = point.medium != NULL;
    if (!(falloff.length > 0.0f) || (!collides && !of->seen)) return false;
    /* Light from infinity that the vertex does not see has no falloff but the media's. */
    const float fraction = !collides ? 1.0f : of->seen || !falloff.distant ? 0.5f : 0.0f;
    const float t = ty_rng_uniform(random) < fraction ? ty_falloff_distances_sample(&falloff, u)
                                                      : ty_fog_point_sample_distance(&point, weight, left);
    float density = ty_collision_set(g, ray, t, out) * (collides ? (1.0f - fraction) / point.total : 0.0f);
    if (fraction > 0.0f) density += fraction * ty_falloff_distances_density(&falloff, t);
    if (!(density > 0.0f)) return false;
    out->measure = 1.0f / density;
    return true;
}

/* ---- scattered light ---- */

/* The phase function of the tables, interpolated between g = -0.5, 0 and 0.5: Sec. 4.5 (Dubouchet 2019). */
TY_FN float ty_table_phase(float mu, float g) {
    const float weight = ty_minf(1.0f, 2.0f * fabsf(g));
    return (1.0f - weight) * TY_INV_4PI + weight * ty_hg(mu, g < 0.0f ? -0.5f : 0.5f);
}

/* Radiance of a zonal response scattered by Henyey-Greenstein's phase function: sum of g^l L_l y_l^0(mu). mu: cosine
 * between the axis and the direction back along the ray. */
TY_FN float ty_response_scatter(const float zonal[TY_IMPULSE_TERMS], float mu, float g) {
    float before = 0.0f, legendre = 1.0f, sum = 0.0f, power = 1.0f;
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
        sum += power * sqrtf((float)(2 * l + 1) * TY_INV_4PI) * legendre * zonal[l];
        power *= g;
        const float next = l == 0 ? mu : ty_legendre_next(l, mu, legendre, before);
        before = legendre;
        legendre = next;
    }
    return sum;
}

/* Intensity of an emitter towards a point that sees it along wi, relative to that of its strength. */
TY_FN float ty_corrected_falloff(const ty_gather* g, const ty_corrected* of, ty_vec wi) {
    return of->virtual_emitter == NULL ? 1.0f : ty_virtual_emitter_falloff(g, of->virtual_emitter, wi);
}

/* True if a point in the media sees the emitter. */
TY_FN bool ty_emitter_is_seen(ty_gather* g, const ty_corrected* of, const ty_emitter* emitter, ty_vec from) {
    const ty_accel* mesh = g->request->path.scene->mesh;
    const ty_virtual_emitter* virtual_emitter = of->virtual_emitter;
    if (emitter->kind == TY_IMPULSE_AREA && !(emitter->cosine > 0.0f)) return false;
    ++g->rays;
    if (mesh == NULL) return true;
    if (virtual_emitter == NULL) return !ty_accel_occluded(mesh, from, emitter->wi, TY_FLOAT_MAX);
    const ty_vec to = ty_sub(ty_mad(virtual_emitter->position, virtual_emitter->face, virtual_emitter->margin), from);
    return !ty_virtual_emitter_is_hidden(mesh, virtual_emitter, from, to, sqrtf(ty_dot(to, to)));
}

/* f_table of a channel, per strength. emitter: relative to the collision. */
TY_FN float ty_corrected_table(const ty_corrected_ray* ray, const ty_corrected* of, const ty_collision_point* at,
                               const ty_emitter* emitter, int c) {
    const ty_impulse_medium* medium = &of->response.medium[of->response.channels == 1 ? 0 : c];
    const float mu = ty_clampf(ty_dot(emitter->wi, ray->direction), -1.0f, 1.0f), t = at->t;
    float geometry = 1.0f, length = of->emitter.distance - t * mu;
    if (emitter->kind != TY_IMPULSE_DIRECTIONAL) {
        length = emitter->distance;
        geometry = (emitter->kind == TY_IMPULSE_AREA ? ty_maxf(0.0f, emitter->cosine) : 1.0f) / (length * length);
    }
    if (!(length >= 0.0f)) return 0.0f;
    return medium->sigma_s * ty_table_phase(mu, medium->g) * ty_expf(-medium->sigma_t * (t + length)) * geometry;
}

/* Adds V f - V f_table of one collision. */
TY_FN void ty_gather_correct(ty_gather* g, const ty_corrected_ray* ray, const ty_corrected* of,
                             const ty_collision_point* at) {
    ty_emitter emitter = of->emitter;
    ty_segment segment;
    float amount[3];
    const bool directional = emitter.kind == TY_IMPULSE_DIRECTIONAL;
    if (!directional) ty_emitter_set_receiver(&emitter, at->at);
    const bool seen = ty_emitter_is_seen(g, of, &emitter, at->at);
    if (!seen && !of->seen) return;
    ty_gather_segment(g, at->at, emitter.wi, directional ? TY_FLOAT_MAX : emitter.distance, &segment);
    const float mu = ty_clampf(ty_dot(emitter.wi, ray->direction), -1.0f, 1.0f);
    const float facing = emitter.kind == TY_IMPULSE_AREA ? ty_maxf(0.0f, emitter.cosine) : 1.0f;
    const float geometry = directional ? 1.0f : facing / (emitter.distance * emitter.distance);
    const float falloff = ty_corrected_falloff(g, of, emitter.wi);
    for (int c = 0; c < 3; ++c) {
        float scattered = 0.0f;
        if (seen)
            scattered =
                falloff * geometry * at->sigma_s[c] * at->passed[c] * ty_hg(mu, at->g[c]) * segment.transmittance[c];
        if (of->seen) scattered -= of->falloff * ty_corrected_table(ray, of, at, &emitter, c);
        amount[c] = ray->weight[c] * at->measure * of->strength[c] * scattered;
    }
    ty_gather_add_rgb(g, of->layer, amount, ray->basis);
}

/* Adds the response to an emitter that the vertex sees. segment: between them. */
TY_FN void ty_gather_vertex_response(ty_gather* g, const ty_walk* walk, ty_corrected* of, const ty_segment* segment) {
    float amount[3], basis[TY_BAKE_TERMS_MAX];
    if (of->seen) of->seen = ty_response_find(g->request, segment, &of->emitter, &of->response);
    if (!of->seen) return;
    for (int c = 0; c < 3; ++c) {
        const int channel = of->response.channels == 1 ? 0 : c;
        const float* single = of->response.channel[channel].single;
        const ty_vec axis = of->response.axis[channel];
        amount[c] = walk->beta[c] * of->strength[c] * of->falloff;
        if (walk->depth == 0) {
            if (c < of->response.channels) ty_gather_zonal_basis(g, single, axis, basis);
            ty_gather_add(g, of->layer, c, amount[c], basis);
        } else {
            amount[c] *= ty_response_scatter(single, ty_clampf(ty_dot(axis, walk->back), -1.0f, 1.0f), walk->g[c]);
        }
    }
    if (walk->depth > 0) ty_gather_add_rgb(g, of->layer, amount, walk->basis);
}

/* Subtracts what the response counts of light that scatters beyond the end of a ray. */
TY_FN void ty_gather_subtract_beyond(ty_gather* g, const ty_corrected_ray* ray, const ty_corrected* of) {
    float amount[3];
    if (!of->seen || !(ray->max_distance < TY_FLOAT_MAX)) return;
    for (int c = 0; c < 3; ++c) {
        const ty_impulse_medium* medium = &of->response.medium[of->response.channels == 1 ? 0 : c];
        amount[c] = -ray->weight[c] * of->strength[c] * of->falloff *
                    ty_response_occluded(&of->emitter, medium, ray->direction, ray->max_distance);
    }
    ty_gather_add_rgb(g, of->layer, amount, ray->basis);
}

/* ---- rays ---- */

/* Density of directions about the direction to an emitter: uniform in the angle to it, as light of a point scatters
 * into a ray in inverse proportion to the ray's distance from it; for light from infinity Henyey-Greenstein's. */
TY_FN float ty_emitter_density(const ty_emitter* emitter, float g, ty_vec direction) {
    if (emitter->kind == TY_IMPULSE_DIRECTIONAL)
        return ty_hg(ty_clampf(ty_dot(emitter->wi, direction), -1.0f, 1.0f), g);
    const ty_vec off = ty_cross(emitter->wi, direction);
    return 1.0f / (2.0f * TY_PI * TY_PI * sqrtf(ty_maxf(ty_dot(off, off), TY_MIN_ANGLE * TY_MIN_ANGLE)));
}

TY_FN ty_vec ty_emitter_sample_direction(const ty_emitter* emitter, float g, float u, float v) {
    if (emitter->kind == TY_IMPULSE_DIRECTIONAL) return ty_hg_sample(emitter->wi, g, u, v);
    return ty_direction_about(emitter->wi, cosf(TY_PI * u), v);
}

/* Density of the walk's directions at its vertex. */
TY_FN float ty_walk_density(const ty_gather* g, const ty_walk* walk, ty_vec direction) {
    if (walk->depth > 0) return ty_hg(ty_clampf(ty_dot(walk->back, direction), -1.0f, 1.0f), walk->g[1]);
    return g->request->terms == TY_BAKE_SH_TERMS ? TY_INV_4PI : ty_dot(g->normal, direction) * (1.0f / TY_PI);
}

/* Chooses a ray for the correction of a response: one-sample MIS with the balance heuristic. cosine: g of light from
 * infinity. False: it leaves behind the receiver, or meets the emitter. */
TY_FN bool ty_corrected_ray_choose(ty_gather* g, const ty_walk* walk, const ty_emitter* emitter, float cosine,
                                   ty_corrected_ray* out) {
    const ty_accel* mesh = g->request->path.scene->mesh;
    ty_sampler* random = &g->path.random;
    ty_segment segment;
    ty_hit hit;
    out->origin = walk->origin;
    out->direction = walk->direction;
    out->max_distance = walk->max_distance;
    if (ty_rng_uniform(random) < 0.5f) {
        const float u = ty_rng_uniform(random);
        out->direction = ty_emitter_sample_direction(emitter, cosine, u, ty_rng_uniform(random));
        if (walk->depth == 0 && g->request->terms != TY_BAKE_SH_TERMS &&
            !(ty_dot(g->normal, out->direction) > 0.0f && ty_dot(g->face, out->direction) > 0.0f))
            return false;
        ++g->rays;
        const bool hits = mesh != NULL && ty_accel_intersect(mesh, out->origin, out->direction, TY_FLOAT_MAX, &hit);
        ty_gather_segment(g, out->origin, out->direction, hits ? hit.distance : TY_FLOAT_MAX, &segment);
        out->max_distance = hits ? hit.distance : segment.leave;
    }
    const ty_vec off = ty_cross(emitter->wi, out->direction);
    if (emitter->kind != TY_IMPULSE_DIRECTIONAL && ty_dot(off, off) < TY_MIN_ANGLE * TY_MIN_ANGLE) return false;
    const float density =
        0.5f * (ty_walk_density(g, walk, out->direction) + ty_emitter_density(emitter, cosine, out->direction));
    const float mu = walk->depth > 0 ? ty_clampf(ty_dot(walk->back, out->direction), -1.0f, 1.0f) : 0.0f;
    for (int c = 0; c < 3; ++c)
        out->weight[c] = walk->beta[c] * (walk->depth > 0 ? ty_hg(mu, walk->g[c]) : 1.0f) / density;
    if (walk->depth == 0)
        ty_gather_basis(g, out->direction, out->basis);
    else
        memcpy(out->basis, walk->basis, sizeof out->basis);
    return true;
}

/* ---- emitters ---- */

/* Light from one direction at infinity. strength: irradiance per sample. */
TY_FN void ty_gather_corrected_distant(ty_gather* g, const ty_walk* walk, ty_vec wi, const float strength[3]) {
    ty_segment segment;
    ty_collision_point at;
    ty_corrected_ray ray;
    ty_corrected of = {.falloff = 1.0f, .layer = walk->depth == 0 ? TY_BAKE_SINGLE : TY_BAKE_MULTIPLE};
    if (!(ty_max3(strength) > 0.0f)) return;
    const bool surface = walk->depth == 0 && g->request->terms != TY_BAKE_SH_TERMS;
    const bool behind = surface && !(ty_dot(g->normal, wi) > 0.0f && ty_dot(g->face, wi) > 0.0f);
    ty_gather_segment(g, walk->origin, wi, TY_FLOAT_MAX, &segment);
    of.emitter = (ty_emitter){.kind = TY_IMPULSE_DIRECTIONAL, .wi = wi, .distance = segment.leave, .cosine = 1.0f};
    for (int c = 0; c < 3; ++c) of.strength[c] = strength[c];
    of.seen = (!behind || g->request->back_scattering != 0) &&
              ty_emitter_is_seen(g, &of, &of.emitter, behind ? g->offset_origin : walk->origin);
    ty_gather_vertex_response(g, walk, &of, &segment);
    if (!ty_corrected_ray_choose(g, walk, &of.emitter, g->request->impulse.mean_cosine, &ray)) return;
    if (ty_collision_sample(g, &ray, &of, g->collision, &g->path.random, &at)) ty_gather_correct(g, &ray, &of, &at);
    ty_gather_subtract_beyond(g, &ray, &of);
}

TY_FN bool ty_has_unsampled_environment(const ty_light_set* lights) {
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        const ty_light_view* light = &lights->lights[lights->distant[i]];
        if (light->kind == TY_KIND_ENVIRONMENT && !(light->chosen > 0.0f)) return true;
    }
    return false;
}

/* Light from infinity: one sample of the lights, and one of environments that are never sampled as lights. */
TY_FN void ty_gather_corrected_sky(ty_gather* g, const ty_walk* walk, float scale) {
    ty_path* path = &g->path;
    ty_light_sample sample;
    float chosen, strength[3];
    const ty_light_set* lights = &g->request->path.scene->lights;
    if (lights->distant_count == 0) return;
    path->normal = ty_vec_make(0.0f, 0.0f, 0.0f);
    const ty_light_view* light = ty_path_choose_light(path, walk->origin, &chosen, &sample);
    if (light != NULL && ty_light_is_distant(light)) {
        for (int c = 0; c < 3; ++c) strength[c] = scale / chosen * sample.radiance[c];
        ty_gather_corrected_distant(g, walk, sample.wi, strength);
    }
    if (!ty_has_unsampled_environment(lights)) return;
    ty_path_sample_sphere(path);
    ty_gather_environment(g, false, strength);
    for (int c = 0; c < 3; ++c) strength[c] *= scale / path->pdf;
    ty_gather_corrected_distant(g, walk, path->direction, strength);
}

/* One virtual emitter. */
TY_FN void ty_gather_corrected_virtual(ty_gather* g, const ty_walk* walk, float scale) {
    float probability;
    const int32_t index = ty_gather_choose_emitter(g, g->emitter, &probability);
    if (index < 0) return;
    const ty_virtual_emitter* virtual_emitter = &g->request->impulse.emitters->items[index];
    ty_segment segment;
    ty_collision_point at;
    ty_corrected_ray ray;
    ty_corrected of = {.virtual_emitter = virtual_emitter};
    if (walk->depth == 0) {
        of.seen = ty_gather_see_virtual_emitter(g, virtual_emitter, &of.emitter);
    } else {
        of.emitter = ty_virtual_emitter_at(virtual_emitter, walk->origin);
        of.seen = ty_emitter_is_seen(g, &of, &of.emitter, walk->origin);
    }
    of.falloff = ty_corrected_falloff(g, &of, of.emitter.wi);
    const bool corrected = ty_corrected_ray_choose(g, walk, &of.emitter, 0.0f, &ray);
    const bool collided = corrected && ty_collision_sample(g, &ray, &of, g->collision, &g->path.random, &at);
    ty_gather_segment(g, walk->origin, of.emitter.wi, of.emitter.distance, &segment);
    for (int emitted = 0; emitted < 2; ++emitted) {
        const float* color = emitted != 0 ? virtual_emitter->emission : virtual_emitter->outgoing;
        if (!(ty_max3(color) > 0.0f)) continue;
        of.layer = emitted != 0 && walk->depth == 0 ? TY_BAKE_SINGLE : TY_BAKE_MULTIPLE;
        for (int c = 0; c < 3; ++c) of.strength[c] = scale / probability * virtual_emitter->measure * color[c];
        ty_gather_vertex_response(g, walk, &of, &segment);
        if (collided) ty_gather_correct(g, &ray, &of, &at);
        if (corrected) ty_gather_subtract_beyond(g, &ray, &of);
    }
}

/* ---- walks ---- */

/* Adds what a medium emits towards a collision of the walk. at: a point of the medium on the walk's ray; weight: of
 * this sample of the light that collides there. */
TY_FN void ty_walk_add_emission(ty_gather* g, const ty_walk* walk, const ty_medium_view* medium, ty_vec at,
                                const float weight[3], const float albedo[3], float scale) {
    float emission[3];
    if (g->request->media_emit == 0 || medium->emits == 0 || walk->depth == 0) return;
    ty_medium_emission(medium, at, emission);
    for (int c = 0; c < 3; ++c) emission[c] *= scale * walk->beta[c] * walk->ray[c] * weight[c] * (1.0f - albedo[c]);
    ty_gather_add_rgb(g, walk->depth == 1 ? TY_BAKE_SINGLE : TY_BAKE_MULTIPLE, emission, walk->basis);
}

/* Goes on to a collision on the walk's ray, as often as light collides there, and to a ray in a direction of its phase
 * function. False: the walk ends. */
TY_FN bool ty_walk_on(ty_gather* g, ty_walk* walk, float scale) {
    const ty_scene_view* scene = g->request->path.scene;
    ty_path* path = &g->path;
    float weight[3], albedo[3];
    ty_segment segment;
    ty_hit hit;
    ty_fog_point point = ty_fog_point_begin(ty_rng_uniform(&path->random), &path->random);
    segment.point = &point;
    ty_segment_find(&segment, scene->media, scene->medium_count, walk->origin, walk->direction, walk->max_distance);
    if (point.medium == NULL) return false;
    path->origin = walk->origin;
    path->direction = walk->direction;
    walk->origin = ty_gather_fog_position(g, &point, weight, albedo);
    ty_walk_add_emission(g, walk, point.medium, walk->origin, weight, albedo, scale);
    for (int c = 0; c < 3; ++c) weight[c] *= albedo[c];
    const float chance = ty_minf(1.0f, ty_max3(weight));
    if (!(ty_rng_uniform(&path->random) < chance)) return false;
    ty_medium_g(point.medium, walk->origin, walk->g);
    walk->back = walk->direction;
    const float u = ty_rng_uniform(&path->random), v = ty_rng_uniform(&path->random);
    walk->direction = ty_hg_sample(walk->back, walk->g[1], u, v);
    const float mu = ty_clampf(ty_dot(walk->back, walk->direction), -1.0f, 1.0f), density = ty_hg(mu, walk->g[1]);
    for (int c = 0; c < 3; ++c) {
        walk->beta[c] *= walk->ray[c] * weight[c] / chance;
        walk->ray[c] = walk->g[c] == walk->g[1] ? 1.0f : ty_hg(mu, walk->g[c]) / density;
    }
    ++g->rays;
    const bool hits =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, walk->origin, walk->direction, TY_FLOAT_MAX, &hit);
    ty_gather_segment(g, walk->origin, walk->direction, hits ? hit.distance : TY_FLOAT_MAX, &segment);
    walk->max_distance = hits ? hit.distance : segment.leave;
    ++walk->depth;
    return true;
}

/* Adds responses along a walk that begins with the receiver's ray. weight: 1 / density of its direction. */
TY_FN void ty_gather_walk(ty_gather* g, float scale, float weight) {
    ty_walk walk = {.origin = g->origin, .direction = g->direction, .max_distance = g->max_distance};
    for (int c = 0; c < 3; ++c) {
        walk.beta[c] = 1.0f;
        walk.ray[c] = weight;
    }
    ty_gather_basis(g, walk.direction, walk.basis);
    /* A response scatters once more than its vertex is deep; emission of media does not. */
    const int32_t scatterings = g->request->scatterings, past = scatterings + (g->request->media_emit != 0 ? 2 : 0);
    while (true) {
        if (walk.depth < scatterings) {
            ty_gather_corrected_sky(g, &walk, scale);
            ty_gather_corrected_virtual(g, &walk, scale);
        }
        if (walk.depth + 1 >= past || !ty_walk_on(g, &walk, scale)) return;
        g->emitter = ty_rng_uniform(&g->path.random);
        g->collision = ty_rng_uniform(&g->path.random);
    }
}

/* Adds light that media scatter. visible: the light sample, or NULL; hit: its ray hit a surface. */
TY_FN void ty_impulse_gather(ty_gather* g, uint64_t item, uint32_t number, const ty_visible_light* visible, bool hit,
                             float weight, const ty_segment* segment) {
    const ty_bake_request* request = g->request;
    const float scale = (float)request->fog_every;
    ty_bake_sums* sums = g->sums;
    float before[3];
    for (int c = 0; c < 3; ++c) {
        before[c] = g->sample[c];
        g->sample[c] = 0.0f;
    }
    if (request->impulse.published == 0)
        ty_gather_walk(g, scale, weight);
    else
        ty_gather_published(g, item, number / request->fog_every, visible, hit, scale, weight, segment);
    for (int c = 0; c < 3; ++c) {
        const double measure = (double)(g->sample[c] / scale);
        sums->fog_mean[c] += measure;
        sums->fog_square[c] += measure * measure;
        g->sample[c] = before[c];
    }
    ++sums->gather_rays;
}

#endif
