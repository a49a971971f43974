/* Where light that has no field of its own comes from: what its phase functions need towards an eye. Fields of all of
 * it together hold how much there is on fine cells; parts hold, on the cells of ordinates, from where. */
#include "base/context.h"
#include "method/dom/sources/environment.h"
#include "method/dom/sources/sources.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

/* Parts of all lights; each has one at least. */
enum { PARTS = 128 };

/* How much brighter a lobe may be than another. */
static const float most_ratio = 10;

static float brightness_of(const ty_discrete_light* source) {
    return (source->color[0] + source->color[1] + source->color[2]) * (1.0f / 3.0f);
}

/* ---- making ---- */

/* How much deeper all of the medium is where light loses all that scatters (order 0), or all but g^order. */
static float deeper(const ty_grid_medium* medium, int32_t plane, int32_t bands, int32_t order) {
    double sums[2] = {0, 0};
    for (size_t i = 0; i < medium->cells; ++i) {
        const double sigma_t = (double)medium->extinction[plane][i], sigma_s = (double)medium->scattering[plane][i];
        const double g = (double)medium->g[plane][i];
        sums[0] += sigma_t - pow(g, bands) * sigma_s;
        sums[1] += sigma_t - (order > 0 ? pow(g, order) * sigma_s : 0);
    }
    return sums[0] > 0 ? (float)(sums[1] / sums[0]) : 1;
}

/* The first sources of a group begin a part each: they are spread as all are. */
static void begin_parts(const ty_dom_job* job, const ty_light_group* group, int32_t count) {
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

static int32_t parts_of(const ty_light_group* group, int32_t sources) {
    const int64_t share = sources > PARTS ? (int64_t)PARTS * group->count / sources : group->count;
    return group->own ? 0 : share < 1 ? 1 : (int32_t)share;
}

static ty_result take_planes(ty_dom_job* job) {
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
    for (int32_t i = 0; i < count; ++i) sources += groups[i].own ? 0 : groups[i].count;
    light->cluster_capacity = 0;
    for (int32_t i = 0; i < count; ++i) light->cluster_capacity += parts_of(&groups[i], sources);
    light->clusters = ty_alloc_array(job->context, (size_t)light->cluster_capacity, sizeof *light->clusters, true);
    if (light->clusters == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < count; ++i) begin_parts(job, &groups[i], parts_of(&groups[i], sources));
    for (int32_t p = 0; p < job->coarse->planes; ++p) {
        light->unscattered_ratio[p] = deeper(job->coarse, p, light->bands, 0);
        light->next_order_ratio[p] = deeper(job->coarse, p, light->bands, light->bands + 1);
    }
    return take_planes(job);
}

void ty_dom_clusters_destroy(ty_dom* light) {
    for (int32_t i = 0; i < light->cluster_count; ++i)
        for (int c = 0; c < 3; ++c)
            ty_free_array(light->context, light->clusters[i].fluence[c], light->cells, sizeof(float));
    ty_free_array(light->context, light->clusters, (size_t)light->cluster_capacity, sizeof *light->clusters);
}

/* ---- filling ---- */

/* How far a source is from where a part began: parts' directions do not change before all is there. */
static float distance_to(const ty_dom_light_cluster* part, const ty_discrete_light* source) {
    const ty_discrete_light* begin = &part->sample;
    const ty_vec off = source->kind == TY_DISCRETE_DIRECTIONAL ? ty_sub(begin->direction, source->direction)
                                                               : ty_sub(begin->position, source->position);
    return ty_dot(off, off);
}

static ty_dom_light_cluster* find_part(const ty_dom* light, const ty_discrete_light* source) {
    ty_dom_light_cluster* nearest = NULL;
    float least = INFINITY;
    for (int32_t i = 0; i < light->cluster_count; ++i) {
        ty_dom_light_cluster* part = &light->clusters[i];
        if (part->sample.light != source->light || part->sample.kind != source->kind) continue;
        const float distance = distance_to(part, source);
        if (distance >= least) continue;
        least = distance;
        nearest = part;
    }
    return nearest;
}

void ty_dom_clusters_add(ty_dom_job* job, const ty_discrete_light* source, int32_t planes, float* const fluence[3]) {
    const ty_dom* light = job->light;
    ty_dom_light_cluster* part = find_part(light, source);
    const float brightness = brightness_of(source), factor = planes == 1 ? brightness : 1;
    for (int32_t p = 0; p < planes; ++p)
        for (size_t i = 0; i < light->cells; ++i) part->fluence[p][i] += factor * fluence[p][i];
    const ty_vec at = part->sample.kind == TY_DISCRETE_DIRECTIONAL ? ty_scale(source->direction, source->mean_cosine)
                                                                   : source->position;
    part->weighted_sum = ty_mad(part->weighted_sum, at, brightness);
    part->sample.area += source->area;
    part->brightness += brightness;
    for (int c = 0; c < 3; ++c) part->sample.color[c] += source->color[c];
}

/* Planes of light as if it had come with color 1. */
static void scale_planes(ty_dom* light, ty_dom_light_cluster* part) {
    for (int32_t p = 0; p < light->cluster_planes; ++p) {
        const float all = light->cluster_planes == 1 ? part->brightness : part->sample.color[p];
        const float factor = all > 0 ? 1 / all : 0;
        for (size_t i = 0; i < light->cells; ++i) part->fluence[p][i] *= factor;
    }
}

void ty_dom_clusters_end(ty_dom_job* job) {
    ty_dom* light = job->light;
    for (int32_t i = 0; i < light->cluster_count; ++i) {
        ty_dom_light_cluster* part = &light->clusters[i];
        if (!(part->brightness > 0)) continue;
        scale_planes(light, part);
        const ty_vec mean = ty_scale(part->weighted_sum, 1 / part->brightness);
        part->sample.mean_cosine = 1;
        if (part->sample.kind == TY_DISCRETE_POINT) {
            part->sample.position = mean;
            continue;
        }
        const float length = sqrtf(ty_dot(mean, mean));
        part->sample.mean_cosine = length;
        part->sample.direction = length > 0 ? ty_scale(mean, 1 / length) : mean;
    }
}

/* ---- seeing ---- */

typedef struct send_job {
    const ty_dom* light;
    const ty_dom_environment* sky;
    const double* eye;
    int32_t channels;
    float* const* sent;
    float* const* all;
} send_job;

/* Where a part's light goes in a cell, the mean cosine about that, and its fluence without media. */
typedef struct arrival {
    ty_vec way;
    float cosine, bare;
} arrival;

static arrival arrive(const ty_dom* light, const ty_dom_light_cluster* part, const int32_t cell[3]) {
    if (part->sample.kind == TY_DISCRETE_DIRECTIONAL)
        return (arrival){part->sample.direction, part->sample.mean_cosine, 1};
    float at[3];
    for (int a = 0; a < 3; ++a)
        at[a] = (float)(light->box.lower[a] +
                        (light->box.upper[a] - light->box.lower[a]) * (cell[a] + 0.5) / light->box.size[a]);
    const ty_vec off = ty_sub(ty_vec_load(at), part->sample.position);
    const float square = ty_maxf(1e-12f, ty_dot(off, off));
    const float cap = ty_minf(2 * TY_PI, part->sample.area / square);
    return (arrival){ty_scale(off, 1 / sqrtf(square)), 1 - cap * TY_INV_4PI, 1 / square};
}

/* What arrives of a part's light, as shares of its fluence without media. */
static ty_forward forward_of(const ty_dom* light, int32_t plane, float fluence, const arrival* from) {
    const float kept = ty_minf(1, fluence / from->bare);
    return (ty_forward){.straight = powf(kept, light->unscattered_ratio[plane]),
                        .kept = kept,
                        .bent = powf(kept, light->next_order_ratio[plane]),
                        .cosine = from->cosine};
}

/* What of a part's light a cell sends along a way per scattering coefficient, times 4 pi. */
static float turn(const ty_dom* light, const ty_forward* forward, float mu, float g) {
    float turned = ty_forward_unscattered(*forward, mu, g);
    if (light->has_lobes) turned += ty_forward_scattered_order(*forward, mu, g * forward->cosine, light->bands);
    return 4 * TY_PI * turned;
}

/* Where a cell's g is not the mean that weights of parts are for: about what that changes. */
static float other_lobe(float mu, float g, float mean, float cosine) {
    if (fabsf(g - mean) < 1e-4f) return 1;
    return ty_minf(most_ratio, ty_hg(mu, g * cosine) / ty_hg(mu, mean * cosine));
}

/* Adds what a part sends along a way from a cell, and its fluence there. */
static void add_part(const send_job* job, int32_t index, const int32_t cell[3], size_t at, ty_vec way,
                     const ty_dom_environment_view* view, float sent[3], float all[3]) {
    const ty_dom* light = job->light;
    const ty_dom_light_cluster* part = &light->clusters[index];
    const arrival from = arrive(light, part, cell);
    const float mu = ty_dot(from.way, way);
    for (int32_t p = 0; p < light->cluster_planes; ++p) {
        const float fluence = part->fluence[p][at], g = light->g[p][at];
        if (!(fluence > 0)) continue;
        const ty_forward forward = forward_of(light, p, fluence, &from);
        const float over = fluence / forward.kept;
        const float turned = part->environment ? over * other_lobe(mu, g, light->mean_g[p], part->sample.mean_cosine)
                                               : over * turn(light, &forward, mu, g);
        for (int32_t c = p; c < (light->cluster_planes == 1 ? 3 : p + 1); ++c) {
            sent[c] += turned * (part->environment ? ty_dom_environment_radiance(view, index, c, &forward)
                                                   : part->sample.color[c]);
            all[c] += part->sample.color[c] * fluence;
        }
    }
}

static void send_cell(const send_job* job, const int32_t cell[3], size_t at) {
    const ty_dom* light = job->light;
    double way[3];
    float sent[3] = {0}, all[3] = {0};
    ty_dom_environment_view view = {.share = {0}};
    ty_dom_direction_to_eye(light, cell, job->eye, way);
    const ty_vec to_eye = ty_vec_make((float)way[0], (float)way[1], (float)way[2]);
    if (job->sky->weights != NULL) ty_dom_environment_lookup(light, job->sky, to_eye, &view);
    for (int32_t i = 0; i < light->cluster_count; ++i) add_part(job, i, cell, at, to_eye, &view, sent, all);
    for (int32_t c = 0; c < job->channels; ++c) {
        job->sent[c][at] = job->channels == 3 ? sent[c] : sent[0] + sent[1] + sent[2];
        job->all[c][at] = job->channels == 3 ? all[c] : all[0] + all[1] + all[2];
    }
}

static void send_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const send_job* job = user;
    const int32_t* size = job->light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        send_cell(job, cell, (size_t)row * (size_t)size[0] + (size_t)i);
    }
}

ty_result ty_dom_evaluate_clusters(const ty_dom* light, const double eye[3], int32_t channels, float* const sent[3],
                                   float* const all[3]) {
    ty_dom_environment sky;
    const ty_result result = ty_dom_environment_evaluate(light, eye, &sky);
    send_job job = {light, &sky, eye, channels, sent, all};
    if (result == TY_OK)
        ty_parallel_for(light->context, (int64_t)light->box.size[1] * light->box.size[2], send_row, &job);
    ty_dom_environment_free(light, &sky);
    return result;
}
