/* Fig. 8 of the paper: comparison with path tracing, for two scattering strengths. The paper traced only the scattered
 * light of visible surfaces; here that is the relief of the view. The full reference of the room also has attenuation
 * between lights and surfaces, and light from surfaces outside the view. */
#include "figures/screen_relief.h"

#include <math.h>

enum {
    STRENGTHS = 2,
    TRUTHS = 2, /* relief, room */
    METHODS = 3,
    BLOCK = 8,
    SAMPLES = 128,
    SAMPLES_QUICK = 4,
    ROOM_WIDTH = 192,
    PICTURE_WIDTH = 288
};

/* The mean cosine is below that of the other figures, which reduces the reference's noise. */
static const screen_water waters[STRENGTHS] = {{2, 0.9f}, {6, 0.9f}};
static const char* const truth_names[TRUTHS] = {"relief", "room"};

static const struct {
    const char* name;
    ty_screen_variant variant;
} methods[METHODS] = {{"scatter", TY_SCREEN_SCATTER}, {"gather", TY_SCREEN_GATHER}, {"reference", TY_SCREEN_REFERENCE}};

/* One row of the sheet. */
typedef struct truth_row {
    int strength, truth;
    int32_t block;   /* errors are of means over block x block pixels, which reduces the reference's noise */
    ty_image* image; /* path traced, with variance */
    double noise[4]; /* root mean square standard error of those means; R, G, B, all */
} truth_row;

static ty_result trace(figure_run* run, const screen_view* view, const ty_scene* scene, int32_t spp, ty_image** out) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.seed = run->session->common.seed + 1; /* differs from the seed of the surface image */
    def.width = view->width;
    def.height = view->height;
    def.progress = cli_progress_report;
    def.progress_user = &run->session->progress;
    return ty_path_render(scene, &def, out, NULL);
}

static ty_result trace_truth(figure_run* run, const screen_view* view, truth_row* row) {
    ty_scene* scene = NULL;
    const screen_water* water = &waters[row->strength];
    ty_result result =
        row->truth == 0 ? screen_make_relief(run, view, water, &scene) : screen_load_room(run, water, &scene);
    if (result == TY_OK)
        result =
            trace(run, view, scene, figure_samples(run, run->options->quick ? SAMPLES_QUICK : SAMPLES), &row->image);
    ty_scene_destroy(scene);
    return result;
}

/* A relief without a medium reproduces its view. */
static ty_result check_relief(figure_run* run, const screen_view* view) {
    ty_scene* scene = NULL;
    ty_image* image = NULL;
    ty_difference difference;
    ty_result result = screen_make_relief(run, view, NULL, &scene);
    if (result == TY_OK) result = trace(run, view, scene, 1, &image);
    if (result == TY_OK) result = ty_image_compare(run->session->context, image, view->surface, 1, &difference);
    if (result == TY_OK) figure_expect(run, "relief, no medium", "relMSE", "1", difference.rel_mse[3], 0, 1e-4);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    return result;
}

typedef char amount_text[16];

static void format_amount(double amount, amount_text out) {
    if (isnan(amount))
        snprintf(out, sizeof(amount_text), "< noise");
    else
        snprintf(out, sizeof(amount_text), "%.3g", amount);
}

static void write_lines(const double rmse[4], double mean, double energy, plot_cell* errors) {
    amount_text texts[4];
    for (int c = 0; c < 3; ++c) format_amount(rmse[c], texts[c]);
    format_amount(rmse[3] / mean, texts[3]);
    snprintf(errors->lines[0], PLOT_LABEL_SIZE, "RMSE R %s, G %s, B %s", texts[0], texts[1], texts[2]);
    snprintf(errors->lines[1], PLOT_LABEL_SIZE, "relative %s, energy %.3g", texts[3], energy);
}

static void note_method(figure_run* run, const truth_row* row, int method, const ty_difference* difference,
                        plot_cell* errors) {
    static const char* const channels[3] = {"RMSE R", "RMSE G", "RMSE B"};
    char item[FIGURE_NAME_SIZE];
    double rmse[4];
    snprintf(item, sizeof item, "%s, %s, thickness %g", methods[method].name, truth_names[row->truth],
             waters[row->strength].thickness);
    for (int c = 0; c < 4; ++c) rmse[c] = bench_without_noise(difference->rmse[c], row->noise[c]);
    for (int c = 0; c < 3; ++c) figure_note(run, item, channels[c], "W m^-2 sr^-1", rmse[c]);
    const double mean = difference->rmse[3] / difference->relative_rmse[3];
    figure_notes(run, item, {"relative RMSE", "1", rmse[3] / mean}, {"relMSE, with noise", "1", difference->rel_mse[3]},
                 {"energy ratio", "1", difference->mean_ratio[3]});
    write_lines(rmse, mean, difference->mean_ratio[3], errors);
}

static ty_result fill_method(figure_run* run, const screen_view* view, const truth_row* row, int method,
                             plot_cell* cell, plot_cell* errors) {
    ty_screen_def def = screen_room_def(view, &waters[row->strength]);
    def.variant = methods[method].variant;
    ty_image* image = NULL;
    ty_difference difference;
    ty_result result = screen_apply(run, view, &def, &image, NULL);
    if (result == TY_OK) result = ty_image_compare(run->session->context, image, row->image, row->block, &difference);
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, image, view->camera.exposure, &cell->picture);
    if (result == TY_OK) result = figure_error_map(run, image, row->image, row->block, &errors->picture);
    ty_image_destroy(image);
    if (result == TY_OK) note_method(run, row, method, &difference, errors);
    return result;
}

/* Columns: the reference, the methods, the methods' errors. */
static ty_result fill_row(figure_run* run, const screen_view* view, int index, plot_sheet* sheet) {
    const bool small = view->width < BLOCK || view->height < BLOCK;
    truth_row row = {.strength = index % STRENGTHS, .truth = index / STRENGTHS, .block = small ? 1 : BLOCK};
    plot_cell* truth = plot_sheet_cell(sheet, index, 0);
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "path, %s, thickness %g", truth_names[row.truth], waters[row.strength].thickness);
    snprintf(sheet->row_titles[index], PLOT_LABEL_SIZE, "%s, τ = %g", truth_names[row.truth],
             waters[row.strength].thickness);
    ty_result result = trace_truth(run, view, &row);
    if (result == TY_OK) {
        bench_noise(row.image, row.block, row.noise);
        snprintf(truth->lines[0], PLOT_LABEL_SIZE, "own noise: RMS %.3g", row.noise[3]);
        figure_note(run, item, "noise, RMS", "W m^-2 sr^-1", row.noise[3]);
    }
    if (result == TY_OK)
        result = plot_picture_of_image(run->session->context, row.image, view->camera.exposure, &truth->picture);
    for (int method = 0; method < METHODS && result == TY_OK; ++method)
        result = fill_method(run, view, &row, method, plot_sheet_cell(sheet, index, 1 + method),
                             plot_sheet_cell(sheet, index, 1 + METHODS + method));
    ty_image_destroy(row.image);
    return result;
}

static void place_on_page(figure_run* run, plot_sheet* sheet) {
    snprintf(sheet->column_titles[0], PLOT_LABEL_SIZE, "path traced");
    for (int method = 0; method < METHODS; ++method) {
        snprintf(sheet->column_titles[1 + method], PLOT_LABEL_SIZE, "%s", methods[method].name);
        snprintf(sheet->column_titles[1 + METHODS + method], PLOT_LABEL_SIZE, "error of %s", methods[method].name);
    }
    plot_page_sheet(&run->page, sheet);
    plot_page_color_bar(&run->page, &figure_error_scale);
}

ty_result figure_screen_truth(figure_run* run) {
    int32_t size[2];
    screen_view view = {0};
    plot_sheet sheet = {0};
    screen_room_size(run, ROOM_WIDTH, size);
    ty_result result = screen_render_room(run, size, &view);
    if (result == TY_OK) result = check_relief(run, &view);
    if (result == TY_OK) result = plot_create_sheet(STRENGTHS * TRUTHS, 1 + 2 * METHODS, PICTURE_WIDTH, &sheet);
    for (int row = 0; row < STRENGTHS * TRUTHS && result == TY_OK; ++row) result = fill_row(run, &view, row, &sheet);
    if (result == TY_OK) place_on_page(run, &sheet);
    plot_free_sheet(&sheet);
    screen_free_view(&view);
    figure_caption(run,
                   "The builtin scene screen_room, %d × %d pixels, g = %g, scattering of optical thickness τ as far as "
                   "the back wall (%g m). Relief: every pixel is a facet that sends what the image shows and reflects "
                   "nothing, which is what screen-space methods know of a scene. Room: the lit scene itself, with all "
                   "that they cannot know. The truth's own noise is taken out of each RMSE, W m⁻² sr⁻¹ (< noise: "
                   "nothing is left). Errors are of means over %d × %d pixels. Scatter spreads light as small-angle "
                   "theory has it, gather and reference by the paper's Gaussian.",
                   size[0], size[1], (double)waters[0].g, SCREEN_ROOM_DEPTH, BLOCK, BLOCK);
    return result;
}
