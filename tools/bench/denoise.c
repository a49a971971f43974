/* tyndall bench denoise: seconds of denoising path-traced images, in all and per megapixel, with the errors before and
 * after as estimated. */
#include "bench/bench.h"

enum { RUNS_MAX = 99, WIDTH = 1024, SPP = 2 };

static ty_result render(const bench_session* bench, const char* name, ty_image** out) {
    char path[64];
    ty_scene* scene = NULL;
    snprintf(path, sizeof path, "builtin:%s", name);
    ty_result result = ty_scene_load(bench->session->context, path, NULL, 0, &scene);
    ty_path_def def = ty_default_path_def();
    int32_t size[2];
    bench_pixels(bench->options, WIDTH, WIDTH, size);
    def.width = size[0];
    def.height = size[1];
    def.spp = SPP;
    def.aovs = TY_DENOISE_AOVS | TY_AOV_SAMPLES;
    def.progress = cli_progress_report;
    def.progress_user = &bench->session->progress;
    if (result == TY_OK) result = ty_path_render(scene, &def, out, NULL);
    ty_scene_destroy(scene);
    return result;
}

/* Of the parts apart, or of all light at once. */
static ty_result time_denoising(const bench_session* bench, const ty_image* image, bool parts) {
    double seconds[RUNS_MAX], cpu[RUNS_MAX];
    const int runs = bench->options->runs;
    ty_denoise_stats stats = ty_default_denoise_stats();
    for (int run = 0; run < runs; ++run) {
        ty_denoise_def def = ty_default_denoise_def();
        ty_image* out = NULL;
        def.parts = parts;
        def.progress = cli_progress_report;
        def.progress_user = &bench->session->progress;
        const double begun = cli_cpu_seconds();
        const ty_result result = ty_denoise_image(bench->session->context, image, &def, &out, &stats);
        ty_image_destroy(out);
        if (result != TY_OK) return result;
        cpu[run] = cli_cpu_seconds() - begun;
        seconds[run] = stats.seconds;
    }
    cli_progress_clear(&bench->session->progress);
    const double median = bench_median(seconds, runs);
    const double pixels = (double)ty_image_width(image) * ty_image_height(image);
    json_open_object(bench->json, parts ? "parts" : "whole");
    bench_numbers(bench->json, {"parts", stats.parts}, {"features", stats.features}, {"seconds", median},
                  {"cpu_seconds", bench_median(cpu, runs)}, {"seconds_per_megapixel", median / (1e-6 * pixels)},
                  {"raw_error", stats.raw_error}, {"error", stats.error});
    json_close_object(bench->json);
    return TY_OK;
}

int bench_denoise(const bench_session* bench) {
    static const char* const names[] = {"cornell_fog", "cloud_sun"};
    ty_result result = TY_OK;
    for (size_t n = 0; n < sizeof names / sizeof *names && result == TY_OK; ++n) {
        ty_image* image = NULL;
        result = render(bench, names[n], &image);
        if (result == TY_OK) {
            json_open_object(bench->json, names[n]);
            result = time_denoising(bench, image, true);
            if (result == TY_OK) result = time_denoising(bench, image, false);
            json_close_object(bench->json);
        }
        ty_image_destroy(image);
    }
    if (result == TY_OK && bench->options->full) return bench_denoise_errors(bench);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
