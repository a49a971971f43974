/* Means over a cell of the light of a point, from the optical depth at its center. */
#ifndef TY_DIRECT_UNCOLLIDED_POINT_LIGHT_K_H
#define TY_DIRECT_UNCOLLIDED_POINT_LIGHT_K_H

#include "direct/media/attenuation.k.h"
#include "scene/lights/light.k.h"

/* The derivative of the mean attenuation m by x, (e^-x - m) / x, and its series where that loses digits. */
TY_FN float ty_mean_attenuation_slope(float x, float attenuation, float mean) {
    const float series = -0.5f + x * (1.0f / 3.0f - x * (0.125f - x * (1.0f / 30.0f)));
    return x < 0.1f ? series : (attenuation - mean) / ty_maxf(x, 0.1f);
}

/* The optical depth around a cell's center along the axes u, v and w. */
typedef struct ty_cell_depth {
    float depth;      /* at the center */
    float extinction; /* of the cell, 1/m */
    float slope[3];   /* gradient of the depth over the extinction */
} ty_cell_depth;

/* Mean transmittance of a cell with sides cell[3]; exact where the depth is linear. */
TY_FN float ty_cell_mean_transmittance(const ty_cell_depth* d, const float cell[3]) {
    float max_exponent = -d->depth, mean = 1.0f; /* exponent at the brightest corner, and the mean relative to it */
    for (int32_t a = 0; a < 3; ++a) {
        const float across = d->extinction * fabsf(d->slope[a]) * cell[a];
        max_exponent += 0.5f * across;
        mean *= ty_mean_attenuation(across, ty_attenuation(across));
    }
    const float brightest = max_exponent > 0.0f ? ty_expf(max_exponent) : ty_attenuation(-max_exponent);
    return ty_minf(1.0f, brightest * mean);
}

/* Mean of 1 / r^2 and the transmittance's change over a cell, relative to the center, to second order in the cell's
 * size over r. omega: unit, from the light. */
TY_FN float ty_cell_falloff_ratio(const ty_cell_depth* d, const float omega[3], float per_distance,
                                  const float cell[3]) {
    float ratio = 1.0f;
    for (int32_t a = 0; a < 3; ++a) {
        const float square = omega[a] * omega[a];
        const float curvature = d->extinction * (4.0f * omega[a] * d->slope[a] - (1.0f - square));
        ratio +=
            cell[a] * cell[a] * (1.0f / 24.0f) * per_distance * ((8.0f * square - 2.0f) * per_distance + curvature);
    }
    return ratio;
}

/* Largest mean falloff over that at the center, for long cells. */
#define TY_MAX_FALLOFF_RATIO 4.0f

/* Mean of transmittance / r^2 over a cell, relative to 1 / r^2 at its center. */
TY_FN float ty_cell_mean_falloff(const ty_cell_depth* d, const float omega[3], float per_distance,
                                 const float cell[3]) {
    return ty_cell_mean_transmittance(d, cell) *
           ty_clampf(ty_cell_falloff_ratio(d, omega, per_distance, cell), 0.0f, TY_MAX_FALLOFF_RATIO);
}

#endif
