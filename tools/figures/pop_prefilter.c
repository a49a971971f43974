/* Fig. 6 of the paper: thin slabs before windows; ordinates without and with prefiltering over their solid angle. */
#include "figures/pop_view.h"

enum { COSINES = 4, ROWS = 4, WIDTH = 160, PICTURE_WIDTH = 280, ORDINATES = 27 };

static const double cosines[COSINES] = {0.95, 0.98, 0.99, 0.999};
static const char* const row_titles[ROWS] = {"path tracing", "without prefiltering", "β = 1", "β = 4"};

/* Beta of each row. */
static const double betas[ROWS] = {0, 0, 1, 4};

static ty_result fill_column(figure_run* run, int column, plot_sheet* sheet) {
    int32_t size[2];
    char override[32];
    const char* const overrides[1] = {override};
    ty_scene* scene = NULL;
    figure_picture pictures[ROWS] = {0};
    figure_view_size(run, WIDTH, WIDTH, size);
    snprintf(override, sizeof override, "media[0].g=%g", cosines[column]);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "g = %g", cosines[column]);
    ty_result result = pop_make_scene(run, "pop_slab", overrides, 1, &scene);
    for (int row = 0; row < ROWS && result == TY_OK; ++row) {
        char item[FIGURE_NAME_SIZE];
        ty_pop_def settings = pop_scene_def(scene);
        settings.prefilter = betas[row];
        settings.ordinates = ORDINATES;
        snprintf(item, sizeof item, "g %g, %s", cosines[column], row_titles[row]);
        result = pop_render(run, item, scene, row > 0 ? &settings : NULL, size, &pictures[row], NULL);
        if (result == TY_OK)
            result = figure_show(run, item, scene, &pictures[row], row > 0 ? &pictures[0] : NULL, false,
                                 plot_sheet_cell(sheet, row, column), NULL);
    }
    for (int row = 0; row < ROWS; ++row) figure_free_picture(&pictures[row]);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_pop_prefilter(figure_run* run) {
    plot_sheet sheet;
    ty_result result = plot_create_sheet(ROWS, COSINES, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    for (int row = 0; row < ROWS; ++row) snprintf(sheet.row_titles[row], PLOT_LABEL_SIZE, "%s", row_titles[row]);
    for (int column = 0; column < COSINES && result == TY_OK; ++column) result = fill_column(run, column, &sheet);
    figure_place_sheet(run, result, &sheet, NULL);
    figure_caption(run,
                   "A slab 0.2 m thick, σs = 40/m, before the windows of a room; %d ordinates. Without prefiltering "
                   "each ordinate shows where scattering widens its light little.",
                   ORDINATES);
    figure_describe_errors(run, true);
    return result;
}
