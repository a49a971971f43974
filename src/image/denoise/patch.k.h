/* Differences of patches in units of their noise, whole rows at once. */
#ifndef TY_IMAGE_DENOISE_PATCH_K_H
#define TY_IMAGE_DENOISE_PATCH_K_H

#include "base/simd.h"
#include "image/denoise/kernel.h"

/* Floats of a row of differences: those of the tile and a patch on either side, in whole lanes. */
enum { TY_PATCH_ROW = TY_DENOISE_TILE + 16 };

/* The index in a tile's planes of the pixel (x, y) of the tile. */
TY_FN int32_t ty_tile_index(int32_t x, int32_t y) {
    return (y + TY_DENOISE_MARGIN) * TY_DENOISE_PITCH + x + TY_DENOISE_MARGIN;
}

/* Squared differences of the pixels from index `at` on and those `shift` behind them, less what noise makes of them,
 * over their noise (Rousselle et al. 2012), with sums over the channels above and below the line, so that channels
 * without light do not count. */
TY_INLINE void ty_patch_row(const ty_denoise_tile* tile, int32_t half, int32_t channels, int32_t at, int32_t shift,
                            float* out) {
    for (int32_t x = 0; x < TY_PATCH_ROW; x += TY_LANES) {
        ty_lanes squares = {0};
        for (int32_t c = 0; c < channels; ++c) {
            const float* color = tile->color[half][c] + at + x;
            const ty_lanes difference = ty_lanes_load(color) - ty_lanes_load(color + shift);
            squares += difference * difference;
        }
        const float* variance = tile->variance + at + x;
        const ty_lanes here = ty_lanes_load(variance), there = ty_lanes_load(variance + shift), sum = here + there;
        const ty_lanes lesser = 0.5f * (sum - ty_lanes_abs(here - there));
        ty_lanes_store(out + x, (squares - here - lesser) * ty_lanes_invert(sum + tile->softening));
    }
}

/* The mean over patches, at least 0, of the differences in the rows from rows[0] on, of pixels radius + i. */
TY_INLINE void ty_patch_mean(const float (*rows)[TY_PATCH_ROW], int32_t radius, float* out) {
    float column[TY_PATCH_ROW + TY_LANES];
    const int32_t side = 2 * radius + 1;
    const float scale = 1.0f / (float)(side * side);
    for (int32_t x = 0; x < TY_PATCH_ROW; x += TY_LANES) {
        ty_lanes sum = ty_lanes_load(rows[0] + x);
        for (int32_t y = 1; y < side; ++y) sum += ty_lanes_load(rows[y] + x);
        ty_lanes_store(column + x, sum);
    }
    for (int32_t x = 0; x < TY_DENOISE_TILE; x += TY_LANES) {
        ty_lanes sum = ty_lanes_load(column + x);
        for (int32_t k = 1; k < side; ++k) sum += ty_lanes_load(column + x + k);
        ty_lanes_store(out + x, 0.5f * scale * (sum + ty_lanes_abs(sum)));
    }
}

#endif
