/* Diffuse light of one channel between surfaces. */
#ifndef TY_SOLVE_DIFFUSION_LIGHT_SURFACE_LIGHT_H
#define TY_SOLVE_DIFFUSION_LIGHT_SURFACE_LIGHT_H

#include "solve/diffusion/light/diffuse_light.h"

/* Diffuse radiance (phi + 3 E . omega) / (4 pi), Eq. 7 (Koerner 2014), from fluence and face fluxes, in place: a cell
 * has the mean flux of its two faces along each axis. surfaces, side_flux: the flux of closed faces; NULL: none. */
void ty_diffuse_terms_make(const int32_t size[3], float* const terms[TY_FIELD_TERMS], const ty_boundary_faces* faces,
                           const float* side_flux);

/* Solves for light that surfaces send into media, until its first collision, and for collided light, into
 * light->terms and light->surface_terms of a channel. def: of collided light, with its source and all else but
 * surfaces. unscattered: extinction of light that does not scatter at all; NULL: def->extinction. incident: the light
 * of def's boundaries, which is carried with that of surfaces; NULL: none. *stats: of both solves together. Errors:
 * TY_ERROR_MEMORY, TY_CANCELLED. */
ty_result ty_surface_light_solve(const ty_diffusion_def* def, const float* unscattered,
                                 const ty_diffuse_surfaces* surfaces, const ty_incident_flux* incident, int32_t channel,
                                 ty_diffuse_light* light, ty_diffusion_stats* stats);

#endif
