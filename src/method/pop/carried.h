/* What of a beam's light scatters out of its forward lobe, and how far that is carried before it is diffuse.
 *
 * Diffusion that is given (1 - g) sigma_s R takes what has scattered forwards, R - U (direct/forward.k.h), as a line of
 * light: its second moment is R - U instead of S - U, and none of it leaves a narrow medium by its sides.
 * Delta-Eddington of f = g^2 (Joseph, Wiscombe, Weinman 1976) is exact to second moments: only S is a line, and
 * diffusion has the sources q_0 = (1 - g^2) sigma_s S and q_1 = g (1 - g) sigma_s S along the beam, which make a flux
 * E* = q_1 / (sigma_t - g sigma_s) beside that of the gradient.
 *
 * As it stands that takes more from thin cells than they emit: light has to come a way before it has the flux. So E is
 * what comes from upstream and what the cell itself emits, up to a part of E*: q_0 - div E is nowhere below 0, and all
 * of q_0 is emitted somewhere. Diffusion's light is then all but S; what the lobes have of it, R - S as both fluence
 * and flux, is taken off again. */
#ifndef TY_METHOD_POP_CARRIED_H
#define TY_METHOD_POP_CARRIED_H

#include "direct/grid_medium.h"
#include "direct/single.k.h"
#include "solve/diffusion/diffuse_light.h"

/* On merged cells: what is emitted, W m^-3; what is to be added to the diffusion's fluence, and to its flux along x, y
 * and z, W m^-2. */
enum { TY_POP_CARRIED = 5 };

typedef struct ty_pop_carried {
    size_t cells;
    float* of[3][TY_POP_CARRIED]; /* per channel */
} ty_pop_carried;

/* Zeros. Whatever becomes of it, ty_pop_carried_destroy may follow. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_carried_create(ty_context* context, size_t cells, ty_pop_carried* out);
void ty_pop_carried_destroy(ty_context* context, ty_pop_carried* carried);

/* Adds a beam with lobes of L = 1, whose fluences are on cells of `fine`. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_carry(const ty_grid_medium* fine, const ty_single_light* light, const ty_grid_medium* merged,
                       ty_pop_carried* out);
/* Adds to the solved light what it is to have besides. */
void ty_pop_carried_add(const ty_pop_carried* carried, ty_diffuse_light* light);

#endif
