/* How two images differ. Sums run over pixels in order, in double, so that results never depend on threads. */
#include "image/image.h"

#include "base/context.h"

#include <math.h>
#include <string.h>

/* Sums over one channel, or over all. */
typedef struct tally {
    double a, b, square;
    int64_t count;
} tally;

typedef struct pair {
    double a, b;
} pair;

/* The mean of one channel over a block, pixels that are not finite in either image left out; false if none is left. */
static bool block_mean(const float* a, const float* b, size_t width, size_t x0, size_t y0, size_t block, pair* mean) {
    double sum_a = 0, sum_b = 0;
    int64_t count = 0;
    for (size_t y = y0; y < y0 + block; ++y)
        for (size_t x = x0; x < x0 + block; ++x) {
            const size_t i = y * width + x;
            if (!isfinite(a[i]) || !isfinite(b[i])) continue;
            sum_a += a[i];
            sum_b += b[i];
            ++count;
        }
    if (count == 0) return false;
    *mean = (pair){sum_a / (double)count, sum_b / (double)count};
    return true;
}

static void count_values(const float* a, const float* b, size_t pixels, ty_difference* difference) {
    for (size_t i = 0; i < pixels; ++i) {
        difference->not_finite += !isfinite(a[i]) + !isfinite(b[i]);
        difference->differing += memcmp(&a[i], &b[i], sizeof a[i]) != 0;
    }
}

/* Adds the square error relative to b^2 + softening over one channel. Equal values count 0 even where both are 0. */
static double relative_square(const float* a, const float* b, size_t width, size_t height, size_t block,
                              double softening) {
    double sum = 0;
    for (size_t y = 0; y + block <= height; y += block)
        for (size_t x = 0; x + block <= width; x += block) {
            pair mean;
            if (!block_mean(a, b, width, x, y, block, &mean) || mean.a == mean.b) continue;
            const double error = mean.a - mean.b;
            sum += error * error / (mean.b * mean.b + softening);
        }
    return sum;
}

static tally sum_channel(const float* a, const float* b, size_t width, size_t height, size_t block) {
    tally sums = {0};
    for (size_t y = 0; y + block <= height; y += block)
        for (size_t x = 0; x + block <= width; x += block) {
            pair mean;
            if (!block_mean(a, b, width, x, y, block, &mean)) continue;
            sums.a += mean.a;
            sums.b += mean.b;
            sums.square += (mean.a - mean.b) * (mean.a - mean.b);
            ++sums.count;
        }
    return sums;
}

/* Equal quantities have ratio 1 and no error has relative error 0, also where the reference is black. */
static void fill(ty_difference* difference, int slot, const tally* sums, double relative) {
    const double count = (double)sums->count;
    const double rmse = sums->count > 0 ? sqrt(sums->square / count) : 0;
    difference->mean_ratio[slot] = sums->a == sums->b ? 1 : sums->a / sums->b;
    difference->rmse[slot] = rmse;
    difference->relative_rmse[slot] = rmse == 0 ? 0 : rmse / (sums->b / count);
    difference->rel_mse[slot] = sums->count > 0 ? relative / count : 0;
}

static double softening(const tally* sums) {
    const double mean = sums->count > 0 ? sums->b / (double)sums->count : 0;
    return 0.01 * mean * mean;
}

ty_result ty_image_compare(ty_context* context, const ty_image* a, const ty_image* b, int32_t block,
                           ty_difference* out) {
    if (a == NULL || b == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_compare: an argument is NULL");
    if (a->width != b->width || a->height != b->height)
        return ty_fail(context, TY_ERROR_ARGUMENT, "images of %d x %d and %d x %d cannot be compared", (int)a->width,
                       (int)a->height, (int)b->width, (int)b->height);
    if (block < 1 || block > a->width || block > a->height)
        return ty_fail(context, TY_ERROR_ARGUMENT, "blocks of %d pixels do not fit an image of %d x %d", (int)block,
                       (int)a->width, (int)a->height);
    const float *pa[3], *pb[3];
    if (!ty_image_rgb_planes(a, pa) || !ty_image_rgb_planes(b, pb))
        return ty_fail(context, TY_ERROR_ARGUMENT, "an image to compare has neither R, G and B nor one channel alone");

    const size_t width = (size_t)a->width, height = (size_t)a->height, side = (size_t)block;
    const bool grey = pa[0] == pa[1] && pb[0] == pb[1];
    ty_difference difference = {0};
    tally sums[3], all = {0};
    for (int c = 0; c < 3; ++c) {
        if (c == 0 || !grey) count_values(pa[c], pb[c], width * height, &difference);
        sums[c] = c > 0 && grey ? sums[0] : sum_channel(pa[c], pb[c], width, height, side);
        all.a += sums[c].a;
        all.b += sums[c].b;
        all.square += sums[c].square;
        all.count += sums[c].count;
    }
    double all_relative = 0;
    for (int c = 0; c < 3; ++c) {
        fill(&difference, c, &sums[c], relative_square(pa[c], pb[c], width, height, side, softening(&sums[c])));
        all_relative += relative_square(pa[c], pb[c], width, height, side, softening(&all));
    }
    fill(&difference, 3, &all, all_relative);
    *out = difference;
    return TY_OK;
}
