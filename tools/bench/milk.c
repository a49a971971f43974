/* A glass of milk, whose medium fills a solid dielectric, by a fast method beside path tracing. */
#include "bench/milk.h"

#include "bench/noise.h"
#include "scenes/scenes.h"

enum { WIDTH = 320, HEIGHT = 240, SPP = 4, BLOCK = 8, PATH_SPP = 64, RUNS_MAX = 99 };

typedef struct measured {
    double seconds, cpu, solve, entering; /* medians */
    double path, path_cpu;
    ty_difference difference;
    double error, noise; /* of means over blocks, relative; without path's noise */
} measured;

static ty_result time_images(const bench_session* bench, const ty_method* method, const ty_scene* scene,
                             const int32_t size[2], ty_image** out, measured* m) {
    static double seconds[RUNS_MAX], cpu[RUNS_MAX], solve[RUNS_MAX], entering[RUNS_MAX];
    static ty_method_run run;
    const ty_render_request request = {.spp = SPP, .width = size[0], .height = size[1]};
    ty_result result = TY_OK;
    for (int i = 0; i < bench->options->runs && result == TY_OK; ++i) {
        const double begun = cli_cpu_seconds();
        run = (ty_method_run){.own_seconds = 0};
        ty_image_destroy(*out);
        *out = NULL;
        result = method->render(scene, &request, out, &run);
        cpu[i] = cli_cpu_seconds() - begun;
        seconds[i] = run.path.seconds;
        solve[i] = run.interiors.seconds;
        entering[i] = run.interiors.entering_seconds;
    }
    if (result != TY_OK) return result;
    m->seconds = bench_median(seconds, bench->options->runs);
    m->cpu = bench_median(cpu, bench->options->runs);
    m->solve = bench_median(solve, bench->options->runs);
    m->entering = bench_median(entering, bench->options->runs);
    return TY_OK;
}

static ty_result compare(const bench_session* bench, const ty_scene* scene, const int32_t size[2],
                         const ty_image* image, measured* m) {
    ty_path_def def = ty_default_path_def();
    ty_path_stats stats = ty_default_path_stats();
    ty_image* truth = NULL;
    double noise[4];
    const double begun = cli_cpu_seconds();
    def.spp = PATH_SPP;
    def.width = size[0];
    def.height = size[1];
    def.aovs = TY_AOV_VARIANCE;
    ty_result result = ty_path_render(scene, &def, &truth, &stats);
    m->path_cpu = cli_cpu_seconds() - begun;
    m->path = stats.seconds;
    if (result == TY_OK) result = ty_image_compare(bench->session->context, image, truth, BLOCK, &m->difference);
    if (result == TY_OK) {
        bench_noise(truth, BLOCK, noise);
        const double mean = m->difference.rmse[3] / m->difference.relative_rmse[3];
        m->noise = noise[3] / mean;
        m->error = bench_without_noise(m->difference.rmse[3], noise[3]) / mean;
    }
    ty_image_destroy(truth);
    return result;
}

ty_result bench_milk(const bench_session* bench, const ty_method* method) {
    int32_t size[2];
    measured m = {0};
    ty_scene* scene = NULL;
    ty_image* image = NULL;
    bench_pixels(bench->options, WIDTH, HEIGHT, size);
    ty_result result = tools_load_scene(bench->session->context, "milk_glass", NULL, NULL, 0, &scene);
    if (result == TY_OK) result = time_images(bench, method, scene, size, &image, &m);
    if (result == TY_OK) result = compare(bench, scene, size, image, &m);
    cli_progress_clear(&bench->session->progress);
    if (result == TY_OK) {
        json_open_object(bench->json, "glass_of_milk");
        json_numbers(bench->json, "size", (const double[]){size[0], size[1]}, 2);
        bench_numbers(bench->json, {"spp", SPP}, {"seconds", m.seconds}, {"cpu_seconds", m.cpu},
                      {"interiors_seconds", m.solve}, {"entering_seconds", m.entering}, {"path_spp", PATH_SPP},
                      {"path_seconds", m.path}, {"path_cpu_seconds", m.path_cpu},
                      {"mean_ratio", m.difference.mean_ratio[3]}, {"block", BLOCK}, {"path_noise", m.noise});
        if (!(m.error != m.error)) json_number(bench->json, "relative_rmse", m.error);
        json_close_object(bench->json);
    }
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    return result;
}
