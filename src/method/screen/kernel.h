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

/* What was noticed on the way. */
typedef struct ty_screen_counts {
    int64_t mended, unknown; /* pixels */
    int64_t cut;             /* pixels with a measure of spread above the limit in some channel */
    float largest[3];        /* measure of spread per channel: pixels^2, or an optical thickness */
} ty_screen_counts;

/* A row of the caller's picture. */
typedef struct ty_screen_row {
    const float* color[3];
    ptrdiff_t color_step;
    const float* distance;
    ptrdiff_t distance_step;
    int32_t y;
} ty_screen_row;

/* Where a split row goes; NULL for what is not wanted. */
typedef struct ty_screen_split_out {
    float* attenuated[3]; /* with what the environment adds */
    float* scattered[3];
    float* measure[3]; /* of spread: variance, pixels^2, or scattering optical thickness */
} ty_screen_split_out;

/* One level of the pyramid: light in planes 0..2, moments in planes 3..5, `stride` floats from row to row. */
typedef struct ty_screen_level {
    int32_t width, height;
    ptrdiff_t stride;
    float* plane[6];
    float* area[2]; /* of its texels along x and y: less than 1 where they reach beyond the picture */
    float edges[TY_SCREEN_EDGES * TY_SCREEN_DOWN_WEIGHTS]; /* along x, to the next level */
    ty_screen_down_fraction share[3];                              /* what goes on to the next, per channel */
} ty_screen_level;

/* Rows on the way from one level of the paper's pyramid to the next. */
enum {
    TY_GATHER_LIGHT = 0,    /* three: light, masked */
    TY_GATHER_DISTANCE = 3, /* m */
    TY_GATHER_MASK = 4,     /* M */
    TY_GATHER_WEIGHT = 5,   /* Y */
    TY_GATHER_SPREAD = 6,   /* Y W */
    TY_GATHER_ROWS = 7
};

/* The options that its kernels look at. */
typedef struct ty_screen_gather_params {
    ty_screen_mask_params mask; /* for the next level */
    int32_t luminance_weights, normalise, blurred_distance;
    float level_scale;
    int32_t level_count; /* with level 0 */
    float farthest;      /* m: distances are cut to it, since no level lies beyond */
} ty_screen_gather_params;

/* The picture as the exact point spread function takes it: light over what its spread would send to all pixels, and
 * sharpness 1 / (2 variance), pixels^-2. */
typedef struct ty_screen_sources {
    int32_t width, height;
    int32_t before, after; /* pixels that light reaches to the left and above, and to the right and below */
    float* light[3];
    float* sharpness[3];
} ty_screen_sources;

typedef struct ty_screen_kernels {
    /* Splits one row. limit: measure of spread above which a pixel counts as cut, per channel. */
    void (*split)(const ty_screen_params* params, const ty_screen_row* row, const float limit[3],
                  const ty_screen_split_out* out, ty_screen_counts* counts);
    /* Splits one row of level 0; what goes on to level 1 into onward[6], all else into out (step as given), which may
     * be NULL: then nothing is counted either. */
    void (*scatter)(const ty_screen_params* params, const ty_screen_row* row, const ty_screen_down_fraction share[3],
                    const float limit[3], float* const out[3], ptrdiff_t out_step, float* const onward[6],
                    ty_screen_counts* counts);
    /* What goes on from row y of a level, into onward[6]. */
    void (*onward)(const ty_screen_level* level, int32_t y, float* const onward[6]);
    /* A row of `width` texels, half as many of them. area: of the texels (ty_screen_down_weights); NULL: outside counts
     * as the edge. */
    void (*narrow)(const ty_screen_taps* taps, const float* row, int32_t width, const float* area, float* out);
    /* The weighted sum of narrowed rows, `width` texels each; those of weight 0 may be any. */
    void (*join)(const float weights[TY_SCREEN_DOWN_WEIGHTS], const float* const rows[TY_SCREEN_DOWN_WEIGHTS],
                 int32_t width, float* out);
    /* Row y of a level: what stays there and what comes back from the next (light in next->plane[0..2]), in place of
     * the light. scratch: next->width floats. */
    void (*up)(const ty_screen_taps* taps, const ty_screen_level* level, const ty_screen_level* next, int32_t y,
               float* scratch);
    /* Adds what comes back from level 1 to row y of one channel of the picture. */
    void (*add)(const ty_screen_taps* taps, const ty_screen_level* first, int32_t channel, int32_t y, int32_t width,
                float* out, ptrdiff_t step, float* scratch);

    /* Splits one row of level 0 for the paper's pyramid: I' into out, light and distance into texels, W into spread. */
    void (*gather_split)(const ty_screen_params* params, const ty_screen_gather_params* gather,
                         const ty_screen_row* row, const float limit[3], float* const out[3], ptrdiff_t out_step,
                         float* texels, float* spread, ty_screen_counts* counts);
    /* Rows for the filter from one row of a level. */
    void (*gather_rows)(const ty_screen_gather_params* gather, const float* texels, const float* spread, int32_t width,
                        float* const rows[TY_GATHER_ROWS]);
    /* A row of the next level from filtered rows. */
    void (*gather_store)(const ty_screen_gather_params* gather, const float* const rows[TY_GATHER_ROWS], int32_t width,
                         float* texels, float* spread);
    /* Adds to row y of the picture what its levels hold. */
    void (*gather_add)(const ty_screen_params* params, const ty_screen_gather_params* gather,
                       const ty_screen_texels* levels, int32_t y, float* const out[3], ptrdiff_t out_step);

    /* Turns a split row (scattered light and variance, in place) into sources. */
    void (*reference_prepare)(const ty_screen_sources* sources, int32_t y);
    /* Adds to `count` pixels from (x, y) on what the sources in a rectangle send to them; sums: a channel after
     * another. */
    void (*reference_add)(const ty_screen_sources* sources, const int32_t from[2], const int32_t to[2], int32_t x,
                          int32_t y, int32_t count, float* sums);
    /* The share of its own light that stays in the picture, for `count` pixels from (x, y) on. */
    void (*reference_coverage)(const ty_screen_sources* sources, int channel, int32_t x, int32_t y, int32_t count,
                               float* coverage);
} ty_screen_kernels;
TY_DECLARE_KERNELS(ty_screen_kernels);

#endif
