/* Parameters from a scene: the medium, the camera, and the distance of each pixel through the medium. */
#include "base/float_mode.h"
#include "base/context.h"
#include "scene/camera.h"
#include "scene/scene.h"
#include "scene/media/spans.k.h"

#include <tyndall/screen.h>

#include <stdatomic.h>
#include <stdio.h>

/* Distance of rays outside all media, m: negligible but not 0, which marks an unknown distance. */
static const float no_distance = 1e-20f;

/* "media[1] (smoke)" */
static void name_medium(const ty_scene* scene, int32_t index, char out[128]) {
    const char* name = scene->media[index].name;
    snprintf(out, 128, name[0] != '\0' ? "media[%d] (%.100s)" : "media[%d]", index, name);
}

static bool is_empty(const ty_medium_view* medium) {
    return !(medium->sigma_t_max > 0);
}

/* Sums the coefficients of all media. */
static ty_result add_media(const ty_scene* scene, const ty_scene_view* view, ty_screen_def* def) {
    char name[128];
    double g[3] = {0, 0, 0};
    for (int c = 0; c < 3; ++c) def->sigma_s[c] = def->sigma_a[c] = def->g[c] = 0;
    for (int32_t i = 0; i < view->medium_count; ++i) {
        const ty_medium_view* medium = &view->media[i];
        if (is_empty(medium)) continue;
        name_medium(scene, i, name);
        if (medium->heterogeneous != 0)
            return ty_fail(scene->context, TY_ERROR_ARGUMENT,
                           "screen: %s is not homogeneous, and the method knows one medium for the whole picture",
                           name);
        for (int c = 0; c < 3; ++c) {
            def->sigma_s[c] += medium->sigma_s[c];
            def->sigma_a[c] += medium->sigma_t[c] - medium->sigma_s[c];
            g[c] += (double)medium->sigma_s[c] * (double)medium->g[c];
        }
    }
    for (int c = 0; c < 3; ++c)
        if (def->sigma_s[c] > 0) def->g[c] = (float)(g[c] / (double)def->sigma_s[c]);
    return TY_OK;
}

ty_result ty_screen_set_scene(const ty_scene* scene, int32_t height, ty_screen_def* def) {
    ty_screen_def known = ty_default_screen_def();
    ty_result result = ty_take_def(ty_scene_context(scene), def, "ty_default_screen_def", &known, sizeof known);
    const ty_scene_view* view = result == TY_OK ? ty_scene_get_view(scene) : NULL;
    if (view == NULL) return TY_ERROR_ARGUMENT;
    result = ty_scene_check_open(scene, "screen");
    const ty_camera_def camera = ty_scene_camera(scene);
    if (result == TY_OK) result = ty_camera_check_pinhole(ty_scene_context(scene), &camera, "screen");
    if (result == TY_OK && (camera.shift[0] != 0 || camera.shift[1] != 0))
        result = ty_fail(ty_scene_context(scene), TY_ERROR_ARGUMENT, "screen: the camera has a shift");
    if (result == TY_OK) result = add_media(scene, view, def);
    if (result != TY_OK) return result;
    def->focal[0] = def->focal[1] = ty_screen_focal(height > 0 ? height : camera.resolution[1], camera.fov_y);
    def->center[0] = def->center[1] = -1;
    def->distance_kind = TY_SCREEN_DISTANCE_RAY;
    return TY_OK;
}

/* ---- Distances ---- */

typedef struct distance_job {
    const ty_scene_view* view;
    ty_camera_view camera;
    int32_t width;
    float sigma_t; /* sum over all media, channel mean, 1/m */
    float* distance;
    _Atomic bool outside; /* a ray enters a medium from outside */
    _Atomic bool unequal; /* a ray is longer in one medium than in another */
} distance_job;

static float mean_sigma_t(const ty_medium_view* medium) {
    return (medium->sigma_t[0] + medium->sigma_t[1] + medium->sigma_t[2]) / 3;
}

/* The length of a ray inside each medium, m. */
static void add_lengths(distance_job* job, ty_vec direction, float max_distance, float lengths[TY_MEDIA_MAX]) {
    ty_spans spans;
    ty_spans_find(job->view->media, job->view->medium_count, job->camera.origin, direction, max_distance, &spans);
    for (int32_t i = 0; i < spans.count; ++i) {
        lengths[spans.medium[i]] += spans.leave[i] - spans.enter[i];
        if (spans.enter[i] > 0 && !is_empty(&job->view->media[spans.medium[i]]))
            atomic_store_explicit(&job->outside, true, memory_order_relaxed);
    }
}

/* Distance at which all media together have the mean optical depth found along a ray. */
static float equivalent_distance(distance_job* job, ty_vec direction, float max_distance) {
    float lengths[TY_MEDIA_MAX] = {0}, depth = 0, shortest = TY_FLOAT_MAX, longest = 0;
    add_lengths(job, direction, max_distance, lengths);
    for (int32_t i = 0; i < job->view->medium_count; ++i) {
        const ty_medium_view* medium = &job->view->media[i];
        if (is_empty(medium)) continue;
        depth += mean_sigma_t(medium) * lengths[i];
        shortest = ty_minf(shortest, lengths[i]);
        longest = ty_maxf(longest, lengths[i]);
    }
    if (longest - shortest > 1e-3f * longest) atomic_store_explicit(&job->unequal, true, memory_order_relaxed);
    return ty_maxf(job->sigma_t > 0 ? depth / job->sigma_t : 0, no_distance);
}

static void find_row(void* user, int64_t y, int32_t worker) {
    (void)worker;
    distance_job* job = user;
    float* row = job->distance + y * job->width;
    const unsigned state = ty_flush_denormals();
    for (int32_t x = 0; x < job->width; ++x) {
        const ty_vec direction = ty_camera_direction(&job->camera, (float)x + 0.5f, (float)y + 0.5f);
        row[x] = equivalent_distance(job, direction, row[x] > 0 && row[x] < TY_FLOAT_MAX ? row[x] : TY_FLOAT_MAX);
    }
    ty_restore_denormals(state);
}

static void warn_of_emission(const ty_scene* scene, const ty_scene_view* view) {
    char name[128];
    for (int32_t i = 0; i < view->medium_count; ++i) {
        if (view->media[i].emits == 0) continue;
        name_medium(scene, i, name);
        ty_log(scene->context, TY_LOG_WARNING, "screen: the light that %s itself sends is left out", name);
    }
}

ty_result ty_screen_scene_distance(const ty_scene* scene, int32_t width, int32_t height, float* distance) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (width < 1 || height < 1 || width > 65536 || height > 65536 || distance == NULL)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "screen: %d x %d is outside 1..65536, or distance is NULL",
                       width, height);
    distance_job job = {.view = view, .width = width, .distance = distance};
    job.camera = ty_camera_get_view(&scene->camera, width, height);
    for (int32_t i = 0; i < view->medium_count; ++i) job.sigma_t += mean_sigma_t(&view->media[i]);
    ty_parallel_for(scene->context, height, find_row, &job);
    warn_of_emission(scene, view);
    if (job.outside)
        ty_log(scene->context, TY_LOG_WARNING,
               "screen: the camera is outside a medium, whose light is spread as if it were at its edge");
    if (job.unequal)
        ty_log(scene->context, TY_LOG_WARNING,
               "screen: the media do not fill the same space; their mean is used, with distances that keep the optical "
               "depth");
    return TY_OK;
}
