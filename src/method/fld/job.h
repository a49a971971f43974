/* What a solve leaves behind, and one call on its way through the parts of the method. */
#ifndef TY_METHOD_FLD_JOB_H
#define TY_METHOD_FLD_JOB_H

#include "direct/single.k.h"
#include "direct/uncollided.h"
#include "image/options.h"
#include "solve/diffusion/diffuse_light.h"

#include <tyndall/fld.h>

/* Lights that keep a field of their own, so that their phase function stays sharp, beside all others together. */
enum { TY_FLD_OWN_MAX = 8 };

struct ty_fld {
    ty_context* context;
    bool reduced;                             /* beams are TY_FLD_BEAM_REDUCED */
    ty_grid_box direct_box;                   /* cells of direct light */
    ty_light_field* beam[TY_FLD_OWN_MAX + 1]; /* the last is of many sources, with flux */
    ty_single_light lights[TY_FLD_OWN_MAX + 1];
    int32_t light_count;
    ty_diffuse_light* diffuse;
};

typedef struct ty_fld_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_fld_def* def;
    ty_part_progress progress;
    ty_grid_medium* fine;   /* cells of direct light */
    ty_grid_medium* coarse; /* cells of diffusion */
    ty_source* sources;
    int32_t source_count;
    float* source[3]; /* q and j on coarse cells, W m^-3 */
    ty_fld* light;
    ty_fld_stats stats;
} ty_fld_job;

/* Fails with the first field that is out of its range. */
ty_result ty_fld_check(ty_context* context, const ty_fld_def* def);
ty_image_options ty_fld_image_options(const ty_fld_def* def);

/* Fine and coarse cells, and the media on them. */
ty_result ty_fld_sample_media(ty_fld_job* job);
/* Uncollided light of all sources on fine cells, and what of it scatters, on coarse ones. */
ty_result ty_fld_light_directly(ty_fld_job* job);
/* What of it scatters on a medium's cells, W m^-3, to arrays that are the caller's to free, also after an error. */
ty_result ty_fld_find_sources(ty_fld_job* job, const ty_grid_medium* medium, float* source[3]);
/* How diffusion is solved. */
ty_diffusion_def ty_fld_diffusion_def(const ty_fld_job* job);
/* The diffuse light of all channels. */
ty_result ty_fld_diffuse(ty_fld_job* job);
/* The same on finer cells, where its own are coarse. */
ty_result ty_fld_refine(ty_fld_job* job);

#endif
