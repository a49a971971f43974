/* Common driver of images, rays and cells: options, kernels, time. */
#ifndef TY_PATH_DRIVER_H
#define TY_PATH_DRIVER_H

#include "method/path/guide/guide.h"
#include "option/option.h"

#include <tyndall/path.h>

/* Items sampled together in a block: all of them have the same number of samples. */
enum { TY_PATH_BLOCK = 64, TY_PATH_SPP_MAX = 1 << 24 };

/* Accumulated samples of one item. */
typedef struct ty_path_item {
    ty_path_sums sums;
    uint32_t count;
} ty_path_item;

/* Sums over the even samples of an item alone, whose random numbers are independent of those of odd ones. */
typedef struct ty_path_half {
    double mean[3]; /* sum of samples */
    ty_path_aov_sums aov_sums;
} ty_path_half;

typedef struct ty_path_run {
    ty_context* context;
    const ty_path_def* def; /* known, but for a bake, which has none once it samples */
    ty_path_def known;      /* the caller's def in the library's own size */
    const char* stage;
    const ty_scene* scene;
    ty_scene_view view; /* scene as seen by paths; media may be left out */
    ty_path_request request;
    ty_sobol sobol;
    int32_t height;             /* of the whole frame; pixels only */
    uint64_t scene_hash;        /* pixels only */
    ty_image* image;            /* of the pixels, filled for def->partial; NULL: none */
    ty_path_item* items;        /* item_count items, zeroed or resumed from a state */
    ty_path_aov_sums* aov_sums; /* item_count; NULL: not needed */
    ty_path_half* halves;       /* item_count, for TY_AOV_HALF; NULL: not needed */
    ty_light_view* lights;      /* lights of the scene without its media; NULL: the scene's own */
    uint8_t* outlines;          /* item_count, nonzero where outlines of emitters are; NULL: nowhere */
    bool has_outlines;          /* true once they are found */
    int64_t item_count;
    ty_path_kernel kernel;
    ty_path_guide* guide;                    /* NULL: none */
    double guide_seconds, guide_cpu_seconds; /* of its making */
    ty_path_stats stats;                     /* result; before sampling, the statistics of earlier runs */
} ty_path_run;

extern const ty_option_table ty_path_options;
/* Copies a caller's def to own, in the library's own size, and checks it. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_path_take_def(ty_context* context, const ty_path_def* def, ty_path_def* own);

/* Checks def and the scene and fills in everything but kind, geometry and items. */
ty_result ty_path_prepare(const ty_scene* scene, const ty_path_def* def, ty_path_run* run);

/* Chooses the guiding lights, and allocates item_count items and, if asked, their AOV sums. */
ty_result ty_path_run_begin(ty_path_run* run, const ty_scene* scene, bool with_aov_sums);
void ty_path_run_end(ty_path_run* run);
/* All of this for the pixels of an image. Call ty_path_run_end after TY_OK alone. */
ty_result ty_path_begin_pixels(const ty_scene* scene, const ty_path_def* def, ty_path_run* run);

/* Samples all items in passes until def's bounds are met. Items are valid after TY_OK and TY_CANCELLED;
 * TY_ERROR_MEMORY comes before any work. */
ty_result ty_path_sample(ty_path_run* run);

/* Mean of an item's samples, and variance of that mean (0 for fewer than two samples). */
double ty_path_item_mean(const ty_path_item* item, int channel);
double ty_path_item_variance(const ty_path_item* item, int channel);

#endif
