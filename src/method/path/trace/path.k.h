/* One light path from the camera towards the lights, with next-event estimation and multiple importance sampling.
 * docs/method/path.md gives the estimators. */
#ifndef TY_METHOD_PATH_TRACE_PATH_K_H
#define TY_METHOD_PATH_TRACE_PATH_K_H

#include "method/path/trace/equiangular.k.h"
#include "method/path/trace/guided_distance.k.h"
#include "method/path/trace/periodic.k.h"
#include "method/path/trace/point_light_direction.k.h"
#include "method/path/trace/refracted_light.k.h"
#include "method/path/trace/window.k.h"

/* The squared distance from a local light within which rays sample the light that it sends into them, m^2. */
TY_FN float ty_path_near2(const ty_path* path, const ty_light_view* light) {
    return light->reach2 * (ty_light_is_point_or_spot(light->kind) ? path->request->point_light_near : 1.0f);
}

/* The lobe by which lights are chosen for the last vertex; NULL: it is diffuse. */
TY_FN const ty_light_lobe* ty_path_lobe(const ty_path* path) {
    return TY_PATH_GLOSS != 0 && path->lobe.weight > 0.0f ? &path->lobe : NULL;
}

/* MIS weight (balance heuristic) of emission that a ray hits, against light sampling from the ray's origin. */
TY_FN float ty_path_mis_weight_emission(const ty_path* path, const ty_intersection* end) {
    const ty_light_set* lights = &path->request->scene->lights;
    const float distance = end->hit.distance + path->passed;
    const ty_vec vertex = path->passed > 0.0f ? ty_mad(path->origin, path->direction, -path->passed) : path->origin;
    float weight = 1.0f;
    if (end->point.light < 0) return weight;
    const ty_light_view* light = &lights->lights[end->point.light];
    const float density = ty_light_pdf(light, vertex, path->direction, distance);
    if (path->pdf > 0.0f) {
        const float chosen = ty_lights_probability(lights, end->point.light, vertex, path->normal, ty_path_lobe(path));
        weight = path->pdf / (path->pdf + chosen * density);
    }
    if (path->scattered != 0 && ty_light_is_local(light->kind))
        weight *= ty_mis_weight_collision(distance * distance, ty_path_near2(path, light), density, path->phase);
    return weight;
}

/* Adds emission at the ray's end. end: NULL if the ray leaves the scene, which adds the environments. */
TY_FN void ty_path_add_emission(ty_path* path, const float throughput[3], const ty_intersection* end) {
    const ty_light_set* lights = &path->request->scene->lights;
    const bool refracted = ty_path_sees_dielectrics(path) && path->vertex.refractions > 0;
    float radiance[3];
    if (end != NULL) {
        if (!(ty_max3(end->point.emission) > 0.0f) || (path->found != TY_FOUND_NONE && path->depth == 0)) return;
        float weight = ty_path_mis_weight_emission(path, end);
        if (refracted && end->point.light >= 0) {
            const ty_manifold_target target = {end->hit.position, false};
            weight = ty_manifold_mis_weight_emission(path, end->point.light, &target);
        }
        for (int c = 0; c < 3; ++c) radiance[c] = throughput[c] * end->point.emission[c] * weight;
        ty_path_add(path, radiance);
        return;
    }
    if (path->found == TY_FOUND_ALL && path->depth == 0) return;
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        const ty_light_view* light = &lights->lights[lights->distant[i]];
        if (light->kind != TY_KIND_ENVIRONMENT) continue;
        float weight = 1.0f;
        if (path->pdf > 0.0f && light->chosen > 0.0f)
            weight = path->pdf / (path->pdf + light->chosen * ty_environment_pdf(&light->environment, path->direction));
        if (refracted && light->chosen > 0.0f) {
            const ty_manifold_target target = {path->direction, true};
            weight = ty_manifold_mis_weight_emission(path, lights->distant[i], &target);
        }
        ty_environment_radiance(&light->environment, path->direction, radiance);
        for (int c = 0; c < 3; ++c) radiance[c] *= throughput[c] * weight;
        ty_path_add(path, radiance);
    }
}

/* Adds emission of the environments, by Russian roulette where hardly any of the throughput is transmitted. */
TY_FN void ty_path_add_faint_emission(ty_path* path, const float transmitted[3], float throughput) {
    const float chance = ty_sum3(transmitted) / (TY_PATH_FAINT_TRANSMITTANCE * throughput);
    if (chance >= 1.0f) {
        ty_path_add_emission(path, transmitted, NULL);
        return;
    }
    if (ty_rng_uniform(&path->random) >= chance) return;
    float raised[3];
    for (int c = 0; c < 3; ++c) raised[c] = transmitted[c] / chance;
    ty_path_add_emission(path, raised, NULL);
}

/* ---- vertices ---- */

/* Chooses a light for a vertex and samples a point on it, without visibility: the light's index, or -1 without one.
 * *chosen: the discrete probability of that light. *shines: the sample carries radiance. */
TY_FN int32_t ty_path_sample_light(ty_path* path, ty_vec from, float* chosen, ty_light_sample* sample, bool* shines) {
    const ty_light_set* lights = &path->request->scene->lights;
    *shines = false;
    *chosen = 0.0f;
    if (lights->count == 0) return -1;
    float pick = lights->count > 1 ? ty_sobol_next(&path->random) : 0.0f;
    const int32_t i = ty_lights_choose(lights, from, path->normal, ty_path_lobe(path), &pick, chosen);
    if (i < 0) return -1;
    const ty_light_view* light = &lights->lights[i];
    float u = 0.5f, v = 0.5f;
    if (light->kind >= TY_KIND_AREA) {
        u = ty_sobol_next(&path->random);
        v = ty_sobol_next(&path->random);
    }
    *shines = ty_light_sample_from(light, from, u, v, sample);
    return i;
}

/* The light of ty_path_sample_light; NULL: there is none, or its sample carries no radiance. */
TY_FN const ty_light_view* ty_path_choose_light(ty_path* path, ty_vec from, float* chosen, ty_light_sample* sample) {
    bool shines;
    const int32_t i = ty_path_sample_light(path, from, chosen, sample, &shines);
    return shines ? &path->request->scene->lights.lights[i] : NULL;
}

/* Visibility of a light sample from a point: true if no surface lies between them. */
TY_FN bool ty_path_light_visible(const ty_path* path, ty_vec from, const ty_light_sample* sample) {
    const ty_accel* mesh = path->request->scene->mesh;
    const float far = sample->distance < TY_FLOAT_MAX ? sample->distance * 0.9999f : TY_FLOAT_MAX;
    return mesh == NULL || !ty_accel_occluded(mesh, from, sample->wi, far);
}

/* Radiance of a light sample times factor (throughput, phase function or BRDF, cosine) times visibility and
 * transmittance. Contributions below ty_path_min_contribution are traced by Russian roulette. */
TY_FN void ty_path_add_light(ty_path* path, ty_vec origin, const ty_light_sample* sample, const float factor[3],
                             float radiance[3]) {
    const ty_scene_view* scene = path->request->scene;
    float transmittance[3];
    for (int c = 0; c < 3; ++c) radiance[c] = factor[c] * sample->radiance[c];
    const float most = ty_max3(radiance), threshold = ty_path_min_contribution(path);
    if (most < threshold) {
        const float chance = most / threshold;
        const bool traced = ty_rng_uniform(&path->random) < chance;
        for (int c = 0; c < 3; ++c) radiance[c] = traced ? radiance[c] / chance : 0.0f;
    }
    const bool sees_dielectrics = ty_path_sees_dielectrics(path);
    if (TY_PATH_PERIODIC == 0 && !sees_dielectrics && ty_sum3(radiance) > 0.0f &&
        !ty_path_light_visible(path, origin, sample))
        for (int c = 0; c < 3; ++c) radiance[c] = 0.0f;
    if (!(ty_sum3(radiance) > 0.0f)) return;
    if (TY_PATH_PERIODIC != 0)
        ty_periodic_transmittance(scene, origin, sample->wi, &path->random, transmittance);
    else if (sees_dielectrics)
        ty_path_light_through(path, origin, sample, transmittance);
    else
        ty_transmittance(scene->media, scene->medium_count, origin, sample->wi, sample->distance, &path->random,
                         transmittance);
    for (int c = 0; c < 3; ++c) radiance[c] *= transmittance[c];
}

/* Next-event estimation at a vertex. factor: phase function or BRDF times cosine, per channel. The MIS weight accounts
 * for directional sampling with solid-angle density pdf, and in media for equiangular sampling of the last ray. phase:
 * in media, the phase function (green) towards the sample, 1/sr. */
TY_FN void ty_path_add_vertex_light(ty_path* path, const ty_light_view* light, float chosen,
                                    const ty_light_sample* sample, const float factor[3], float pdf, float phase) {
    float weight = 1.0f / chosen, weighted[3], radiance[3];
    if (sample->pdf > 0.0f) weight = sample->pdf / (chosen * sample->pdf + pdf);
    if (path->scattered != 0 && ty_light_is_local(light->kind))
        weight *= ty_mis_weight_collision(sample->distance * sample->distance, ty_path_near2(path, light), sample->pdf,
                                          phase);
    for (int c = 0; c < 3; ++c) weighted[c] = path->beta[c] * factor[c] * weight;
    ty_path_add_light(path, path->origin, sample, weighted, radiance);
    ty_path_add(path, radiance);
}

/* Russian roulette for a ray that passes a point of a local light at a distance: the probability to go on with it. */
TY_FN float ty_path_pass_chance(const ty_closest_approach* closest, ty_media_interval interval, float near2) {
    const float beyond = closest->t - ty_clampf(closest->t, interval.enter, interval.leave);
    return ty_mis_near_weight(closest->distance2 + beyond * beyond, near2);
}

/* Adds the light that a point of a local light sends into a ray by one scattering: at one distance, sampled equiangular
 * (Kulla and Fajardo 2012) with `along` in [0, 1). u, v: coordinates of the light's point. weight: MIS weight over the
 * probability of the light and of the ray's roulette. */
TY_FN void ty_path_add_single_scattering(ty_path* path, const ty_spans* spans, ty_media_interval interval,
                                         const ty_light_view* light, float u, float v, float along,
                                         const ty_closest_approach* closest, const float throughput[3], float weight) {
    const bool point_light = ty_light_is_point_or_spot(light->kind);
    const float uniform = !(path->request->point_light_rate > 0.0f) ? 1.0f : light->kind == TY_KIND_SPOT ? 0.5f : 0.0f;
    float t;
    const float density =
        point_light ? ty_point_light_distance_sample(interval, closest, ty_spans_broadest_g(path->media, spans),
                                                     uniform, along, &t)
                    : ty_equiangular_sample(interval, closest->t, sqrtf(closest->distance2), along, &t);
    const ty_vec at = ty_mad(path->origin, path->direction, t);
    ty_light_sample sample;
    if (!ty_light_sample_from(light, at, u, v, &sample)) return;
    const float near = ty_mis_near_weight(sample.distance * sample.distance, ty_path_near2(path, light));
    float mu = ty_clampf(ty_dot(path->direction, sample.wi), -1.0f, 1.0f);
    weight *= near / density;
    if (point_light) {
        /* The rounding of `at` is of the size of the distance to the lamp on rays that nearly meet it; the density and
         * 1/d^2 cancel only if both are those of the ray. */
        const float before = closest->t - t, d2 = closest->distance2 + before * before;
        weight *= sample.distance * sample.distance / d2;
        mu = before / sqrtf(d2);
    }
    float factor[3] = {0.0f, 0.0f, 0.0f}, transmittance[3], radiance[3];
    for (int32_t i = 0; i < spans->count; ++i) {
        if (t < spans->enter[i] || t > spans->leave[i]) continue;
        const ty_medium_view* medium = &path->media[spans->medium[i]];
        float sigma_s[3], phase[3];
        ty_medium_sigma_s(medium, at, sigma_s);
        ty_medium_phase(medium, at, mu, phase);
        const float mis_weight = ty_mis_small_light_weight(sample.pdf, phase[1]);
        const float amount = mis_weight * weight * ty_medium_density(medium, at, &path->random);
        for (int c = 0; c < 3; ++c) factor[c] += throughput[c] * amount * sigma_s[c] * phase[c];
    }
    if (!(ty_sum3(factor) > 0.0f)) return;
    ty_path_add_light(path, at, &sample, factor, radiance);
    if (!(ty_sum3(radiance) > 0.0f)) return;
    ty_transmittance(path->media, path->medium_count, path->origin, path->direction, t, &path->random, transmittance);
    for (int c = 0; c < 3; ++c)
        path->radiance[ty_path_class_scattered(path->path_class)][c] += radiance[c] * transmittance[c];
}

/* Adds the light of a local light that is scattered into the path's current ray. */
TY_FN void ty_path_add_equiangular(ty_path* path, const ty_spans* spans) {
    const ty_light_set* lights = &path->request->scene->lights;
    const ty_media_interval interval = ty_spans_interval(spans);
    float pick = lights->local_count > 1 ? ty_rng_uniform(&path->random) : 0.0f, chosen = 1.0f;
    const int32_t point_light =
        ty_lights_choose_local(lights, path->origin, path->direction, interval.enter, interval.leave, &pick, &chosen);
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    const float along = ty_sobol_next(&path->random);
    if (point_light < 0) return;
    const ty_light_view* light = &lights->lights[point_light];
    float b1, b2;
    const bool flat = light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE;
    const ty_vec place = flat ? ty_light_point(light, u, v, &b1, &b2) : light->position;
    const ty_closest_approach closest = ty_closest_approach_find(path->origin, path->direction, place, light->reach2);
    const float chance = ty_path_pass_chance(&closest, interval, ty_path_near2(path, light));
    if (ty_rng_uniform(&path->random) >= chance) return;
    float weight = 1.0f / (chosen * chance);
    if (path->point_light_rate > 0.0f && ty_light_is_point_or_spot(light->kind)) {
        /* The balance heuristic against lamp directions. */
        const float probability =
            ty_lights_probability(lights, point_light, path->origin, path->normal, ty_path_lobe(path)) *
            ty_point_light_direction_rate(path->request, path->point_light_rate, &closest);
        const float both =
            path->pdf * chosen + probability * ty_point_light_direction_pdf(&closest, path->request->point_light_g);
        weight *= path->pdf * chosen / both;
    }
    ty_path_add_single_scattering(path, spans, interval, light, u, v, along, &closest, path->beta, weight);
}

/* ---- lamp directions ---- */

/* Light that a lamp sends to the vertex at path->origin by one scattering, along a direction sampled about the lamp. */
TY_FN void ty_path_add_point_light_direction(ty_path* path, const ty_light_view* point_light, float probability,
                                             const ty_vertex_response* response) {
    const ty_scene_view* scene = path->request->scene;
    const float u = ty_rng_uniform(&path->random), turn = ty_rng_uniform(&path->random);
    float throughput[3];
    ty_hit hit;
    ty_spans spans;
    path->direction =
        ty_point_light_direction_sample(path->origin, point_light->position, path->request->point_light_g, u, turn);
    const float pdf = ty_vertex_response_evaluate(response, path->direction, throughput);
    if (!(pdf > 0.0f)) return;
    const bool on_surface =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &hit);
    ty_spans_find(path->media, path->medium_count, path->origin, path->direction,
                  on_surface ? hit.distance : TY_FLOAT_MAX, &spans);
    if (spans.count == 0) return;
    const ty_media_interval interval = ty_spans_interval(&spans);
    const ty_closest_approach closest =
        ty_closest_approach_find(path->origin, path->direction, point_light->position, point_light->reach2);
    const float chance = ty_path_pass_chance(&closest, interval, ty_path_near2(path, point_light));
    if (ty_rng_uniform(&path->random) >= chance) return;
    const float chosen = ty_lights_local_probability(&scene->lights, (int32_t)(point_light - scene->lights.lights),
                                                     path->origin, path->direction, interval.enter, interval.leave);
    const float both =
        pdf * chosen + probability * ty_point_light_direction_pdf(&closest, path->request->point_light_g);
    const float weight = 1.0f / (chance * both);
    for (int c = 0; c < 3; ++c) throughput[c] *= path->beta[c];
    ty_path_add_single_scattering(path, &spans, interval, point_light, 0.5f, 0.5f, ty_rng_uniform(&path->random),
                                  &closest, throughput, weight);
}

/* Lamp directions of the vertex at path->origin, for the light that its next-event estimation chose with probability
 * `chosen`; returns path->point_light_rate of that vertex. The path's own random numbers stay as they are. */
TY_FN float ty_path_sample_point_light_direction(ty_path* path, int32_t light, float chosen,
                                                 const ty_vertex_response* response) {
    const ty_path_request* request = path->request;
    const ty_scene_view* scene = request->scene;
    const float rate = ty_path_is_last(path) ? 0.0f : request->point_light_rate;
    if (!(rate > 0.0f) || light < 0 || !ty_light_is_point_or_spot(scene->lights.lights[light].kind)) return rate;
    const ty_light_view* point_light = &scene->lights.lights[light];
    const ty_vec to = ty_sub(point_light->position, path->origin);
    const ty_closest_approach beside = {0.0f, 0.0f, ty_dot(to, to)};
    const float probability = ty_point_light_direction_rate(request, rate, &beside);
    const ty_sampler own = path->random;
    const ty_vec direction = path->direction;
    path->random = ty_sampler_branch(&own);
    if (ty_rng_uniform(&path->random) < probability)
        ty_path_add_point_light_direction(path, point_light, chosen * probability, response);
    path->random = own;
    path->direction = direction;
    return rate;
}

/* Probability that a vertex deep in a homogeneous medium samples lights, all of which are outside of it: 1, or in
 * proportion to the transmittance along the shortest way out where that is little. Paths through snow and milk have
 * most vertices where light hardly comes straight from outside. */
TY_FN float ty_path_light_chance(const ty_path* path, const ty_medium_view* medium) {
    if (path->request->deep == 0 || medium->heterogeneous != 0) return 1.0f;
    const float depth = ty_medium_depth(medium, ty_map_point(medium->to_bounds, path->origin));
    return ty_minf(1.0f, ty_exp_neg(ty_clampf(depth, 0.0f, 87.0f)) / TY_PATH_FAINT_TRANSMITTANCE);
}

/* A scattering vertex at path->origin: next-event estimation, then the next direction. */
TY_FN void ty_path_scatter(ty_path* path, const ty_medium_view* medium) {
    ty_scatter_vertex scatter;
    ty_light_sample sample;
    float phase[3], chosen = 0.0f;
    path->normal = ty_vec_make(0, 0, 0);
    path->lobe.weight = 0.0f;
    ty_scatter_vertex_begin(&scatter, path, medium);
    bool shines = false;
    const float light_chance = ty_path_light_chance(path, medium);
    int32_t light = -1;
    if (light_chance >= 1.0f || ty_rng_uniform(&path->random) < light_chance)
        light = ty_path_sample_light(path, path->origin, &chosen, &sample, &shines);
    if (shines) {
        ty_scatter_vertex_phase(&scatter, sample.wi, phase);
        const float pdf = sample.pdf > 0.0f ? ty_scatter_vertex_pdf(&scatter, sample.wi, phase) : 0.0f;
        float factor[3];
        for (int c = 0; c < 3; ++c) factor[c] = phase[c] / light_chance;
        ty_path_add_vertex_light(path, &path->request->scene->lights.lights[light], chosen, &sample, factor, pdf,
                                 phase[1]);
    }
    const ty_vertex_response response = {&scatter, NULL, NULL};
    ty_path_sample_refracted_light(path, light, chosen, shines ? &sample : NULL, &response);
    path->point_light_rate = ty_path_sample_point_light_direction(path, light, chosen, &response);
    path->direction = ty_scatter_vertex_sample(&scatter, &path->random);
    ty_scatter_vertex_phase(&scatter, path->direction, phase);
    path->phase = phase[1];
    path->pdf = ty_scatter_vertex_pdf(&scatter, path->direction, phase);
    for (int c = 0; c < 3; ++c) path->beta[c] *= phase[c] / path->pdf;
    if (TY_PATH_GUIDED != 0) path->incident = ty_guide_vertex_radiance(&scatter.guide, path->direction);
}

/* Samples a cosine-weighted direction about the vertex normal. */
TY_FN void ty_path_sample_cosine_hemisphere(ty_path* path) {
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    const float cosine = ty_maxf(sqrtf(1.0f - u), 1e-4f);
    path->direction = ty_direction_about(path->normal, cosine, v);
    path->pdf = cosine * (1.0f / TY_PI);
    path->point_light_rate = 0.0f;
}

/* The same by a guide, too. Returns the weight of the direction beside the albedo. */
TY_FN float ty_path_sample_guided_hemisphere(ty_path* path, const ty_guide_vertex* guide) {
    float u = ty_sobol_next(&path->random);
    const float v = ty_sobol_next(&path->random);
    path->point_light_rate = 0.0f;
    path->direction = ty_guide_vertex_takes(guide, &u)
                          ? ty_guide_vertex_sample(guide, u, v)
                          : ty_direction_about(path->normal, ty_maxf(sqrtf(1.0f - u), 1e-4f), v);
    const float cosine = ty_maxf(ty_dot(path->normal, path->direction) * (1.0f / TY_PI), 0.0f);
    path->pdf = ty_guide_vertex_pdf(guide, path->direction, cosine);
    return path->pdf > 0.0f ? cosine / path->pdf : 0.0f;
}

/* Samples a direction uniformly on the sphere. */
TY_FN void ty_path_sample_sphere(ty_path* path) {
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    path->direction = ty_direction_about(ty_vec_make(0, 0, 1), 1.0f - 2.0f * u, v);
    path->pdf = TY_INV_4PI;
    path->point_light_rate = 0.0f;
}

/* A vertex on a Lambertian surface: next-event estimation, then the next direction. Cosines use the shading normal;
 * directions behind the geometric normal carry no light. */
TY_FN void ty_path_reflect(ty_path* path, const ty_intersection* at) {
    const ty_surface_point* point = &at->point;
    ty_light_sample sample;
    float factor[3], chosen;
    path->origin = ty_hit_leave(&at->hit, point->ng);
    path->normal = point->ns;
    path->lobe.weight = 0.0f;
    path->passed = 0.0f;
    bool shines;
    const int32_t light = ty_path_sample_light(path, path->origin, &chosen, &sample, &shines);
    ty_guide_vertex guide;
    if (TY_PATH_GUIDED != 0)
        ty_guide_vertex_reflect(&guide, path->request->guide, path->origin, point->ns, path->depth, &path->random);
    const ty_vertex_response response = {NULL, point, TY_PATH_GUIDED != 0 ? &guide : NULL};
    const float facing = shines ? ty_vertex_response_evaluate(&response, sample.wi, factor) : 0.0f;
    if (facing > 0.0f)
        ty_path_add_vertex_light(path, &path->request->scene->lights.lights[light], chosen, &sample, factor, facing,
                                 0.0f);
    ty_path_sample_refracted_light(path, light, chosen, shines ? &sample : NULL, &response);
    const float point_light_rate = ty_path_sample_point_light_direction(path, light, chosen, &response);
    const float weight = TY_PATH_GUIDED != 0 ? ty_path_sample_guided_hemisphere(path, &guide) : 1.0f;
    if (TY_PATH_GUIDED == 0) ty_path_sample_cosine_hemisphere(path);
    path->point_light_rate = point_light_rate;
    const bool outside = ty_dot(point->ng, path->direction) > 0.0f;
    for (int c = 0; c < 3; ++c) path->beta[c] *= outside ? weight * point->albedo[c] : 0.0f;
    path->rr_throughput *= ty_max3(point->albedo);
    if (TY_PATH_GUIDED != 0) path->incident = ty_guide_vertex_radiance(&guide, path->direction);
}

/* The lobe of a glossy surface for the choice of lights: of its microfacets or its coat, whichever reflects more. Thin
 * walls have none, because light passes them, too. */
TY_FN void ty_path_set_lobe(ty_path* path, const ty_bsdf* b) {
    const float coat = b->probability[TY_LOBE_COAT], base = b->probability[TY_LOBE_SPECULAR];
    const bool coated = coat > base;
    const ty_vec wo = coated ? b->coat_wo : b->wo;
    const float alpha = coated ? ty_ggx_alpha(b->coat_roughness) : b->alpha;
    path->lobe.weight = ty_bsdf_transmits(b) ? 0.0f : coat + base;
    path->lobe.alpha2 = alpha * alpha;
    path->lobe.axis = ty_frame_world(coated ? &b->coat_frame : &b->frame, ty_vec_make(-wo.x, -wo.y, wo.z));
}

/* A vertex on a glossy surface, as ty_path_reflect. Directions through thin walls start on the other side; their
 * vertices sample no lamp directions. */
TY_FN void ty_path_reflect_gloss(ty_path* path, const ty_intersection* at) {
    const ty_surface_point* point = &at->point;
    const bool transmits = ty_bsdf_transmits(&point->bsdf);
    const ty_vec origin = ty_hit_leave(&at->hit, point->ng);
    ty_light_sample sample;
    float factor[3], chosen;
    path->origin = origin;
    path->passed = 0.0f;
    path->normal = transmits ? ty_vec_make(0, 0, 0) : point->bsdf.frame.n;
    ty_path_set_lobe(path, &point->bsdf);
    bool shines;
    const int32_t light = ty_path_sample_light(path, origin, &chosen, &sample, &shines);
    const float density = shines ? ty_surface_evaluate_bsdf(point, sample.wi, factor) : 0.0f;
    if (density > 0.0f) {
        path->origin = ty_hit_leave(&at->hit, sample.wi);
        ty_path_add_vertex_light(path, &path->request->scene->lights.lights[light], chosen, &sample, factor, density,
                                 0.0f);
        path->origin = origin;
    }
    const ty_vertex_response response = {NULL, point, NULL};
    ty_path_sample_refracted_light(path, light, chosen, shines ? &sample : NULL, &response);
    path->point_light_rate = transmits ? 0.0f : ty_path_sample_point_light_direction(path, light, chosen, &response);
    const float pick = ty_sobol_next(&path->random);
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    path->pdf = ty_surface_sample_bsdf(point, pick, u, v, &path->direction, factor);
    path->origin = ty_hit_leave(&at->hit, path->direction);
    for (int c = 0; c < 3; ++c) path->beta[c] *= path->pdf > 0.0f ? factor[c] / path->pdf : 0.0f;
    path->rr_throughput *= ty_max3(point->albedo);
}

/* Russian roulette on rr_throughput, unbiased. beta_before: sum of beta before the last interaction. */
TY_FN bool ty_path_survives(ty_path* path, float beta_before) {
    const float now = ty_sum3(path->beta);
    if (!(now > 0.0f)) return false;
    path->rr_throughput *= ty_minf(1.0f, now / beta_before);
    /* Guiding weights can lower beta and later vertices can restore it, by at most the ratio of the phase functions. */
    path->rr_throughput = ty_minf(path->rr_throughput, 1e6f * now);
    /* A closed scene without absorption would otherwise never end a path. The probability to reach depth n falls as
     * 1 / n^2, whose sum over n is finite: walks through dense media that hardly absorb are long, and their weights
     * should stay small. */
    if (path->depth >= TY_PATH_ROULETTE_DEPTH) path->rr_throughput *= 1.0f - 2.0f / (float)path->depth;
    const bool in_window = ty_path_has_window(path) && path->depth < TY_PATH_ROULETTE_DEPTH;
    if (path->rr_throughput >= 0.2f || in_window) return true;
    const float chance = ty_maxf(path->rr_throughput * 2.5f, 0.02f);
    if (ty_rng_uniform(&path->random) >= chance) return false;
    for (int c = 0; c < 3; ++c) path->beta[c] /= chance;
    path->rr_throughput /= chance;
    return true;
}

/* The next event where media only attenuate: throughput times transmittance to the ray's end (NULL: the ray leaves the
 * scene). True at a reflecting surface. Averaging several transmittance estimates costs as much time as it saves. */
TY_FN bool ty_path_pass_unscattered(ty_path* path, const ty_intersection* end, float beta_before) {
    const float far = end != NULL ? end->hit.distance : TY_FLOAT_MAX;
    float transmittance[3];
    ty_transmittance(path->media, path->medium_count, path->origin, path->direction, far, &path->random, transmittance);
    for (int c = 0; c < 3; ++c) path->beta[c] *= transmittance[c];
    ty_path_add_emission(path, path->beta, end);
    return end != NULL && ty_max3(end->point.albedo) > 0.0f && ty_path_survives(path, beta_before);
}

/* A glossy surface as the path needs it: the albedo is that of all directions, and without energy compensation where
 * the request is. */
TY_FN void ty_path_meet_gloss(const ty_path* path, ty_surface_point* point) {
    for (int c = 0; c < 3; ++c) point->albedo[c] = point->bsdf.total[c];
    if (path->request->single_reflection != 0) ty_surface_drop_compensation(point);
}

/* The next event of a path at or before the next surface, as ty_path_next_event. */
TY_FN bool ty_path_next_event_before_surface(ty_path* path, const ty_medium_view** medium, ty_intersection* end) {
    const ty_scene_view* scene = path->request->scene;
    const ty_medium_view* media = path->media;
    const float beta_before = ty_sum3(path->beta);
    if (!(beta_before > 1e-30f)) return false;
    const bool last = ty_path_is_last(path);
    const bool on_surface =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    if (on_surface) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    if (TY_PATH_GLOSS != 0 && on_surface && end->point.glossy != 0) ty_path_meet_gloss(path, &end->point);
    if (ty_path_sees_dielectrics(path) && on_surface) ty_path_meet_interface(path, end);
    *medium = NULL;
    if (path->request->unscattered != 0) return ty_path_pass_unscattered(path, on_surface ? end : NULL, beta_before);
    ty_spans spans;
    ty_collision collision;
    const bool scatters = !ty_path_only_absorbs(path);
    float emitted[3] = {0.0f, 0.0f, 0.0f};
    ty_spans_find(media, path->medium_count, path->origin, path->direction,
                  on_surface ? end->hit.distance : TY_FLOAT_MAX, &spans);
    if (spans.count > 0 && scatters && scene->lights.local_count > 0 && !last) ty_path_add_equiangular(path, &spans);
    if (TY_PATH_GUIDED != 0 && path->depth == 0 && (spans.heterogeneous != 0 || spans.count != 1))
        ty_path_expect(path, on_surface ? end : NULL);
    if (spans.heterogeneous != 0) {
        const bool collides = ty_delta_tracking(media, &spans, path->origin, path->direction, &path->random, path->beta,
                                                emitted, &collision);
        if (spans.emits != 0) ty_path_add(path, emitted);
        if (collides) {
            *medium = &media[collision.medium];
            path->scattered = 1;
            path->origin = ty_mad(path->origin, path->direction, collision.t);
            return ty_path_survives(path, beta_before);
        }
        ty_path_add_emission(path, path->beta, on_surface ? end : NULL);
        path->scattered = 0;
        return on_surface && ty_max3(end->point.albedo) > 0.0f && ty_path_survives(path, beta_before);
    }
    /* Homogeneous media: the transmittance to the end is known, so emission there is added in full, and the path either
     * collides or goes on to the surface with probabilities proportional to the throughput of both. */
    float depth[3], collided[3], transmitted[3], reflecting = 0.0f, colliding = 0.0f;
    ty_spans_optical_depth(media, &spans, TY_FLOAT_MAX, depth);
    if (spans.emits != 0) {
        ty_spans_emitted_radiance(media, &spans, emitted);
        for (int c = 0; c < 3; ++c) emitted[c] *= path->beta[c];
        ty_path_add(path, emitted);
    }
    for (int c = 0; c < 3; ++c) {
        collided[c] = ty_collision_probability(depth[c]);
        transmitted[c] = path->beta[c] * ty_expf(-depth[c]);
        colliding += path->beta[c] * collided[c];
        if (on_surface) reflecting += transmitted[c] * end->point.albedo[c];
    }
    if (!scatters) colliding = 0.0f;
    if (on_surface || path->request->deep == 0)
        ty_path_add_emission(path, transmitted, on_surface ? end : NULL);
    else
        ty_path_add_faint_emission(path, transmitted, beta_before);
    const float sum = colliding + reflecting;
    if (!(sum > 0.0f)) return false;
    if (TY_PATH_GUIDED != 0 && spans.count == 1 && colliding > 0.0f && path->depth == 0) {
        ty_guided_event event;
        if (ty_path_sample_guided_event(path, &spans, end, transmitted, colliding, reflecting, &event)) {
            path->scattered = event.collides;
            if (event.collides) {
                *medium = &media[spans.medium[0]];
                path->origin = ty_mad(path->origin, path->direction, event.t);
            }
            return event.analog > 0.0f && ty_path_survives(path, ty_sum3(path->beta) / event.analog);
        }
    }
    const float chance = colliding / sum;
    const float u = ty_sobol_next(&path->random);
    if (u < chance) {
        if (!ty_sample_homogeneous_collision(media, &spans, collided, u / chance, &path->random, path->beta,
                                             &collision))
            return false;
        for (int c = 0; c < 3; ++c) path->beta[c] /= chance;
        *medium = &media[collision.medium];
        path->scattered = 1;
        path->origin = ty_mad(path->origin, path->direction, collision.t);
    } else {
        for (int c = 0; c < 3; ++c) path->beta[c] = transmitted[c] / (1.0f - chance);
        path->scattered = 0;
    }
    return ty_path_survives(path, beta_before);
}

/* The same in a medium whose light is known: it is added at a sampled collision, and the path goes on to the surface
 * with the light that does not collide. */
TY_FN_CALLED bool ty_path_next_event_in_field(ty_path* path, const ty_enclosed_field* field, ty_intersection* end) {
    const ty_scene_view* scene = path->request->scene;
    const float beta_before = ty_sum3(path->beta);
    if (!(beta_before > 1e-30f)) return false;
    const bool on_surface = ty_accel_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end->hit);
    const float far = on_surface ? end->hit.distance : TY_FLOAT_MAX;
    if (on_surface) ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    if (on_surface && end->point.glossy != 0) ty_path_meet_gloss(path, &end->point);
    if (on_surface) ty_path_meet_interface(path, end);
    ty_spans spans;
    ty_collision collision;
    float emitted[3] = {0.0f, 0.0f, 0.0f}, depth[3], collided[3], transmitted[3] = {0.0f, 0.0f, 0.0f};
    ty_spans_find(path->media, path->medium_count, path->origin, path->direction, far, &spans);
    bool collides;
    if (spans.heterogeneous != 0) {
        collides = ty_delta_tracking(path->media, &spans, path->origin, path->direction, &path->random, path->beta,
                                     emitted, &collision);
        for (int c = 0; c < 3 && !collides; ++c) transmitted[c] = path->beta[c];
    } else {
        ty_spans_optical_depth(path->media, &spans, TY_FLOAT_MAX, depth);
        for (int c = 0; c < 3; ++c) {
            collided[c] = ty_collision_probability(depth[c]);
            transmitted[c] = path->beta[c] * ty_expf(-depth[c]);
        }
        collides = ty_sample_homogeneous_collision(path->media, &spans, collided, ty_sobol_next(&path->random),
                                                   &path->random, path->beta, &collision);
    }
    if (collides) ty_path_add_field(path, field, collision.t);
    for (int c = 0; c < 3; ++c) path->beta[c] = transmitted[c];
    ty_path_add_emission(path, transmitted, on_surface ? end : NULL);
    path->scattered = 0;
    return on_surface && ty_max3(end->point.albedo) > 0.0f && ty_path_survives(path, beta_before);
}

/* The next event of a path in a periodic cell, as ty_path_next_event. */
TY_FN bool ty_path_next_event_periodic(ty_path* path, const ty_medium_view** medium, ty_intersection* end) {
    const ty_scene_view* scene = path->request->scene;
    const float beta_before = ty_sum3(path->beta);
    ty_periodic_walk walk;
    *medium = NULL;
    if (!(beta_before > 1e-30f)) return false;
    bool more = ty_periodic_walk_begin(&walk, &scene->periodic, path->origin, path->direction);
    while (more) {
        const bool on_surface =
            scene->mesh != NULL && ty_accel_intersect(scene->mesh, walk.origin, path->direction, walk.far, &end->hit);
        if (ty_periodic_meets_medium(path, &walk, on_surface ? end->hit.distance : walk.far, medium))
            return ty_path_survives(path, beta_before);
        if (!(ty_max3(path->beta) > 0.0f)) return false;
        if (on_surface) {
            ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
            if (TY_PATH_GLOSS != 0 && end->point.glossy != 0) ty_path_meet_gloss(path, &end->point);
            end->interface = TY_INTERFACE_NONE;
            return ty_max3(end->point.albedo) > 0.0f && ty_path_survives(path, beta_before);
        }
        more = ty_periodic_walk_next(&walk, &scene->periodic);
        if (!more && ty_periodic_walk_is_lost(&walk)) return false;
    }
    ty_path_add_emission(path, path->beta, NULL);
    return false;
}

/* The next event of a path: true at a new vertex, which lies in *medium or, if that is NULL, on the surface *end. */
TY_FN bool ty_path_next_event(ty_path* path, const ty_medium_view** medium, ty_intersection* end) {
    if (TY_PATH_PERIODIC != 0) return ty_path_next_event_periodic(path, medium, end);
    if (!ty_path_sees_dielectrics(path)) return ty_path_next_event_before_surface(path, medium, end);
    const int32_t scattered = path->scattered;
    for (;;) {
        const ty_enclosed_field* field = ty_path_enclosed_field(path);
        *medium = NULL;
        if (!(field != NULL ? ty_path_next_event_in_field(path, field, end)
                            : ty_path_next_event_before_surface(path, medium, end)))
            return false;
        if (*medium != NULL || end->interface != TY_INTERFACE_PASSED) {
            if (*medium != NULL) path->passed = 0.0f;
            return true;
        }
        path->scattered = scattered;
        ty_path_pass_interface(path, end);
    }
}

/* Traces a path to its end and returns its number of vertices. */
TY_FN uint32_t ty_path_follow(ty_path* path) {
    const int32_t max_depth = path->request->max_depth;
    const ty_medium_view* medium;
    ty_intersection end;
    uint32_t vertices = 0;
    while (ty_path_next_event(path, &medium, &end)) {
        if (max_depth > 0 && path->depth >= max_depth) break;
        path->run = medium != NULL ? path->run + 1 : 0;
        if (path->request->max_run > 0 && path->run > path->request->max_run) break;
        ++path->depth;
        ++vertices;
        if (TY_PATH_GUIDED != 0) path->incident = -1.0f;
        path->path_class =
            medium != NULL ? ty_path_class_scattered(path->path_class) : ty_path_class_reflected(path->path_class);
        if (medium != NULL)
            ty_path_scatter(path, medium);
        else if (ty_path_sees_dielectrics(path) && end.interface == TY_INTERFACE_REFRACTS)
            ty_path_refract(path, &end);
        else if (TY_PATH_GLOSS != 0 && end.point.glossy != 0) {
            for (int c = 0; c < 3 && ty_path_sees_dielectrics(path) && end.interface == TY_INTERFACE_PANE; ++c)
                path->beta[c] *= end.tint[c];
            ty_path_reflect_gloss(path, &end);
        } else
            ty_path_reflect(path, &end);
        if (TY_PATH_GUIDED != 0 && !ty_path_passes_window(path)) break;
    }
    return vertices;
}

TY_FN void ty_path_begin(ty_path* path, const ty_path_request* request, uint64_t item, uint32_t sample) {
    path->request = request;
    path->random = ty_sampler_begin(request->sobol, request->seed, item, sample);
    path->rr_throughput = 1.0f;
    path->pdf = 0.0f;
    path->scattered = 0;
    path->phase = 0.0f;
    path->point_light_rate = 0.0f;
    path->found = TY_FOUND_NONE;
    path->depth = 0;
    path->run = 0;
    path->path_class = TY_PATH_UNCOLLIDED;
    path->normal = ty_vec_make(0, 0, 0);
    path->lobe.weight = 0.0f;
    path->media = request->scene->media;
    path->medium_count = request->scene->medium_count;
    path->passed = 0.0f;
    path->vertex.refractions = -1;
    path->expected = 0.0f;
    path->incident = -1.0f;
    for (int c = 0; c < 3; ++c) path->beta[c] = 1.0f;
    memset(path->radiance, 0, sizeof path->radiance);
}

/* Starts a path that estimates the fluence at a point, the integral of radiance over all directions, W m^-2, times a
 * factor. */
TY_FN void ty_path_begin_fluence(ty_path* path, ty_vec point, const float factor[3]) {
    ty_light_sample sample;
    float chosen;
    path->origin = point;
    ty_path_begin_inside(path);
    bool shines;
    const int32_t light = ty_path_sample_light(path, point, &chosen, &sample, &shines);
    if (shines)
        ty_path_add_vertex_light(path, &path->request->scene->lights.lights[light], chosen, &sample, factor, TY_INV_4PI,
                                 0.0f);
    const ty_vertex_response response = {NULL, NULL, NULL};
    ty_path_sample_refracted_light(path, light, chosen, shines ? &sample : NULL, &response);
    ty_path_sample_sphere(path);
    for (int c = 0; c < 3; ++c) path->beta[c] = factor[c] / TY_INV_4PI;
}

#endif
