/* What scattering turns aside of light that otherwise keeps its direction: the source of diffusion. */
#ifndef TY_DIRECT_UNCOLLIDED_FIRST_COLLISION_SOURCE_H
#define TY_DIRECT_UNCOLLIDED_FIRST_COLLISION_SOURCE_H

#include "direct/media/grid_medium.h"
#include "direct/single/single.k.h"

/* The extinction of a beam's fluence: order 0: sigma_t (U of forward.k.h), 1: sigma_t - g sigma_s (R, the reduced
 * beam), 2: sigma_t - g^2 sigma_s (S); negative g counts as 0. planes: as many as the medium has, of its cells. */
void ty_scaled_extinction(const ty_grid_medium* medium, int32_t order, float* const planes[3]);

/* How much of a beam's fluence turns aside, 1/m: (1 - g) sigma_s, negative g as 0. */
static inline float ty_reduced_scattering(float scattering, float g) {
    return scattering * (1.0f - ty_maxf(g, 0.0f));
}

/* A channel's q, W m^-3: all lights' fluence (R) times that, or, if not reduced, times sigma_s. */
void ty_first_collision_source(const ty_grid_medium* medium, const ty_light_fluence* lights, int32_t count,
                               int32_t channel, bool reduced, float* out);

#endif
