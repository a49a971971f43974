/* Placement of a cache's points, and the rays between them. */
#include "base/context.h"
#include "base/parallel.h"
#include "direct/media/attenuation.k.h"
#include "direct/shadow/grid_depth.h"
#include "image/march/irradiance_points.h"
#include "scene/scene.h"

enum { TABLE_BITS = 12 };

/* Generators of the R2 low-discrepancy sequence (Roberts 2018), and the golden ratio. */
static const double step_u = 0.7548776662466927, step_v = 0.5698402909980532, golden = 0.6180339887498949;

typedef struct place_job {
    const ty_scene* scene;
    const ty_grid_medium* medium;
    ty_irradiance_cache* cache;
    bool outside; /* a point is outside of the box */
} place_job;

static float fraction(double x) {
    return (float)(x - floor(x));
}

/* ---- points ---- */

/* The point at a hit, which is new where its cell had none; -1: the cache is full. */
static int32_t point_at(place_job* job, ty_vec position, ty_vec normal, const float albedo[3]) {
    ty_irradiance_cache* cache = job->cache;
    const uint32_t key = ty_irradiance_key(&cache->view, position, normal);
    const uint32_t entry = ty_irradiance_entry(&cache->view, key);
    if (cache->keys[entry] == TY_IRRADIANCE_EMPTY) {
        if (cache->view.count == TY_IRRADIANCE_POINTS_MAX) return -1;
        cache->keys[entry] = key;
        cache->items[entry] = cache->view.count++;
        const bool inside = ty_boundary_contains(job->medium, position);
        cache->points[cache->items[entry]] =
            (ty_irradiance_point){position, normal, inside, 0, 1 - fraction(cache->view.count * golden)};
        job->outside = job->outside || !inside;
    }
    const int32_t index = cache->items[entry];
    ty_irradiance_point* point = &cache->points[index];
    if (point->places < TY_IRRADIANCE_PLACES) {
        ty_boundary_side* place = &cache->places[(size_t)index * TY_IRRADIANCE_PLACES + (size_t)point->places++];
        *place = (ty_boundary_side){.position = position, .normal = normal};
        for (int c = 0; c < 3; ++c) place->albedo[c] = albedo[c];
    }
    return index;
}

/* Traces a ray to its point. weight: of a ray without loss. */
static void trace(place_job* job, ty_vec origin, ty_vec direction, float weight, ty_irradiance_ray* ray) {
    const ty_scene_view* view = &job->scene->view;
    ty_surface_point surface;
    ty_hit hit;
    *ray = (ty_irradiance_ray){origin, direction, TY_FLOAT_MAX, -1, {0, 0, 0}, {0, 0, 0}};
    if (!ty_accel_intersect(view->mesh, origin, direction, TY_FLOAT_MAX, &hit)) return;
    ty_surface_evaluate(&view->surfaces[hit.surface], &hit, direction, &surface);
    ray->distance = hit.distance;
    ray->point = point_at(job, ty_hit_leave(&hit, surface.ng), surface.ng, surface.albedo);
    for (int c = 0; c < 3; ++c) {
        ray->weight[c] = weight * ty_minf(surface.albedo[c], 1);
        ray->emitted[c] = surface.light < 0 ? weight * TY_PI * surface.emission[c] : 0;
    }
}

/* A ray about an axis, the index-th of so many, with the density of its cosine. */
static ty_vec direction_of(ty_vec axis, int32_t index, int32_t count, double shift) {
    const float u = ((float)index + fraction(shift)) / (float)count;
    return ty_direction_about(axis, sqrtf(1.0f - u), fraction(shift * step_v + golden * index));
}

/* Rays of the box's faces begin at the center of their cells, so that surfaces in the faces stop them. */
static void trace_faces(place_job* job) {
    const ty_grid_medium* medium = job->medium;
    const ty_grid_box* box = &medium->box;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, low = axis == 0 ? 1 : 0, high = axis == 2 ? 1 : 2;
        ty_irradiance_ray* rays = ty_irradiance_face_rays(job->cache, face);
        float out[3] = {0, 0, 0};
        out[axis] = (face & 1) != 0 ? 1 : -1;
        for (int32_t i = 0; i < TY_IRRADIANCE_FACE_PATCHES * TY_IRRADIANCE_PATCH_RAYS; ++i) {
            const int32_t patch = i / TY_IRRADIANCE_PATCH_RAYS, sample = i % TY_IRRADIANCE_PATCH_RAYS;
            const double u = (double)(patch % TY_IRRADIANCE_PATCHES) + (double)fraction((i + 1) * step_u);
            const double v = (double)(patch / TY_IRRADIANCE_PATCHES) + (double)fraction((i + 1) * step_v);
            const double half = 0.5 * medium->cell[axis];
            float at[3];
            at[axis] = (float)((face & 1) != 0 ? box->upper[axis] - half : box->lower[axis] + half);
            at[low] = (float)(box->lower[low] + u / TY_IRRADIANCE_PATCHES * (box->upper[low] - box->lower[low]));
            at[high] = (float)(box->lower[high] + v / TY_IRRADIANCE_PATCHES * (box->upper[high] - box->lower[high]));
            const ty_vec direction =
                direction_of(ty_vec_load(out), sample, TY_IRRADIANCE_PATCH_RAYS, 0.5 + patch * golden);
            trace(job, ty_vec_load(at), direction, 1.0f / TY_IRRADIANCE_PATCH_RAYS, &rays[i]);
            if (rays[i].point >= 0 && job->cache->points[rays[i].point].inside != 0) rays[i].point = -1;
        }
    }
}

static void trace_points(place_job* job) {
    ty_irradiance_cache* cache = job->cache;
    for (int32_t i = 0; i < cache->view.count; ++i) {
        const ty_irradiance_point* point = &cache->points[i];
        for (int32_t r = 0; r < TY_IRRADIANCE_RAYS && point->inside == 0; ++r)
            trace(job, point->position, direction_of(point->normal, r, TY_IRRADIANCE_RAYS, (i + 1) * golden),
                  1.0f / TY_IRRADIANCE_RAYS, &cache->rays[(size_t)i * TY_IRRADIANCE_RAYS + (size_t)r]);
    }
}

/* ---- attenuation ---- */

static void attenuate(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const place_job* job = user;
    ty_irradiance_ray* rays = job->cache->rays + index * TY_IRRADIANCE_RAYS;
    if (job->cache->points[index].inside != 0) return;
    for (int32_t r = 0; r < TY_IRRADIANCE_RAYS; ++r) {
        float depth[3];
        if (rays[r].point < 0) continue;
        ty_grid_depth(job->medium, NULL, rays[r].origin, rays[r].direction, rays[r].distance, depth);
        for (int c = 0; c < 3; ++c) {
            rays[r].weight[c] *= ty_attenuation(depth[c]);
            rays[r].emitted[c] *= ty_attenuation(depth[c]);
        }
    }
}

/* ---- memory ---- */

static const size_t ray_count = (size_t)TY_IRRADIANCE_POINTS_MAX * TY_IRRADIANCE_RAYS + TY_IRRADIANCE_FACE_RAYS,
                    place_count = (size_t)TY_IRRADIANCE_POINTS_MAX * TY_IRRADIANCE_PLACES,
                    float_count = (size_t)TY_IRRADIANCE_POINTS_MAX * 3;

static ty_result allocate(ty_context* context, ty_irradiance_cache** out) {
    ty_irradiance_cache* cache = ty_alloc_array(context, 1, sizeof *cache, true);
    *out = cache;
    if (cache == NULL) return TY_ERROR_MEMORY;
    cache->context = context;
    cache->keys = ty_alloc_array(context, (size_t)1 << TABLE_BITS, sizeof *cache->keys, false);
    cache->items = ty_alloc_array(context, (size_t)1 << TABLE_BITS, sizeof *cache->items, false);
    cache->points = ty_alloc_array(context, TY_IRRADIANCE_POINTS_MAX, sizeof *cache->points, false);
    cache->rays = ty_alloc_array(context, ray_count, sizeof *cache->rays, false);
    cache->places = ty_alloc_array(context, place_count, sizeof *cache->places, false);
    bool complete = cache->keys != NULL && cache->items != NULL && cache->points != NULL && cache->rays != NULL &&
                    cache->places != NULL;
    for (int i = 0; i < 3; ++i) {
        cache->irradiance[i] = ty_alloc_array(context, float_count, sizeof(float), true);
        complete = complete && cache->irradiance[i] != NULL;
    }
    return complete ? TY_OK : TY_ERROR_MEMORY;
}

void ty_irradiance_cache_destroy(ty_irradiance_cache* cache) {
    if (cache == NULL) return;
    ty_context* context = cache->context;
    ty_free_array(context, cache->keys, (size_t)1 << TABLE_BITS, sizeof *cache->keys);
    ty_free_array(context, cache->items, (size_t)1 << TABLE_BITS, sizeof *cache->items);
    ty_free_array(context, cache->points, TY_IRRADIANCE_POINTS_MAX, sizeof *cache->points);
    ty_free_array(context, cache->rays, ray_count, sizeof *cache->rays);
    ty_free_array(context, cache->places, place_count, sizeof *cache->places);
    for (int i = 0; i < 3; ++i) ty_free_array(context, cache->irradiance[i], float_count, sizeof(float));
    ty_free_array(context, cache, 1, sizeof *cache);
}

static void begin_view(const ty_grid_medium* medium, ty_irradiance_cache* cache) {
    const ty_grid_box* box = &medium->box;
    float center[3], half_side[3];
    double edge[3];
    ty_irradiance_view* view = &cache->view;
    for (int a = 0; a < 3; ++a) {
        edge[a] = box->upper[a] - box->lower[a];
        center[a] = (float)(0.5 * (box->lower[a] + box->upper[a]));
        half_side[a] = (float)(0.5 * edge[a]);
        view->longest = ty_maxf(view->longest, (float)edge[a]);
    }
    for (int a = 0; a < 3; ++a) cache->area[a] = edge[(a + 1) % 3] * edge[(a + 2) % 3];
    view->bits = TABLE_BITS;
    view->center = ty_vec_load(center);
    view->half_side = ty_vec_load(half_side);
    view->keys = cache->keys;
    view->points = cache->items;
    view->irradiance = cache->irradiance[TY_REFLECTED_MEDIA];
    for (size_t i = 0; i < (size_t)1 << TABLE_BITS; ++i) cache->keys[i] = TY_IRRADIANCE_EMPTY;
}

/* True where a surface reaches out of the box by more than half a cell. */
static bool has_outer_surfaces(const ty_scene* scene, const ty_grid_medium* medium) {
    double lower[3], upper[3];
    bool out = false;
    if (scene->view.mesh == NULL) return false;
    ty_scene_surface_extent(scene, lower, upper);
    for (int a = 0; a < 3; ++a) {
        const double half = 0.5 * medium->cell[a];
        out = out || lower[a] < medium->box.lower[a] - half || upper[a] > medium->box.upper[a] + half;
    }
    return out;
}

ty_result ty_irradiance_cache_create(const ty_scene* scene, const ty_grid_medium* medium, ty_irradiance_cache** out) {
    ty_context* context = ty_scene_context(scene);
    *out = NULL;
    if (!has_outer_surfaces(scene, medium)) return TY_OK;
    place_job job = {.scene = scene, .medium = medium};
    const ty_result result = allocate(context, &job.cache);
    if (result == TY_OK) {
        begin_view(medium, job.cache);
        trace_faces(&job);
    }
    if (result != TY_OK || !job.outside) {
        ty_irradiance_cache_destroy(job.cache);
        return result;
    }
    trace_points(&job);
    ty_parallel_flushed(context, job.cache->view.count, attenuate, &job);
    *out = job.cache;
    return TY_OK;
}

void ty_irradiance_cache_get_view(const ty_irradiance_cache* cache, ty_irradiance_view* out) {
    if (cache == NULL)
        *out = (ty_irradiance_view){.count = 0};
    else
        *out = cache->view;
}
