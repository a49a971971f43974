/* Finding senders, and the light that they send.
 *
 * Rays from anchors, a few of the receivers, find them: where receivers are and where they look, surfaces count. All
 * anchors together could have found each, which tells the area that it stands for (the balance heuristic). Senders then
 * gather light like any receiver: first what surfaces and lights send, then, in rounds, what media make of that. */
#include "bake/gather.h"
#include "bake/gather.k.h"

#include "base/context.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* Rounds of light from media to surfaces and back; samples of each. */
enum { ANCHORS_MAX = 64, SENDERS_MIN = 64, ROUNDS = 3, BLOCK = 4 };
enum { CLEAR_SAMPLES_MIN = 16, CLEAR_SAMPLES_MAX = 256, FOG_SAMPLES_MIN = 8, LAMP_POINTS_MAX = 256, LIT_RAYS = 1024 };
enum { FOG_EVERY = 4 };

typedef struct search {
    ty_bake_run* run;
    ty_senders* senders;
    int32_t anchor_count, each;          /* rays of one anchor */
    int32_t lamp_points, lit_each, most; /* of lamps; rays of one anchor for parts of media; of all, at most */
    float reach, free; /* m: how far rays of anchors go in the mean; and light in media before it is met */
    ty_vec anchors[ANCHORS_MAX];
    ty_bake_receiver* receivers; /* the senders, */
    ty_bake_sums* sums;          /* and what they gather */
    double* light;
    ty_bake_request request;
    uint32_t samples;
} search;

enum { LIGHT_SIZE = TY_BAKE_LAYERS * 3 * TY_BAKE_SURFACE_TERMS };

/* ---- places ---- */

static void place_anchors(search* s) {
    const ty_bake_request* request = &s->run->request;
    ty_gather g = {.request = request};
    for (int32_t i = 0; i < s->anchor_count; ++i) {
        ty_gather_stand(&g, &request->receivers[(2 * i + 1) * s->run->count / (2 * s->anchor_count)]);
        s->anchors[i] = ty_gather_off(&g);
    }
}

/* ---- what media are like ---- */

/* How many times as bright as one bounce the next is at most, per channel, where light that scattered does so again
 * with a mean probability p before it leaves the medium or meets a surface. In the long run it is p; the first bounces
 * fall off less, more of their light being deep in the medium. */
static void find_most(search* s) {
    enum { RAYS = 8 };
    ty_bake_request* request = &s->run->request;
    const ty_accel* mesh = request->path.scene->mesh;
    const ty_gather g = {.request = request};
    double depth[3] = {0}, stopped[3] = {0}, length = 0;
    ty_path path;
    ty_hit hit;
    ty_segment segment;
    for (int32_t ray = 0; ray < RAYS * s->anchor_count; ++ray) {
        const ty_vec from = s->anchors[ray / RAYS];
        ty_path_begin(&path, &request->path, ~(uint64_t)(ray / RAYS), (uint32_t)(ray % RAYS));
        ty_path_sample_sphere(&path);
        const bool met = mesh != NULL && ty_accel_intersect(mesh, from, path.direction, TY_FLOAT_MAX, &hit);
        ty_gather_segment(&g, from, path.direction, met ? hit.distance : TY_FLOAT_MAX, &segment);
        length += met ? (double)ty_minf(hit.distance, segment.leave) : (double)ty_minf(segment.leave, 1e6f);
        for (int c = 0; c < 3; ++c) {
            depth[c] += (double)ty_minf(segment.depth[c], 1e6f);
            stopped[c] += (double)ty_collision_probability(segment.depth[c]);
        }
    }
    s->reach = s->anchor_count > 0 ? (float)fmax(1e-6, 3 * length / (RAYS * s->anchor_count)) : 1;
    s->free = (float)(length / fmax(1e-12, fmax(depth[0], fmax(depth[1], depth[2]))));
    for (int c = 0; c < 3; ++c) {
        const double p = depth[c] > 0 ? 1 - stopped[c] / depth[c] : 1;
        request->most[c] = p < 1 ? (float)(p / (1 - p * p)) : TY_FLOAT_MAX;
    }
}

/* Whether all media have one albedo and one g in a channel. */
static bool are_alike(const ty_scene_view* scene, int channel, float* albedo, float* g) {
    for (int32_t i = 0; i < scene->medium_count; ++i) {
        const ty_medium_view* medium = &scene->media[i];
        const float own = medium->sigma_s[channel] / medium->sigma_t[channel];
        if (medium->albedo_fields != 0 || medium->transfer_albedo != 0 || medium->has_g_field != 0) return false;
        if (!(medium->sigma_t[channel] > 0)) return false;
        if (i > 0 && (own != *albedo || medium->g[channel] != *g)) return false;
        *albedo = own;
        *g = medium->g[channel];
    }
    return true;
}

static ty_result merge_tables(ty_bake_run* run) {
    ty_bake_request* request = &run->request;
    const size_t rows = ty_impulse_merged_rows();
    run->merged_size = 3 * rows;
    run->merged = ty_alloc_array(run->context, run->merged_size, sizeof *run->merged, false);
    if (run->merged == NULL) return TY_ERROR_MEMORY;
    for (int c = 0; c < (request->gray != 0 ? 1 : 3); ++c) {
        float albedo = 0, g = 0;
        if (are_alike(request->path.scene, c, &albedo, &g))
            ty_impulse_merge(request->tables, albedo, g, request->scatterings, request->most[c],
                             run->merged + (size_t)c * rows, &request->merged[c]);
    }
    return TY_OK;
}

/* ---- surfaces ---- */

static bool find_sender(const search* s, int32_t ray, ty_sender* out) {
    const ty_path_request* request = &s->run->request.path;
    const int32_t anchor = ray / s->each;
    ty_path path;
    ty_intersection end;
    ty_path_begin(&path, request, ~(uint64_t)anchor, (uint32_t)(ray % s->each));
    ty_path_sample_sphere(&path);
    if (!ty_accel_intersect(request->scene->mesh, s->anchors[anchor], path.direction, TY_FLOAT_MAX, &end.hit))
        return false;
    ty_surface_evaluate(&request->scene->surfaces[end.hit.surface], &end.hit, path.direction, &end.point);
    *out = (ty_sender){.position = end.hit.position,
                       .normal = end.point.ns,
                       .face = end.point.ng,
                       .margin = end.hit.margin,
                       .kind = TY_IMPULSE_AREA,
                       .light = -1};
    double density = 0;
    for (int32_t i = 0; i < s->anchor_count; ++i) {
        const ty_vec from = ty_mad(out->position, out->face, out->margin), to = ty_sub(s->anchors[i], from);
        const float d2 = ty_dot(to, to), over = 1.0f / sqrtf(d2), cosine = ty_dot(out->face, to) * over;
        const bool own = i == anchor;
        if (!(d2 > 0.0f) || !(cosine > 0.0f)) continue;
        if (own || !ty_accel_occluded(request->scene->mesh, from, ty_scale(to, over), 0.9999f / over))
            density += (double)(cosine / d2) * s->each * (double)TY_INV_4PI;
    }
    if (!(density > 0)) return false;
    out->area = out->amount = (float)(1 / density);
    for (int c = 0; c < 3; ++c) {
        out->albedo[c] = end.point.albedo[c];
        out->glows[c] = end.point.light < 0 ? end.point.emission[c] : 0.0f;
    }
    return true;
}

static void find_senders(void* user, int64_t ray, int32_t worker) {
    const search* s = user;
    (void)worker;
    if (!find_sender(s, (int32_t)ray, &s->senders->at[ray])) s->senders->at[ray].area = 0;
}

/* ---- lamps ---- */

/* What a lamp sends, to share points among lamps by: intensity along its normal. */
static double lamp_power(const ty_light_view* light) {
    const double color = (double)light->color[0] + (double)light->color[1] + (double)light->color[2];
    const double radius = (double)light->radius;
    if (ty_light_is_far(light)) return 0;
    if (light->kind == TY_KIND_SPHERE) return color * (double)TY_PI * radius * radius;
    if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE)
        return color * (double)light->area * (light->two_sided != 0 ? 2 : 1);
    return color;
}

/* Point k of count of a lamp, each of which stands for `share` lamps. */
static ty_sender lamp_point(const search* s, int32_t index, int32_t k, int32_t count, double share) {
    const ty_light_view* light = &s->run->request.path.scene->lights.lights[index];
    ty_sender out = {.position = light->position, .kind = TY_IMPULSE_POINT, .light = index, .amount = (float)share};
    for (int c = 0; c < 3; ++c) out.glows[c] = light->color[c];
    if (light->kind == TY_KIND_SPHERE) {
        out.area = TY_PI * light->radius * light->radius;
        out.amount *= out.area;
    }
    if (light->kind != TY_KIND_AREA && light->kind != TY_KIND_TRIANGLE) return out;
    float b1, b2;
    const bool back = light->two_sided != 0 && k % 2 == 1;
    const float u = ((float)k + 0.5f) / (float)count, v = ty_unit_float(ty_reverse_bits((uint32_t)k));
    out.kind = TY_IMPULSE_AREA;
    out.light = -1;
    out.position = ty_light_point(light, u, v, &b1, &b2);
    out.normal = out.face = ty_scale(light->direction, back ? -1.0f : 1.0f);
    out.area = light->area * (light->two_sided != 0 ? 2.0f : 1.0f) / (float)count;
    out.amount *= out.area;
    if (light->textured != NULL) ty_surface_mean_emission(light->textured, light->primitive_id, b1, b2, out.glows);
    return out;
}

/* Shares points among lamps: faint ones get one by chance. */
static void place_lamps(search* s) {
    const ty_light_set* lights = &s->run->request.path.scene->lights;
    ty_sampler random = ty_sampler_begin(s->run->request.path.sobol, s->run->def->seed, UINT64_MAX, 0);
    double all = 0;
    for (int32_t i = 0; i < lights->count; ++i) all += lamp_power(&lights->lights[i]);
    for (int32_t i = 0; i < lights->count && all > 0; ++i) {
        const ty_light_view* light = &lights->lights[i];
        const bool flat = light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE;
        const double wanted = 0.5 * s->lamp_points * lamp_power(light) / all;
        int32_t count = flat ? (int32_t)ceil(wanted) : 1;
        if (!(wanted > 0)) continue;
        if (light->two_sided != 0 && flat) count += count % 2;
        const double share = fmin(1, wanted);
        if (share < 1 && (double)ty_rng_uniform(&random) >= share) continue;
        for (int32_t k = 0; k < count && s->senders->count < s->senders->surfaces + s->lamp_points; ++k)
            s->senders->at[s->senders->count++] = lamp_point(s, i, k, count, 1 / share);
    }
}

/* ---- parts of media ---- */

/* A part of a medium that light from afar reaches: along a ray of an anchor, at a distance of any length, typically
 * s->reach. */
static bool find_lit(const search* s, int32_t ray, ty_sender* out) {
    const ty_path_request* request = &s->run->request.path;
    const ty_light_set* lights = &request->scene->lights;
    const ty_accel* mesh = request->scene->mesh;
    const ty_gather g = {.request = &s->run->request};
    ty_path path;
    ty_segment segment;
    ty_light_sample sample;
    const int32_t anchor = ray / s->lit_each;
    ty_path_begin(&path, request, ~(uint64_t)anchor, (uint32_t)(ray % s->lit_each));
    ty_path_sample_sphere(&path);
    const float u = ty_sobol_next(&path.random), distance = s->reach * u / (1 - u);
    const float pick = ty_sobol_next(&path.random), a = ty_sobol_next(&path.random), b = ty_sobol_next(&path.random);
    const ty_vec from = s->anchors[anchor], at = ty_mad(from, path.direction, distance);
    if (mesh != NULL && ty_accel_occluded(mesh, from, path.direction, distance)) return false;
    const ty_light_view* light = &lights->lights[lights->distant[(int32_t)(pick * (float)lights->distant_count)]];
    if (!ty_light_sample_from(light, at, a, b, &sample)) return false;
    const float step = 1e-3f * s->reach;
    ty_gather_segment(&g, at, sample.wi, step, &segment);
    *out = (ty_sender){.position = at, .kind = TY_IMPULSE_POINT, .light = -1, .lit = 1, .toward = sample.wi};
    for (int c = 0; c < 3; ++c) {
        out->sends[c] = segment.scattered[c] / step * (float)lights->distant_count * TY_INV_4PI * sample.radiance[c];
        out->g[c] = segment.scattered[c] > 0 ? segment.turned[c] / segment.scattered[c] : 0;
    }
    if (!(ty_max3(out->sends) > 0) || (mesh != NULL && ty_accel_occluded(mesh, at, sample.wi, TY_FLOAT_MAX)))
        return false;
    ty_gather_segment(&g, at, sample.wi, TY_FLOAT_MAX, &segment);
    double density = 0;
    for (int32_t i = 0; i < s->anchor_count; ++i) {
        const ty_vec to = ty_sub(s->anchors[i], at);
        const float d2 = ty_dot(to, to), d = sqrtf(d2);
        if (!(d > 0) || (i != anchor && mesh != NULL && ty_accel_occluded(mesh, at, ty_scale(to, 1 / d), d))) continue;
        density += (double)(s->reach / (d2 * (s->reach + d) * (s->reach + d))) * s->lit_each * (double)TY_INV_4PI;
    }
    if (!(density > 0)) return false;
    for (int c = 0; c < 3; ++c) out->sends[c] *= segment.transmittance[c];
    out->amount = (float)(1 / density);
    /* The mean of 1 / d^2 over a ball about its middle is 3 / radius^2. */
    const double radius = cbrt(0.75 / (double)TY_PI * (double)out->amount);
    out->area = (float)(4 * (double)TY_PI * radius * radius / 3);
    return true;
}

static void find_lits(void* user, int64_t ray, int32_t worker) {
    const search* s = user;
    (void)worker;
    ty_sender* out = &s->senders->at[s->senders->count + ray];
    if (!find_lit(s, (int32_t)ray, out)) out->amount = 0;
}

static void place_lit(search* s) {
    ty_senders* senders = s->senders;
    const int32_t rays = s->anchor_count * s->lit_each;
    if (s->run->request.path.scene->lights.distant_count == 0) return;
    ty_parallel_flushed(s->run->context, rays, find_lits, s);
    const int32_t first = senders->count;
    for (int32_t i = 0; i < rays; ++i)
        if (senders->at[first + i].amount > 0) senders->at[senders->count++] = senders->at[first + i];
}

static void place_senders(search* s) {
    ty_senders* senders = s->senders;
    const int64_t rays = (int64_t)s->anchor_count * s->each;
    if (s->run->request.path.scene->mesh != NULL) ty_parallel_flushed(s->run->context, rays, find_senders, s);
    for (int64_t i = 0; i < rays; ++i)
        if (senders->at[i].area > 0) senders->at[senders->count++] = senders->at[i];
    senders->surfaces = senders->count;
    place_lamps(s);
    senders->lamps = senders->count - senders->surfaces;
    place_lit(s);
    for (int32_t i = 0; i < senders->count; ++i) {
        const ty_sender* at = &senders->at[i];
        ty_bake_receiver* receiver = &s->receivers[i];
        *receiver = (ty_bake_receiver){.position = {at->position.x, at->position.y, at->position.z},
                                       .normal = {at->normal.x, at->normal.y, at->normal.z},
                                       .face = {at->face.x, at->face.y, at->face.z},
                                       .margin = at->margin};
        senders->x[i] = at->position.x;
        senders->y[i] = at->position.y;
        senders->z[i] = at->position.z;
        senders->nx[i] = at->normal.x;
        senders->ny[i] = at->normal.y;
        senders->nz[i] = at->normal.z;
        senders->area[i] = at->area;
    }
}

/* A lattice about all surfaces. */
static void place_cells(ty_senders* senders) {
    for (int a = 0; a < 3; ++a) {
        const float* at = a == 0 ? senders->x : a == 1 ? senders->y : senders->z;
        float lower = 0, upper = 0;
        for (int32_t i = 0; i < senders->surfaces; ++i) {
            lower = i == 0 ? at[i] : fminf(lower, at[i]);
            upper = i == 0 ? at[i] : fmaxf(upper, at[i]);
        }
        senders->lower[a] = lower;
        senders->per_metre[a] = upper > lower ? (float)senders->side / (upper - lower) : 0;
    }
}

/* ---- light ---- */

static void gather_block(void* user, int64_t block, int32_t worker) {
    const search* s = user;
    (void)worker;
    const int64_t begin = block * BLOCK, left = s->senders->surfaces - begin;
    s->run->kernel(&s->request, begin, begin + (left < BLOCK ? left : BLOCK), 0, s->samples, s->sums, s->light);
}

static void gather(search* s, uint32_t samples) {
    const size_t count = (size_t)s->senders->surfaces;
    memset(s->sums, 0, count * sizeof *s->sums);
    memset(s->light, 0, count * LIGHT_SIZE * sizeof *s->light);
    s->samples = samples;
    ty_parallel_flushed(s->run->context, (s->senders->surfaces + BLOCK - 1) / BLOCK, gather_block, s);
}

/* Irradiance of all layers that was gathered. */
static double gathered(const search* s, int32_t sender, int channel) {
    double sum = 0;
    for (int32_t layer = 0; layer < TY_BAKE_LAYERS; ++layer)
        sum += s->light[(size_t)sender * LIGHT_SIZE + (size_t)((layer * 3 + channel) * TY_BAKE_SURFACE_TERMS)];
    return sum / s->samples;
}

static void set_light(search* s, const float* clear, const float* fog) {
    for (int32_t i = 0; i < s->senders->count; ++i) {
        ty_sender* at = &s->senders->at[i];
        float power = 0;
        if (at->lit != 0) {
            s->senders->power[i] = 2 * s->free * at->amount * ty_sum3(at->sends);
            continue;
        }
        for (int c = 0; c < 3; ++c) {
            at->sends[c] = at->albedo[c] * (1.0f / TY_PI) * fmaxf(0, clear[3 * i + c] + fog[3 * i + c]);
            power += at->amount * (at->sends[c] + at->glows[c]);
        }
        s->senders->power[i] = power;
    }
}

/* What the lattice and senders are made of. */
typedef struct cells_job {
    const ty_senders* senders;
    const float* fog;
} cells_job;

static void fill_cell(void* user, int64_t index, int32_t worker) {
    const cells_job* job = user;
    const ty_senders* senders = job->senders;
    (void)worker;
    const int32_t side = senders->side,
                  at[3] = {(int32_t)index % side, (int32_t)index / side % side, (int32_t)index / side / side};
    float middle[3], within = 0;
    double sums[TY_FOG_SIDES][4] = {{0}};
    for (int a = 0; a < 3; ++a) {
        const float size = senders->per_metre[a] > 0 ? 1 / senders->per_metre[a] : 0;
        middle[a] = senders->lower[a] + ((float)at[a] + 0.5f) * size;
        within += 0.25f * size * size;
    }
    for (int32_t i = 0; i < senders->surfaces; ++i) {
        const float x = senders->x[i] - middle[0], y = senders->y[i] - middle[1], z = senders->z[i] - middle[2];
        const float d2 = x * x + y * y + z * z + within + 1e-12f;
        const float normal[3] = {senders->nx[i], senders->ny[i], senders->nz[i]};
        for (int k = 0; k < TY_FOG_SIDES; ++k) {
            const float cosine = k % 2 == 0 ? -normal[k / 2] : normal[k / 2];
            const float facing = fmaxf(0.01f, cosine);
            const double weight = (double)(facing * facing) / ((double)d2 * (double)d2);
            for (int c = 0; c < 3; ++c) sums[k][c] += weight * (double)job->fog[3 * i + c];
            sums[k][3] += weight;
        }
    }
    for (int k = 0; k < TY_FOG_SIDES; ++k)
        for (int c = 0; c < 3; ++c)
            senders->cells[index].irradiance[k][c] = sums[k][3] > 0 ? (float)fmax(0, sums[k][c] / sums[k][3]) : 0;
}

static void light_senders(search* s, uint32_t samples, float* clear, float* fog) {
    ty_senders* senders = s->senders;
    cells_job job = {senders, fog};
    s->request.method = TY_BAKE_ATTENUATION;
    gather(s, samples);
    for (int32_t i = 0; i < senders->surfaces; ++i)
        for (int c = 0; c < 3; ++c) clear[3 * i + c] = (float)gathered(s, i, c);
    set_light(s, clear, fog);
    s->request.method = TY_BAKE_IMPULSE;
    s->request.fog_alone = s->request.fog_every = 1;
    for (int round = 0; round < ROUNDS; ++round) {
        gather(s, samples / 4 > FOG_SAMPLES_MIN ? samples / 4 : FOG_SAMPLES_MIN);
        for (int32_t i = 0; i < senders->surfaces; ++i)
            for (int c = 0; c < 3; ++c) fog[3 * i + c] = (float)gathered(s, i, c);
        set_light(s, clear, fog);
        ty_parallel_flushed(s->run->context, (int64_t)senders->side * senders->side * senders->side, fill_cell, &job);
    }
}

/* ---- memory ---- */

/* Arrays of senders: what choosing goes by. */
enum { NUMBERS = 8 };

static size_t cells_of(const ty_senders* senders) {
    return (size_t)(senders->side * senders->side * senders->side);
}

static ty_result take_senders(ty_bake_run* run, int32_t most) {
    ty_senders* senders = &run->senders;
    run->sender_size = (size_t)most;
    senders->side = (int32_t)fmin(TY_FOG_SIDE_MAX, ceil(cbrt(most)));
    senders->at = ty_alloc_array(run->context, run->sender_size, sizeof *senders->at, true);
    senders->x = ty_alloc_array(run->context, run->sender_size * NUMBERS, sizeof *senders->x, true);
    senders->cells = ty_alloc_array(run->context, cells_of(senders), sizeof *senders->cells, true);
    if (senders->at == NULL || senders->x == NULL || senders->cells == NULL) return TY_ERROR_MEMORY;
    float** numbers[NUMBERS] = {&senders->x,  &senders->y,  &senders->z,     &senders->nx,
                                &senders->ny, &senders->nz, &senders->power, &senders->area};
    for (int i = 1; i < NUMBERS; ++i) *numbers[i] = senders->x + (size_t)i * run->sender_size;
    return TY_OK;
}

void ty_bake_senders_free(ty_bake_run* run) {
    ty_senders* senders = &run->senders;
    ty_free_array(run->context, senders->at, run->sender_size, sizeof *senders->at);
    ty_free_array(run->context, senders->x, run->sender_size * NUMBERS, sizeof *senders->x);
    ty_free_array(run->context, senders->cells, cells_of(senders), sizeof *senders->cells);
    *senders = (ty_senders){.count = 0};
    ty_free_array(run->context, run->merged, run->merged_size, sizeof *run->merged);
}

/* Paths of senders are a small part of all, and as many per sender as there are senders. */
ty_result ty_bake_senders_make(ty_bake_run* run) {
    ty_context* context = run->context;
    const double paths = (double)run->count * run->def->spp;
    run->request.senders = &run->senders;
    run->request.fog_every = FOG_EVERY;
    search s = {.run = run, .senders = &run->senders};
    s.anchor_count = run->count < ANCHORS_MAX ? (int32_t)run->count : ANCHORS_MAX;
    const double wanted = fmin(TY_SENDERS_MAX - LAMP_POINTS_MAX - LIT_RAYS, fmax(SENDERS_MIN, sqrt(paths / 8)));
    s.each = s.anchor_count > 0 ? (int32_t)(wanted / s.anchor_count) : 0;
    s.lamp_points = (int32_t)fmin(LAMP_POINTS_MAX, 0.5 * wanted);
    s.lit_each = s.anchor_count > 0 ? LIT_RAYS / s.anchor_count : 0;
    s.most = s.anchor_count * s.each + s.lamp_points + s.anchor_count * s.lit_each;
    const size_t most = (size_t)s.most;
    ty_result result = take_senders(run, s.most);
    s.receivers = ty_alloc_array(context, most, sizeof *s.receivers, true);
    s.sums = ty_alloc_array(context, most, sizeof *s.sums, true);
    s.light = ty_alloc_array(context, most * LIGHT_SIZE, sizeof *s.light, true);
    float* light = ty_alloc_array(context, 6 * most, sizeof *light, true);
    if (s.receivers == NULL || s.sums == NULL || s.light == NULL || light == NULL) result = TY_ERROR_MEMORY;
    if (result == TY_OK) {
        place_anchors(&s);
        find_most(&s);
        result = merge_tables(run);
    }
    if (result == TY_OK) {
        place_senders(&s);
        place_cells(&run->senders);
        s.request = run->request;
        s.request.path.seed = ~run->def->seed;
        s.request.receivers = s.receivers;
        s.request.terms = TY_BAKE_SURFACE_TERMS;
        const double samples = paths / (64 * (double)most);
        light_senders(&s, (uint32_t)fmin(CLEAR_SAMPLES_MAX, fmax(CLEAR_SAMPLES_MIN, samples)), light, light + 3 * most);
    }
    ty_free_array(context, light, 6 * most, sizeof *light);
    ty_free_array(context, s.light, most * LIGHT_SIZE, sizeof *s.light);
    ty_free_array(context, s.sums, most, sizeof *s.sums);
    ty_free_array(context, s.receivers, most, sizeof *s.receivers);
    return result;
}
