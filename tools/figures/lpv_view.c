/* Common code of figures of light propagation volumes. */
#include "figures/lpv_view.h"

#include <math.h>
#include <stdlib.h>

ty_lpv_def lpv_scene_def(const ty_scene* scene) {
    ty_lpv_def def = ty_default_lpv_def();
    ty_method_options(scene, "lpv", &def);
    return def;
}

ty_lpv_def lpv_variant_def(const ty_scene* scene, const lpv_variant* variant) {
    ty_lpv_def def = lpv_scene_def(scene);
    ty_context* context = ty_scene_context(scene);
    ty_options_set(context, &ty_lpv_options, &def, "mode", variant->mode);
    ty_options_set(context, &ty_lpv_options, &def, "parts", variant->parts);
    def.iterations = variant->iterations > 0 ? variant->iterations : TY_AUTO;
    if (variant->bands > 0) def.bands = variant->bands;
    if (variant->cascades > 0) def.cascades = variant->cascades;
    return def;
}

ty_result lpv_render(figure_run* run, const char* item, ty_scene* scene, const lpv_variant* variant,
                     const int32_t size[2], figure_picture* out, ty_lpv_stats* stats) {
    cli_report report;
    if (variant->mode == NULL) return figure_render(run, item, scene, &ty_method_path, size, out, &report);
    const ty_lpv_def before = lpv_scene_def(scene), own = lpv_variant_def(scene, variant);
    ty_result result = ty_method_set_options(scene, "lpv", &own);
    if (result != TY_OK) return result;
    result = figure_render(run, item, scene, &ty_method_lpv, size, out, &report);
    if (stats != NULL) *stats = *(const ty_lpv_stats*)report.run.stats;
    const ty_result restored = ty_method_set_options(scene, "lpv", &before);
    return result == TY_OK ? restored : result;
}

/* ---- shadow ---- */

ty_result lpv_render_direct(const ty_scene* scene, const int32_t size[2], ty_image** out) {
    const lpv_variant variant = {.mode = "links", .parts = "shadow_map"};
    ty_lpv_def def = lpv_variant_def(scene, &variant);
    def.width = size[0];
    def.height = size[1];
    return ty_lpv_render(scene, &def, out, NULL);
}

double lpv_mean(const ty_image* image) {
    const size_t count = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    const float* planes[3];
    double sum = 0;
    if (!ty_image_rgb_planes(image, planes)) return NAN;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < count; ++i) sum += (double)planes[c][i];
    return sum / (3.0 * (double)count);
}

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
    const double min_sum = 3.0 * block * block * shadow_fraction * lpv_mean(direct);
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

ty_result lpv_compare_shadow(figure_run* run, const char* item, const figure_picture* picture,
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
    ty_result result = figure_note(run, item, "blocks in shadow", "1", (double)sums.blocks);
    if (result == TY_OK) result = figure_note(run, item, "mean ratio in shadow", "1", out->mean_ratio);
    if (result == TY_OK) result = figure_note(run, item, "relative RMSE in shadow", "1", out->relative_rmse);
    return result;
}
