/* tyndall bench path: cost of noise. The measure is relRMSE^2 times CPU seconds, which is independent of the number of
 * samples once there are enough. Without a reference the noise comes from two independent images A and B of the same
 * scene: relRMSE^2 = mean((A - B)^2) / 2 / mean(A and B)^2. */
#include "bench/bench.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

enum { PATH_SIZE = 4096 };

typedef struct path_result {
    double relative_rmse;  /* of one image */
    double cpu_seconds;    /* of one image */
    double cost;           /* relative_rmse^2 * cpu_seconds */
    double msamples;       /* 1e6 paths per second, wall clock */
    double mvertices;      /* 1e6 vertices per second, wall clock */
    double from_reference; /* relative RMSE from the reference; NaN without one */
} path_result;

static double pair_noise(const ty_image* a, const ty_image* b) {
    const int64_t count = (int64_t)ty_image_width(a) * ty_image_height(a);
    const float *pa[3], *pb[3];
    if (!ty_image_rgb_planes(a, pa) || !ty_image_rgb_planes(b, pb)) return NAN;
    double squares = 0, sum = 0;
    for (int channel = 0; channel < 3; ++channel) {
        for (int64_t i = 0; i < count; ++i) {
            const double x = (double)pa[channel][i], y = (double)pb[channel][i];
            squares += 0.5 * (x - y) * (x - y);
            sum += 0.5 * (x + y);
        }
    }
    const double values = 3.0 * (double)count;
    return sqrt(squares / values) / (sum / values);
}

static ty_result render(const bench_session* bench, const ty_scene* scene, bool guided, uint64_t seed, ty_image** out,
                        ty_path_stats* stats) {
    ty_path_def def = ty_default_path_def();
    def.spp = bench->options->spp;
    def.seed = seed;
    def.width = bench->options->size[0];
    def.height = bench->options->size[1];
    def.progress = cli_progress_report;
    def.progress_user = &bench->session->progress;
    const ty_result result = ty_method_options(scene, "path", &def);
    if (bench->options->guide) def.guide = guided ? TY_PATH_GUIDE_DOM : TY_PATH_GUIDE_NONE;
    return result == TY_OK ? ty_path_render(scene, &def, out, stats) : result;
}

/* Renders two images with different seeds. */
static ty_result measure_pair(const bench_session* bench, const ty_scene* scene, bool guided, int run,
                              const ty_image* reference, path_result* out) {
    ty_image* images[2] = {NULL, NULL};
    ty_path_stats stats[2] = {ty_default_path_stats(), ty_default_path_stats()};
    ty_result result = TY_OK;
    for (int i = 0; result == TY_OK && i < 2; ++i)
        result = render(bench, scene, guided, bench->session->common.seed + 2 * (uint64_t)run + (uint64_t)i, &images[i],
                        &stats[i]);
    ty_difference difference = {.relative_rmse = {0, 0, 0, NAN}};
    if (result == TY_OK && reference != NULL)
        result = ty_image_compare(bench->session->context, images[0], reference, 1, &difference);
    if (result == TY_OK) {
        const double seconds = stats[0].seconds + stats[1].seconds;
        out->relative_rmse = pair_noise(images[0], images[1]);
        out->cpu_seconds = 0.5 * (stats[0].cpu_seconds + stats[1].cpu_seconds);
        out->cost = out->relative_rmse * out->relative_rmse * out->cpu_seconds;
        out->msamples = 1e-6 * (double)(stats[0].paths + stats[1].paths) / seconds;
        out->mvertices = 1e-6 * (double)(stats[0].vertices + stats[1].vertices) / seconds;
        out->from_reference = difference.relative_rmse[3];
    }
    ty_image_destroy(images[0]);
    ty_image_destroy(images[1]);
    return result;
}

static double median_member(const path_result* results, int count, size_t offset) {
    double values[99];
    for (int i = 0; i < count; ++i) memcpy(&values[i], (const char*)&results[i] + offset, sizeof values[i]);
    return bench_median(values, count);
}

static path_result median_result(const path_result* results, int count) {
    return (path_result){
        .relative_rmse = median_member(results, count, offsetof(path_result, relative_rmse)),
        .cpu_seconds = median_member(results, count, offsetof(path_result, cpu_seconds)),
        .cost = median_member(results, count, offsetof(path_result, cost)),
        .msamples = median_member(results, count, offsetof(path_result, msamples)),
        .mvertices = median_member(results, count, offsetof(path_result, mvertices)),
        .from_reference = median_member(results, count, offsetof(path_result, from_reference)),
    };
}

static void print_result(const bench_session* bench, const char* name, const path_result* result) {
    json_open_object(bench->json, name);
    bench_numbers(bench->json, {"relative_rmse", result->relative_rmse}, {"cpu_seconds", result->cpu_seconds},
                  {"cost", result->cost}, {"msamples_per_second", result->msamples},
                  {"mvertices_per_second", result->mvertices});
    if (bench->options->reference != NULL)
        json_number(bench->json, "relative_rmse_from_reference", result->from_reference);
    json_close_object(bench->json);
}

/* A scene argument that looks like a path is a file, else the name of a builtin scene. */
static ty_result load_scene(const bench_session* bench, const char* given, ty_scene** out) {
    char path[PATH_SIZE + 16];
    const bool is_file = strchr(given, '/') != NULL || cli_has_extension(given, ".json");
    snprintf(path, sizeof path, "%s%s", is_file ? "" : "builtin:", given);
    return ty_scene_load(bench->session->context, path, NULL, 0, out);
}

/* The file name of a path, without .json. */
static void get_name(const char* given, char out[PATH_SIZE]) {
    const char* slash = strrchr(given, '/');
    snprintf(out, PATH_SIZE, "%s", slash == NULL ? given : slash + 1);
    if (cli_has_extension(out, ".json")) out[strlen(out) - strlen(".json")] = '\0';
}

static ty_result load_reference(const bench_session* bench, const char* name, ty_image** out) {
    if (bench->options->reference == NULL) return TY_OK;
    char path[2 * PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s.exr", bench->options->reference, name);
    return ty_image_read(bench->session->context, path, out);
}

/* Measures a scene under a name. */
static ty_result measure(const bench_session* bench, const ty_scene* scene, bool guided, const ty_image* reference,
                         const char* name) {
    path_result results[99];
    ty_result result = TY_OK;
    for (int run = 0; result == TY_OK && run < bench->options->runs; ++run)
        result = measure_pair(bench, scene, guided, run, reference, &results[run]);
    cli_progress_clear(&bench->session->progress);
    if (result != TY_OK) return result;
    const path_result median = median_result(results, bench->options->runs);
    print_result(bench, name, &median);
    return TY_OK;
}

static int bench_scene(const bench_session* bench, const char* given) {
    cli_session* session = bench->session;
    char name[PATH_SIZE];
    get_name(given, name);
    ty_scene* scene = NULL;
    ty_image* reference = NULL;
    ty_result result = load_scene(bench, given, &scene);
    if (result == TY_OK) result = load_reference(bench, name, &reference);
    if (result != TY_OK) {
        ty_scene_destroy(scene);
        return cli_fail_reading(session, result);
    }
    result = measure(bench, scene, false, reference, name);
    if (result == TY_OK && bench->options->guide) {
        char guided[PATH_SIZE + 16];
        snprintf(guided, sizeof guided, "%s_guided", name);
        result = measure(bench, scene, true, reference, guided);
    }
    ty_image_destroy(reference);
    ty_scene_destroy(scene);
    return result == TY_OK ? CLI_DONE : cli_fail_running(session, result);
}

int bench_path(const bench_session* bench) {
    const bench_options* options = bench->options;
    json_numbers(bench->json, "size", (const double[]){options->size[0], options->size[1]}, 2);
    bench_numbers(bench->json, {"spp", options->spp}, {"runs", options->runs});
    json_open_object(bench->json, "scenes");
    int status = CLI_DONE;
    for (const char* rest = options->scenes; status == CLI_DONE && rest != NULL;) {
        char given[PATH_SIZE];
        const size_t length = strcspn(rest, ",");
        if (length == 0 || length >= sizeof given)
            return cli_usage_error("bench", "--scenes: '%s' is not a list like cube_g0,cloud_sun", options->scenes);
        memcpy(given, rest, length);
        given[length] = '\0';
        rest = rest[length] == ',' ? rest + length + 1 : NULL;
        status = bench_scene(bench, given);
    }
    json_close_object(bench->json);
    return status;
}
