/* Sampling of receivers: state shared by surfaces and probes. */
#ifndef TY_BAKE_GATHER_RUN_H
#define TY_BAKE_GATHER_RUN_H

#include "bake/gather/request.h"
#include "method/path/driver.h"
#include "method/path/enclosed_light.h"

/* Impulse responses in a run, which owns their memory. */
typedef struct ty_bake_impulse_run {
    ty_impulse* tables;           /* created by the run; NULL: the caller's */
    ty_virtual_emitters emitters; /* emitter_capacity of them allocated */
    size_t emitter_capacity;
    ty_impulse_sum* merged; /* rows of ty_bake_impulse.merged */
    size_t merged_size;
} ty_bake_impulse_run;

typedef struct ty_bake_run {
    ty_context* context;
    const ty_bake_def* def; /* = &known */
    ty_bake_def known;      /* copy of the caller's def in the library's own size */
    ty_path_run path;       /* the scene without media, including its lights; then with its media */
    ty_medium_view* media;  /* media of non-zero density; media_size of them allocated */
    size_t media_size;
    ty_enclosed* enclosed; /* light in media inside dielectrics, where no cache holds it; NULL: none */
    ty_bake_cache* cache;  /* created by the run; NULL: the caller's */
    ty_bake_impulse_run impulse;
    ty_bake_request request;
    ty_bake_kernel kernel;
    int64_t count;
    ty_bake_sums* sums;
    double* light; /* per receiver layers x 3 x request.terms */
    ty_bake_stats stats;
} ty_bake_run;

/* Copies a caller's def to own, in the library's own size, and checks it. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_bake_take_def(ty_context* context, const ty_bake_def* def, ty_bake_def* own);
/* Checks def and prepares the scene, as needed for a cache. Call ty_bake_run_end whatever it returns. */
ty_result ty_bake_run_prepare(ty_bake_run* run, const ty_scene* scene, const ty_bake_def* def);
/* Solves media inside dielectrics, where the method scatters light; *out is NULL without any. */
ty_result ty_bake_solve_enclosed(const ty_bake_run* run, const ty_scene* scene, ty_enclosed** out);
/* Checks def and receivers and allocates memory. Call ty_bake_run_end whatever it returns. */
ty_result ty_bake_run_begin(ty_bake_run* run, const ty_scene* scene, const ty_bake_def* def,
                            const ty_bake_receiver* receivers, int64_t count, int32_t terms);
/* Samples all receivers until they are done. After TY_OK and TY_CANCELLED sums and light are valid. Other errors are
 * those of ty_context_device and ty_scene_pack. */
ty_result ty_bake_sample(ty_bake_run* run);
void ty_bake_run_end(ty_bake_run* run);

/* Mean of a receiver's samples. */
double ty_bake_mean(const ty_bake_run* run, int64_t receiver, int layer, int channel, int term);
/* Variance of that mean, for the first term summed over layers; 0 with fewer than two samples. */
double ty_bake_variance(const ty_bake_sums* sums, int channel);

#endif
