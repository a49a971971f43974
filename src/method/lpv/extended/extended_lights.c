/* Next-event estimation of lights with extent. */
#include "method/lpv/extended/extended_lights.h"

#include "base/context.h"
#include "base/random.k.h"
#include "base/sh.k.h"
#include "direct/media/attenuation.k.h"
#include "direct/media/transmittance.k.h"
#include "direct/shadow/grid_depth.h"

/* ---- lights ---- */

static bool is_positioned(const ty_light_view* light) {
    return light->kind == TY_KIND_AREA || light->kind == TY_KIND_SPHERE || light->kind == TY_KIND_TRIANGLE;
}

static ty_result find_lights(const ty_light_set* set, ty_extended_lights* lights, bool* any) {
    const size_t count = (size_t)set->count;
    ty_light_bounds* bounds = ty_alloc_array(lights->context, count, sizeof *bounds, true);
    lights->environments = ty_alloc_array(lights->context, (size_t)set->distant_count, sizeof(int32_t), false);
    lights->environment_capacity = (size_t)set->distant_count;
    ty_result result = bounds != NULL && lights->environments != NULL ? TY_OK : TY_ERROR_MEMORY;
    for (int32_t i = 0; i < set->count && result == TY_OK; ++i) {
        if (is_positioned(&set->lights[i])) *any |= ty_light_get_bounds(&set->lights[i], &bounds[i]);
        if (set->lights[i].kind == TY_KIND_ENVIRONMENT) lights->environments[lights->environment_count++] = i;
    }
    if (result == TY_OK) result = ty_light_tree_create(lights->context, bounds, count, &lights->tree);
    ty_free_array(lights->context, bounds, count, sizeof *bounds);
    *any |= lights->environment_count > 0;
    return result;
}

ty_result ty_extended_lights_create(const ty_scene* scene, ty_extended_lights** out) {
    const ty_light_set* set = &scene->view.lights;
    bool any = false;
    *out = NULL;
    if (set->count == 0) return TY_OK;
    ty_extended_lights* lights = ty_alloc_array(scene->context, 1, sizeof *lights, true);
    if (lights == NULL) return TY_ERROR_MEMORY;
    lights->context = scene->context;
    const ty_result result = find_lights(set, lights, &any);
    if (result != TY_OK || !any) {
        ty_extended_lights_destroy(lights);
        return result;
    }
    *out = lights;
    return TY_OK;
}

void ty_extended_lights_destroy(ty_extended_lights* lights) {
    if (lights == NULL) return;
    ty_light_tree_destroy(lights->context, lights->tree);
    ty_free_array(lights->context, lights->environments, lights->environment_capacity, sizeof(int32_t));
    ty_free_array(lights->context, lights, 1, sizeof *lights);
}

/* ---- points ---- */

static size_t point_count(const ty_light_points* points) {
    return (size_t)TY_LIGHT_PATTERN * (size_t)points->count;
}

/* Consecutive points of a scrambled Sobol sequence are stratified among themselves, and so are those of all places. */
ty_result ty_light_points_create(ty_context* context, int32_t count, uint64_t seed, int32_t sample,
                                 ty_light_points* out) {
    ty_sobol sobol;
    *out = (ty_light_points){.context = context, .count = count};
    out->at = ty_alloc_array(context, point_count(out), sizeof *out->at, false);
    if (out->at == NULL) return TY_ERROR_MEMORY;
    ty_sobol_matrices(&sobol);
    for (size_t i = 0; i < point_count(out); ++i) {
        const uint32_t number = (uint32_t)((size_t)sample * point_count(out) + i);
        ty_sampler random = ty_sampler_begin(&sobol, seed, 0, number);
        for (int t = 0; t < TY_LIGHT_POINT_TERMS; ++t) out->at[i][t] = ty_sobol_next(&random);
    }
    return TY_OK;
}

void ty_light_points_destroy(ty_light_points* points) {
    ty_free_array(points->context, points->at, point_count(points), sizeof *points->at);
    points->at = NULL;
}

ty_extended_view ty_extended_view_of(const ty_scene* scene, const ty_extended_lights* lights,
                                     const ty_light_points* points, const ty_grid_medium* medium,
                                     const ty_reduced_media* reduced) {
    ty_extended_view view = {
        .scene = &scene->view, .lights = lights, .points = points, .media = scene->view.media, .medium = medium};
    if (reduced->medium != NULL && medium != NULL && reduced->view_count == scene->view.medium_count) {
        view.media = reduced->views;
        view.medium = reduced->medium;
    }
    for (int32_t m = 0; m < scene->view.medium_count; ++m) view.on_cells |= scene->view.media[m].heterogeneous != 0;
    return view;
}

/* ---- irradiance ---- */

/* Samples of one receiver, whose shadow rays are traced when the packet is full. */
typedef struct sample_packet {
    const ty_extended_view* view;
    int32_t count, traced;
    ty_ray rays[TY_PACKET];
    bool beams[TY_PACKET];      /* whether the light goes to a cell's beam */
    float light[TY_PACKET][3];  /* contribution if the ray is unoccluded and media do not attenuate it */
    float* sum;                 /* irradiance */
    const ty_light_cell* cell;  /* NULL: a surface receives the light */
    ty_cell_radiance* radiance; /* in place of sum */
} sample_packet;

/* Multiplies light by the transmittance of the media on a ray from `begin` on. */
static void attenuate(const ty_extended_view* view, const ty_ray* ray, float begin, float light[3]) {
    const ty_vec wi = ty_vec_load(ray->direction), from = ty_mad(ty_vec_load(ray->origin), wi, begin);
    const float far = ty_minf(ray->far, TY_FLOAT_MAX) - begin;
    float passing[3];
    if (view->medium == NULL || !(far > 0.0f)) return;
    if (view->on_cells) {
        ty_grid_depth(view->medium, NULL, from, wi, far, passing);
        for (int c = 0; c < 3; ++c) passing[c] = ty_attenuation(passing[c]);
    } else {
        ty_transmittance(view->media, view->scene->medium_count, from, wi, far, NULL, passing);
    }
    for (int c = 0; c < 3; ++c) light[c] *= passing[c];
}

/* Optical depth of the lit layer of a dense cell that an eye on the light's side sees. */
static const float visible_depth = 1.0f;

/* Adds light that travels along a ray's opposite direction. Its mean over the chord of optical depth x through the
 * center is the fraction (1 - e^-x) / x of the light that enters. */
static void add_to_cell(sample_packet* packet, int32_t ray) {
    const ty_light_cell* cell = packet->cell;
    const ty_vec wi = ty_vec_load(packet->rays[ray].direction);
    const float half = 0.5f * cell->side / ty_maxf(fabsf(wi.x), ty_maxf(fabsf(wi.y), fabsf(wi.z)));
    const float before = ty_minf(half, packet->rays[ray].far);
    const float kept = ty_beam_cosine(cell->side, packet->rays[ray].far * packet->rays[ray].far);
    float y[TY_SH_TERMS_MAX], *light = packet->light[ray];
    ty_sh_all(ty_scale(wi, -1.0f), y);
    attenuate(packet->view, &packet->rays[ray], before, light);
    for (int c = 0; c < 3; ++c) {
        const float depth = packet->view->medium != NULL ? cell->extinction[c] * (before + half) : 0.0f;
        const float shallow = ty_minf(depth, visible_depth);
        const float mean = light[c] * ty_mean_attenuation(depth, ty_attenuation(depth));
        const float visible = light[c] * ty_mean_attenuation(shallow, ty_attenuation(shallow));
        for (int t = 0; t < TY_SH_TERMS_MAX; ++t) packet->radiance->mean[c][t] += mean * y[t];
        for (int t = 0; t < TY_SH_TERMS_MAX && !packet->beams[ray]; ++t)
            packet->radiance->visible[c][t] += visible * y[t];
        const float beam[TY_BEAM_TERMS] = {visible, -visible * kept * wi.x, -visible * kept * wi.y,
                                           -visible * kept * wi.z};
        for (int t = 0; t < TY_BEAM_TERMS && packet->beams[ray]; ++t) packet->radiance->beam[c][t] += beam[t];
    }
}

static void trace(sample_packet* packet) {
    bool occluded[TY_PACKET] = {false};
    if (packet->count == 0) return;
    if (packet->view->scene->mesh != NULL) {
        ty_accel_occluded_packet(packet->view->scene->mesh, packet->rays, packet->count, occluded);
        packet->traced += packet->count;
    }
    for (int32_t i = 0; i < packet->count; ++i) {
        if (occluded[i]) continue;
        if (packet->cell != NULL) {
            add_to_cell(packet, i);
            continue;
        }
        attenuate(packet->view, &packet->rays[i], 0.0f, packet->light[i]);
        for (int c = 0; c < 3; ++c) packet->sum[c] += packet->light[i][c];
    }
    packet->count = 0;
}

/* Adds the sample of a light with weight 1 / (number of samples * probability of the light): the next-event estimate of
 * the irradiance is the mean of L cos / pdf, those of the terms of radiance in a medium the means of L Y / pdf. */
static void add_sample(sample_packet* packet, int32_t light, const ty_light_receiver* receiver, float u, float v,
                       float weight) {
    ty_light_sample sample;
    if (!ty_light_sample_from(&packet->view->scene->lights.lights[light], receiver->point, u, v, &sample)) return;
    const float cosine = packet->cell != NULL ? 1.0f : ty_dot(sample.wi, receiver->normal);
    if (!(cosine > 0.0f) || !(packet->cell != NULL || ty_dot(sample.wi, receiver->facing) > 0.0f)) return;
    float* out = packet->light[packet->count];
    for (int c = 0; c < 3; ++c) out[c] = sample.radiance[c] * cosine * weight;
    if (!(out[0] + out[1] + out[2] > 0.0f && out[0] + out[1] + out[2] < TY_FLOAT_MAX)) return;
    const ty_vec from = receiver->point, wi = sample.wi;
    const float far = sample.distance < TY_FLOAT_MAX ? sample.distance * 0.9999f : INFINITY;
    packet->rays[packet->count] = (ty_ray){{from.x, from.y, from.z}, {wi.x, wi.y, wi.z}, far};
    packet->beams[packet->count] =
        packet->cell != NULL && packet->cell->narrow && is_positioned(&packet->view->scene->lights.lights[light]);
    if (++packet->count == TY_PACKET) trace(packet);
}

/* The points from `first` on. */
static void add_points(sample_packet* packet, const ty_light_receiver* receiver, int32_t first, int32_t count) {
    const ty_extended_lights* lights = packet->view->lights;
    const float weight = 1.0f / (float)count;
    for (int32_t i = first; i < first + count; ++i) {
        const float* at = packet->view->points->at[i];
        for (int32_t e = 0; e < lights->environment_count; ++e)
            add_sample(packet, lights->environments[e], receiver, at[0], at[1], weight);
        float u = at[2], probability;
        const int32_t light =
            ty_light_tree_sample(lights->tree->nodes, receiver->point, receiver->normal, NULL, &u, &probability);
        if (light >= 0) add_sample(packet, light, receiver, at[3], at[4], weight / probability);
    }
    trace(packet);
}

int32_t ty_extended_irradiance(const ty_extended_view* view, const ty_light_receiver* receiver, int32_t place,
                               float irradiance[3]) {
    sample_packet packet = {.view = view, .sum = irradiance};
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    add_points(&packet, receiver, place * view->points->count, view->points->count);
    return packet.traced;
}

int32_t ty_extended_radiance(const ty_extended_view* view, const ty_light_cell* cell, ty_cell_radiance* out) {
    const ty_light_receiver receiver = {.point = cell->center};
    sample_packet packet = {.view = view, .cell = cell, .radiance = out};
    memset(out, 0, sizeof *out);
    add_points(&packet, &receiver, 0, TY_LIGHT_PATTERN * view->points->count);
    return packet.traced;
}
