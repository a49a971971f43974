/* Diffuse light of media on cells: one diffusion solve per channel, and the resulting radiance field. */
#ifndef TY_SOLVE_DIFFUSION_LIGHT_DIFFUSE_LIGHT_H
#define TY_SOLVE_DIFFUSION_LIGHT_DIFFUSE_LIGHT_H

#include "base/progress.h"
#include "direct/single/source_field.h"
#include "solve/diffusion/diffusion.h"
#include "solve/diffusion/light/diffuse_surfaces.h"

typedef struct ty_diffuse_light {
    ty_context* context;
    ty_grid_box box;
    size_t cells;
    bool isotropic;                  /* isotropic phase function everywhere */
    float* terms[3][TY_FIELD_TERMS]; /* as in ty_source_field */
    bool shared;                     /* all channels are the first one's, times color */
    float color[3];
    ty_boundary_faces* faces;                /* surfaces between the cells, owned; NULL: none */
    float* surface_terms[3][TY_FIELD_TERMS]; /* with them: light that reaches surfaces and is no unscattered light of
                                                surfaces */
} ty_diffuse_light;

/* Per channel. */
typedef struct ty_diffuse_stats {
    bool converged; /* all channels */
    int32_t iterations[3], cycles[3];
    double residual[3], work[3], emitted[3], absorbed[3], leaving[3]; /* as in ty_diffusion_stats */
    double surfaces_absorbed[3]; /* emitted: includes what surfaces send besides their reflection */
    double bytes;                /* memory of the solver, for all channels that are solved concurrently; on each rank */
    int32_t ranks;               /* that solved together */
} ty_diffuse_stats;

/* Light that enters the box: irradiance of each side's face cells, W m^-2, laid out as ty_boundary.value. */
typedef struct ty_incident_flux {
    float* sides[6][3]; /* of each channel */
    bool scattered;     /* media have scattered it: pictures of surfaces do not have it yet */
} ty_incident_flux;

/* Diffuse light of a source (per channel, W m^-3; the media's emission is added to it) in a medium on the same cells.
 * solver: limiter, boundaries, solver and bounds; its cells, coefficients, sources, progress and memory are ignored.
 * reduced: use the reduced extinction sigma_t - g sigma_s; false treats media as isotropic. stats is required. Errors:
 * TY_ERROR_ARGUMENT, TY_ERROR_MEMORY; TY_CANCELLED.
 * surfaces: their faces become the light's; they send their radiosity into the media, and reflect and absorb diffuse
 * light. incident: light that enters through Marshak boundaries; NULL: none. */
ty_result ty_diffuse_light_solve_between(const ty_diffusion_def* solver, bool reduced, const ty_grid_medium* medium,
                                         ty_diffuse_surfaces* surfaces, float* const source[3],
                                         const ty_incident_flux* incident, ty_part_progress* progress,
                                         ty_diffuse_light** out, ty_diffuse_stats* stats);
/* The same without surfaces, with the light on other cells of the same box as the initial guess; start and incident may
 * be NULL. */
ty_result ty_diffuse_light_refine(const ty_diffuse_light* start, const ty_diffusion_def* solver, bool reduced,
                                  const ty_grid_medium* medium, float* const source[3],
                                  const ty_incident_flux* incident, ty_part_progress* progress, ty_diffuse_light** out,
                                  ty_diffuse_stats* stats);
/* Adds factor times the light of the same cells and faces. */
void ty_diffuse_light_add(ty_diffuse_light* light, const ty_diffuse_light* other, float factor);
/* Fluence of a channel, W m^-2, on finer cells of the box: linear between cell centers. */
void ty_diffuse_light_prolong(const ty_diffuse_light* light, int32_t channel, const int32_t size[3], float* fluence);
void ty_diffuse_light_destroy(ty_diffuse_light* light);

/* View of the light as a field; arrays remain the light's. directed: include the P1 terms even in isotropic media (for
 * surfaces). */
ty_source_field ty_diffuse_light_field(const ty_diffuse_light* light, bool directed);
/* The light that surfaces receive, of a light with faces. */
ty_source_field ty_diffuse_light_surface_field(const ty_diffuse_light* light);

#endif
