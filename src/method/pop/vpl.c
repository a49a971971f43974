/* Virtual point lights, chosen from reflective shadow maps. */
#include "method/pop/ordinate.h"

#include "base/context.h"
#include "base/random.k.h"
#include "direct/shadow_map.h"
#include "scene/scene.h"

/* Surfaces farther from the medium than this many of its longest sides are left out of directional lights' maps. */
static const double REACH = 8;

/* Lights whose maps are of full size; more of them share as many texels. */
enum { FULL_MAPS = 16, LEAST_SIDE = 16 };

typedef struct vpl_list {
    const ty_scene* scene;
    const ty_pop_def* def;
    const ty_grid_medium* medium;
    ty_shadow_map** maps;
    int32_t map_count;
    ty_vec corners[8], middle; /* of the medium's box */
    float longest;             /* side of it, m */
    ty_pop_ordinate* items;
    int32_t count;
} vpl_list;

/* All of the texels' weight, cut into as many equal shares as there shall be VPLs; where the way through it is. */
typedef struct walk {
    double total, at;
    int32_t shares;
    int32_t share;                      /* the one that is being gathered */
    double flux[3], solid_angle;        /* of it so far; as seen from the medium, sr */
    const ty_shadow_texel* chosen;      /* of it; NULL: not met yet */
    const ty_shadow_texel* chosen_last; /* of the VPL before */
    int32_t light;                      /* that lights the chosen one */
} walk;

static bool casts(const ty_light_view* light) {
    const bool kind = light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_POINT || light->kind == TY_KIND_SPOT;
    return kind && light->color[0] + light->color[1] + light->color[2] > 0;
}

/* ---- how much a texel matters ---- */

/* Per watt: the cosine law towards the medium, not below a tenth, and the square of the distance, not within the
 * medium's size. 0: the surface faces away from all of it. */
static float reach_of(const vpl_list* list, const ty_shadow_texel* texel) {
    bool faces = false;
    for (int32_t i = 0; i < 8; ++i) faces |= ty_dot(ty_sub(list->corners[i], texel->position), texel->normal) > 0.0f;
    if (!faces) return 0.0f;
    const ty_vec off = ty_sub(list->middle, texel->position);
    const float distance2 = ty_maxf(ty_dot(off, off), 0.25f * list->longest * list->longest);
    const float cosine = ty_dot(off, texel->normal) / sqrtf(distance2);
    return ty_maxf(0.1f, cosine) / distance2;
}

static double weight_of(const vpl_list* list, const ty_shadow_texel* texel) {
    const float bright = 0.2126f * texel->flux[0] + 0.7152f * texel->flux[1] + 0.0722f * texel->flux[2];
    return bright > 0.0f ? (double)(bright * reach_of(list, texel)) : 0;
}

/* ---- all texels in an order that keeps neighbours together ---- */

typedef void (*visit_fn)(vpl_list* list, const ty_shadow_map* map, const ty_shadow_texel* texel, walk* way);

static uint32_t even_bits(uint32_t x) {
    uint32_t out = 0;
    for (int32_t bit = 0; bit < 16; ++bit) out |= (x >> 2 * bit & 1u) << bit;
    return out;
}

/* Along Morton's curve. */
static void visit_map(vpl_list* list, const ty_shadow_map* map, visit_fn visit, walk* way) {
    uint32_t padded = 1;
    while (padded < (uint32_t)map->side) padded *= 2;
    for (int32_t face = 0; face < map->faces; ++face)
        for (uint32_t i = 0; i < padded * padded; ++i) {
            const uint32_t x = even_bits(i), y = even_bits(i >> 1);
            if (x >= (uint32_t)map->side || y >= (uint32_t)map->side) continue;
            const size_t side = (size_t)map->side;
            visit(list, map, &map->texels[x + side * (y + side * (size_t)face)], way);
        }
}

static void visit_all(vpl_list* list, visit_fn visit, walk* way) {
    for (int32_t i = 0; i < list->map_count; ++i) visit_map(list, list->maps[i], visit, way);
}

static void weigh(vpl_list* list, const ty_shadow_map* map, const ty_shadow_texel* texel, walk* way) {
    (void)map;
    way->total += weight_of(list, texel);
}

/* ---- VPLs ---- */

/* Light of a share comes, for the medium, from as much of the sphere as its surfaces take of it: its mean cosine is
 * 1 - w / N as for environments, with w / N that part. */
static float cosine_of(const vpl_list* list, double solid_angle) {
    return (float)pow(1 - fmin(1, solid_angle / (4 * 3.14159265358979323846)), list->def->prefilter);
}

static void finish_share(vpl_list* list, walk* way) {
    if (way->chosen == NULL) return;
    const float per_pi = 1.0f / TY_PI;
    if (way->chosen == way->chosen_last) { /* a texel of several shares is one VPL */
        for (int c = 0; c < 3; ++c) list->items[list->count - 1].color[c] += (float)way->flux[c] * per_pi;
    } else {
        ty_pop_ordinate* vpl = &list->items[list->count++];
        *vpl = (ty_pop_ordinate){.kind = TY_POP_RADIAL,
                                 .direction = way->chosen->normal,
                                 .position = way->chosen->position,
                                 .cosine = cosine_of(list, way->solid_angle),
                                 .least = (float)fmax(list->def->clamp, 1e-3) * list->longest,
                                 .profile = TY_POP_COSINE,
                                 .light = way->light,
                                 .shadowed = 1};
        for (int c = 0; c < 3; ++c) vpl->color[c] = (float)way->flux[c] * per_pi;
    }
    way->chosen_last = way->chosen;
    way->chosen = NULL;
    way->solid_angle = way->flux[0] = way->flux[1] = way->flux[2] = 0;
}

/* Where in a share its VPL is chosen. */
static double place_in(const vpl_list* list, int32_t share) {
    const uint64_t bits = ty_mix64(list->def->seed + 0x9e3779b97f4a7c15u * ((uint64_t)share + 1));
    return share + (double)ty_unit_float((uint32_t)(bits >> 32));
}

/* Hands a texel's light out to the shares that it lies in. */
static void gather(vpl_list* list, const ty_shadow_map* map, const ty_shadow_texel* texel, walk* way) {
    const double weight = weight_of(list, texel), per_share = way->total / way->shares;
    if (!(weight > 0)) return;
    const ty_vec off = ty_sub(list->middle, texel->position);
    const double distance2 = fmax((double)ty_dot(off, off), 0.25 * (double)(list->longest * list->longest));
    const double facing = fmax(0, (double)ty_dot(off, texel->normal)) / sqrt(distance2);
    const double end = way->at + weight;
    while (way->at < end) {
        const bool last = way->share + 1 == way->shares;
        const double stop = last ? end : fmin(end, per_share * (way->share + 1));
        const double part = fmax(0, stop - way->at) / weight;
        const bool first = way->chosen == NULL; /* rounding may miss the place, but no share goes without */
        if (first || per_share * place_in(list, way->share) >= way->at) {
            way->chosen = texel;
            way->light = map->light;
        }
        for (int c = 0; c < 3; ++c) way->flux[c] += part * (double)texel->flux[c];
        way->solid_angle += part * facing * (double)texel->area / distance2;
        way->at = stop;
        if (last || stop < per_share * (way->share + 1)) break;
        finish_share(list, way);
        ++way->share;
    }
    way->at = end;
}

static void choose(vpl_list* list) {
    walk way = {.shares = list->def->vpls};
    visit_all(list, weigh, &way);
    if (!(way.total > 0)) return;
    visit_all(list, gather, &way);
    finish_share(list, &way);
}

/* ---- maps ---- */

static void measure_box(vpl_list* list) {
    const ty_grid_box* box = &list->medium->box;
    list->middle =
        ty_vec_make((float)(0.5 * (box->lower[0] + box->upper[0])), (float)(0.5 * (box->lower[1] + box->upper[1])),
                    (float)(0.5 * (box->lower[2] + box->upper[2])));
    for (int32_t i = 0; i < 8; ++i)
        list->corners[i] = ty_vec_make((float)((i & 1) != 0 ? box->upper[0] : box->lower[0]),
                                       (float)((i & 2) != 0 ? box->upper[1] : box->lower[1]),
                                       (float)((i & 4) != 0 ? box->upper[2] : box->lower[2]));
    for (int a = 0; a < 3; ++a) list->longest = ty_maxf(list->longest, (float)(box->upper[a] - box->lower[a]));
}

static int32_t side_of(const ty_pop_def* def, int32_t lights) {
    if (lights <= FULL_MAPS) return def->shadow_texels;
    const double share = sqrt((double)FULL_MAPS / lights);
    return (int32_t)fmax(LEAST_SIDE, def->shadow_texels * share);
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

/* What reaches surfaces in a split is light that keeps its direction: it is attenuated as ordinates are. */
static ty_result make_attenuated_maps(vpl_list* list, int32_t lights) {
    const ty_grid_medium* medium = list->medium;
    ty_context* context = medium->context;
    if (list->def->mode != TY_POP_MODE_SPLIT) return make_maps(list, lights, NULL);
    const size_t floats = medium->cells * (size_t)medium->planes;
    float* reduced = ty_alloc_array(context, floats, sizeof *reduced, false);
    if (reduced == NULL) return TY_ERROR_MEMORY;
    float* planes[3] = {reduced, NULL, NULL};
    for (int32_t c = 1; c < medium->planes; ++c) planes[c] = reduced + medium->cells * (size_t)c;
    ty_grid_medium_reduce(medium, 1, planes);
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
    if (result == TY_OK) choose(list);
    for (int32_t i = 0; i < list->map_count; ++i) ty_shadow_map_destroy(list->maps[i]);
    ty_free_array(context, list->maps, (size_t)lights, sizeof *list->maps);
    return result;
}

ty_result ty_pop_vpls_create(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium,
                             ty_pop_ordinate** out, int32_t* count) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    vpl_list list = {.scene = scene, .def = def, .medium = medium};
    int32_t lights = 0;
    for (int32_t i = 0; i < view->lights.count; ++i) lights += casts(&view->lights.lights[i]);
    list.items = ty_alloc_array(scene->context, (size_t)def->vpls, sizeof *list.items, false);
    if (list.items == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    if (view->mesh != NULL && lights > 0 && def->vpls > 0) result = find_vpls(&list, lights);
    if (result == TY_OK)
        return ty_pop_ordinates_hand_over(scene->context, list.items, def->vpls, list.count, out, count);
    ty_free_array(scene->context, list.items, (size_t)def->vpls, sizeof *list.items);
    return result;
}
