/* Directions of the light without dedicated fields, which its phase functions need towards an eye. The aggregate field
 * holds its amount on fine cells; clusters hold its directions on coarse cells. */
#include "base/context.h"
#include "method/dom/sources/environment.h"
#include "method/dom/sources/sources.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Maximum number of clusters of all lights; each light has at least one. */
enum { MAX_CLUSTERS = 128 };

/* Maximum ratio of two lobes. */
static const float max_ratio = 10;

static float mean_color(const ty_discrete_light* source) {
    return (source->color[0] + source->color[1] + source->color[2]) * (1.0f / 3.0f);
}

/* ---- making ---- */

/* Optical depth of sigma_t - g^order sigma_s (order 0: sigma_t) over that of sigma_t - g^bands sigma_s. */
static float depth_ratio(const ty_grid_medium* medium, int32_t plane, int32_t bands, int32_t order) {
    const bool moments = medium->legendre[0] > 0;
    double sums[2] = {0, 0};
    for (size_t i = 0; i < medium->cells; ++i) {
        const double sigma_t = (double)medium->extinction[plane][i], sigma_s = (double)medium->scattering[plane][i];
        const double g = (double)medium->g[plane][i];
        const double forward = moments ? (double)ty_grid_medium_forward(medium, bands) : pow(g, bands);
        const double at_order = moments ? (double)ty_grid_medium_forward(medium, order) : pow(g, order);
        sums[0] += sigma_t - forward * sigma_s;
        sums[1] += sigma_t - (order > 0 ? at_order * sigma_s : 0);
    }
    return sums[0] > 0 ? (float)(sums[1] / sums[0]) : 1;
}

/* The first samples of a group, which cover the light evenly, become the initial clusters. */
static void begin_clusters(const ty_dom_job* job, const ty_light_group* group, int32_t count) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    ty_dom* light = job->light;
    for (int32_t i = 0; i < count; ++i) {
        const ty_discrete_light* source = &job->sources.items[group->first + i];
        ty_dom_light_cluster* cluster = &light->clusters[light->cluster_count++];
        *cluster = (ty_dom_light_cluster){.sample = *source,
                                          .environment = lights->lights[source->light].kind == TY_KIND_ENVIRONMENT};
        cluster->sample.area = cluster->sample.mean_cosine = 0;
        for (int c = 0; c < 3; ++c) cluster->sample.color[c] = 0;
    }
}

static int32_t cluster_count_of(const ty_light_group* group, int32_t sources) {
    const int64_t count = sources > MAX_CLUSTERS ? (int64_t)MAX_CLUSTERS * group->count / sources : group->count;
    return group->dedicated ? 0 : count < 1 ? 1 : (int32_t)count;
}

static ty_result allocate_planes(ty_dom_job* job) {
    ty_dom* light = job->light;
    light->cluster_planes = job->coarse->planes;
    for (int32_t i = 0; i < light->cluster_count; ++i)
        for (int32_t p = 0; p < light->cluster_planes; ++p) {
            light->clusters[i].fluence[p] = ty_alloc_array(job->context, light->cells, sizeof(float), true);
            if (light->clusters[i].fluence[p] == NULL) return TY_ERROR_MEMORY;
        }
    return TY_OK;
}

ty_result ty_dom_clusters_create(ty_dom_job* job, const ty_light_group* groups, int32_t count) {
    ty_dom* light = job->light;
    int32_t sources = 0;
    for (int32_t i = 0; i < count; ++i) sources += groups[i].dedicated ? 0 : groups[i].count;
    light->cluster_capacity = 0;
    for (int32_t i = 0; i < count; ++i) light->cluster_capacity += cluster_count_of(&groups[i], sources);
    light->clusters = ty_alloc_array(job->context, (size_t)light->cluster_capacity, sizeof *light->clusters, true);
    if (light->clusters == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < count; ++i) begin_clusters(job, &groups[i], cluster_count_of(&groups[i], sources));
    for (int32_t p = 0; p < job->coarse->planes; ++p) {
        light->unscattered_ratio[p] = depth_ratio(job->coarse, p, light->bands, 0);
        light->next_order_ratio[p] = depth_ratio(job->coarse, p, light->bands, light->bands + 1);
    }
    return allocate_planes(job);
}

void ty_dom_clusters_destroy(ty_dom* light) {
    for (int32_t i = 0; i < light->cluster_count; ++i)
        for (int c = 0; c < 3; ++c)
            ty_free_array(light->context, light->clusters[i].fluence[c], light->cells, sizeof(float));
    ty_free_array(light->context, light->clusters, (size_t)light->cluster_capacity, sizeof *light->clusters);
}

/* ---- filling ---- */

/* Square distance of a sample from its cluster's first sample. */
static float distance_to(const ty_dom_light_cluster* cluster, const ty_discrete_light* source) {
    const ty_discrete_light* begin = &cluster->sample;
    const ty_vec off = source->kind == TY_DISCRETE_DIRECTIONAL ? ty_sub(begin->direction, source->direction)
                                                               : ty_sub(begin->position, source->position);
    return ty_dot(off, off);
}

static ty_dom_light_cluster* find_cluster(const ty_dom* light, const ty_discrete_light* source) {
    ty_dom_light_cluster* nearest = NULL;
    float min_square = INFINITY;
    for (int32_t i = 0; i < light->cluster_count; ++i) {
        ty_dom_light_cluster* cluster = &light->clusters[i];
        if (cluster->sample.light != source->light || cluster->sample.kind != source->kind) continue;
        const float distance = distance_to(cluster, source);
        if (distance >= min_square) continue;
        min_square = distance;
        nearest = cluster;
    }
    return nearest;
}

void ty_dom_clusters_add(ty_dom_job* job, const ty_discrete_light* source, int32_t planes, float* const fluence[3]) {
    const ty_dom* light = job->light;
    ty_dom_light_cluster* cluster = find_cluster(light, source);
    const float brightness = mean_color(source), factor = planes == 1 ? brightness : 1;
    for (int32_t p = 0; p < planes; ++p)
        for (size_t i = 0; i < light->cells; ++i) cluster->fluence[p][i] += factor * fluence[p][i];
    const ty_vec at = cluster->sample.kind == TY_DISCRETE_DIRECTIONAL ? ty_scale(source->direction, source->mean_cosine)
                                                                      : source->position;
    cluster->weighted_sum = ty_mad(cluster->weighted_sum, at, brightness);
    cluster->sample.area += source->area;
    cluster->brightness += brightness;
    for (int c = 0; c < 3; ++c) cluster->sample.color[c] += source->color[c];
}

/* Scales a cluster's fluence to color 1. */
static void scale_planes(ty_dom* light, ty_dom_light_cluster* cluster) {
    for (int32_t p = 0; p < light->cluster_planes; ++p) {
        const float fluence_sum = light->cluster_planes == 1 ? cluster->brightness : cluster->sample.color[p];
        const float factor = fluence_sum > 0 ? 1 / fluence_sum : 0;
        for (size_t i = 0; i < light->cells; ++i) cluster->fluence[p][i] *= factor;
    }
}

void ty_dom_clusters_end(ty_dom_job* job) {
    ty_dom* light = job->light;
    for (int32_t i = 0; i < light->cluster_count; ++i) {
        ty_dom_light_cluster* cluster = &light->clusters[i];
        if (!(cluster->brightness > 0)) continue;
        scale_planes(light, cluster);
        const ty_vec mean = ty_scale(cluster->weighted_sum, 1 / cluster->brightness);
        cluster->sample.mean_cosine = 1;
        if (cluster->sample.kind == TY_DISCRETE_POINT) {
            cluster->sample.position = mean;
            continue;
        }
        const float length = sqrtf(ty_dot(mean, mean));
        cluster->sample.mean_cosine = length;
        cluster->sample.direction = length > 0 ? ty_scale(mean, 1 / length) : mean;
    }
}

/* ---- seeing ---- */

typedef struct evaluate_job {
    const ty_dom* light;
    const ty_dom_environment* sky;
    const double* eye;
    int32_t channels;
    int64_t first_row;
    float* const* radiance_sum;
    float* const* fluence_sum;
} evaluate_job;

/* Direction of a cluster's light at a cell, its mean cosine, and its fluence without media. */
typedef struct arrival {
    ty_vec omega;
    float mean_cosine, unattenuated;
} arrival;

static arrival arrive(const ty_dom* light, const ty_dom_light_cluster* cluster, const int32_t cell[3]) {
    if (cluster->sample.kind == TY_DISCRETE_DIRECTIONAL)
        return (arrival){cluster->sample.direction, cluster->sample.mean_cosine, 1};
    float at[3];
    for (int a = 0; a < 3; ++a)
        at[a] = (float)(light->box.lower[a] +
                        (light->box.upper[a] - light->box.lower[a]) * (cell[a] + 0.5) / light->box.size[a]);
    const ty_vec off = ty_sub(ty_vec_load(at), cluster->sample.position);
    const float square = ty_maxf(1e-12f, ty_dot(off, off));
    const float cap = ty_minf(2 * TY_PI, cluster->sample.area / square);
    return (arrival){ty_scale(off, 1 / sqrtf(square)), 1 - cap * TY_INV_4PI, 1 / square};
}

/* Transmittances U, R and S of a cluster's light. */
static ty_forward forward_of(const ty_dom* light, int32_t plane, float fluence, const arrival* from) {
    const float order_l = ty_minf(1, fluence / from->unattenuated);
    return (ty_forward){.phi_unscattered = powf(order_l, light->unscattered_ratio[plane]),
                        .phi_order_l = order_l,
                        .phi_next_order = powf(order_l, light->next_order_ratio[plane]),
                        .mean_cosine = from->mean_cosine};
}

/* Scattering of a cluster's light at cosine mu, per scattering coefficient, times 4 pi. */
static float scattered_phase(const ty_dom* light, const ty_forward* forward, float mu, float g) {
    const float* legendre = ty_dom_legendre(light);
    float radiance = ty_forward_unscattered(*forward, mu, g), blurred[TY_PHASE_MOMENTS] = {0};
    if (light->has_lobes) {
        ty_dom_blur_legendre(light, forward->mean_cosine, blurred);
        radiance += ty_forward_scattered_order(*forward, mu, g * forward->mean_cosine,
                                               legendre != NULL ? blurred : NULL, light->bands);
    }
    return 4 * TY_PI * radiance;
}

/* Correction where a cell's g differs from the mean g that the environment's weights assume. */
static float lobe_ratio(float mu, float g, float mean, float cosine) {
    if (fabsf(g - mean) < 1e-4f) return 1;
    return ty_minf(max_ratio, ty_hg(mu, g * cosine) / ty_hg(mu, mean * cosine));
}

/* Adds a cluster's scattered radiance at a cell along omega, and its fluence. */
static void add_cluster(const evaluate_job* job, int32_t index, const int32_t cell[3], size_t at, ty_vec omega,
                        const ty_dom_environment_view* view, float radiance_sum[3], float fluence_sum[3]) {
    const ty_dom* light = job->light;
    const ty_dom_light_cluster* cluster = &light->clusters[index];
    const arrival from = arrive(light, cluster, cell);
    const float mu = ty_dot(from.omega, omega);
    for (int32_t p = 0; p < light->cluster_planes; ++p) {
        const float fluence = cluster->fluence[p][at], g = light->g[p][at];
        if (!(fluence > 0)) continue;
        const ty_forward forward = forward_of(light, p, fluence, &from);
        const float over = fluence / forward.phi_order_l;
        const float radiance = cluster->environment
                                   ? over * lobe_ratio(mu, g, light->mean_g[p], cluster->sample.mean_cosine)
                                   : over * scattered_phase(light, &forward, mu, g);
        for (int32_t c = p; c < (light->cluster_planes == 1 ? 3 : p + 1); ++c) {
            radiance_sum[c] += radiance * (cluster->environment ? ty_dom_environment_radiance(view, index, c, &forward)
                                                                : cluster->sample.color[c]);
            fluence_sum[c] += cluster->sample.color[c] * fluence;
        }
    }
}

static void evaluate_cell(const evaluate_job* job, const int32_t cell[3], size_t at) {
    const ty_dom* light = job->light;
    double omega[3];
    float radiance_sum[3] = {0}, fluence_sum[3] = {0};
    ty_dom_environment_view view = {.t = {0}};
    ty_dom_direction_to_eye(light, cell, job->eye, omega);
    const ty_vec to_eye = ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2]);
    if (job->sky->weights != NULL) ty_dom_environment_lookup(light, job->sky, to_eye, &view);
    for (int32_t i = 0; i < light->cluster_count; ++i)
        add_cluster(job, i, cell, at, to_eye, &view, radiance_sum, fluence_sum);
    for (int32_t c = 0; c < job->channels; ++c) {
        job->radiance_sum[c][at] =
            job->channels == 3 ? radiance_sum[c] : radiance_sum[0] + radiance_sum[1] + radiance_sum[2];
        job->fluence_sum[c][at] =
            job->channels == 3 ? fluence_sum[c] : fluence_sum[0] + fluence_sum[1] + fluence_sum[2];
    }
}

static void evaluate_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const evaluate_job* job = user;
    const int32_t* size = job->light->box.size;
    row += job->first_row;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        evaluate_cell(job, cell, (size_t)row * (size_t)size[0] + (size_t)i);
    }
}

ty_result ty_dom_evaluate_clusters(const ty_dom* light, const double eye[3], int32_t channels,
                                   ty_part_progress* progress, float* const radiance_sum[3],
                                   float* const fluence_sum[3]) {
    ty_dom_environment sky;
    ty_result result = ty_dom_environment_evaluate(light, eye, &sky);
    evaluate_job job = {light, &sky, eye, channels, 0, radiance_sum, fluence_sum};
    for (int32_t z = 0; z < light->box.size[2] && result == TY_OK; ++z, job.first_row += light->box.size[1]) {
        ty_parallel_for(light->context, light->box.size[1], evaluate_row, &job);
        result = ty_part_show(progress, "lights", 0);
    }
    ty_dom_environment_free(light, &sky);
    return result;
}
