/* The result of a solve, and the state of one call. */
#ifndef TY_METHOD_FLD_JOB_H
#define TY_METHOD_FLD_JOB_H

#include "direct/single/single.k.h"
#include "direct/uncollided/uncollided.h"
#include "solve/diffusion/light/diffuse_light.h"
#include "method/diffuse/interreflection.h"
#include "method/volume_method.h"

#include <tyndall/fld.h>

/* Lights with dedicated fields, which keep their exact phase function, besides one aggregate field of all others. */
enum { TY_FLD_DEDICATED_FIELDS_MAX = 8 };

struct ty_fld {
    ty_context* context;
    bool reduced;           /* uncollided light is TY_FLD_BEAM_REDUCED */
    ty_grid_box direct_box; /* cells of direct light */
    ty_light_field*
        beam[TY_FLD_DEDICATED_FIELDS_MAX + 1]; /* the last is the aggregate field of many sources, with flux */
    ty_light_fluence lights[TY_FLD_DEDICATED_FIELDS_MAX + 1];
    int32_t light_count;
    ty_diffuse_light* diffuse;
    ty_irradiance_cache* cache; /* of surfaces outside of the box; NULL: none */
};

typedef struct ty_fld_job {
    ty_context* context;
    const ty_scene* scene;
    const ty_fld_def* def;
    ty_part_progress progress;
    ty_grid_medium* fine;   /* cells of direct light */
    ty_grid_medium* coarse; /* cells of diffusion */
    ty_discrete_light_set sources;
    float* source[3];             /* q and j on coarse cells, W m^-3 */
    ty_diffuse_surfaces surfaces; /* between coarse cells */
    ty_incident_flux incident;    /* from surfaces outside of them, of lamps */
    ty_fld* light;
    ty_fld_stats stats;
} ty_fld_job;

extern const ty_option_table ty_fld_options;
extern const ty_volume_method ty_volume_fld;

/* The cells of direct light, and the number of those of diffusion. */
ty_result ty_fld_choose_cells(const ty_scene* scene, const ty_fld_def* def, ty_grid_box* direct, int32_t diffusion[3]);
/* Samples the media on fine and coarse cells. */
ty_result ty_fld_sample_media(ty_fld_job* job);
/* Computes the uncollided light of all sources on fine cells, and its scattering source on coarse cells. */
ty_result ty_fld_direct_light(ty_fld_job* job);
/* Computes the scattering source on a medium's cells, W m^-3; the arrays are freed by the caller, also after an error.
 */
ty_result ty_fld_find_sources(ty_fld_job* job, const ty_grid_medium* medium, float* source[3]);
/* Lights surfaces outside of the box by the lamps. */
ty_result ty_fld_light_outside(ty_fld_job* job);
/* Lights them by the media, and the media by them. */
ty_result ty_fld_interreflect(ty_fld_job* job);
/* The lights of a march, and how it reads the fields. */
void ty_fld_set_march(const ty_fld* light, ty_march_def* march);
/* Settings of the diffusion solver. */
ty_diffusion_def ty_fld_diffusion_def(const ty_fld_job* job);
/* Adds to the derivatives of a loss by a factor of each light, without surfaces, what they have by way of the bound of
 * the flux, the solver's `streaming`. */
void ty_fld_return_flux_fraction(const ty_fld_job* job, double by_fraction, double (*lights)[3]);
/* Solves the diffuse light of all channels. */
ty_result ty_fld_diffuse(ty_fld_job* job);
/* Refines it on finer cells where its own are coarse. */
ty_result ty_fld_refine(ty_fld_job* job);

#endif
