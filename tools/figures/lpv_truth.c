/* Figs. 7 and 8 of the paper: scenes in fog against path tracing, and simpler combinations of the method. */
#include "figures/view.h"

#include <math.h>

enum { SCENES = 3, VARIANTS = 8, TRUTH = 0, FULL = 1, BOTH = 2, MARCHED = 3, PICTURE_WIDTH = 250 };

static const figure_variant variants[VARIANTS] = {
    {.title = "path tracing", .method = &ty_method_path},
    {.title = "full", .method = &ty_method_lpv, .options = "mode=links parts=all"},
    {.title = "both added (f)", .method = &ty_method_lpv, .options = "mode=links parts=both"},
    {.title = "plain, marched (e)", .method = &ty_method_lpv, .options = "mode=links parts=plain_march"},
    {.title = "plain (c)", .method = &ty_method_lpv, .options = "mode=links parts=plain"},
    {.title = "full, published", .method = &ty_method_lpv, .options = "mode=published parts=all"},
    {.title = "three bands", .method = &ty_method_lpv, .options = "mode=links parts=all bands=3"},
    {.title = "two cascades", .method = &ty_method_lpv, .options = "mode=links parts=all cascades=2"},
};

static const struct {
    lpv_scene scene;
    int32_t size[2];
} scenes[SCENES] = {{LPV_SPONZA, {320, 180}}, {LPV_ATRIUM, {320, 180}}, {LPV_CORNELL, {192, 192}}};

/* Errors of a scene's variants. */
typedef struct comparison {
    figure_picture truth;
    ty_image* direct;
    figure_errors all[VARIANTS], shadow[VARIANTS];
} comparison;

/* ---- errors in shadow ---- */

/* Sums over a block of pixels: R, G and B of one image. */
static void add_block(const float* const planes[3], int32_t width, int32_t block, int32_t x, int32_t y, double sum[3]) {
    for (int c = 0; c < 3; ++c) {
        sum[c] = 0;
        for (int32_t j = 0; j < block; ++j)
            for (int32_t i = 0; i < block; ++i)
                sum[c] += (double)planes[c][(size_t)(y * block + j) * (size_t)width + (size_t)(x * block + i)];
    }
}

typedef struct shadow_sums {
    double picture, truth, squares, noise;
    int64_t blocks;
} shadow_sums;

static void add_difference(const double picture[3], const double truth[3], const double variance[3], int32_t block,
                           shadow_sums* sums) {
    const double pixels = (double)block * block;
    for (int c = 0; c < 3; ++c) {
        sums->picture += picture[c] / pixels;
        sums->truth += truth[c] / pixels;
        sums->squares += pow((picture[c] - truth[c]) / pixels, 2);
        sums->noise += variance[c] / (pixels * pixels);
    }
    ++sums->blocks;
}

/* Single scattering in front of a surface does not light it; surface radiance below this fraction of the mean is
 * rounding error. */
static const double shadow_fraction = 1e-3;

static bool find_planes(const ty_image* picture, const ty_image* truth, const ty_image* direct,
                        const float* planes[4][3]) {
    static const char* const names[3] = {"variance.R", "variance.G", "variance.B"};
    for (int c = 0; c < 3; ++c) planes[3][c] = ty_image_plane_const(truth, ty_image_find_channel(truth, names[c]));
    return ty_image_rgb_planes(picture, planes[0]) && ty_image_rgb_planes(truth, planes[1]) &&
           ty_image_rgb_planes(direct, planes[2]);
}

static shadow_sums compare_blocks(const float* planes[4][3], const ty_image* direct, int32_t block) {
    const int32_t width = ty_image_width(direct), columns = width / block, rows = ty_image_height(direct) / block;
    const double min_sum = 3.0 * block * block * shadow_fraction * figure_mean(direct);
    shadow_sums sums = {0};
    for (int32_t y = 0; y < rows; ++y)
        for (int32_t x = 0; x < columns; ++x) {
            double values[4][3];
            for (int i = 0; i < 4; ++i) add_block(planes[i], width, block, x, y, values[i]);
            if (values[2][0] + values[2][1] + values[2][2] <= min_sum)
                add_difference(values[0], values[1], values[3], block, &sums);
        }
    return sums;
}

/* Records the errors against the path-traced image in blocks entirely in shadow, by the image of shadow maps alone.
 * Without shadow all errors are NaN. */
static ty_result compare_shadow(figure_run* run, const char* item, const figure_picture* picture,
                                const figure_picture* truth, const ty_image* direct, figure_errors* out) {
    const float* planes[4][3];
    *out = (figure_errors){.mean_ratio = NAN, .relative_rmse = NAN, .rel_mse = NAN};
    if (!find_planes(picture->image, truth->image, direct, planes)) return TY_ERROR_INTERNAL;
    const shadow_sums sums = compare_blocks(planes, direct, figure_block(truth->image));
    if (sums.blocks > 0) {
        const double count = 3.0 * (double)sums.blocks, mean = sums.truth / count;
        out->mean_ratio = sums.picture / sums.truth;
        out->relative_rmse = bench_without_noise(sqrt(sums.squares / count), sqrt(sums.noise / count)) / mean;
    }
    figure_notes(run, item, {"blocks in shadow", "1", (double)sums.blocks},
                 {"mean ratio in shadow", "1", out->mean_ratio}, {"relative RMSE in shadow", "1", out->relative_rmse});
    return TY_OK;
}

/* The scene by shadow maps alone: black where surfaces are in shadow. */
static ty_result render_direct(const ty_scene* scene, const int32_t size[2], ty_image** out) {
    ty_lpv_def def;
    const ty_result result = figure_method_def(scene, &ty_method_lpv, "mode=links parts=shadow_map", &def);
    def.width = size[0];
    def.height = size[1];
    return result == TY_OK ? ty_lpv_render(scene, &def, out, NULL) : result;
}

/* ---- scenes ---- */

static ty_result show_variant(figure_run* run, const char* name, ty_scene* scene, int v, const int32_t size[2],
                              comparison* compared, plot_sheet* sheet) {
    char item[FIGURE_NAME_SIZE];
    figure_picture picture = {0};
    const figure_picture* truth = v == TRUTH ? NULL : &compared->truth;
    plot_cell* cell = plot_sheet_cell(sheet, 0, v);
    snprintf(item, sizeof item, "%s, %s", name, variants[v].title);
    snprintf(sheet->column_titles[v], PLOT_LABEL_SIZE, "%s", variants[v].title);
    ty_result result = figure_render_variant(run, item, scene, &variants[v], size, &picture, NULL);
    if (result == TY_OK) result = figure_show(run, item, scene, &picture, truth, false, cell, &compared->all[v]);
    if (result == TY_OK && v != TRUTH)
        result = compare_shadow(run, item, &picture, truth, compared->direct, &compared->shadow[v]);
    if (result == TY_OK && v != TRUTH) {
        char error[16];
        figure_format_error(compared->shadow[v].relative_rmse, error);
        snprintf(cell->lines[2], PLOT_LABEL_SIZE, "in shadow %.3f, %s", compared->shadow[v].mean_ratio, error);
        result = figure_error_map(run, picture.image, truth->image, figure_block(truth->image),
                                  &plot_sheet_cell(sheet, 1, v)->picture);
    }
    if (v == TRUTH)
        compared->truth = picture;
    else
        figure_free_picture(&picture);
    return result;
}

/* Criteria: means within 20 %, and half of the error of the simpler combinations. */
static ty_result expect(figure_run* run, const char* name, const comparison* compared) {
    const figure_errors* all = compared->all;
    figure_expect(run, name, "mean ratio of full", "1", all[FULL].mean_ratio, 1, 0.2);
    figure_expect(run, name, "relative RMSE of full over that of both added", "1",
                  all[FULL].relative_rmse / all[BOTH].relative_rmse, 0, 0.5);
    figure_expect(run, name, "relative RMSE of full over that of plain, marched", "1",
                  all[FULL].relative_rmse / all[MARCHED].relative_rmse, 0, 0.5);
    return TY_OK;
}

static ty_result show_scene(figure_run* run, ty_scene* scene, int s, plot_sheet* sheet) {
    int32_t size[2];
    comparison compared = {0};
    const char* name = lpv_scene_names[scenes[s].scene];
    figure_view_size(run, scenes[s].size[0], scenes[s].size[1], size);
    snprintf(sheet->row_titles[0], PLOT_LABEL_SIZE, "%s", name);
    snprintf(sheet->row_titles[1], PLOT_LABEL_SIZE, "errors");
    ty_result result = render_direct(scene, size, &compared.direct);
    for (int v = 0; v < VARIANTS && result == TY_OK; ++v)
        result = show_variant(run, name, scene, v, size, &compared, sheet);
    if (result == TY_OK) result = expect(run, name, &compared);
    ty_image_destroy(compared.direct);
    figure_free_picture(&compared.truth);
    return result;
}

static ty_result add_scene(figure_run* run, int s) {
    ty_scene* scene = NULL;
    plot_sheet sheet;
    if (scenes[s].scene == LPV_SPONZA && !tools_has_data(run->options->data, SPONZA_FILE)) return TY_OK;
    ty_result result = plot_create_sheet(2, VARIANTS, PICTURE_WIDTH, &sheet);
    if (result != TY_OK) return result;
    result = figure_load_scene(run, lpv_scene_files[scenes[s].scene], NULL, 0, &scene);
    if (result == TY_OK) result = show_scene(run, scene, s, &sheet);
    figure_place_sheet(run, result, &sheet, NULL);
    ty_scene_destroy(scene);
    return result;
}

ty_result figure_lpv_truth(figure_run* run) {
    ty_result result = TY_OK;
    for (int s = 0; s < SCENES && result == TY_OK; ++s) result = add_scene(run, s);
    if (result == TY_OK) plot_page_color_bar(&run->page, &figure_error_scale);
    figure_caption(run,
                   "Scenes in fog%s: the method against path tracing, and combinations of the paper's Fig. 5 by the "
                   "same lattice: light propagation volumes on surfaces alone (c), these marched (e), and single "
                   "scattering added (f); the full method with three bands, and with a finer lattice about the camera. "
                   "In shadow: blocks of pixels whose surfaces no light reaches directly. Errors are of means over %d "
                   "× %d pixels, the relative RMSE without the truth's own noise.",
                   tools_has_data(run->options->data, SPONZA_FILE) ? "" : " (Sponza's data are not there)",
                   FIGURE_BLOCK, FIGURE_BLOCK);
    return result;
}
