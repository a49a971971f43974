/* What rendering images, rays and cells share: options, kernels, time. */
#ifndef TY_PATH_DRIVER_H
#define TY_PATH_DRIVER_H

#include "method/path/kernel.h"

#include <tyndall/path.h>

/* Items whose samples come in together: all of them have equally many. */
enum { TY_PATH_BLOCK = 64, TY_PATH_SPP_MAX = 1 << 24 };

/* Accumulated samples of one item. */
typedef struct ty_path_item {
    ty_path_sums sums;
    uint32_t count;
} ty_path_item;

typedef struct ty_path_run {
    ty_context* context;
    const ty_path_def* def;
    const char* stage;
    ty_scene_view view; /* what paths see of the scene: its media may be left out */
    ty_path_request request;
    ty_sobol sobol;
    int32_t height;          /* of the whole frame; pixels only */
    uint64_t scene_hash;     /* pixels only */
    ty_path_item* items;     /* item_count, zeroed or as a state says */
    ty_path_aov_sums* parts; /* the same; NULL: not kept */
    ty_light_view* lights;   /* of the scene without its media; NULL: those of the scene */
    int64_t item_count;
    ty_path_kernel kernel;
    ty_path_stats stats; /* result; before sampling, what the runs before this one did */
} ty_path_run;

/* Checks def and the scene and fills in everything but kind, geometry and items. */
ty_result ty_path_prepare(const ty_scene* scene, const ty_path_def* def, ty_path_run* run);

/* Finds the lights that guide, and takes memory for item_count items and, if asked, for their parts. */
ty_result ty_path_run_begin(ty_path_run* run, const ty_scene* scene, bool with_parts);
void ty_path_run_end(ty_path_run* run);

/* Samples all items in passes until def's bounds are met. TY_OK or TY_CANCELLED, and items are valid either way;
 * TY_ERROR_MEMORY before any work. */
ty_result ty_path_sample(ty_path_run* run);

/* The mean of an item's samples, and the variance of that mean (0 from fewer than two samples). */
double ty_path_item_mean(const ty_path_item* item, int channel);
double ty_path_item_variance(const ty_path_item* item, int channel);

#endif
