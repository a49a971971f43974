/* Delta-Eddington source of a beam: the light that scatters out of its forward lobe, with the flux that it keeps.
 * A diffusion source of (1 - g) sigma_s R puts forward-scattered light, R - U (direct/single/forward.k.h), on a line:
 * its second moment is R - U instead of S - U, and none of it leaves a narrow medium by its sides. Delta-Eddington with
 * f = g^2 (Joseph, Wiscombe, Weinman 1976) is exact up to second moments: only S lies on a line, and the diffusion has
 * the sources q_0 = (1 - g^2) sigma_s S and q_1 = g (1 - g) sigma_s S along the beam. These make a flux
 * E* = q_1 / (sigma_t - g sigma_s) in addition to that of the gradient.
 * In thin cells E* exceeds the emission, since light builds this flux up over a distance. E is therefore bounded by
 * the flux from upstream plus the cell's own emission, and by a fraction of E*: q_0 - div E is nowhere negative, and
 * all of q_0 is emitted somewhere. The diffusion's light is then everything but S; the overlap with the lobes, R - S
 * as both fluence and flux, is subtracted. */
#ifndef TY_METHOD_POP_DELTA_SOURCE_H
#define TY_METHOD_POP_DELTA_SOURCE_H

#include "direct/media/grid_medium.h"
#include "direct/single/single.k.h"
#include "solve/diffusion/light/diffuse_light.h"

/* Arrays on merged cells: emission, W m^-3; corrections of the diffusion's fluence and of its flux along x, y and z,
 * W m^-2. */
enum { TY_POP_DELTA_SOURCE_ARRAYS = 5 };

typedef struct ty_pop_delta_source {
    size_t cells;
    float* arrays[3][TY_POP_DELTA_SOURCE_ARRAYS]; /* per channel */
} ty_pop_delta_source;

/* Allocates zeros. ty_pop_delta_source_destroy is valid after success and failure. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_delta_source_create(ty_context* context, size_t cells, ty_pop_delta_source* out);
void ty_pop_delta_source_destroy(ty_context* context, ty_pop_delta_source* delta_source);

/* Adds a beam with lobes of order L = 1, given by fluences on cells of `fine`. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_delta_source_add_light(const ty_grid_medium* fine, const ty_light_fluence* light,
                                        const ty_grid_medium* merged, ty_pop_delta_source* out);
/* Adds the fluence and flux corrections to the solved light. */
void ty_pop_delta_source_add_fluence(const ty_pop_delta_source* delta_source, ty_diffuse_light* light);

#endif
