/* Interreflection of media with the surfaces outside of their box, for methods that diffuse light on cells. */
#ifndef TY_METHOD_DIFFUSE_INTERREFLECTION_H
#define TY_METHOD_DIFFUSE_INTERREFLECTION_H

#include "image/march/irradiance_cache.h"
#include "solve/diffusion/light/diffuse_light.h"

/* Fraction of the light that media emit or scatter for the first time below which what surfaces return is neglected. */
#define TY_INTERREFLECTION_MIN 2e-2

/* The whole of the series 1 + r + r^2 + ... of which `more` follows `light`, over its second term. */
double ty_interreflection_series(const ty_irradiance_cache* cache);

/* Light that enters a box of so many cells. Errors: TY_ERROR_MEMORY. Freed with ty_incident_flux_free, also after an
 * error. */
ty_result ty_incident_flux_make(const ty_irradiance_cache* cache, ty_context* context, ty_reflected_light light,
                                const int32_t size[3], ty_incident_flux* out);
void ty_incident_flux_free(ty_context* context, const int32_t size[3], ty_incident_flux* flux);

typedef struct ty_interreflection_def {
    const ty_scene* scene;
    const ty_grid_medium* medium; /* on the light's cells; where these are others, media receive nothing */
    ty_diffusion_def solver; /* as of ty_diffuse_light_solve_between, with `reduced` and `surfaces`; media receive light
                                through Marshak boundaries alone */
    bool reduced;
    ty_diffuse_surfaces* surfaces; /* which the light was solved between */
    ty_march_def march;            /* lights and options of the march */
    float* const* added;           /* isotropic radiance per channel besides the light's; NULL: none */
    double emitted;                /* power that media emit or scatter for the first time, sum of the channels, W */
    ty_part_progress* progress;
} ty_interreflection_def;

/* Lights a cache by the media, and adds to their diffuse light what surfaces return of it. *returned: of that, power in
 * and out. Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_interreflect(const ty_interreflection_def* def, ty_irradiance_cache* cache, ty_diffuse_light* light,
                          ty_diffuse_stats* returned);

#endif
