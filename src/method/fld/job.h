/* What a solve leaves behind, and one call on its way through the parts of the method. */
#ifndef TY_METHOD_FLD_JOB_H
#define TY_METHOD_FLD_JOB_H

#include "direct/single.k.h"
#include "direct/uncollided.h"
#include "image/field.h"

#include <tyndall/fld.h>

/* Lights that keep a field of their own, so that their phase function stays sharp, beside all others together. */
enum { TY_FLD_OWN_MAX = 8 };

struct ty_fld {
    ty_context* context;
    bool reduced;                             /* beams are TY_FLD_BEAM_REDUCED */
    ty_grid_box direct_box, box;              /* the same box, in cells of direct light and of diffusion */
    ty_light_field* beam[TY_FLD_OWN_MAX + 1]; /* the last is of many sources, with flux */
    ty_single_light lights[TY_FLD_OWN_MAX + 1];
    int32_t light_count;
    size_t cells;                    /* of diffusion */
    bool even;                       /* whether media scatter alike in all directions */
    float* terms[3][TY_FIELD_TERMS]; /* of diffuse light, as in ty_source_field; ty_fld_term_size each */
    bool shared;                     /* whether all channels are the first one's, times color */
    float color[3];
};

/* A part of the caller's progress. */
typedef struct ty_fld_progress {
    ty_progress_fn function; /* the caller's; may be NULL */
    void* user;
    double begun;       /* s */
    double reported;    /* s: when the caller was last told */
    double from, share; /* of the whole work */
} ty_fld_progress;

typedef struct ty_fld_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_fld_def* def;
    ty_fld_progress progress;
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

/* Takes the caller's progress over for the next part of the work, up to the fraction `until`, and tells the caller.
 * Errors: TY_CANCELLED. */
ty_result ty_fld_next_part(ty_fld_job* job, const char* stage, double until);
/* Tells the caller where this part begins, unless it was told of anything just now. Errors: TY_CANCELLED. */
ty_result ty_fld_show_progress(ty_fld_job* job, const char* stage);
/* A ty_progress_fn whose user is a ty_fld_progress. */
bool ty_fld_report(void* user, const ty_progress* progress);

/* Fine and coarse cells, and the media on them. */
ty_result ty_fld_sample_media(ty_fld_job* job);
/* Uncollided light of all sources on fine cells, and what of it scatters, on coarse ones. */
ty_result ty_fld_light_directly(ty_fld_job* job);
/* A channel's fluence of a light, without its factor. */
const float* ty_fld_beam_plane(const ty_single_light* light, int channel, float* factor);
/* Floats of a term's array: room for the faces along its axis, where its flux comes from. */
size_t ty_fld_term_size(const ty_fld* light, int term);
/* The diffuse light of all channels. */
ty_result ty_fld_diffuse(ty_fld_job* job);

#endif
