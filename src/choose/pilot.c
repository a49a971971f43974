/* A pilot of path tracing: all light, and the light of surfaces that no medium scatters. */
#include "choose/pilot.h"

#include "method/method.h"

#include <math.h>

enum { PIXELS = 768, SAMPLES_MIN = 4, SAMPLES_MAX = 64 };

/* Radiance of three channels, summed over the image. */
static double sum_channels(const ty_image* image, const char* const names[3]) {
    const size_t pixels = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        const float* plane = ty_image_plane_const(image, ty_image_find_channel(image, names[c]));
        for (size_t i = 0; i < pixels; ++i) sum += (double)plane[i];
    }
    return sum;
}

static double sum_image(const ty_image* image) {
    static const char* const names[3] = {"R", "G", "B"};
    return sum_channels(image, names);
}

static double sum_multiple(const ty_image* image) {
    static const char* const names[3] = {"multiple.R", "multiple.G", "multiple.B"};
    return sum_channels(image, names);
}

static void find_size(const ty_scene* scene, ty_pilot* out) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const double aspect = (double)camera.resolution[0] / camera.resolution[1];
    out->width = (int32_t)fmin(fmax(rint(sqrt(PIXELS * aspect)), 1), PIXELS);
    out->height = (int32_t)fmax(rint((double)PIXELS / out->width), 1);
}

static double vertices_of(const ty_path_stats* stats) {
    return stats->paths > 0 ? (double)stats->vertices / (double)stats->paths : 0;
}

/* Standard deviation of a pixel by one path, over the mean of its image. */
static double noise_of(const ty_path_stats* stats) {
    return stats->error * sqrt(stats->spp);
}

/* Renders all light, with few samples first, which tell how many there can be. */
static ty_result trace_all(const ty_scene* scene, ty_path_def* def, double interactions, ty_pilot* out,
                           ty_path_stats* stats) {
    const ty_result result = ty_path_render(scene, def, &out->all, stats);
    if (result != TY_OK) return result;
    const double possible = interactions / (PIXELS * (1 + vertices_of(stats)));
    out->spp = (int32_t)fmin(fmax(possible, SAMPLES_MIN), SAMPLES_MAX);
    if (out->spp == SAMPLES_MIN) return TY_OK;
    ty_image_destroy(out->all);
    out->all = NULL;
    def->spp = out->spp;
    return ty_path_render(scene, def, &out->all, stats);
}

static ty_result trace_unscattered(const ty_scene* scene, ty_path_def* def, double sum, ty_pilot* out,
                                   ty_scene_features* features) {
    ty_path_stats stats = ty_default_path_stats();
    def->aovs = 0;
    def->unscattered = true;
    const ty_result result = ty_path_render(scene, def, &out->unscattered, &stats);
    if (result != TY_OK || !(sum > 0)) return result;
    features->unscattered = sum_image(out->unscattered) / sum;
    features->surface_noise = noise_of(&stats) * features->unscattered;
    features->surface_vertices = vertices_of(&stats);
    return TY_OK;
}

ty_result ty_pilot_trace(const ty_scene* scene, double interactions, ty_pilot* out, ty_scene_features* features) {
    const ty_scene_info info = ty_scene_get_info(scene);
    ty_path_stats stats = ty_default_path_stats();
    ty_path_def def;
    *out = (ty_pilot){.spp = SAMPLES_MIN};
    find_size(scene, out);
    const ty_render_request request = {
        .spp = SAMPLES_MIN, .aovs = TY_AOV_MULTIPLE | TY_AOV_VARIANCE, .width = out->width, .height = out->height};
    ty_result result = ty_request_path_def(scene, &request, &def);
    if (result != TY_OK) return result;
    def.guide = TY_PATH_GUIDE_NONE;
    result = trace_all(scene, &def, interactions, out, &stats);
    const double sum = result == TY_OK ? sum_image(out->all) : 0;
    if (sum > 0) {
        features->noise = noise_of(&stats);
        features->vertices = vertices_of(&stats);
        features->multiple = sum_multiple(out->all) / sum;
    }
    if (result == TY_OK && (info.shapes > 0 || info.meshes > 0))
        result = trace_unscattered(scene, &def, sum, out, features);
    return result;
}

void ty_pilot_free(ty_pilot* pilot) {
    ty_image_destroy(pilot->all);
    ty_image_destroy(pilot->unscattered);
    *pilot = (ty_pilot){.all = NULL};
}
