/* Sampling receivers: what surfaces and probes share. */
#ifndef TY_BAKE_GATHER_H
#define TY_BAKE_GATHER_H

#include "bake/kernel.h"
#include "method/path/driver.h"

typedef struct ty_bake_run {
    ty_context* context;
    const ty_bake_def* def;
    ty_path_run path;      /* the scene as surfaces alone see it, lights and all; then with its media */
    ty_medium_view* media; /* those with any matter; media_size of them */
    size_t media_size;
    ty_impulse* tables;   /* made here; NULL: the caller's */
    ty_bake_cache* cache; /* the same */
    ty_senders senders;   /* sender_size of them at most */
    size_t sender_size;
    ty_impulse_sum* merged; /* rows of request.merged */
    size_t merged_size;
    ty_bake_request request;
    ty_bake_kernel kernel;
    int64_t count;
    ty_bake_sums* sums;
    double* light; /* per receiver layers x 3 x request.terms */
    ty_bake_stats stats;
} ty_bake_run;

ty_result ty_bake_check(ty_context* context, const ty_bake_def* def);
/* Checks def and looks at the scene: what comes before a cache. Whatever it returns, ty_bake_run_end is to follow. */
ty_result ty_bake_run_prepare(ty_bake_run* run, const ty_scene* scene, const ty_bake_def* def);
/* Whether a medium does the same to all channels. */
bool ty_bake_is_gray(const ty_medium_view* medium);
/* The light in the media of a prepared run. */
ty_result ty_bake_cache_make(const ty_bake_run* run, const ty_scene* scene, ty_bake_cache** out);
/* Once all cells are filled: which of them see each other, and what is known where nothing was found. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_cache_part(ty_bake_cache* cache, const ty_accel* mesh);
/* Checks def and receivers and takes memory. Whatever it returns, ty_bake_run_end is to follow. */
ty_result ty_bake_run_begin(ty_bake_run* run, const ty_scene* scene, const ty_bake_def* def,
                            const ty_bake_receiver* receivers, int64_t count, int32_t terms);
/* Samples all receivers until they are done. TY_OK or TY_CANCELLED; sums and light are valid either way. */
ty_result ty_bake_sample(ty_bake_run* run);
void ty_bake_run_end(ty_bake_run* run);

/* Finds what sends light into media. ty_bake_senders_free is to follow, whatever it returns. */
ty_result ty_bake_senders_make(ty_bake_run* run);
void ty_bake_senders_free(ty_bake_run* run);

/* The mean of a receiver's samples. */
double ty_bake_mean(const ty_bake_run* run, int64_t receiver, int layer, int channel, int term);
/* Of that, all layers' first term; 0 from fewer than two. */
double ty_bake_variance(const ty_bake_sums* sums, int channel);

#endif
