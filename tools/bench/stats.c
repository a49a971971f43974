/* Medians, sizes and folders of benches, and the time of their reference. */
#define _GNU_SOURCE
#include "bench/bench.h"
#include "scenes/scenes.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int compare_numbers(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

double bench_median(double* values, int count) {
    qsort(values, (size_t)count, sizeof *values, compare_numbers);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

void bench_write_numbers(json_writer* json, const bench_member* members, size_t count) {
    for (size_t i = 0; i < count; ++i) json_number(json, members[i].name, members[i].value);
}

int bench_make_folder(char out[BENCH_PATH_SIZE]) {
    if (cli_make_temporary_folder("bench", out, BENCH_PATH_SIZE)) return CLI_GO;
    return cli_fail(CLI_FAILED, "%s: a folder for the bench cannot be made: %s", out, strerror(errno));
}

int bench_write_scene(const bench_options* options, const char* scene, const char* key, const char* file,
                      bench_scene_file* out) {
    if (bench_make_folder(out->folder) != CLI_GO) return CLI_FAILED;
    snprintf(out->path, sizeof out->path, "%s/scene.json", out->folder);
    char* data = realpath(options->data, NULL);
    const bool written = data != NULL && tools_write_scene(scene, out->path);
    if (written) snprintf(out->override, sizeof out->override, "%s=%s/%s", key, data, file);
    free(data);
    if (written) return CLI_GO;
    bench_remove_scene(out);
    return cli_fail(CLI_FAILED, "%s: a scene for the bench cannot be written", out->path);
}

void bench_remove_scene(const bench_scene_file* scene) {
    unlink(scene->path);
    rmdir(scene->folder);
}

void bench_pixels(const bench_options* options, int32_t width, int32_t height, int32_t size[2]) {
    const int32_t divisor = options->quick ? 4 : 1;
    size[0] = options->size_given ? options->size[0] : width / divisor;
    size[1] = options->size_given ? options->size[1] : height / divisor;
}

ty_result bench_time_path(const bench_session* bench, const ty_scene* scene, int32_t width, int32_t height,
                          double* seconds) {
    ty_path_def def = ty_default_path_def();
    int32_t size[2];
    bench_pixels(bench->options, width, height, size);
    def.spp = BENCH_PATH_SPP;
    def.width = size[0];
    def.height = size[1];
    def.progress = cli_progress_report;
    def.progress_user = &bench->session->progress;
    ty_path_stats stats = ty_default_path_stats();
    ty_image* image = NULL;
    const ty_result result = ty_path_render(scene, &def, &image, &stats);
    ty_image_destroy(image);
    *seconds = stats.seconds * BENCH_TRUTH_SPP / BENCH_PATH_SPP;
    return result;
}
