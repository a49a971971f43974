/* The kernels of screen-space scattering, built once per instruction set. Rows are contiguous floats unless a step is
 * given. */
#ifndef TY_METHOD_SCREEN_KERNEL_H
#define TY_METHOD_SCREEN_KERNEL_H

#include "base/dispatch.h"
#include "method/screen/gather.k.h"
#include "method/screen/reference.k.h"
#include "method/screen/scatter.k.h"
#include "method/screen/split.k.h"

#include <stddef.h>

/* Counts over the pixels of a row or band. */
typedef struct ty_screen_counts {
    int64_t nonfinite_fixed, missing_depth; /* pixels */
    int64_t oversized;                      /* pixels with a measure of spread above the limit in some channel */
    float largest[3]; /* maximum measure of spread per channel: pixels^2, or an optical thickness */
} ty_screen_counts;

/* A row of the caller's image. */
typedef struct ty_screen_row {
    const float* color[3];
    ptrdiff_t color_step;
    const float* distance;
    ptrdiff_t distance_step;
    int32_t y;
} ty_screen_row;

/* Destinations of a split row; NULL for unused ones. */
typedef struct ty_screen_split_out {
    float* attenuated[3]; /* including airlight */
    float* scattered[3];
    float* measure[3]; /* of spread: variance, pixels^2, or scattering optical thickness */
} ty_screen_split_out;

/* One level of the pyramid: light in planes 0..2, moments in planes 3..5, rows `stride` floats apart. */
typedef struct ty_screen_level {
    int32_t width, height;
    ptrdiff_t stride;
    float* plane[6];
    float* area[2]; /* size of its texels along x and y: less than 1 where they extend beyond the image */
    float edges[TY_SCREEN_EDGES * TY_SCREEN_DOWN_WEIGHTS]; /* along x, to the next level */
    ty_screen_down_fraction down_fraction[3];              /* fraction passed to the next level, per channel */
} ty_screen_level;

/* Row kinds while downsampling a level of the pyramid of Elek 2013. */
enum {
    TY_GATHER_LIGHT = 0,    /* three rows: masked light */
    TY_GATHER_DISTANCE = 3, /* m */
    TY_GATHER_MASK = 4,     /* M */
    TY_GATHER_WEIGHT = 5,   /* Y */
    TY_GATHER_SPREAD = 6,   /* Y W */
    TY_GATHER_ROWS = 7
};

/* Options of the gather kernels. */
typedef struct ty_screen_gather_params {
    ty_screen_mask_params mask; /* for the next level */
    int32_t luminance_weights, normalise, blurred_distance;
    float level_scale;
    int32_t level_count; /* including level 0 */
    float max_distance;  /* m: distances are clamped to it, since they all read the last level */
} ty_screen_gather_params;

/* The image as sources of the exact point spread function: light divided by the sum of its Gaussian over all pixels,
 * and sharpness 1 / (2 variance), pixels^-2. */
typedef struct ty_screen_sources {
    int32_t width, height;
    int32_t before, after; /* reach in pixels to the left and above, and to the right and below */
    float* light[3];
    float* sharpness[3];
} ty_screen_sources;

typedef struct ty_screen_kernels {
    /* Splits one row into attenuated and scattered light. limit: measure of spread above which a pixel counts as
     * oversized, per channel. */
    void (*split)(const ty_screen_params* params, const ty_screen_row* row, const float limit[3],
                  const ty_screen_split_out* out, ty_screen_counts* counts);
    /* Splits one row of level 0: light passed to level 1 into down[6], all other light into out (with its step). out
     * NULL: only down[6] is written, and nothing is counted. */
    void (*scatter)(const ty_screen_params* params, const ty_screen_row* row,
                    const ty_screen_down_fraction fractions[3], const float limit[3], float* const out[3],
                    ptrdiff_t out_step, float* const down[6], ty_screen_counts* counts);
    /* Light passed to the next level from row y of a level, into down[6]. */
    void (*split_level)(const ty_screen_level* level, int32_t y, float* const down[6]);
    /* Downsamples a row of `width` texels by 2. edges: weights of the texels at its ends (ty_screen_down_weights);
     * NULL: clamped at the edges. */
    void (*downsample)(const ty_screen_taps* taps, const float* row, int32_t width, const float* edges, float* out);
    /* Weighted sum of downsampled rows, `width` texels each; rows of weight 0 are not read. */
    void (*combine_rows)(const float weights[TY_SCREEN_DOWN_WEIGHTS], const float* const rows[TY_SCREEN_DOWN_WEIGHTS],
                         int32_t width, float* out);
    /* Replaces the light in row y of a level by the light that stays there plus the upsampled light of the next level
     * (next->plane[0..2]). scratch: next->width floats. */
    void (*merge_up)(const ty_screen_taps* taps, const ty_screen_level* level, const ty_screen_level* next, int32_t y,
                     float* scratch);
    /* Adds the upsampled light of level 1 to row y of one image channel. */
    void (*add_upsampled)(const ty_screen_taps* taps, const ty_screen_level* first, int32_t channel, int32_t y,
                          int32_t width, float* out, ptrdiff_t step, float* scratch);

    /* Splits one row of level 0 for the gather pyramid: I' into out, light and distance into texels, W into spread. */
    void (*gather_split)(const ty_screen_params* params, const ty_screen_gather_params* gather,
                         const ty_screen_row* row, const float limit[3], float* const out[3], ptrdiff_t out_step,
                         float* texels, float* spread, ty_screen_counts* counts);
    /* Filter input rows from one row of a level: Eq. 8 and 9 (Elek 2013). */
    void (*gather_rows)(const ty_screen_gather_params* gather, const float* texels, const float* spread, int32_t width,
                        float* const rows[TY_GATHER_ROWS]);
    /* A row of the next level from filtered rows: Eq. 8 and 9 (Elek 2013). */
    void (*gather_store)(const ty_screen_gather_params* gather, const float* const rows[TY_GATHER_ROWS], int32_t width,
                         float* texels, float* spread);
    /* Adds the interpolated levels to row y of the image: Eq. 10 and 11 (Elek 2013). */
    void (*gather_add)(const ty_screen_params* params, const ty_screen_gather_params* gather,
                       const ty_screen_texels* levels, int32_t y, float* const out[3], ptrdiff_t out_step);

    /* Converts a split row (scattered light and variance, in place) into sources. */
    void (*reference_prepare)(const ty_screen_sources* sources, int32_t y);
    /* Adds the light of the sources in a rectangle to `count` pixels starting at (x, y); sums: one channel after
     * another. */
    void (*reference_add)(const ty_screen_sources* sources, const int32_t from[2], const int32_t to[2], int32_t x,
                          int32_t y, int32_t count, float* sums);
    /* Fraction of the point spread function of `count` pixels starting at (x, y) that lies inside the image. */
    void (*reference_coverage)(const ty_screen_sources* sources, int channel, int32_t x, int32_t y, int32_t count,
                               float* coverage);
} ty_screen_kernels;
TY_DECLARE_KERNELS(ty_screen_kernels);

#endif
