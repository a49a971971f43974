/* Fig. 16 of the paper: a growing plume, each frame solved anew. */
#include "figures/pop_view.h"

#include <math.h>
#include <string.h>

enum { FRAMES = 5, ROWS = 2, WIDTH = 168, HEIGHT = 224, PICTURE_WIDTH = 250, FIRST_SMOOTH = 2 };

static const int frames[FRAMES] = {20, 30, 40, 41, 42};
static const char* const row_titles[ROWS] = {"path tracing", "split"};

static ty_result fill_frame(figure_run* run, int frame, figure_picture pictures[ROWS], plot_sheet* sheet) {
    int32_t size[2];
    char override[16];
    const char* const overrides[1] = {override};
    ty_scene* scene = NULL;
    figure_view_size(run, WIDTH, HEIGHT, size);
    snprintf(override, sizeof override, "frame=%d", frames[frame]);
    snprintf(sheet->column_titles[frame], PLOT_LABEL_SIZE, "frame %d", frames[frame]);
    ty_result result = figure_load_scene(run, "pop_plume_frames", overrides, 1, &scene);
    for (int row = 0; row < ROWS && result == TY_OK; ++row) {
        char item[FIGURE_NAME_SIZE];
        figure_errors errors;
        const ty_pop_def settings = pop_scene_def(scene);
        snprintf(item, sizeof item, "frame %d, %s", frames[frame], row_titles[row]);
        result = pop_render(run, item, scene, row == 1 ? &settings : NULL, size, &pictures[row], NULL);
        if (result == TY_OK)
            result = figure_show(run, item, scene, &pictures[row], row > 0 ? &pictures[0] : NULL, false,
                                 plot_sheet_cell(sheet, row, frame), &errors);
        if (result == TY_OK && row == 1)
            result = figure_expect(run, item, "mean ratio of split", "1", errors.mean_ratio, 1, 0.1);
    }
    ty_scene_destroy(scene);
    return result;
}

/* Difference of successive frames, by both methods: the relative RMSE, corrected for the path tracer's noise, and the
 * change of the mean. */
static ty_result compare_frames(figure_run* run, int frame, figure_picture (*pictures)[ROWS], plot_table* table) {
    char item[FIGURE_NAME_SIZE];
    double changes[ROWS], means[ROWS];
    snprintf(item, sizeof item, "frames %d to %d", frames[frame - 1], frames[frame]);
    for (int row = 0; row < ROWS; ++row) {
        const ty_image *before = pictures[frame - 1][row].image, *now = pictures[frame][row].image;
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
    ty_result result = figure_expect(run, item, "change of the mean", "1", means[1], means[0], 0.01);
    if (result == TY_OK) result = figure_expect(run, item, "change, relative RMSE", "1", changes[1], changes[0], NAN);
    return result;
}

static ty_result fill_page(figure_run* run, plot_sheet* sheet, plot_table* table) {
    static const char* const heads[] = {"from frame to frame", "change, path tracing", "change, split",
                                        "mean, path tracing", "mean, split"};
    figure_picture pictures[FRAMES][ROWS] = {0};
    ty_result result = TY_OK;
    for (int column = 0; column < 5; ++column) plot_set_cell(table, 0, column, "%s", heads[column]);
    for (int row = 0; row < ROWS; ++row) snprintf(sheet->row_titles[row], PLOT_LABEL_SIZE, "%s", row_titles[row]);
    for (int frame = 0; frame < FRAMES && result == TY_OK; ++frame)
        result = fill_frame(run, frame, pictures[frame], sheet);
    for (int frame = FIRST_SMOOTH + 1; frame < FRAMES && result == TY_OK; ++frame)
        result = compare_frames(run, frame, pictures, table);
    for (int i = 0; i < FRAMES * ROWS; ++i) figure_free_picture(&pictures[i / ROWS][i % ROWS]);
    return result;
}

ty_result figure_pop_animation(figure_run* run) {
    for (int frame = 0; frame < FRAMES; ++frame) {
        char name[48], path[FIGURE_PATH_SIZE];
        snprintf(name, sizeof name, "volumes/plume/plume_%04d.vdb", frames[frame]);
        if (!figure_find_data(run, name, path)) return TY_OK;
    }
    plot_sheet sheet;
    plot_table table = {0};
    ty_result result = plot_create_sheet(ROWS, FRAMES, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    result = plot_create_table(FRAMES - FIRST_SMOOTH, 5, 1, &table);
    if (result == TY_OK) result = fill_page(run, &sheet, &table);
    if (result == TY_OK) {
        plot_page_sheet(&run->page, &sheet);
        plot_page_table(&run->page, &table);
    }
    plot_free_table(&table);
    plot_free_sheet(&sheet);
    figure_caption(run,
                   "Simulated smoke under the sky, g = 0.7, each frame solved anew, without history. Below: relative "
                   "RMSE of a frame to the one before (path tracing's without its noise), and how the mean changes.");
    figure_describe_errors(run, false);
    return result;
}
