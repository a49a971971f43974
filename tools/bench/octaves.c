/* tyndall bench octaves: images by number of octaves, with the times of their stages, compared with path tracing. */
#include "bench/bench.h"

enum { RUNS_MAX = 99, WIDTH = 1024, COUNTS = 4, STAGES = 3 };

static const int32_t counts[COUNTS] = {1, 3, 6, 8};
static const char* const stages[STAGES] = {"medium_seconds", "direct_seconds", "march_seconds"};

typedef struct timed {
    double seconds[COUNTS], stages[COUNTS][STAGES]; /* medians, s */
    double bytes[COUNTS];                           /* bytes of the light fields */
    double path;                                    /* s, of bench_time_path */
} timed;

static ty_result render(const bench_session* bench, const ty_scene* scene, int32_t count, ty_octaves_stats* stats) {
    ty_octaves_def def = ty_default_octaves_def();
    int32_t size[2];
    bench_pixels(bench->options, WIDTH, WIDTH, size);
    def.width = size[0];
    def.height = size[1];
    def.count = count;
    def.progress = cli_progress_report;
    def.progress_user = &bench->session->progress;
    ty_image* image = NULL;
    const ty_result result = ty_octaves_render(scene, &def, &image, stats);
    ty_image_destroy(image);
    return result;
}

static ty_result time_count(const bench_session* bench, const ty_scene* scene, int index, timed* out) {
    double seconds[RUNS_MAX], parts[STAGES][RUNS_MAX];
    const int runs = bench->options->runs;
    for (int run = 0; run < runs; ++run) {
        ty_octaves_stats stats = ty_default_octaves_stats();
        const ty_result result = render(bench, scene, counts[index], &stats);
        if (result != TY_OK) return result;
        const double of[STAGES] = {stats.medium_seconds, stats.direct_seconds, stats.march_seconds};
        seconds[run] = stats.seconds;
        for (int s = 0; s < STAGES; ++s) parts[s][run] = of[s];
        out->bytes[index] = stats.memory_bytes;
    }
    out->seconds[index] = bench_median(seconds, runs);
    for (int s = 0; s < STAGES; ++s) out->stages[index][s] = bench_median(parts[s], runs);
    return TY_OK;
}

static void print_timed(const bench_session* bench, const char* name, const timed* t) {
    json_open_object(bench->json, name);
    for (int i = 0; i < COUNTS; ++i) {
        char key[16];
        snprintf(key, sizeof key, "octaves_%d", (int)counts[i]);
        json_open_object(bench->json, key);
        json_number(bench->json, "seconds", t->seconds[i]);
        for (int s = 0; s < STAGES; ++s) json_number(bench->json, stages[s], t->stages[i][s]);
        json_number(bench->json, "bytes", t->bytes[i]);
        json_close_object(bench->json);
    }
    json_number(bench->json, "path_seconds_at_1000_spp", t->path);
    json_close_object(bench->json);
}

int bench_octaves(const bench_session* bench) {
    static const char* const names[] = {"cloud_sun", "nebulae"};
    ty_result result = TY_OK;
    for (size_t n = 0; n < sizeof names / sizeof *names && result == TY_OK; ++n) {
        char path[64];
        timed t = {.path = 0};
        ty_scene* scene = NULL;
        snprintf(path, sizeof path, "builtin:%s", names[n]);
        result = ty_scene_load(bench->session->context, path, NULL, 0, &scene);
        for (int i = 0; i < COUNTS && result == TY_OK; ++i) result = time_count(bench, scene, i, &t);
        if (result == TY_OK) result = bench_time_path(bench, scene, WIDTH, WIDTH, &t.path);
        cli_progress_clear(&bench->session->progress);
        if (result == TY_OK) print_timed(bench, names[n], &t);
        ty_scene_destroy(scene);
    }
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
