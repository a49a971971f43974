/* Virtual point lights, clustered from samples of the surfaces that the lights reach first. */
#include "direct/lights/vpl.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/luminance.k.h"
#include "direct/lights/vpl_samples.h"
#include "scene/scene.h"

/* Directional lights sample only surfaces within this multiple of the medium's longest side. */
static const double MAX_DISTANCE = 8;

/* Number of lights up to which each has the full number of samples; more lights share that total. */
enum { FULL_MAPS = 16, MIN_SIDE = 16 };

/* Dimensions that texels are clustered in: positions in units of the box's longest side, and normals, scaled so that
 * opposite ones are 1 apart. */
enum { KEYS = 6 };

/* A texel that faces the medium. */
typedef struct vpl_texel {
    const ty_vpl_sample* texel;
    float key[KEYS];
    int32_t light;
    double weight; /* luminance times cosine over square distance */
} vpl_texel;

/* Sums over the texels of one VPL. */
typedef struct cluster {
    double flux[3];
    double solid_angle;                    /* of its surfaces as seen from the medium, sr */
    double position_sum[3], luminance_sum; /* sum of luminance times position, and of luminance */
} cluster;

typedef struct vpl_list {
    const ty_scene* scene;
    const ty_vpl_def* def;
    const ty_grid_medium* medium;
    ty_vpl_samples** maps;
    int32_t map_count;
    ty_vec center, half_side; /* of the medium's box */
    float longest;            /* longest side, m */
    vpl_texel* texels;
    size_t texel_count;
    ty_discrete_light_set* out;
} vpl_list;

static bool is_mapped(const ty_light_view* light) {
    const bool kind = light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT;
    return kind && light->color[0] + light->color[1] + light->color[2] > 0;
}

/* ---- texels that matter ---- */

static float luminance(const ty_vpl_sample* texel) {
    return ty_luminance(texel->flux[0], texel->flux[1], texel->flux[2]);
}

static double clamped_square_distance(const vpl_list* list, ty_vec off) {
    return fmax((double)ty_dot(off, off), 0.25 * (double)(list->longest * list->longest));
}

/* Luminance times the cosine towards the medium (at least 0.1) over the square of the distance (at least half of the
 * box); 0 where the surface faces away from the whole box. */
static double weight_of(const vpl_list* list, const ty_vpl_sample* texel) {
    const ty_vec off = ty_sub(list->center, texel->position), n = texel->normal, half_side = list->half_side;
    const float luminance_sum = luminance(texel);
    const float along = ty_dot(off, n),
                reach = fabsf(n.x) * half_side.x + fabsf(n.y) * half_side.y + fabsf(n.z) * half_side.z;
    if (!(luminance_sum > 0.0f) || !(along + reach > 0.0f)) return 0;
    const double distance2 = clamped_square_distance(list, off);
    return (double)luminance_sum * fmax(0.1, (double)along / sqrt(distance2)) / distance2;
}

static void list_samples(vpl_list* list, const ty_vpl_samples* samples) {
    const size_t count = ty_vpl_samples_count(samples);
    for (size_t i = 0; i < count; ++i) {
        const double weight = weight_of(list, &samples->items[i]);
        if (!(weight > 0)) continue;
        const ty_vec p = ty_scale(samples->items[i].position, 1 / list->longest), n = samples->items[i].normal;
        list->texels[list->texel_count++] = (vpl_texel){
            &samples->items[i], {p.x, p.y, p.z, 0.5f * n.x, 0.5f * n.y, 0.5f * n.z}, samples->light, weight};
    }
}

/* ---- clusters of texels ---- */

/* The key with the largest weighted variance. *total: sum of the weights. */
static int32_t widest_key(const vpl_texel* texels, size_t count, double* total) {
    double sum[KEYS] = {0}, square[KEYS] = {0};
    int32_t widest = 0;
    *total = 0;
    for (size_t i = 0; i < count; ++i) {
        *total += texels[i].weight;
        for (int32_t k = 0; k < KEYS; ++k) {
            const double key = (double)texels[i].key[k];
            sum[k] += texels[i].weight * key;
            square[k] += texels[i].weight * key * key;
        }
    }
    for (int32_t k = 0; k < KEYS; ++k) {
        square[k] -= sum[k] * sum[k] / *total;
        if (square[k] > square[widest]) widest = k;
    }
    return widest;
}

static void swap(vpl_texel* a, vpl_texel* b) {
    const vpl_texel swapped = *a;
    *a = *b;
    *b = swapped;
}

/* Partially sorts texels along a key (quickselect by weight); returns the number of texels with the given total weight.
 */
static size_t split_by_weight(vpl_texel* texels, size_t count, int32_t key, double weight) {
    size_t begin = 0, end = count;
    double passed = 0;
    while (end - begin > 1) {
        const float pivot = texels[begin + (end - begin) / 2].key[key];
        size_t below = begin, above = end, at = begin;
        double lower = 0, same = 0;
        while (at < above) {
            const float value = texels[at].key[key];
            if (value < pivot) {
                lower += texels[at].weight;
                swap(&texels[at++], &texels[below++]);
            } else if (value > pivot) {
                swap(&texels[at], &texels[--above]);
            } else {
                same += texels[at++].weight;
            }
        }
        if (passed + lower >= weight) {
            end = below;
        } else if (passed + lower + same < weight) {
            begin = above;
            passed += lower + same;
        } else {
            passed += lower;
            for (at = below; at < above && passed < weight; ++at) passed += texels[at].weight;
            return at;
        }
    }
    return begin;
}

/* ---- VPLs ---- */

static void add_to_cluster(const vpl_list* list, const ty_vpl_sample* texel, cluster* group) {
    const ty_vec off = ty_sub(list->center, texel->position);
    const double luminance_sum = (double)luminance(texel), distance2 = clamped_square_distance(list, off);
    const double facing = fmax(0, (double)ty_dot(off, texel->normal)) / sqrt(distance2);
    for (int c = 0; c < 3; ++c) group->flux[c] += (double)texel->flux[c];
    group->solid_angle += facing * (double)texel->area / distance2;
    group->position_sum[0] += luminance_sum * (double)texel->position.x;
    group->position_sum[1] += luminance_sum * (double)texel->position.y;
    group->position_sum[2] += luminance_sum * (double)texel->position.z;
    group->luminance_sum += luminance_sum;
}

/* The texel nearest to the luminance-weighted mean position. */
static const vpl_texel* nearest_of(const cluster* group, const vpl_texel* texels, size_t count) {
    const vpl_texel* nearest = texels;
    double min_square = INFINITY;
    for (size_t i = 0; i < count; ++i) {
        const ty_vec at = texels[i].texel->position;
        const double off[3] = {(double)at.x - group->position_sum[0] / group->luminance_sum,
                               (double)at.y - group->position_sum[1] / group->luminance_sum,
                               (double)at.z - group->position_sum[2] / group->luminance_sum};
        const double distance2 = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        if (!(distance2 < min_square)) continue;
        min_square = distance2;
        nearest = &texels[i];
    }
    return nearest;
}

/* Mean cosine 1 - w / N as for environments, w / N being the fraction of the sphere that the cluster's surfaces subtend
 * at the medium. */
static float cosine_of(const vpl_list* list, double solid_angle) {
    return (float)pow(1 - fmin(1, solid_angle / (4 * TY_PI_F64)), list->def->prefilter);
}

static void add_vpl(vpl_list* list, const vpl_texel* texels, size_t count) {
    cluster group = {.luminance_sum = 0};
    for (size_t i = 0; i < count; ++i) add_to_cluster(list, texels[i].texel, &group);
    const vpl_texel* nearest = nearest_of(&group, texels, count);
    const float min_distance = (float)fmax(list->def->clamp, 1e-3) * list->longest;
    ty_discrete_light* vpl = &list->out->items[list->out->count++];
    *vpl = (ty_discrete_light){.kind = TY_DISCRETE_POINT,
                               .direction = nearest->texel->normal,
                               .position = nearest->texel->position,
                               .mean_cosine = cosine_of(list, group.solid_angle),
                               .min_distance = min_distance,
                               .area = min_distance * min_distance,
                               .profile = TY_PROFILE_COSINE,
                               .light = nearest->light,
                               .is_virtual = 1,
                               .shadowed = 1};
    for (int c = 0; c < 3; ++c) vpl->color[c] = (float)group.flux[c] / TY_PI;
}

/* Partitions texels into max_count clusters of about equal weight, by recursive halving. */
static void split_texels(vpl_list* list, vpl_texel* texels, size_t count, size_t max_count) {
    if (max_count <= 1) {
        add_vpl(list, texels, count);
        return;
    }
    double total;
    const size_t first = max_count / 2, second = max_count - first;
    const int32_t key = widest_key(texels, count, &total);
    size_t split = split_by_weight(texels, count, key, total * (double)first / (double)max_count);
    split = split < first ? first : count - split < second ? count - second : split;
    split_texels(list, texels, split, first);
    split_texels(list, texels + split, count - split, second);
}

static ty_result choose_vpls(vpl_list* list) {
    ty_context* context = list->scene->context;
    const size_t max_count = (size_t)list->def->count;
    size_t texels = 0;
    for (int32_t i = 0; i < list->map_count; ++i) texels += ty_vpl_samples_count(list->maps[i]);
    list->texels = ty_alloc_array(context, texels, sizeof *list->texels, false);
    if (list->texels == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < list->map_count; ++i) list_samples(list, list->maps[i]);
    if (list->texel_count > 0)
        split_texels(list, list->texels, list->texel_count,
                     max_count < list->texel_count ? max_count : list->texel_count);
    ty_free_array(context, list->texels, texels, sizeof *list->texels);
    return TY_OK;
}

/* ---- maps ---- */

static void measure_box(vpl_list* list) {
    const ty_grid_box* box = &list->medium->box;
    float center[3], half_side[3];
    for (int a = 0; a < 3; ++a) {
        center[a] = (float)(0.5 * (box->lower[a] + box->upper[a]));
        half_side[a] = (float)(0.5 * (box->upper[a] - box->lower[a]));
        list->longest = ty_maxf(list->longest, 2 * half_side[a]);
    }
    list->center = ty_vec_load(center);
    list->half_side = ty_vec_load(half_side);
}

static int32_t side_of(const ty_vpl_def* def, int32_t lights) {
    if (lights <= FULL_MAPS) return def->texels;
    const double group = sqrt((double)FULL_MAPS / lights);
    return (int32_t)fmax(MIN_SIDE, def->texels * group);
}

static ty_result make_maps(vpl_list* list, int32_t lights, float* const* extinction) {
    const ty_light_set* set = &list->scene->view.lights;
    double lower[3], upper[3];
    for (int a = 0; a < 3; ++a) {
        lower[a] = list->medium->box.lower[a] - MAX_DISTANCE * (double)list->longest;
        upper[a] = list->medium->box.upper[a] + MAX_DISTANCE * (double)list->longest;
    }
    const ty_vpl_samples_def def = {.side = side_of(list->def, lights),
                                    .medium = list->medium,
                                    .extinction = extinction,
                                    .lower = lower,
                                    .upper = upper,
                                    .seed = list->def->seed};
    for (int32_t i = 0; i < set->count; ++i) {
        if (!is_mapped(&set->lights[i])) continue;
        const ty_result result = ty_vpl_samples_create(list->scene, &def, i, &list->maps[list->map_count]);
        if (result != TY_OK) return result;
        ++list->map_count;
    }
    return TY_OK;
}

/* The maps' light is attenuated by the delta-scaled extinction where list->def->reduced is set. */
static ty_result make_attenuated_maps(vpl_list* list, int32_t lights) {
    const ty_grid_medium* medium = list->medium;
    ty_context* context = medium->context;
    if (list->def->reduced == 0) return make_maps(list, lights, NULL);
    const size_t floats = medium->cells * (size_t)medium->planes;
    float* reduced = ty_alloc_array(context, floats, sizeof *reduced, false);
    if (reduced == NULL) return TY_ERROR_MEMORY;
    float* planes[3] = {reduced, NULL, NULL};
    for (int32_t c = 1; c < medium->planes; ++c) planes[c] = reduced + medium->cells * (size_t)c;
    ty_grid_medium_reduce(medium, list->def->reduced, planes);
    const ty_result result = make_maps(list, lights, planes);
    ty_free_array(context, reduced, floats, sizeof *reduced);
    return result;
}

static ty_result find_vpls(vpl_list* list, int32_t lights) {
    ty_context* context = list->scene->context;
    measure_box(list);
    list->maps = ty_alloc_array(context, (size_t)lights, sizeof *list->maps, true);
    if (list->maps == NULL) return TY_ERROR_MEMORY;
    ty_result result = make_attenuated_maps(list, lights);
    if (result == TY_OK) result = choose_vpls(list);
    for (int32_t i = 0; i < list->map_count; ++i) ty_vpl_samples_destroy(list->maps[i]);
    ty_free_array(context, list->maps, (size_t)lights, sizeof *list->maps);
    return result;
}

/* Sec. 6 (Elek 2014). */
ty_result ty_vpls_create(const ty_scene* scene, const ty_vpl_def* def, const ty_grid_medium* medium,
                         ty_discrete_light_set* out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    *out = (ty_discrete_light_set){.items = NULL};
    if (view == NULL) return TY_ERROR_ARGUMENT;
    vpl_list list = {.scene = scene, .def = def, .medium = medium, .out = out};
    int32_t lights = 0;
    for (int32_t i = 0; i < view->lights.count; ++i) lights += is_mapped(&view->lights.lights[i]);
    if (view->mesh == NULL || lights == 0 || def->count <= 0) return TY_OK;
    const ty_result result = ty_discrete_light_set_create(scene->context, "vpls", def->count, out);
    return result == TY_OK ? find_vpls(&list, lights) : result;
}
