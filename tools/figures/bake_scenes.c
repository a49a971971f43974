/* Figs. 8 and 12 of the paper: a staircase in heterogeneous fog, baked per vertex, and fog lit by a local light and by
 * the sun. */
#include "figures/bake_view.h"

#include <stdlib.h>
#include <string.h>

enum { METHODS = 5, SURFACES = 0, ATTENUATION = 1, IMPULSE = 2, CELLS = 3, TRUTH = 4 };

static const char* const titles[METHODS] = {"without media", "attenuation", "impulse responses", "cache",
                                            "path tracing"};
static const ty_bake_method methods[METHODS] = {TY_BAKE_SURFACES, TY_BAKE_ATTENUATION, TY_BAKE_IMPULSE, TY_BAKE_CACHE,
                                                TY_BAKE_PATH};

/* A view baked by all compared methods. */
typedef struct baked_view {
    bake_view view;
    ty_bake_light* light[METHODS];
    double seconds[METHODS];
} baked_view;

static void free_baked(baked_view* b) {
    for (int m = 0; m < METHODS; ++m) free(b->light[m]);
    bake_view_free(&b->view);
}

static ty_result bake_all(figure_run* run, const char* item, const ty_scene* scene, const ty_impulse* tables, int first,
                          int past, baked_view* b) {
    ty_result result = TY_OK;
    for (int m = first; m < past && result == TY_OK; ++m) {
        ty_bake_def def = ty_default_bake_def();
        char own_item[FIGURE_NAME_SIZE];
        snprintf(own_item, sizeof own_item, "%.30s, %s", item, titles[m]);
        def.method = methods[m];
        def.composition = TY_BAKE_PUBLISHED;
        def.tables = tables;
        def.scatterings = m >= CELLS ? TY_IMPULSE_BOUNCES_MAX : def.scatterings;
        def.spp = bake_spp(run, m == TRUTH);
        def.seed = (uint64_t)m;
        result =
            bake_view_light(run, own_item, scene, &def, b->view.receivers, b->view.count, &b->light[m], &b->seconds[m]);
    }
    return TY_OK;
}

static ty_result show(figure_run* run, const baked_view* b, int method, bake_component component, double exposure,
                      plot_cell* cell) {
    ty_image* image = NULL;
    ty_result result = bake_view_image(run, &b->view, b->light[method], component, &image);
    if (result == TY_OK) result = plot_picture_of_image(run->session->context, image, exposure, &cell->picture);
    ty_image_destroy(image);
    return result;
}

static ty_result show_errors(figure_run* run, const baked_view* b, int method, bake_component component,
                             plot_cell* cell) {
    ty_image *image = NULL, *truth = NULL;
    ty_result result = bake_view_image(run, &b->view, b->light[method], component, &image);
    if (result == TY_OK) result = bake_view_image(run, &b->view, b->light[TRUTH], component, &truth);
    if (result == TY_OK) result = figure_error_map(run, image, truth, run->options->quick ? 1 : 2, &cell->picture);
    ty_image_destroy(image);
    ty_image_destroy(truth);
    return result;
}

static ty_result make_tables(figure_run* run, ty_impulse** out) {
    const ty_impulse_def def = ty_default_impulse_def();
    return ty_impulse_create(run->session->context, &def, out, NULL);
}

/* ---- Fig. 8: the staircase ---- */

enum { STAIR_WIDTH = 108, STAIR_HEIGHT = 192, STAIR_PICTURE = 240 };

/* Columns: radiance cache per vertex and per pixel, reference per pixel, errors per pixel. Impulse responses are
 * compared, too. */
static ty_result fill_stairs(figure_run* run, const baked_view* vertices, const baked_view* b, plot_sheet* sheet) {
    static const char* const rows[2] = {"all light", "scattered by media"};
    static const double exposures[2] = {-1, 0};
    ty_result result = TY_OK;
    for (int row = 0; row < 2 && result == TY_OK; ++row) {
        char item[FIGURE_NAME_SIZE];
        const bake_component component = (bake_component)row;
        const bake_errors errors = bake_compare(b->light[CELLS], b->light[TRUTH], b->view.count, component);
        plot_cell* cell = plot_sheet_cell(sheet, row, 3);
        snprintf(item, sizeof item, "staircase, %s", rows[row]);
        snprintf(sheet->row_titles[row], PLOT_LABEL_SIZE, "%s", rows[row]);
        const bake_errors impulse_errors = bake_compare(b->light[IMPULSE], b->light[TRUTH], b->view.count, component);
        bake_note_errors(run, item, &errors, row == 0 && !run->options->quick);
        snprintf(item, sizeof item, "staircase, %.30s, impulse", rows[row]);
        if (result == TY_OK) bake_note_errors(run, item, &impulse_errors, false);
        if (result == TY_OK)
            result = show(run, vertices, CELLS, component, exposures[row], plot_sheet_cell(sheet, row, 0));
        if (result == TY_OK) result = show(run, b, CELLS, component, exposures[row], plot_sheet_cell(sheet, row, 1));
        if (result == TY_OK) result = show(run, b, TRUTH, component, exposures[row], plot_sheet_cell(sheet, row, 2));
        if (result == TY_OK) result = show_errors(run, b, CELLS, component, cell);
        bake_write_errors("means", &errors, cell->lines[0]);
    }
    snprintf(plot_sheet_cell(sheet, 0, 0)->lines[0], PLOT_LABEL_SIZE, "%.3g s", vertices->seconds[CELLS]);
    snprintf(plot_sheet_cell(sheet, 0, 1)->lines[0], PLOT_LABEL_SIZE, "%.3g s", b->seconds[CELLS]);
    snprintf(plot_sheet_cell(sheet, 0, 2)->lines[0], PLOT_LABEL_SIZE, "%.3g s", b->seconds[TRUTH]);
    return result;
}

static ty_result show_stairs(figure_run* run, const ty_scene* scene, const ty_impulse* tables) {
    static const char* const columns[4] = {"by vertex", "cache", "path tracing", "errors"};
    baked_view vertices = {.view = {.count = 0}}, b = {.view = {.count = 0}};
    int32_t size[2];
    plot_sheet sheet;
    figure_view_size(run, STAIR_WIDTH, STAIR_HEIGHT, size);
    ty_result result = plot_create_sheet(2, 4, STAIR_PICTURE, &sheet);
    if (result != TY_OK) return result;
    for (int i = 0; i < 4; ++i) snprintf(sheet.column_titles[i], PLOT_LABEL_SIZE, "%s", columns[i]);
    result = bake_view_create(scene, size, true, &vertices.view);
    if (result == TY_OK) result = bake_view_create(scene, size, false, &b.view);
    if (result == TY_OK) result = bake_all(run, "staircase by vertex", scene, tables, CELLS, TRUTH, &vertices);
    if (result == TY_OK) result = bake_all(run, "staircase", scene, tables, IMPULSE, METHODS, &b);
    if (result == TY_OK) result = fill_stairs(run, &vertices, &b, &sheet);
    figure_place_sheet(run, result, &sheet, &figure_error_scale);
    figure_caption(run,
                   "Irradiance in smoke of noise. By the %lld vertices that the camera sees, which suits the fine "
                   "parts of the model and not its walls, whose few vertices lie behind others; and at every pixel. "
                   "Light in cells at %d paths, path tracing at %d.",
                   (long long)vertices.view.count, (int)bake_spp(run, false), (int)bake_spp(run, true));
    free_baked(&vertices);
    free_baked(&b);
    return result;
}

ty_result figure_bake_staircase(figure_run* run) {
    char path[FIGURE_PATH_SIZE];
    ty_scene* scene = NULL;
    ty_impulse* tables = NULL;
    if (!figure_find_data(run, STAIRCASE_FILE, path)) return TY_OK;
    ty_result result = figure_load_scene(run, "bake_staircase", NULL, 0, &scene);
    if (result == TY_OK) result = make_tables(run, &tables);
    if (result == TY_OK) result = show_stairs(run, scene, tables);
    ty_impulse_destroy(tables);
    ty_scene_destroy(scene);
    return result;
}

/* ---- Fig. 12: a local light and the sun ---- */

enum { LIGHTS = 2, VIEW_WIDTH = 160, VIEW_HEIGHT = 120, VIEW_PICTURE = 240 };

/* A hall with a door and pillars, in fog. */
static const struct {
    const char *name, *override;
    double exposure;
} lights[LIGHTS] = {
    {"point", "lights[0].intensity=10", -1.5},
    {"directional", "lights[0]={\"type\": \"directional\", \"direction\": [-0.7, -1, -0.3], \"irradiance\": 6}", -2},
};

static ty_result fill_light(figure_run* run, int row, const baked_view* b, plot_sheet* sheet) {
    ty_result result = TY_OK;
    snprintf(sheet->row_titles[row], PLOT_LABEL_SIZE, "%s", lights[row].name);
    for (int m = 0; m < METHODS && result == TY_OK; ++m) {
        plot_cell* cell = plot_sheet_cell(sheet, row, m);
        char item[FIGURE_NAME_SIZE];
        const bake_errors errors = bake_compare(b->light[m], b->light[TRUTH], b->view.count, BAKE_ALL);
        snprintf(item, sizeof item, "%s, %s", lights[row].name, titles[m]);
        result = show(run, b, m, BAKE_ALL, lights[row].exposure, cell);
        if (result == TY_OK && m != TRUTH) bake_note_errors(run, item, &errors, m == CELLS && !run->options->quick);
        snprintf(cell->lines[0], PLOT_LABEL_SIZE, "%.3g s", b->seconds[m]);
        if (m != TRUTH) bake_write_errors("means", &errors, cell->lines[1]);
    }
    if (result == TY_OK) result = show_errors(run, b, CELLS, BAKE_ALL, plot_sheet_cell(sheet, row, METHODS));
    return result;
}

static ty_result show_light(figure_run* run, int row, const ty_impulse* tables, plot_sheet* sheet) {
    const char* const overrides[1] = {lights[row].override};
    int32_t size[2];
    ty_scene* scene = NULL;
    baked_view b = {.view = {.count = 0}};
    figure_view_size(run, VIEW_WIDTH, VIEW_HEIGHT, size);
    ty_result result = figure_load_scene(run, "bake_hall", overrides, 1, &scene);
    if (result == TY_OK) result = bake_view_create(scene, size, false, &b.view);
    if (result == TY_OK) result = bake_all(run, lights[row].name, scene, tables, SURFACES, METHODS, &b);
    if (result == TY_OK) result = fill_light(run, row, &b, sheet);
    free_baked(&b);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_bake_lights(figure_run* run) {
    plot_sheet sheet;
    ty_impulse* tables = NULL;
    ty_result result = plot_create_sheet(LIGHTS, METHODS + 1, VIEW_PICTURE, &sheet);
    if (result != TY_OK) return result;
    for (int m = 0; m < METHODS; ++m) snprintf(sheet.column_titles[m], PLOT_LABEL_SIZE, "%s", titles[m]);
    snprintf(sheet.column_titles[METHODS], PLOT_LABEL_SIZE, "errors of the cache");
    result = make_tables(run, &tables);
    for (int row = 0; row < LIGHTS && result == TY_OK; ++row) result = show_light(run, row, tables, &sheet);
    figure_place_sheet(run, result, &sheet, &figure_error_scale);
    ty_impulse_destroy(tables);
    figure_caption(run,
                   "Irradiance of what a camera sees of a hall, 8 m x 10 m, in fog of σs = 0.15/m. %d paths a pixel, "
                   "path tracing %d. Ratios of means and relative RMSE against path tracing, without its noise.",
                   (int)bake_spp(run, false), (int)bake_spp(run, true));
    return result;
}
