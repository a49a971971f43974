/* Medians, sizes and folders of benches, and the time of their reference. */
#define _GNU_SOURCE
#include "bench/bench.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

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
    const char* folder = getenv("TMPDIR");
    snprintf(out, BENCH_PATH_SIZE, "%s/tyndall-bench-XXXXXX", folder != NULL && folder[0] != '\0' ? folder : "/tmp");
    if (mkdtemp(out) != NULL) return CLI_GO;
    return cli_fail(CLI_FAILED, "%s: a folder for the bench cannot be made: %s", out, strerror(errno));
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
