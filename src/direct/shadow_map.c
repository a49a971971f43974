/* Reflective shadow maps. */
#include "direct/shadow_map.h"

#include "base/context.h"
#include "base/random.k.h"
#include "direct/beam.k.h"
#include "direct/grid_depth.h"
#include "direct/texels.h"
#include "scene/check.h"
#include "scene/scene.h"

enum { SIDE_MAX = 4096 };

typedef struct shadow_job {
    const ty_scene* scene;
    const ty_shadow_map_def* def;
    const ty_light_view* light;
    ty_shadow_map* map;
} shadow_job;

/* ---- where rays go ---- */

/* A place in a square, [-1, 1] each, to a place in a disc: radius and turn, areas kept in proportion (Shirley and Chiu
 * 1997). */
static void disc_of(float a, float b, float* radius, float* turn) {
    const bool wide = fabsf(a) > fabsf(b);
    const float long_side = wide ? a : b;
    const float eighth = long_side != 0.0f ? 0.125f * (wide ? b : a) / long_side : 0.0f;
    const float raw = (wide ? eighth : 0.25f - eighth) + (long_side < 0.0f ? 0.5f : 0.0f);
    *radius = fabsf(long_side);
    *turn = raw - floorf(raw);
}

static ty_vec direction_in_cone(const ty_shadow_map* map, int32_t face, float x, float y) {
    float radius, turn, sine, cosine;
    disc_of(2.0f * x - 1.0f, 2.0f * y - 1.0f, &radius, &turn);
    ty_sincos_2pi(turn, &sine, &cosine);
    const float down = map->cap * radius * radius, across = sqrtf(ty_maxf(0.0f, down * (2.0f - down)));
    const ty_vec along = ty_scale(map->axis[2], face == 0 ? 1.0f - down : down - 1.0f);
    return ty_normalize(ty_mad(ty_mad(along, map->axis[0], across * cosine), map->axis[1], across * sine));
}

size_t ty_shadow_map_count(const ty_shadow_map* map) {
    return (size_t)map->faces * (size_t)map->side * (size_t)map->side;
}

void ty_shadow_map_ray(const ty_shadow_map* map, size_t texel, ty_vec* origin, ty_vec* direction) {
    const size_t side = (size_t)map->side;
    const uint64_t bits = ty_mix64(map->seed + 0x9e3779b97f4a7c15u * (texel + 1));
    const float x = ((float)(texel % side) + ty_unit_float((uint32_t)bits)) / (float)side;
    const float y = ((float)(texel / side % side) + ty_unit_float((uint32_t)(bits >> 32))) / (float)side;
    *origin = map->origin;
    *direction = map->axis[2];
    if (map->parallel != 0)
        *origin = ty_mad(ty_mad(map->origin, map->axis[0], x * map->span[0]), map->axis[1], y * map->span[1]);
    else
        *direction = direction_in_cone(map, (int32_t)(texel / (side * side)), x, y);
}

/* ---- where maps lie ---- */

/* Where rays start: before all surfaces and the medium. */
static double start_of(const shadow_job* job, const double lower[3], const double upper[3]) {
    double range[2], other[2];
    ty_texels_extent(job->map->axis[2], lower, upper, range);
    if (job->def->medium != NULL) {
        ty_texels_extent(job->map->axis[2], job->def->medium->box.lower, job->def->medium->box.upper, other);
        range[0] = fmin(range[0], other[0]);
        range[1] = fmax(range[1], other[1]);
    }
    return range[0] - 1e-3 * (range[1] - range[0]) - 1e-6;
}

/* false: the box that is asked for has no surfaces. */
static bool place_parallel(const shadow_job* job) {
    ty_shadow_map* map = job->map;
    double lower[3], upper[3], along[3];
    ty_scene_surface_extent(job->scene, lower, upper);
    along[2] = start_of(job, lower, upper);
    for (int a = 0; a < 3 && job->def->lower != NULL; ++a) {
        lower[a] = fmax(lower[a], job->def->lower[a]);
        upper[a] = fmin(upper[a], job->def->upper[a]);
        if (lower[a] > upper[a]) return false;
    }
    map->origin = ty_vec_make(0, 0, 0);
    for (int a = 0; a < 2; ++a) {
        double range[2];
        ty_texels_extent(map->axis[a], lower, upper, range);
        map->span[a] = (float)(range[1] - range[0]);
        along[a] = range[0];
    }
    for (int a = 0; a < 3; ++a) map->origin = ty_mad(map->origin, map->axis[a], (float)along[a]);
    map->share = map->span[0] * map->span[1] / ((float)map->side * (float)map->side);
    return true;
}

static void place_cone(const shadow_job* job) {
    ty_shadow_map* map = job->map;
    map->origin = job->light->position;
    map->cap = job->light->kind == TY_KIND_SPOT ? 1.0f - job->light->cos_outer : 1.0f;
    map->share = 2.0f * TY_PI * map->cap / ((float)map->side * (float)map->side);
}

/* ---- what they meet ---- */

/* Light that comes along a texel's ray, W. */
static void find_light(const shadow_job* job, ty_vec origin, ty_vec direction, float distance, float light[3]) {
    const ty_shadow_map_def* def = job->def;
    float depth[3] = {0, 0, 0}, falloff = job->map->share;
    if (def->medium != NULL) ty_grid_depth(def->medium, def->extinction, origin, direction, distance, depth);
    if (job->light->kind == TY_KIND_SPOT)
        falloff *= ty_spot_falloff(job->light, ty_dot(direction, job->light->direction));
    for (int c = 0; c < 3; ++c) light[c] = falloff * job->light->color[c] * ty_decay(depth[c]);
}

static void describe(const void* user, size_t index, const ty_ray* ray, const ty_hit* hit,
                     const ty_surface_point* point) {
    const shadow_job* job = user;
    const ty_vec direction = ty_vec_load(ray->direction);
    ty_shadow_texel* texel = &job->map->texels[index];
    float light[3];
    find_light(job, ty_vec_load(ray->origin), direction, hit->distance, light);
    const float across = job->map->parallel != 0 ? 1.0f : hit->distance * hit->distance;
    const float facing = -ty_dot(point->ng, direction);
    texel->position = ty_hit_leave(hit, point->ng);
    texel->normal = point->ns;
    texel->distance = hit->distance;
    texel->area = job->map->share * across / ty_maxf(facing, 1e-2f);
    for (int c = 0; c < 3; ++c) texel->flux[c] = light[c] * point->albedo[c];
}

static bool ray_of(const void* user, int32_t face, int32_t x, int32_t y, ty_ray* ray) {
    const ty_shadow_map* map = ((const shadow_job*)user)->map;
    const size_t side = (size_t)map->side;
    ty_vec origin, direction;
    ty_shadow_map_ray(map, ((size_t)face * side + (size_t)y) * side + (size_t)x, &origin, &direction);
    *ray = (ty_ray){.origin = {origin.x, origin.y, origin.z},
                    .direction = {direction.x, direction.y, direction.z},
                    .far = INFINITY};
    return true;
}

static void clear(ty_shadow_map* map) {
    const size_t count = ty_shadow_map_count(map);
    for (size_t i = 0; i < count; ++i) map->texels[i] = (ty_shadow_texel){.distance = INFINITY};
}

static void add_up(ty_shadow_map* map) {
    const size_t count = ty_shadow_map_count(map);
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) map->flux[c] += (double)map->texels[i].flux[c];
}

static void fill(shadow_job* job) {
    ty_shadow_map* map = job->map;
    bool meets = job->scene->view.mesh != NULL;
    map->axis[2] = job->light->kind == TY_KIND_POINT ? ty_vec_make(0, 0, 1) : job->light->direction;
    ty_onb(map->axis[2], &map->axis[0], &map->axis[1]);
    clear(map);
    if (map->parallel == 0) place_cone(job);
    if (map->parallel != 0 && meets) meets = place_parallel(job);
    if (!meets) return;
    const ty_texels texels = {
        .scene = job->scene, .side = map->side, .faces = map->faces, .user = job, .ray = ray_of, .meet = describe};
    ty_texels_trace(&texels, NULL);
    add_up(map);
}

ty_result ty_shadow_map_create(const ty_scene* scene, const ty_shadow_map_def* def, int32_t light,
                               ty_shadow_map** out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    ty_result result = ty_check_number(scene->context, "shadow map: side", def->side, 1, SIDE_MAX);
    if (result == TY_OK) result = ty_texels_check_light(scene, "shadow map", light);
    if (result != TY_OK) return result;
    const int32_t kind = view->lights.lights[light].kind;
    ty_shadow_map* map = ty_alloc_array(scene->context, 1, sizeof *map, true);
    if (map == NULL) return TY_ERROR_MEMORY;
    map->context = scene->context;
    map->light = light;
    map->side = def->side;
    map->faces = kind == TY_KIND_POINT ? 2 : 1;
    map->parallel = kind == TY_KIND_DIRECTIONAL;
    map->seed = ty_mix64(def->seed + ty_mix64((uint64_t)light));
    map->texels = ty_alloc_array(scene->context, ty_shadow_map_count(map), sizeof *map->texels, false);
    if (map->texels == NULL) {
        ty_free_array(scene->context, map, 1, sizeof *map);
        return TY_ERROR_MEMORY;
    }
    shadow_job job = {.scene = scene, .def = def, .light = &view->lights.lights[light], .map = map};
    fill(&job);
    *out = map;
    return TY_OK;
}

void ty_shadow_map_destroy(ty_shadow_map* map) {
    if (map == NULL) return;
    ty_free_array(map->context, map->texels, ty_shadow_map_count(map), sizeof *map->texels);
    ty_free_array(map->context, map, 1, sizeof *map);
}
