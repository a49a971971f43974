/* Next-event estimation through smooth interfaces at a vertex of a path (manifold.k.h).
 *
 * Delta lights (directional, point and spot lights) are met by no sampled direction. From the straight line on Newton's
 * method finds one specular chain to them; all chains have a chance to be found from a sampled direction, with
 * refraction and reflection by chance. A chain that is found with probability p has the weight 1 / p, estimated without
 * bias by the number of trials until it is found again (Zeltner et al. 2020), up to a bound. That of the straight line
 * is left out of these. */
#ifndef TY_METHOD_PATH_TRACE_REFRACTED_LIGHT_K_H
#define TY_METHOD_PATH_TRACE_REFRACTED_LIGHT_K_H

#include "method/path/trace/manifold.k.h"
#include "method/path/trace/vertex_response.k.h"

/* Largest numbers, against single bright samples and long searches, of trials until a chain is found again, and of
 * Newton's steps in each. */
enum { TY_MANIFOLD_TRIALS_MAX = 32, TY_MANIFOLD_SAMPLED_STEPS_MAX = 10 };

/* Chains of a smaller determinant, at caustics, are left out: single ones would outshine all others, and Newton's
 * method does not tell the nearest apart. */
#define TY_MANIFOLD_DETERMINANT_MIN 2e-2f

/* Light of an emitter with a size, or of an environment, at a sampled point of it. Its MIS weight is against the
 * vertex's own directions. */
TY_FN void ty_path_add_refracted_emitter(ty_path* path, const ty_light_view* light, float chosen,
                                         const ty_light_sample* sample, const ty_vertex_response* response) {
    const ty_path_request* request = path->request;
    const bool distant = light->kind == TY_KIND_ENVIRONMENT;
    const ty_manifold_target target = {distant ? sample->wi : ty_mad(path->origin, sample->wi, sample->distance),
                                       distant};
    ty_vec direction;
    ty_refracted_ray ray;
    float factor[3], radiance[3];
    const float density =
        ty_manifold_emitter_chain(path, &path->vertex, light, chosen, &target, TY_MANIFOLD_ARRIVE, &direction, &ray);
    if (!(density > 0.0f)) return;
    if (request->max_depth > 0 && path->depth + ray.interfaces > request->max_depth) return;
    const float pdf = ty_vertex_response_evaluate(response, direction, factor);
    if (!(pdf > 0.0f)) return;
    const float weight = ty_path_radiance_ratio(path, ray.inside.top) * sample->pdf / (density + pdf * ray.chance);
    for (int c = 0; c < 3; ++c)
        radiance[c] = path->beta[c] * factor[c] * ray.throughput[c] * sample->radiance[c] * weight;
    ty_path_add_refracted(path, radiance);
}

/* ---- delta lights ---- */

/* Light of a delta light by a found chain, for the light's probability `chosen`; false: there is none. */
TY_FN bool ty_path_refracted_radiance(ty_path* path, const ty_light_view* light, float chosen,
                                      const ty_manifold_target* target, ty_vec direction,
                                      const ty_vertex_response* response, ty_refracted_ray* ray, float radiance[3]) {
    ty_light_sample sample;
    float factor[3];
    if (!(ty_vertex_response_evaluate(response, direction, factor) > 0.0f)) return false;
    if (!ty_manifold_trace(path, &path->vertex, target, direction, TY_MANIFOLD_ARRIVE, ray)) return false;
    if (!ty_light_sample_from(light, ray->origin, 0.5f, 0.5f, &sample)) return false;
    const float weight =
        ty_path_radiance_ratio(path, ray->inside.top) / (chosen * ty_maxf(ty_manifold_determinant(ray), 1e-12f));
    for (int c = 0; c < 3; ++c)
        radiance[c] = path->beta[c] * factor[c] * ray->throughput[c] * sample.radiance[c] * weight;
    return ty_sum3(radiance) > 0.0f;
}

/* A direction of the vertex, by its own sampling; false: none. */
TY_FN bool ty_vertex_response_sample(const ty_vertex_response* response, ty_sampler* random, ty_vec* direction) {
    const float u = ty_rng_uniform(random), v = ty_rng_uniform(random);
    float factor[3];
    if (response->scatter != NULL) {
        *direction = ty_scatter_vertex_sample(response->scatter, random);
        return true;
    }
    if (response->surface == NULL) {
        *direction = ty_direction_about(ty_vec_make(0, 0, 1), 1.0f - 2.0f * u, v);
        return true;
    }
    if (TY_PATH_GLOSS != 0 && response->surface->glossy != 0)
        return ty_surface_sample_bsdf(response->surface, ty_rng_uniform(random), u, v, direction, factor) > 0.0f;
    *direction = ty_direction_about(response->surface->ns, sqrtf(1.0f - u), v);
    return true;
}

/* A chain to a delta light from a sampled direction on; false: none is found. */
TY_FN bool ty_path_sample_chain(ty_path* path, const ty_manifold_target* target, const ty_vertex_response* response,
                                ty_vec* direction, ty_refracted_ray* ray) {
    ray->reflections = 0;
    if (!ty_vertex_response_sample(response, &path->random, direction) ||
        !ty_manifold_trace(path, &path->vertex, target, *direction, TY_MANIFOLD_SEED, ray))
        return false;
    return ty_manifold_solve(path, &path->vertex, target, TY_MANIFOLD_SAMPLED_STEPS_MAX, direction, ray) &&
           ty_manifold_determinant(ray) > TY_MANIFOLD_DETERMINANT_MIN;
}

/* Light of a delta light by all chains but that of the straight line. found: that one's ray, in `direction`; NULL:
 * there is none. Of a path's vertices the later ones look for them less often. */
TY_FN void ty_path_add_sampled_chains(ty_path* path, const ty_light_view* light, float chosen,
                                      const ty_manifold_target* target, const ty_vertex_response* response,
                                      ty_vec direction, const ty_refracted_ray* found) {
    ty_vec other, again;
    ty_refracted_ray chain, trial;
    float radiance[3];
    const float rate = 1.0f / ty_clampf((float)path->depth, 1.0f, 8.0f);
    if (ty_rng_uniform(&path->random) >= rate) return;
    if (!ty_path_sample_chain(path, target, response, &other, &chain)) return;
    if (found != NULL && chain.reflections == 0 && ty_manifold_is_same(found, direction, other)) return;
    if (!ty_path_refracted_radiance(path, light, chosen, target, other, response, &chain, radiance)) return;
    const float chance = ty_minf(ty_max3(radiance) / (rate * path->request->min_contribution), 1.0f);
    if (ty_rng_uniform(&path->random) >= chance) return;
    int32_t trials = 1;
    while (trials < TY_MANIFOLD_TRIALS_MAX &&
           !(ty_path_sample_chain(path, target, response, &again, &trial) && trial.reflections == chain.reflections &&
             ty_manifold_is_same(&chain, other, again)))
        ++trials;
    for (int c = 0; c < 3; ++c) radiance[c] *= (float)trials / (chance * rate);
    ty_path_add_refracted(path, radiance);
}

/* Light of a directional, point or spot light. */
TY_FN void ty_path_add_refracted_delta_light(ty_path* path, const ty_light_view* light, float chosen,
                                             const ty_vertex_response* response) {
    const bool distant = light->kind == TY_KIND_DIRECTIONAL;
    const ty_manifold_target target = {distant ? ty_scale(light->direction, -1.0f) : light->position, distant};
    ty_vec direction = target.point;
    ty_refracted_ray found;
    float radiance[3];
    const bool finds = ty_manifold_find(path, &path->vertex, &target, &direction, &found);
    if (finds) {
        ty_refracted_ray arriving = found;
        if (ty_path_refracted_radiance(path, light, chosen, &target, direction, response, &arriving, radiance))
            ty_path_add_refracted(path, radiance);
    }
    const ty_sampler own = path->random;
    path->random = ty_sampler_branch(&own);
    ty_path_add_sampled_chains(path, light, chosen, &target, response, direction, finds ? &found : NULL);
    path->random = own;
}

/* ---- all lights ---- */

/* Next-event estimation through smooth interfaces, for the light that the vertex at path->origin chose with probability
 * `chosen`. */
TY_FN_CALLED void ty_path_add_refracted_light(ty_path* path, int32_t light, float chosen, const ty_light_sample* sample,
                                              const ty_vertex_response* response) {
    const ty_light_view* view = &path->request->scene->lights.lights[light];
    if (view->kind == TY_KIND_DIRECTIONAL || ty_light_is_point_or_spot(view->kind))
        ty_path_add_refracted_delta_light(path, view, chosen, response);
    else if (sample != NULL)
        ty_path_add_refracted_emitter(path, view, chosen, sample, response);
}

/* The same where the scene has solid dielectrics. light: -1 for none. sample: of the light; NULL: it carries no
 * radiance. */
TY_FN void ty_path_sample_refracted_light(ty_path* path, int32_t light, float chosen, const ty_light_sample* sample,
                                          const ty_vertex_response* response) {
    if (!ty_path_sees_dielectrics(path) || path->request->scene->interior_count < 2) return;
    path->vertex.refractions = 0;
    path->vertex.origin = path->origin;
    path->vertex.normal = path->normal;
    path->vertex.lobe = path->lobe;
    path->vertex.inside = path->inside;
    if (light >= 0) ty_path_add_refracted_light(path, light, chosen, sample, response);
}

#endif
