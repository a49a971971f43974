/* Fig. 6 of the paper: a thin wall with a strong light on its far side, a small bright spot, a single iteration. */
#include "base/constants.h"
#include "figures/view.h"

#include <math.h>
#include <string.h>

enum { COLUMNS = 3, ROWS = 3, BLEEDING = 0, LINKS = 1, WIDTH = 240, HEIGHT = 160, PICTURE_WIDTH = 300 };

/* The wall is 10 cm thick, cells are half a metre wide. */
/* Radiance of the wall on the light's axis: albedo 0.7, 400 W sr^-1 at 4.1 m. */
static const double lit_radiance = 0.7 * 400 / (4.1 * 4.1) / TY_PI_F64;

static const char to_lit_side[] = "camera.position=[3,2.6,7]";
static const struct {
    const char* title;
    const char* overrides[3];
    int32_t override_count;
    bool single; /* a single iteration */
} columns[COLUMNS] = {
    {"(a) through a thin wall", {0}, 0, false},
    {"(b) a small bright spot", {to_lit_side, "lights[0].cone=6", "camera.exposure=0"}, 3, false},
    {"(c) a single iteration", {to_lit_side, "lights[0].cone=6", "camera.exposure=0"}, 3, true},
};
static const figure_variant rows[2][ROWS] = {
    {{.title = "path tracing", .method = &ty_method_path},
     {.title = "links", .method = &ty_method_lpv, .options = "mode=links"},
     {.title = "published", .method = &ty_method_lpv, .options = "mode=published"}},
    {{.title = "path tracing", .method = &ty_method_path},
     {.title = "links", .method = &ty_method_lpv, .options = "mode=links iterations=1"},
     {.title = "published", .method = &ty_method_lpv, .options = "mode=published iterations=1"}}};

/* Links must transmit less than 1 % of the radiance of the lit side. */
static void note_leak(figure_run* run, const char* item, int row, double leaked) {
    const double fraction = leaked / lit_radiance;
    figure_expect(run, item, "leaked, of the lit side's radiance", "1", fraction, row == LINKS ? 0 : NAN,
                  row == LINKS ? 0.01 : NAN);
}

static ty_result fill_column(figure_run* run, ty_scene* scene, int column, plot_sheet* sheet) {
    int32_t size[2];
    figure_picture pictures[ROWS] = {0};
    ty_result result = TY_OK;
    figure_view_size(run, WIDTH, HEIGHT, size);
    snprintf(sheet->column_titles[column], PLOT_LABEL_SIZE, "%s", columns[column].title);
    for (int row = 0; row < ROWS && result == TY_OK; ++row) {
        char item[FIGURE_NAME_SIZE];
        const figure_variant* variant = &rows[columns[column].single][row];
        snprintf(item, sizeof item, "%s, %s", columns[column].title, variant->title);
        result = figure_render_variant(run, item, scene, variant, size, &pictures[row], NULL);
        if (result == TY_OK)
            result = figure_show(run, item, scene, &pictures[row], row > 0 ? &pictures[0] : NULL, false,
                                 plot_sheet_cell(sheet, row, column), NULL);
        if (result == TY_OK && row > 0 && column == BLEEDING)
            note_leak(run, item, row, figure_mean(pictures[row].image) - figure_mean(pictures[0].image));
    }
    for (int row = 0; row < ROWS; ++row) figure_free_picture(&pictures[row]);
    return result;
}

ty_result figure_lpv_leaking(figure_run* run) {
    plot_sheet sheet;
    ty_result result = plot_create_sheet(ROWS, COLUMNS, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    for (int row = 0; row < ROWS; ++row) snprintf(sheet.row_titles[row], PLOT_LABEL_SIZE, "%s", rows[0][row].title);
    for (int column = 0; column < COLUMNS && result == TY_OK; ++column) {
        ty_scene* scene = NULL;
        result =
            figure_load_scene(run, "lpv_thin_wall", columns[column].overrides, columns[column].override_count, &scene);
        if (result == TY_OK) result = fill_column(run, scene, column, &sheet);
        ty_scene_destroy(scene);
    }
    figure_place_sheet(run, result, &sheet, NULL);
    figure_caption(run, "A wall 10 cm thick in thin fog, in a lattice of half a metre. (a): from its dark side, the "
                        "lamp on the other; what is brighter than path tracing has leaked. (b): the lit side, the lamp "
                        "on less than a cell. (c): the same after one iteration of propagation.");
    figure_describe_errors(run, false);
    return result;
}
