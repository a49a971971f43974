/* Virtual point lights, chosen from reflective shadow maps. */
#include "direct/vpl.h"

#include "base/context.h"
#include "direct/shadow_map.h"
#include "scene/scene.h"

/* Surfaces farther from the medium than this many of its longest sides are left out of directional lights' maps. */
static const double REACH = 8;

/* Lights whose maps are of full size; more of them share as many texels. */
enum { FULL_MAPS = 16, LEAST_SIDE = 16 };

/* What texels are sorted by: positions in sides of the medium's box, and normals, of which opposite ones are a side
 * apart. */
enum { KEYS = 6 };

/* A texel whose light can meet the medium. */
typedef struct vpl_texel {
    const ty_shadow_texel* texel;
    float key[KEYS];
    int32_t light;
    double weight; /* luminance as far as it matters to the medium */
} vpl_texel;

/* Sums over the texels that a VPL stands for. */
typedef struct vpl_share {
    double flux[3];
    double solid_angle;      /* of its surfaces, as seen from the medium, sr */
    double place[3], bright; /* sums of luminance times position, and of luminance */
} vpl_share;

typedef struct vpl_list {
    const ty_scene* scene;
    const ty_vpl_def* def;
    const ty_grid_medium* medium;
    ty_shadow_map** maps;
    int32_t map_count;
    ty_vec middle, half; /* of the medium's box */
    float longest;       /* side of it, m */
    vpl_texel* texels;
    size_t texel_count;
    ty_light_part* items;
    int32_t count;
} vpl_list;

static bool casts(const ty_light_view* light) {
    const bool kind = light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT;
    return kind && light->color[0] + light->color[1] + light->color[2] > 0;
}

/* ---- texels that matter ---- */

static float luminance(const ty_shadow_texel* texel) {
    return 0.2126f * texel->flux[0] + 0.7152f * texel->flux[1] + 0.0722f * texel->flux[2];
}

static double distance2_of(const vpl_list* list, ty_vec off) {
    return fmax((double)ty_dot(off, off), 0.25 * (double)(list->longest * list->longest));
}

/* Luminance, times the cosine law towards the medium, not below a tenth, over the square of the distance, not within
 * the medium's size; 0 where the surface faces away from all of it. */
static double weight_of(const vpl_list* list, const ty_shadow_texel* texel) {
    const ty_vec off = ty_sub(list->middle, texel->position), n = texel->normal, half = list->half;
    const float bright = luminance(texel);
    const float along = ty_dot(off, n), reach = fabsf(n.x) * half.x + fabsf(n.y) * half.y + fabsf(n.z) * half.z;
    if (!(bright > 0.0f) || !(along + reach > 0.0f)) return 0;
    const double distance2 = distance2_of(list, off);
    return (double)bright * fmax(0.1, (double)along / sqrt(distance2)) / distance2;
}

static void list_map(vpl_list* list, const ty_shadow_map* map) {
    const size_t count = ty_shadow_map_count(map);
    for (size_t i = 0; i < count; ++i) {
        const double weight = weight_of(list, &map->texels[i]);
        if (!(weight > 0)) continue;
        const ty_vec p = ty_scale(map->texels[i].position, 1 / list->longest), n = map->texels[i].normal;
        list->texels[list->texel_count++] =
            (vpl_texel){&map->texels[i], {p.x, p.y, p.z, 0.5f * n.x, 0.5f * n.y, 0.5f * n.z}, map->light, weight};
    }
}

/* ---- shares: texels near one another that face alike ---- */

/* Along which key texels differ most; *total: of their weights. */
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
    const vpl_texel kept = *a;
    *a = *b;
    *b = kept;
}

/* Brings texels into order along a key as far as it takes to find how many of the first have a weight together. */
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

static void add_to_share(const vpl_list* list, const ty_shadow_texel* texel, vpl_share* share) {
    const ty_vec off = ty_sub(list->middle, texel->position);
    const double bright = (double)luminance(texel), distance2 = distance2_of(list, off);
    const double facing = fmax(0, (double)ty_dot(off, texel->normal)) / sqrt(distance2);
    for (int c = 0; c < 3; ++c) share->flux[c] += (double)texel->flux[c];
    share->solid_angle += facing * (double)texel->area / distance2;
    share->place[0] += bright * (double)texel->position.x;
    share->place[1] += bright * (double)texel->position.y;
    share->place[2] += bright * (double)texel->position.z;
    share->bright += bright;
}

/* The texel next to the middle of their light. */
static const vpl_texel* nearest_of(const vpl_share* share, const vpl_texel* texels, size_t count) {
    const vpl_texel* nearest = texels;
    double least = INFINITY;
    for (size_t i = 0; i < count; ++i) {
        const ty_vec at = texels[i].texel->position;
        const double off[3] = {(double)at.x - share->place[0] / share->bright,
                               (double)at.y - share->place[1] / share->bright,
                               (double)at.z - share->place[2] / share->bright};
        const double distance2 = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        if (!(distance2 < least)) continue;
        least = distance2;
        nearest = &texels[i];
    }
    return nearest;
}

/* Light of a share comes, for the medium, from as much of the sphere as its surfaces take of it: its mean cosine is
 * 1 - w / N as for environments, with w / N that part. */
static float cosine_of(const vpl_list* list, double solid_angle) {
    return (float)pow(1 - fmin(1, solid_angle / (4 * 3.14159265358979323846)), list->def->prefilter);
}

static void add_vpl(vpl_list* list, const vpl_texel* texels, size_t count) {
    vpl_share share = {.bright = 0};
    for (size_t i = 0; i < count; ++i) add_to_share(list, texels[i].texel, &share);
    const vpl_texel* nearest = nearest_of(&share, texels, count);
    ty_light_part* vpl = &list->items[list->count++];
    *vpl = (ty_light_part){.kind = TY_LIGHT_PART_RADIAL,
                           .direction = nearest->texel->normal,
                           .position = nearest->texel->position,
                           .cosine = cosine_of(list, share.solid_angle),
                           .least = (float)fmax(list->def->clamp, 1e-3) * list->longest,
                           .profile = TY_LIGHT_PART_COSINE,
                           .light = nearest->light,
                           .shadowed = 1};
    for (int c = 0; c < 3; ++c) vpl->color[c] = (float)share.flux[c] / TY_PI;
}

/* Shares texels out among `wanted` VPLs, by halves. */
static void share_out(vpl_list* list, vpl_texel* texels, size_t count, size_t wanted) {
    if (wanted <= 1) {
        add_vpl(list, texels, count);
        return;
    }
    double total;
    const size_t first = wanted / 2, second = wanted - first;
    const int32_t key = widest_key(texels, count, &total);
    size_t split = split_by_weight(texels, count, key, total * (double)first / (double)wanted);
    split = split < first ? first : count - split < second ? count - second : split;
    share_out(list, texels, split, first);
    share_out(list, texels + split, count - split, second);
}

static ty_result choose_vpls(vpl_list* list) {
    ty_context* context = list->scene->context;
    const size_t wanted = (size_t)list->def->count;
    size_t texels = 0;
    for (int32_t i = 0; i < list->map_count; ++i) texels += ty_shadow_map_count(list->maps[i]);
    list->texels = ty_alloc_array(context, texels, sizeof *list->texels, false);
    if (list->texels == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < list->map_count; ++i) list_map(list, list->maps[i]);
    if (list->texel_count > 0)
        share_out(list, list->texels, list->texel_count, wanted < list->texel_count ? wanted : list->texel_count);
    ty_free_array(context, list->texels, texels, sizeof *list->texels);
    return TY_OK;
}

/* ---- maps ---- */

static void measure_box(vpl_list* list) {
    const ty_grid_box* box = &list->medium->box;
    float middle[3], half[3];
    for (int a = 0; a < 3; ++a) {
        middle[a] = (float)(0.5 * (box->lower[a] + box->upper[a]));
        half[a] = (float)(0.5 * (box->upper[a] - box->lower[a]));
        list->longest = ty_maxf(list->longest, 2 * half[a]);
    }
    list->middle = ty_vec_load(middle);
    list->half = ty_vec_load(half);
}

static int32_t side_of(const ty_vpl_def* def, int32_t lights) {
    if (lights <= FULL_MAPS) return def->texels;
    const double share = sqrt((double)FULL_MAPS / lights);
    return (int32_t)fmax(LEAST_SIDE, def->texels * share);
}

static ty_result make_maps(vpl_list* list, int32_t lights, float* const* extinction) {
    const ty_light_set* set = &list->scene->view.lights;
    double lower[3], upper[3];
    for (int a = 0; a < 3; ++a) {
        lower[a] = list->medium->box.lower[a] - REACH * (double)list->longest;
        upper[a] = list->medium->box.upper[a] + REACH * (double)list->longest;
    }
    const ty_shadow_map_def def = {.side = side_of(list->def, lights),
                                   .medium = list->medium,
                                   .extinction = extinction,
                                   .lower = lower,
                                   .upper = upper,
                                   .seed = list->def->seed};
    for (int32_t i = 0; i < set->count; ++i) {
        if (!casts(&set->lights[i])) continue;
        const ty_result result = ty_shadow_map_create(list->scene, &def, i, &list->maps[list->map_count]);
        if (result != TY_OK) return result;
        ++list->map_count;
    }
    return TY_OK;
}

/* What reaches surfaces is all light that keeps its direction, where media are reduced. */
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
    for (int32_t i = 0; i < list->map_count; ++i) ty_shadow_map_destroy(list->maps[i]);
    ty_free_array(context, list->maps, (size_t)lights, sizeof *list->maps);
    return result;
}

/* Sec. 6 (Elek 2014). */
ty_result ty_vpls_create(const ty_scene* scene, const ty_vpl_def* def, const ty_grid_medium* medium,
                         ty_light_part** out, int32_t* count) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    vpl_list list = {.scene = scene, .def = def, .medium = medium};
    int32_t lights = 0;
    for (int32_t i = 0; i < view->lights.count; ++i) lights += casts(&view->lights.lights[i]);
    list.items = ty_alloc_array(scene->context, (size_t)def->count, sizeof *list.items, false);
    if (list.items == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    if (view->mesh != NULL && lights > 0 && def->count > 0) result = find_vpls(&list, lights);
    if (result == TY_OK) return ty_light_parts_trim(scene->context, list.items, def->count, list.count, out, count);
    ty_free_array(scene->context, list.items, (size_t)def->count, sizeof *list.items);
    return result;
}
