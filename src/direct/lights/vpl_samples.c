/* Candidates for virtual point lights. */
#include "direct/lights/vpl_samples.h"

#include "base/context.h"
#include "base/random.k.h"
#include "direct/media/attenuation.k.h"
#include "direct/shadow/grid_depth.h"
#include "direct/shadow/texels.h"
#include "base/check.h"
#include "scene/scene.h"

enum { SIDE_MAX = 4096 };

typedef struct sample_job {
    const ty_scene* scene;
    const ty_vpl_samples_def* def;
    const ty_light_view* light;
    ty_vpl_samples* samples;
} sample_job;

/* ---- stratified directions ---- */

/* The concentric map of the square [-1, 1]^2 to the disc, in polar coordinates (angle in turns), which preserves
 * relative area (Shirley and Chiu 1997). */
static void disc_of(float a, float b, float* radius, float* turn) {
    const bool wide = fabsf(a) > fabsf(b);
    const float long_side = wide ? a : b;
    const float eighth = long_side != 0.0f ? 0.125f * (wide ? b : a) / long_side : 0.0f;
    const float raw = (wide ? eighth : 0.25f - eighth) + (long_side < 0.0f ? 0.5f : 0.0f);
    *radius = fabsf(long_side);
    *turn = raw - floorf(raw);
}

static ty_vec direction_in_cone(const ty_vpl_samples* samples, int32_t face, float x, float y) {
    float radius, turn, sine, cosine;
    disc_of(2.0f * x - 1.0f, 2.0f * y - 1.0f, &radius, &turn);
    ty_sincos_2pi(turn, &sine, &cosine);
    const float down = samples->cap * radius * radius, across = sqrtf(ty_maxf(0.0f, down * (2.0f - down)));
    const ty_vec along = ty_scale(samples->axis[2], face == 0 ? 1.0f - down : down - 1.0f);
    return ty_normalize(ty_mad(ty_mad(along, samples->axis[0], across * cosine), samples->axis[1], across * sine));
}

size_t ty_vpl_samples_count(const ty_vpl_samples* samples) {
    return (size_t)samples->faces * (size_t)samples->side * (size_t)samples->side;
}

void ty_vpl_samples_ray(const ty_vpl_samples* samples, size_t texel, ty_vec* origin, ty_vec* direction) {
    const size_t side = (size_t)samples->side;
    const uint64_t bits = ty_mix64(samples->seed + 0x9e3779b97f4a7c15u * (texel + 1));
    const float x = ((float)(texel % side) + ty_unit_float((uint32_t)bits)) / (float)side;
    const float y = ((float)(texel / side % side) + ty_unit_float((uint32_t)(bits >> 32))) / (float)side;
    *origin = samples->origin;
    *direction = samples->axis[2];
    if (samples->parallel != 0)
        *origin = ty_mad(ty_mad(samples->origin, samples->axis[0], x * samples->span[0]), samples->axis[1],
                         y * samples->span[1]);
    else
        *direction = direction_in_cone(samples, (int32_t)(texel / (side * side)), x, y);
}

/* ---- placement ---- */

/* The plane that parallel rays start from, in front of all surfaces and the medium. */
static double start_of(const sample_job* job, const double lower[3], const double upper[3]) {
    double range[2], other[2];
    ty_texels_extent(job->samples->axis[2], lower, upper, range);
    if (job->def->medium != NULL) {
        ty_texels_extent(job->samples->axis[2], job->def->medium->box.lower, job->def->medium->box.upper, other);
        range[0] = fmin(range[0], other[0]);
        range[1] = fmax(range[1], other[1]);
    }
    return range[0] - 1e-3 * (range[1] - range[0]) - 1e-6;
}

/* False if there are no surfaces in the requested box. */
static bool place_parallel(const sample_job* job) {
    ty_vpl_samples* samples = job->samples;
    double lower[3], upper[3], along[3];
    ty_scene_surface_extent(job->scene, lower, upper);
    along[2] = start_of(job, lower, upper);
    for (int a = 0; a < 3 && job->def->lower != NULL; ++a) {
        lower[a] = fmax(lower[a], job->def->lower[a]);
        upper[a] = fmin(upper[a], job->def->upper[a]);
        if (lower[a] > upper[a]) return false;
    }
    samples->origin = ty_vec_make(0, 0, 0);
    for (int a = 0; a < 2; ++a) {
        double range[2];
        ty_texels_extent(samples->axis[a], lower, upper, range);
        samples->span[a] = (float)(range[1] - range[0]);
        along[a] = range[0];
    }
    for (int a = 0; a < 3; ++a) samples->origin = ty_mad(samples->origin, samples->axis[a], (float)along[a]);
    samples->measure = samples->span[0] * samples->span[1] / ((float)samples->side * (float)samples->side);
    return true;
}

static void place_cone(const sample_job* job) {
    ty_vpl_samples* samples = job->samples;
    samples->origin = job->light->position;
    samples->cap = job->light->kind == TY_KIND_SPOT ? 1.0f - job->light->cos_outer : 1.0f;
    samples->measure = 2.0f * TY_PI * samples->cap / ((float)samples->side * (float)samples->side);
}

/* ---- tracing ---- */

/* Power of a sample's ray, W. */
static void find_light(const sample_job* job, ty_vec origin, ty_vec direction, float distance, float light[3]) {
    const ty_vpl_samples_def* def = job->def;
    float depth[3] = {0, 0, 0}, falloff = job->samples->measure;
    if (def->medium != NULL) ty_grid_depth(def->medium, def->extinction, origin, direction, distance, depth);
    if (job->light->kind == TY_KIND_SPOT)
        falloff *= ty_spot_falloff(job->light, ty_dot(direction, job->light->direction));
    for (int c = 0; c < 3; ++c) light[c] = falloff * job->light->color[c] * ty_attenuation(depth[c]);
}

static void describe(const void* user, size_t index, const ty_ray* ray, const ty_hit* hit,
                     const ty_surface_point* point) {
    const sample_job* job = user;
    const ty_vec direction = ty_vec_load(ray->direction);
    ty_vpl_sample* texel = &job->samples->items[index];
    float light[3];
    find_light(job, ty_vec_load(ray->origin), direction, hit->distance, light);
    const float across = job->samples->parallel != 0 ? 1.0f : hit->distance * hit->distance;
    const float facing = -ty_dot(point->ng, direction);
    texel->position = ty_hit_leave(hit, point->ng);
    texel->normal = point->ns;
    texel->distance = hit->distance;
    texel->area = job->samples->measure * across / ty_maxf(facing, 1e-2f);
    for (int c = 0; c < 3; ++c) texel->flux[c] = light[c] * point->albedo[c];
}

static bool ray_of(const void* user, int32_t face, int32_t x, int32_t y, ty_ray* ray) {
    const ty_vpl_samples* samples = ((const sample_job*)user)->samples;
    const size_t side = (size_t)samples->side;
    ty_vec origin, direction;
    ty_vpl_samples_ray(samples, ((size_t)face * side + (size_t)y) * side + (size_t)x, &origin, &direction);
    *ray = (ty_ray){.origin = {origin.x, origin.y, origin.z},
                    .direction = {direction.x, direction.y, direction.z},
                    .far = INFINITY};
    return true;
}

static void clear(ty_vpl_samples* samples) {
    const size_t count = ty_vpl_samples_count(samples);
    for (size_t i = 0; i < count; ++i) samples->items[i] = (ty_vpl_sample){.distance = INFINITY};
}

static void add_up(ty_vpl_samples* samples) {
    const size_t count = ty_vpl_samples_count(samples);
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) samples->flux[c] += (double)samples->items[i].flux[c];
}

static void fill(sample_job* job) {
    ty_vpl_samples* samples = job->samples;
    bool meets = job->scene->view.mesh != NULL;
    samples->axis[2] = job->light->kind == TY_KIND_POINT ? ty_vec_make(0, 0, 1) : job->light->direction;
    ty_onb(samples->axis[2], &samples->axis[0], &samples->axis[1]);
    clear(samples);
    if (samples->parallel == 0) place_cone(job);
    if (samples->parallel != 0 && meets) meets = place_parallel(job);
    if (!meets) return;
    const ty_texels texels = {.scene = job->scene,
                              .side = samples->side,
                              .faces = samples->faces,
                              .user = job,
                              .ray = ray_of,
                              .meet = describe};
    ty_texels_trace(&texels, NULL);
    add_up(samples);
}

ty_result ty_vpl_samples_create(const ty_scene* scene, const ty_vpl_samples_def* def, int32_t light,
                                ty_vpl_samples** out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    ty_result result = ty_check_number(scene->context, "VPL samples: side", def->side, 1, SIDE_MAX);
    if (result == TY_OK) result = ty_texels_check_light(scene, "VPL samples", light);
    if (result != TY_OK) return result;
    const int32_t kind = view->lights.lights[light].kind;
    ty_vpl_samples* samples = ty_alloc_array(scene->context, 1, sizeof *samples, true);
    if (samples == NULL) return TY_ERROR_MEMORY;
    samples->context = scene->context;
    samples->light = light;
    samples->side = def->side;
    samples->faces = kind == TY_KIND_POINT ? 2 : 1;
    samples->parallel = kind == TY_KIND_DIRECTIONAL;
    samples->seed = ty_mix64(def->seed + ty_mix64((uint64_t)light));
    samples->items = ty_alloc_array(scene->context, ty_vpl_samples_count(samples), sizeof *samples->items, false);
    if (samples->items == NULL) {
        ty_free_array(scene->context, samples, 1, sizeof *samples);
        return TY_ERROR_MEMORY;
    }
    sample_job job = {.scene = scene, .def = def, .light = &view->lights.lights[light], .samples = samples};
    fill(&job);
    *out = samples;
    return TY_OK;
}

void ty_vpl_samples_destroy(ty_vpl_samples* samples) {
    if (samples == NULL) return;
    ty_free_array(samples->context, samples->items, ty_vpl_samples_count(samples), sizeof *samples->items);
    ty_free_array(samples->context, samples, 1, sizeof *samples);
}
