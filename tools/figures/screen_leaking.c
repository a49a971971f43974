/* Fig. 6 of the paper: the effect of each part of the method on near highlights that leak onto far surfaces. */
#include "figures/screen_view.h"

#include <math.h>

enum { STAGES = 7, REFERENCE_WINDOW = 100, PAGE_WIDTH = 1900, ROOM_WIDTH = 288 };

static const screen_water water = {.thickness = 4, .g = 0.97f};

static void make_naive(ty_screen_def* def) {
    ty_screen_naive_def(def);
}

static void make_step(ty_screen_def* def) {
    ty_screen_naive_def(def);
    def->mask = TY_SCREEN_MASK_STEP;
}

static void make_smooth(ty_screen_def* def) {
    ty_screen_naive_def(def);
    def->mask = TY_SCREEN_MASK_SMOOTH;
}

static void make_weighted(ty_screen_def* def) {
    make_smooth(def);
    def->luminance_weights = true;
}

static void make_gather(ty_screen_def* def) {
    def->variant = TY_SCREEN_GATHER;
}

static void make_published(ty_screen_def* def) {
    ty_screen_published_def(def);
}

/* The same spread as in all other variants. */
static void make_scatter(ty_screen_def* def) {
    def->variant = TY_SCREEN_SCATTER;
    def->spread = TY_SCREEN_SPREAD_GAUSSIAN;
}

static const struct {
    const char *name, *title;
    void (*make)(ty_screen_def* def);
} stages[STAGES] = {
    {"naive", "(a) naive", make_naive},
    {"step", "(b) step mask", make_step},
    {"smoothstep", "(c) smoothstep mask", make_smooth},
    {"luminance", "(d) luminance weights", make_weighted},
    {"gather", "(e) blurred distance", make_gather},
    {"published", "(e), masks not normalised", make_published},
    {"scatter", "scatter (ours), Gaussian", make_scatter},
};

/* Detail: the near lights in front of the far wall. */
static void choose_crop(const screen_view* view, int32_t cut[4]) {
    cut[0] = (int32_t)(0.36 * view->width);
    cut[1] = (int32_t)(0.26 * view->height);
    cut[2] = (int32_t)fmax(0.16 * view->width, 1);
    cut[3] = (int32_t)fmax(0.24 * view->height, 1);
}

static ty_result fill_cell(figure_run* run, const screen_view* view, const ty_image* image, plot_cell* cell) {
    int32_t cut[4];
    choose_crop(view, cut);
    ty_result result = plot_picture_of_image(run->session->context, image, view->camera.exposure, &cell->picture);
    return result == TY_OK ? plot_enlarge(cell, cut) : result;
}

/* The surface image, its distances, and the reference over a window and unbounded. */
static ty_result fill_references(figure_run* run, const screen_view* view, plot_sheet* sheet, ty_image** reference) {
    ty_screen_def def = screen_room_def(view, &water);
    ty_screen_stats stats = ty_default_screen_stats();
    ty_image* windowed = NULL;
    ty_difference difference;
    def.variant = TY_SCREEN_REFERENCE;
    ty_result result = screen_apply(run, view, &def, reference, &stats);
    if (result == TY_OK)
        figure_notes(run, "reference", {"time", "s", stats.seconds},
                     {"largest half-light radius", "pixel", stats.spread});
    def.window = REFERENCE_WINDOW;
    if (result == TY_OK) result = screen_apply(run, view, &def, &windowed, &stats);
    if (result == TY_OK) figure_note(run, "reference 100x100", "time", "s", stats.seconds);
    if (result == TY_OK) result = figure_note_difference(run, "reference 100x100", windowed, *reference, &difference);
    if (result == TY_OK) result = fill_cell(run, view, view->surface, &sheet->cells[0]);
    if (result == TY_OK) result = screen_distance_picture(run, view, &sheet->cells[1].picture);
    if (result == TY_OK) result = fill_cell(run, view, windowed, &sheet->cells[2]);
    if (result == TY_OK) result = fill_cell(run, view, *reference, &sheet->cells[3]);
    ty_image_destroy(windowed);
    if (result != TY_OK) return result;
    snprintf(sheet->cells[0].title, PLOT_LABEL_SIZE, "image without a medium");
    snprintf(sheet->cells[1].title, PLOT_LABEL_SIZE, "distance, near is bright");
    snprintf(sheet->cells[2].title, PLOT_LABEL_SIZE, "(f) reference, 100 × 100 pixels, relMSE %.2g",
             difference.rel_mse[3]);
    snprintf(sheet->cells[3].title, PLOT_LABEL_SIZE, "reference, unbounded");
    return TY_OK;
}

/* The image of one stage, and its error map below. */
static ty_result fill_stage(figure_run* run, const screen_view* view, int stage, const ty_image* reference,
                            plot_sheet* sheet) {
    ty_screen_def def = screen_room_def(view, &water);
    stages[stage].make(&def);
    ty_image* image = NULL;
    ty_screen_stats stats = ty_default_screen_stats();
    ty_difference difference;
    plot_cell *cell = plot_sheet_cell(sheet, 0, stage), *errors = plot_sheet_cell(sheet, 1, stage);
    ty_result result = screen_apply(run, view, &def, &image, &stats);
    if (result == TY_OK) result = figure_note_difference(run, stages[stage].name, image, reference, &difference);
    if (result == TY_OK) figure_note(run, stages[stage].name, "time", "s", stats.seconds);
    if (result == TY_OK) result = fill_cell(run, view, image, cell);
    if (result == TY_OK) result = figure_error_map(run, image, reference, 1, &errors->picture);
    ty_image_destroy(image);
    if (result != TY_OK) return result;
    snprintf(sheet->column_titles[stage], PLOT_LABEL_SIZE, "%s", stages[stage].title);
    snprintf(errors->lines[0], PLOT_LABEL_SIZE, "RMSE %.3g, relative %.3g", difference.rmse[3],
             difference.relative_rmse[3]);
    snprintf(errors->lines[1], PLOT_LABEL_SIZE, "relMSE %.2g", difference.rel_mse[3]);
    snprintf(errors->lines[2], PLOT_LABEL_SIZE, "energy %.4g of the reference's", difference.mean_ratio[3]);
    return TY_OK;
}

static ty_result fill_page(figure_run* run, const screen_view* view) {
    plot_sheet references = {0}, sheet = {0};
    ty_image* reference = NULL;
    ty_result result = plot_create_sheet(1, 4, (PAGE_WIDTH - 30) / 4, &references);
    if (result == TY_OK) result = plot_create_sheet(2, STAGES, (PAGE_WIDTH - 60) / STAGES, &sheet);
    if (result == TY_OK) result = fill_references(run, view, &references, &reference);
    for (int stage = 0; stage < STAGES && result == TY_OK; ++stage)
        result = fill_stage(run, view, stage, reference, &sheet);
    if (result == TY_OK) {
        plot_page_sheet(&run->page, &references);
        plot_page_sheet(&run->page, &sheet);
        plot_page_color_bar(&run->page, &figure_error_scale);
    }
    ty_image_destroy(reference);
    plot_free_sheet(&references);
    plot_free_sheet(&sheet);
    return result;
}

ty_result figure_screen_leaking(figure_run* run) {
    int32_t size[2];
    screen_view view = {0};
    screen_room_size(run, ROOM_WIDTH, size);
    ty_result result = screen_render_room(run, size, &view);
    if (result == TY_OK) result = fill_page(run, &view);
    screen_free_view(&view);
    figure_caption(
        run,
        "The builtin scene screen_room, %d × %d pixels, scattering of optical thickness %g as far as the back wall (%g "
        "m), g = %g. Two bright lamps hang 2.6 m and 3.4 m away before the dark wall; the insets enlarge one. Below: "
        "the error against the unbounded reference, red where too bright. RMSE in W m⁻² sr⁻¹.",
        size[0], size[1], water.thickness, SCREEN_ROOM_DEPTH, (double)water.g);
    return result;
}
