/* Cells, boundary faces and the solve of each channel by discrete ordinates. */
#ifndef TY_METHOD_DOM_SOLVE_SOLVE_H
#define TY_METHOD_DOM_SOLVE_SOLVE_H

#include "method/dom/job.h"

/* Directions, fine and coarse cells with their media, and the number of Legendre bands. */
ty_result ty_dom_sample_media(ty_dom_job* job);
/* Cells, directions and bands of a channel's solve, without the media's cells, for plans of memory: `resolution` auto
 * counts as its largest number of cells, and fits of narrow phase functions may take more bands. out->set is `set`. */
ty_result ty_dom_plan(const ty_scene* scene, const ty_dom_def* def, ty_angular_quadrature* set, ty_ordinates_def* out);
/* Minimum number of Legendre bands for a fit. */
enum { TY_DOM_MIN_FITTED_BANDS = 4 };

/* Fits the Henyey-Greenstein function of mean cosine g by `bands` Legendre orders, at least TY_DOM_MIN_FITTED_BANDS. */
void ty_dom_fit_phase(double g, int32_t bands, ty_forward_fit* out);

/* The moments of all channels. */
ty_result ty_dom_solve_channels(ty_dom_job* job);

/* ---- surfaces ---- */

/* Boundary faces between coarse cells, and the number of bands that they need. */
ty_result ty_dom_find_boundary(ty_dom_job* job);
void ty_dom_free_boundary(ty_dom_job* job);
/* True where boundary faces, and surfaces outside of the box, reflect all channels alike and boundary faces emit
 * nothing. */
bool ty_dom_boundary_is_gray(const ty_dom_job* job);
/* True where a surface reaches out of the box. */
bool ty_dom_has_outer_surfaces(const ty_dom_job* job);
/* True where all of the scene's surfaces are gray. */
bool ty_dom_surfaces_are_gray(const ty_dom_job* job);
/* Makes the cache of surfaces outside of the box, if there are any, lights it by the lamps, and fills
 * job->incident_radiance with what it reflects. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_find_incident_radiance(ty_dom_job* job);
/* Radiance of a channel as in job->incident_radiance; NULL: none. */
ty_boundary_radiance ty_dom_boundary_radiance(const ty_dom_job* job, const float* radiance);
/* Floats of a channel there. */
size_t ty_dom_incident_floats(const ty_dom_job* job);
/* The same of the media's light alone, which the cache's points reflect, into out. Errors: TY_ERROR_MEMORY. */
ty_result ty_dom_find_returned_radiance(const ty_dom_job* job, float* out[3]);
/* Lights surfaces outside of the box by the media, and the media by what these return. */
ty_result ty_dom_interreflect(ty_dom_job* job);
/* True for points within half a cell of the box, whose surfaces are boundary faces. */
bool ty_dom_is_within_boundary(const ty_dom_job* job, ty_vec point);
/* The radiance of boundary faces lit by uncollided light; removes the source q_lm of unlit cells. */
ty_result ty_dom_light_boundary(ty_dom_job* job);
bool ty_dom_boundary_is_dark(const ty_dom_job* job, int32_t channel);

/* Power balance, W, of light from surfaces until its first collision; light that scatters is not part of it. */
typedef struct ty_dom_boundary_power {
    double emitted, absorbed, by_walls, leaving, sweep_seconds;
    int32_t sweeps;
    bool converged;
} ty_dom_boundary_power;

/* Solves for a channel's light from surfaces without scattering, and adds its first-collision source to q_lm. def: the
 * definition of the solve with scattering. Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_dom_solve_boundary_light(ty_dom_job* job, int32_t channel, const ty_ordinates_def* def,
                                      ty_dom_boundary_power* power);
/* Lets boundary faces reflect collided light. *none: one zero per side, which the caller frees after the solve. */
ty_result ty_dom_set_reflection(ty_dom_job* job, int32_t channel, ty_ordinates_def* def, float** none);

#endif
