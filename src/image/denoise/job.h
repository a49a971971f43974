/* One run of denoising: what it takes from the image, and its steps. Planes have width * height floats. */
#ifndef TY_IMAGE_DENOISE_JOB_H
#define TY_IMAGE_DENOISE_JOB_H

#include "base/progress.h"
#include "image/denoise/kernel.h"

#include <tyndall/denoise.h>

/* Light that is denoised by itself: both halves, and afterwards their denoised light. */
typedef struct ty_denoise_light {
    int32_t channels; /* 3, or 1 of a feature */
    float softening;  /* variance that does not count as noise */
    float* color[2][3];
    float* variance; /* of a half, summed over channels, smoothed */
    float* sums[2][TY_DENOISE_CANDIDATES][4];
} ty_denoise_light;

typedef struct ty_denoise_job {
    ty_context* context;
    const ty_image* image;
    ty_denoise_def def;
    int32_t width, height;
    size_t pixels;
    const float* samples; /* NULL: spp in all pixels */
    double spp;
    const ty_denoise_kernels* kernels;
    ty_denoise_tile* tiles; /* one per thread */
    int32_t feature_count;
    float* features[TY_DENOISE_PLANES_MAX]; /* of mean 0 and variance 1 */
    float ridge[TY_DENOISE_PLANES_MAX];     /* noise left in them */
    ty_denoise_light light;                 /* of the part at hand */
    float* raw[2][3];                       /* halves of all light */
    float* denoised[2][3];                  /* the same, denoised, summed over parts */
    float* error[3];                        /* mean square error of the halves' mean, which may be negative */
    float* scratch[4];
    ty_part_progress progress;
    ty_denoise_stats stats;
} ty_denoise_job;

ty_result ty_denoise_take_def(ty_context* context, const ty_denoise_def* def, ty_denoise_def* own);

/* ---- planes ---- */

float* ty_denoise_plane(ty_denoise_job* job);
void ty_denoise_free_plane(ty_denoise_job* job, float* plane);
/* Means over squares of (2 radius + 1)^2 pixels, as far as they are in the image; in and out may be the same. */
void ty_denoise_box(ty_denoise_job* job, const float* in, int32_t radius, float* out);
/* Calls body for all rows, with job as user. */
void ty_denoise_rows(ty_denoise_job* job, ty_parallel_fn body);

/* ---- channels of the image ---- */

/* The plane of a channel, or NULL; half: of its even samples. */
const float* ty_denoise_find(const ty_denoise_job* job, const char* name, bool half);
/* Stores the even and the odd half of a plane; even NULL: the plane twice. */
void ty_denoise_split(const ty_denoise_job* job, const float* all, const float* even, float* const out[2]);
/* Checks the image and finds how many samples its pixels have. Errors: TY_ERROR_INPUT. */
ty_result ty_denoise_check_image(ty_denoise_job* job);

/* ---- steps ---- */

/* Fills in features. Errors: TY_ERROR_MEMORY. */
ty_result ty_denoise_make_features(ty_denoise_job* job);
/* Runs a body over tiles in parallel: of all tiles, or in four passes within which no two tiles are neighbours. */
typedef void (*ty_denoise_tile_fn)(ty_denoise_job* job, ty_denoise_tile* tile, int32_t x, int32_t y);
void ty_denoise_tiles(ty_denoise_job* job, bool in_passes, ty_denoise_tile_fn body);
/* Copies planes into a tile with its margin. */
void ty_denoise_load(const ty_denoise_job* job, const float* plane, int32_t x, int32_t y, float* out);
void ty_denoise_load_charts(const ty_denoise_job* job, int32_t x, int32_t y, ty_denoise_tile* tile);
/* True if a tile or its margin has noise, by its variance. */
bool ty_denoise_is_noisy(const ty_denoise_tile* tile);
/* Fills in variance and softening of light. */
void ty_denoise_estimate_variance(ty_denoise_job* job);
/* Adds up the candidates' predictions of light in its sums. */
void ty_denoise_predict(ty_denoise_job* job);
/* Chooses among candidates by their errors, and adds the light to that denoised. */
void ty_denoise_choose(ty_denoise_job* job);
/* Denoises both halves by Open Image Denoise. Errors: TY_ERROR_UNSUPPORTED without it, TY_ERROR_INTERNAL,
 * TY_ERROR_MEMORY, TY_CANCELLED. */
ty_result ty_denoise_by_oidn(ty_denoise_job* job);
/* Estimates the errors of what was denoised, and the statistics of them. */
void ty_denoise_estimate_error(ty_denoise_job* job);
/* True if the image before has the channels that are needed of it. */
bool ty_denoise_has_previous(ty_denoise_job* job);
/* Blends the image before into what was denoised. */
void ty_denoise_blend_previous(ty_denoise_job* job);

#endif
