/* `tyndall render` as a process of its own, whose crash or endless loop harms no other. */
#define _GNU_SOURCE
#include "figures/matrix.h"
#include "bench/command.h"

#include <math.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

enum { ARGUMENTS_MAX = 32 };

const int32_t matrix_seconds_max = 60;

void matrix_image_path(const char* folder, char out[MATRIX_PATH_SIZE]) {
    snprintf(out, MATRIX_PATH_SIZE, "%s/image.exr", folder);
}

void matrix_stats_path(const char* folder, char out[MATRIX_PATH_SIZE]) {
    snprintf(out, MATRIX_PATH_SIZE, "%s/stats.json", folder);
}

ty_result matrix_run_tyndall(const char* const* arguments, figure_process* out) {
    char path[BENCH_COMMAND_SIZE];
    const char* list[ARGUMENTS_MAX] = {path};
    for (int count = 1; *arguments != NULL && count < ARGUMENTS_MAX - 1; ++arguments) list[count++] = *arguments;
    bench_find_command(path);
    return figure_run_process(list, matrix_seconds_max, out);
}

ty_result matrix_render(const char* folder, const char* scene, const char* const* arguments, figure_process* out) {
    char image[MATRIX_PATH_SIZE], stats[MATRIX_PATH_SIZE];
    const char* list[ARGUMENTS_MAX] = {"render", scene, "-o", image, "-q", "--threads", "1", "--stats", stats};
    int count = 9;
    for (; *arguments != NULL && count < ARGUMENTS_MAX - 1; ++arguments) list[count++] = *arguments;
    matrix_image_path(folder, image);
    matrix_stats_path(folder, stats);
    unlink(image);
    unlink(stats);
    return matrix_run_tyndall(list, out);
}

void matrix_take_failure(const figure_process* process, matrix_cell* out) {
    out->state = process->signal == SIGXCPU || process->signal == SIGKILL ? MATRIX_TOO_LONG
                 : process->status < 0                                    ? MATRIX_CRASHED
                 : process->status == CLI_USAGE                           ? MATRIX_REFUSED
                                                                          : MATRIX_FAILED;
    if (out->state == MATRIX_TOO_LONG)
        snprintf(out->words, sizeof out->words, "more than %d s of processor time", matrix_seconds_max);
    else if (out->state == MATRIX_CRASHED)
        snprintf(out->words, sizeof out->words, "ended by signal %d", process->signal);
    else
        memcpy(out->words, process->words, sizeof out->words);
}

bool matrix_block_means(const ty_image* image, double means[MATRIX_BLOCKS], double variances[MATRIX_BLOCKS]) {
    static const char* const names[3] = {"variance.R", "variance.G", "variance.B"};
    const double weight = 1.0 / (3 * MATRIX_BLOCK * MATRIX_BLOCK);
    const float* planes[3];
    bool finite = ty_image_rgb_planes(image, planes);
    memset(means, 0, MATRIX_BLOCKS * sizeof *means);
    if (variances != NULL) memset(variances, 0, MATRIX_BLOCKS * sizeof *variances);
    for (int c = 0; c < 3 && finite; ++c) {
        const float* spread =
            variances == NULL ? NULL : ty_image_plane_const(image, ty_image_find_channel(image, names[c]));
        for (int y = 0; y < MATRIX_HEIGHT; ++y)
            for (int x = 0; x < MATRIX_WIDTH; ++x) {
                const int i = y * MATRIX_WIDTH + x;
                const int block = y / MATRIX_BLOCK * (MATRIX_WIDTH / MATRIX_BLOCK) + x / MATRIX_BLOCK;
                finite = finite && isfinite(planes[c][i]);
                means[block] += weight * (double)planes[c][i];
                if (spread != NULL) variances[block] += weight * (double)spread[i] / (MATRIX_BLOCK * MATRIX_BLOCK);
            }
    }
    return finite;
}
