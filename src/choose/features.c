/* Features of a scene as seen by its camera, estimated from a few hundred rays through media and as many from their
 * scattering points. */
#include "choose/features.h"

#include "base/context.h"
#include "direct/media/grid_medium.h"
#include "scene/camera.h"
#include "scene/scene.h"
#include "scene/media/spans.k.h"

#include <stdlib.h>

enum { COLUMNS = 32, ROWS = 24, RAYS = COLUMNS * ROWS, STEPS = 32, AROUND = 8, CELLS = 40 };

/* Opacity of a ray below which it counts as without media. */
static const float min_fraction = 1e-3f;

/* One camera ray through media. `scattered`: light scattered towards the camera along it; the other sums are
 * weighted by it. */
typedef struct view_ray {
    double depth, scattered, g, albedo, cell;
    ty_vec at; /* scattering point if scattered > 0: one sample in proportion to the light scattered */
} view_ray;

typedef struct features_job {
    const ty_scene_view* view;
    ty_sampler random;
    float cell; /* cell edge, m */
} features_job;

/* ---- media along a ray ---- */

typedef struct media_point {
    float extinction, scattering, g; /* channel means; 1/m, 1/m, 1 */
} media_point;

static float mean(const float rgb[3]) {
    return (rgb[0] + rgb[1] + rgb[2]) / 3;
}

/* Sum of all media whose spans contain parameter t. */
static media_point media_at(features_job* job, const ty_spans* spans, ty_vec point_at, float t) {
    media_point sum = {0, 0, 0};
    for (int32_t i = 0; i < spans->count; ++i) {
        if (t < spans->enter[i] || t > spans->leave[i]) continue;
        const ty_medium_view* medium = &job->view->media[spans->medium[i]];
        const float density = ty_medium_density(medium, point_at, &job->random);
        float sigma_s[3], g[3];
        ty_medium_sigma_s(medium, point_at, sigma_s);
        ty_medium_g(medium, point_at, g);
        sum.extinction += density * mean(medium->sigma_t);
        sum.scattering += density * mean(sigma_s);
        sum.g += density * mean(sigma_s) * mean(g);
    }
    if (sum.scattering > 0) sum.g /= sum.scattering;
    return sum;
}

static void add_step(features_job* job, const media_point* point, ty_vec point_at, float length, view_ray* ray) {
    const float through = ty_expf(-(float)ray->depth), depth = point->extinction * length;
    ray->depth += (double)depth;
    if (!(point->scattering > 0)) return;
    const float albedo = point->scattering / point->extinction;
    const double scattered_light = (double)(through * (1 - ty_expf(-depth)) * albedo);
    ray->scattered += scattered_light;
    ray->g += scattered_light * (double)point->g;
    ray->albedo += scattered_light * (double)albedo;
    ray->cell += scattered_light * (double)(point->extinction * job->cell);
    if ((double)ty_rng_uniform(&job->random) * ray->scattered < scattered_light) ray->at = point_at;
}

static int compare_floats(const void* a, const void* b) {
    const float x = *(const float*)a, y = *(const float*)b;
    return (x > y) - (x < y);
}

/* Sorted ends of the media's intervals along the ray; the set of media is constant between two neighbours. */
static int32_t find_interval_ends(const ty_spans* spans, float ends[2 * TY_SPANS_MAX]) {
    for (int32_t i = 0; i < spans->count; ++i) {
        ends[2 * i] = spans->enter[i];
        ends[2 * i + 1] = spans->leave[i];
    }
    qsort(ends, (size_t)(2 * spans->count), sizeof *ends, compare_floats);
    return 2 * spans->count;
}

static view_ray march_ray(features_job* job, const ty_ray* from, float far) {
    ty_spans spans;
    float ends[2 * TY_SPANS_MAX];
    view_ray ray = {.depth = 0};
    const ty_vec origin = ty_vec_load(from->origin), direction = ty_vec_load(from->direction);
    ty_spans_find(job->view->media, job->view->medium_count, origin, direction, far, &spans);
    const int32_t count = find_interval_ends(&spans, ends);
    for (int32_t i = 0; i + 1 < count; ++i) {
        const float step = (ends[i + 1] - ends[i]) / STEPS;
        for (int32_t s = 0; s < STEPS && step > 0; ++s) {
            const float t = ends[i] + step * ((float)s + ty_rng_uniform(&job->random));
            const ty_vec point_at = ty_mad(origin, direction, t);
            const media_point point = media_at(job, &spans, point_at, t);
            add_step(job, &point, point_at, step, &ray);
        }
    }
    return ray;
}

/* ---- frame ---- */

static void make_camera_rays(const ty_scene* scene, ty_ray rays[RAYS]) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const ty_camera_view view = ty_camera_get_view(&camera, camera.resolution[0], camera.resolution[1]);
    for (int32_t i = 0; i < RAYS; ++i) {
        const float x = ((float)(i % COLUMNS) + 0.5f) / COLUMNS, y = ((float)(i / COLUMNS) + 0.5f) / ROWS;
        const ty_vec direction =
            ty_camera_direction(&view, x * (float)camera.resolution[0], y * (float)camera.resolution[1]);
        rays[i] = (ty_ray){
            {view.origin.x, view.origin.y, view.origin.z}, {direction.x, direction.y, direction.z}, TY_FLOAT_MAX};
    }
}

static void add_ray(const view_ray* ray, const ty_ray_hit* hit, ty_scene_features* out) {
    const double absorbed = 1 - exp(-ray->depth);
    out->media += absorbed > (double)min_fraction ? 1.0 / RAYS : 0;
    out->opacity += absorbed / RAYS;
    out->thickness = fmax(out->thickness, ray->depth);
    out->surfaces += hit->surface >= 0 ? 1.0 / RAYS : 0;
    out->g += ray->g;
    out->albedo += ray->albedo;
    out->cell += ray->cell;
}

/* Stratified uniform directions around a point. */
static void sample_enclosure_rays(features_job* job, ty_vec at, float far, ty_ray rays[AROUND]) {
    const float rotation = ty_rng_uniform(&job->random);
    for (int32_t k = 0; k < AROUND; ++k) {
        const float z = 1 - 2 * ((float)k + ty_rng_uniform(&job->random)) / AROUND;
        const ty_vec direction = ty_direction_about(ty_vec_make(0, 0, 1), z, rotation + 0.618034f * (float)k);
        rays[k] = (ty_ray){{at.x, at.y, at.z}, {direction.x, direction.y, direction.z}, far};
    }
}

/* Fraction of rays from scattering points that hit surfaces, weighted by scattered light. */
static ty_result find_enclosed(features_job* job, const ty_scene* scene, const view_ray* rays, float far,
                               ty_scene_features* out) {
    ty_context* context = ty_scene_context(scene);
    ty_ray* around = ty_alloc_array(context, RAYS * AROUND, sizeof *around, false);
    bool* shadowed = ty_alloc_array(context, RAYS * AROUND, sizeof *shadowed, true);
    ty_result result = around != NULL && shadowed != NULL ? TY_OK : TY_ERROR_MEMORY;
    double sum = 0, all = 0;
    for (int32_t i = 0; i < RAYS && result == TY_OK; ++i)
        sample_enclosure_rays(job, rays[i].at, far, around + i * AROUND);
    if (result == TY_OK) result = ty_scene_trace_shadows(scene, around, RAYS * AROUND, TY_RAYS_INCOHERENT, shadowed);
    for (int32_t i = 0; i < RAYS * AROUND && result == TY_OK; ++i) {
        all += rays[i / AROUND].scattered;
        sum += shadowed[i] ? rays[i / AROUND].scattered : 0;
    }
    if (all > 0) out->enclosed = sum / all;
    ty_free_array(context, around, RAYS * AROUND, sizeof *around);
    ty_free_array(context, shadowed, RAYS * AROUND, sizeof *shadowed);
    return result;
}

/* ---- features without rays ---- */

static bool is_empty(const ty_medium_view* medium) {
    return !(medium->sigma_t_max > 0);
}

static void list_media(const ty_scene_view* view, ty_vec camera, ty_scene_features* out) {
    ty_spans spans;
    for (int32_t i = 0; i < view->medium_count; ++i) {
        if (is_empty(&view->media[i])) continue;
        out->heterogeneous |= view->media[i].heterogeneous != 0;
        out->emissive_media |= view->media[i].emits != 0;
    }
    ty_spans_find(view->media, view->medium_count, camera, ty_vec_make(0, 0, 1), TY_FLOAT_MAX, &spans);
    for (int32_t i = 0; i < spans.count; ++i)
        out->inside |= spans.enter[i] <= 0 && !is_empty(&view->media[spans.medium[i]]);
}

static void list_lights(const ty_scene* scene, ty_scene_features* out) {
    for (size_t i = 0; i < scene->light_count; ++i)
        if (mean(scene->lights[i].color) > 0) out->lights |= 1u << scene->lights[i].kind;
    out->light_count = scene->view.lights.count;
    for (int32_t i = 0; i < scene->view.lights.count; ++i) {
        const int32_t kind = scene->view.lights.lights[i].kind;
        if (kind > TY_KIND_SPOT && kind != TY_KIND_ENVIRONMENT) out->lights |= 1u << TY_LIGHT_AREA;
    }
}

static ty_result trace_view_rays(features_job* job, const ty_scene* scene, view_ray* rays, ty_scene_features* out) {
    ty_context* context = ty_scene_context(scene);
    ty_ray* camera_rays = ty_alloc_array(context, RAYS, sizeof *camera_rays, false);
    ty_ray_hit* hits = ty_alloc_array(context, RAYS, sizeof *hits, false);
    ty_result result = camera_rays != NULL && hits != NULL ? TY_OK : TY_ERROR_MEMORY;
    if (result == TY_OK) {
        make_camera_rays(scene, camera_rays);
        result = ty_scene_trace(scene, camera_rays, RAYS, TY_RAYS_COHERENT, hits);
    }
    double scattered = 0;
    for (int32_t i = 0; i < RAYS && result == TY_OK; ++i) {
        rays[i] = march_ray(job, &camera_rays[i], hits[i].distance);
        add_ray(&rays[i], &hits[i], out);
        scattered += rays[i].scattered;
    }
    if (scattered > 0) {
        out->g /= scattered;
        out->albedo /= scattered;
        out->cell /= scattered;
    }
    ty_free_array(context, camera_rays, RAYS, sizeof *camera_rays);
    ty_free_array(context, hits, RAYS, sizeof *hits);
    return result;
}

/* Mean optical thickness of the box along its axes, on the lines through its center. */
static double find_span(features_job* job, const ty_grid_box* box) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
        double from[3];
        for (int b = 0; b < 3; ++b) from[b] = 0.5 * (box->lower[b] + box->upper[b]);
        from[a] = box->lower[a];
        const ty_ray ray = {{(float)from[0], (float)from[1], (float)from[2]}, {a == 0, a == 1, a == 2}, TY_FLOAT_MAX};
        sum += march_ray(job, &ray, (float)(box->upper[a] - box->lower[a])).depth / 3;
    }
    return sum;
}

ty_result ty_scene_features_find(const ty_scene* scene, ty_scene_features* out) {
    ty_context* context = ty_scene_context(scene);
    features_job job = {.view = ty_scene_get_view(scene), .random = ty_sampler_begin(NULL, 0, 0, 0)};
    double side = 0;
    ty_grid_box box;
    *out = (ty_scene_features){.media = 0};
    list_lights(scene, out);
    ty_result result = TY_OK;
    if (job.view->medium_count > 0) result = ty_grid_box_fit(scene, CELLS, &box);
    for (int a = 0; a < 3 && result == TY_OK && job.view->medium_count > 0; ++a)
        side = fmax(side, box.upper[a] - box.lower[a]);
    job.cell = (float)(side / CELLS);
    const ty_camera_def camera = ty_scene_camera(scene);
    list_media(job.view, ty_vec_make((float)camera.position[0], (float)camera.position[1], (float)camera.position[2]),
               out);
    view_ray* rays = ty_alloc_array(context, RAYS, sizeof *rays, true);
    if (rays == NULL) return TY_ERROR_MEMORY;
    if (result == TY_OK) result = trace_view_rays(&job, scene, rays, out);
    if (result == TY_OK && job.view->medium_count > 0) {
        out->span = find_span(&job, &box);
        int32_t size[3];
        ty_grid_box_cut(&box, ty_grid_box_longest(scene, 0), size);
        out->voxels = (double)size[0] * size[1] * size[2];
    }
    if (result == TY_OK && job.view->mesh != NULL) result = find_enclosed(&job, scene, rays, (float)side, out);
    ty_free_array(context, rays, RAYS, sizeof *rays);
    return result;
}
