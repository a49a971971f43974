/* The first-collision source of diffusion: uncollided light after its first scattering out of the forward direction. */
#ifndef TY_DIRECT_UNCOLLIDED_FIRST_COLLISION_SOURCE_H
#define TY_DIRECT_UNCOLLIDED_FIRST_COLLISION_SOURCE_H

#include "direct/media/grid_medium.h"
#include "direct/single/single.k.h"

/* Scaled extinction of a beam's fluence (forward.k.h): order 0 is sigma_t (U), 1 is sigma_t - g sigma_s (R, the reduced
 * beam), 2 is sigma_t - g^2 sigma_s (S); negative g counts as 0. planes: as many as the medium has, of its cells. */
void ty_scaled_extinction(const ty_grid_medium* medium, int32_t order, float* const planes[3]);

/* Reduced scattering coefficient sigma_s' = (1 - g) sigma_s, 1/m; negative g counts as 0. */
static inline float ty_reduced_scattering(float scattering, float g) {
    return scattering * (1.0f - ty_maxf(g, 0.0f));
}

/* A channel's source q, W m^-3: sigma_s' (reduced) or sigma_s times the sum of all lights' fluence. */
void ty_first_collision_source(const ty_grid_medium* medium, const ty_light_fluence* lights, int32_t count,
                               int32_t channel, bool reduced, float* out);

#endif
