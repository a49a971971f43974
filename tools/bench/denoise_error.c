/* tyndall bench denoise --full: errors of denoised images of few samples beside those of raw images of 16 times as
 * many, both by a reference of 2048 samples whose own noise is subtracted. */
#include "bench/bench.h"
#include "scenes/scenes.h"

#include <math.h>

enum { FEW = 16, MANY = 256, TRUTH = 2048, LONG_SIDE = 96 };

static const struct {
    const char *name, *scene, *file; /* file: third-party data that the scene needs, or NULL */
} scenes[] = {
    {"cube_g0", "builtin:cube_g0", NULL},
    {"cube_g0.7", "builtin:cube_g0.7", NULL},
    {"cube_g0.96", "builtin:cube_g0.96", NULL},
    {"cornell_fog", "builtin:cornell_fog", NULL},
    {"cloud_sun", "builtin:cloud_sun", NULL},
    {"cloud_sky", "builtin:cloud_sky", NULL},
    {"fog_cornell", "builtin:fog_cornell", NULL},
    {"window", "path_window", NULL},
    {"cloud_behind", "path_cloud_behind", NULL},
    {"snow", "path_snow", NULL},
    {"lamp_in_ball", "path_lamp_in_ball", NULL},
    {"hall", "path_hall", NULL},
    {"lamps", "builtin:lamps", NULL},
    {"corner", "path_corner", NULL},
    {"sponza", "auto_sponza_sky", SPONZA_FILE},
    {"staircase", "auto_staircase", STAIRCASE_FILE},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

/* relRMSE and relMSE of a raw image, a denoised one and a raw one of more samples; relRMSE as estimated. */
typedef struct denoise_errors {
    double rmse[3], mse[3], estimate;
} denoise_errors;

static void frame_size(const bench_session* bench, const ty_scene* scene, int32_t size[2]) {
    const ty_camera_def camera = ty_scene_camera(scene);
    const double longest = fmax(camera.resolution[0], camera.resolution[1]);
    const double scale = (bench->options->quick ? LONG_SIDE / 4 : LONG_SIDE) / longest;
    for (int a = 0; a < 2; ++a)
        size[a] = bench->options->size_given ? bench->options->size[a]
                                             : (int32_t)fmax(1, round(scale * camera.resolution[a]));
}

static ty_result render(const bench_session* bench, const ty_scene* scene, int32_t spp, uint64_t seed, uint32_t aovs,
                        ty_image** out) {
    ty_path_def def = ty_default_path_def();
    const ty_result result = ty_method_options(scene, "path", &def);
    int32_t size[2];
    frame_size(bench, scene, size);
    def.width = size[0];
    def.height = size[1];
    def.spp = bench->options->quick && spp > FEW ? spp / 16 : spp;
    def.seed = seed;
    def.aovs = aovs;
    def.progress = cli_progress_report;
    def.progress_user = &bench->session->progress;
    return result == TY_OK ? ty_path_render(scene, &def, out, NULL) : result;
}

/* The variance of a reference's noise, in the units of relRMSE^2 and of relMSE. */
static void own_noise(const ty_image* truth, double out[2]) {
    const float* light[3];
    const int64_t count = (int64_t)ty_image_width(truth) * ty_image_height(truth);
    out[0] = out[1] = 0;
    if (!ty_image_rgb_planes(truth, light)) return;
    static const char* const names[3] = {"variance.R", "variance.G", "variance.B"};
    double mean = 0;
    for (int c = 0; c < 3; ++c)
        for (int64_t i = 0; i < count; ++i) mean += (double)light[c][i] / (3.0 * (double)count);
    for (int c = 0; c < 3; ++c) {
        const float* variance = ty_image_plane_const(truth, ty_image_find_channel(truth, names[c]));
        double own = 0, sum = 0; /* of the channel, whose relMSE is over its own mean */
        for (int64_t i = 0; i < count; ++i) own += (double)light[c][i] / (double)count;
        for (int64_t i = 0; i < count; ++i) {
            const double value = (double)light[c][i];
            out[0] += (double)variance[i] / (3.0 * (double)count * mean * mean);
            sum += (double)variance[i] / (value * value + 0.01 * own * own);
        }
        out[1] += own > 0 ? sum / (3.0 * (double)count) : 0;
    }
}

static ty_result compare(const bench_session* bench, const ty_image* image, const ty_image* truth, double* rmse,
                         double* mse) {
    ty_difference difference;
    double noise[2];
    const ty_result result = ty_image_compare(bench->session->context, image, truth, 1, &difference);
    if (result != TY_OK) return result;
    own_noise(truth, noise);
    *rmse = sqrt(fmax(difference.relative_rmse[3] * difference.relative_rmse[3] - noise[0], 0));
    *mse = fmax(difference.rel_mse[3] - noise[1], 0);
    return TY_OK;
}

/* few: with all channels that denoising uses. */
static ty_result compare_denoised(const bench_session* bench, const ty_image* few, const ty_image* truth,
                                  denoise_errors* out) {
    ty_context* context = bench->session->context;
    ty_denoise_def def = ty_default_denoise_def();
    ty_denoise_stats stats = ty_default_denoise_stats();
    ty_image *denoised = NULL, *layer = NULL;
    ty_result result = ty_denoise_image(context, few, &def, &denoised, &stats);
    if (result == TY_OK) result = ty_image_create_layer(context, denoised, "denoised", &layer);
    if (result == TY_OK) result = compare(bench, layer, truth, &out->rmse[1], &out->mse[1]);
    out->estimate = stats.error;
    ty_image_destroy(layer);
    ty_image_destroy(denoised);
    return result;
}

static ty_result measure(const bench_session* bench, const ty_scene* scene, denoise_errors* out) {
    const uint64_t seed = bench->session->common.seed;
    ty_image *truth = NULL, *few = NULL, *plain = NULL, *many = NULL;
    ty_result result = render(bench, scene, TRUTH, seed + 777, TY_AOV_VARIANCE, &truth);
    if (result == TY_OK) result = render(bench, scene, FEW, seed, TY_DENOISE_AOVS | TY_AOV_SAMPLES, &few);
    if (result == TY_OK) result = render(bench, scene, FEW, seed + 1, 0, &plain);
    if (result == TY_OK) result = render(bench, scene, MANY, seed + 5, 0, &many);
    if (result == TY_OK) result = compare(bench, plain, truth, &out->rmse[0], &out->mse[0]);
    if (result == TY_OK) result = compare_denoised(bench, few, truth, out);
    if (result == TY_OK) result = compare(bench, many, truth, &out->rmse[2], &out->mse[2]);
    ty_image_destroy(truth);
    ty_image_destroy(few);
    ty_image_destroy(plain);
    ty_image_destroy(many);
    return result;
}

static void print(const bench_session* bench, const char* name, const denoise_errors* e) {
    json_open_object(bench->json, name);
    bench_numbers(bench->json, {"raw_16", e->rmse[0]}, {"denoised_16", e->rmse[1]}, {"raw_256", e->rmse[2]},
                  {"denoised_over_256", e->rmse[1] / e->rmse[2]}, {"estimated_over_true", e->estimate / e->rmse[1]},
                  {"rel_mse_raw_16", e->mse[0]}, {"rel_mse_denoised_16", e->mse[1]}, {"rel_mse_raw_256", e->mse[2]});
    json_close_object(bench->json);
}

int bench_denoise_errors(const bench_session* bench) {
    double rmse = 0, mse = 0;
    int count = 0;
    ty_result result = TY_OK;
    json_open_object(bench->json, "errors");
    for (int s = 0; s < SCENES && result == TY_OK; ++s) {
        if (scenes[s].file != NULL && !tools_has_data(bench->options->data, scenes[s].file)) continue;
        ty_scene* scene = NULL;
        denoise_errors errors = {.estimate = 0};
        result = tools_load_scene(bench->session->context, scenes[s].scene, bench->options->data, NULL, 0, &scene);
        if (result == TY_OK) result = measure(bench, scene, &errors);
        ty_scene_destroy(scene);
        cli_progress_clear(&bench->session->progress);
        if (result != TY_OK) break;
        print(bench, scenes[s].name, &errors);
        rmse += log(errors.rmse[1] / errors.rmse[2]);
        mse += log(errors.mse[1] / errors.mse[2]);
        ++count;
    }
    if (result == TY_OK)
        bench_numbers(bench->json, {"scenes", count}, {"denoised_over_256", exp(rmse / count)},
                      {"rel_mse_denoised_over_256", exp(mse / count)});
    json_close_object(bench->json);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
