/* Kernels of denoising; compiled once per instruction set, named by TY_ISA. */
#include "image/denoise/kernel.h"

#include "image/denoise/regression.k.h"

/* Squared bandwidth k of the wide weights exp(-d / k^2); that of the narrow ones is a quarter of it. */
static const float wide2 = 1.0f;

/* Distances beyond which a weight counts as 0. */
static const float farthest = 80.0f;

/* The least weight of a center itself, which otherwise has that of the most similar pixel beside it. */
static const float own_weight = 0.01f;

/* Radii of the window and of the patches of features' NL-means. */
enum { SMOOTH_REACH = 3, SMOOTH_PATCH = 1 };

/* The first center of a row: every second row is shifted by half of the distance between centers. */
static int32_t first_center(int32_t y) {
    return y / TY_DENOISE_STEP % 2 * TY_DENOISE_STEP;
}

/* Offset in tile->distance of a center. */
static int32_t center_distances(int32_t x, int32_t y) {
    return (y / TY_DENOISE_STEP * TY_DENOISE_CENTERS + x / (2 * TY_DENOISE_STEP)) * TY_DENOISE_DISTANCES;
}

static void find_distances(ty_denoise_tile* tile, int32_t half) {
    enum { ROWS = TY_DENOISE_TILE + 2 * TY_DENOISE_PATCH };
    float rows[ROWS][TY_PATCH_ROW], mean[TY_DENOISE_TILE];
    for (int32_t o = 0; o < TY_DENOISE_WEIGHTS; ++o) {
        const int32_t dx = o % TY_DENOISE_WINDOW - TY_DENOISE_BEFORE, dy = o / TY_DENOISE_WINDOW - TY_DENOISE_BEFORE;
        for (int32_t row = 0; row < tile->height + 2 * TY_DENOISE_PATCH; ++row)
            ty_patch_row(tile, half, 3, ty_tile_index(-TY_DENOISE_PATCH, row - TY_DENOISE_PATCH),
                         dy * TY_DENOISE_PITCH + dx, rows[row]);
        for (int32_t y = 0; y < tile->height; y += TY_DENOISE_STEP) {
            ty_patch_mean((const float(*)[TY_PATCH_ROW])rows + y, TY_DENOISE_PATCH, mean);
            for (int32_t x = first_center(y); x < TY_DENOISE_TILE; x += 2 * TY_DENOISE_STEP)
                tile->distance[center_distances(x, y) + o] = mean[x];
        }
    }
}

/* Weights of a center's window, by distance and chart. */
static void set_weights(const ty_denoise_tile* tile, int32_t x, int32_t y, ty_regression* out) {
    const float* distance = tile->distance + center_distances(x, y);
    const float chart = tile->chart[ty_tile_index(x, y)];
    for (int32_t row = 0; row < TY_DENOISE_WINDOW; ++row) {
        const float* charts = tile->chart + ty_tile_index(x - TY_DENOISE_BEFORE, y - TY_DENOISE_BEFORE + row);
        for (int32_t i = 0; i < TY_DENOISE_WINDOW; ++i) {
            const int32_t at = row * TY_DENOISE_WINDOW + i;
            const float scaled = ty_minf(distance[at] * (1.0f / wide2), farthest);
            const float weight = charts[i] == chart ? ty_exp_neg(scaled) : 0.0f;
            const float squared = weight * weight;
            out->weight[TY_DENOISE_WIDE][at] = weight;
            out->weight[TY_DENOISE_NARROW][at] = squared * squared;
        }
    }
    for (int32_t k = TY_DENOISE_NARROW; k <= TY_DENOISE_WIDE; ++k) {
        float* own = out->weight[k] + TY_DENOISE_BEFORE * TY_DENOISE_WINDOW + TY_DENOISE_BEFORE;
        const float beside =
            ty_maxf(ty_maxf(own[-1], own[1]), ty_maxf(own[-TY_DENOISE_WINDOW], own[TY_DENOISE_WINDOW]));
        *own = ty_maxf(beside, own_weight);
    }
}

/* Columns of a center's window: a constant, features less their values at the center, and the colors of a half. */
static void set_columns(const ty_denoise_tile* tile, int32_t half, int32_t x, int32_t y, ty_regression* out) {
    const int32_t first = ty_tile_index(x - TY_DENOISE_BEFORE, y - TY_DENOISE_BEFORE), center = ty_tile_index(x, y);
    for (int32_t i = 1; i < out->basis + 3; ++i) {
        const bool is_color = i >= out->basis;
        const float* plane = is_color ? tile->color[half][i - out->basis] : tile->feature[i - 1];
        const float offset = is_color ? 0.0f : plane[center];
        for (int32_t row = 0; row < TY_DENOISE_WINDOW; ++row)
            for (int32_t k = 0; k < TY_DENOISE_WINDOW; ++k)
                out->column[i][row * TY_DENOISE_WINDOW + k] = plane[first + row * TY_DENOISE_PITCH + k] - offset;
    }
}

static void regress_half(ty_denoise_tile* tile, int32_t half, int32_t features, const float* ridge) {
    ty_regression regression;
    memset(&regression, 0, sizeof regression);
    regression.basis = features + 1;
    for (int32_t i = 0; i < TY_DENOISE_WEIGHTS; ++i) regression.column[0][i] = 1.0f;
    for (int32_t y = 0; y < tile->height; y += TY_DENOISE_STEP)
        for (int32_t x = first_center(y); x < tile->width; x += 2 * TY_DENOISE_STEP) {
            if (tile->chart[ty_tile_index(x, y)] < 0.0f) continue;
            const int32_t at = y * TY_DENOISE_REACH + x;
            ty_linear_model model;
            set_weights(tile, x, y, &regression);
            set_columns(tile, half, x, y, &regression);
            for (int32_t k = TY_DENOISE_NARROW; k <= TY_DENOISE_WIDE; ++k) {
                ty_fit_model(&regression, regression.weight[k], ridge, &model);
                ty_add_predictions(&regression, regression.weight[k], regression.basis, (const float(*)[3])model.beta,
                                   tile->sums[half][k], at);
            }
            ty_add_predictions(&regression, regression.weight[TY_DENOISE_WIDE], 1, (const float(*)[3]) & model.mean,
                               tile->sums[half][TY_DENOISE_MEAN], at);
        }
}

static void smooth_rows(ty_denoise_tile* tile, int32_t half, int32_t channels, int32_t dx, int32_t dy) {
    enum { ROWS = TY_DENOISE_TILE + 2 * SMOOTH_PATCH };
    float rows[ROWS][TY_PATCH_ROW], mean[TY_DENOISE_TILE];
    const int32_t shift = dy * TY_DENOISE_PITCH + dx;
    for (int32_t y = 0; y < tile->height + 2 * SMOOTH_PATCH; ++y)
        ty_patch_row(tile, 1 - half, channels, ty_tile_index(-SMOOTH_PATCH, y - SMOOTH_PATCH), shift, rows[y]);
    for (int32_t y = 0; y < tile->height; ++y) {
        const int32_t from = ty_tile_index(0, y), to = y * TY_DENOISE_REACH;
        const float *here = tile->chart + from, *there = here + shift;
        ty_patch_mean((const float(*)[TY_PATCH_ROW])rows + y, SMOOTH_PATCH, mean);
        for (int32_t x = 0; x < TY_DENOISE_TILE; ++x)
            mean[x] = here[x] == there[x] ? ty_exp_neg(ty_minf(mean[x], farthest)) : 0.0f;
        for (int32_t c = 0; c < channels; ++c) {
            const float* color = tile->color[half][c] + from + shift;
            float* sum = tile->sums[half][0][c] + to;
            for (int32_t x = 0; x < TY_DENOISE_TILE; ++x) sum[x] += mean[x] * color[x];
        }
        float* weight = tile->sums[half][0][3] + to;
        for (int32_t x = 0; x < TY_DENOISE_TILE; ++x) weight[x] += mean[x];
    }
}

static void smooth_halves(ty_denoise_tile* tile, int32_t channels) {
    for (int32_t half = 0; half < 2; ++half) {
        memset(tile->sums[half][0], 0, sizeof tile->sums[half][0]);
        for (int32_t dy = -SMOOTH_REACH; dy <= SMOOTH_REACH; ++dy)
            for (int32_t dx = -SMOOTH_REACH; dx <= SMOOTH_REACH; ++dx) smooth_rows(tile, half, channels, dx, dy);
    }
}

const ty_denoise_kernels TY_KERNEL_NAME(ty_denoise_kernels) = {find_distances, regress_half, smooth_halves};
