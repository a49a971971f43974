/* tyndall bench octaves: images by number of octaves and from froxels, with the times of their stages, compared with
 * path tracing; froxels also with the error against a ray per pixel. */
#include "bench/bench.h"

enum { RUNS_MAX = 99, WIDTH = 1024, VARIANTS = 7, MARCHED = 2, STAGES = 3 };

/* Octaves, and columns and slices of froxels; MARCHED is the one that froxels are compared with. */
typedef struct variant {
    const char* name;
    int32_t count, froxels, slices;
} variant;

static const variant variants[VARIANTS] = {{"octaves_1", 1, 0, 64},
                                           {"octaves_3", 3, 0, 64},
                                           {"octaves_6", 6, 0, 64},
                                           {"octaves_8", 8, 0, 64},
                                           {"octaves_6_froxels_80x32", 6, 80, 32},
                                           {"octaves_6_froxels_160x64", 6, 160, 64},
                                           {"octaves_6_froxels_320x128", 6, 320, 128}};
static const char* const stages[STAGES] = {"medium_seconds", "direct_seconds", "march_seconds"};

typedef struct timed {
    double seconds[VARIANTS], stages[VARIANTS][STAGES]; /* medians, s */
    double bytes[VARIANTS];                             /* bytes of the light fields */
    ty_difference errors[VARIANTS];                     /* of froxels */
    double path;                                        /* s, of bench_time_path */
} timed;

static ty_result render(const bench_session* bench, const ty_scene* scene, const variant* v, ty_image** image,
                        ty_octaves_stats* stats) {
    ty_octaves_def def = ty_default_octaves_def();
    int32_t size[2];
    bench_pixels(bench->options, WIDTH, WIDTH, size);
    def.width = size[0];
    def.height = size[1];
    def.count = v->count;
    def.froxels = v->froxels;
    def.froxel_slices = v->slices;
    def.progress = cli_progress_report;
    def.progress_user = &bench->session->progress;
    return ty_octaves_render(scene, &def, image, stats);
}

/* marched: the image of variant MARCHED, made there. */
static ty_result time_variant(const bench_session* bench, const ty_scene* scene, int index, ty_image** marched,
                              timed* out) {
    double seconds[RUNS_MAX], parts[STAGES][RUNS_MAX];
    const int runs = bench->options->runs;
    ty_result result = TY_OK;
    for (int run = 0; run < runs && result == TY_OK; ++run) {
        ty_octaves_stats stats = ty_default_octaves_stats();
        ty_image* image = NULL;
        result = render(bench, scene, &variants[index], &image, &stats);
        const double of[STAGES] = {stats.medium_seconds, stats.direct_seconds, stats.march_seconds};
        seconds[run] = stats.seconds;
        for (int s = 0; s < STAGES; ++s) parts[s][run] = of[s];
        out->bytes[index] = stats.memory_bytes;
        if (result == TY_OK && run == 0 && variants[index].froxels > 0)
            result = ty_image_compare(bench->session->context, image, *marched, 1, &out->errors[index]);
        if (run == 0 && index == MARCHED)
            *marched = image;
        else
            ty_image_destroy(image);
    }
    if (result != TY_OK) return result;
    out->seconds[index] = bench_median(seconds, runs);
    for (int s = 0; s < STAGES; ++s) out->stages[index][s] = bench_median(parts[s], runs);
    return TY_OK;
}

static void print_timed(const bench_session* bench, const char* name, const timed* t) {
    json_open_object(bench->json, name);
    for (int i = 0; i < VARIANTS; ++i) {
        json_open_object(bench->json, variants[i].name);
        json_number(bench->json, "seconds", t->seconds[i]);
        for (int s = 0; s < STAGES; ++s) json_number(bench->json, stages[s], t->stages[i][s]);
        json_number(bench->json, "bytes", t->bytes[i]);
        if (variants[i].froxels > 0)
            bench_numbers(bench->json, {"mean_ratio", t->errors[i].mean_ratio[3]},
                          {"relative_rmse", t->errors[i].relative_rmse[3]});
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
        ty_image* marched = NULL;
        snprintf(path, sizeof path, "builtin:%s", names[n]);
        result = ty_scene_load(bench->session->context, path, NULL, 0, &scene);
        for (int i = 0; i < VARIANTS && result == TY_OK; ++i) result = time_variant(bench, scene, i, &marched, &t);
        if (result == TY_OK) result = bench_time_path(bench, scene, WIDTH, WIDTH, &t.path);
        cli_progress_clear(&bench->session->progress);
        if (result == TY_OK) print_timed(bench, names[n], &t);
        ty_image_destroy(marched);
        ty_scene_destroy(scene);
    }
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
