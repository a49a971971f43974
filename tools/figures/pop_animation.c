/* Fig. 16 of the paper: a growing plume, each frame solved anew. */
#include "figures/view.h"

#include <math.h>

enum { FRAMES = 5, ROWS = 2, FIRST_SMOOTH = 2 };

#define FRAME(number)                                                                                                  \
    {                                                                                                                  \
        .title = "frame " #number, .scene = "pop_plume_frames", .overrides = {"frame=" #number}, .width = 168,         \
        .height = 224, .file = "volumes/plume/plume_00" #number ".vdb"                                                 \
    }
static const figure_scene scenes[FRAMES] = {FRAME(20), FRAME(30), FRAME(40), FRAME(41), FRAME(42)};

/* Difference of successive frames, by both methods: the relative RMSE, corrected for the path tracer's noise, and the
 * change of the mean. */
static ty_result compare_frames(figure_run* run, int frame, const figure_matrix* matrix, plot_table* table) {
    char item[FIGURE_NAME_SIZE];
    double changes[ROWS], means[ROWS];
    snprintf(item, sizeof item, "frames %.2s to %.2s", scenes[frame - 1].title + 6, scenes[frame].title + 6);
    for (int row = 0; row < ROWS; ++row) {
        const ty_image *before = matrix->pictures[frame - 1][row].image, *now = matrix->pictures[frame][row].image;
        double noise[2][4] = {{0}, {0}};
        ty_difference difference;
        const int32_t block = figure_block(now);
        const ty_result result = ty_image_compare(run->session->context, now, before, block, &difference);
        if (result != TY_OK) return result;
        if (row == 0) bench_noise(before, block, noise[0]);
        if (row == 0) bench_noise(now, block, noise[1]);
        const double mean = difference.rmse[3] / difference.relative_rmse[3];
        changes[row] = bench_without_noise(difference.rmse[3], hypot(noise[0][3], noise[1][3])) / mean;
        means[row] = difference.mean_ratio[3];
    }
    const int line = frame - FIRST_SMOOTH;
    plot_set_cell(table, line, 0, "%s", item);
    for (int row = 0; row < ROWS; ++row) {
        char change[16];
        figure_format_error(changes[row], change);
        plot_set_cell(table, line, 1 + row, "%s", change);
        plot_set_cell(table, line, 3 + row, "%+.2f %%", 100 * (means[row] - 1));
    }
    figure_expect(run, item, "change of the mean", "1", means[1], means[0], 0.01);
    figure_expect(run, item, "change, relative RMSE", "1", changes[1], changes[0], NAN);
    return TY_OK;
}

static ty_result fill_table(figure_run* run, const figure_matrix* matrix, plot_table* table) {
    static const char* const heads[] = {"from frame to frame", "change, path tracing", "change, split",
                                        "mean, path tracing", "mean, split"};
    ty_result result = TY_OK;
    for (int column = 0; column < 5; ++column) plot_set_cell(table, 0, column, "%s", heads[column]);
    for (int frame = 0; frame < FRAMES && result == TY_OK; ++frame) {
        char item[FIGURE_NAME_SIZE];
        snprintf(item, sizeof item, "%s, split", scenes[frame].title);
        figure_expect(run, item, "mean ratio of split", "1", matrix->errors[frame][1].mean_ratio, 1, 0.1);
    }
    for (int frame = FIRST_SMOOTH + 1; frame < FRAMES && result == TY_OK; ++frame)
        result = compare_frames(run, frame, matrix, table);
    return result;
}

ty_result figure_pop_animation(figure_run* run) {
    char path[FIGURE_PATH_SIZE];
    const figure_variant variants[ROWS] = {figure_path, {.title = "split", .method = &ty_method_pop}};
    figure_matrix matrix = {.scenes = scenes, .scene_count = FRAMES, .variants = variants, .variant_count = ROWS};
    plot_table table = {0};
    for (int frame = 0; frame < FRAMES; ++frame)
        if (!figure_find_data(run, scenes[frame].file, path)) return TY_OK;
    ty_result result = figure_show_matrix(run, &matrix, 250);
    if (result == TY_OK) result = plot_create_table(FRAMES - FIRST_SMOOTH, 5, 1, &table);
    if (result == TY_OK) result = fill_table(run, &matrix, &table);
    if (result == TY_OK) plot_page_table(&run->page, &table);
    plot_free_table(&table);
    figure_free_matrix(&matrix);
    figure_caption(run,
                   "Simulated smoke under the sky, g = 0.7, each frame solved anew, without history. Below: relative "
                   "RMSE of a frame to the one before (path tracing's without its noise), and how the mean changes.");
    figure_describe_errors(run, false);
    return result;
}
