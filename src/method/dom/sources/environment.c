/* Single scattering of environments towards the eye. Their light clusters are so few that narrow phase functions would
 * leave gaps between them, while their transmittances vary little from one to the next. So the environment is divided
 * into many finer clusters with their own radiance and direction, each of which takes its transmittance from its
 * nearest light clusters. For each direction to the eye this gives one weight per light cluster, tabulated for a few
 * mean cosines of the lobe. */
#include "method/dom/sources/environment.h"
#include "method/dom/sources/sources.h"

#include "base/context.h"
#include "base/octahedral.k.h"
#include "direct/lights/environment_clusters.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Number of finer clusters of an environment; side of the octahedral map of directions. */
enum { ENV_CLUSTERS = 1024, SIDE = TY_DOM_ENVIRONMENT_SIDE };
/* Steps of the table of lobes over the sine of half the angle. */
enum { STEPS = 256 };
/* Sample points within a cluster. */
enum { RINGS = 4, PER_RING = 8 };
/* Minimum of 1 minus the mean cosine, for clusters without extent. */
static const float min_spread = 1e-4f;

/* ---- finer clusters ---- */

/* Weights of a finer cluster's nearest light clusters, by Gaussians as wide as each of these. */
static void find_neighbours(const ty_dom* light, int32_t of, ty_dom_env_cluster* region) {
    float best[TY_DOM_ENV_NEIGHBOURS] = {0}, sum = 0;
    memset(region->neighbour, 0, sizeof region->neighbour);
    for (int32_t i = 0; i < light->cluster_count; ++i) {
        const ty_dom_light_cluster* cluster = &light->clusters[i];
        if (!cluster->environment || cluster->sample.light != of) continue;
        const float sums = ty_maxf(min_spread, 1 - cluster->sample.mean_cosine),
                    off = 1 - ty_dot(cluster->sample.direction, region->omega);
        float weight = expf(-ty_minf(80, off / sums));
        int32_t at = i;
        for (int32_t k = 0; k < TY_DOM_ENV_NEIGHBOURS; ++k) {
            if (!(weight > best[k])) continue;
            const float other = best[k];
            const int32_t other_at = region->neighbour[k];
            best[k] = weight;
            region->neighbour[k] = at;
            weight = other;
            at = other_at;
        }
    }
    for (int32_t k = 0; k < TY_DOM_ENV_NEIGHBOURS; ++k) sum += best[k];
    for (int32_t k = 0; k < TY_DOM_ENV_NEIGHBOURS; ++k) region->weight[k] = sum > 0 ? best[k] / sum : 0;
}

/* Divides one environment into finer clusters. sums: of brightness, and of brightness times mean cosine. */
static ty_result find_env_clusters(const ty_dom_job* job, int32_t of, ty_discrete_light_set* clusters, double* sums) {
    const ty_environment_clusters_def def = {.count = ENV_CLUSTERS, .prefilter = 1};
    ty_dom* light = job->light;
    clusters->count = 0;
    const ty_result result = ty_environment_clusters_add(job->scene, &def, of, clusters);
    for (int32_t i = 0; i < clusters->count && result == TY_OK; ++i) {
        const ty_discrete_light* cluster = &clusters->items[i];
        ty_dom_env_cluster* region = &light->env_clusters[light->env_count++];
        const float color_sum = cluster->color[0] + cluster->color[1] + cluster->color[2];
        region->omega = cluster->direction;
        memcpy(region->color, cluster->color, sizeof region->color);
        find_neighbours(light, of, region);
        sums[0] += (double)color_sum;
        sums[1] += (double)(color_sum * cluster->mean_cosine);
    }
    return result;
}

/* Scattering-weighted mean of g, per plane. */
static void find_mean_g(const ty_grid_medium* medium, float g[3]) {
    for (int32_t p = 0; p < medium->planes; ++p) {
        double sums[2] = {0, 0};
        for (size_t i = 0; i < medium->cells; ++i) {
            sums[0] += (double)medium->scattering[p][i];
            sums[1] += (double)(medium->scattering[p][i] * medium->g[p][i]);
        }
        g[p] = sums[0] > 0 ? (float)(sums[1] / sums[0]) : 0;
    }
}

ty_result ty_dom_environment_find(ty_dom_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    ty_dom* light = job->light;
    double sums[2] = {0, 0};
    for (int32_t i = 0; i < lights->count; ++i)
        if (lights->lights[i].kind == TY_KIND_ENVIRONMENT) light->env_capacity += ENV_CLUSTERS;
    if (light->env_capacity == 0) return TY_OK;
    light->env_clusters = ty_alloc_array(job->context, (size_t)light->env_capacity, sizeof *light->env_clusters, false);
    if (light->env_clusters == NULL) return TY_ERROR_MEMORY;
    ty_discrete_light_set clusters;
    ty_result result = ty_discrete_light_set_create(job->context, "dom", ENV_CLUSTERS, &clusters);
    for (int32_t i = 0; i < lights->count && result == TY_OK; ++i)
        if (lights->lights[i].kind == TY_KIND_ENVIRONMENT) result = find_env_clusters(job, i, &clusters, sums);
    ty_discrete_light_set_destroy(job->context, &clusters);
    find_mean_g(job->coarse, light->mean_g);
    light->env_cosine = sums[0] > 0 ? (float)(sums[1] / sums[0]) : 1;
    return result;
}

void ty_dom_environment_destroy(ty_dom* light) {
    ty_free_array(light->context, light->env_clusters, (size_t)light->env_capacity, sizeof *light->env_clusters);
}

/* ---- directions ---- */

static ty_vec direction_of(const ty_dom* light, const double eye[3], const int32_t cell[3]) {
    double omega[3];
    ty_dom_direction_to_eye(light, cell, eye, omega);
    return ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2]);
}

/* Lists the texels that directions from cells to the eye interpolate. */
static void number_texels(const ty_dom* light, const double eye[3], ty_dom_environment* sky) {
    const int32_t* size = light->box.size;
    int32_t cell[3];
    for (int32_t i = 0; i < SIDE * SIDE; ++i) sky->index[i] = -1;
    for (cell[2] = 0; cell[2] < size[2]; ++cell[2])
        for (cell[1] = 0; cell[1] < size[1]; ++cell[1])
            for (cell[0] = 0; cell[0] < size[0]; ++cell[0]) {
                int32_t texel[4];
                float t[4];
                ty_octahedral_around(SIDE, direction_of(light, eye, cell), texel, t);
                for (int32_t k = 0; k < 4; ++k) {
                    if (sky->index[texel[k]] >= 0) continue;
                    sky->texel[sky->directions] = texel[k];
                    sky->index[texel[k]] = sky->directions++;
                }
            }
}

/* ---- weights ---- */

/* 4 pi times the scattering of a unit lobe by the sine of half the angle, for mean cosines of the lobe: the last one is
 * a line, which scatters by the phase function itself. */
typedef struct lobe_table {
    float lobe[STEPS + 2][TY_DOM_ENVIRONMENT_LOBES];
} lobe_table;

static void fill_lobes(const ty_dom* light, float g, lobe_table* table) {
    const float* legendre = ty_dom_legendre(light);
    float blurred[TY_PHASE_MOMENTS] = {0};
    ty_dom_blur_legendre(light, light->env_cosine, blurred);
    for (int32_t i = 0; i < STEPS + 2; ++i) {
        const float sine = ty_minf(1, (float)i / STEPS), mu = 1 - 2 * sine * sine;
        for (int32_t n = 0; n < TY_DOM_ENVIRONMENT_LOBES; ++n) {
            float below = 0, tail = 4 * TY_PI * ty_hg(mu, g);
            if (light->fit.bands > 0)
                tail = 4 * TY_PI * ty_forward_blended_phase(&light->fit, mu, g);
            else if (n + 1 < TY_DOM_ENVIRONMENT_LOBES && light->has_lobes && legendre != NULL)
                tail = ty_forward_tail_of((float)n / (TY_DOM_ENVIRONMENT_LOBES - 1), mu, blurred, light->bands, &below);
            else if (n + 1 < TY_DOM_ENVIRONMENT_LOBES && light->has_lobes)
                tail = ty_forward_tail((float)n / (TY_DOM_ENVIRONMENT_LOBES - 1), mu, g, light->bands, &below);
            table->lobe[i][n] = below + tail;
        }
    }
}

typedef struct weigh_job {
    const ty_dom* light;
    ty_dom_environment* sky;
    const lobe_table* lobes; /* one per plane */
} weigh_job;

static void weigh_direction(void* user, int64_t number, int32_t worker) {
    (void)worker;
    const weigh_job* job = user;
    const ty_dom* light = job->light;
    const int32_t texel = job->sky->texel[number];
    const ty_vec omega = ty_octahedral_texel(SIDE, texel);
    ty_dom_environment_weight* weights = job->sky->weights + (size_t)number * (size_t)light->cluster_count;
    memset(weights, 0, sizeof *weights * (size_t)light->cluster_count);
    for (int32_t i = 0; i < light->env_count; ++i) {
        const ty_dom_env_cluster* region = &light->env_clusters[i];
        const float at = sqrtf(ty_maxf(0, 0.5f * (1 - ty_dot(region->omega, omega)))) * STEPS;
        const int32_t step = at < STEPS ? (int32_t)at : STEPS;
        const float t = at - (float)step;
        for (int32_t c = 0; c < 3; ++c) {
            const lobe_table* table = &job->lobes[light->cluster_planes == 3 ? c : 0];
            for (int32_t n = 0; n < TY_DOM_ENVIRONMENT_LOBES; ++n) {
                const float lobe = region->color[c] * ty_lerpf(table->lobe[step][n], table->lobe[step + 1][n], t);
                for (int32_t k = 0; k < TY_DOM_ENV_NEIGHBOURS; ++k)
                    weights[region->neighbour[k]].lobe[n][c] += region->weight[k] * lobe;
            }
        }
    }
}

ty_result ty_dom_environment_evaluate(const ty_dom* light, const double eye[3], ty_dom_environment* sky) {
    *sky = (ty_dom_environment){.weights = NULL};
    if (light->env_count == 0) return TY_OK;
    number_texels(light, eye, sky);
    sky->count = (size_t)sky->directions * (size_t)light->cluster_count;
    sky->weights = ty_alloc_array(light->context, sky->count, sizeof *sky->weights, false);
    lobe_table* lobes = ty_alloc_array(light->context, 3, sizeof *lobes, false);
    if (sky->weights != NULL && lobes != NULL) {
        for (int32_t p = 0; p < light->cluster_planes; ++p)
            fill_lobes(light, light->mean_g[p] * light->env_cosine, &lobes[p]);
        weigh_job job = {light, sky, lobes};
        ty_parallel_for(light->context, sky->directions, weigh_direction, &job);
    }
    const bool whole = sky->weights != NULL && lobes != NULL;
    ty_free_array(light->context, lobes, 3, sizeof *lobes);
    return whole ? TY_OK : TY_ERROR_MEMORY;
}

void ty_dom_environment_free(const ty_dom* light, ty_dom_environment* sky) {
    ty_free_array(light->context, sky->weights, sky->count, sizeof *sky->weights);
}

/* ---- behind media ---- */

typedef struct blur_job {
    const ty_dom* light;
    const float* kernel; /* STEPS + 2 values over the sine of half the angle */
    float* map;
} blur_job;

static void blur_texel(void* user, int64_t texel, int32_t worker) {
    (void)worker;
    const blur_job* job = user;
    const ty_dom* light = job->light;
    const ty_vec wi = ty_octahedral_texel(TY_DOM_ENVIRONMENT_SIDE, (int32_t)texel);
    float* out = job->map + 3 * texel;
    for (int c = 0; c < 3; ++c) out[c] = 0;
    for (int32_t i = 0; i < light->env_count; ++i) {
        const ty_dom_env_cluster* region = &light->env_clusters[i];
        const float at = sqrtf(ty_maxf(0, 0.5f * (1 + ty_dot(region->omega, wi)))) * STEPS;
        const int32_t step = at < STEPS ? (int32_t)at : STEPS;
        const float* kernel = job->kernel + step;
        const float t = ty_lerpf(kernel[0], kernel[1], at - (float)step);
        for (int c = 0; c < 3; ++c) out[c] += t * region->color[c];
    }
}

/* Scattering within the peak, averaged over a cap of the clusters' mean size, so that they do not show as points. */
static float peak_kernel(const ty_dom* light, float mu) {
    const float sine = sqrtf(ty_maxf(0, 1 - mu * mu)), g = light->mean_g[0];
    float sum = 0;
    for (int32_t i = 0; i < RINGS * PER_RING; ++i) {
        const float azimuth = 2 * TY_PI * ((float)(i % PER_RING) + 0.5f) / PER_RING;
        const float up = 1 - 2 * (1 - light->env_cosine) * ((float)(i / PER_RING) + 0.5f) / RINGS;
        const float to = ty_clampf(mu * up + sine * sqrtf(ty_maxf(0, 1 - up * up)) * cosf(azimuth), -1, 1);
        sum += ty_maxf(0, ty_hg(to, g) - ty_forward_blended_phase(&light->fit, to, g));
    }
    return sum;
}

void ty_dom_environment_blur(const ty_dom* light, float* map) {
    float kernel[STEPS + 2];
    double sum = 0;
    for (int32_t i = 0; i < STEPS + 2; ++i) {
        const float sine = ty_minf(1, (float)i / STEPS);
        kernel[i] = peak_kernel(light, 1 - 2 * sine * sine);
        /* The solid angle of a step: 4 pi times the change of the square of the sine. */
        sum += 8 * (double)(TY_PI * kernel[i] * sine / STEPS);
    }
    for (int32_t i = 0; i < STEPS + 2; ++i) kernel[i] = (float)((double)kernel[i] / sum);
    blur_job job = {light, kernel, map};
    ty_parallel_for(light->context, TY_DOM_ENVIRONMENT_TEXELS, blur_texel, &job);
}

/* ---- looking ---- */

void ty_dom_environment_lookup(const ty_dom* light, const ty_dom_environment* sky, ty_vec omega,
                               ty_dom_environment_view* view) {
    int32_t texel[4];
    view->has_lobes = light->has_lobes;
    ty_octahedral_around(SIDE, omega, texel, view->t);
    for (int32_t k = 0; k < 4; ++k)
        view->weights[k] = sky->weights + (size_t)sky->index[texel[k]] * (size_t)light->cluster_count;
}

float ty_dom_environment_radiance(const ty_dom_environment_view* view, int32_t cluster, int32_t channel,
                                  const ty_forward* forward) {
    const float lost = view->has_lobes ? ty_maxf(0, forward->phi_order_l - forward->phi_unscattered) : 0;
    const float b = ty_forward_lobe_cosine(forward->phi_unscattered, forward->phi_order_l, forward->phi_next_order) *
                    (TY_DOM_ENVIRONMENT_LOBES - 1);
    const int32_t n = b < TY_DOM_ENVIRONMENT_LOBES - 1 ? (int32_t)b : TY_DOM_ENVIRONMENT_LOBES - 2;
    float line = 0, first = 0, second = 0;
    for (int32_t k = 0; k < 4; ++k) {
        const ty_dom_environment_weight* weight = &view->weights[k][cluster];
        line += view->t[k] * weight->lobe[TY_DOM_ENVIRONMENT_LOBES - 1][channel];
        first += view->t[k] * weight->lobe[n][channel];
        second += view->t[k] * weight->lobe[n + 1][channel];
    }
    return forward->phi_unscattered * line + lost * ty_lerpf(first, second, b - (float)n);
}
