/* Search for virtual emitters and the light they emit.
 *
 * Rays from anchors, a subset of the receivers, find them, so surfaces near and in front of receivers are favoured. The
 * area an emitter represents follows from the density with which all anchors together could have found it (the balance
 * heuristic). Emitters then gather light like receivers: first from surfaces and lights, then, in rounds, from media.
 */
#include "bake/impulse/impulse.h"
#include "bake/impulse/emitter_response.k.h"

#include "base/context.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* Iterations of light between media and surfaces; samples of each. */
enum { ANCHORS_MAX = 64, SENDERS_MIN = 256, PUBLISHED_SENDERS_MIN = 64, ROUNDS = 3, BLOCK = 4 };
enum {
    SURFACE_SAMPLES_MIN = 16,
    SURFACE_SAMPLES_MAX = 256,
    FOG_SAMPLES_MIN = 8,
    FOG_SAMPLES_LAST = 24, /* of the last iteration by collisions */
    LIGHT_POINTS_MAX = 256,
    MEDIUM_RAYS = 1024
};
/* Paths per gather, and at probes by collisions, where directions are far more. */
enum { FOG_EVERY = 4, FOG_EVERY_PROBE = 1 };
/* First sample number of rays to anchors beyond surfaces. */
enum { ANCHOR_SAMPLE = 1 << 16 };

typedef struct emitter_search {
    ty_bake_run* run;
    ty_virtual_emitters* emitters;
    int32_t anchor_count, rays_per_anchor; /* rays per anchor */
    int32_t light_points, medium_rays_per_anchor,
        max_emitters; /* points on local lights; rays per anchor for parts of media; capacity for all emitters */
    float distance_scale, mean_free_path; /* m: scale of the distances along anchor rays; mean free path of the media */
    ty_vec anchors[ANCHORS_MAX];
    ty_bake_receiver* receivers; /* receivers at the emitters, */
    ty_bake_sums* sums;          /* and their gathered sums */
    double* light;
    ty_bake_request request;
    uint32_t samples;
} emitter_search;

enum { LIGHT_SIZE = TY_BAKE_LAYERS * 3 * TY_BAKE_SURFACE_TERMS };

/* ---- anchors ---- */

/* Least height of anchors over their surfaces: a hundredth of the diagonal of the receivers' box, m. From closer by,
 * most rays end on the surface below, at emitters with next to no area, and few on the rest of it. */
static float find_anchor_height(const ty_bake_run* run) {
    float diagonal2 = 0;
    for (int a = 0; a < 3; ++a) {
        float lower = TY_FLOAT_MAX, upper = -TY_FLOAT_MAX;
        for (int64_t i = 0; i < run->count; ++i) {
            lower = fminf(lower, run->request.receivers[i].position[a]);
            upper = fmaxf(upper, run->request.receivers[i].position[a]);
        }
        if (upper > lower) diagonal2 += (upper - lower) * (upper - lower);
    }
    return 0.01f * sqrtf(diagonal2);
}

/* A receiver's point off its surface, at least at that height where there is room for it. */
static ty_vec find_anchor(const ty_gather* g, float height) {
    const ty_accel* mesh = g->request->path.scene->mesh;
    const ty_vec at = ty_gather_find_offset(g);
    ty_hit hit;
    if (!(ty_dot(g->face, g->face) > 0.0f) || ty_dot(g->face, ty_sub(at, g->position)) >= height) return at;
    if (mesh != NULL && ty_accel_intersect(mesh, g->origin, g->face, 2.0f * height, &hit)) height = 0.5f * hit.distance;
    return ty_mad(g->position, g->face, ty_maxf(g->receiver->margin, height));
}

static void choose_receiver_anchors(emitter_search* s) {
    const ty_bake_request* request = &s->run->request;
    const float height = find_anchor_height(s->run);
    ty_gather g = {.request = request};
    s->anchor_count = s->run->count < ANCHORS_MAX ? (int32_t)s->run->count : ANCHORS_MAX;
    for (int32_t i = 0; i < s->anchor_count; ++i) {
        ty_gather_set_receiver(&g, &request->receivers[(2 * i + 1) * s->run->count / (2 * s->anchor_count)]);
        s->anchors[i] = find_anchor(&g, height);
    }
}

/* Adds anchors halfway along rays that surfaces reflect: walks reach surfaces that few receivers see. */
static void add_anchors_beyond(emitter_search* s) {
    const ty_path_request* request = &s->run->request.path;
    const int32_t own = s->anchor_count;
    ty_path path;
    ty_hit hit;
    if (own == 0 || request->scene->mesh == NULL) return;
    for (int32_t i = 0; i < ANCHORS_MAX && s->anchor_count < ANCHORS_MAX; ++i) {
        const int32_t from = i % own;
        ty_path_begin(&path, request, ~(uint64_t)from, (uint32_t)(ANCHOR_SAMPLE + i / own));
        ty_path_sample_sphere(&path);
        if (!ty_accel_intersect(request->scene->mesh, s->anchors[from], path.direction, TY_FLOAT_MAX, &hit)) continue;
        path.normal = ty_scale(hit.normal, ty_dot(hit.normal, path.direction) < 0.0f ? 1.0f : -1.0f);
        const ty_vec origin = ty_hit_leave(&hit, path.normal);
        ty_path_sample_cosine_hemisphere(&path);
        if (!ty_accel_intersect(request->scene->mesh, origin, path.direction, TY_FLOAT_MAX, &hit)) continue;
        s->anchors[s->anchor_count++] = ty_mad(origin, path.direction, 0.5f * hit.distance);
    }
}

static void choose_anchors(emitter_search* s) {
    choose_receiver_anchors(s);
    if (s->run->request.impulse.published == 0) add_anchors_beyond(s);
}

/* ---- properties of the media ---- */

/* Upper bound of the ratio of successive bounces, per channel, where scattered light scatters again with mean
 * probability p before it leaves the medium or hits a surface. The asymptotic ratio is p; the first bounces fall off
 * more slowly, because more of their light is deep in the medium. */
static void find_max_bounce_ratio(emitter_search* s) {
    enum { RAYS = 8 };
    ty_bake_request* request = &s->run->request;
    const ty_accel* mesh = request->path.scene->mesh;
    const ty_gather g = {.request = request};
    double depth[3] = {0}, collision[3] = {0}, length = 0, scattering = 0, cosine = 0;
    ty_path path;
    ty_hit hit;
    ty_segment segment;
    for (int32_t ray = 0; ray < RAYS * s->anchor_count; ++ray) {
        const ty_vec from = s->anchors[ray / RAYS];
        ty_path_begin(&path, &request->path, ~(uint64_t)(ray / RAYS), (uint32_t)(ray % RAYS));
        ty_path_sample_sphere(&path);
        const bool hit_surface = mesh != NULL && ty_accel_intersect(mesh, from, path.direction, TY_FLOAT_MAX, &hit);
        ty_gather_segment(&g, from, path.direction, hit_surface ? hit.distance : TY_FLOAT_MAX, &segment);
        length += hit_surface ? (double)ty_minf(hit.distance, segment.leave) : (double)ty_minf(segment.leave, 1e6f);
        scattering += (double)ty_minf(segment.scattering_depth[1], 1e6f);
        cosine += (double)ty_minf(segment.g_scattering_depth[1], 1e6f);
        for (int c = 0; c < 3; ++c) {
            depth[c] += (double)ty_minf(segment.depth[c], 1e6f);
            collision[c] += (double)ty_collision_probability(segment.depth[c]);
        }
    }
    s->distance_scale = s->anchor_count > 0 ? (float)fmax(1e-6, 3 * length / (RAYS * s->anchor_count)) : 1;
    request->impulse.step = 1e-3f * s->distance_scale;
    request->impulse.mean_cosine = scattering > 0 ? (float)fmin(0.9, fmax(0, cosine / scattering)) : 0;
    s->mean_free_path = (float)(length / fmax(1e-12, fmax(depth[0], fmax(depth[1], depth[2]))));
    for (int c = 0; c < 3; ++c) {
        const double p = depth[c] > 0 ? 1 - collision[c] / depth[c] : 1;
        request->impulse.max_bounce_ratio[c] = p < 1 ? (float)(p / (1 - p * p)) : TY_FLOAT_MAX;
    }
}

/* True if all media have one albedo and one g in a channel. */
static bool are_uniform(const ty_scene_view* scene, int channel, float* albedo, float* g) {
    for (int32_t i = 0; i < scene->medium_count; ++i) {
        const ty_medium_view* medium = &scene->media[i];
        const float medium_albedo = medium->sigma_s[channel] / medium->sigma_t[channel];
        if (medium->albedo_fields != 0 || medium->transfer_albedo != 0 || medium->has_g_field != 0) return false;
        if (!(medium->sigma_t[channel] > 0)) return false;
        if (i > 0 && (medium_albedo != *albedo || medium->g[channel] != *g)) return false;
        *albedo = medium_albedo;
        *g = medium->g[channel];
    }
    return true;
}

static ty_result merge_tables(ty_bake_run* run) {
    ty_bake_request* request = &run->request;
    const size_t rows = ty_impulse_merged_rows();
    run->impulse.merged_size = 3 * rows;
    run->impulse.merged = ty_alloc_array(run->context, run->impulse.merged_size, sizeof *run->impulse.merged, false);
    if (run->impulse.merged == NULL) return TY_ERROR_MEMORY;
    for (int c = 0; c < (request->gray != 0 ? 1 : 3); ++c) {
        float albedo = 0, g = 0;
        if (are_uniform(request->path.scene, c, &albedo, &g))
            ty_impulse_merge(request->impulse.tables, albedo, g, request->scatterings,
                             request->impulse.max_bounce_ratio[c], run->impulse.merged + (size_t)c * rows,
                             &request->impulse.merged[c]);
    }
    return TY_OK;
}

/* ---- surfaces ---- */

static bool find_surface_emitter(const emitter_search* s, int32_t ray, ty_virtual_emitter* out) {
    const ty_path_request* request = &s->run->request.path;
    const int32_t anchor = ray / s->rays_per_anchor;
    ty_path path;
    ty_intersection end;
    ty_path_begin(&path, request, ~(uint64_t)anchor, (uint32_t)(ray % s->rays_per_anchor));
    ty_path_sample_sphere(&path);
    if (!ty_accel_intersect(request->scene->mesh, s->anchors[anchor], path.direction, TY_FLOAT_MAX, &end.hit))
        return false;
    ty_surface_evaluate(&request->scene->surfaces[end.hit.surface], &end.hit, path.direction, &end.point);
    *out = (ty_virtual_emitter){.position = end.hit.position,
                                .normal = end.point.ns,
                                .face = end.point.ng,
                                .margin = end.hit.margin,
                                .kind = TY_IMPULSE_AREA,
                                .light = -1};
    double density = 0;
    for (int32_t i = 0; i < s->anchor_count; ++i) {
        /* The anchor may lie closer to the emitter's plane than the margin: distances are those of its ray. */
        const ty_vec from = ty_mad(out->position, out->face, out->margin), to = ty_sub(s->anchors[i], out->position);
        const float d2 = ty_dot(to, to), inverse_distance = 1.0f / sqrtf(d2),
                    cosine = ty_dot(out->face, to) * inverse_distance;
        const bool own = i == anchor;
        if (!(d2 > 0.0f) || !(cosine > 0.0f)) continue;
        if (own ||
            !ty_accel_occluded(request->scene->mesh, from, ty_scale(to, inverse_distance), 0.9999f / inverse_distance))
            density += (double)(cosine / d2) * s->rays_per_anchor * (double)TY_INV_4PI;
    }
    if (!(density > 0)) return false;
    out->area = out->measure = (float)(1 / density);
    for (int c = 0; c < 3; ++c) {
        out->albedo[c] = end.point.albedo[c];
        out->emission[c] = end.point.light < 0 ? end.point.emission[c] : 0.0f;
    }
    return true;
}

static void find_surface_emitters(void* user, int64_t ray, int32_t worker) {
    const emitter_search* s = user;
    (void)worker;
    if (!find_surface_emitter(s, (int32_t)ray, &s->emitters->items[ray])) s->emitters->items[ray].area = 0;
}

/* ---- local lights ---- */

/* Power weight of a local light for the distribution of points: intensity along its normal. */
static double local_light_power(const ty_light_view* light) {
    const double color = (double)light->color[0] + (double)light->color[1] + (double)light->color[2];
    const double radius = (double)light->radius;
    if (ty_light_is_distant(light)) return 0;
    if (light->kind == TY_KIND_SPHERE) return color * (double)TY_PI * radius * radius;
    if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE)
        return color * (double)light->area * (light->two_sided != 0 ? 2 : 1);
    return color;
}

/* Point k of count on a local light that was selected with the given probability. */
static ty_virtual_emitter local_light_point(const emitter_search* s, int32_t index, int32_t k, int32_t count,
                                            double probability) {
    const ty_light_view* light = &s->run->request.path.scene->lights.lights[index];
    ty_virtual_emitter out = {
        .position = light->position, .kind = TY_IMPULSE_POINT, .light = index, .measure = (float)probability};
    for (int c = 0; c < 3; ++c) out.emission[c] = light->color[c];
    if (light->kind == TY_KIND_SPHERE) {
        out.area = TY_PI * light->radius * light->radius;
        out.radius = light->radius * 1.001f;
        out.measure *= out.area;
    }
    if (light->kind != TY_KIND_AREA && light->kind != TY_KIND_TRIANGLE) return out;
    float b1, b2;
    /* Both sides emit from the same points (Hammersley). */
    const int32_t sides = light->two_sided != 0 ? 2 : 1, point = k / sides;
    const bool back = k % sides == 1;
    const float u = ((float)point + 0.5f) * (float)sides / (float)count;
    const float v = ty_unit_float(ty_reverse_bits((uint32_t)point));
    out.kind = TY_IMPULSE_AREA;
    out.light = -1;
    out.position = ty_light_point(light, u, v, &b1, &b2);
    out.normal = out.face = ty_scale(light->direction, back ? -1.0f : 1.0f);
    out.area = light->area * (float)sides / (float)count;
    out.measure *= out.area;
    if (light->textured != NULL) ty_surface_mean_emission(light->textured, light->primitive_id, b1, b2, out.emission);
    return out;
}

/* Distributes points over local lights by power: faint lights get one with the probability of their fraction. */
static void sample_local_lights(emitter_search* s) {
    const ty_light_set* lights = &s->run->request.path.scene->lights;
    ty_sampler random = ty_sampler_begin(s->run->request.path.sobol, s->run->def->seed, UINT64_MAX, 0);
    double all = 0;
    for (int32_t i = 0; i < lights->count; ++i) all += local_light_power(&lights->lights[i]);
    for (int32_t i = 0; i < lights->count && all > 0; ++i) {
        const ty_light_view* light = &lights->lights[i];
        const bool flat = light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE;
        const double wanted = 0.5 * s->light_points * local_light_power(light) / all;
        int32_t count = flat ? (int32_t)ceil(wanted) : 1;
        if (!(wanted > 0)) continue;
        if (light->two_sided != 0 && flat) count += count % 2;
        const double probability = fmin(1, wanted);
        if (probability < 1 && (double)ty_rng_uniform(&random) >= probability) continue;
        for (int32_t k = 0; k < count && s->emitters->count < s->emitters->surfaces + s->light_points; ++k)
            s->emitters->items[s->emitters->count++] = local_light_point(s, i, k, count, 1 / probability);
    }
}

/* ---- parts of media ---- */

/* A part of a medium lit by a distant light, on a ray of an anchor at a random distance of scale s->distance_scale. */
static bool find_medium_emitter(const emitter_search* s, int32_t ray, ty_virtual_emitter* out) {
    const ty_path_request* request = &s->run->request.path;
    const ty_light_set* lights = &request->scene->lights;
    const ty_accel* mesh = request->scene->mesh;
    const ty_gather g = {.request = &s->run->request};
    ty_path path;
    ty_segment segment;
    ty_light_sample sample;
    const int32_t anchor = ray / s->medium_rays_per_anchor;
    ty_path_begin(&path, request, ~(uint64_t)anchor, (uint32_t)(ray % s->medium_rays_per_anchor));
    ty_path_sample_sphere(&path);
    const float u = ty_sobol_next(&path.random), distance = s->distance_scale * u / (1 - u);
    const float pick = ty_sobol_next(&path.random), a = ty_sobol_next(&path.random), b = ty_sobol_next(&path.random);
    const ty_vec from = s->anchors[anchor], at = ty_mad(from, path.direction, distance);
    if (mesh != NULL && ty_accel_occluded(mesh, from, path.direction, distance)) return false;
    const ty_light_view* light = &lights->lights[lights->distant[(int32_t)(pick * (float)lights->distant_count)]];
    if (!ty_light_sample_from(light, at, a, b, &sample)) return false;
    const float step = s->run->request.impulse.step;
    ty_gather_segment(&g, at, sample.wi, step, &segment);
    *out = (ty_virtual_emitter){.position = at, .kind = TY_IMPULSE_POINT, .light = -1, .in_medium = 1, .wi = sample.wi};
    for (int c = 0; c < 3; ++c) {
        out->outgoing[c] =
            segment.scattering_depth[c] / step * (float)lights->distant_count * TY_INV_4PI * sample.radiance[c];
        out->g[c] = segment.scattering_depth[c] > 0 ? segment.g_scattering_depth[c] / segment.scattering_depth[c] : 0;
    }
    if (!(ty_max3(out->outgoing) > 0) || (mesh != NULL && ty_accel_occluded(mesh, at, sample.wi, TY_FLOAT_MAX)))
        return false;
    ty_gather_segment(&g, at, sample.wi, TY_FLOAT_MAX, &segment);
    double density = 0;
    for (int32_t i = 0; i < s->anchor_count; ++i) {
        const ty_vec to = ty_sub(s->anchors[i], at);
        const float d2 = ty_dot(to, to), d = sqrtf(d2);
        if (!(d > 0) || (i != anchor && mesh != NULL && ty_accel_occluded(mesh, at, ty_scale(to, 1 / d), d))) continue;
        density += (double)(s->distance_scale / (d2 * (s->distance_scale + d) * (s->distance_scale + d))) *
                   s->medium_rays_per_anchor * (double)TY_INV_4PI;
    }
    if (!(density > 0)) return false;
    for (int c = 0; c < 3; ++c) out->outgoing[c] *= segment.transmittance[c];
    out->measure = (float)(1 / density);
    /* The mean of 1 / d^2 over a ball about its center is 3 / radius^2. */
    const double radius = cbrt(0.75 / (double)TY_PI * (double)out->measure);
    out->area = (float)(4 * (double)TY_PI * radius * radius / 3);
    return true;
}

static void find_medium_emitters(void* user, int64_t ray, int32_t worker) {
    const emitter_search* s = user;
    (void)worker;
    ty_virtual_emitter* out = &s->emitters->items[s->emitters->count + ray];
    if (!find_medium_emitter(s, (int32_t)ray, out)) out->measure = 0;
}

static void sample_media(emitter_search* s) {
    ty_virtual_emitters* emitters = s->emitters;
    const int32_t rays = s->anchor_count * s->medium_rays_per_anchor;
    if (s->run->request.impulse.published == 0 || s->run->request.path.scene->lights.distant_count == 0) return;
    ty_parallel_flushed(s->run->context, rays, find_medium_emitters, s);
    const int32_t first = emitters->count;
    for (int32_t i = 0; i < rays; ++i)
        if (emitters->items[first + i].measure > 0) emitters->items[emitters->count++] = emitters->items[first + i];
}

static void find_emitters(emitter_search* s) {
    ty_virtual_emitters* emitters = s->emitters;
    const int64_t rays = (int64_t)s->anchor_count * s->rays_per_anchor;
    if (s->run->request.path.scene->mesh != NULL) ty_parallel_flushed(s->run->context, rays, find_surface_emitters, s);
    for (int64_t i = 0; i < rays; ++i)
        if (emitters->items[i].area > 0) emitters->items[emitters->count++] = emitters->items[i];
    emitters->surfaces = emitters->count;
    sample_local_lights(s);
    emitters->local_lights = emitters->count - emitters->surfaces;
    sample_media(s);
    for (int32_t i = 0; i < emitters->count; ++i) {
        const ty_virtual_emitter* at = &emitters->items[i];
        ty_bake_receiver* receiver = &s->receivers[i];
        *receiver = (ty_bake_receiver){.position = {at->position.x, at->position.y, at->position.z},
                                       .normal = {at->normal.x, at->normal.y, at->normal.z},
                                       .face = {at->face.x, at->face.y, at->face.z},
                                       .margin = at->margin};
        emitters->x[i] = at->position.x;
        emitters->y[i] = at->position.y;
        emitters->z[i] = at->position.z;
        emitters->nx[i] = at->normal.x;
        emitters->ny[i] = at->normal.y;
        emitters->nz[i] = at->normal.z;
        emitters->area[i] = at->area;
    }
}

/* Lays out the lattice over all surface emitters. */
static void lay_out_cells(ty_virtual_emitters* emitters) {
    for (int a = 0; a < 3; ++a) {
        const float* at = a == 0 ? emitters->x : a == 1 ? emitters->y : emitters->z;
        float lower = 0, upper = 0;
        for (int32_t i = 0; i < emitters->surfaces; ++i) {
            lower = i == 0 ? at[i] : fminf(lower, at[i]);
            upper = i == 0 ? at[i] : fmaxf(upper, at[i]);
        }
        emitters->lower[a] = lower;
        emitters->per_metre[a] = upper > lower ? (float)emitters->side / (upper - lower) : 0;
    }
}

/* ---- light ---- */

static void gather_block(void* user, int64_t block, int32_t worker) {
    const emitter_search* s = user;
    (void)worker;
    const int64_t begin = block * BLOCK, left = s->emitters->surfaces - begin;
    s->run->kernel(&s->request, begin, begin + (left < BLOCK ? left : BLOCK), 0, s->samples, s->sums, s->light);
}

static void gather(emitter_search* s, uint32_t samples) {
    const size_t count = (size_t)s->emitters->surfaces;
    memset(s->sums, 0, count * sizeof *s->sums);
    memset(s->light, 0, count * LIGHT_SIZE * sizeof *s->light);
    s->samples = samples;
    ty_parallel_flushed(s->run->context, (s->emitters->surfaces + BLOCK - 1) / BLOCK, gather_block, s);
}

/* Gathered irradiance summed over layers. */
static double gathered(const emitter_search* s, int32_t emitter, int channel) {
    double sum = 0;
    for (int32_t layer = 0; layer < TY_BAKE_LAYERS; ++layer)
        sum += s->light[(size_t)emitter * LIGHT_SIZE + (size_t)((layer * 3 + channel) * TY_BAKE_SURFACE_TERMS)];
    return sum / s->samples;
}

static void set_power(emitter_search* s, const float* from_surfaces, const float* from_media) {
    for (int32_t i = 0; i < s->emitters->count; ++i) {
        ty_virtual_emitter* at = &s->emitters->items[i];
        float power = 0;
        if (at->in_medium != 0) {
            s->emitters->power[i] = 2 * s->mean_free_path * at->measure * ty_sum3(at->outgoing);
            continue;
        }
        for (int c = 0; c < 3; ++c) {
            at->outgoing[c] =
                at->albedo[c] * (1.0f / TY_PI) * fmaxf(0, from_surfaces[3 * i + c] + from_media[3 * i + c]);
            power += at->measure * (at->outgoing[c] + at->emission[c]);
        }
        s->emitters->power[i] = power;
    }
}

/* Input of the lattice cells. */
typedef struct cells_job {
    const ty_virtual_emitters* emitters;
    const float* from_media;
} cells_job;

static void fill_cell(void* user, int64_t index, int32_t worker) {
    const cells_job* job = user;
    const ty_virtual_emitters* emitters = job->emitters;
    (void)worker;
    const int32_t side = emitters->side,
                  at[3] = {(int32_t)index % side, (int32_t)index / side % side, (int32_t)index / side / side};
    float center[3], half_diagonal2 = 0;
    double sums[TY_FOG_SIDES][4] = {{0}};
    for (int a = 0; a < 3; ++a) {
        const float size = emitters->per_metre[a] > 0 ? 1 / emitters->per_metre[a] : 0;
        center[a] = emitters->lower[a] + ((float)at[a] + 0.5f) * size;
        half_diagonal2 += 0.25f * size * size;
    }
    for (int32_t i = 0; i < emitters->surfaces; ++i) {
        const float x = emitters->x[i] - center[0], y = emitters->y[i] - center[1], z = emitters->z[i] - center[2];
        const float d2 = x * x + y * y + z * z + half_diagonal2 + 1e-12f;
        const float normal[3] = {emitters->nx[i], emitters->ny[i], emitters->nz[i]};
        for (int k = 0; k < TY_FOG_SIDES; ++k) {
            const float cosine = k % 2 == 0 ? -normal[k / 2] : normal[k / 2];
            const float facing = fmaxf(0.01f, cosine);
            const double weight = (double)(facing * facing) / ((double)d2 * (double)d2);
            for (int c = 0; c < 3; ++c) sums[k][c] += weight * (double)job->from_media[3 * i + c];
            sums[k][3] += weight;
        }
    }
    for (int k = 0; k < TY_FOG_SIDES; ++k)
        for (int c = 0; c < 3; ++c)
            emitters->cells[index].irradiance[k][c] = sums[k][3] > 0 ? (float)fmax(0, sums[k][c] / sums[k][3]) : 0;
}

static void light_emitters(emitter_search* s, uint32_t samples, float* from_surfaces, float* from_media) {
    ty_virtual_emitters* emitters = s->emitters;
    cells_job job = {emitters, from_media};
    s->request.method = TY_BAKE_ATTENUATION;
    gather(s, samples);
    for (int32_t i = 0; i < emitters->surfaces; ++i)
        for (int c = 0; c < 3; ++c) from_surfaces[3 * i + c] = (float)gathered(s, i, c);
    set_power(s, from_surfaces, from_media);
    s->request.method = TY_BAKE_IMPULSE;
    s->request.impulse.media_only = 1;
    s->request.fog_every = 1;
    for (int round = 0; round < ROUNDS; ++round) {
        const bool last = s->run->request.impulse.published == 0 && round == ROUNDS - 1;
        const uint32_t min_samples = last ? FOG_SAMPLES_LAST : FOG_SAMPLES_MIN;
        gather(s, samples / 4 > min_samples ? samples / 4 : min_samples);
        for (int32_t i = 0; i < emitters->surfaces; ++i)
            for (int c = 0; c < 3; ++c) from_media[3 * i + c] = (float)gathered(s, i, c);
        set_power(s, from_surfaces, from_media);
        ty_parallel_flushed(s->run->context, (int64_t)emitters->side * emitters->side * emitters->side, fill_cell,
                            &job);
    }
}

/* ---- tables ---- */

bool ty_bake_impulse_emits(const ty_bake_run* run) {
    return run->def->method == TY_BAKE_IMPULSE && run->path.view.medium_count > 0;
}

ty_result ty_bake_impulse_take_tables(ty_bake_run* run) {
    const ty_bake_def* def = run->def;
    if (!ty_bake_impulse_emits(run)) return TY_OK;
    run->request.impulse.tables = def->tables;
    if (def->tables != NULL) return TY_OK;
    ty_impulse_def impulse = ty_default_impulse_def();
    ty_impulse_stats stats = ty_default_impulse_stats();
    if (def->scatterings > impulse.bounces) impulse.bounces = def->scatterings;
    impulse.progress = def->progress;
    impulse.progress_user = def->progress_user;
    const ty_result result = ty_impulse_create(run->context, &impulse, &run->impulse.tables, &stats);
    if (result != TY_OK) return result;
    run->request.impulse.tables = run->impulse.tables;
    run->stats.table_seconds = stats.seconds;
    return TY_OK;
}

/* ---- memory ---- */

/* Number of selection arrays of the emitters. */
enum { SELECTION_ARRAYS = 8 };

static size_t cells_of(const ty_virtual_emitters* emitters) {
    return (size_t)(emitters->side * emitters->side * emitters->side);
}

static ty_result allocate_emitters(ty_bake_run* run, int32_t capacity) {
    ty_virtual_emitters* emitters = &run->impulse.emitters;
    run->impulse.emitter_capacity = (size_t)capacity;
    emitters->side = (int32_t)fmin(TY_FOG_SIDE_MAX, ceil(cbrt(capacity)));
    emitters->items = ty_alloc_array(run->context, run->impulse.emitter_capacity, sizeof *emitters->items, true);
    emitters->x =
        ty_alloc_array(run->context, run->impulse.emitter_capacity * SELECTION_ARRAYS, sizeof *emitters->x, true);
    emitters->cells = ty_alloc_array(run->context, cells_of(emitters), sizeof *emitters->cells, true);
    if (emitters->items == NULL || emitters->x == NULL || emitters->cells == NULL) return TY_ERROR_MEMORY;
    float** arrays[SELECTION_ARRAYS] = {&emitters->x,  &emitters->y,  &emitters->z,     &emitters->nx,
                                        &emitters->ny, &emitters->nz, &emitters->power, &emitters->area};
    for (int i = 1; i < SELECTION_ARRAYS; ++i) *arrays[i] = emitters->x + (size_t)i * run->impulse.emitter_capacity;
    return TY_OK;
}

void ty_bake_impulse_end(ty_bake_run* run) {
    ty_virtual_emitters* emitters = &run->impulse.emitters;
    ty_free_array(run->context, emitters->items, run->impulse.emitter_capacity, sizeof *emitters->items);
    ty_free_array(run->context, emitters->x, run->impulse.emitter_capacity * SELECTION_ARRAYS, sizeof *emitters->x);
    ty_free_array(run->context, emitters->cells, cells_of(emitters), sizeof *emitters->cells);
    *emitters = (ty_virtual_emitters){.count = 0};
    ty_free_array(run->context, run->impulse.merged, run->impulse.merged_size, sizeof *run->impulse.merged);
    ty_impulse_destroy(run->impulse.tables);
}

/* Emitter paths are a small fraction of all paths; the number of paths per emitter equals the number of emitters. */
ty_result ty_bake_impulse_begin(ty_bake_run* run) {
    ty_context* context = run->context;
    const double paths = (double)run->count * run->def->spp;
    run->request.impulse.emitters = &run->impulse.emitters;
    const bool published = run->request.impulse.published != 0;
    run->request.fog_every = !published && run->request.terms == TY_BAKE_SH_TERMS ? FOG_EVERY_PROBE : FOG_EVERY;
    emitter_search s = {.run = run, .emitters = &run->impulse.emitters};
    const int32_t medium_rays = published ? MEDIUM_RAYS : 0;
    choose_anchors(&s);
    const double wanted = fmin(TY_VIRTUAL_EMITTERS_MAX - LIGHT_POINTS_MAX - medium_rays,
                               fmax(published ? PUBLISHED_SENDERS_MIN : SENDERS_MIN, sqrt(paths / 8)));
    s.rays_per_anchor = s.anchor_count > 0 ? (int32_t)(wanted / s.anchor_count) : 0;
    s.light_points = (int32_t)fmin(LIGHT_POINTS_MAX, 0.5 * wanted);
    s.medium_rays_per_anchor = s.anchor_count > 0 ? medium_rays / s.anchor_count : 0;
    s.max_emitters = s.anchor_count * s.rays_per_anchor + s.light_points + s.anchor_count * s.medium_rays_per_anchor;
    const size_t capacity = (size_t)s.max_emitters;
    ty_result result = allocate_emitters(run, s.max_emitters);
    s.receivers = ty_alloc_array(context, capacity, sizeof *s.receivers, true);
    s.sums = ty_alloc_array(context, capacity, sizeof *s.sums, true);
    s.light = ty_alloc_array(context, capacity * LIGHT_SIZE, sizeof *s.light, true);
    float* light = ty_alloc_array(context, 6 * capacity, sizeof *light, true);
    if (s.receivers == NULL || s.sums == NULL || s.light == NULL || light == NULL) result = TY_ERROR_MEMORY;
    if (result == TY_OK) {
        find_max_bounce_ratio(&s);
        result = merge_tables(run);
    }
    if (result == TY_OK) {
        find_emitters(&s);
        lay_out_cells(&run->impulse.emitters);
        s.request = run->request;
        s.request.path.seed = ~run->def->seed;
        s.request.receivers = s.receivers;
        s.request.terms = TY_BAKE_SURFACE_TERMS;
        const double samples = paths / (64 * (double)capacity);
        light_emitters(&s, (uint32_t)fmin(SURFACE_SAMPLES_MAX, fmax(SURFACE_SAMPLES_MIN, samples)), light,
                       light + 3 * capacity);
    }
    ty_free_array(context, light, 6 * capacity, sizeof *light);
    ty_free_array(context, s.light, capacity * LIGHT_SIZE, sizeof *s.light);
    ty_free_array(context, s.sums, capacity, sizeof *s.sums);
    ty_free_array(context, s.receivers, capacity, sizeof *s.receivers);
    return result;
}
