/* Difference metrics of two images. Sums run over pixels in order, in double, so that results are independent of
 * threads. */
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

/* The common pixels of one channel of two images. */
typedef struct match {
    const float *a, *b;
    size_t stride_a, stride_b; /* floats from one row to the next */
    size_t width, height;
} match;

/* The mean over a block, excluding pixels that are not finite in either image; false if none remains. */
static bool block_mean(const match* m, size_t x0, size_t y0, size_t block, pair* mean) {
    double sum_a = 0, sum_b = 0;
    int64_t count = 0;
    for (size_t y = y0; y < y0 + block; ++y) {
        const float *a = m->a + y * m->stride_a, *b = m->b + y * m->stride_b;
        for (size_t x = x0; x < x0 + block; ++x) {
            if (!isfinite(a[x]) || !isfinite(b[x])) continue;
            sum_a += a[x];
            sum_b += b[x];
            ++count;
        }
    }
    if (count == 0) return false;
    *mean = (pair){sum_a / (double)count, sum_b / (double)count};
    return true;
}

static void count_values(const match* m, ty_difference* difference) {
    for (size_t y = 0; y < m->height; ++y) {
        const float *a = m->a + y * m->stride_a, *b = m->b + y * m->stride_b;
        for (size_t x = 0; x < m->width; ++x) {
            difference->not_finite += !isfinite(a[x]) + !isfinite(b[x]);
            difference->differing += memcmp(&a[x], &b[x], sizeof a[x]) != 0;
        }
    }
}

/* Sum of squared errors relative to b^2 + softening. Equal values count 0 even if both are 0. */
static double relative_square(const match* m, size_t block, double softening) {
    double sum = 0;
    for (size_t y = 0; y + block <= m->height; y += block)
        for (size_t x = 0; x + block <= m->width; x += block) {
            pair mean;
            if (!block_mean(m, x, y, block, &mean) || mean.a == mean.b) continue;
            const double error = mean.a - mean.b;
            sum += error * error / (mean.b * mean.b + softening);
        }
    return sum;
}

static tally sum_channel(const match* m, size_t block) {
    tally sums = {0};
    for (size_t y = 0; y + block <= m->height; y += block)
        for (size_t x = 0; x + block <= m->width; x += block) {
            pair mean;
            if (!block_mean(m, x, y, block, &mean)) continue;
            sums.a += mean.a;
            sums.b += mean.b;
            sums.square += (mean.a - mean.b) * (mean.a - mean.b);
            ++sums.count;
        }
    return sums;
}

/* Equal quantities have ratio 1, and a zero error has relative error 0, even if the reference is black. */
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

/* Matches the pixels common to both images, per channel; *grey: all channels are one. */
static ty_result match_images(ty_context* context, const ty_image* a, const ty_image* b, match matches[3], bool* grey) {
    if (a->frame[2] != b->frame[2] || a->frame[3] != b->frame[3])
        return ty_fail(context, TY_ERROR_ARGUMENT, "images of %d x %d and %d x %d cannot be compared", (int)a->frame[2],
                       (int)a->frame[3], (int)b->frame[2], (int)b->frame[3]);
    const ty_window common = ty_window_intersection(ty_image_window(a), ty_image_window(b));
    if (common.x0 >= common.x1 || common.y0 >= common.y1)
        return ty_fail(context, TY_ERROR_ARGUMENT, "the images to compare have no pixel in common");
    const float *pa[3], *pb[3];
    if (!ty_image_rgb_planes(a, pa) || !ty_image_rgb_planes(b, pb))
        return ty_fail(context, TY_ERROR_ARGUMENT, "an image to compare has neither R, G and B nor one channel alone");
    for (int c = 0; c < 3; ++c)
        matches[c] = (match){.a = pa[c] + ty_image_index(a, common.x0, common.y0),
                             .b = pb[c] + ty_image_index(b, common.x0, common.y0),
                             .stride_a = (size_t)a->width,
                             .stride_b = (size_t)b->width,
                             .width = (size_t)(common.x1 - common.x0),
                             .height = (size_t)(common.y1 - common.y0)};
    *grey = pa[0] == pa[1] && pb[0] == pb[1];
    return TY_OK;
}

ty_result ty_image_compare(ty_context* context, const ty_image* a, const ty_image* b, int32_t block,
                           ty_difference* out) {
    if (a == NULL || b == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_compare: an argument is NULL");
    match matches[3];
    bool grey = false;
    const ty_result result = match_images(context, a, b, matches, &grey);
    if (result != TY_OK) return result;
    const size_t width = matches[0].width, height = matches[0].height, side = (size_t)block;
    if (block < 1 || side > width || side > height)
        return ty_fail(context, TY_ERROR_ARGUMENT, "blocks of %d pixels do not fit an image of %zu x %zu", (int)block,
                       width, height);

    ty_difference difference = {0};
    tally sums[3], total = {0};
    for (int c = 0; c < 3; ++c) {
        if (c == 0 || !grey) count_values(&matches[c], &difference);
        sums[c] = c > 0 && grey ? sums[0] : sum_channel(&matches[c], side);
        total.a += sums[c].a;
        total.b += sums[c].b;
        total.square += sums[c].square;
        total.count += sums[c].count;
    }
    double total_relative = 0;
    for (int c = 0; c < 3; ++c) {
        fill(&difference, c, &sums[c], relative_square(&matches[c], side, softening(&sums[c])));
        total_relative += relative_square(&matches[c], side, softening(&total));
    }
    fill(&difference, 3, &total, total_relative);
    *out = difference;
    return TY_OK;
}
